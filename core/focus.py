"""Focusing: where the film must stand for an object's distance, and what plane a film is focused on.

Lengths in mm. The object's distance is measured from the film plane, as engraved on
a lens, and math.inf is allowed. The film distance runs from the last vertex to the
film. The film stands in air; before the lens there may be water (`Lens.front_index`).

A lens moves as a whole (unit focusing), unless its positions say how its groups move
to focus. Then the film stands where those positions put it, the last gap behind the
last vertex, moved once for each zoom setting so that infinity is sharp: between the
stations of a zoom this takes up what interpolation leaves (a maker's cam has no such
error), at the stations the rounding of the table. The groups stand where the object's
image falls on that film, up to the nearest of their stations and no further.
"""

from functools import lru_cache
from math import ceil, floor, inf, isinf, log10, sqrt

import numpy as np

from lensbench.axial_bundle import ZONES, trace_bundles, zone_rule
from lensbench.paraxial import FirstOrder, first_order, ray_matrix
from lensbench.prescription import Lens, LensError
from lensbench.roots import least, root
from lensbench.tracing import surface_table

METHODS = ("paraxial", "real")
ROUNDING = 4e-15                # of the lens's length: what the place of an image can be known to


class FocusError(LensError):
    """A distance at which this lens cannot be focused; the message names the nearest one in metres."""


def film_distance(lens: Lens, focus_distance: float, method: str = "paraxial") -> float:
    """Last vertex → film (mm) for an object at focus_distance (mm) from the film.

    "paraxial": the thick lens in closed form. "real": the film stands where the real
    bundle of the object, over the full pupil, has its least rms blur. Of a lens with
    focus groups: behind `focused(lens, focus_distance, method)`. FocusError where
    the object is nearer than the lens can focus, or where the lens forms no real image.
    Of a lens with a cylinder or toroid, the section y–z is focused; x–z may want another film.
    """
    if method not in METHODS:
        raise ValueError(f"focus method {method!r}: it must be 'paraxial' or 'real'")
    if lens.has_focus_groups:
        moved = focused(lens, focus_distance, method)
        return moved.surfaces[-1].thickness + _travel(moved.at(close=0.0), method)[0]
    if method == "real":
        return _real_film_distance(lens, focus_distance)
    fo = _focusable(lens)
    _check_distance(focus_distance, nearest_focus(lens))
    # With T = s + s' between the conjugates and e = s' − f: e² − (T − (n + 1) f) e + n f² = 0, of which the small root
    n, f = lens.front_index, fo.efl
    free = focus_distance - _hiatus(lens, fo) - (n + 1.0) * f
    return fo.bfl + 2.0 * n * f * (f / (free * (1.0 + sqrt(max(0.0, 1.0 - 4.0 * n * (f / free) ** 2)))))


def focused(lens: Lens, focus_distance: float, method: str = "paraxial") -> Lens:
    """The lens with its focus groups where an object at focus_distance (mm) from the film asks for them.

    A lens without such groups as it is: its film moves. Methods and FocusError as
    for film_distance.
    """
    if not lens.has_focus_groups:
        return lens
    image = _image_distance if method == "paraxial" else _real_image_distance
    at_infinity = lens.at(close=0.0)
    off, nearest = _travel(at_infinity, method)
    if focus_distance == inf:
        return at_infinity
    _check_distance(focus_distance, nearest)

    def excess(close: float) -> float:
        """By how much the film lies behind the image."""
        moved = lens.at(close=close)
        film = moved.surfaces[-1].thickness + off
        return film - image(moved, focus_distance - moved.length - film)

    small = ROUNDING * (at_infinity.length + lens.surfaces[-1].thickness)
    here = lens.positions.close if lens.positions else 0.0
    if here and abs(excess(here)) <= small:         # it stands there already
        return lens.at()
    if not excess(1.0) > 0.0:                       # the nearest distance itself
        return lens.at(close=1.0)
    return lens.at(close=root(excess, 0.0, 1.0, small))


def nearest_focus(lens: Lens) -> float:
    """The nearest object that the lens can focus: mm from the film, paraxially.

    By unit focusing: where object and image are nearest to each other, f (1 + √n)² + the
    hiatus with n the index before the lens (in air at magnification −1), or where the object
    would touch the first vertex if that is farther. By focus groups: at the nearest of their
    stations; inf where that is no nearer than infinity. FocusError where the lens
    forms no real image.
    """
    if lens.has_focus_groups:
        return _travel(lens.at(close=0.0), "paraxial")[1]
    fo = _focusable(lens)
    n = lens.front_index
    object_distance = max((n + sqrt(n)) * fo.efl, fo.front_principal)       # from the front principal plane
    return _hiatus(lens, fo) + object_distance + fo.efl * object_distance / (object_distance - n * fo.efl)


