"""The first minutes: pictures to try, and what the terms mean."""

from dataclasses import replace

import pytest
from imgui_bundle import ImVec2, imgui

from lensbench.app.bench.lens_choice import TRIALS
from lensbench.app.drawing.controls import chord
from tests.app.conftest import SMALL


@pytest.mark.slow
@pytest.mark.parametrize("size", [(640, 400), (1280, 720)])
def test_a_picture_is_tried_and_undone_and_the_offer_dismissed(drive, size):
    def use(hand):
        view, trial = hand.session.view, TRIALS[2]
        hand.picture()
        assert not hand.ctx.item_exists(f"**/{trial.title}")        # a later session
        before, view.offers_trials = hand.settings, True
        hand.ctx.yield_(3)
        box = hand.box("**/###No trials")
        assert box.max.x <= size[0] and box.max.y <= size[1]
        if size[0] < 1000:                                          # no room beside the lens browser
            hand.press(imgui.Key.l)
            hand.ctx.yield_(8)
            assert not hand.ctx.item_exists(f"**/{TRIALS[1].title}")
            hand.press(imgui.Key.escape)
            hand.ctx.yield_(8)
        hand.ctx.item_click(f"**/{trial.title}")
        hand.ctx.yield_(4)
        assert (hand.settings.lens, hand.settings.scene, hand.settings.blades) == (trial.lens, trial.scene, 6)
        assert view.messages == [trial.about]
        hand.press(chord(imgui.Key.mod_ctrl, imgui.Key.z))
        assert hand.settings == before
        hand.ctx.yield_(2)
        assert view.messages == []                                  # what was said of the lens goes with it
        hand.ctx.item_click("**/###No trials")
        hand.ctx.yield_(2)
        assert not view.offers_trials

    drive(use, replace(SMALL, samples=1), size=size)


@pytest.mark.slow
@pytest.mark.parametrize("change", [{"lens": TRIALS[1].lens}, {"view": "fate"}, {"overlay": "coc"}])
def test_the_offer_leaves_the_notes_at_the_lower_edge_in_sight(drive, change):
    """It lay over them, such as over the note on the image circle of the fisheye that it had offered itself."""
    def use(hand):
        view = hand.session.view
        hand.picture()
        view.offers_trials = view.histogram = True
        hand.session.take(replace(hand.settings, f_number=None, **change))
        hand.picture()
        child = hand.ctx.window_info("//Render/Trials").window
        upper, lower = child.pos, ImVec2(child.pos.x + child.size.x, child.pos.y + child.size.y)
        assert len(view.plates) >= 2                                # and the histogram
        for left, top, right, bottom in view.plates:
            assert right <= upper.x or lower.x <= left or bottom <= upper.y or lower.y <= top
        frame = imgui.internal.find_window_by_name("Render")
        assert frame.pos.y < upper.y and lower.y <= frame.pos.y + frame.size.y

    drive(use, replace(SMALL, samples=1), size=(800, 600))


@pytest.mark.slow
def test_the_question_mark_explains_the_terms(drive):
    def use(hand):
        hand.picture()
        hand.ctx.item_click("**/###Terms")
        hand.ctx.yield_(3)
        window = imgui.internal.find_window_by_name("What the terms mean")
        assert window.active and window.pos.y >= 0.0 and window.pos.y + window.size.y <= 400.0
        hand.ctx.key_chars("coc")
        hand.ctx.yield_(3)
        assert imgui.is_popup_open("", imgui.PopupFlags_.any_popup)
        hand.press(imgui.Key.escape)
        hand.ctx.yield_(2)
        assert not window.active
        hand.ctx.menu_click("//##MainMenuBar/Help/What the terms mean")
        hand.ctx.yield_(3)
        assert window.active

    drive(use, replace(SMALL, samples=1), size=(640, 400))
