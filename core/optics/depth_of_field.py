"""Circles of confusion and depth of field: of the thin lens, of traced spots, and of the thick lens.

A circle of confusion is a diameter on the film. Lengths in mm. The thin lens measures distances from the lens, the
other two from the film, as focusing does; they may be math.inf. The spots of a lens with cylinders are ellipses, whose
diameter is 2√2 × the rms radius.

The thick lens is paraxial, at any focus and in any medium. With the reduced nearness ν = n / x of a point x before the
first vertex, ν′ that of the plane in focus, (a, b, c, d) the matrix of the lens, (a, b)ₛ the first row of that of the
surfaces before the stop, and r the stop's radius, the cone of the point is as wide on the film as

    2 r |ν − ν′| / (|c + d ν′| (aₛ + bₛ ν)).
"""

from functools import lru_cache
from math import inf, isfinite, nan
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.kernels.numeric import find_root
from lensbench.core.optics.axial_bundle import pupil_rays
from lensbench.core.optics.focus import FocusError, film_distance, focused_distance, nearest_focus
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LensError, check_film_distance
from lensbench.core.optics.paraxial import ray_matrix
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant


def circle_of_confusion(focal_length: float, f_number: float, focus_distance: ArrayLike, distance: ArrayLike) -> Any:
    """Circle of confusion of a thin lens: A f |s − s_f| / (s (s_f − f)), A = f / N.

    Args:
        focal_length: f in mm.
        f_number: N, for an object at infinity.
        focus_distance: s_f, lens → plane in focus (mm); broadcast against `distance`.
        distance: s, lens → object (mm).
    Returns:
        float or ndarray. Diameters on the film (mm).
    Raises:
        FocusError: If the focus lies within f, or a distance is not positive.
        LensError: If f or N is not a positive finite number.
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

    Args:
        focal_length: f in mm.
        f_number: N, for an object at infinity.
        limit: Greatest acceptable circle of confusion C on the film (mm).
    Returns:
        Lens → plane in focus (mm).
    Raises:
        LensError: If a number is not positive and finite.
    """
    _check_thin_lens(focal_length, f_number, np.asarray(np.inf))
    check_limit(limit)
    return focal_length**2 / (f_number * limit) + focal_length


