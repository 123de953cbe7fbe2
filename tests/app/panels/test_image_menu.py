"""The menu of the picture, and a panel that has to fit beside it."""

from dataclasses import replace

import pytest
from imgui_bundle import imgui

from lensbench.app.settings.settings import Settings
from tests.app.conftest import SMALL


@pytest.mark.slow
def test_small_lights_are_left_to_the_cameras_rays_where_a_person_says_so(drive):
    def use(hand):
        hand.picture()
        hand.ctx.item_click("**/Picture size")
        hand.ctx.item_click("**/Light tracing")
        hand.press(imgui.Key.escape)
        hand.picture()
        assert hand.settings == replace(SMALL, light_tracing=False)

    assert drive(use).view.messages == []


@pytest.mark.slow
@pytest.mark.parametrize("size", [(1280, 720), (1920, 1080)])
def test_stars_and_their_strength_are_set_in_the_drawer(drive, tmp_path, size):
    def use(hand):
        hand.picture()
        hand.ctx.item_click("**/###Drawer Flare")
        hand.ctx.item_click("//$FOCUSED/Stars")
        hand.ctx.item_click("//$FOCUSED/Ghosts")
        hand.photograph(tmp_path / "menu.png")
        hand.ctx.item_input_value("**/###stars strength", 20.0)
        hand.press(imgui.Key.escape)
        hand.picture()
        assert hand.settings == replace(SMALL, stars=True, star_strength=20.0, ghosts=True)
        hand.photograph(tmp_path / "stars.png")

    assert drive(use, SMALL, size).view.messages == []


def test_the_choice_is_kept_with_the_settings():
    assert Settings().light_tracing
    assert not Settings.from_dict({"version": 1, "light_tracing": False}).light_tracing


@pytest.mark.slow
def test_every_row_of_the_spaces_is_seen_in_a_small_window(drive):
    def use(hand):
        hand.picture()
        hand.ctx.window_focus("//Spaces")
        hand.ctx.mouse_move_to_pos(hand.at("**/Picture", 0.6, 0.5))
        hand.ctx.yield_(4)
        window = hand.ctx.window_info("//Spaces").window
        assert window.scroll_max.y == 0.0
        assert hand.box("**/Save intrinsics").max.y < window.pos.y + window.size.y

    drive(use)
