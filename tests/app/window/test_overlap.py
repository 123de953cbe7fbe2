"""Words over the drawings of the window touch neither each other nor a handle, measured as they are drawn."""

from dataclasses import replace
from itertools import combinations

import pytest
from imgui_bundle import ImVec2, imgui

from lensbench.app.bench.build import bench_of
from lensbench.app.bench.ray_fans import lit_radius
from lensbench.app.panels.exit_pupil import NAME as PUPIL
from lensbench.app.panels.lens_section.handles import POSED, REACH
from lensbench.app.plots.exit_pupil import region
from lensbench.app.plots.plot import Curve
from lensbench.app.window.actions import ACTIONS
from tests.app.conftest import SMALL

SIZES = pytest.mark.parametrize(("size", "dark"), [((1024, 640), True), ((1280, 720), False)])
HALF = 1.3 * REACH              # pixels, of a handle of decentre or tilt
FAST = replace(SMALL, lens="fujifilm-24-f085", f_number=None)
pytestmark = pytest.mark.slow


def written(hand, panel) -> list[tuple[str, tuple[float, float, float, float]]]:
    """What the draw lists and the text items of one frame write within a box of the screen, with the box of each."""
    words, left, top = [], panel.min.x - 1.0, panel.min.y - 1.0

    def note(text, x, y):
        size = imgui.calc_text_size(text)
        if left <= x <= panel.max.x and top <= y <= panel.max.y and text.strip():
            words.append((text, (x, y, x + size.x, y + size.y)))

    def drawn(self, *args, plain=imgui.ImDrawList.add_text):
        if not isinstance(args[0], imgui.ImFont):
            note(args[2], args[0].x, args[0].y)
        plain(self, *args)

    def item(plain):
        def said(*args):
            corner = imgui.get_cursor_screen_pos()
            note(args[-1], corner.x, corner.y)
            plain(*args)
        return said

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(imgui.ImDrawList, "add_text", drawn)
        for name in ("text_disabled", "text_unformatted", "text_colored"):
            patched.setattr(imgui, name, item(getattr(imgui, name)))
        hand.ctx.yield_()
    return words


def touching(boxes) -> list:
    """Pairs of the named boxes that overlap by more than a pixel."""
    return [(a, b) for (a, (x0, y0, x1, y1)), (b, (u0, v0, u1, v1)) in combinations(boxes, 2)
            if min(x1, u1) - max(x0, u0) > 1.0 and min(y1, v1) - max(y0, v0) > 1.0]


def front(hand, name: str) -> None:
    """Bring a panel to the front of its dock."""
    hand.ctx.window_focus(f"//{name}")
    hand.ctx.yield_(4)


@SIZES
@pytest.mark.parametrize("lens", ["pbrt-dgauss-50mm", "fujifilm-24-f085", "rodenstock-xr-heligon-100-f075"])
def test_no_word_of_the_section_lies_on_another_or_on_a_handle(drive, size, dark, lens):
    def use(hand):
        hand.picture()
        front(hand, "Section")
        hand.ctx.item_click("**/Edit section")
        canvas, state = hand.box("**/Section canvas"), hand.session.panels.kept.section
        for surface in range(0, 10, 2):
            state.edit.body = surface, surface + 1
            hand.ctx.mouse_move_to_pos(ImVec2(5.0, 5.0))
            hand.ctx.yield_(2)
            words = written(hand, canvas)
            names = [word for word in words if word[0] not in POSED.values()]
            assert {"Stop", "Film", "axis"} <= {text for text, _ in names} and any("Side view" in text for text, _ in
                                                                                   names)
            handles = [("handle", (0.5 * (x0 + x1) - HALF, 0.5 * (y0 + y1) - HALF, 0.5 * (x0 + x1) + HALF,
                                   0.5 * (y0 + y1) + HALF)) for text, (x0, y0, x1, y1) in words
                       if text in POSED.values()]
            assert len(handles) == 2
            assert not touching([*names, *handles])

    drive(use, replace(SMALL, lens=lens, f_number=None), size, dark)


@SIZES
def test_the_number_of_rays_of_a_pixel_stands_above_its_plot(drive, size, dark):
    def use(hand):
        hand.picture()
        hand.session.view.links.pinned = 0.62, 0.45
        front(hand, "Pixel")
        panel = imgui.internal.find_window_by_name("Pixel").rect()
        words = [box for text, box in written(hand, panel) if text.endswith("rays")]
        plots = list(hand.session.panels.kept.pixel.drawn.shown.values())
        assert len(words) == len(plots) == int(size[1] > 700)       # a low panel has room for the values alone
        assert all(box[3] <= plot.top for box, plot in zip(words, plots, strict=True))

    drive(use, SMALL, size, dark)


@SIZES
@pytest.mark.parametrize("field", [0.0, 0.7, 1.0])
def test_every_exit_pupil_is_drawn_whole_by_a_very_fast_lens(drive, size, dark, field):
    def use(hand):
        hand.picture()
        hand.session.panels._field = field
        front(hand, "Exit pupil")
        hand.ctx.mouse_move_to_pos(ImVec2(5.0, 5.0))
        hand.ctx.yield_(4)
        drawn, bench = hand.session.panels.kept.pupil.drawn, bench_of(hand.settings)
        shown = drawn.shown[f"{PUPIL} 0 0"]
        assert {"axis", "0.7", "full"} <= set(drawn.words[f"{PUPIL} 0 0"])
        for share in (0.0, 0.7, 1.0):
            pixels = shown.pixels(*region(bench.lens, bench.film_distance, share * lit_radius(bench)).outline.T)
            assert (pixels > (shown.left, shown.top)).all() and (pixels < (shown.right, shown.bottom)).all()

    drive(use, FAST, size, dark)


@SIZES
def test_each_curve_of_the_mtf_has_a_look_of_its_own_which_the_legend_names_whole(drive, size, dark):
    def use(hand):
        hand.picture()
        ACTIONS["Layout: Photographer"].run(hand.session)
        hand.ctx.yield_(6)
        front(hand, "MTF")
        state = hand.session.analyses.states["MTF"]
        hand.wait(lambda: state.figure is not None and state.drawn.shown, "the MTF")
        curves = [layer for layer in state.figure.rows[0][0].layers if isinstance(layer, Curve) and layer.name]
        assert len({(curve.tint, curve.dash) for curve in curves}) == len(curves) == 4
        assert [curve.name for curve in curves] == ["10 lp/mm S", "10 lp/mm T", "30 lp/mm S", "30 lp/mm T"]
        panel = imgui.internal.find_window_by_name("MTF").rect()
        words = written(hand, panel)
        if size[1] > 700:                       # a low panel has no legend, and names curves at the cursor
            assert {curve.name for curve in curves} <= {text for text, _ in words}
        assert not touching(words)

    drive(use, FAST, size, dark)
