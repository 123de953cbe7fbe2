"""The layout: the first, on a plain screen and on one twice as fine, floating panels, and room for what is in them."""

import pytest
from imgui_bundle import ImVec2, hello_imgui, imgui, immapp
from imgui_bundle.immapp import testing
from PIL import Image

from lensbench.app.drawing import theme
from lensbench.app.settings.camera_facts import CAMERA_KINDS
from lensbench.app.window import window
from tests.app.conftest import SMALL
from tests.app.kinds import KINDS, of_kind


@pytest.mark.parametrize("factor", [1.0, pytest.param(2.0, marks=pytest.mark.slow)])
def test_the_columns_are_as_wide_as_their_text_needs(factor):
    session = window.Session(SMALL, remember=False, threads=2)
    window.without_display()
    runner = window.parameters(session, (1900, 1000))
    runner.dpi_aware_params.dpi_window_size_factor = factor
    runner.fps_idling.enable_idling = False
    widths = {}

    def test(ctx):
        ctx.yield_(10)
        widths["factor"] = hello_imgui.dpi_window_size_factor()
        for name in ("Controls", "Exit pupil"):
            widths[name] = imgui.internal.find_window_by_name(name).size.x / imgui.get_font_size()

    try:
        testing.run(test_function=test, runner_params=runner, add_ons_params=immapp.AddOnsParams(with_implot=True))
    finally:
        session.worker.stop()
    assert widths["factor"] == factor
    assert 17.0 < widths["Controls"] < 23.0 and 18.0 < widths["Exit pupil"] < 31.0


@pytest.mark.slow
def test_a_panel_that_floats_hides_what_is_below_it(drive, tmp_path):
    def test(hand):
        hand.picture()
        hand.ctx.dock_clear("Plan")
        hand.ctx.yield_(2)
        hand.ctx.window_move("Plan", ImVec2(500, 200))
        hand.ctx.yield_(2)
        window = imgui.internal.find_window_by_name("Plan")
        pixel = int(window.pos.x + 0.5 * window.size.x), int(window.pos.y + window.size.y) - 4
        hand.photograph(tmp_path / "window.png")
        panel = tuple(round(255.0 * channel) for channel in theme.colours().panel[:3])
        with Image.open(tmp_path / "window.png") as picture:
            assert picture.getpixel(pixel) == panel

    drive(test)


@pytest.mark.slow
def test_every_camera_finds_room_for_its_controls_in_a_small_window(drive):
    shown = {}

    def test(hand):
        hand.picture()
        for name in KINDS:
            hand.session.history.edit(of_kind(SMALL, name), False, 0.0)
            hand.ctx.yield_(3)
            controls = imgui.internal.find_window_by_name("Controls")
            shown[name] = controls.scrollbar_y, hand.ctx.item_exists("**/Aperture")
        hand.session.history.edit(of_kind(SMALL, "polynomial"), False, 0.0)
        hand.ctx.yield_(3)
        hand.ctx.item_click("//Controls/##Degree")
        hand.ctx.item_click("//##Combo_00/5")
        hand.ctx.yield_(2)
        assert (hand.settings.lens_model, hand.settings.degree) == ("polynomial", 5)

    drive(test)
    assert [model for model, (scrolls, _) in shown.items() if scrolls] == []
    # a camera that sees from a point, or without a lens, has no aperture to set
    assert {name for name, (_, aperture) in shown.items() if not aperture} == {
        "pinhole", *(name for name, kind in CAMERA_KINDS.items() if not kind.f_number)}


@pytest.mark.slow
def test_the_words_of_the_help_stand_within_it(drive):
    def test(hand):
        hand.picture()
        hand.press(imgui.Key.f1)
        hand.ctx.yield_(3)
        sheet = imgui.internal.find_window_by_name("Keys and mouse")
        assert sheet.content_size.x <= sheet.size.x - 2.0 * imgui.get_style().window_padding.x + 0.5

    drive(test)


@pytest.mark.slow
def test_a_panel_that_is_shown_has_its_tab_in_sight(drive):
    def test(hand):
        hand.picture()
        for name in ("Tolerances", "Ghosts", "Bokeh", "Plan"):
            panel = hello_imgui.get_runner_params().docking_params.dockable_window_of_name(name)
            panel.is_visible = panel.focus_window_at_next_frame = True
            hand.ctx.yield_(40)                         # the tabs scroll for a moment
            shown = imgui.internal.find_window_by_name(name)
            tabs = shown.dock_node.tab_bar
            tab = imgui.internal.tab_bar_find_tab_by_id(tabs, shown.tab_id)
            left = tabs.bar_rect.min.x + tab.offset - tabs.scrolling_anim
            assert tabs.visible_tab_id == shown.tab_id
            assert left >= tabs.bar_rect.min.x - 1.0 and left + tab.width <= tabs.scrolling_rect_max_x + 1.0

    drive(test)
