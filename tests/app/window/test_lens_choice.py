"""Choosing a lens in the window: at its best, one step of undo, and what the padlocks keep."""

from dataclasses import replace

import pytest
from imgui_bundle import imgui

from lensbench.app.bench.lens_choice import FILM, with_lens
from lensbench.app.drawing.controls import chord
from lensbench.lenses.library import catalogue
from tests.app.conftest import SMALL

UNDO = chord(imgui.Key.mod_ctrl, imgui.Key.z)
REDO = chord(imgui.Key.mod_ctrl, imgui.Key.y)
FILE = str(catalogue.path_of("pbrt-telephoto-250mm"))


@pytest.mark.slow
def test_a_camera_that_something_keeps_near_the_subject_says_so_while_it_stands_there(drive):
    def use(hand):
        hand.picture()
        hand.session.dropped(None, [FILE])
        hand.ctx.yield_(3)
        said = "stands in the way"
        assert not any(said in message for message in hand.session.view.messages)
        hand.ctx.item_click("//Controls/##Scene")
        hand.ctx.item_click("**/Room")
        hand.session.dropped(None, [FILE])
        hand.ctx.yield_(3)
        assert hand.settings == with_lens(replace(SMALL, scene="room", exposure=0.3), FILE)
        assert sum(said in message for message in hand.session.view.messages) == 1
        hand.press(UNDO)
        assert not any(said in message for message in hand.session.view.messages)
        hand.press(REDO)
        assert sum(said in message for message in hand.session.view.messages) == 1

    drive(use)


@pytest.mark.slow
def test_a_dropped_lens_is_at_its_best_but_for_what_a_padlock_keeps(drive, tmp_path):
    def use(hand):
        hand.picture()
        hand.session.dropped(None, [FILE])
        hand.ctx.yield_(3)
        assert hand.settings == with_lens(SMALL, FILE)
        assert hand.settings.f_number is None and hand.settings.position[2] > 1000.0
        hand.press(UNDO)
        assert hand.settings == SMALL               # one entry

        for name in ("film", "aperture", "focus"):
            hand.ctx.item_click(f"**/Lock {name}")
        assert hand.session.chooser.locked == {"film", "aperture", "focus"}
        hand.session.dropped(None, [FILE])
        hand.ctx.yield_(3)
        assert hand.settings == with_lens(SMALL, FILE, {"film", "aperture", "focus"})
        assert hand.settings.position == SMALL.position
        hand.ctx.item_click("**/Lock aperture")
        assert hand.session.chooser.locked == {"film", "focus"}

    assert [text for text in drive(use).view.messages if "telephoto" not in str(text)] == []


def test_a_camera_is_found_by_its_name_and_another_lens_leaves_its_format(drive):
    def use(hand):
        hand.picture()
        hand.ctx.item_click("//Controls/##Film")
        hand.ctx.yield_(2)
        hand.ctx.item_click("//$FOCUSED/##Camera body")
        hand.ctx.key_chars("a7 iv")
        hand.ctx.yield_(3)
        hand.ctx.item_click("**/Sony A7 IV")
        hand.picture()
        body = hand.settings.sensor
        assert body.name == "Sony A7 IV" and (hand.settings.film_width, hand.settings.film_height) == (35.9, 23.9)
        assert hand.settings.pixels_x == SMALL.pixels_x and FILM in hand.session.chooser.locked
        hand.session.browsing.toggle()
        hand.session.browsing.state.tried = "fujifilm-fujinon-xf-r-lm-wr-23-f14"        # of APS-C
        hand.picture()
        assert hand.settings.lens.startswith("fujifilm") and hand.settings.sensor == body
        hand.session.browsing.toggle()
        hand.ctx.item_click("//Controls/##Film")
        hand.ctx.item_click("//##Combo_00/APS-C 23.5 × 15.6")
        hand.picture()
        assert hand.settings.body == "" and hand.settings.film_width == 23.5

    drive(use)
