"""Plots written to files: SVG and PNG on a light sheet, numbers as CSV.

Sizes in inches and points. Only functions that draw import matplotlib, so that the program starts without it.

    with look():
        figure = sheet(8.0, 5.0)
        axes = plot(figure.add_subplot(), "Cost (ns a ray)", "Error (px)", "Double Gauss", log=True)
        axes.plot(x, y, color=COLOURS["blue"])
        save(figure, path)
"""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from lensbench.app.plots.plot import Bars, Curve, Figure, Label, Map, Plot, Points, Tint, wavelength_colour
from lensbench.app.session.export import ExportError, replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure as PrintedFigure


SUFFIXES = (".svg", ".png")
RESOLUTION = 160                # dots per inch of a PNG
SHORT = 300.0                   # largest ratio of the ends of an axis with ticks at 1, 2 and 5
INK, DIM, FAINT, GRID, PAPER = "#262626", "#5a5a5a", "#8a8a8a", "#e6e6e6", "#ffffff"
AMBER = "#c98a1b"               # of objects in focus
# Okabe and Ito's colours, darker where they are drawn as lines on white
COLOURS = {"blue": "#0072b2", "sky": "#3d9fd3", "green": "#007f5c", "vermilion": "#d55e00", "purple": "#b5588f",
           "olive": "#7d7a12", "black": "#262626", "grey": "#7a7a7a"}
STYLE: Any = {
    "font.family": "Roboto", "font.size": 9.0, "text.color": INK, "axes.labelcolor": DIM, "axes.edgecolor": GRID,
    "xtick.color": GRID, "ytick.color": GRID, "xtick.labelcolor": DIM, "ytick.labelcolor": DIM,
    "axes.labelsize": 9.0, "xtick.labelsize": 8.5, "ytick.labelsize": 8.5,
    "axes.titlesize": 10.5, "axes.titlelocation": "left", "axes.titlepad": 8.0,
    "mathtext.fontset": "custom", **{f"mathtext.{style}": "Roboto" for style in ("rm", "it", "bf", "sf", "tt", "cal")},
    "lines.linewidth": 1.6, "lines.solid_capstyle": "round", "axes.axisbelow": True,
    "figure.facecolor": PAPER, "axes.facecolor": PAPER, "savefig.facecolor": PAPER, "svg.hashsalt": "lensbench"}


@contextmanager
def look() -> Iterator[None]:
    """Context in which figures have the font, sizes and colours of the sheet."""
    import matplotlib

    _load_font()
    with matplotlib.rc_context(STYLE):
        yield


def _load_font() -> None:
    """Register the font of the window, which imgui_bundle ships; without that font matplotlib uses its own."""
    from matplotlib import font_manager

    spec = find_spec("imgui_bundle")
    if spec is None or spec.origin is None or any(f.name == "Roboto" for f in font_manager.fontManager.ttflist):
        return
    folder = Path(spec.origin).parent / "assets" / "fonts" / "Roboto"
    for name in ("Regular", "Bold"):
        font_manager.fontManager.addfont(folder / f"Roboto-{name}.ttf")


def sheet(width: float, height: float) -> "PrintedFigure":
    """An empty figure of this size (inches) whose parts do not overlap."""
    from matplotlib.figure import Figure as PrintedFigure

    return PrintedFigure((width, height), layout="constrained")


def plot(axes: "Axes", x: str, y: str, title: str = "", log: bool | tuple[bool, bool] = False) -> "Axes":
    """Set labels, scales and grid of axes, and return the axes. log: for both axes, or one value each."""
    log_x, log_y = (log, log) if isinstance(log, bool) else log
    if log_x:
        axes.set_xscale("log")
    if log_y:
        axes.set_yscale("log")
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if title:
        axes.set_title(title)
    axes.grid(True, which="major", color=GRID, linewidth=0.8)
    axes.tick_params(which="both", length=0.0)
    for axis, is_log in ((axes.xaxis, log_x), (axes.yaxis, log_y)):
        if is_log:
            axis.set_major_formatter(_plainly)
            axis.set_minor_formatter(lambda *_: "")
    return axes


def tick_finely(axis: "Axis") -> None:
    """Put ticks at 1, 2 and 5 of each decade on a logarithmic axis shorter than two and a half decades."""
    from matplotlib.ticker import LogLocator

    low, high = axis.get_view_interval()
    if high < SHORT * low:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))


