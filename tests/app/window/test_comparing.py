"""A beside B: it refines as B does, follows the dials while it is locked, and both are read in two columns."""

import math
from dataclasses import replace

import pytest
from imgui_bundle import imgui

from lensbench.app.drawing.controls import chord
from lensbench.app.panels.readouts import Status, paired_rows
from lensbench.app.settings.settings import Settings
from tests.app.conftest import SMALL

KEY = imgui.Key
ENOUGH = replace(SMALL, samples=48)


@pytest.mark.slow
def test_a_picture_pinned_early_refines_as_the_present_one_does(drive):
    def use(hand):
        presenter = hand.session.presenter
        hand.session.worker.pause()
        hand.wait(lambda: presenter.update is not None and presenter.update.samples >= 1, "the first pass")
        hand.press(KEY.a)
        pinned = presenter.pinned
        assert pinned.samples < 48
        hand.press(KEY.s)
        hand.session.worker.resume()
        hand.session.take(replace(hand.settings, f_number=8.0))
        hand.picture()
        hand.wait(lambda: presenter.pinned.samples == 48, "the samples of A")
        assert presenter.pinned.settings.f_number == ENOUGH.f_number == hand.session.view.pinned.f_number
        assert hand.session.comparing.settled(48)
        hand.press(KEY.d)
        hand.ctx.yield_(2)
        assert presenter.picture(hand.settings, hand.session.view).difference.rms > 0.0

    assert drive(use, ENOUGH).view.messages == []


@pytest.mark.slow
def test_a_locked_to_b_follows_its_dials_and_keeps_its_lens(drive):
    def use(hand):
        view, presenter = hand.session.view, hand.session.presenter
        hand.press(KEY.k)
        assert not view.locked and "as A first" in view.messages[0]
        hand.picture()
        hand.press(KEY.a)
        hand.press(KEY.w)
        hand.session.take(replace(hand.settings, lens="pbrt-wide-22mm", f_number=4.0))
        hand.picture()
        hand.press(KEY.k)
        hand.drag(hand.at("**/Aperture", 0.4, 0.5), hand.at("**/Aperture", 0.7, 0.5))
        hand.picture()
        hand.wait(lambda: hand.session.comparing.settled(48), "A")
        a = presenter.pinned.settings
        assert a == view.pinned and a.lens == ENOUGH.lens and a.f_number == hand.settings.f_number > 4.5
        assert hand.session.panels.kept.section.view is not None
        hand.press(chord(KEY.mod_ctrl, KEY.z))                        # undo turns the dial back, in both
        hand.ctx.yield_(2)
        assert view.pinned.f_number == hand.settings.f_number == 4.0
        hand.ctx.item_click("**/Compare")
        hand.ctx.item_click("//$FOCUSED/Lock A's dials to B")
        hand.ctx.yield_(2)
        assert not view.locked
        hand.press(KEY.escape)
        hand.drag(hand.at("**/Aperture", 0.4, 0.5), hand.at("**/Aperture", 0.7, 0.5))
        assert view.pinned.f_number == 4.0 != hand.settings.f_number

    assert drive(use, ENOUGH).view.messages == []


def test_read_outs_of_a_and_b_stand_side_by_side():
    a, b = Settings(), replace(Settings(), f_number=5.6)
    table = {row.name: row for row in paired_rows(b, Status(), a, Status(samples=7))}
    assert (table["f-number"].a, table["f-number"].b, table["f-number"].apart) == ("f/2.80", "f/5.60", "−2.0 EV")
    assert table["Focal length"].apart == "" and table["Samples"].a == "7"
    near = table["Entrance pupil"]
    apart = float(near.apart.removesuffix(" mm").replace("−", "-"))
    assert math.isclose(apart, float(near.b[2:]) - float(near.a[2:]), abs_tol=0.05 + 1e-9)
    coated = {row.name: row for row in paired_rows(replace(a, coating="multi-layer"), Status(),
                                                   replace(a, coating="uncoated"), Status())}
    assert coated["T-stop"].apart.startswith("+") and "uncoated" in coated["T-stop"].meaning
    without = {row.name: row for row in paired_rows(replace(b, camera="environment"), Status(), a, Status())}
    assert without["Focal length"].a == "50.4" and without["Focal length"].b == "–"
