"""Layers of a plot drawn in the window: curves, marks, bars, labels."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from imgui_bundle import ImVec2, ImVec4, imgui, implot

from lensbench.app.state.analysis.figure import Bars, Curve, Label, Points, Tint, wavelength_colour
from lensbench.app.widgets import theme
from lensbench.app.widgets.plot_axes import PlotMap, pieces, text

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
