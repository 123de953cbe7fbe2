"""The circles of confusion: their curves against closed forms, and the focus line under a real mouse."""

import math
from dataclasses import replace

import numpy as np
import pytest
from imgui_bundle import ImVec2

import lensbench as lb
from lensbench.app.bench.build import bench_of
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.drawing.plot_axes import PlotMap, log_ticks, pieces
from lensbench.app.panels import circle_of_confusion
from lensbench.app.plots.blur import SMALLEST, curves, main_curve, plot_range
from lensbench.app.settings.settings import Settings
from tests.app.stand import drive

START = Settings(lens="pbrt-dgauss-50mm")


def shown(settings: Settings):
    low, high, *_ = plot_range(readings(settings))
    return curves(settings, low, high)


@pytest.mark.parametrize("focus", [600.0, 1200.0, math.inf])
def test_the_thin_curve_is_the_closed_form_measured_from_the_lens(focus):
    settings = replace(START, focus_distance=focus)
    got, stand, drawn = readings(settings), bench_of(settings), shown(settings)
    offset = stand.film_z - stand.first_order.front_principal
    s, s_f = 1000.0 * drawn.distances - offset, focus - offset
    # A f |1/s − 1/s_f| s_f / (s_f − f)
    expected = got.efl / got.f_number * got.efl * np.abs(1.0 / s - 1.0 / s_f) / (1.0 - got.efl / s_f)
    assert drawn.thin == pytest.approx(np.maximum(1000.0 * expected, SMALLEST), rel=1e-9)


@pytest.mark.parametrize("focus", [600.0, 1200.0])
def test_thin_thick_and_real_agree_on_a_slow_lens(focus):
    # At f/16 aberrations are small beside blurs over 10 µm; the pupil stands some mm off the principal plane
    drawn = shown(replace(START, focus_distance=focus, f_number=16.0))
    far = drawn.thick > 10.0
    assert far.sum() > 30
    assert drawn.real[far] == pytest.approx(drawn.thick[far], rel=0.05)
    assert drawn.thin[far] == pytest.approx(drawn.thick[far], rel=0.12)


def test_the_curve_dips_at_the_focus_and_the_real_one_keeps_its_aberrations():
    drawn = shown(START)
    nearest = int(np.argmin(np.abs(drawn.distances - 1.2)))
    assert drawn.thin[nearest] == pytest.approx(SMALLEST, rel=1e-6)
    assert 0.5 < drawn.real.min() < 30.0


def test_neighbouring_stops_differ_by_the_ratio_of_their_f_numbers():
    drawn = shown(START)
    # f/2, as engraved on this lens of f/2.03, belongs to them
    assert [f_number for f_number, _ in drawn.neighbours] == [2.0, 5.6, 16.0]
    for f_number, diameters in drawn.neighbours:
        large = diameters > 1.0
        assert diameters[large] == pytest.approx(drawn.thick[large] * 2.8 / f_number, rel=1e-9)


def test_the_limits_lie_where_the_thin_curve_crosses_the_limit():
    got, drawn = readings(START), shown(START)
    for edge in (got.near_limit, got.far_limit):
        there = np.exp(np.interp(math.log(edge / 1000.0), np.log(drawn.distances), np.log(drawn.thin)))
        # Between two points of the curve, drawn as a chord
        assert there == pytest.approx(1000.0 * got.limit, rel=0.02)


def test_the_picture_follows_the_real_lens_only_when_it_is_traced():
    assert main_curve(shown(START)) is shown(START).real
    thin = shown(replace(START, lens_model="thin"))
    assert thin.real is None and main_curve(thin) is thin.thick
    ideal = shown(replace(START, camera="perspective"))
    assert ideal.thick is None and main_curve(ideal) is ideal.thin
    with pytest.raises(ValueError, match="pinhole"):
        shown(replace(START, lens_model="pinhole"))


def test_what_the_plot_shows_does_not_jump_with_focus_and_aperture():
    ranges = {plot_range(readings(s)) for s in (START, replace(START, f_number=11.0),
                                                   replace(START, focus_distance=math.inf))}
    assert len(ranges) == 1
    low, high, bottom, top = ranges.pop()
    assert low * 1000.0 <= 1.05 * readings(START).nearest_focus and high * 1000.0 > readings(START).hyperfocal
    assert bottom < top


