"""Plot files: a light sheet, the font of the window, and colours that colour-blind readers can tell apart.

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
from typing import TYPE_CHECKING, Any

from lensbench.app.files.export import ExportError, replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

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

    found = find_spec("imgui_bundle")
    if found is None or found.origin is None or any(f.name == "Roboto" for f in font_manager.fontManager.ttflist):
        return
    folder = Path(found.origin).parent / "assets" / "fonts" / "Roboto"
    for name in ("Regular", "Bold"):
        font_manager.fontManager.addfont(folder / f"Roboto-{name}.ttf")


def sheet(width: float, height: float) -> "Figure":
    """An empty figure of this size (inches) whose parts do not overlap."""
    from matplotlib.figure import Figure

    return Figure((width, height), layout="constrained")


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
            axis.set_minor_formatter(_nothing)
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


def _nothing(_: float, __: Any = None) -> str:
    return ""


def checked_suffix(path: str | Path, figures: bool = False) -> Path:
    """The path of a chart; ExportError unless its suffix is in SUFFIXES. figures: the error also names .json."""
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise ExportError(f"{path}: a chart is written as {' or '.join(SUFFIXES)}{', its figures as .json' * figures}: "
                          "choose one of these suffixes")
    return path


def save(figure: "Figure", path: str | Path) -> None:
    """Write a figure in the format of the suffix; equal figures give equal bytes.

    ExportError where the path cannot be written.
    """
    path = checked_suffix(path)
    suffix = path.suffix.lower()[1:]
    with replacing(path) as part:
        figure.savefig(part, format=suffix, dpi=RESOLUTION, metadata={"Date": None} if suffix == "svg" else None)
