"""How far each camera model holds: its error in the picture against the traced lens, as `lb.choose_model` judges it."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.accuracy import LADDER
from lensbench.app.atlas.stress import Stress, curve
from lensbench.judge import Judge, Rung

LENSES = {"double Gauss": "pbrt-dgauss-50mm", "fisheye": "pbrt-fisheye-10mm", "triplet": "lenshh-cooke-triplet-50"}
PIXEL, PIXELS = 0.006, 0.5      # mm, as of 24 megapixels on full frame; and how many of them a model may be off by
STOPS = 0.05
FOCUS = 2000.0                  # mm
RUNGS = LADDER[:-1]             # all but the trace, which is the reference
WHY = "half a pixel of 6 µm"
SWITCH = "Auto takes the next rung of the ladder"


def _film(half_diagonal: float) -> lb.Film:
    """3 : 2, with pixels of PIXEL."""
    width = 2.0 * half_diagonal * 3.0 / math.sqrt(13.0)
    return lb.Film(width, width / 1.5, max(round(width / PIXEL), 1), max(round(width / 1.5 / PIXEL), 1))


def _judge(lens: lb.Lens, half_diagonal: float, f_number: float | None, focus: float) -> Judge:
    """Of things from four fifths of the focus distance to twice as far."""
    return Judge(lb.LensCamera(lens, _film(half_diagonal), focus, f_number), (0.8 * focus, 2.0 * focus))


def _circle(lens: lb.Lens) -> float:
    """Half the diagonal (mm) of the film that the lens is judged on: nine tenths of its light, at most full frame."""
    camera = lb.LensCamera(lens, _film(21.6), FOCUS)
    return min(21.6, 0.9 * camera.pupil.dark_beyond)        # type: ignore[union-attr]


def _curves(judges: Sequence[Judge]):
    def error(judge: Judge, model: str, degree: int) -> float | str:
        rung = judge.rung(model, degree)
        return rung.error_px if math.isfinite(rung.error_px) else "refused"

    return tuple(curve(name(model, degree), [error(judge, model, degree) for judge in judges], True, SWITCH)
                 for model, degree in RUNGS)


def name(model: str, degree: int) -> str:
    """Of a rung, in words."""
    return f"polynomial, degree {degree}" if degree else model


def _angle(camera: lb.LensCamera, radius: float) -> float:
    """The field angle (degrees) of a film point so far from the axis: of the ray through the middle of its region."""
    film = camera.film
    across = film.pixels_x * (0.5 - radius / film.width)
    rays = camera.generate_rays([[across, 0.5 * film.pixels_y]], [[0.0, 0.0]])
    return math.degrees(math.acos(-float(rays.directions[0, 2])))


def field(label: str) -> Stress:
    """Ever larger films."""
    lens = lenses.load(LENSES[label])
    halves = np.geomspace(0.2, _circle(lens), 10)
    angles = np.array([_angle(lb.LensCamera(lens, _film(half * 1.3), FOCUS), half) for half in halves])
    return Stress(f"Models over the field, {label}", "Field angle at the film's corner", "°", angles,
                  "Place and size of blurs", "px", PIXELS, WHY, _curves([_judge(lens, half, None, FOCUS)
                                                                        for half in halves]),
                  "Wide open, at 2 m. Ideal models know no distortion; they hold for the middle of the picture.")


def f_number(label: str) -> Stress:
    """Ever wider stops."""
    lens = lenses.load(LENSES[label])
    widest = lb.first_order(lens).f_number * 1.0001
    values = np.geomspace(32.0, widest, 10)
    half = 0.5 * _circle(lens)
    return Stress(f"Models as the stop opens, {label}", "f-number", "", values, "Place and size of blurs", "px", PIXELS,
                  WHY, _curves([_judge(lens, half, float(value), FOCUS) for value in values]),
                  "Half of the field, at 2 m. A wider pupil has more aberration for a polynomial to follow.")


def object_distance(label: str) -> Stress:
    """Ever nearer things, in focus."""
    lens = lenses.load(LENSES[label])
    values = np.geomspace(1e5, 1.5 * lb.nearest_focus(lens), 10)
    half = 0.5 * _circle(lens)
    return Stress(f"Models near by, {label}", "Distance in focus", "mm", values, "Place and size of blurs", "px",
                  PIXELS, WHY, _curves([_judge(lens, half, 4.0 if lb.first_order(lens).f_number < 4.0 else None,
                                               float(value)) for value in values]),
                  "Half of the field, f/4. Things stand from four fifths of that distance to twice as far.")


STRESSES: dict[str, Callable[[], Stress]] = {
    f"{title}, {label}": partial(stress, label) for title, stress in (
        ("Models over the field", field), ("Models as the stop opens", f_number), ("Models near by", object_distance))
    for label in LENSES}


@dataclass(frozen=True, eq=False)
class Domain:
    """Which model is the simplest that will do, for one lens over its field and stops: the map of its domains.

    rung (f-numbers, film sizes): index into LADDER, of the first within PIXELS and STOPS; the last is the trace.
    half_diagonals: mm; angles: degrees at the film's corners.
    """

    lens: str
    half_diagonals: np.ndarray
    angles: np.ndarray
    f_numbers: np.ndarray
    rung: np.ndarray


def domain(lens_name: str, sizes: int = 7, stops: int = 5) -> Domain:
    """The map of one lens, in focus at 2 m or as near as it can."""
    lens = lenses.load(lens_name)
    focus = max(FOCUS, 2.0 * lb.nearest_focus(lens))
    widest = lb.first_order(lens).f_number * 1.0001
    numbers = np.geomspace(max(22.0, 2.0 * widest), widest, stops)
    halves = np.geomspace(0.5, _circle(lens), sizes)
    angles = np.array([_angle(lb.LensCamera(lens, _film(half * 1.3), focus), half) for half in halves])
    rung = np.full((stops, sizes), len(RUNGS))
    for i, number in enumerate(numbers):
        first = 0
        for j, half in enumerate(halves):
            judge = _judge(lens, half, float(number), focus)
            # a larger film holds the smaller one: what failed there fails here
            while first < len(RUNGS) and not _good(judge.rung(*RUNGS[first])):
                first += 1
            rung[i, j] = first
    return Domain(lens_name, halves, angles, numbers, rung)


def _good(rung: Rung) -> bool:
    return rung.error_px <= PIXELS and rung.error_stops <= STOPS
