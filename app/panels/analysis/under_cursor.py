"""The numbers under the cursor of a plot, and the tooltip that shows them."""

import math

import numpy as np
from imgui_bundle import ImVec2, ImVec4, imgui

from lensbench.app.panels.analysis.layers import colour_of
from lensbench.app.state.analysis.figure import Area, Curve, Map, Plot
from lensbench.app.widgets import theme
from lensbench.app.widgets.plot_axes import PlotMap
from lensbench.kernels.figures import significant, true_minus


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
