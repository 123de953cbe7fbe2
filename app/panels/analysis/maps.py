"""Maps of a plot drawn in the window: shades, as one texture each, and contours with their values."""

import math
from functools import lru_cache
from typing import Any

import numpy as np
from imgui_bundle import ImVec2, imgui, implot
from numpy.typing import NDArray

from lensbench.app.display.small_textures import SmallTextures
from lensbench.app.state.analysis.figure import Map
from lensbench.app.widgets import theme
from lensbench.app.widgets.memo import FrameMemo
from lensbench.app.widgets.plot_axes import PlotMap, pieces, text
from lensbench.kernels.figures import significant

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