def test_the_plot_has_room_for_the_blur_of_what_is_far_behind_a_near_focus():
    nearest = replace(START, focus_distance=readings(START).nearest_focus * 1.001)
    low, high, _, top = plot_range(readings(nearest))
    far = main_curve(curves(nearest, low, high))[-1]
    assert plot_range(readings(START))[3] < far < top


def test_a_plot_maps_logarithms_and_back():
    plot = PlotMap(10.0, 20.0, 210.0, 120.0, -1.0, 1.0, 0.0, 2.0, log=True)
    assert plot.pixels([0.1, 1.0, 10.0], [1.0, 10.0, 100.0]) == pytest.approx(
        np.array([[10.0, 120.0], [110.0, 70.0], [210.0, 20.0]]))
    assert plot.x_at(110.0) == pytest.approx(1.0)


def test_dashes_lie_on_the_curve_and_leave_out_what_is_no_number():
    line = np.array([[0.0, 0.0], [10.0, 0.0], [np.nan, 0.0], [20.0, 0.0], [40.0, 0.0]])
    dashes = [(piece[0].x, piece[-1].x) for piece in pieces(line, 6.0, 2.0)]
    assert dashes == [(0.0, 6.0), (8.0, 10.0), (20.0, 26.0), (28.0, 34.0), (36.0, 40.0)]


def test_ticks_thin_out_on_a_short_axis():
    dense, few = log_ticks(1.0, 1000.0, 600.0, 30.0)[0], log_ticks(1.0, 1000.0, 90.0, 30.0)[0]
    assert {1.0, 2.0, 5.0, 10.0} <= set(dense) and few == [1.0, 10.0, 100.0, 1000.0, 10000.0]


# The panel


class Panel:
    def __init__(self, settings: Settings = START):
        self.settings, self.state = settings, circle_of_confusion.CocState()

    def show(self) -> None:
        self.settings = circle_of_confusion.circle_of_confusion_panel(self.settings, self.state)


def test_the_focus_line_is_dragged_to_focus():
    panel = Panel()
    values = {}

    def drag_to(ctx, x: float) -> None:
        box = ctx.item_info("**/Focus line").rect_full
        y = 0.5 * (box.min.y + box.max.y)
        ctx.mouse_move_to_pos(ImVec2(0.5 * (box.min.x + box.max.x), y))
        ctx.mouse_down(0)
        ctx.yield_()
        ctx.mouse_move_to_pos(ImVec2(x, y))
        ctx.yield_()
        ctx.mouse_up(0)
        ctx.yield_(2)

    def place(ctx) -> float:
        box = ctx.item_info("**/Focus line").rect_full
        return 0.5 * (box.min.x + box.max.x)

    def test(ctx):
        ctx.yield_(4)
        values["start"] = place(ctx)
        drag_to(ctx, values["start"] + 40.0)
        values["moved"], values["focus"] = place(ctx), panel.settings.focus_distance
        drag_to(ctx, 600.0)
        values["beyond"] = panel.settings.focus_distance
        drag_to(ctx, 2.0)
        values["before"] = panel.settings.focus_distance
        for x in range(40, 280, 30):                    # the numbers under the cursor
            ctx.mouse_move_to_pos(ImVec2(float(x), 100.0))
            ctx.yield_()

    drive(panel.show, test, (300, 300))
    assert values["moved"] == pytest.approx(values["start"] + 40.0, abs=1.0)    # whole pixels
    # The axis is logarithmic: the drag takes the focus by as many decades as its share of the plot's
    assert 1200.0 < values["focus"] < 50000.0
    assert values["beyond"] == math.inf
    assert values["before"] == pytest.approx(lb.nearest_focus(bench_of(START).lens), rel=1e-9)


STATES = [START, replace(START, lens="no-such-lens"), replace(START, focus_distance=3.0),
          replace(START, f_number=0.3), replace(START, lens_model="pinhole"),
          replace(START, camera="perspective", f_number=None), replace(START, camera="perspective", focus_distance=1.0),
          replace(START, lens="pbrt-fisheye-10mm", focus_distance=math.inf), replace(START, film_width=0.0),
          replace(START, f_number=900.0), replace(START, limit="pixel")]


@pytest.mark.parametrize("size", [(20, 20), (80, 75), (90, 800), (1500, 120)])
def test_the_panel_lives_in_any_window_and_any_state(size):
    panel = Panel()

    def test(ctx):
        for state in STATES:
            panel.settings = state
            ctx.yield_(2)
            assert panel.settings == state

    drive(panel.show, test, size)
