"""The numbers under the cursor of a plot, and the tooltip that shows them.

Layers of a plot drawn in the window: curves, marks, bars, labels.

Maps of a plot drawn in the window: shades, as one texture each, and contours with their values.
"""

import math
from collections.abc import Iterable
from functools import lru_cache
from typing import Any

import numpy as np
from imgui_bundle import ImVec2, ImVec4, imgui, implot
from numpy.typing import NDArray

from lensbench.app.display.small_textures import SmallTextures
from lensbench.app.drawing import theme
from lensbench.app.drawing.plot_axes import PlotMap, pieces, text
from lensbench.app.drawing.recorded import FrameMemo
from lensbench.app.plots.plot import Area, Bars, Curve, Label, Map, Plot, Points, Tint, wavelength_colour
from lensbench.core.text import significant, true_minus

MARKERS = {"triangle": implot.Marker_.up, "square": implot.Marker_.square, "diamond": implot.Marker_.diamond}
DOT = 1.3                       # half a mark of a point, pixels
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


SHADES = 1024
VALUE_PLACES = (0.5, 0.25, 0.75, 0.1, 0.9)      # along a contour, for its value: the first that is free
NAMED = 6                       # levels of a map, at most, that have their values on the contours


class MapPictures:
    """The pictures of maps between frames, each a texture. Call `begin_frame` before those of a frame."""

    def __init__(self) -> None:
        self._drawn: dict[str, NDArray[np.uint8]] = {}          # in this frame, or until it begins in the last one
        self._textures = SmallTextures(self._drawn)

    def begin_frame(self) -> None:
        """Release the textures of maps that the last frame did not draw."""
        self._textures.begin_frame()
        self._drawn.clear()

    def texture(self, name: str, picture: NDArray[np.uint8]) -> int:
        """The GL name of a map's texture, made again where another picture (h, w, 4) has taken the place of the last.

        name: of the map.
        """
        self._drawn[name] = picture
        found = self._textures.of(name)
        assert found is not None
        return found[0]


def draw_map(name: str, draw: imgui.ImDrawList, shown: PlotMap, shades: Map, memo: FrameMemo,
             pictures: MapPictures) -> None:
    """Shades from the ground to strong, and contours at the levels.

    name: of the map among those of `memo` and `pictures`.
    """
    dark, ground = theme.colours().dark, theme.colours().well
    values, lower, upper = memo.of((name, "shades", shades, shown), lambda: on_pixels(shades, shown))
    pixels = memo.of((name, "picture", shades, shown, dark), lambda: picture(values, dark, ground))
    implot.plot_image("##map", imgui.ImTextureRef(pictures.texture(name, pixels)), implot.Point(*lower),
                      implot.Point(*upper))
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

    The graphics card interpolates between samples. Where there are more of them than pixels, means over whole pixels
    take their place: those that a pixel happens to show would make a moiré. A map with gaps keeps its samples.
    """
    values, ends = shades.shades, shown.pixels(shades.x, shades.y)
    corners = [shades.x, shades.y]
    if not np.isnan(values).any():
        for place, (start, end) in enumerate(ends.T.tolist()):
            axis, size = 1 - place, abs(end - start)
            count, (low, high) = values.shape[axis], corners[place]
            if count > size:
                edges = round(start) + math.copysign(1.0, end - start) * np.arange(max(round(size), 1) + 1)
                parts = (edges - start) / math.copysign(max(size, 1.0), end - start)
                values = np.moveaxis(_averaged(np.moveaxis(values, axis, 0), parts * count), 0, axis)
                corners[place] = low + float(parts[0]) * (high - low), low + float(parts[-1]) * (high - low)
    (left, right), (bottom, top) = corners
    return values[::-1], (left, bottom), (right, top)


def _averaged(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Means (k, m) of the rows of values (n, m) from edge to edge (k + 1,), in rows from the first one's beginning."""
    total = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, 0)])
    edges = np.clip(edges, 0.0, len(values))
    low = np.minimum(edges.astype(int), len(values) - 1)
    until = total[low] + (edges - low)[:, None] * values[low]
    return np.diff(until, axis=0) / np.maximum(np.diff(edges), 1e-9)[:, None]


def picture(shades: np.ndarray, dark: bool, unknown: theme.Colour) -> NDArray[np.uint8]:
    """The colours (h, w, 4) of shades (h, w) from 0 to 1; NaN has the colour `unknown`."""
    places = np.nan_to_num(shades * (SHADES - 1) + 0.5, nan=SHADES).astype(np.uint16)
    return _colours(dark, unknown)[places]


