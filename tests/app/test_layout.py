"""The layout: the first, on a plain screen and on one twice as fine, and panels that float."""

import pytest
from imgui_bundle import ImVec2, hello_imgui, imgui, immapp
from imgui_bundle.immapp import testing
from PIL import Image

from lensbench.app import theme, window

from .conftest import SMALL


@pytest.mark.parametrize("factor", [1.0, 2.0])
def test_the_columns_are_as_wide_as_their_text_needs(factor):
    bench = window.Bench(SMALL, remember=False, threads=2)
    window.without_display()
    runner = window.parameters(bench, (1900, 1000))
    runner.dpi_aware_params.dpi_window_size_factor = factor
    runner.fps_idling.enable_idling = False
    seen = {}

    def test(ctx):
        ctx.yield_(10)
        seen["factor"] = hello_imgui.dpi_window_size_factor()
        for name in ("Controls", "Exit pupil"):
            seen[name] = imgui.internal.find_window_by_name(name).size.x / imgui.get_font_size()

    try:
        testing.run(test_function=test, runner_params=runner, add_ons_params=immapp.AddOnsParams(with_implot=True))
    finally:
        bench.worker.stop()
    assert seen["factor"] == factor
    assert 17.0 < seen["Controls"] < 23.0 and 18.0 < seen["Exit pupil"] < 31.0


def test_a_panel_that_floats_hides_what_is_below_it(drive, tmp_path):
    def test(hand):
        hand.picture()
        hand.ctx.dock_clear("Plan")
        hand.ctx.yield_(2)
        hand.ctx.window_move("Plan", ImVec2(500, 200))
        hand.ctx.yield_(2)
        window = imgui.internal.find_window_by_name("Plan")
        at = int(window.pos.x + 0.5 * window.size.x), int(window.pos.y + window.size.y) - 4
        hand.photograph(tmp_path / "window.png")
        panel = tuple(round(255.0 * part) for part in theme.colours().panel[:3])
        with Image.open(tmp_path / "window.png") as picture:
            assert picture.getpixel(at) == panel

    drive(test)
