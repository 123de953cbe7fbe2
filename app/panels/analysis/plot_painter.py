"""Figures of analyses drawn in the window: the legend, and plots with their axes."""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from imgui_bundle import ImVec2, ImVec4, imgui, implot

from lensbench.app.drawing import theme
from lensbench.app.drawing.plot_axes import AXIS_FLAGS, PLOT_FLAGS, PlotMap, linear_ticks, log_ticks, pieces, text
from lensbench.app.drawing.recorded import Calls, FrameMemo, Recorder, record, repeat
from lensbench.app.panels.analysis.plot_layers import (
    MapPictures, colour_of, draw_cursor, draw_layers, draw_map, draw_points, told, tooltip, unit_of
)
from lensbench.app.plots.plot import Curve, Figure, Map, Plot, Points

NARROW = 8.5                    # em: a plot of this width has no room for the label of its y axis
BESIDE = 3.2                    # em that ticks and labels of the other axis take from the length of an axis


@dataclass
class Drawn:
    """State of a figure between frames."""

    memo: FrameMemo = field(default_factory=FrameMemo)      # what is drawn, in pixels
    maps: MapPictures = field(default_factory=MapPictures)
    told: str = ""                                          # the numbers under the cursor
    fitted: dict[str, tuple] = field(default_factory=dict)  # the limits that each plot was fitted to
    limits: dict[str, tuple] = field(default_factory=dict)  # of each plot as drawn last, x and y

    def forget(self) -> None:
        """Drop what was drawn, and its textures; the limits stay."""
        for _ in range(2):                              # the frame drawn last, and the one before
            self.memo.begin_frame()
            self.maps.begin_frame()


@dataclass
class Grip:
    """An upright line in amber that the mouse drags: where it is (in the plot's x), its name, and its tooltip.

    held: whether it is dragged in this frame.
    """

    at: float
    name: str
    tip: str = ""
    held: bool = False


@dataclass(frozen=True)
class Under:
    """What is under the cursor: the plot, its row and column in the figure, and the place in its units."""

    plot: Plot
    row: int
    column: int
    x: float
    y: float


def draw_figure(name: str, figure: Figure, size: ImVec2, state: Drawn, grip: Grip | None = None,
                surfaces: tuple[int, ...] = (), named: bool = True) -> Under | None:
    """Draw the legend and all plots into `size` pixels; returns what is under the cursor.

    grip: a line in the first plot. surfaces: those that are lit; layers of other surfaces are left out. named: False
    leaves the legend out; the text at the cursor has its names as well.
    """
    top = imgui.get_cursor_screen_pos()
    state.memo.begin_frame()
    state.maps.begin_frame()
    if named:
        _legend(figure, size.x, state.memo)
    corner = imgui.get_cursor_screen_pos()
    room = ImVec2(size.x, size.y - (corner.y - top.y))
    weights = np.array(figure.heights or (1.0,) * len(figure.rows), float)
    heights = room.y * weights / weights.sum()
    found, y, state.told = None, corner.y, ""
    for i, row in enumerate(figure.rows):
        for j, plot in enumerate(row):
            imgui.set_cursor_screen_pos(ImVec2(corner.x + j * room.x / len(row), y))
            cell = ImVec2(room.x / len(row), float(heights[i]))
            at = _plot(f"{name} {i} {j}", plot, cell, state, grip if i == j == 0 else None, surfaces)
            if at is not None:
                found = Under(plot, i, j, *at)
        y += float(heights[i])
    imgui.set_cursor_screen_pos(ImVec2(corner.x, corner.y + room.y))
    imgui.dummy(ImVec2(0.0, 0.0))
    return found


# The legend


def _legend(figure: Figure, width: float, memo: FrameMemo) -> None:
    """Names with a sample of each line or mark, in as many lines as they need."""
    corner = imgui.get_cursor_screen_pos()
    calls, height = memo.of((figure.rows, width, corner.x, corner.y, theme.look()),
                            lambda: _drawn_legend(figure, width, corner))
    repeat(calls, imgui.get_window_draw_list())
    if height > 0.0:
        imgui.dummy(ImVec2(width, height))


