"""Charts on a sheet: one chart with its figures, or many small charts under a summary of all."""

import math
from dataclasses import replace
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any, NamedTuple

from lensbench.app.drawing.sheet import COLOURS, DIM, FAINT, INK, PAPER, look, plot, save, sheet, tick_finely
from lensbench.app.studies.charts.curves import Chart, Mark, columns, figure_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

ACROSS = 5                      # small charts in a row
FRONT = "#d9d4c9"
READING = ("Bold, and joined by a band: no other mark is both cheaper and more accurate. Thin lines go up to the worst"
           " ray, and right to the median run")


class Kind(NamedTuple):
    """Look of the marks of a family: colour, shape, and whether they are larger."""

    colour: str
    shape: str
    words: str


KINDS = {
    "pinhole": Kind(COLOURS["grey"], "o", "pinhole"),
    "thin": Kind(COLOURS["sky"], "^", "thin lens"),
    "thick": Kind(COLOURS["blue"], "s", "thick lens"),
    "polynomial": Kind(COLOURS["vermilion"], "D", "polynomial, degree 3 to 11"),
    "table": Kind(COLOURS["purple"], "X", "table"),
    "trace": Kind(COLOURS["green"], "h", "full trace, float32 and float64"),
    "scalar": Kind(COLOURS["black"], "P", "scalar reference"),
    "peer": Kind(COLOURS["olive"], "v", "other programs"),
}


def draw(charts: list[Chart], path: Path, summary: bool = False, measured: str = "") -> None:
    """Write charts into a file: one with its figures, or several small ones below a summary.

    summary: of several charts, write the summary alone. measured: place and date of the measurement, printed on the
    sheet.
    """
    with look():
        save(_one(charts[0], measured) if len(charts) == 1 else _overview(charts, summary, measured), path)


def _one(chart: Chart, measured: str) -> "Figure":
    """One chart for each of its costs, with a table of its figures."""
    heads, rows = columns(chart), len(chart.marks) + 2
    notes = [*_notes(chart), measured]
    height = 0.19 * rows + 0.17 * len(notes) + 0.1
    figure = sheet(9.6, 4.9 + height)
    _head(figure, chart.title, chart.conditions)
    grid = figure.add_gridspec(2, len(chart.all_costs), height_ratios=[4.3, height])
    errors = _limits(chart.marks, chart.floor)
    drawn = []
    for i, over in enumerate(chart.all_costs):
        axes = plot(figure.add_subplot(grid[0, i]), over.cost, over.error if i == 0 else "", log=True)
        axes.set_ylim(*errors)
        _draw(axes, over)
        tick_finely(axes.xaxis)
        drawn.append((axes, over))
    _write_table(figure.add_subplot(grid[1, :]), chart, heads, notes, height)
    figure.draw_without_rendering()                     # the layout is known from here on
    figure.set_layout_engine("none")
    for axes, over in drawn:
        _name_marks(axes, over)
    return figure


def _head(figure: "Figure", title: str, below: str) -> None:
    """Title of the sheet, and a line of its common conditions."""
    high = figure.get_figheight()
    engine: Any = figure.get_layout_engine()
    engine.set(rect=(0.0, 0.0, 1.0, 1.0 - 0.5 / high))
    figure.text(0.008, 1.0 - 0.22 / high, title, fontsize=13.0, color=INK, in_layout=False)
    figure.text(0.008, 1.0 - 0.42 / high, below, fontsize=8.5, color=DIM, in_layout=False)


def _notes(chart: Chart) -> list[str]:
    return [*(f"{mark.name} is not valid: {mark.why}" for mark in chart.marks if mark.why), READING, *chart.notes]


def _limits(marks: tuple[Mark, ...], floor: float) -> tuple[float, float]:
    """Range of the error axis, from the floor to the largest error."""
    shown = [max(mark.error, mark.worst if math.isfinite(mark.worst) else 0.0) for mark in marks if mark.has_place]
    return 0.4 * floor, 3.0 * max([1.0, *(error for error in shown if math.isfinite(error))])


