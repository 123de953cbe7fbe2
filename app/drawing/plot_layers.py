"""Layers of a plot drawn in the window: patches, curves, marks, bars, labels; maps as a texture each, with contours.

Words next to a curve or a mark stand where they touch no line, no mark and no other words.
"""

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any, Protocol

import numpy as np
from imgui_bundle import ImVec2, ImVec4, imgui, implot
from numpy.typing import NDArray

from lensbench.app.drawing import theme
from lensbench.app.drawing.plot_axes import PlotMap, pieces, simplified, text
from lensbench.app.drawing.recorded import FrameMemo
from lensbench.app.plots.plot import SIZED, Bars, Curve, Label, Map, Patch, Plot, Points, Tint, wavelength_colour
from lensbench.core.text import significant

MARKERS = {"triangle": implot.Marker_.up, "square": implot.Marker_.square, "diamond": implot.Marker_.diamond,
           "cross": implot.Marker_.cross}
CORNERS = {"triangle": (3, -0.5), "square": (4, 0.25), "diamond": (4, 0.0), "hexagon": (6, 0.0)}
ARMS = {"cross": 0.25, "plus": 0.0}     # turn of the first arm, × π; of CORNERS that of the first corner
GHOST = 0.5                     # opacity of the figure A
MARGIN = 9.0                    # pixels about a plot, within which curves are drawn
CELL = 3.0                      # pixels: words know to so many where lines run
TRIED = 40                      # positions along a curve for its words, at most
AWAY = (5.0, 9.0, 13.0, 18.0, 26.0)     # pixels from a mark to its words: the first that is free
Boxes = dict[str, tuple[float, float, float, float]]    # words: left, top, right and bottom, pixels
SIDES = ("right", "left", "right above", "right below", "above", "below", "left above", "left below")


def colour_of(tint: Tint) -> theme.Colour:
    """The colour of a tint in the theme in use."""
    if isinstance(tint, float):
        code = wavelength_colour(tint, theme.colours().dark)
        return int(code[:2], 16) / 255.0, int(code[2:4], 16) / 255.0, int(code[4:], 16) / 255.0, 1.0
    if tint.startswith("chart"):
        return theme.tints()[int(tint[5:]) % 8]
    colour: theme.Colour = getattr(theme.colours(), tint)
    return colour


def ink(tint: Tint) -> theme.Colour:
    """The colour of words about what has this tint."""
    return colour_of(f"{tint}_text" if hasattr(theme.colours(), f"{tint}_text") else "dim" if tint == "faint" else tint)


def draw_layers(draw: imgui.ImDrawList, shown: PlotMap, layers: Sequence[Any], title: str = "",
                column: float | None = None) -> Boxes:
    """Draw all patches, curves, marks, bars and labels of a plot, and its title in the corner; where words stand.

    column: of a line in pixels that is drawn above them, which words keep clear of.
    """
    paths = {id(layer): _pixels(shown, layer) for layer in layers if isinstance(layer, Curve)}
    words = Words(shown, layers, paths, column)
    if title:
        words.taken.append((shown.left, shown.top, shown.left + imgui.calc_text_size(title).x,
                            shown.top + imgui.get_text_line_height()))
    for layer in layers:
        if isinstance(layer, Patch):
            _draw_patch(draw, shown, layer)
    for layer in layers:
        if isinstance(layer, Curve):
            _draw_curve(draw, layer, paths[id(layer)])
        elif isinstance(layer, Points) and layer.size >= SIZED:
            tint = theme.packed(colour_of(layer.tint), GHOST if layer.ghost else 1.0)
            for x, y in shown.pixels(layer.x, layer.y).tolist():
                draw_mark(draw, layer.shape, ImVec2(x, y), layer.size * theme.scale(), tint, layer.turn)
        elif isinstance(layer, Bars):
            _draw_bars(draw, shown, layer)
        elif isinstance(layer, Label) and not layer.free:
            words.fixed(draw, layer)
    for layer in sorted(layers, key=lambda layer: -getattr(layer, "weight", 0.0)):
        if isinstance(layer, Curve) and layer.tag:
            words.along(draw, layer)
        elif isinstance(layer, Label) and layer.free:
            words.about(draw, layer)
    if title:
        pixel = theme.scale()
        text(draw, ImVec2(shown.left + 4.0 * pixel, shown.top + 2.0 * pixel), theme.colours().text,
             theme.shortened(title, shown.right - shown.left - 6.0 * pixel), plate=True)
    return words.boxes