def depth_of_field(focal_length: float, f_number: float, focus_distance: ArrayLike, limit: float) -> Any:
    """Near and far limit of the depth of field of a thin lens.

    Args:
        focal_length: f in mm.
        f_number: N, for an object at infinity.
        focus_distance: Lens → plane in focus (mm).
        limit: Greatest acceptable circle of confusion on the film (mm).
    Returns:
        (near, far): floats or ndarrays. Distances from the lens (mm); far is inf from the hyperfocal distance on.
    Raises:
        FocusError: If the focus lies within f.
        LensError: If f, N or the limit is not a positive finite number.
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

    Args:
        lens: The lens at its current focus positions.
        film_distance: Last vertex → film (mm).
        distances: (n,) array_like. Film → axis points (mm).
    Returns:
        spread: (n,) ndarray. 2√2 × the rms radius of the spots on the film (mm); NaN for a point within the lens.
        extent: (n,) ndarray. Their full extents (mm).
    Raises:
        LensError: If the film distance is not finite, or a distance is NaN.
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
    if not lens.is_centred:                             # they lie beside the axis: their width is about their middle
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


def _plain(values: np.ndarray) -> Any:
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


TOUCHING = 1e-3                 # mm: a hyperfocal distance of 0 counts as this one
SETTLED = 1e-12                 # of a nearness, times the film's distance


def thick_circle_of_confusion(lens: Lens, film_distance: float, distances: ArrayLike) -> np.ndarray:
    """Paraxial circles of confusion of a lens, from marginal rays of the stop by the ABCD matrix.

    Args:
        lens: The lens at its current focus positions.
        film_distance: Last vertex → film (mm).
        distances: (n,) array_like. Film → axis points (mm).
    Returns:
        (n,) ndarray. Diameters on the film (mm); NaN for a point within the lens.
    Raises:
        LensError: If the film distance is not finite, or a distance is NaN.
    """
    check_points(film_distance, distances)
    film_gap = film_distance / lens.indices()[-1]
    before = np.atleast_1d(np.asarray(distances, dtype=np.float64)) - film_distance - lens.length
    squares = []
    for section in lens.sections:
        a, b, c, d = ray_matrix(section, 0, len(lens.surfaces))
        a_stop, b_stop, _, _ = ray_matrix(section, 0, lens.stop_index)
        with np.errstate(divide="ignore", invalid="ignore"):
            nearness = lens.front_index / before        # reduced slope per mm of height at the first vertex
            at_film = (a + film_gap * c) + (b + film_gap * d) * nearness    # heights per mm there
            at_stop = a_stop + b_stop * nearness
            squares.append((2.0 * lens.equivalent_stop_radius * at_film / at_stop) ** 2)
    return np.where(before > 0.0, np.sqrt(np.mean(squares, 0)), np.nan)


def magnification(lens: Lens, film_distance: float, focus_distance: float, wavelength: float = D_LINE) -> float:
    """Paraxial magnification of the plane in focus.

    Args:
        lens: The lens at its current focus position.
        film_distance: Last vertex → film (mm), from which the object's distance before the lens follows.
        focus_distance: Film → plane in focus (mm); math.inf is allowed.
        wavelength: Micrometres.
    Returns:
        Size of the image to that of the object: positive, 0 at infinity. Of the section y–z of a lens with cylinders.
    Raises:
        LensError: If the plane in focus does not lie before the lens, or the film distance is not finite.
    """
    _, _, c, d = ray_matrix(lens, 0, len(lens.surfaces), wavelength)
    nearness = _nearness(lens, film_distance, focus_distance)
    return abs(nearness / (c + d * nearness)) if nearness else 0.0


def section_foci(lens: Lens, focus_distance: float, film_distance: float) -> tuple[float, float]:
    """Paraxial foci of the sections x–z and y–z; equal for a rotationally symmetric lens.

    Args:
        lens: The lens at its current position.
        focus_distance: Film → object (mm); math.inf is allowed.
        film_distance: Last vertex → film (mm), from which the object's distance before the lens follows.
    Returns:
        (float, float). Last vertex → focus (mm) in x–z and in y–z; inf for a section without power, or with the object
            at its focus.
    Raises:
        LensError: If the film distance is not finite, or the object lies on the first vertex or nowhere.
    """
    check_film_distance(film_distance)
    before = focus_distance - lens.length - film_distance
    if not abs(before) > 0.0:
        raise LensError(f"focus at {significant(focus_distance / 1000.0, 6)} m: the object must not touch the lens")
    nearness, behind = lens.front_index / before, lens.indices()[-1]
    foci = []
    for section in lens.sections:
        a, b, c, d = ray_matrix(section, 0, len(lens.surfaces))
        height, slope = a + b * nearness, c + d * nearness          # of the paraxial ray, 1 mm high on the first vertex
        foci.append(-behind * height / slope if slope else inf)
    return foci[0], foci[-1]


def thick_depth_of_field(lens: Lens, film_distance: float, focus_distance: float, limit: float) -> tuple[float, float]:
    """Near and far limit of the depth of field of a lens.

    Args:
        lens: The lens at its current focus position, stopped down.
        film_distance: Last vertex → film (mm).
        focus_distance: Film → plane in focus (mm); math.inf is allowed.
        limit: Greatest acceptable circle of confusion on the film (mm).
    Returns:
        (near, far): Film → limits (mm). far is inf from the hyperfocal distance on. near is that of the first vertex
            where even what touches the lens is sharp. Both are NaN for a lens with cylinders whose two foci blur every
            distance more.
    Raises:
        LensError: If the limit is not a positive finite number, the film distance not finite, or the plane in focus not
            before the lens.
    """
    check_limit(limit)
    focus = _nearness(lens, film_distance, focus_distance)
    if len(lens.sections) > 1:
        near, far = _between_sections(lens, film_distance, focus, limit)
    else:
        _, _, c, d = ray_matrix(lens, 0, len(lens.surfaces))
        a, b, _, _ = ray_matrix(lens, 0, lens.stop_index)
        share = limit * abs(c + d * focus) / (2.0 * lens.equivalent_stop_radius)
        share = share if a + b * focus > 0.0 else -share
        far = (focus - share * a) / (1.0 + share * b) if share * b > -1.0 else 0.0
        near = (focus + share * a) / (1.0 - share * b) if share * b < 1.0 else inf
    near, far = (inf if nearness <= 0.0 else lens.front_index / nearness for nearness in (near, far))   # keeps NaN
    return film_distance + lens.length + near, film_distance + lens.length + far


def thick_hyperfocal(lens: Lens, limit: float) -> float:
    """Hyperfocal distance of a lens: the least focus distance at which infinity is still sharp.

    Args:
        lens: The lens, stopped down. Its focus groups are moved to that distance, at most to their nearest position.
        limit: Greatest acceptable circle of confusion on the film (mm).
    Returns:
        Film → plane in focus (mm); 0 where infinity is sharp at every focus. Of the section y–z of a lens with
            cylinders.
    Raises:
        LensError: If the limit is not a positive finite number, or the lens does not converge.
    """
    check_limit(limit)
    return _of_groups(lens.at(close=0.0), limit) if lens.has_focus_groups else _hyperfocal(lens, limit)


@lru_cache(maxsize=64)
def _of_groups(lens: Lens, limit: float) -> float:
    """The hyperfocal distance (mm) of a lens whose groups, now at infinity, can focus on the one that it has there."""
    film = film_distance(lens, inf)

    def at(close: float) -> tuple[Lens, float]:
        moved = lens.at(close=close)
        return moved, film + moved.surfaces[-1].thickness - lens.surfaces[-1].thickness

    def excess(close: float) -> float:
        moved, film_at = at(close)
        return 1.0 / focused_distance(moved, film_at) - 1.0 / max(_hyperfocal(moved, limit, film_at), TOUCHING)

    if nearest_focus(lens) == inf:
        return _hyperfocal(lens, limit, film)
    moved, film_at = at(find_root(excess, 0.0, 1.0, SETTLED / film) if excess(1.0) > 0.0 else 1.0)
    return _hyperfocal(moved, limit, film_at)


def _hyperfocal(lens: Lens, limit: float, film_at: float | None = None) -> float:
    """The hyperfocal distance (mm) of a lens with still groups; film_at: last vertex → film (mm), None if free."""
    a, b, c, d = ray_matrix(lens, 0, len(lens.surfaces))
    a_stop = ray_matrix(lens, 0, lens.stop_index)[0]
    share = limit * abs(a_stop) / (2.0 * lens.equivalent_stop_radius)
    if not c < 0.0:
        raise LensError("this lens has no hyperfocal distance: it does not make distant light converge")
    if not 1.0 + share * d > 0.0:
        return 0.0
    nearness = -share * c / (1.0 + share * d)           # of ν = share · |c + d ν|, and c + d ν < 0
    if film_at is None:
        film_at = -lens.indices()[-1] * (a + b * nearness) * (1.0 + share * d) / c     # c + d ν = c / (1 + share · d)
    return lens.front_index / nearness + lens.length + film_at


def _nearness(lens: Lens, film_distance: float, distance: float) -> float:
    """Reduced nearness (1/mm) of a distance (mm) from the film; LensError where that is within the lens."""
    check_film_distance(film_distance)
    before = distance - film_distance - lens.length
    if not before > 0.0:
        raise LensError(f"focus at {significant(distance / 1000.0, 4)} m: that is within the lens")
    return lens.front_index / before


def _between_sections(lens: Lens, film_distance: float, focus: float, limit: float) -> tuple[float, float]:
    """Reduced nearness (1/mm) of the limits of a lens with cylinders, whose blur is the rms of its two sections."""
    gap = film_distance / lens.indices()[-1]
    wide, stops = [], []
    for section in lens.sections:
        a, b, c, d = ray_matrix(section, 0, len(lens.surfaces))
        a_stop, b_stop, _, _ = ray_matrix(section, 0, lens.stop_index)
        diameter = 2.0 * lens.equivalent_stop_radius
        wide.append(diameter * np.poly1d([b + gap * d, a + gap * c]))
        stops.append(np.poly1d([b_stop, a_stop]))
    excess = (wide[0] * stops[1]) ** 2 + (wide[1] * stops[0]) ** 2 - 2.0 * limit**2 * (stops[0] * stops[1]) ** 2
    if excess(focus) > 0.0:
        return nan, nan
    roots = np.sort(excess.roots[np.isreal(excess.roots)].real)
    after, before = roots[roots > focus], roots[roots < focus]
    return (float(after[0]) if len(after) else inf), (float(before[-1]) if len(before) else 0.0)
