"""Circles of confusion and depth of field.

A circle of confusion is a diameter on the film, in mm. The closed forms of the
thin lens measure distances from the lens; those of a real lens measure from the
film, as focusing does. Every distance may be math.inf, every one may be an array. A lens with a cylinder or
toroid draws ellipses: 2√2 × their rms radius is told, the diameter of the disk that is spread as far.
"""

from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from lensbench.optics.axial_bundle import pupil_rays
from lensbench.optics.focus import FocusError
from lensbench.optics.paraxial import ray_matrix
from lensbench.optics.prescription import Lens, LensError


def circle_of_confusion(focal_length: float, f_number: float, focus_distance: ArrayLike, distance: ArrayLike):
    """CoC diameter (mm) of a thin lens focused at focus_distance for points at distance, both mm from the lens.

    A f |s − s_f| / (s (s_f − f)), A = f / N. A float for floats, an array for
    arrays. FocusError where the focus lies within f or a distance is not positive;
    LensError where f or the f-number is not a positive number.
    """
    s_f, s = np.asarray(focus_distance, dtype=np.float64), np.asarray(distance, dtype=np.float64)
    _check_thin_lens(focal_length, f_number, s_f)
    if not np.all(s > 0.0):
        raise FocusError("a distance from the lens must be positive")
    # |s − s_f| / (s (s_f − f)); the greater divisor first, and where one is infinite its quotient is 1
    extension = s_f - focal_length
    far, near = np.maximum(s, extension), np.minimum(s, extension)
    with np.errstate(invalid="ignore"):
        share = np.where(np.isinf(far), np.isfinite(near), np.abs(s - s_f) / far)
    return _plain(focal_length / f_number * focal_length * share / near)


def hyperfocal(focal_length: float, f_number: float, limit: float) -> float:
    """The focus (mm from the lens) whose far limit is just inf, f² / (N C) + f, for a CoC limit C (mm)."""
    _check_thin_lens(focal_length, f_number, np.asarray(np.inf))
    _check_limit(limit)
    return focal_length**2 / (f_number * limit) + focal_length


def depth_of_field(focal_length: float, f_number: float, focus_distance: ArrayLike, limit: float):
    """(near, far): the distances (mm from the lens) between which the CoC of a thin lens stays below limit (mm).

    far is inf from the hyperfocal on. Floats for a float, arrays for an array.
    FocusError where the focus lies within f; LensError where f, the f-number or
    the limit is not a positive number.
    """
    s_f = np.asarray(focus_distance, dtype=np.float64)
    _check_thin_lens(focal_length, f_number, s_f)
    _check_limit(limit)
    # near, far = s f² / (f² ± N C (s − f)), s and s − f alike where both are infinite
    whole, blur = focal_length**2, f_number * limit * (s_f - focal_length)
    far, near = np.full(s_f.shape, np.inf), np.full(s_f.shape, whole / (f_number * limit))
    np.multiply(s_f, whole / np.where(blur < whole, whole - blur, 1.0), out=far, where=blur < whole)
    np.multiply(s_f, whole / (whole + blur), out=near, where=np.isfinite(blur))
    return _plain(near), _plain(far)


def thick_circle_of_confusion(lens: Lens, film_distance: float, distances: ArrayLike) -> np.ndarray:
    """CoC diameters (mm), paraxially, of axis points at distances (n,) mm from the film.

    The marginal rays of the stop, carried to the film by the ABCD matrix. nan for a
    point that lies within the lens.
    """
    film_gap = film_distance / lens.indices()[-1]
    before = np.atleast_1d(np.asarray(distances, dtype=np.float64)) - film_distance - lens.length
    squares = []
    for section in lens.sections:
        a, b, c, d = ray_matrix(section, 0, len(lens.surfaces))
        a_stop, b_stop, _, _ = ray_matrix(section, 0, lens.stop_index)
        with np.errstate(divide="ignore", invalid="ignore"):
            nearness = lens.front_index / before        # reduced slope for each mm at the first vertex; 0 at infinity
            at_film = (a + film_gap * c) + (b + film_gap * d) * nearness    # heights for each mm there
            at_stop = a_stop + b_stop * nearness
            squares.append((2.0 * lens.stop.semi_diameter * at_film / at_stop) ** 2)
    return np.where(before > 0.0, np.sqrt(np.mean(squares, 0)), np.nan)


def real_circle_of_confusion(lens: Lens, film_distance: float, distances: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """(2√2 rms radius, full extent) in mm on the film of the traced spots of axis points at distances (n,) mm.

    Distances from the film; the bundle fills the pupil that all rims leave, evenly
    over the plane of the first vertex. For a uniform disk both are its diameter.
    nan for a point that lies within the lens.
    """
    before = np.atleast_1d(np.asarray(distances, dtype=np.float64)) - film_distance - lens.length
    outside = before > 0.0
    nearness = 1.0 / before[outside]
    places, slopes, weights = pupil_rays(lens, nearness)
    radii = np.hypot(*np.moveaxis(places + film_distance * slopes, 2, 0))
    spread, extent = np.full((2, len(before)), np.nan)
    spread[outside] = 2.0 * np.sqrt(2.0 * (weights * radii**2).sum(1))
    extent[outside] = 2.0 * radii.max(axis=1)
    return spread, extent


def _plain(values: np.ndarray):
    return values if np.ndim(values) else float(values)


def _check_thin_lens(focal_length: float, f_number: float, focus_distance: np.ndarray) -> None:
    if not (isfinite(focal_length) and focal_length > 0.0):
        raise LensError(f"focal length {focal_length:g} mm: it must be a positive finite number")
    if not (isfinite(f_number) and f_number > 0.0):
        raise LensError(f"f-number {f_number:g}: it must be a positive finite number")
    if not np.all(focus_distance > focal_length):
        raise FocusError(f"focus at {np.min(focus_distance) / 1000.0:.4g} m: a thin lens of {focal_length:g} mm "
                         f"focuses only beyond its focal length, {focal_length / 1000.0:.4g} m")


def _check_limit(limit: float) -> None:
    if not (isfinite(limit) and limit > 0.0):
        raise LensError(f"limit {limit:g} mm of the circle of confusion: it must be a positive finite number")
