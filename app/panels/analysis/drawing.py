"""Figures of analyses drawn in the window: axes, layers, legend, and the numbers under the cursor."""

import math
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from imgui_bundle import ImVec2, ImVec4, imgui, implot

from lensbench.app.state.analysis.figure import (
    Area,
    Bars,
    Curve,
    Figure,
    Label,
    Map,
    Plot,
    Points,
    Tint,
    wavelength_colour,
)
from lensbench.app.widgets import theme
from lensbench.app.widgets.memo import Memo
from lensbench.app.widgets.plot_axes import AXIS_FLAGS, PLOT_FLAGS, PlotMap, linear_ticks, log_ticks, pieces, text
from lensbench.kernels.figures import significant, true_minus

MARKERS = {"triangle": implot.Marker_.up, "square": implot.Marker_.square, "diamond": implot.Marker_.diamond}
DOT = 1.3                       # half a mark of a point, pixels
SHADES = 64
NAMED = 6                       # levels of a map, at most, that have their values on the contours


@dataclass
class Drawn:
    """State of a figure between frames."""

    memo: Memo = field(default_factory=lambda: Memo(96))    # strokes in pixels
    told: str = ""                                          # the numbers under the cursor
    fitted: dict[str, tuple] = field(default_factory=dict)  # the limits that each plot was fitted to
    limits: dict[str, tuple] = field(default_factory=dict)  # of each plot as drawn last, x and y


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


def colour_of(tint: Tint) -> theme.Colour:
    """The colour of a tint in the theme in use."""
    if isinstance(tint, float):
        code = wavelength_colour(tint, theme.colours().dark)
        return int(code[:2], 16) / 255.0, int(code[2:4], 16) / 255.0, int(code[4:], 16) / 255.0, 1.0
    if tint.startswith("chart"):
        return theme.tints()[int(tint[5:]) % 8]
    colour: theme.Colour = getattr(theme.colours(), tint)
    return colour


def draw_figure(name: str, figure: Figure, size: ImVec2, state: Drawn, grip: Grip | None = None) -> Under | None:
    """Draw the legend and all plots into `size` pixels; what is under the cursor. grip: a line in the first plot."""
    top = imgui.get_cursor_screen_pos()
    _legend(figure, size.x)
    corner = imgui.get_cursor_screen_pos()
    room = ImVec2(size.x, size.y - (corner.y - top.y))
    weights = np.array(figure.heights or (1.0,) * len(figure.rows), float)
    heights = room.y * weights / weights.sum()
    found, y, state.told = None, corner.y, ""
    for i, row in enumerate(figure.rows):
        for j, plot in enumerate(row):
            imgui.set_cursor_screen_pos(ImVec2(corner.x + j * room.x / len(row), y))
            cell = ImVec2(room.x / len(row), float(heights[i]))
            at = _plot(f"{name} {i} {j}", plot, cell, state, grip if i == j == 0 else None)
            if at is not None:
                found = Under(plot, i, j, *at)
        y += float(heights[i])
    imgui.set_cursor_screen_pos(ImVec2(corner.x, corner.y + room.y))
    imgui.dummy(ImVec2(0.0, 0.0))
    return found


# The legend


def _legend(figure: Figure, width: float) -> None:
    """Names with a sample of each line or mark, in as many lines as they need."""
    found: dict = {}
    for row in figure.rows:
        for plot in row:
            for layer in plot.named():
                found.setdefault(layer.name, layer)
    if not found:
        return
    draw, pixel, line = imgui.get_window_draw_list(), theme.scale(), imgui.get_text_line_height()
    corner = imgui.get_cursor_screen_pos()
    x, y = corner.x, corner.y
    for name, layer in found.items():
        sample = (18.0 if isinstance(layer, Curve) else 9.0) * pixel
        wide = sample + 4.0 * pixel + imgui.calc_text_size(name).x
        if x > corner.x and x + wide > corner.x + width:
            x, y = corner.x, y + line
        _sample(draw, layer, ImVec2(x, y + 0.5 * line), sample)
        text(draw, ImVec2(x + sample + 4.0 * pixel, y), theme.colours().dim, name)
        x += wide + 10.0 * pixel
    imgui.dummy(ImVec2(width, y - corner.y + line))


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


