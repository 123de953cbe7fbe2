"""Charts as values: marks with cost and error and their Pareto front, panels of curves; as sheet, table and JSON."""

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lensbench.app.drawing.sheet import COLOURS, DIM, FAINT, INK, PAPER, look, plot, save, sheet, tick_finely

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True)
class Mark:
    """One method at one cost.

    name: the label of the mark. kind: its family, a key of `sheet.KINDS`. cost, error: in the units of the chart.
    spread: excess of the median run over the least run, which is `cost`, in percent. worst: largest error. NaN: not
    measured. why: the reason why the mark is invalid, "" if valid. figures: all measured values by name and unit, such
    as "streamed, ns".
    """

    name: str
    kind: str
    cost: float = math.nan
    error: float = math.nan
    spread: float = math.nan
    worst: float = math.nan
    why: str = ""
    figures: dict[str, float] = field(default_factory=dict)

    @property
    def has_place(self) -> bool:
        """Whether the mark can be drawn in the chart."""
        return self.cost > 0.0 and self.error >= 0.0

    @property
    def is_valid(self) -> bool:
        """Whether the mark can be drawn and is valid."""
        return self.has_place and not self.why


@dataclass(frozen=True)
class Chart:
    """Methods side by side, for one lens or one scene.

    key: short name. cost, error: axis labels with units. conditions: valid for all marks. notes: printed below. also:
    other costs of the same marks: axis label, and the figures that hold the cost and its spread. floor: smaller errors
    count as none.
    """

    key: str
    title: str
    cost: str
    error: str
    marks: tuple[Mark, ...]
    conditions: str = ""
    notes: tuple[str, ...] = ()
    also: tuple[tuple[str, str, str], ...] = ()
    floor: float = 1e-5

    @property
    def front(self) -> tuple[Mark, ...]:
        """The Pareto front by cost: marks that no other mark beats in both cost and error."""
        front: list[Mark] = []
        for mark in sorted((mark for mark in self.marks if mark.is_valid), key=lambda mark: (mark.cost, mark.error)):
            if not front or max(mark.error, self.floor) < max(front[-1].error, self.floor):
                front.append(mark)
        return tuple(front)

    @property
    def all_costs(self) -> list["Chart"]:
        """The same chart for each of its costs, this one first."""
        ancestors = [self]
        for cost, figure, spread in self.also:
            marks = tuple(replace(mark, cost=mark.figures.get(figure, math.nan),
                                  spread=mark.figures.get(spread, math.nan)) for mark in self.marks)
            ancestors.append(replace(self, cost=cost, marks=marks, also=()))
        return ancestors


def columns(chart: Chart) -> list[str]:
    """Names of the figures in a chart, in the order of the mark that has the most."""
    fullest = max((mark.figures for mark in chart.marks), key=len, default={})
    return list(fullest)


def figure_text(value: float | None) -> str:
    """A figure in few digits; a rounding error as 0."""
    if value is None or math.isnan(value):
        return ""
    if math.isinf(value):
        return "∞"
    if abs(value) < 1e-9:
        return "0"
    if abs(value) < 1e-5:
        return f"{value:.0e}"
    return f"{value:.{max(2 - math.floor(math.log10(abs(value))), 0) if abs(value) >= 0.01 else 5}f}"


def aligned(rows: list[list[str]]) -> list[str]:
    """Rows of a table as lines of text: the first column left-aligned, the others right-aligned."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join([first.ljust(widths[0]), *(cell.rjust(width) for cell, width in
                                                 zip(cells, widths[1:], strict=True))]).rstrip()
            for first, *cells in rows]


def table(chart: Chart) -> str:
    """A chart as lines of text: marks with their figures, * on the Pareto front; then the reasons of invalid marks."""
    heads, front = columns(chart), chart.front
    rows = [["", *(head.split(", ")[0] for head in heads)], ["", *(head.split(", ")[-1] for head in heads)]]
    for mark in chart.marks:
        name = f"{mark.name}{' *' if mark in front else ''}{' (not valid)' if mark.why else ''}"
        rows.append([name, *(figure_text(mark.figures.get(head)) for head in heads)])
    lines = [chart.title, chart.conditions, *aligned(rows)]
    lines += [f"Not valid: {mark.name}: {mark.why}" for mark in chart.marks if mark.why]
    return "\n".join([*(line for line in lines if line), *chart.notes])


def plain(charts: list[Chart]) -> list[dict[str, Any]]:
    """Charts as JSON data."""
    summaries = []
    for chart in charts:
        front = chart.front
        marks = [{"name": mark.name, "kind": mark.kind, "valid": not mark.why, "why": mark.why,
                  "on front": mark in front, "figures": mark.figures} for mark in chart.marks]
        summaries.append({"key": chart.key, "title": chart.title, "conditions": chart.conditions, "cost": chart.cost,
                      "error": chart.error, "notes": list(chart.notes), "marks": marks})
    return summaries


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
    """Curves on common logarithmic axes, with labels x and y; levels: of horizontal lines; ticks: the few of x."""

    key: str
    title: str
    x: str
    y: str
    curves: tuple[Curve, ...]
    levels: tuple[tuple[float, str], ...] = ()
    ticks: tuple[float, ...] = ()
    conditions: str = ""


def draw_panels(panels: list[Panel], path: Path, title: str, measured: str = "") -> None:
    """Write panels with one legend into a file; ExportError. measured: place and date, printed on the sheet."""
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
