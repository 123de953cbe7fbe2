"""The presenter shows the image of the newest update, however the memory of older ones is used again."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from lensbench.app.bench.tone import Difference, histogram
from lensbench.app.display.frame import View
from lensbench.app.display.presenter import Presenter
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.light_field_worker import FieldPicture
from lensbench.app.workers.render_job import RenderUpdate
from lensbench.core.optics import finding

SETTINGS = replace(Settings(), pixels_x=6, pixels_y=4, compare="difference")


class Screen:
    """A screen without a graphics card, that remembers what was loaded."""

    size = (6, 4)

    def load(self, image, depth=None):
        self.loaded = image.copy()

    def developed(self, development):
        return 1

    def apart(self, other, scale):
        return 2

    def draw_at(self, scale):
        pass


@pytest.fixture
def presenter():
    made = Presenter(SimpleNamespace(waiting=0.0, paused=False))
    made._screen, made._pinned_screen = Screen(), Screen()
    return made


def assert_shows(presenter, image):
    picture = presenter.picture(SETTINGS, View(histogram=True))
    np.testing.assert_array_equal(presenter._screen.loaded, image)
    np.testing.assert_array_equal(presenter.light, image)
    np.testing.assert_array_equal(picture.histogram, histogram(image, SETTINGS.exposure, SETTINGS.tone, SETTINGS.noise))
    assert picture.difference == Difference.of(presenter.pinned.image, image)


@pytest.mark.parametrize(("generation", "samples"), [(1, 2), (2, 1)])
def test_a_new_image_at_the_address_of_an_old_one_is_shown_and_counted_anew(presenter, generation, samples):
    random = np.random.default_rng(5)
    image = random.random((4, 6, 3), np.float32)
    presenter._keep(RenderUpdate(1, np.zeros((4, 6, 3), np.float32), 1, 0.0, SETTINGS, 0.0))
    presenter.update = RenderUpdate(1, image, 1, 0.0, SETTINGS, 0.0)
    assert_shows(presenter, image)
    image[:] = random.random((4, 6, 3), np.float32)         # the same id
    presenter.update = RenderUpdate(generation, image, samples, 0.0, SETTINGS, 0.0)
    assert_shows(presenter, image)


def test_another_picture_a_at_the_address_of_an_old_one_is_compared_with_anew(presenter):
    image, pinned = (np.full((4, 6, 3), value, np.float32) for value in (0.5, 0.25))
    presenter.update = RenderUpdate(1, image, 1, 0.0, SETTINGS, 0.0)
    for value in (0.25, 1.0):
        pinned[:] = value                                   # the same id
        presenter._keep(RenderUpdate(0, pinned, 1, 0.0, SETTINGS, 0.0))
        assert_shows(presenter, image)


def test_pictures_of_a_light_field_are_told_apart_by_their_number(presenter, monkeypatch):
    monkeypatch.setattr("lensbench.app.display.presenter.picture_settings", lambda recording, look, *_: SETTINGS)
    monkeypatch.setattr("lensbench.app.display.presenter.note", lambda recording, look, depth: "")
    presenter._keep(RenderUpdate(1, np.zeros((4, 6, 3), np.float32), 1, 0.0, SETTINGS, 0.0))
    image = np.empty((4, 6, 3), np.float32)
    recording, look = SimpleNamespace(settings=SETTINGS), SimpleNamespace(coded=False)
    for number in (1, 2):
        image[:] = 0.3 * number                             # the same id
        presenter.field_picture = FieldPicture(recording, look, image, 0.0, 1.0, number)
        assert_shows(presenter, image)


def test_what_a_picture_leaves_out_is_said_once_until_it_no_longer_does(presenter):
    view, image = View(), np.zeros((4, 6, 3), np.float32)

    def take(*findings):
        presenter._say(RenderUpdate(1, image, 1, 0.0, SETTINGS, 0.0, findings=findings), view)
        return view.messages

    def dim(lights):
        return finding.note(finding.Kind.DIM_LIGHTS, f"{lights} lights have none", lights=lights)

    still = finding.note(finding.Kind.NO_GHOSTS, "ghosts are not traced where the camera moves")
    port = finding.note(finding.Kind.NO_GHOSTS, "ghosts are not traced through a port")
    assert take(still) == take(still) == ["Ghosts are not traced where the camera moves"]
    assert take(port) == ["Ghosts are not traced through a port"]
    assert take(dim(2)) == ["2 lights have none"] and take(dim(3)) == ["3 lights have none"]
    view.notices.forget()                                   # dismissed: other figures do not bring it back
    assert take(dim(4)) == [] and take(still) == ["Ghosts are not traced where the camera moves"]
    assert take() == []


@pytest.mark.parametrize(("renderer", "share"), [("llvmpipe (LLVM 15.0.7, 256 bits)", 0.0), ("NVIDIA H200/PCIe", 0.35)])
def test_a_processor_that_draws_leaves_out_the_softening_and_the_window_says_so(presenter, renderer, share):
    presenter.renderer = renderer
    presenter.update = presenter._deep = RenderUpdate(1, np.zeros((4, 6, 3), np.float32), 1, 0.0, SETTINGS, 0.0,
                                                      depth=np.ones((4, 6), np.float32))
    used = []
    presenter._screen.developed = lambda development: used.append(development.share) or 1
    presenter.picture(SETTINGS, View())
    assert used == [share] and renderer in presenter.drawn_by
    assert ("not softened" in presenter.drawn_by) == (share == 0.0)
