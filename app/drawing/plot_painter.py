"""Figures drawn in the window: the legend, and plots with their axes, a line to drag, and the numbers at the cursor."""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from imgui_bundle import ImVec2, imgui, implot

from lensbench.app.drawing import theme
from lensbench.app.drawing.plot_axes import AXIS_FLAGS, PLOT_FLAGS, PlotMap, linear_ticks, log_ticks, pieces, text
from lensbench.app.drawing.plot_layers import (
    Boxes, Pictures, colour_of, draw_cursor, draw_layers, draw_map, draw_mark, draw_points, tooltip
)
from lensbench.app.drawing.recorded import Calls, FrameMemo, Recorder, repeat
from lensbench.app.plots.plot import SIZED, Axis, Curve, Figure, Map, Plot, Points, told, unit_of

NARROW = 8.5                    # em: a plot of this width has no room for the label of its y axis
ACROSS = 3.2                    # em that ticks and labels of the other axis take from the length of an axis
DECADES = 1e3                   # by which the wheel may leave the range of a logarithmic axis


@dataclass
class Drawn:
    """State of a figure between frames.

    maps: the textures of its maps; None for a figure without maps.
    """

    maps: Pictures | None = None
    memo: FrameMemo = field(default_factory=FrameMemo)      # what is drawn, in pixels
    told: str = ""                                          # the numbers under the cursor
    fitted: dict[str, tuple] = field(default_factory=dict)  # the limits that each plot was fitted to
    shown: dict[str, PlotMap] = field(default_factory=dict)     # each plot as drawn last
    words: dict[str, Boxes] = field(default_factory=dict)   # and where its words stand
    grabbed: float = 0.0                                    # pixels from the mouse to the line that it drags

    def forget(self) -> None:
        """Drop what was drawn, and its textures; the limits stay."""
        for _ in range(2):                              # the frame drawn last, and the one before
            self._begin_frame()

    def _begin_frame(self) -> None:
        self.memo.begin_frame()
        if self.maps is not None:
            self.maps.begin_frame()


@dataclass
class Grip:
    """An upright line in amber that the mouse drags: where it is (in the plot's x), its name, and its tooltip.

    endless: infinity lies at the right edge. held: whether it is dragged in this frame.
    """

    at: float
    name: str
    tip: str = ""
    endless: bool = False
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
                surfaces: tuple[int, ...] = (), named: bool = True, over: tuple = ()) -> Under | None:
    """Draw the legend and all plots into `size` pixels; returns what is under the cursor.

    grip: a line in the first plot. surfaces: those that are lit; layers of other surfaces are left out. named: False
    leaves the legend out; the text at the cursor has its names as well. over: layers above the first plot, which
    change from frame to frame.
    """
    top = imgui.get_cursor_screen_pos()
    state._begin_frame()
    if named:
        _legend(figure, size.x, state.memo)
    corner = imgui.get_cursor_screen_pos()
    room = ImVec2(size.x, size.y - (corner.y - top.y))
    weights = np.array(figure.heights or (1.0,) * len(figure.rows), float)
    heights = room.y * weights / weights.sum()
    under, y, state.told = None, corner.y, ""
    for i, row in enumerate(figure.rows):
        for j, plot in enumerate(row):
            imgui.set_cursor_screen_pos(ImVec2(corner.x + j * room.x / len(row), y))
            cell = ImVec2(room.x / len(row), float(heights[i]))
            first = i == j == 0
            spot = _plot(f"{name} {i} {j}", plot, cell, state, grip if first else None, surfaces, over if first else ())
            if spot is not None:
                under = Under(plot, i, j, *spot)
        y += float(heights[i])
    imgui.set_cursor_screen_pos(ImVec2(corner.x, corner.y + room.y))
    imgui.dummy(ImVec2(0.0, 0.0))
    return under