def _drawn_legend(figure: Figure, width: float, corner: ImVec2) -> tuple[Calls, float]:
    """The calls that draw it, and its height in pixels, 0 without names."""
    found: dict = {}
    draw: Any = Recorder()
    for row in figure.rows:
        for plot in row:
            for layer in plot.named():
                found.setdefault(layer.name, layer)
    if not found:
        return [], 0.0
    pixel, line = theme.scale(), imgui.get_text_line_height()
    x, y = corner.x, corner.y
    for name, layer in found.items():
        sample = (18.0 if isinstance(layer, Curve) else 9.0) * pixel
        wide = sample + 4.0 * pixel + imgui.calc_text_size(name).x
        if x > corner.x and x + wide > corner.x + width:
            x, y = corner.x, y + line
        _sample(draw, layer, ImVec2(x, y + 0.5 * line), sample)
        text(draw, ImVec2(x + sample + 4.0 * pixel, y), theme.colours().dim, name)
        x += wide + 10.0 * pixel
    return draw.calls, y - corner.y + line


def _sample(draw: imgui.ImDrawList, layer, at: ImVec2, width: float) -> None:
    tint, pixel = theme.packed(colour_of(layer.tint)), theme.scale()
    if isinstance(layer, Curve):
        ends = np.array([[at.x, math.floor(at.y) + 0.5], [at.x + width, math.floor(at.y) + 0.5]])
        for piece in pieces(ends, *(each * pixel for each in layer.dash)):
            draw.add_polyline(piece, tint, layer.weight * pixel, imgui.ImDrawFlags_.none)
        return
    r = 3.0 * pixel
    x = at.x + 0.5 * width
    if isinstance(layer, Points) and layer.shape == "triangle":
        draw.add_triangle_filled(ImVec2(x - r, at.y + r), ImVec2(x + r, at.y + r), ImVec2(x, at.y - r), tint)
    elif isinstance(layer, Points) and layer.shape == "diamond":
        draw.add_quad_filled(ImVec2(x, at.y - 1.2 * r), ImVec2(x + 1.2 * r, at.y), ImVec2(x, at.y + 1.2 * r),
                             ImVec2(x - 1.2 * r, at.y), tint)
    else:
        draw.add_rect_filled(ImVec2(x - r, at.y - r), ImVec2(x + r, at.y + r), tint)


# One pair of axes


def _plot(name: str, plot: Plot, size: ImVec2, state: Drawn, grip: Grip | None = None,
          surfaces: tuple[int, ...] = ()) -> tuple[float, float] | None:
    """Draw one plot; the place under the cursor in its units."""
    if size.x < 40.0 or size.y < 40.0 or not implot.begin_plot(name, size, PLOT_FLAGS | implot.Flags_.no_frame):
        return None
    _axes(name, plot, size, state)
    shown = PlotMap.current(log=False)
    state.limits[name] = (shown.x0, shown.x1), (shown.y0, shown.y1)
    if plot.x.log or plot.y.log:
        shown = PlotMap.current(plot.x.log, plot.y.log)
    draw, at = implot.get_plot_draw_list(), None
    implot.push_plot_clip_rect()
    layers = [layer for layer in plot.layers if getattr(layer, "surface", None) in (None, *surfaces)]
    for place, layer in enumerate(layers):
        if isinstance(layer, Map) and not layer.ghost:
            draw_map(f"{name} {place}", draw, shown, layer, state.memo, state.maps)
        elif isinstance(layer, Points):
            draw_points(layer)
    implot.push_plot_clip_rect()
    repeat(state.memo.of((name, plot, shown, surfaces, theme.look()),
                         lambda: record(lambda into: draw_layers(into, shown, layers, plot.title))), draw)
    held = _grip(draw, shown, grip) if grip is not None else False
    implot.pop_plot_clip_rect()
    implot.pop_plot_clip_rect()
    if implot.is_plot_hovered() and not held:
        mouse = implot.get_plot_mouse_pos()
        at = float(mouse.x), float(mouse.y)
        if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
            state.fitted.pop(name, None)
        draw_cursor(draw, shown, plot, at)
        state.told = told(plot, *at)
    implot.end_plot()
    if at is not None and state.told and not imgui.is_mouse_dragging(imgui.MouseButton_.left):
        tooltip(plot, state.told)
    return at


