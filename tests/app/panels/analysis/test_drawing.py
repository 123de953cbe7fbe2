"""Figures in narrow panels: the labels of axes, and titles that hide nothing."""

import numpy as np
import pytest
from imgui_bundle import ImVec2, imgui, implot

from lensbench.app.drawing import theme
from lensbench.app.drawing.plot_axes import PlotMap
from lensbench.app.drawing.plot_layers import CELL, _pixels
from lensbench.app.drawing.plot_painter import Drawn, draw_figure
from lensbench.app.plots.aperture_plots import axial_figure
from lensbench.app.plots.plot import Axis, Curve, Figure, Label, Map, Plot, Points, Table
from lensbench.app.plots.query import query
from lensbench.app.settings.settings import Settings
from tests.app.stand import drive

EMPTY = Table((), ())


def drawn(figure, size):
    """The state of a figure that was drawn into so many pixels, and the height of a line of its text there."""
    state, line = Drawn(), 0.0

    def gui():
        nonlocal line
        theme.small()
        line = imgui.get_text_line_height()
        draw_figure("figure", figure, ImVec2(*size), state)
        imgui.pop_font()

    drive(gui, lambda ctx: ctx.yield_(3))
    return state, line


@pytest.mark.slow
def test_both_plots_on_the_axis_name_their_upright_axis_in_the_narrowest_column(monkeypatch):
    """At 1280 × 720 they had bare numbers: heights in the stop and wavelengths."""
    labels, setup = set(), implot.setup_axis
    monkeypatch.setattr(implot, "setup_axis",
                        lambda axis, label, flags: labels.add(label) or setup(axis, label, flags))
    drawn(axial_figure(query(Settings()), 16), (270.0, 190.0))
    assert {"Height in the stop", "Wavelength (nm)"} <= labels


@pytest.mark.slow
@pytest.mark.parametrize("size", [(270.0, 120.0), (200.0, 300.0), (350.0, 280.0)])
def test_a_title_stands_above_a_map_and_hides_none_of_it(size):
    """It lay over the upper edge of the pupil in *Wavefront*, and over a contour's value."""
    shades = Map("", np.ones((8, 8)), (-1.0, 1.0), (-1.0, 1.0))
    plot = Plot(Axis(None, -1.0, 1.0), Axis(None, -1.0, 1.0), (shades,), "axis   Strehl 0.66", equal=True)
    state, line = drawn(Figure("", ((plot,),), EMPTY, "", ()), size)
    shown = state.shown["figure 0 0"]
    (left, right), (low, high) = (shown.x0, shown.x1), (shown.y0, shown.y1)
    assert left <= -1.0 and right >= 1.0 and low <= -1.0
    assert (high - 1.0) / (high - low) * size[1] > line


def test_words_about_a_mark_touch_no_other_words_and_none_without_room_are_written():
    """A name was once written at the right border, as if it named what lies there."""
    names = [f"mark {i}" for i in range(30)]
    x, y = np.full(30, 0.5), np.linspace(0.1, 0.9, 30)
    layers = (Points("", x, y, size=4.5), *(Label(0.5, h, name, free=True) for h, name in zip(y, names, strict=True)))
    state, _ = drawn(Figure("", ((Plot(Axis("x", 0.0, 1.0), Axis("y", 0.0, 1.0), layers),),)), (300.0, 110.0))
    boxes, shown = list(state.words["figure 0 0"].values()), state.shown["figure 0 0"]
    assert 2 < len(boxes) < 30
    for i, (left, top, right, bottom) in enumerate(boxes):
        assert shown.left <= left and right <= shown.right and shown.top <= top and bottom <= shown.bottom
        assert all(right <= l or left >= r or bottom <= t or top >= b for l, t, r, b in boxes[:i])


def test_a_curve_is_drawn_where_it_crosses_a_plot_between_two_points_outside():
    shown = PlotMap(0.0, 0.0, 100.0, 100.0, 0.0, 1.0, 0.0, 1.0, False)
    x, y = np.array([-5.0, -3.0, 3.0, 5.0, 6.0]), np.array([-4.0, -2.0, 4.0, 5.0, 5.0])
    kept = np.isfinite(_pixels(shown, Curve("", x, y))).all(1)
    assert kept.tolist() == [False, True, True, False, False]


@pytest.mark.parametrize("count", [0, 1])
def test_a_curve_without_a_stretch_is_drawn_as_nothing(count):
    """That of a field that no light reaches."""
    line = Curve("none", np.zeros(count), np.zeros(count), tag="none")
    state, _ = drawn(Figure("", ((Plot(Axis("x", 0.0, 1.0), Axis("y", 0.0, 1.0), (line,)),),)), (300.0, 110.0))
    assert state.shown and not state.words["figure 0 0"]


@pytest.mark.parametrize("turns", [1.0, 3.0, 12.0])
def test_the_words_of_curves_touch_no_curve(turns):
    x = np.linspace(0.0, 1.0, 400)
    curves = [Curve("", x, 0.4 * np.sin(2.0 * np.pi * turns * x + i) + 0.5, tag=f"f/{i}") for i in range(5)]
    state, _ = drawn(Figure("", ((Plot(Axis("x", 0.0, 1.0), Axis("y", 0.0, 1.0), tuple(curves)),),)), (500.0, 300.0))
    shown, boxes = state.shown["figure 0 0"], state.words["figure 0 0"]
    assert boxes or turns > 3.0                         # no room among many
    for left, top, right, bottom in boxes.values():
        for curve in curves:
            points = shown.pixels(curve.x, curve.y)
            margin = CELL                               # to which lines are known
            inside = (points > (left + margin, top + margin)) & (points < (right - margin, bottom - margin))
            assert not inside.all(1).any()
