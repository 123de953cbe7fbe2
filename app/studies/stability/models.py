"""Errors of each camera model in the picture against the traced lens, as `lb.choose_model` measures them."""

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.analysis.model_choice import LADDER
from lensbench.analysis.model_error import ModelErrors
from lensbench.app.studies.stability.sweep import Sweep, curve

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
    """Half diagonal (mm) of the film on which a lens is examined.

    Nine tenths of its image circle, at most full frame.
    """
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
    """Field angle (degrees) of a film point at a radius (mm).

    It is the angle of the ray through the middle of the exit-pupil region.
    """
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