def _draw(axes: "Axes", chart: Chart, size: float = 6.5) -> None:
    """Draw the marks of a chart, the Pareto front, and the spreads of cost and error."""
    has_place = [mark for mark in chart.marks if mark.has_place and math.isfinite(mark.error)]
    ahead, floor = chart.front, chart.floor
    axes.plot([mark.cost for mark in ahead], [max(mark.error, floor) for mark in ahead], color=FRONT,
              linewidth=0.35 * size, zorder=1.5, solid_joinstyle="round")
    for mark in has_place:
        kind, y = KINDS[mark.kind], max(mark.error, floor)
        colour = FAINT if mark.why else kind.colour
        if mark.worst > y and math.isfinite(mark.worst):
            axes.plot([mark.cost] * 2, [y, mark.worst], color=colour, linewidth=0.8, alpha=0.75, zorder=2.0)
        if mark.spread > 0.0:
            axes.plot([mark.cost, mark.cost * (1.0 + 0.01 * mark.spread)], [y] * 2, color=colour, linewidth=0.8,
                      alpha=0.75, zorder=2.0)
        edge, fill = (colour, PAPER) if mark.why else (PAPER, colour)
        axes.plot(mark.cost, y, kind.shape, markersize=size, markeredgecolor=edge, markerfacecolor=fill,
                  markeredgewidth=0.7, zorder=3.0)
        if mark.error < floor:
            axes.annotate("", (mark.cost, 0.45 * floor), (mark.cost, y), zorder=2.5,
                          arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 0.8, "mutation_scale": size})


# Names at the marks: the first free place around each

PLACES = [(1.0, 0.0), (-1.0, 0.0), (0.75, 0.75), (0.75, -0.75), (-0.75, 0.75), (-0.75, -0.75), (0.0, 1.0), (0.0, -1.0)]
REACHES = (7.0, 11.0, 16.0, 22.0, 30.0, 40.0)           # points from the mark


def _name_marks(axes: "Axes", chart: Chart) -> None:
    """Write the names of marks next to them, with a leader where the nearest places are occupied."""
    from matplotlib.patheffects import withStroke

    halo = [withStroke(linewidth=3.5, foreground=PAPER)]
    pixel, marks = axes.figure.dpi / 72.0, [mark for mark in chart.marks if mark.has_place]
    positions = {mark.name: axes.transData.transform((mark.cost, max(mark.error, chart.floor))) for mark in marks}
    taken = [(x - 4.5 * pixel, y - 4.5 * pixel, x + 4.5 * pixel, y + 4.5 * pixel) for x, y in positions.values()]
    frame = axes.get_window_extent()
    for mark in sorted(marks, key=lambda mark: (-mark.error, mark.cost)):
        written = axes.annotate(mark.name, (mark.cost, max(mark.error, chart.floor)), xytext=(0.0, 0.0), fontsize=8.0,
                                textcoords="offset points", zorder=4.0,
                                color=DIM if mark.why else KINDS[mark.kind].colour, path_effects=halo)
        for reach in REACHES:
            box = next((free_box for side in PLACES if (free_box := _placed(written, side, reach, frame, taken))), None)
            if box is not None:
                if reach > REACHES[1]:
                    line = {"arrowstyle": "-", "color": FAINT, "linewidth": 0.5, "shrinkB": 3.0}
                    axes.annotate("", (mark.cost, max(mark.error, chart.floor)), written.get_position(), zorder=1.8,
                                  textcoords="offset points", arrowprops=line)
                taken.append(box)
                break
        else:
            written.remove()


def _placed(written, side: tuple[float, float], reach: float, frame, taken) -> tuple | None:
    """Move a name to a place around its mark; its box, or None if it overlaps something."""
    right, up = side
    written.set_position((right * reach, up * reach))
    written.set_horizontalalignment("left" if right > 0.0 else "right" if right < 0.0 else "center")
    written.set_verticalalignment("bottom" if up > 0.0 else "top" if up < 0.0 else "center")
    box = written.get_window_extent()
    if box.x0 < frame.x0 or box.x1 > frame.x1 or box.y0 < frame.y0 or box.y1 > frame.y1:
        return None
    if any(box.x0 < x1 and box.x1 > x0 and box.y0 < y1 and box.y1 > y0 for x0, y0, x1, y1 in taken):
        return None
    return box.x0, box.y0, box.x1, box.y1


