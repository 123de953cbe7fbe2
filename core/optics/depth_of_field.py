"""Circles of confusion and depth of field.

A circle of confusion is a diameter on the film, in mm. The closed forms of the
thin lens measure distances from the lens; those of a real lens measure them from the
film, as focusing does. Every distance may be math.inf, and may be an array. The spots of a lens with a cylinder or
toroid are ellipses; their diameter is 2√2 × the rms radius, that of a uniform disk of this rms radius.
"""

from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

from lensbench.kernels.figures import significant
from lensbench.optics.axial_bundle import pupil_rays
from lensbench.optics.focus import FocusError
from lensbench.optics.lens_surface import LensError, check_film_distance
from lensbench.optics.prescription import Lens


def circle_of_confusion(focal_length: float, f_number: float, focus_distance: ArrayLike, distance: ArrayLike):
    """Circle of confusion of a thin lens: A f |s − s_f| / (s (s_f − f)), A = f / N.

    Parameters
    ----------
    focal_length : float
        f in mm.
    f_number : float
        N, for an object at infinity.
    focus_distance : float or array_like
        s_f, lens → plane in focus (mm); broadcast against `distance`.
    distance : float or array_like
        s, lens → object (mm).

    Returns
    -------
    float or ndarray
        Diameters on the film (mm).

    Raises
    ------
    FocusError
        If the focus lies within f, or a distance is not positive.
    LensError
        If f or N is not a positive finite number.
    """
    s_f, s = np.asarray(focus_distance, dtype=np.float64), np.asarray(distance, dtype=np.float64)
    _check_thin_lens(focal_length, f_number, s_f)
    if not np.all(s > 0.0):
        raise FocusError("a distance from the lens must be positive")
    # |s − s_f| / (s (s_f − f)): divide by the greater one first; if it is infinite, that quotient is 1
    extension = s_f - focal_length
    far, near = np.maximum(s, extension), np.minimum(s, extension)
    with np.errstate(invalid="ignore"):
        share = np.where(np.isinf(far), np.isfinite(near), np.abs(s - s_f) / far)
    return _plain(focal_length / f_number * focal_length * share / near)


def hyperfocal(focal_length: float, f_number: float, limit: float) -> float:
    """Hyperfocal distance of a thin lens, f² / (N C) + f: the least focus distance whose far limit is infinite.

    Parameters
    ----------
    focal_length : float
        f in mm.
    f_number : float
        N, for an object at infinity.
    limit : float
        Greatest acceptable circle of confusion C on the film (mm).

    Returns
    -------
    float
        Lens → plane in focus (mm).

    Raises
    ------
    LensError
        If a number is not positive and finite.
    """
    _check_thin_lens(focal_length, f_number, np.asarray(np.inf))
    check_limit(limit)
    return focal_length**2 / (f_number * limit) + focal_length


def depth_of_field(focal_length: float, f_number: float, focus_distance: ArrayLike, limit: float):
    """Near and far limit of the depth of field of a thin lens.

    Parameters
    ----------
    focal_length : float
        f in mm.
    f_number : float
        N, for an object at infinity.
    focus_distance : float or array_like
        Lens → plane in focus (mm).
    limit : float
        Greatest acceptable circle of confusion on the film (mm).

    Returns
    -------
    (near, far) : floats or ndarrays
        Distances from the lens (mm); far is inf from the hyperfocal distance on.

    Raises
    ------
    FocusError
        If the focus lies within f.
    LensError
        If f, N or the limit is not a positive finite number.
    """
    s_f = np.asarray(focus_distance, dtype=np.float64)
    _check_thin_lens(focal_length, f_number, s_f)
    check_limit(limit)
    # near, far = s f² / (f² ± N C (s − f)); s / (s − f) is 1 where both are infinite
    whole, blur = focal_length**2, f_number * limit * (s_f - focal_length)
    far, near = np.full(s_f.shape, np.inf), np.full(s_f.shape, whole / (f_number * limit))
    np.multiply(s_f, whole / np.where(blur < whole, whole - blur, 1.0), out=far, where=blur < whole)
    np.multiply(s_f, whole / (whole + blur), out=near, where=np.isfinite(blur))
    return _plain(near), _plain(far)


def real_circle_of_confusion(lens: Lens, film_distance: float, distances: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Circles of confusion of a lens, from traced spots of axis points.

    The bundle fills the pupil that all rims leave open, evenly over the plane of the first vertex. For a uniform disk
    both results are its diameter.

    Parameters
    ----------
    lens : Lens
        The lens at its current focus positions.
    film_distance : float
        Last vertex → film (mm).
    distances : (n,) array_like
        Film → axis points (mm).

    Returns
    -------
    spread : (n,) ndarray
        2√2 × the rms radius of the spots on the film (mm); NaN for a point within the lens.
    extent : (n,) ndarray
        Their full extents (mm).

    Raises
    ------
    LensError
        If the film distance is not finite, or a distance is NaN.
    """
    check_points(film_distance, distances)
    before = np.atleast_1d(np.asarray(distances, dtype=np.float64)) - film_distance - lens.length
    outside = before > 0.0
    spread, extent = np.full((2, len(before)), np.nan)
    if not outside.any():
        return spread, extent
    nearness = 1.0 / before[outside]
    places, slopes, weights = pupil_rays(lens, nearness)
    spots = places + film_distance * slopes
    if not lens.is_in_line:                             # they lie beside the axis: their width is about their middle
        spots -= (weights[..., None] * spots).sum(1, keepdims=True)
    radii = np.hypot(*np.moveaxis(spots, 2, 0))
    spread[outside] = 2.0 * np.sqrt(2.0 * (weights * radii**2).sum(1))
    extent[outside] = 2.0 * radii.max(axis=1)
    return spread, extent


def check_points(film_distance: float, distances: ArrayLike) -> None:
    """LensError for a film distance that is not finite, and for distances film → axis points that are NaN (mm)."""
    check_film_distance(film_distance)
    if np.isnan(np.asarray(distances, dtype=np.float64)).any():
        raise LensError("distances of points: they must be numbers, and none is NaN")


def check_limit(limit: float) -> None:
    """LensError for a limit (mm) of the circle of confusion that is not positive and finite."""
    if not (isfinite(limit) and limit > 0.0):
        raise LensError(f"limit {significant(limit)} mm of the circle of confusion: it must be a positive "
                        f"finite number")


def _plain(values: np.ndarray):
    """A float for a 0-dimensional array."""
    return values if np.ndim(values) else float(values)


def _check_thin_lens(focal_length: float, f_number: float, focus_distance: np.ndarray) -> None:
    if not (isfinite(focal_length) and focal_length > 0.0):
        raise LensError(f"focal length {significant(focal_length)} mm: it must be a positive finite number")
    if not (isfinite(f_number) and f_number > 0.0):
        raise LensError(f"f-number {significant(f_number)}: it must be a positive finite number")
    if not np.all(focus_distance > focal_length):
        raise FocusError(f"focus at {significant(np.min(focus_distance) / 1000.0, 4)} m: a thin lens of "
                         f"{significant(focal_length)} mm "
                         f"focuses only beyond its focal length, {significant(focal_length / 1000.0, 4)} m")
