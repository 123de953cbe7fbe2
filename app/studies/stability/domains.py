"""Maps of the simplest camera model that is accurate enough, for every lens over its field and its stops."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.analysis.model_choice import LADDER
from lensbench.analysis.model_error import Rung
from lensbench.app.studies.plotting import DIM, INK, look, save, sheet
from lensbench.app.studies.stability.models import FOCUS, PIXELS, RUNGS, STOPS, angle, circle, film, judge, name
from lensbench.kernels.figures import significant
from lensbench.lenses.catalogue import one_of_each_kind

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLUMNS = 5
WIDTH, HEIGHT = 11.0, 1.55          # inches: width of the sheet, height of each row
# From the palest, for the simplest model, to the darkest
COLOURS = ("#e3f0e2", "#bfe0bd", "#94cc95", "#d3e6f4", "#a7cde9", "#73aedb", "#3d8ac6", "#1c64a4", "#d55e00")
SIGNS = ("hole", "thin", "thick", "3", "5", "7", "9", "11", "trace")


@dataclass(frozen=True, eq=False)
class Domain:
    """The simplest model that is accurate enough for one lens, over its field and stops.

    rung (f-numbers, film sizes): index in LADDER of the first model within PIXELS and STOPS; the last is the full
    trace. half_diagonals: mm. angles: field angles at the corners of the film, degrees.
    """

    lens: str
    half_diagonals: np.ndarray
    angles: np.ndarray
    f_numbers: np.ndarray
    rung: np.ndarray


def domain(lens_name: str, sizes: int = 7, stops: int = 5) -> Domain:
    """The map of one lens, focused at 2 m or at twice its nearest distance."""
    lens = lenses.load(lens_name)
    focus = max(FOCUS, 2.0 * lb.nearest_focus(lens))
    widest = lb.f_number_at_infinity(lens)         # at which blades leave the stop round
    numbers = np.geomspace(max(22.0, 2.0 * widest), widest, stops)
    halves = np.geomspace(0.5, circle(lens), sizes)
    angles = np.array([angle(lb.LensCamera(lens, film(half * 1.3), focus), half) for half in halves])
    rung = np.full((stops, sizes), len(RUNGS))
    for i, number in enumerate(numbers):
        first = 0
        for j, half in enumerate(halves):
            judged = judge(lens, half, float(number), focus)
            # A larger film contains the smaller one: a model that failed there fails here
            while first < len(RUNGS) and not _good(judged.rung(*RUNGS[first])):
                first += 1
            rung[i, j] = first
    return Domain(lens_name, halves, angles, numbers, rung)


def _good(rung: Rung) -> bool:
    return rung.error_px <= PIXELS and rung.error_stops <= STOPS


def domains() -> list[Domain]:
    """Maps of a library lens of each kind with rotational symmetry."""
    return [domain(each) for each in one_of_each_kind() if lenses.load(each).is_rotationally_symmetric]


def save_domains(found: list[Domain], path: Path) -> None:
    """Draw the maps of all lenses on one sheet; ExportError where it cannot be written."""
    lines = -(-len(found) // COLUMNS)
    with look():
        figure = sheet(WIDTH, HEIGHT * lines + 1.0)
        figure.suptitle(f"The simplest model within {significant(PIXELS)} px of 6 µm and {significant(STOPS)} stops of "
                        "the traced lens; across: half the field at the film's corner, down: f-number",
                        color=INK, fontsize=10.5, x=0.01, ha="left")
        for axes, each in zip(figure.subplots(lines, COLUMNS, squeeze=False).flat, found, strict=False):
            _draw(axes, each)
        for axes in figure.axes[len(found):]:
            axes.set_axis_off()
        _legend(figure)
        save(figure, path)


def _legend(figure) -> None:
    from matplotlib.patches import Patch

    figure.legend(handles=[Patch(facecolor=colour, label=name(*rung))
                           for colour, rung in zip(COLOURS, LADDER, strict=True)],
                  loc="outside lower center", ncols=len(LADDER), frameon=False, fontsize=7.5, labelcolor=DIM,
                  handlelength=1.0, columnspacing=1.2)


def _draw(axes: "Axes", found: Domain) -> None:
    from matplotlib.colors import ListedColormap

    axes.imshow(found.rung, cmap=ListedColormap(COLOURS), vmin=-0.5, vmax=len(LADDER) - 0.5, aspect="auto")
    for (i, j), rung in np.ndenumerate(found.rung):
        axes.text(j, i, SIGNS[rung], ha="center", va="center", fontsize=5.5,
                  color=INK if rung < 6 else "white")
    axes.set_title(found.lens, fontsize=7.0, color=INK)
    axes.set_xticks(range(0, len(found.angles), 2), [f"{significant(value, 2)}°" for value in found.angles[::2]],
                    fontsize=6.0)
    axes.set_yticks(range(0, len(found.f_numbers), 2), [significant(value, 3) for value in found.f_numbers[::2]],
                    fontsize=6.0)
    axes.tick_params(length=0.0)
    for side in axes.spines.values():
        side.set_visible(False)
