"""Dials, steps, panels and the screen by the keyboard alone."""

from dataclasses import replace

import pytest
from imgui_bundle import hello_imgui, imgui

from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import chord
from lensbench.app.session.states import save_settings
from lensbench.app.settings.dial_scales import F_NUMBERS, aperture_scale
from tests.app.conftest import SMALL

KEY = imgui.Key


def panels():
    listed = hello_imgui.get_runner_params().docking_params.dockable_windows
    return {panel.label for panel in listed if panel.is_visible}


def type_keys(hand, text):
    hand.ctx.key_chars(text)
    hand.ctx.yield_(3)


@pytest.mark.slow
def test_keys_step_focus_aperture_and_exposure_with_or_without_the_dials(drive):
    def use(hand):
        hand.picture()
        near = hand.settings.focus_distance
        for hidden in (False, True):
            type_keys(hand, "[")
            assert hand.settings.focus_distance < near
            type_keys(hand, "]")
            assert hand.settings.focus_distance == pytest.approx(near)
            type_keys(hand, ".")
            assert hand.settings.f_number == 3.2
            type_keys(hand, ",")
            assert hand.settings.f_number == 2.8
            type_keys(hand, "+")
            assert hand.settings.exposure == pytest.approx(1.0 / 3.0)
            type_keys(hand, "-")
            assert hand.settings.exposure == pytest.approx(0.0)
            if not hidden:
                hand.press(KEY.tab)
                assert panels() == {"Render"}
        for _ in range(8):
            type_keys(hand, ",")
        assert hand.settings.f_number is None                       # wide open

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_a_camera_without_an_aperture_says_so(drive):
    def use(hand):
        hand.picture()
        type_keys(hand, ".")
        assert hand.settings == before

    before = replace(SMALL, camera="fisheye")
    assert drive(use, before).view.messages == ["This camera has no aperture to turn"]


@pytest.mark.slow
def test_a_dial_takes_the_keyboard_passes_it_on_and_lets_go(drive):
    def use(hand):
        hand.picture()
        shown = panels()
        hand.press(KEY.t)                                           # the focus
        hand.press(KEY.right_arrow)
        farther = hand.settings.focus_distance
        assert farther > SMALL.focus_distance
        hand.press(chord(KEY.mod_shift, KEY.left_arrow))
        assert SMALL.focus_distance < hand.settings.focus_distance < farther
        hand.press(KEY.tab)                                         # the aperture; no panel is hidden
        assert panels() == shown
        hand.press(KEY.right_arrow)
        assert hand.settings.f_number == 3.2
        hand.press(KEY.page_up)
        assert hand.settings.f_number == F_NUMBERS[F_NUMBERS.index(3.2) + 3]
        hand.press(chord(KEY.mod_shift, KEY.right_arrow))
        assert 4.5 < hand.settings.f_number < 4.6
        hand.press(KEY.enter)
        hand.ctx.key_chars("8")
        hand.press(KEY.enter)
        assert hand.settings.f_number == 8.0
        hand.press(chord(KEY.mod_shift, KEY.tab))
        before = hand.settings.focus_distance
        hand.press(KEY.left_arrow)
        assert hand.settings.focus_distance < before
        hand.press(KEY.escape)
        kept = hand.settings
        hand.press(KEY.right_arrow)
        assert hand.settings == kept
        hand.press(KEY.tab)
        assert panels() == {"Render"}
        hand.press(KEY.tab)
        hand.ctx.yield_(3)
        assert panels() == shown

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_hidden_panels_come_back_as_they_were(drive):
    def use(hand):
        hand.picture()
        hand.session.show_panel("Plan")
        hand.ctx.yield_(5)
        shown, front = panels(), [name for name in panels() if hand.session.panel_shown(name)]
        room = hand.session.view.room
        hand.press(KEY.tab)
        hand.ctx.yield_(5)
        assert hand.session.panels_hidden and hand.session.view.room[0] > room[0] and "Plan" in front
        hand.press(KEY.tab)
        hand.ctx.yield_(6)
        assert panels() == shown and sorted(front) == sorted(name for name in shown if hand.session.panel_shown(name))
        assert hand.session.view.room == pytest.approx(room, abs=2.0) and not hand.session.panels_hidden

    drive(use)


