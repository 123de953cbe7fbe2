"""Figures of charts as a text table and as JSON data."""

import math
from typing import Any

from lensbench.app.studies.charts.values import Chart


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
    found = []
    for chart in charts:
        front = chart.front
        marks = [{"name": mark.name, "kind": mark.kind, "valid": not mark.why, "why": mark.why,
                  "on front": mark in front, "figures": mark.figures} for mark in chart.marks]
        found.append({"key": chart.key, "title": chart.title, "conditions": chart.conditions, "cost": chart.cost,
                      "error": chart.error, "notes": list(chart.notes), "marks": marks})
    return found