def _plot(name: str, plot: Plot, size: ImVec2, state: Drawn, grip: Grip | None = None) -> tuple[float, float] | None:
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
    for layer in plot.layers:
        if isinstance(layer, Map):
            _map(name, draw, shown, layer, state)
        elif isinstance(layer, Points):
            _points(layer)
    implot.push_plot_clip_rect()
    for index, layer in enumerate(plot.layers):
        if isinstance(layer, Curve):
            _curve(draw, shown, layer, (name, index), state)
        elif isinstance(layer, Bars):
            _bars(draw, shown, layer)
        elif isinstance(layer, Label):
            _label(draw, shown, layer)
    if plot.title:
        text(draw, ImVec2(shown.left + 4.0 * theme.scale(), shown.top + 2.0 * theme.scale()), theme.colours().text,
             plot.title, plate=True)
    held = _grip(draw, shown, grip) if grip is not None else False
    implot.pop_plot_clip_rect()
    implot.pop_plot_clip_rect()
    if implot.is_plot_hovered() and not held:
        mouse = implot.get_plot_mouse_pos()
        at = float(mouse.x), float(mouse.y)
        if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
            state.fitted.pop(name, None)
        _cursor(draw, shown, plot, at)
        state.told = _told(plot, *at)
    implot.end_plot()
    if at is not None and state.told and not imgui.is_mouse_dragging(imgui.MouseButton_.left):
        _tooltip(plot, state.told)
    return at


def _axes(name: str, plot: Plot, size: ImVec2, state: Drawn) -> None:
    """Labels, limits and ticks. Limits are set when they or the size change, so that wheel and drag work between."""
    key = (plot.x, plot.y, size.x, size.y)
    refit = state.fitted.get(name) != key
    roomy = size.x > theme.em(11) and size.y > theme.em(7)
    for index, axis, length, room in ((implot.ImAxis_.x1, plot.x, size.x, 3.4),
                                      (implot.ImAxis_.y1, plot.y, size.y, 1.4)):
        flags = AXIS_FLAGS | (implot.AxisFlags_.no_decorations if axis.label is None else implot.AxisFlags_.none)
        fits = roomy and axis.label is not None and imgui.calc_text_size(axis.label).x < 0.85 * length
        implot.setup_axis(index, axis.label if fits else None, flags)
        if axis.log:
            implot.setup_axis_scale(index, implot.Scale_.log10)
            values, labels = log_ticks(axis.low, axis.high, 0.8 * length, room * imgui.get_text_line_height())
            implot.setup_axis_ticks(index, values, labels, False)
        elif axis.label is not None:
            low, high = (axis.low, axis.high) if refit else state.limits[name][index == implot.ImAxis_.y1]
            values, labels = linear_ticks(low, high, 0.8 * length, room * imgui.get_text_line_height())
            implot.setup_axis_ticks(index, values, labels, False)
        implot.setup_axis_limits(index, axis.low, axis.high, implot.Cond_.always if refit else implot.Cond_.once)
    state.fitted[name] = key
    if plot.equal and refit:
        wide, high = plot.x.high - plot.x.low, plot.y.high - plot.y.low
        margin = 0.0 if plot.x.label is None else theme.em(3.0)
        scale = min((size.x - margin) / wide, (size.y - margin) / high)
        more_x, more_y = 0.5 * ((size.x - margin) / scale - wide), 0.5 * ((size.y - margin) / scale - high)
        implot.setup_axes_limits(plot.x.low - more_x, plot.x.high + more_x, plot.y.low - more_y, plot.y.high + more_y,
                                 implot.Cond_.always)
    implot.setup_finish()


def _curve(draw: imgui.ImDrawList, shown: PlotMap, curve: Curve, key: tuple, state: Drawn) -> None:
    pixel = theme.scale()
    strokes = state.memo.of((key, curve, shown, pixel), lambda: pieces(
        shown.pixels(curve.x, curve.y), *(each * pixel for each in curve.dash)))
    tint = theme.packed(colour_of(curve.tint))
    for stroke in strokes:
        draw.add_polyline(stroke, tint, curve.weight * pixel, imgui.ImDrawFlags_.none)


def _points(points: Points) -> None:
    tint, pixel = ImVec4(*colour_of(points.tint)), theme.scale()
    if points.x.size:
        implot.plot_scatter(f"##{points.name}", np.ascontiguousarray(points.x, float),
                            np.ascontiguousarray(points.y, float),
                            implot.Spec(marker=MARKERS[points.shape], marker_size=DOT * pixel, marker_line_color=tint,
                                        marker_fill_color=tint, line_weight=0.0))


