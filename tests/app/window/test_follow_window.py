"""The render follows the pixels of the window: full when still, coarse while a slow picture is dragged."""

from dataclasses import replace

import pytest
from imgui_bundle import hello_imgui, imgui

from lensbench.app.bench.constraints import coarser, longer_side_within, with_longer_side
from lensbench.app.drawing.controls import chord
from lensbench.app.settings.settings import Settings
from lensbench.app.window import state
from tests.app.conftest import SMALL


def test_a_picture_fills_its_room_and_is_made_coarse_only_where_that_pays():
    settings = Settings()                               # 3 : 2
    assert longer_side_within(settings, (900.0, 700.0)) == 900
    assert longer_side_within(settings, (900.0, 400.0)) == 600
    large = with_longer_side(settings, 2400)
    assert coarser(large, 1e7) == large and coarser(large, 3.6e6) == large
    coarse = coarser(large, 600.0 * 400.0)
    assert (coarse.pixels_x, coarse.pixels_y) == (600, 400) and replace(coarse, pixels_x=2400, pixels_y=1600) == large
    assert coarser(large, 1.0).pixels_x == 160


@pytest.mark.slow
def test_the_picture_takes_the_pixels_of_the_window_and_a_drag_a_coarse_one(drive, monkeypatch):
    def use(hand):
        view, worker = hand.session.view, hand.session.worker
        view.follows = True
        hand.picture()
        assert max(hand.settings.pixels_x, hand.settings.pixels_y) == longer_side_within(hand.settings, view.room)
        assert view.scale == pytest.approx(1.0, abs=0.02)
        full = hand.settings.pixels_x
        monkeypatch.setattr(state, "DRAG_SECONDS", 1e-3)        # as if this machine were slow
        hand.ctx.mouse_move_to_pos(hand.at("**/Aperture", 0.4, 0.5))
        hand.ctx.mouse_down(0)
        for fraction in (0.45, 0.5, 0.55):
            hand.ctx.mouse_move_to_pos(hand.at("**/Aperture", fraction, 0.5))
            hand.ctx.yield_(3)
        hand.wait(lambda: worker.newest().settings.pixels_x < full, "a coarse picture")
        hand.ctx.yield_(3)
        assert hand.settings.pixels_x == full and view.scale == pytest.approx(1.0, abs=0.02)
        hand.ctx.mouse_up(0)
        hand.picture()
        assert worker.newest().settings == hand.settings
        hello_imgui.change_window_size((900, 600))
        hand.picture()
        assert hand.settings.pixels_x < full
        assert max(hand.settings.pixels_x, hand.settings.pixels_y) == longer_side_within(hand.settings, view.room)
        hand.press(chord(imgui.Key.mod_ctrl, imgui.Key.z))            # takes back the aperture, not the size
        hand.picture()
        assert hand.settings.f_number == SMALL.f_number
        hello_imgui.change_window_size((1280, 720))
        hand.picture()
        hand.ctx.item_click("**/Picture size")
        hand.ctx.item_click("//$FOCUSED/480 × 320")
        hand.ctx.yield_(3)
        assert hand.settings.pixels_x == 480 and not view.follows

    assert drive(use, replace(SMALL, samples=2)).view.messages == []