def draw_plot(name: str, plot: Plot, size: ImVec2, state: Drawn, **more: Any) -> Under | None:
    """Draw one plot, without a legend; the rest as `draw_figure`."""
    return draw_figure(name, Figure(name, ((plot,),)), size, state, named=False, **more)


def drawn_map(name: str, state: Drawn) -> PlotMap | None:
    """Where the first plot of a figure lies, as it was drawn last; None for one without room."""
    return state.shown.get(f"{name} 0 0")


# The legend


def _legend(figure: Figure, width: float, memo: FrameMemo) -> None:
    """Names with a sample of each line or mark, in as many lines as they need."""
    corner = imgui.get_cursor_screen_pos()
    named: dict = {}
    for layer in (layer for row in figure.rows for plot in row for layer in plot.named()):
        named.setdefault(layer.name, layer)
    key = tuple((name, type(layer), layer.tint, getattr(layer, "dash", getattr(layer, "shape", "")))
                for name, layer in named.items())
    calls, height = memo.of((key, width, corner.x, corner.y, theme.look()), lambda: _drawn_legend(named, width, corner))
    repeat(calls, imgui.get_window_draw_list())
    if height > 0.0:
        imgui.dummy(ImVec2(width, height))


def _drawn_legend(named: dict, width: float, corner: ImVec2) -> tuple[Calls, float]:
    """The calls that draw the names of these layers, and the height in pixels, 0 without names."""
    draw: Any = Recorder()
    if not named:
        return [], 0.0
    pixel, line = theme.scale(), imgui.get_text_line_height()
    x, y = corner.x, corner.y
    for name, layer in named.items():
        sample = (18.0 if isinstance(layer, Curve) else 9.0) * pixel
        wide = sample + 4.0 * pixel + imgui.calc_text_size(name).x
        if x > corner.x and x + wide > corner.x + width:
            x, y = corner.x, y + line
        _sample(draw, layer, ImVec2(x, y + 0.5 * line), sample)
        text(draw, ImVec2(x + sample + 4.0 * pixel, y), theme.colours().dim, name)
        x += wide + 10.0 * pixel
    return draw.calls, y - corner.y + line


def _sample(draw: imgui.ImDrawList, layer, corner: ImVec2, width: float) -> None:
    tint, pixel = theme.packed(colour_of(layer.tint)), theme.scale()
    if isinstance(layer, Curve):
        ends = np.array([[corner.x, math.floor(corner.y) + 0.5], [corner.x + width, math.floor(corner.y) + 0.5]])
        for piece in pieces(ends, *(length * pixel for length in layer.dash)):
            draw.add_polyline(piece, tint, layer.weight * pixel, imgui.ImDrawFlags_.none)
        return
    draw_mark(draw, layer.shape if isinstance(layer, Points) else "square", ImVec2(corner.x + 0.5 * width, corner.y),
              3.0 * pixel, tint)


# One pair of axes