def _bars(draw: imgui.ImDrawList, shown: PlotMap, bars: Bars) -> None:
    tint = theme.packed(colour_of(bars.tint))
    low = shown.pixels(bars.x - 0.5 * bars.width, np.zeros_like(bars.y))
    high = shown.pixels(bars.x + 0.5 * bars.width, bars.y)
    for (x0, y0), (x1, y1) in zip(low.tolist(), high.tolist(), strict=True):
        if y0 == y0 and y1 == y1:
            draw.add_rect_filled(ImVec2(x0, min(y0, y1)), ImVec2(max(x1, x0 + 1.0), max(y0, y1)), tint)


def _label(draw: imgui.ImDrawList, shown: PlotMap, label: Label) -> None:
    at, size, pad = shown.at(label.x, label.y), imgui.calc_text_size(label.text), 2.0 * theme.scale()
    x = {"right": at.x + pad, "left": at.x - size.x - pad}.get(label.side.split()[0], at.x - 0.5 * size.x)
    upright = label.side.split()[-1]
    y = {"above": at.y - size.y, "below": at.y}.get(upright, at.y - 0.5 * size.y)
    tint = "amber_text" if label.tint == "amber" else label.tint
    text(draw, ImVec2(x, y), colour_of(tint), label.text, plate=True)


