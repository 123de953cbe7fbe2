"""When the panels whose geometry takes time follow the picture."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from lensbench.app.window.panels import PATIENCE, Followed
from tests.app.conftest import SMALL

OTHER = replace(SMALL, lens="pbrt-fisheye-10mm")


@pytest.mark.parametrize(("on_screen", "waiting", "follows"), [
    (False, 0.0, False),                # the picture is there, and not yet shown
    (False, 0.5 * PATIENCE, False), (True, 0.0, True), (False, 1.1 * PATIENCE, True)])
def test_panels_of_another_lens_wait_for_its_picture_but_not_for_ever(on_screen, waiting, follows):
    worker = SimpleNamespace(on_screen=on_screen, waiting=waiting)
    assert Followed(SMALL).now(OTHER, worker) == (OTHER if follows else SMALL)


def test_panels_follow_a_dial_at_once_and_a_lens_that_stays():
    worker = SimpleNamespace(on_screen=False, waiting=0.1)
    followed, focused = Followed(SMALL), replace(SMALL, focus_distance=900.0)
    assert followed.now(focused, worker) == focused
    worker.waiting = PATIENCE + 1.0
    assert followed.now(OTHER, worker) == OTHER
    worker.waiting = 0.0
    assert followed.now(replace(OTHER, f_number=8.0), worker).f_number == 8.0
