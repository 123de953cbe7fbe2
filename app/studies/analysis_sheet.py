"""Figures of analyses written to files: SVG and PNG on the light sheet of the charts, numbers as CSV."""

from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np

from lensbench.app.files.export import ExportError, replacing
from lensbench.app.state.analysis.figure import Bars, Curve, Figure, Label, Map, Plot, Points, Tint, wavelength_colour
from lensbench.app.studies.plotting import (
    AMBER,
    COLOURS,
    DIM,
    FAINT,
    GRID,
    INK,
    SUFFIXES,
    look,
    plot,
    save,
    sheet,
    tick_finely,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTH = 8.0                     # inches
LETTER = 0.0077                 # inches of a letter of 1 point, on average; somewhat more than that
SAMPLE = 0.5                    # inches of the sample in a legend, with its gaps
TINTS = {"strong": INK, "text": DIM, "dim": COLOURS["grey"], "faint": FAINT, "grid": GRID, "amber": AMBER,
         "field0": COLOURS["blue"], "field1": COLOURS["green"], "field2": COLOURS["vermilion"], "dead": FAINT}
CHART = ("vermilion", "purple", "blue", "green", "olive", "sky", "black", "grey")
GHOST = 0.45                    # opacity of the figure A
SHAPES = {"triangle": "^", "square": "s", "diamond": "D"}


def write_figure(figure: Figure, path: Path, title: str = "") -> None:
    """Write a figure; the suffix of the path sets the format. title: the lens, printed above.

    ExportError for another suffix, and where the path cannot be written.
    """
    suffix = path.suffix.lower()
    if suffix == ".csv":
        with replacing(path) as part:
            part.write_text(figure.table.text(), encoding="utf-8")
        return
    if suffix not in SUFFIXES:
        raise ExportError(f"{path}: a figure is written as {', '.join((*SUFFIXES, '.csv'))}: choose one of these "
                          "suffixes")
    with look():
        save(_drawn(figure, title), path)


def write_figures(figures: list[Figure], path: Path, title: str = "") -> None:
    """Write several figures below each other; in a PDF each on a page, as CSV their tables with a heading each.

    ExportError as for `write_figure`.
    """
    suffix = path.suffix.lower()
    if len(figures) == 1 and suffix != ".pdf":
        write_figure(figures[0], path, title)
    elif suffix == ".csv":
        with replacing(path) as part:
            part.write_text("\n".join(f"{each.title}\n{each.table.text()}" for each in figures), encoding="utf-8")
    elif suffix == ".pdf":
        from matplotlib.backends.backend_pdf import PdfPages

        with look(), replacing(path) as part, PdfPages(part, metadata={"CreationDate": None}) as pages:
            for each in figures:
                pages.savefig(_drawn(each, title))
    else:
        if suffix not in SUFFIXES:
            raise ExportError(f"{path}: figures are written as {', '.join((*SUFFIXES, '.pdf', '.csv'))}: choose one of "
                              "these suffixes")
        heights = [_height(each) for each in figures]
        with look():
            whole = sheet(WIDTH, sum(heights))
            parts = whole.subfigures(len(figures), 1, squeeze=False, height_ratios=heights)
            for part_of, each in zip(parts[:, 0], figures, strict=True):
                _fill(part_of, each, title)
            save(whole, path)


def _height(figure: Figure) -> float:
    """Height of a figure on the sheet, inches."""
    weights = figure.heights or (1.0,) * len(figure.rows)
    shape = max((_shape(row) for row in figure.rows), default=0.6)
    return min(max(WIDTH * shape * sum(weights) / max(weights), 3.5), 14.0)


def _drawn(figure: Figure, title: str):
    drawn = sheet(WIDTH, _height(figure))
    _fill(drawn, figure, title)
    return drawn


def _fill(drawn, figure: Figure, title: str) -> None:
    """Draw a figure into a sheet, or a part of one."""
    weights = figure.heights or (1.0,) * len(figure.rows)
    grids = drawn.add_gridspec(len(figure.rows), 1, height_ratios=weights)
    for i, row in enumerate(figure.rows):
        cells = grids[i].subgridspec(1, len(row))
        for j, each in enumerate(row):
            _axes(drawn.add_subplot(cells[0, j]), each)
    named = {layer.name: layer for row in figure.rows for each in row for layer in each.named()}
    handles, room = [_handle(layer) for layer in named.values()], WIDTH
    if handles:
        columns = len(handles) if len(handles) < 6 else 3
        room -= columns * (SAMPLE + LETTER * 8.0 * max(map(len, named)))
        drawn.legend(handles=handles, loc="outside upper right", ncols=columns, frameon=False, fontsize=8)
    words = f"{title}: {figure.title}" if title else figure.title
    drawn.suptitle(_wrapped(words, 10.5, max(room, 0.3 * WIDTH)), x=0.01, ha="left", fontsize=10.5)
    below = (_wrapped(line, 7.5, WIDTH) for line in (figure.conditions, *figure.remarks))
    drawn.supxlabel("\n".join(below), x=0.01, ha="left", fontsize=7.5, color=DIM)


def _wrapped(words: str, size: float, room: float) -> str:
    """Words of this size (points) in lines of `room` inches."""
    return "\n".join(wrap(words, max(int(room / (LETTER * size)), 10)))


def _shape(row: tuple[Plot, ...]) -> float:
    """Height over width of a row."""
    if row[0].equal:
        each = row[0]
        return (each.y.high - each.y.low) / (each.x.high - each.x.low) / len(row)
    return 0.55 if len(row) == 1 else 0.9 / len(row)


def colour(tint: Tint) -> str:
    """The colour of a tint on white."""
    if isinstance(tint, float):
        return f"#{wavelength_colour(tint, dark=False)}"
    return COLOURS[CHART[int(tint[5:]) % 8]] if tint.startswith("chart") else TINTS[tint]


def _axes(axes: "Axes", each: Plot) -> None:
    from matplotlib.ticker import MaxNLocator

    plot(axes, each.x.label or "", each.y.label or "", each.title, (each.x.log, each.y.log))
    axes.set_xlim(each.x.low, each.x.high)
    axes.set_ylim(each.y.low, each.y.high)
    for axis, drawn in ((each.x, axes.xaxis), (each.y, axes.yaxis)):
        if axis.log:
            tick_finely(drawn)
        elif axis.whole is not None:
            locator = MaxNLocator("auto", integer=True)
            drawn.set_major_locator(locator)
            drawn.set_ticks([number for number in locator.tick_values(axis.low, axis.whole)
                             if axis.low <= number <= axis.whole])
    if each.equal:
        axes.set_aspect("equal")
    if each.x.label is None:
        axes.set_axis_off()
    for layer in each.layers:
        if getattr(layer, "surface", None) is not None:         # lit by the mouse alone
            continue
        if isinstance(layer, Curve):
            axes.plot(layer.x, layer.y, color=colour(layer.tint), linewidth=0.75 * layer.weight, alpha=_alpha(layer),
                      **_dash(layer))
        elif isinstance(layer, Points):
            axes.plot(layer.x, layer.y, SHAPES[layer.shape], color=colour(layer.tint), markersize=1.0,
                      markeredgewidth=0.0, alpha=_alpha(layer))
        elif isinstance(layer, Bars):
            axes.bar(layer.x, layer.y, layer.width, color=colour(layer.tint), alpha=_alpha(layer))
        elif isinstance(layer, Map) and not layer.ghost:
            axes.imshow(layer.shades, cmap="bone", vmin=0.0, vmax=1.0,
                        origin="lower", aspect=axes.get_aspect(), extent=(*layer.x, *layer.y), interpolation="nearest")
            x, y = (low + (np.arange(n) + 0.5) / n * (high - low) for n, (low, high)
                    in zip(layer.values.shape[::-1], (layer.x, layer.y), strict=True))
            if layer.levels:
                lines = axes.contour(x, y, layer.values, layer.levels, colors=[INK], linewidths=0.5)
                axes.clabel(lines, fontsize=6.5)
        elif isinstance(layer, Label):
            first, last = layer.side.split()[0], layer.side.split()[-1]
            axes.text(layer.x, layer.y, layer.text, fontsize=7.0, color=colour(layer.tint), clip_on=False, bbox=PLATE,
                      ha={"left": "right", "right": "left"}.get(first, "center"),
                      va={"above": "bottom", "below": "top"}.get(last, "center"))


PLATE = {"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 0.6}     # of labels, which may lie on maps


def _alpha(layer: Curve | Points | Bars) -> float:
    return GHOST if layer.ghost else 1.0


def _dash(curve: Curve) -> dict:
    return {"dashes": [0.75 * each for each in curve.dash]} if curve.dash[0] else {}


def _handle(layer):
    from matplotlib.lines import Line2D

    if isinstance(layer, Curve):
        return Line2D([], [], color=colour(layer.tint), label=layer.name, linewidth=0.75 * layer.weight, **_dash(layer))
    return Line2D([], [], color=colour(layer.tint), label=layer.name, linestyle="",
                  marker=SHAPES[layer.shape] if isinstance(layer, Points) else "s", markersize=4.0)
