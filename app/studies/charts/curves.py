"""Panels of curves, such as error against samples or seconds: values, sheet, table and JSON."""

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lensbench.app.studies.charts.table import aligned, figure_text
from lensbench.app.studies.plotting import COLOURS, DIM, FAINT, INK, PAPER, look, plot, save, sheet, tick_finely

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ACROSS = 3                      # panels in a row
SIZE = (3.2, 2.75)              # inches, of one panel; a single panel is half as large again
DOTS = (1.0, 2.2)


@dataclass(frozen=True)
class Curve:
    """Points (x, y) of one method, and its figures by name and unit, such as "to 1 %, s".

    tint: a key of `plotting.COLOURS`. dotted: a dotted line, for a variant of the method with the same tint.
    """

    name: str
    tint: str
    points: tuple[tuple[float, float], ...]
    figures: dict[str, float] = field(default_factory=dict)
    dotted: bool = False


@dataclass(frozen=True)
class Panel:
    """Curves on common axes, both logarithmic; x and y: their labels, with units.

    levels: values of horizontal lines, with labels. ticks: of x, if few values are possible.
    """

    key: str
    title: str
    x: str
    y: str
    curves: tuple[Curve, ...]
    levels: tuple[tuple[float, str], ...] = ()
    ticks: tuple[float, ...] = ()
    conditions: str = ""


def draw_panels(panels: list[Panel], path: Path, title: str, measured: str = "") -> None:
    """Write panels into one file, with one legend; ExportError where it cannot be written.

    measured: place and date of the measurement, printed on the sheet.
    """
    across = 2 if len(panels) == 4 else min(len(panels), ACROSS)
    rows, larger = math.ceil(len(panels) / across), 1.5 if len(panels) == 1 else 1.0
    named = {curve.name: curve for panel in panels for curve in panel.curves}
    with look():
        figure = sheet(max(larger * SIZE[0] * across, 6.4), larger * SIZE[1] * rows + 0.5 + 0.2 * (len(named) / 2))
        figure.suptitle(title, x=0.008, ha="left", fontsize=13.0, color=INK)
        figure.supxlabel(measured, x=0.992, ha="right", fontsize=7.5, color=FAINT)
        for i, panel in enumerate(panels):
            first = i % across == 0
            axes = plot(figure.add_subplot(rows, across, i + 1), panel.x if i + across >= len(panels) else "",
                        panel.y if first else "", panel.title, log=True)
            _draw(axes, panel)
        figure.legend([_line(curve) for curve in named.values()], list(named), loc="outside lower left",
                      ncols=2, frameon=False, fontsize=8.5, labelcolor=DIM, handlelength=2.4)
        save(figure, path)


def _line(curve: Curve) -> Any:
    from matplotlib.lines import Line2D

    return Line2D([], [], color=COLOURS[curve.tint], linestyle=(0, DOTS) if curve.dotted else "-", marker="o",
                  markersize=3.0, markerfacecolor=PAPER if curve.dotted else None)


def _draw(axes: "Axes", panel: Panel) -> None:
    """Draw the curves and the levels of a panel."""
    for curve in panel.curves:
        if curve.points:
            x, y = zip(*curve.points, strict=True)
            axes.plot(x, y, color=COLOURS[curve.tint], linestyle=(0, DOTS) if curve.dotted else "-", marker="o",
                      markersize=3.0 if len(x) > 1 else 5.0, markerfacecolor=PAPER if curve.dotted else None)
    axes.margins(y=0.12)
    if panel.ticks:
        axes.set_xticks(panel.ticks)
    else:
        tick_finely(axes.xaxis)
    tick_finely(axes.yaxis)
    for value, words in panel.levels:
        axes.axhline(value, color=FAINT, linewidth=1.0, linestyle=":")
        axes.annotate(words, (0.01, value), (0, 2), xycoords=("axes fraction", "data"), textcoords="offset points",
                      color=DIM, fontsize=8.0)


def panel_table(panel: Panel) -> str:
    """A panel as lines of text: the figures of each curve."""
    heads = list(dict.fromkeys(head for curve in panel.curves for head in curve.figures))
    rows = [["", *heads], *([curve.name, *(figure_text(curve.figures.get(head)) for head in heads)]
                            for curve in panel.curves)]
    return "\n".join(line for line in (panel.title, panel.conditions, *aligned(rows)) if line)


def plain_panels(panels: list[Panel]) -> list[dict[str, Any]]:
    """Panels as JSON data."""
    return [{"key": panel.key, "title": panel.title, "conditions": panel.conditions, "x": panel.x, "y": panel.y,
             "curves": [{"name": curve.name, "points": [list(point) for point in curve.points],
                         "figures": curve.figures} for curve in panel.curves]} for panel in panels]
