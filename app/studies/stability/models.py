"""Errors of each camera model against the traced lens, as `lb.choose_model` measures them; and maps of the simplest
model that is accurate enough, for every lens over its field and its stops.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.drawing.sheet import DIM, INK, look, save, sheet
from lensbench.app.studies.stability.sweep import Sweep, curve
from lensbench.core.analysis.model_choice import LADDER, ModelErrors, Rung
from lensbench.core.text import significant
from lensbench.lenses.library.catalogue import one_of_each_kind

if TYPE_CHECKING:
    from matplotlib.axes import Axes


LENSES = {"double Gauss": "pbrt-dgauss-50mm", "fisheye": "pbrt-fisheye-10mm", "triplet": "lenshh-cooke-triplet-50"}
PIXEL, PIXELS = 0.006, 0.5      # mm, as of 24 megapixels on full frame; allowed error in pixels
STOPS = 0.05
FOCUS = 2000.0                  # mm
RUNGS = LADDER[:-1]             # all models except the trace, which is the reference
WHY = "half a pixel of 6 µm"
SWITCH = "Auto takes the next rung of the ladder"


def film(half_diagonal: float) -> lb.Film:
    """A 3 : 2 film of this half diagonal (mm) with pixels of PIXEL."""
    width = 2.0 * half_diagonal * 3.0 / math.sqrt(13.0)
    return lb.Film(width, width / 1.5, max(round(width / PIXEL), 1), max(round(width / 1.5 / PIXEL), 1))


def judge(lens: lb.Lens, half_diagonal: float, f_number: float | None, focus: float) -> ModelErrors:
    """Errors of all models for objects from four fifths of the focus distance (mm) to twice that distance."""
    return ModelErrors(lb.LensCamera(lens, film(half_diagonal), focus, f_number), (0.8 * focus, 2.0 * focus))


def circle(lens: lb.Lens) -> float:
    """Half diagonal (mm) of the film that is examined: nine tenths of the image circle, at most full frame."""
    camera = lb.LensCamera(lens, film(21.6), FOCUS)
    return min(21.6, 0.9 * camera.pupil.dark_beyond)        # type: ignore[union-attr]


def _curves(judges: Sequence[ModelErrors]):
    def error(judged: ModelErrors, model: str, degree: int) -> float | str:
        rung = judged.rung(model, degree)
        return rung.error_px if math.isfinite(rung.error_px) else "refused"

    return tuple(curve(name(model, degree), [error(judged, model, degree) for judged in judges], True, SWITCH)
                 for model, degree in RUNGS)


def name(model: str, degree: int) -> str:
    """Name of a model, with the degree of a polynomial."""
    return f"polynomial, degree {degree}" if degree else model


def angle(camera: lb.LensCamera, radius: float) -> float:
    """Angle (degrees) of the ray from a film radius (mm) through the middle of its exit-pupil region."""
    width, pixels = camera.film.width, camera.film.pixels_x
    rays = camera.generate_rays([[pixels * (0.5 - radius / width), 0.5 * camera.film.pixels_y]], [[0.5, 0.5]])
    return math.degrees(math.acos(-float(rays.directions[0, 2])))


def field(label: str) -> Sweep:
    """Sweep over ever larger films."""
    lens = lenses.load(LENSES[label])
    halves = np.geomspace(0.2, circle(lens), 10)
    angles = np.array([angle(lb.LensCamera(lens, film(half * 1.3), FOCUS), half) for half in halves])
    return Sweep(f"Models over the field, {label}", "Field angle at the film's corner", "°", angles,
                  "Place and size of blurs", "px", PIXELS, WHY, _curves([judge(lens, half, None, FOCUS)
                                                                        for half in halves]),
                  "Wide open, at 2 m. Ideal models have no distortion; they hold in the middle of the picture.")


def f_number(label: str) -> Sweep:
    """Sweep over ever wider stops."""
    lens = lenses.load(LENSES[label])
    widest = lb.f_number_at_infinity(lens)         # at which blades leave the stop round
    values = np.geomspace(32.0, widest, 10)
    half = 0.5 * circle(lens)
    return Sweep(f"Models as the stop opens, {label}", "f-number", "", values, "Place and size of blurs", "px", PIXELS,
                  WHY, _curves([judge(lens, half, float(value), FOCUS) for value in values]),
                  "Half of the field, at 2 m. A wider pupil has more aberration for a polynomial to follow.")


def object_distance(label: str) -> Sweep:
    """Sweep over ever nearer objects in focus."""
    lens = lenses.load(LENSES[label])
    values = np.geomspace(1e5, 1.5 * lb.nearest_focus(lens), 10)
    half = 0.5 * circle(lens)
    return Sweep(f"Models near by, {label}", "Distance in focus", "mm", values, "Place and size of blurs", "px",
                  PIXELS, WHY, _curves([judge(lens, half, 4.0 if lb.first_order(lens).f_number < 4.0 else None,
                                               float(value)) for value in values]),
                  "Half of the field, f/4. Objects lie between four fifths of that distance and twice that distance.")


SWEEPS: dict[str, Callable[[], Sweep]] = {
    f"{title}, {label}": partial(sweep, label) for title, sweep in (
        ("Models over the field", field), ("Models as the stop opens", f_number), ("Models near by", object_distance))
    for label in LENSES}


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
    return [domain(name) for name in one_of_each_kind() if lenses.load(name).is_rotationally_symmetric]


def save_domains(maps: list[Domain], path: Path) -> None:
    """Draw the maps of all lenses on one sheet; ExportError where it cannot be written."""
    lines = -(-len(maps) // COLUMNS)
    with look():
        figure = sheet(WIDTH, HEIGHT * lines + 1.0)
        figure.suptitle(f"The simplest model within {significant(PIXELS)} px of 6 µm and {significant(STOPS)} stops of "
                        "the traced lens; across: half the field at the film's corner, down: f-number",
                        color=INK, fontsize=10.5, x=0.01, ha="left")
        for axes, one_map in zip(figure.subplots(lines, COLUMNS, squeeze=False).flat, maps, strict=False):
            _draw(axes, one_map)
        for axes in figure.axes[len(maps):]:
            axes.set_axis_off()
        _legend(figure)
        save(figure, path)


def _legend(figure) -> None:
    from matplotlib.patches import Patch

    figure.legend(handles=[Patch(facecolor=colour, label=name(*rung))
                           for colour, rung in zip(COLOURS, LADDER, strict=True)],
                  loc="outside lower center", ncols=len(LADDER), frameon=False, fontsize=7.5, labelcolor=DIM,
                  handlelength=1.0, columnspacing=1.2)


def _draw(axes: "Axes", one_map: Domain) -> None:
    from matplotlib.colors import ListedColormap

    axes.imshow(one_map.rung, cmap=ListedColormap(COLOURS), vmin=-0.5, vmax=len(LADDER) - 0.5, aspect="auto")
    for (i, j), rung in np.ndenumerate(one_map.rung):
        axes.text(j, i, SIGNS[rung], ha="center", va="center", fontsize=5.5,
                  color=INK if rung < 6 else "white")
    axes.set_title(one_map.lens, fontsize=7.0, color=INK)
    axes.set_xticks(range(0, len(one_map.angles), 2), [f"{significant(value, 2)}°" for value in one_map.angles[::2]],
                    fontsize=6.0)
    axes.set_yticks(range(0, len(one_map.f_numbers), 2), [significant(value, 3) for value in one_map.f_numbers[::2]],
                    fontsize=6.0)
    axes.tick_params(length=0.0)
    for side in axes.spines.values():
        side.set_visible(False)