def _write_table(axes: "Axes", chart: Chart, heads: list[str], notes: list[str], height: float) -> None:
    """Write the figures of every mark, the reasons of invalid marks, and the notes."""
    axes.axis("off")
    axes.set(xlim=(0.0, 1.0), ylim=(height, 0.0))
    ahead, left, y = chart.front, 0.17, 0.1
    step = (1.0 - left) / len(heads)
    for i, head in enumerate(heads):
        name, _, unit = head.partition(", ")
        for line, words in enumerate((name, unit)):
            axes.text(left + (i + 1) * step, y + 0.15 * line, words, ha="right", va="center", fontsize=7.5, color=DIM)
    y += 0.36
    for mark in chart.marks:
        kind = KINDS[mark.kind]
        axes.plot(0.008, y, kind.shape, color=kind.colour, markersize=5.0, markeredgewidth=0.0, clip_on=False)
        weight = "bold" if mark in ahead else "normal"
        axes.text(0.02, y, mark.name, va="center", fontsize=8.0, color=FAINT if mark.why else INK, weight=weight)
        for i, head in enumerate(heads):
            axes.text(left + (i + 1) * step, y, figure_text(mark.figures.get(head)), ha="right", va="center",
                      fontsize=8.0, color=FAINT if mark.why else INK)
        y += 0.19
    for words in notes:
        axes.text(0.0, y + 0.03, words, va="center", fontsize=7.5, color=DIM)
        y += 0.17


# Many lenses


def _overview(charts: list[Chart], summary: bool, measured: str) -> "Figure":
    """All charts in one: medians over a cloud of all marks; below it, unless `summary`, each chart in small."""
    rows = 0 if summary else math.ceil(len(charts) / ACROSS)
    figure = sheet(9.6, 5.3 + 1.62 * rows)
    parts: Any = figure.subfigures(2, 1, height_ratios=[5.3, 1.62 * rows]) if rows else [figure]
    top, *below = parts
    middles = _medians(charts)
    _head(figure, f"{len(charts)} lenses: {middles.title}", measured)
    marks, floor = tuple(mark for chart in charts for mark in chart.marks), charts[0].floor
    drawn = []
    for i, over in enumerate(middles.all_costs):
        axes = top.add_subplot(1, len(middles.all_costs), i + 1)
        plot(axes, over.cost, over.error if i == 0 else "", log=True)
        axes.set_ylim(*_limits(tuple(replace(mark, worst=math.nan) for mark in marks), floor))
        for chart in charts:
            for mark in chart.all_costs[i].marks:
                if mark.is_valid:
                    axes.plot(mark.cost, max(mark.error, chart.floor), ".", color=KINDS[mark.kind].colour, alpha=0.35,
                              markersize=3.5, markeredgewidth=0.0, zorder=1.2)
        _draw(axes, over, 7.5)
        tick_finely(axes.xaxis)
        drawn.append((axes, over))
    if below:
        _small_charts(below[0], charts, _limits(marks, floor))
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for axes, over in drawn:
        _name_marks(axes, over)
    return figure


def _medians(charts: list[Chart]) -> Chart:
    """A chart of the median over all charts of each valid mark, and of its figures."""
    first, marks = charts[0], []
    for name in dict.fromkeys(mark.name for chart in charts for mark in chart.marks):
        same = [mark for chart in charts for mark in chart.marks if mark.name == name and mark.is_valid]
        if same:
            heads = [head for head in same[0].figures if all(head in mark.figures for mark in same)]
            cost, error = (median(getattr(mark, name) for mark in same) for name in ("cost", "error"))
            figures = {head: median(mark.figures[head] for mark in same) for head in heads}
            marks.append(Mark(name, same[0].kind, cost, error, figures=figures))
    return Chart("all", "median of each model, over a dot for every lens", first.cost, first.error, tuple(marks),
                 also=tuple((cost, figure, "") for cost, figure, _ in first.also))


def _small_charts(figure: "SubFigure", charts: list[Chart], errors: tuple[float, float]) -> None:
    """Draw every chart in small on common axes, labelled only at the left and the bottom."""
    costs = [mark.cost for chart in charts for mark in chart.marks if mark.has_place]
    rows = math.ceil(len(charts) / ACROSS)
    for i, chart in enumerate(charts):
        axes = plot(figure.add_subplot(rows, ACROSS, i + 1), "", "", log=True)
        axes.set(xlim=(0.6 * min(costs), 1.7 * max(costs)), ylim=errors)
        axes.set_title(chart.title, fontsize=7.0, pad=3.0, color=INK)
        axes.tick_params(labelsize=6.5, labelleft=i % ACROSS == 0, labelbottom=i + ACROSS >= len(charts))
        _draw(axes, chart, 3.6)
    figure.supxlabel(charts[0].cost, fontsize=8.5, color=DIM)
    figure.supylabel(charts[0].error, fontsize=8.5, color=DIM)