@pytest.mark.slow
def test_f11_fills_the_screen_and_gives_the_size_back(drive):
    def use(hand):
        hand.picture()
        size = imgui.get_main_viewport().size
        before = size.x, size.y
        hand.press(KEY.f11)
        hand.ctx.yield_(8)
        size = imgui.get_main_viewport().size
        assert (size.x, size.y) == (1920.0, 1080.0) and hand.session.full_screen is not None
        hand.press(KEY.f11)
        hand.ctx.yield_(8)
        size = imgui.get_main_viewport().size
        assert (size.x, size.y) == before and hand.session.full_screen is None

    drive(use)


def test_a_fine_step_is_a_tenth_of_a_third_stop():
    scale = aperture_scale(1.0)
    assert scale.finely(2.0, 1.0) == pytest.approx(scale.stepped(2.0, 1), rel=0.02)
    assert scale.finely(scale.low, -1.0) == scale.low


@pytest.mark.slow
def test_the_scale_of_the_view_menu_is_that_of_texts_controls_and_columns(drive):
    def use(hand):
        hand.picture()
        before = imgui.get_font_size(), imgui.get_style().item_spacing.x, hand.box("**/Aperture").get_width()
        hand.ctx.menu_click("//##MainMenuBar/View/Scale/150 %")
        hand.ctx.yield_(8)
        assert imgui.get_font_size() == pytest.approx(1.5 * before[0], abs=0.5)       # whole pixels
        assert imgui.get_style().item_spacing.x == 1.5 * before[1]
        assert theme.scale() == 1.5 and hand.box("**/Aperture").get_width() > 1.2 * before[2]
        hand.ctx.menu_click("//##MainMenuBar/View/Scale/As the screen asks for")
        hand.ctx.yield_(8)
        assert (imgui.get_font_size(), imgui.get_style().item_spacing.x) == before[:2] and theme.scale() == 1.0

    drive(use)


@pytest.mark.slow
def test_settings_with_pixels_of_their_own_say_so_and_a_button_follows_the_window_again(drive, tmp_path):
    path = tmp_path / "fixed.toml"
    save_settings(path, replace(SMALL, pixels_x=300, pixels_y=200))

    def use(hand):
        hand.session.view.follows = True
        hand.picture()
        hand.session.files.open(path)
        hand.picture()
        assert hand.settings.pixels_x == 300 and not hand.session.view.follows
        said = "fixed.toml sets 300 × 200 pixels: the picture no longer follows the window"
        assert hand.session.view.messages == [said]
        hand.ctx.item_click("**/Follow window")
        hand.ctx.yield_(3)
        hand.picture()
        assert hand.session.view.follows and hand.settings.pixels_x > 300

    assert drive(use).view.messages == []


@pytest.mark.slow
def test_enter_applies_a_dialog_and_escape_cancels_it(drive, tmp_path):
    def use(hand):
        hand.picture()
        hand.session.export.path = path = tmp_path / "out.png"
        hand.press(chord(KEY.mod_ctrl, KEY.e))
        hand.ctx.yield_(3)
        hand.session.export.path = path
        hand.press(KEY.escape)
        assert not imgui.is_popup_open("", imgui.PopupFlags_.any_popup) and not hand.session.export.busy
        hand.press(chord(KEY.mod_ctrl, KEY.e))
        hand.ctx.yield_(3)
        hand.session.export.path = path
        hand.ctx.item_input_value("//Export/##Longer side", 48)
        hand.press(KEY.enter)
        hand.wait(path.exists, "the exported picture")

    drive(use)
