"""Layers of a plot drawn in the window: curves, marks, bars, labels, maps with contours."""

import math
from collections.abc import Iterable
from functools import lru_cache
from math import ceil, floor
from typing import Any

import numpy as np
from imgui_bundle import ImVec2, ImVec4, imgui, implot

from lensbench.app.state.analysis.figure import Bars, Curve, Label, Map, Points, Tint, wavelength_colour
from lensbench.app.widgets import theme
from lensbench.app.widgets.memo import FrameMemo
from lensbench.app.widgets.plot_axes import PlotMap, pieces, text
from lensbench.kernels.figures import significant

MARKERS = {"triangle": implot.Marker_.up, "square": implot.Marker_.square, "diamond": implot.Marker_.diamond}
DOT = 1.3                       # half a mark of a point, pixels
SHADES = 64
FEW = 64                        # samples across a map, up to which they are interpolated
VALUE_PLACES = (0.5, 0.25, 0.75, 0.1, 0.9)      # along a contour, for its value: the first that is free
NAMED = 6                       # levels of a map, at most, that have their values on the contours
GHOST = 0.5                     # opacity of the figure A


def colour_of(tint: Tint) -> theme.Colour:
    """The colour of a tint in the theme in use."""
    if isinstance(tint, float):
        code = wavelength_colour(tint, theme.colours().dark)
        return int(code[:2], 16) / 255.0, int(code[2:4], 16) / 255.0, int(code[4:], 16) / 255.0, 1.0
    if tint.startswith("chart"):
        return theme.tints()[int(tint[5:]) % 8]
    colour: theme.Colour = getattr(theme.colours(), tint)
    return colour


def draw_layers(draw: imgui.ImDrawList, shown: PlotMap, layers: Iterable[Any], title: str) -> None:
    """All curves, bars and labels of a plot, and its title in the corner."""
    above: list[tuple[float, float, float]] = []        # labels above their places: left, right, top
    for layer in layers:
        if isinstance(layer, Curve):
            _draw_curve(draw, shown, layer)
        elif isinstance(layer, Bars):
            _draw_bars(draw, shown, layer)
        elif isinstance(layer, Label):
            _draw_label(draw, shown, layer, above)
    if title:
        pixel = theme.scale()
        text(draw, ImVec2(shown.left + 4.0 * pixel, shown.top + 2.0 * pixel), theme.colours().text,
             theme.shortened(title, shown.right - shown.left - 6.0 * pixel), plate=True)


def _draw_curve(draw: imgui.ImDrawList, shown: PlotMap, curve: Curve) -> None:
    """A line in strokes of pixels."""
    pixel = theme.scale()
    tint = theme.packed(colour_of(curve.tint), GHOST if curve.ghost else 1.0)
    for stroke in pieces(shown.pixels(curve.x, curve.y), *(each * pixel for each in curve.dash)):
        draw.add_polyline(stroke, tint, curve.weight * pixel, imgui.ImDrawFlags_.none)


def draw_points(points: Points) -> None:
    """Marks, all by one call."""
    red, green, blue, alpha = colour_of(points.tint)
    tint, pixel = ImVec4(red, green, blue, GHOST * alpha if points.ghost else alpha), theme.scale()
    if points.x.size:
        implot.plot_scatter(f"##{points.name} {points.ghost} {points.surface}", np.ascontiguousarray(points.x, float),
                            np.ascontiguousarray(points.y, float),
                            implot.Spec(marker=MARKERS[points.shape], marker_size=DOT * pixel, marker_line_color=tint,
                                        marker_fill_color=tint, line_weight=0.0))


def _draw_bars(draw: imgui.ImDrawList, shown: PlotMap, bars: Bars) -> None:
    """Bars; those of unknown height are left out."""
    tint = theme.packed(colour_of(bars.tint), GHOST if bars.ghost else 1.0)
    low = shown.pixels(bars.x - 0.5 * bars.width, np.zeros_like(bars.y))
    high = shown.pixels(bars.x + 0.5 * bars.width, bars.y)
    for (x0, y0), (x1, y1) in zip(low.tolist(), high.tolist(), strict=True):
        if y0 == y0 and y1 == y1:
            draw.add_rect_filled(ImVec2(x0, min(y0, y1)), ImVec2(max(x1, x0 + 1.0), max(y0, y1)), tint)


def _draw_label(draw: imgui.ImDrawList, shown: PlotMap, label: Label, above: list[tuple[float, float, float]]) -> None:
    """Small text on a plate beside its place, moved into the plot where its end would be cut.

    One above its place is moved up over those in `above` that it would touch.
    """
    at, size, pad = shown.at(label.x, label.y), imgui.calc_text_size(label.text), 2.0 * theme.scale()
    if not (shown.left <= at.x <= shown.right and shown.top <= at.y <= shown.bottom):
        return
    x = {"right": at.x + pad, "left": at.x - size.x - pad}.get(label.side.split()[0], at.x - 0.5 * size.x)
    upright = label.side.split()[-1]
    y = {"above": at.y - size.y, "below": at.y}.get(upright, at.y - 0.5 * size.y)
    x, y = max(min(x, shown.right - size.x - pad), shown.left + pad), max(min(y, shown.bottom - size.y), shown.top)
    if upright == "above":
        for left, right, top in above:
            if x < right + pad and left < x + size.x + pad and abs(y - top) < size.y:
                y = top - size.y
        y = max(y, shown.top)
        above.append((x, x + size.x, y))
    tint = "amber_text" if label.tint == "amber" else label.tint
    text(draw, ImVec2(x, y), colour_of(tint), label.text, plate=True)