def _axes(name: str, plot: Plot, size: ImVec2, state: Drawn) -> None:
    """Labels, limits and ticks. Limits are set when they or the size change, so that wheel and drag work between."""
    key = (plot.x, plot.y, size.x, size.y)
    refit = state.fitted.get(name) != key
    wide, high = size.x > theme.em(NARROW), size.y > theme.em(7)
    for index, axis, length, room, has_room in ((implot.ImAxis_.x1, plot.x, size.x, 3.4, high),
                                                (implot.ImAxis_.y1, plot.y, size.y, 1.4, wide)):
        flags = AXIS_FLAGS | (implot.AxisFlags_.no_decorations if axis.label is None else implot.AxisFlags_.none)
        implot.setup_axis(index, _label(axis.label, length - theme.em(BESIDE)) if has_room else None, flags)
        if axis.log:
            implot.setup_axis_scale(index, implot.Scale_.log10)
            values, labels = log_ticks(axis.low, axis.high, 0.8 * length, room * imgui.get_text_line_height())
            implot.setup_axis_ticks(index, values, labels, False)
        elif axis.label is not None:
            low, high = (axis.low, axis.high) if refit else state.limits[name][index == implot.ImAxis_.y1]
            values, labels = linear_ticks(low, high, 0.8 * length, room * imgui.get_text_line_height(), axis.whole)
            implot.setup_axis_ticks(index, values, labels, False)
        top = axis.high
        if axis is plot.y and plot.title and wide and high and not (plot.equal or axis.log):
            # Else the title hides curves
            top += (axis.high - axis.low) * 1.2 * imgui.get_text_line_height() / max(length - theme.em(3.0), 1.0)
        implot.setup_axis_limits(index, axis.low, top, implot.Cond_.always if refit else implot.Cond_.once)
    state.fitted[name] = key
    if plot.equal and refit:
        wide, high = plot.x.high - plot.x.low, plot.y.high - plot.y.low
        margin = 0.0 if plot.x.label is None else theme.em(3.0)
        title = 1.3 * imgui.get_text_line_height() if plot.title else 0.0          # above what it else would hide
        scale = min((size.x - margin) / wide, (size.y - margin - title) / high)
        more_x, more_y = 0.5 * ((size.x - margin) / scale - wide), 0.5 * ((size.y - margin - title) / scale - high)
        implot.setup_axes_limits(plot.x.low - more_x, plot.x.high + more_x, plot.y.low - more_y,
                                 plot.y.high + more_y + title / scale, implot.Cond_.always)
    implot.setup_finish()


def _label(label: str | None, length: float) -> str | None:
    """A label that fits into `length` pixels: all of it, its unit, or none."""
    return next((each for each in (label, unit_of(label)) if each and imgui.calc_text_size(each).x < length), None)


def _grip(draw: imgui.ImDrawList, shown: PlotMap, grip: Grip) -> bool:
    """Draw the line and let the mouse drag it; whether the mouse is on it."""
    colour, pixel, line = theme.colours(), theme.scale(), imgui.get_text_line_height()
    changed, at, _, hovered, held = implot.drag_line_x(0, grip.at, ImVec4(*colour.amber), 2.0 * pixel,
                                                       implot.DragToolFlags_.no_fit, False, False, False)
    grip.held = held
    if changed:
        grip.at = float(at)
    x = shown.at(grip.at, shown.y0).x
    leftward = x + imgui.calc_text_size(grip.name).x + 8.0 * pixel > shown.right
    text(draw, ImVec2(x + (-5.0 if leftward else 5.0) * pixel, shown.bottom - line - 3.0 * pixel), colour.amber_text,
         grip.name, right=leftward, plate=True)
    if (hovered or held) and grip.tip and imgui.begin_tooltip():
        imgui.text_unformatted(grip.tip)
        imgui.end_tooltip()
    return hovered or held