def _map(name: str, draw: imgui.ImDrawList, shown: PlotMap, shades: Map, state: Drawn) -> None:
    """Shades from the ground to strong, and contours at the levels."""
    implot.push_colormap(_shades(theme.colours().dark))
    implot.plot_heatmap("##map", np.ascontiguousarray(shades.shades[::-1]), 0.0, 1.0, "",
                        implot.Point(shades.x[0], shades.y[0]), implot.Point(shades.x[1], shades.y[1]))
    implot.pop_colormap()
    for x0, y0, x1, y1 in state.memo.of((name, "gaps", shades, shown), lambda: _gaps(shades, shown)):
        draw.add_rect_filled(ImVec2(x0, y1), ImVec2(x1, y0), theme.packed(theme.colours().well))
    strokes = state.memo.of((name, "contours", shades, shown), lambda: [
        (level, [pieces(shown.pixels(*line.T)) for line in _contours(shades, level)]) for level in shades.levels])
    tint = theme.packed(theme.colours().ground, 0.8)
    for level, lines in strokes:
        for line in lines:
            for stroke in line:
                draw.add_polyline(stroke, tint, theme.scale(), imgui.ImDrawFlags_.none)
        if lines and lines[0] and len(shades.levels) <= NAMED:
            middle = lines[0][0][len(lines[0][0]) // 2]
            text(draw, ImVec2(middle.x, middle.y), theme.colours().text, significant(level, 2), plate=True)


def _gaps(shades: Map, shown: PlotMap) -> list[list[float]]:
    """Boxes in pixels of the runs of unknown values in each row: left, bottom, right, top."""
    rows, columns = shades.values.shape
    missing = np.pad(np.isnan(shades.values), ((0, 0), (1, 1))).astype(int)
    found = []
    for row in np.flatnonzero(missing.any(1)).tolist():
        ends = np.flatnonzero(np.diff(missing[row]))
        x = shades.x[0] + ends / columns * (shades.x[1] - shades.x[0])
        y = shades.y[0] + np.array([row, row + 1]) / rows * (shades.y[1] - shades.y[0])
        for a, b in zip(x[::2], x[1::2], strict=True):
            (left, bottom), (right, top) = shown.pixels([a, b], y)
            found.append([float(left), float(bottom), float(right), float(top)])
    return found


def _shades(dark: bool) -> int:
    """The colormap from the well of the plot to its strong colour, through the blue of glass."""
    name = f"shades {'dark' if dark else 'light'}"
    known = implot.get_colormap_index(name)
    if known >= 0:
        return known
    low, high = ((0.09, 0.10, 0.12), (0.93, 0.95, 0.97)) if dark else ((0.26, 0.30, 0.36), (0.98, 0.98, 0.98))
    middle = (0.27, 0.45, 0.62) if dark else (0.42, 0.62, 0.80)
    part = np.linspace(0.0, 1.0, SHADES)
    rows = np.column_stack([np.interp(part, (0.0, 0.5, 1.0), ends) for ends in zip(low, middle, high, strict=True)])
    packed = [imgui.color_convert_float4_to_u32(ImVec4(*row, 1.0)) for row in rows.tolist()]
    return implot.add_colormap(name, np.array(packed, np.uint32), False)


@lru_cache(maxsize=32)
def _contours(shades: Map, level: float) -> tuple[np.ndarray, ...]:
    """Polylines (n, 2) of one level."""
    from contourpy import contour_generator

    rows, columns = shades.values.shape
    x = shades.x[0] + (np.arange(columns) + 0.5) / columns * (shades.x[1] - shades.x[0])
    y = shades.y[0] + (np.arange(rows) + 0.5) / rows * (shades.y[1] - shades.y[0])
    lines: Any = contour_generator(x, y, np.ma.masked_invalid(shades.values)).lines(level)
    return tuple(lines)


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


# Under the cursor


def _cursor(draw: imgui.ImDrawList, shown: PlotMap, plot: Plot, at: tuple[float, float]) -> None:
    """A thin line where curves are read."""
    if plot.x.label is None or not any(isinstance(layer, Curve) and layer.name for layer in plot.layers):
        return
    place, tint = shown.at(*at), theme.packed(theme.colours().faint)
    ends = (ImVec2(shown.left, place.y), ImVec2(shown.right, place.y)) if plot.across else \
        (ImVec2(place.x, shown.top), ImVec2(place.x, shown.bottom))
    draw.add_line(*ends, tint, theme.scale())


def _told(plot: Plot, x: float, y: float) -> str:
    """The numbers at a place: what an area says, and each curve at this x (or this y), bars and maps."""
    lines = [layer.text for layer in plot.layers
             if isinstance(layer, Area) and layer.x[0] <= x < layer.x[1] and layer.y[0] <= y < layer.y[1]]
    if lines:
        return "\n".join(lines)
    for layer in plot.layers:
        if isinstance(layer, Map) and layer.name and layer.x[0] <= x < layer.x[1] and layer.y[0] <= y < layer.y[1]:
            rows, columns = layer.values.shape
            row = int((y - layer.y[0]) / (layer.y[1] - layer.y[0]) * rows)
            column = int((x - layer.x[0]) / (layer.x[1] - layer.x[0]) * columns)
            lines.append(f"{layer.name}   {_number(float(layer.values[row, column]))}")
    key, axis = (y, plot.y) if plot.across else (x, plot.x)
    for layer in plot.layers:
        if isinstance(layer, Curve) and layer.name and (value := read(layer, key, plot.across)) is not None:
            lines.append(f"{layer.name}   {_number(value)}")
    if lines and axis.label:
        head = f"{axis.label.split(' (')[0]} {_number(key)}{_unit(axis.label)}"
        other = plot.x if plot.across else plot.y
        if any(isinstance(layer, Map) for layer in plot.layers):
            head += f", {(other.label or '').split(' (')[0].lower()} {_number(y)}{_unit(other.label)}"
        elif other.label:
            head += f": {other.label}"
        lines.insert(0, head)
    return "\n".join(lines)


def read(curve: Curve, at: float, across: bool = False) -> float | None:
    """A curve's value at an x (at a y if `across`), by a straight line between its points; None where it is none."""
    keys, values = (curve.y, curve.x) if across else (curve.x, curve.y)
    if keys.size < 2:
        return None
    a, b = keys[:-1], keys[1:]
    held = np.flatnonzero((np.minimum(a, b) <= at) & (at <= np.maximum(a, b)) & np.isfinite(values[:-1] + values[1:]))
    if not held.size:
        return None
    i = int(held[0])
    part = 0.0 if b[i] == a[i] else (at - a[i]) / (b[i] - a[i])
    return float(values[i] + part * (values[i + 1] - values[i]))


def _number(value: float) -> str:
    return true_minus(significant(value, 3)) if math.isfinite(value) else "–"


def _unit(label: str | None) -> str:
    """The unit of an axis, from the parenthesis of its label."""
    unit = label.rsplit("(", 1)[1].rstrip(")") if label and "(" in label else ""
    return unit if unit in ("°", "%", "") else f" {unit}"


def _tooltip(plot: Plot, words: str) -> None:
    tints = {layer.name: layer.tint for layer in plot.named()}
    if imgui.begin_tooltip():
        first, *rest = words.split("\n")
        imgui.text_unformatted(first)
        for line in rest:
            tint = tints.get(line.split("   ")[0])
            if tint is not None:
                imgui.text_colored(ImVec4(*colour_of(tint)), line)
            else:
                imgui.text_disabled(line)
        imgui.end_tooltip()