def _draw_patch(draw: imgui.ImDrawList, shown: PlotMap, patch: Patch) -> None:
    corners = shown.pixels(*within(shown, patch.corners).T)
    if len(corners) > 2:
        draw.add_convex_poly_filled([ImVec2(x, y) for x, y in simplified(corners).tolist()],
                                    theme.packed(colour_of(patch.tint), patch.opacity))


def _draw_curve(draw: imgui.ImDrawList, curve: Curve, points: np.ndarray) -> None:
    """A line through pixels (n, 2), in strokes."""
    pixel = theme.scale()
    tint = theme.packed(colour_of(curve.tint), GHOST if curve.ghost else 1.0)
    for stroke in pieces(simplified(points), *(length * pixel for length in curve.dash)):
        draw.add_polyline(stroke, tint, curve.weight * pixel, imgui.ImDrawFlags_.none)


def _pixels(shown: PlotMap, curve: Curve) -> np.ndarray:
    """The points (n, 2) of a curve in pixels, NaN where it is out of sight; a straight line is cut at the edges."""
    pixels: np.ndarray
    if curve.x.size < 2:                                    # of a field that no light reaches
        return np.empty((0, 2))
    if curve.x.size > 2:
        pixels = shown.pixels(curve.x, curve.y)
        beyond = np.column_stack([pixels < (shown.left - MARGIN, shown.top - MARGIN),
                                  pixels > (shown.right + MARGIN, shown.bottom + MARGIN)])
        visible = ~(beyond[:-1] & beyond[1:]).any(1)           # stretches that are not all on one side
        pixels[~(np.append(visible, False) | np.append(False, visible))] = np.nan
        return pixels
    ends = np.column_stack([curve.x, curve.y])
    cut = within(shown, ends)
    if not len(cut):
        return cut
    pixels = shown.pixels(*cut[np.argsort(cut @ (ends[1] - ends[0]))][[0, -1]].T)
    level = pixels[0] == pixels[1]
    if level.any():                                     # an upright or a level line lies on whole pixels
        pixels[:, level] = np.floor(pixels[:, level]) + 0.5
        pixels[:, ~level] = np.clip(pixels, (shown.left, shown.top), (shown.right, shown.bottom))[:, ~level]
    return pixels


def within(shown: PlotMap, points: np.ndarray) -> np.ndarray:
    """The convex outline or the straight line (n, 2) cut at the edges of a plot of linear axes (Sutherland-Hodgman).

    What lies far outside would lose its direction in pixels.
    """
    if shown.log or shown.log_y:
        return points
    ends = sorted((shown.x0, shown.x1)), sorted((shown.y0, shown.y1))
    for axis, sign, edge in ((0, 1.0, ends[0][0]), (0, -1.0, ends[0][1]), (1, 1.0, ends[1][0]), (1, -1.0, ends[1][1])):
        inside, cut = sign * (points[:, axis] - edge), []
        for i in range(len(points)):
            before, now = inside[i - 1], inside[i]
            if before * now < 0.0:
                cut.append(points[i - 1] + before / (before - now) * (points[i] - points[i - 1]))
            if now >= 0.0:
                cut.append(points[i])
        points = np.array(cut).reshape(-1, 2)
    return points


def draw_mark(draw: imgui.ImDrawList, shape: str, centre: ImVec2, size: float, tint: int,
              clockwise: float = 0.0) -> None:
    """A mark, `size` pixels from its middle to its border; shape and turn (radians): as of Points."""
    if shape == "ring":
        draw.add_circle(centre, size, tint, 0, 2.0 * theme.scale())
    elif shape == "circle":
        draw.add_circle_filled(centre, size, tint)
    elif shape in ARMS:
        for turn in (ARMS[shape], ARMS[shape] + 0.5):
            arm = size * np.exp(1j * np.pi * turn)
            draw.add_line(ImVec2(centre.x - arm.real, centre.y - arm.imag),
                          ImVec2(centre.x + arm.real, centre.y + arm.imag), tint, 2.0 * theme.scale())
    else:
        count, turn = CORNERS[shape]
        corners = 1.2 * size * np.exp(1j * (clockwise + np.pi * (turn + 2.0 * np.arange(count) / count)))
        draw.add_convex_poly_filled([ImVec2(centre.x + c.real, centre.y + c.imag) for c in corners], tint)


