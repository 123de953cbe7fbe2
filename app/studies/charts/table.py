"""The figures of charts as a table of text and as JSON."""

import math
from typing import Any

from lensbench.app.studies.charts.values import Chart


def columns(chart: Chart) -> list[str]:
    """The figures that the marks of a chart have, in the order of the fullest of them."""
    fullest = max((mark.figures for mark in chart.marks), key=len, default={})
    return list(fullest)


def figure_text(value: float | None) -> str:
    """A figure in few digits; one of mere rounding as 0."""
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
    """The rows of a table as lines of text: the first column to the left, the others to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join([first.ljust(widths[0]), *(cell.rjust(width) for cell, width in
                                                 zip(cells, widths[1:], strict=True))]).rstrip()
            for first, *cells in rows]


def table(chart: Chart) -> str:
    """A chart as lines of text: its marks with their figures, * at the Pareto front; then why marks are invalid."""
    heads, ahead = columns(chart), chart.front
    rows = [["", *(head.split(", ")[0] for head in heads)], ["", *(head.split(", ")[-1] for head in heads)]]
    for mark in chart.marks:
        name = f"{mark.name}{' *' if mark in ahead else ''}{' (not valid)' if mark.why else ''}"
        rows.append([name, *(figure_text(mark.figures.get(head)) for head in heads)])
    lines = [chart.title, chart.conditions, *aligned(rows)]
    lines += [f"Not valid: {mark.name}: {mark.why}" for mark in chart.marks if mark.why]
    return "\n".join([*(line for line in lines if line), *chart.notes])


def plain(charts: list[Chart]) -> list[dict[str, Any]]:
    """Charts as plain data."""
    found = []
    for chart in charts:
        ahead = chart.front
        marks = [{"name": mark.name, "kind": mark.kind, "valid": not mark.why, "why": mark.why,
                  "on front": mark in ahead, "figures": mark.figures} for mark in chart.marks]
        found.append({"key": chart.key, "title": chart.title, "conditions": chart.conditions, "cost": chart.cost,
                      "error": chart.error, "notes": list(chart.notes), "marks": marks})
    return found