def draw_map(name: str, draw: imgui.ImDrawList, shown: PlotMap, shades: Map, memo: FrameMemo) -> None:
    """Shades from the ground to strong, and contours at the levels."""
    implot.push_colormap(_shades(theme.colours().dark))
    values, lower, upper = memo.of((name, "cells", shades, shown), lambda: on_pixels(shades, shown))
    implot.plot_heatmap("##map", values, 0.0, 1.0, "", implot.Point(*lower), implot.Point(*upper))
    implot.pop_colormap()
    for x0, y0, x1, y1 in memo.of((name, "gaps", shades, shown), lambda: _gaps(shades, shown)):
        draw.add_rect_filled(ImVec2(x0, y1), ImVec2(x1, y0), theme.packed(theme.colours().well))
    strokes = memo.of((name, "contours", shades, shown), lambda: [
        (level, [pieces(shown.pixels(*line.T)) for line in _contours(shades, level)]) for level in shades.levels])
    tint = theme.packed(theme.colours().ground, 0.8)
    taken: list[tuple[float, float, float]] = []        # places and widths of values
    for level, lines in strokes:
        for line in lines:
            for stroke in line:
                draw.add_polyline(stroke, tint, theme.scale(), imgui.ImDrawFlags_.none)
        if lines and lines[0] and len(shades.levels) <= NAMED:
            value, stroke = significant(level, 2), lines[0][0]
            size = imgui.calc_text_size(value)
            for part in VALUE_PLACES:
                at = stroke[int(part * (len(stroke) - 1))]
                inside = (shown.left <= at.x <= shown.right - size.x) and (shown.top <= at.y <= shown.bottom - size.y)
                if inside and all(abs(at.x - x) > 0.5 * (size.x + wide) + 4.0 or abs(at.y - y) > size.y
                                  for x, y, wide in taken):
                    text(draw, ImVec2(at.x, at.y), theme.colours().text, value, plate=True)
                    taken.append((at.x, at.y, size.x))
                    break


def on_pixels(shades: Map, shown: PlotMap) -> tuple[np.ndarray, tuple[float, float], tuple[float, float]]:
    """The shades of a map, the top row first, and its lower left and its upper right corner in the plot.

    The shades are those of cells of whole pixels, interpolated between few samples and averaged over more samples than
    pixels: samples of one and of two pixels side by side, or those that a pixel happens to show, would make a grid. A
    map with gaps keeps its samples.
    """
    values, ends = shades.shades, shown.pixels(shades.x, shades.y)
    sizes = np.maximum(np.abs(ends[1] - ends[0]), 1.0)[::-1]
    if np.isnan(shades.values).any() or max(values.shape) > FEW and (values.shape <= sizes).all():
        return np.ascontiguousarray(values[::-1]), (shades.x[0], shades.y[0]), (shades.x[1], shades.y[1])
    corners = []
    for (low, high), (start, end), axis in ((shades.x, ends[:, 0], 1), (shades.y, ends[:, 1], 0)):
        count, size = values.shape[axis], max(abs(end - start), 1.0)
        step = max(int(size / count), 1)
        edges = round(start) + math.copysign(step, end - start) * np.arange(max(round(size) // step, 1) + 1)
        parts = (edges - start) / math.copysign(size, end - start)
        turned = np.moveaxis(values, axis, 0)
        turned = _averaged(turned, parts * count) if count > size else \
            _between(turned, 0.5 * (parts[1:] + parts[:-1]) * count - 0.5)
        values = np.moveaxis(turned, 0, axis)
        corners.append((low + float(parts[0]) * (high - low), low + float(parts[-1]) * (high - low)))
    (left, right), (bottom, top) = corners
    return np.ascontiguousarray(values[::-1]), (left, bottom), (right, top)


def _between(values: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Rows (k, m) of values (n, m) at places (k,), interpolated between neighbours, beyond the ends the last ones."""
    at = np.clip(at, 0.0, len(values) - 1.0)
    low = np.minimum(at.astype(int), max(len(values) - 2, 0))
    part, high = (at - low)[:, None], np.minimum(low + 1, len(values) - 1)
    return values[low] * (1.0 - part) + values[high] * part


def _averaged(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Means (k, m) of the rows of values (n, m) from edge to edge (k + 1,), in rows from the first one's beginning."""
    total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, 0)])
    edges = np.clip(edges, 0.0, len(values))
    return np.diff(_between(total, edges), axis=0) / np.maximum(np.diff(edges), 1e-9)[:, None]


def _gaps(shades: Map, shown: PlotMap) -> list[list[float]]:
    """Boxes in pixels of the runs of unknown values in each row: left, bottom, right, top.

    They end at whole pixels, and a pixel beyond the map, so that the shades are covered between and around them.
    """
    rows, columns = shades.values.shape
    missing = np.pad(np.isnan(shades.values), ((0, 0), (1, 1))).astype(int)
    found = []
    for row in np.flatnonzero(missing.any(1)).tolist():
        ends = np.flatnonzero(np.diff(missing[row]))
        x = shades.x[0] + ends / columns * (shades.x[1] - shades.x[0])
        y = shades.y[0] + np.array([row, row + 1]) / rows * (shades.y[1] - shades.y[0])
        for a, b, low, high in zip(ends[::2], ends[1::2], x[::2], x[1::2], strict=True):
            (left, bottom), (right, top) = shown.pixels([low, high], y)
            found.append([floor(left) - float(a == 0), ceil(bottom) + float(row == 0),
                          ceil(right) + float(b == columns), floor(top) - float(row == rows - 1)])
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