def draw_points(points: Points) -> None:
    """Many small marks, all by one call."""
    red, green, blue, alpha = colour_of(points.tint)
    tint, pixel = ImVec4(red, green, blue, GHOST * alpha if points.ghost else alpha), theme.scale()
    if points.x.size:
        implot.plot_scatter(f"##{points.name} {points.ghost} {points.surface} {points.shape}",
                            np.ascontiguousarray(points.x, float), np.ascontiguousarray(points.y, float),
                            implot.Spec(marker=MARKERS[points.shape], marker_size=points.size * pixel,
                                        marker_line_color=tint, marker_fill_color=tint,
                                        line_weight=pixel if points.shape in ARMS else 0.0))


def _draw_bars(draw: imgui.ImDrawList, shown: PlotMap, bars: Bars) -> None:
    """Bars; those of unknown height are left out."""
    tint = theme.packed(colour_of(bars.tint), GHOST if bars.ghost else 1.0)
    low = shown.pixels(bars.x - 0.5 * bars.width, np.zeros_like(bars.y))
    high = shown.pixels(bars.x + 0.5 * bars.width, bars.y)
    for (x0, y0), (x1, y1) in zip(low.tolist(), high.tolist(), strict=True):
        if y0 == y0 and y1 == y1:
            draw.add_rect_filled(ImVec2(x0, min(y0, y1)), ImVec2(max(x1, x0 + 1.0), max(y0, y1)), tint)