def _plot(name: str, plot: Plot, size: ImVec2, state: Drawn, grip: Grip | None = None,
          surfaces: tuple[int, ...] = (), over: tuple = ()) -> tuple[float, float] | None:
    """Draw one plot; the place under the cursor in its units."""
    if size.x < 40.0 or size.y < 40.0 or not implot.begin_plot(name, size, PLOT_FLAGS | implot.Flags_.no_frame):
        state.shown.pop(name, None)
        return None
    _axes(name, plot, size, state)
    shown = state.shown[name] = PlotMap.current(plot.x.log, plot.y.log, plot.x.falling)
    draw, position, column = implot.get_plot_draw_list(), None, None if grip is None else _column(shown, grip)
    implot.push_plot_clip_rect()
    layers = [layer for layer in plot.layers if getattr(layer, "surface", None) in (None, *surfaces)]
    for index, layer in enumerate(layers):
        if isinstance(layer, Map) and not layer.ghost and state.maps is not None:
            draw_map(f"{name} {index}", draw, shown, layer, state.memo, state.maps)
        elif isinstance(layer, Points) and layer.size < SIZED:
            draw_points(layer)
    implot.push_plot_clip_rect()
    calls, state.words[name] = state.memo.of((name, plot, shown, surfaces, column, theme.look()),
                                             lambda: _recorded(shown, layers, plot.title, column))
    repeat(calls, draw)
    if over:
        draw_layers(draw, shown, over)
    if grip is not None and column is not None:
        _draw_grip(draw, shown, grip, column)
    implot.pop_plot_clip_rect()
    implot.pop_plot_clip_rect()
    if implot.is_plot_hovered() and not (grip is not None and grip.held):
        mouse = implot.get_plot_mouse_pos()
        position = float(mouse.x), float(mouse.y)
        if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
            state.fitted.pop(name, None)
        draw_cursor(draw, shown, plot, position)
        state.told = told(plot, *position)
    implot.end_plot()
    if grip is not None and column is not None and shown.bottom > shown.top:
        after = imgui.get_cursor_screen_pos()
        _drag(shown, grip, column, state)
        imgui.set_cursor_screen_pos(after)
    if position is not None and state.told and not imgui.is_mouse_down(imgui.MouseButton_.left):
        tooltip(plot, state.told)
    return position


def _recorded(shown: PlotMap, layers: list, title: str, column: float | None) -> tuple[Calls, Boxes]:
    """The calls that draw the layers, and where their words stand."""
    recorder: Any = Recorder()
    words = draw_layers(recorder, shown, layers, title, column)
    return recorder.calls, words


def _axes(name: str, plot: Plot, size: ImVec2, state: Drawn) -> None:
    """Labels, limits and ticks. Limits are set when they or the size change, so that wheel and drag work between."""
    before, margin = state.shown.get(name), 0.0 if plot.x.label is None else theme.em(3.0)
    inner = (size.x - margin, size.y - margin) if before is None or not plot.equal else (
        round(before.right - before.left), round(before.bottom - before.top))
    key = (plot.x, plot.y, size.x, size.y, inner)
    refit = state.fitted.get(name) != key
    wide, high = size.x > theme.em(NARROW), size.y > theme.em(7)
    shown = (plot.x.low, plot.x.high), (plot.y.low, plot.y.high)
    if before is not None and not refit:
        shown = _ends(before.x0, before.x1, plot.x.log), _ends(before.y0, before.y1, plot.y.log)
    for index, axis, ends, length, room, has_room in (
            (implot.ImAxis_.x1, plot.x, shown[0], size.x, 3.4, high),
            (implot.ImAxis_.y1, plot.y, shown[1], size.y, 1.4, wide)):
        flags = AXIS_FLAGS | (implot.AxisFlags_.no_decorations if axis.label is None else implot.AxisFlags_.none)
        flags |= implot.AxisFlags_.invert if axis.falling else implot.AxisFlags_.none
        implot.setup_axis(index, _label(axis.label, length - theme.em(ACROSS)) if has_room else None, flags)
        _ticks(index, axis, ends, 0.8 * length, room)
        top = axis.high
        if axis is plot.y and plot.title and wide and high and not (plot.equal or axis.log):
            # Else the title hides curves
            top += (axis.high - axis.low) * 1.2 * imgui.get_text_line_height() / max(length - theme.em(3.0), 1.0)
        implot.setup_axis_limits(index, axis.low, top, implot.Cond_.always if refit else implot.Cond_.once)
    state.fitted[name] = key
    if plot.right is not None:
        label, unit = plot.right
        implot.setup_axis(implot.ImAxis_.y2, label if wide and high else None, AXIS_FLAGS
                          | implot.AxisFlags_.aux_default | implot.AxisFlags_.lock)
        low, top = (end / unit for end in shown[1])
        _ticks(implot.ImAxis_.y2, Axis(label, low, top, plot.y.log), (low, top), 0.8 * size.y, 1.4)
        implot.setup_axis_limits(implot.ImAxis_.y2, low, top, implot.Cond_.always)
    if plot.equal and refit:
        wide, high = plot.x.high - plot.x.low, plot.y.high - plot.y.low
        title = 1.3 * imgui.get_text_line_height() if plot.title else 0.0          # above what it else would hide
        scale = max(min(inner[0] / wide, (inner[1] - title) / high), 1e-6)
        more_x, more_y = 0.5 * (inner[0] / scale - wide), 0.5 * ((inner[1] - title) / scale - high)
        implot.setup_axes_limits(plot.x.low - more_x, plot.x.high + more_x, plot.y.low - more_y,
                                 plot.y.high + more_y + title / scale, implot.Cond_.always)
    implot.setup_finish()