@lru_cache(maxsize=4)
def _colours(dark: bool, unknown: theme.Colour) -> NDArray[np.uint8]:
    """Colours (SHADES, 4) from the well of a plot to its strong colour, through the blue of glass; then `unknown`."""
    low, high = ((0.09, 0.10, 0.12), (0.93, 0.95, 0.97)) if dark else ((0.26, 0.30, 0.36), (0.98, 0.98, 0.98))
    middle = (0.27, 0.45, 0.62) if dark else (0.42, 0.62, 0.80)
    part = np.linspace(0.0, 1.0, SHADES)
    rows = [np.interp(part, (0.0, 0.5, 1.0), ends) for ends in zip(low, middle, high, strict=True)]
    colours = np.vstack([np.column_stack([*rows, np.ones(SHADES)]), unknown])
    return np.round(255.0 * colours).astype(np.uint8)


@lru_cache(maxsize=32)
def _contours(shades: Map, level: float) -> tuple[np.ndarray, ...]:
    """Polylines (n, 2) of one level."""
    from contourpy import contour_generator

    rows, columns = shades.values.shape
    x = shades.x[0] + (np.arange(columns) + 0.5) / columns * (shades.x[1] - shades.x[0])
    y = shades.y[0] + (np.arange(rows) + 0.5) / rows * (shades.y[1] - shades.y[0])
    lines: Any = contour_generator(x, y, np.ma.masked_invalid(shades.values)).lines(level)
    return tuple(lines)


def draw_cursor(draw: imgui.ImDrawList, shown: PlotMap, plot: Plot, at: tuple[float, float]) -> None:
    """A thin line where curves are read."""
    if plot.x.label is None or plot.equal or not any(isinstance(layer, Curve) and layer.name for layer in plot.layers):
        return
    place, tint = shown.at(*at), theme.packed(theme.colours().faint)
    ends = (ImVec2(shown.left, place.y), ImVec2(shown.right, place.y)) if plot.across else \
        (ImVec2(place.x, shown.top), ImVec2(place.x, shown.bottom))
    draw.add_line(*ends, tint, theme.scale())


def told(plot: Plot, x: float, y: float) -> str:
    """The numbers at a place: what an area says, or each curve at this x (or this y) and maps; and those of A."""
    if plot.words is not None:
        return plot.words(x, y)
    lines = [layer.text for layer in plot.layers
             if isinstance(layer, Area) and layer.x[0] <= x < layer.x[1] and layer.y[0] <= y < layer.y[1]]
    if lines:
        return "\n".join(lines)
    other = {layer.name: value for layer in plot.layers if isinstance(layer, Curve | Map) and layer.ghost
             and (value := _value(layer, plot, x, y)) is not None}
    mapped = any(isinstance(layer, Map) for layer in plot.layers)
    read_on = plot.x if plot.across else plot.y         # the axis of the curves' values
    for layer in plot.layers:
        if isinstance(layer, Map | Curve) and layer.name and not layer.ghost and layer.surface is None \
                and (value := _value(layer, plot, x, y)) is not None:
            unit = _unit(read_on.label) if mapped and isinstance(layer, Curve) else ""
            lines.append(f"{layer.name}   {_number(value)}{unit}{_beside(value, other.get(layer.name))}")
    if lines and plot.x.label and plot.y.label:
        names = [label.split(" (")[0] for label in (plot.x.label, plot.y.label)]
        places = [f"{name} {_number(at)}{_unit(axis.label)}" for name, axis, at in zip(
            names, (plot.x, plot.y), (x, y), strict=True) if mapped or axis is not read_on]
        lines.insert(0, ", ".join(places) if mapped else f"{places[0]}: {read_on.label}")
    return "\n".join(lines)


def _value(layer: Curve | Map, plot: Plot, x: float, y: float) -> float | None:
    """The value of a layer at a place; None where it has none."""
    if isinstance(layer, Curve):
        return read(layer, y if plot.across else x, plot.across)
    if not (layer.name and layer.x[0] <= x < layer.x[1] and layer.y[0] <= y < layer.y[1]):
        return None
    rows, columns = layer.values.shape
    row = int((y - layer.y[0]) / (layer.y[1] - layer.y[0]) * rows)
    column = int((x - layer.x[0]) / (layer.x[1] - layer.x[0]) * columns)
    return float(layer.values[row, column])


def _beside(value: float, other: float | None) -> str:
    """The value of A after that of B, and B less A."""
    if other is None or not (math.isfinite(other) and math.isfinite(value)):
        return ""
    return f"   A {_number(other)}   {true_minus(significant(value - other, 2, signed=True))}"


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


def unit_of(label: str | None) -> str:
    """The unit of an axis, from the parenthesis of its label; "" for a number."""
    return label.rsplit("(", 1)[1].rstrip(")") if label and "(" in label else ""


def _unit(label: str | None) -> str:
    """The unit of an axis after a number."""
    unit = unit_of(label)
    return unit if unit in ("°", "%", "") else f" {unit}"


def tooltip(plot: Plot, words: str) -> None:
    """Show the numbers, each line in the tint of its curve."""
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