def _plainly(value: float, _: Any = None) -> str:
    """Tick text: plain digits if there are few (0.01, 1, 1000), otherwise a power of ten (10⁻⁶)."""
    if 1e-4 < value < 1e5:
        return f"{value:.0f}" if value >= 0.999 else f"{value:g}"
    return f"$10^{{{len(f'{value:.0f}') - 1 if value > 1.0 else int(f'{value:e}'[-3:])}}}$"


def checked_suffix(path: str | Path, figures: bool = False) -> Path:
    """The path of a chart; ExportError unless its suffix is in SUFFIXES. figures: the error also names .json."""
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise ExportError(f"{path}: a chart is written as {' or '.join(SUFFIXES)}{', its figures as .json' * figures}: "
                          "choose one of these suffixes")
    return path


def save(figure: "PrintedFigure", path: str | Path) -> None:
    """Write a figure in the format of the suffix; equal figures give equal bytes.

    ExportError where the path cannot be written.
    """
    path = checked_suffix(path)
    suffix = path.suffix.lower()[1:]
    with replacing(path) as file:
        figure.savefig(file, format=suffix, dpi=RESOLUTION, metadata={"Date": None} if suffix == "svg" else None)


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
        with replacing(path) as file:
            file.write_text(figure.table.text(), encoding="utf-8")
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
        with replacing(path) as file:
            file.write_text("\n".join(f"{figure.title}\n{figure.table.text()}" for figure in figures), encoding="utf-8")
    elif suffix == ".pdf":
        from matplotlib.backends.backend_pdf import PdfPages

        with look(), replacing(path) as file, PdfPages(file, metadata={"CreationDate": None}) as pages:
            for figure in figures:
                pages.savefig(_drawn(figure, title))
    else:
        if suffix not in SUFFIXES:
            raise ExportError(f"{path}: figures are written as {', '.join((*SUFFIXES, '.pdf', '.csv'))}: choose one of "
                              "these suffixes")
        heights = [_height(figure) for figure in figures]
        with look():
            whole = sheet(WIDTH, sum(heights))
            parts = whole.subfigures(len(figures), 1, squeeze=False, height_ratios=heights)
            for part_of, figure in zip(parts[:, 0], figures, strict=True):
                _fill(part_of, figure, title)
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
        for j, subplot in enumerate(row):
            _axes(drawn.add_subplot(cells[0, j]), subplot)
    named = {layer.name: layer for row in figure.rows for subplot in row for layer in subplot.named()}
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
        subplot = row[0]
        return (subplot.y.high - subplot.y.low) / (subplot.x.high - subplot.x.low) / len(row)
    return 0.55 if len(row) == 1 else 0.9 / len(row)


def colour(tint: Tint) -> str:
    """The colour of a tint on white."""
    if isinstance(tint, float):
        return f"#{wavelength_colour(tint, dark=False)}"
    return COLOURS[CHART[int(tint[5:]) % 8]] if tint.startswith("chart") else TINTS[tint]


def _axes(axes: "Axes", subplot: Plot) -> None:
    from matplotlib.ticker import MaxNLocator

    plot(axes, subplot.x.label or "", subplot.y.label or "", subplot.title, (subplot.x.log, subplot.y.log))
    axes.set_xlim(subplot.x.low, subplot.x.high)
    axes.set_ylim(subplot.y.low, subplot.y.high)
    for axis, drawn in ((subplot.x, axes.xaxis), (subplot.y, axes.yaxis)):
        if axis.log:
            tick_finely(drawn)
        elif axis.whole is not None:
            locator = MaxNLocator("auto", integer=True)
            drawn.set_major_locator(locator)
            drawn.set_ticks([number for number in locator.tick_values(axis.low, axis.whole)
                             if axis.low <= number <= axis.whole])
    if subplot.equal:
        axes.set_aspect("equal")
    if subplot.x.label is None:
        axes.set_axis_off()
    for layer in subplot.layers:
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
    return {"dashes": [0.75 * length for length in curve.dash]} if curve.dash[0] else {}


def _handle(layer):
    from matplotlib.lines import Line2D

    if isinstance(layer, Curve):
        return Line2D([], [], color=colour(layer.tint), label=layer.name, linewidth=0.75 * layer.weight, **_dash(layer))
    return Line2D([], [], color=colour(layer.tint), label=layer.name, linestyle="",
                  marker=SHAPES[layer.shape] if isinstance(layer, Points) else "s", markersize=4.0)