def _ends(first: float, last: float, log: bool) -> tuple[float, float]:
    """The lower and the upper end of an axis, from those of a `PlotMap`."""
    low, high = min(first, last), max(first, last)
    return (10.0**low, 10.0**high) if log else (low, high)


def _label(label: str | None, length: float) -> str | None:
    """A label that fits into `length` pixels: all of it, its unit, or none."""
    return next((name for name in (label, unit_of(label)) if name and imgui.calc_text_size(name).x < length), None)


def _ticks(index: int, axis: Axis, ends: tuple[float, float], length: float, room: float) -> None:
    """Round numbers along an axis of this length in pixels, each with room for so many lines of text."""
    if axis.log:
        implot.setup_axis_scale(index, implot.Scale_.log10)
        implot.setup_axis_limits_constraints(index, axis.low / DECADES, axis.high * DECADES)
        implot.setup_axis_ticks(index, *log_ticks(*ends, length, room * imgui.get_text_line_height()), False)
    elif axis.label is not None:
        implot.setup_axis_ticks(index, *linear_ticks(*ends, length, room * imgui.get_text_line_height(), axis.whole),
                                False)


# The line to drag


def _column(shown: PlotMap, grip: Grip) -> float:
    """The column of the line in pixels: at the right edge for infinity."""
    x = shown.right if math.isinf(grip.at) else shown.at(grip.at, 1.0).x
    return math.floor(min(max(x, shown.left + 1.0), shown.right - 1.0) if grip.endless else x)


def _draw_grip(draw: imgui.ImDrawList, shown: PlotMap, grip: Grip, x: float) -> None:
    """The line, and its name at the top."""
    pixel, colour = theme.scale(), theme.colours()
    draw.add_rect_filled(ImVec2(x - pixel, shown.top), ImVec2(x + pixel, shown.bottom), theme.packed(colour.amber))
    leftward = x + imgui.calc_text_size(grip.name).x + 8.0 * pixel > shown.right
    text(draw, ImVec2(x + (-6.0 if leftward else 6.0) * pixel, shown.top + 3.0 * pixel), colour.amber_text, grip.name,
         right=leftward, plate=True)


def _drag(shown: PlotMap, grip: Grip, x: float, state: Drawn) -> None:
    """The line as an item over the plot, which the mouse drags."""
    half = 5.0 * theme.scale()
    imgui.set_cursor_screen_pos(ImVec2(x - half, shown.top))
    imgui.invisible_button("Focus line", ImVec2(2.0 * half, shown.bottom - shown.top))
    grip.held = imgui.is_item_active()
    if imgui.is_item_hovered() or grip.held:
        imgui.set_mouse_cursor(imgui.MouseCursor_.resize_ew)
        if grip.tip:
            imgui.set_tooltip(grip.tip)
    mouse = imgui.get_mouse_pos().x
    if imgui.is_item_activated():
        state.grabbed = x - mouse
    elif grip.held and imgui.get_io().mouse_delta.x != 0.0:
        column = mouse + state.grabbed
        grip.at = math.inf if grip.endless and column >= shown.right - 1.0 else shown.x_at(column)