class Words:
    """The words of a plot: what they must not touch, in pixels, and where each may stand."""

    def __init__(self, shown: PlotMap, layers: Sequence[Any], paths: dict[int, np.ndarray],
                 column: float | None = None):
        self._shown, self._pad = shown, 2.0 * theme.scale()
        self.boxes: Boxes = {}                                          # of the words that were written
        self.taken: list[tuple[float, float, float, float]] = []       # and of all else that they must not touch
        self._above: list[tuple[float, float, float]] = []             # labels above their places: left, right, top
        self._lines: dict[int, np.ndarray] = {}                        # the points of each curve, close together
        lines = [np.zeros((0, 2))]
        if any(getattr(layer, "tag", "") or getattr(layer, "free", False) for layer in layers):
            self._lines = {key: _dense(points) for key, points in paths.items()}
            lines += [self._lines[id(layer)] for layer in layers if isinstance(layer, Curve) and not (
                layer.x.size == 2 and layer.x[0] == layer.x[1])]           # words may hide a bit of an upright line
            for layer in layers:
                if isinstance(layer, Points) and layer.size >= SIZED:
                    half = (layer.size + 2.5) * theme.scale()
                    self.taken += [(x - half, y - half, x + half, y + half)
                                   for x, y in shown.pixels(layer.x, layer.y).tolist()]
        if column is not None:
            lines.append(_dense(np.array([[column, shown.top], [column, shown.bottom]])))
        self._counts = _counted(np.concatenate(lines) - (shown.left, shown.top),
                                (shown.right - shown.left, shown.bottom - shown.top))

    def fixed(self, draw: imgui.ImDrawList, label: Label) -> None:
        """Small text on a plate next to its place, moved into the plot where its end would be cut.

        One above its place is moved up over those before it that it would touch.
        """
        shown, pad, size = self._shown, self._pad, imgui.calc_text_size(label.text)
        point = shown.at(label.x, label.y)
        if not (shown.left <= point.x <= shown.right and shown.top <= point.y <= shown.bottom):
            return
        x, y = _corner(label.side, point, size, pad, 0.0)
        x, y = max(min(x, shown.right - size.x - pad), shown.left + pad), max(min(y, shown.bottom - size.y), shown.top)
        if label.side.split()[-1] == "above":
            for left, right, top in self._above:
                if x < right + pad and left < x + size.x + pad and abs(y - top) < size.y:
                    y = top - size.y
            y = max(y, shown.top)
            self._above.append((x, x + size.x, y))
        self._write(draw, label.text, label.tint, ImVec2(x, y))

    def about(self, draw: imgui.ImDrawList, label: Label) -> None:
        """Words about a mark: on their own side of it, else on the first that is free; lines may run below them."""
        shown, pixel = self._shown, theme.scale()
        point, size = self._shown.at(label.x, label.y), imgui.calc_text_size(label.text)
        sides = (label.side, *(side for side in SIDES if side != label.side))
        corners = ((*_corner(side, point, size, away * pixel, away * pixel), side) for away in AWAY for side in sides)
        self._first_free(draw, label.text, label.tint, (
            (min(max(x, shown.left + pixel), shown.right - size.x - pixel) if side in ("above", "below") else x, y)
            for x, y, side in corners), clear=False)

    def along(self, draw: imgui.ImDrawList, curve: Curve) -> None:
        """The tag of a curve, from its end backwards: above it, below it, or next to it."""
        shown = self._shown
        words = theme.shortened(curve.tag, shown.right - shown.left - 8.0 * self._pad)
        size = imgui.calc_text_size(words)
        points = self._lines[id(curve)]
        inside = (points >= (shown.left - 1.0, shown.top - 1.0)).all(1) & (points <= (shown.right, shown.bottom)).all(1)
        points = points[inside][::-1]
        every = max(int(6.0 / CELL), -(-len(points) // TRIED))
        self._first_free(draw, words, curve.tint, (
            _corner(side, ImVec2(x, y), size, pad, 0.5 * self._pad) for x, y in points[::every].tolist()
            for side, pad in (("left above", 0.0), ("left below", 0.0), ("right", 2.0 * self._pad),
                              ("left", 2.0 * self._pad))))

    def _first_free(self, draw: imgui.ImDrawList, words: str, tint: Tint,
                    corners: Iterator[tuple[float, float]], clear: bool = True) -> None:
        """Write words at the first corner where they touch nothing; clear: of lines, too."""
        size = imgui.calc_text_size(words)
        free = next((corner for corner in corners if self._is_free(*corner, size, clear)), None)
        if free is not None:
            self._write(draw, words, tint, ImVec2(*free))

    def _is_free(self, x: float, y: float, size: ImVec2, clear: bool) -> bool:
        """Whether a text with this corner lies in the plot and touches nothing."""
        shown, pixel = self._shown, 0.5 * self._pad
        right, bottom = x + size.x, y + size.y
        if x < shown.left + pixel or right > shown.right - pixel or y < shown.top or bottom > shown.bottom:
            return False
        if any(x < r + pixel and right > l - pixel and y < b and bottom > t for l, t, r, b in self.taken):
            return False
        if not clear:
            return True
        left, right = int((x - shown.left) / CELL) + 1, int((right - shown.left) / CELL)
        top, bottom = int((y - shown.top) / CELL) + 1, int((bottom - shown.top) / CELL)
        counts = self._counts
        return bool(counts[bottom, right] - counts[top, right] - counts[bottom, left] + counts[top, left] == 0)

    def _write(self, draw: imgui.ImDrawList, words: str, tint: Tint, corner: ImVec2) -> None:
        size = imgui.calc_text_size(words)
        box = self.boxes[words] = corner.x, corner.y, corner.x + size.x, corner.y + size.y
        self.taken.append(box)
        text(draw, corner, ink(tint), words, plate=True)


def _corner(side: str, point: ImVec2, size: ImVec2, pad: float, rise: float) -> tuple[float, float]:
    """The upper left corner of a text on a side of a place, `pad` pixels next to it and `rise` above or below."""
    across, upright = side.split()[0], side.split()[-1]
    x = {"right": point.x + pad, "left": point.x - size.x - pad}.get(across, point.x - 0.5 * size.x)
    return x, {"above": point.y - size.y - rise, "below": point.y + rise}.get(upright, point.y - 0.5 * size.y)


def _counted(points: np.ndarray, size: tuple[float, float]) -> NDArray[np.int64]:
    """How many points (n, 2) of a plot of this size in pixels lie above and left of each corner of its cells."""
    across, down = (int(side / CELL) + 2 for side in size)
    places = np.floor(points / CELL)
    places = places[((places >= 0) & (places < (across, down))).all(1)].astype(int)
    cells = np.bincount(places[:, 1] * across + places[:, 0], minlength=across * down).reshape(down, across)
    return np.pad(cells.cumsum(0).cumsum(1), ((1, 0), (1, 0)))


def _dense(points: np.ndarray) -> np.ndarray:
    """Points at most CELL pixels apart along a curve (n, 2)."""
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < 2:
        return points
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    marks = np.linspace(0.0, lengths[-1], min(int(lengths[-1] / CELL) + 2, 4000))
    return np.column_stack([np.interp(marks, lengths, coordinate) for coordinate in points.T])


SHADES = 1024
VALUE_PLACES = (0.5, 0.25, 0.75, 0.1, 0.9)      # along a contour, for its value: the first that is free
NAMED = 6                       # levels of a map, at most, that have their values on the contours


class Pictures(Protocol):
    """The textures of maps between frames; `begin_frame` comes before those of a frame."""

    def begin_frame(self) -> None:
        """Release the textures of maps that the last frame did not draw."""

    def texture(self, name: str, picture: NDArray[np.uint8]) -> int:
        """The GL name of the texture of a map's picture (h, w, 4)."""


def draw_map(name: str, draw: imgui.ImDrawList, shown: PlotMap, shades: Map, memo: FrameMemo,
             pictures: Pictures) -> None:
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
            for fraction in VALUE_PLACES:
                point = stroke[int(fraction * (len(stroke) - 1))]
                inside = shown.left <= point.x <= shown.right - size.x and shown.top <= point.y <= shown.bottom - size.y
                if inside and all(abs(point.x - x) > 0.5 * (size.x + wide) + 4.0 or abs(point.y - y) > size.y
                                  for x, y, wide in taken):
                    text(draw, ImVec2(point.x, point.y), theme.colours().text, value, plate=True)
                    taken.append((point.x, point.y, size.x))
                    break


def on_pixels(shades: Map, shown: PlotMap) -> tuple[np.ndarray, tuple[float, float], tuple[float, float]]:
    """The shades of a map, the top row first, and its lower left and its upper right corner in the plot.

    The graphics card interpolates between samples. Where there are more of them than pixels, means over whole pixels
    take their place: those that a pixel happens to show would make a moiré. A map with gaps keeps its samples.
    """
    values, ends = shades.shades, shown.pixels(shades.x, shades.y)
    corners = [shades.x, shades.y]
    if not np.isnan(values).any():
        for index, (start, end) in enumerate(ends.T.tolist()):
            axis, size = 1 - index, abs(end - start)
            count, (low, high) = values.shape[axis], corners[index]
            if count > size:
                edges = round(start) + math.copysign(1.0, end - start) * np.arange(max(round(size), 1) + 1)
                parts = (edges - start) / math.copysign(max(size, 1.0), end - start)
                values = np.moveaxis(_averaged(np.moveaxis(values, axis, 0), parts * count), 0, axis)
                corners[index] = low + float(parts[0]) * (high - low), low + float(parts[-1]) * (high - low)
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
    fractions = np.linspace(0.0, 1.0, SHADES)
    rows = [np.interp(fractions, (0.0, 0.5, 1.0), ends) for ends in zip(low, middle, high, strict=True)]
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


def draw_cursor(draw: imgui.ImDrawList, shown: PlotMap, plot: Plot, position: tuple[float, float]) -> None:
    """A thin line where curves are read."""
    if plot.x.label is None or plot.equal or not any(isinstance(layer, Curve) and layer.name for layer in plot.layers):
        return
    point, tint = shown.at(*position), theme.packed(theme.colours().faint)
    ends = (ImVec2(shown.left, point.y), ImVec2(shown.right, point.y)) if plot.across else \
        (ImVec2(point.x, shown.top), ImVec2(point.x, shown.bottom))
    draw.add_line(*ends, tint, theme.scale())


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