def focused_distance(lens: Lens, film_distance: float) -> float:
    """The plane in focus, mm from the film, for a film at film_distance (mm) from the last vertex: the inverse.

    Of the lens as it stands, groups included. inf where the film stands at the rear
    focus or nearer to the lens. Beyond magnification −1 the distance grows again, and
    unit focusing would find the other, shorter place of the film for it.
    """
    fo = _focusable(lens)
    extension = film_distance - fo.bfl
    if not extension > 0.0:
        return inf
    n = lens.front_index
    return _hiatus(lens, fo) + (n + 1.0) * fo.efl + extension + n * fo.efl**2 / extension


def _real_film_distance(lens: Lens, focus_distance: float) -> float:
    """By the object's distance x before the first vertex: x + length + image distance(x) = focus_distance."""
    fo = _focusable(lens)
    table = surface_table(lens)
    if focus_distance == inf:
        return _least_blur(table, 0.0)
    if not focus_distance > 0.0:
        _check_distance(focus_distance, nearest_focus(lens))

    def excess(x: float) -> float:
        return x + lens.length + _least_blur(table, 1.0 / x) - focus_distance

    # The sum of the conjugates is least near magnification −1; the object lies on the far side of that
    n = lens.front_index
    near = max((n + sqrt(n)) * fo.efl, fo.front_principal) - fo.front_principal
    near = max(near, 1e-6 * fo.efl)
    if not focus_distance > 2.0 * nearest_focus(lens):
        near = least(excess, 0.5 * near, 2.0 * near)
    nearest = excess(near) + focus_distance
    _check_distance(focus_distance, nearest)
    if focus_distance == nearest:
        return _least_blur(table, 1.0 / near)
    far = max(focus_distance - lens.length, near)
    while excess(far) < 0.0:                            # an image before the last vertex: the object is farther still
        far *= 2.0
    return _least_blur(table, 1.0 / root(excess, near, far))


@lru_cache(maxsize=64)
def _travel(at_infinity: Lens, method: str) -> tuple[float, float]:
    """By how much (mm) the film stands behind the last gap of the positions, and the nearest distance in focus.

    The film so that infinity is sharp; the distance (from the film) by the last focus
    station, inf where that is no nearer.
    """
    fo = _focusable(at_infinity)
    sharp = fo.bfl if method == "paraxial" else _least_blur(surface_table(at_infinity), 0.0)
    off = sharp - at_infinity.surfaces[-1].thickness
    moved = at_infinity.at(close=1.0)
    film = moved.surfaces[-1].thickness + off
    nearest = focused_distance(moved, film)
    if method == "paraxial" or nearest == inf:
        return off, nearest
    table = surface_table(moved)
    low = high = 1.0 / max(nearest - moved.length - film, 1e-6 * fo.efl)     # of the paraxial object
    while _least_blur(table, low) > film:
        low *= 0.5
    while _least_blur(table, high) < film:
        high *= 1.5
    nearness = root(lambda nearness: _least_blur(table, nearness) - film, low, high)
    return off, moved.length + film + 1.0 / nearness


def _image_distance(lens: Lens, object_distance: float) -> float:
    """Last vertex → paraxial image (mm) of the axis point so far before the first vertex."""
    a, b, c, d = ray_matrix(lens, 0, len(lens.surfaces))
    object_distance /= lens.front_index
    return -(a * object_distance + b) / (c * object_distance + d)


def _real_image_distance(lens: Lens, object_distance: float) -> float:
    return _least_blur(surface_table(lens), 1.0 / object_distance)


def _least_blur(table: np.ndarray, nearness: float) -> float:
    """Last vertex → plane of the least rms radius (mm), for the axis point of this nearness."""
    zones, weights = zone_rule()
    heights, slopes = np.empty((1, ZONES)), np.empty((1, ZONES))
    trace_bundles(table, np.array([nearness]), zones, heights, slopes)
    return float(-(weights * heights[0] * slopes[0]).sum() / (weights * slopes[0] ** 2).sum())


def _hiatus(lens: Lens, fo: FirstOrder) -> float:
    """Front → rear principal plane (mm)."""
    return lens.length + fo.rear_principal - fo.front_principal


def _focusable(lens: Lens) -> FirstOrder:
    if lens.indices()[-1] != 1.0:
        raise FocusError("this lens ends in glass: its film must stand in air")
    fo = first_order(lens)
    if isinf(fo.efl) or fo.efl < 0.0:
        raise FocusError("this lens does not converge: it forms no real image and has no nearest distance")
    return fo


def _check_distance(focus_distance: float, nearest: float) -> None:
    if not focus_distance >= nearest:
        raise _too_near(focus_distance, nearest)


def _too_near(focus_distance: float, nearest: float) -> FocusError:
    told = f"{_rounded_up(nearest / 1000.0):.4g} m from the film" if nearest < inf else \
        "infinity: its focus groups reach no nearer object"
    return FocusError(f"focus at {focus_distance / 1000.0:.6g} m: the nearest distance of this lens is {told}")


def _rounded_up(value: float) -> float:
    """To four digits, upwards, so that a named limit is itself allowed."""
    unit = 10.0 ** (floor(log10(value)) - 3)
    return ceil(value / unit) * unit
