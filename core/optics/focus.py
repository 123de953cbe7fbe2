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

A lens with cylinders or toroids focuses the light of its section x–z at one place and that of y–z at another, which
come apart as the object comes nearer (`section_foci`). Its film stands between, where the whole pupil has the least
rms blur: paraxially at the mean of the two, each weighted by the square of its cone's slope. Where one section alone
converges, the film stands at its focus, which is a line.
"""

from collections.abc import Callable
from functools import lru_cache
from math import ceil, floor, inf, log10, sqrt

import numpy as np

from lensbench.kernels.root_finding import find_minimum, find_root
from lensbench.optics.axial_bundle import pupil_rays
from lensbench.optics.paraxial import FirstOrder, first_order, ray_matrix
from lensbench.optics.prescription import Lens, LensError

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
    Of a lens with a cylinder or toroid both are the best compromise between its two foci; "paraxial" is then
    the limit of "real" as the stop closes.
    """
    if method not in METHODS:
        raise ValueError(f"focus method {method!r}: it must be 'paraxial' or 'real'")
    if lens.has_focus_groups:
        moved = focused(lens, focus_distance, method)
        return moved.surfaces[-1].thickness + _travel(moved.at(close=0.0), method)[0]
    if method == "real" or not lens.is_rotationally_symmetric:
        return _solved(lens, focus_distance, method)
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
    at_infinity = lens.at(close=0.0)
    off, nearest = _travel(at_infinity, method)
    if focus_distance == inf:
        return at_infinity
    _check_distance(focus_distance, nearest)

    def excess(close: float) -> float:
        """By how much the film lies behind the image."""
        moved = lens.at(close=close)
        film = moved.surfaces[-1].thickness + off
        return film - _imager(moved, method)(1.0 / (focus_distance - moved.length - film))

    small = ROUNDING * (at_infinity.length + lens.surfaces[-1].thickness)
    here = lens.positions.close if lens.positions else 0.0
    if here and abs(excess(here)) <= small:         # it stands there already
        return lens.at()
    if not excess(1.0) > 0.0:                       # the nearest distance itself
        return lens.at(close=1.0)
    return lens.at(close=find_root(excess, 0.0, 1.0, small))


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
    if not lens.is_rotationally_symmetric:
        return _conjugates(lens, _imager(lens, "paraxial"))[1]
    n = lens.front_index
    object_distance = max((n + sqrt(n)) * fo.efl, fo.front_principal)       # from the front principal plane
    return _hiatus(lens, fo) + object_distance + fo.efl * object_distance / (object_distance - n * fo.efl)


def focused_distance(lens: Lens, film_distance: float) -> float:
    """The plane in focus, mm from the film, for a film at film_distance (mm) from the last vertex: the inverse.

    Of the lens as it stands, groups included. inf where the film stands at the rear
    focus or nearer to the lens. Beyond magnification −1 the distance grows again, and
    unit focusing would find the other, shorter place of the film for it. Of a lens with a cylinder or toroid the
    plane whose best focus lies on the film.
    """
    fo = _focusable(lens)
    if not lens.is_rotationally_symmetric:
        return _object_of(lens, film_distance, _imager(lens, "paraxial"))
    extension = film_distance - fo.bfl
    if not extension > 0.0:
        return inf
    n = lens.front_index
    return _hiatus(lens, fo) + (n + 1.0) * fo.efl + extension + n * fo.efl**2 / extension


def section_foci(lens: Lens, focus_distance: float, film_distance: float) -> tuple[float, float]:
    """Last vertex → paraxial focus (mm) of the sections x–z and y–z, for an object focus_distance mm from this film.

    Both are the same for a rotationally symmetric lens. For one with a cylinder or toroid the film can stand at
    either, or between; an infinite one has no power there, or its object at the focus.
    """
    nearness = 1.0 / (focus_distance - lens.length - film_distance)
    rays = [_axial_ray(section)(nearness) for section in lens.sections]
    foci = [-height / slope if slope else inf for height, slope, _ in rays]
    return foci[0], foci[-1]


@lru_cache(maxsize=64)
def _solved(lens: Lens, focus_distance: float, method: str) -> float:
    """Kept: a camera asks for it, and so does all that is told of its lens, while something else is changed."""
    return _solved_film_distance(lens, focus_distance, _imager(lens, method))


def _solved_film_distance(lens: Lens, focus_distance: float, image: Callable[[float], float]) -> float:
    """By the object's distance x before the first vertex: x + length + image distance(1 / x) = focus_distance."""
    if focus_distance == inf:
        _focusable(lens)
        return image(0.0)
    if not focus_distance > 0.0:
        _check_distance(focus_distance, nearest_focus(lens))

    def excess(x: float) -> float:
        return x + lens.length + image(1.0 / x) - focus_distance

    # The object lies on the far side of where the sum of the conjugates is least
    near, nearest = _conjugates(lens, image, closely=not focus_distance > 2.0 * nearest_focus(lens))
    _check_distance(focus_distance, nearest)
    if focus_distance == nearest:
        return image(1.0 / near)
    far = max(focus_distance - lens.length, near)
    while excess(far) < 0.0:                            # an image before the last vertex: the object is farther still
        far *= 2.0
    return image(1.0 / find_root(excess, near, far))


def _conjugates(lens: Lens, image: Callable[[float], float], closely: bool = True) -> tuple[float, float]:
    """The object's distance before the first vertex at which the film is nearest to it, and then from the film (mm).

    Near magnification −1, or where the object would touch the first vertex; closely: or else
    about there, where the object is nearer than one much farther.
    """
    fo, n = _focusable(lens), lens.front_index

    def total(x: float) -> float:
        return x + lens.length + image(1.0 / x)

    near = max((n + sqrt(n)) * fo.efl, fo.front_principal) - fo.front_principal
    near = max(near, 1e-6 * fo.efl)
    near = find_minimum(total, 0.5 * near, 2.0 * near) if closely else near
    return near, total(near)


def _object_of(lens: Lens, film_distance: float, image: Callable[[float], float]) -> float:
    """What lies in focus (mm from the film) for a film this far behind the last vertex; inf before the rear focus."""
    if not film_distance > image(0.0):
        return inf
    high = 1.0 / _focusable(lens).efl
    while image(high) < film_distance:
        high *= 1.5
    nearness = find_root(lambda nearness: image(nearness) - film_distance, 0.0, high)
    return lens.length + film_distance + 1.0 / nearness


@lru_cache(maxsize=64)
def _travel(at_infinity: Lens, method: str) -> tuple[float, float]:
    """By how much (mm) the film stands behind the last gap of the positions, and the nearest distance in focus.

    The film so that infinity is sharp; the distance (from the film) by the last focus
    station, inf where that is no nearer.
    """
    off = _imager(at_infinity, method)(0.0) - at_infinity.surfaces[-1].thickness
    moved = at_infinity.at(close=1.0)
    film = moved.surfaces[-1].thickness + off
    if method == "paraxial":
        return off, focused_distance(moved, film)
    return off, _object_of(moved, film, _imager(moved, method))


def _imager(lens: Lens, method: str) -> Callable[[float], float]:
    """Nearness (1/mm) of an axis point before the first vertex → last vertex to plane of its least rms blur (mm)."""
    converging = [k for k, section in enumerate(lens.sections) if 0.0 < first_order(section).efl < inf]
    which = converging or list(range(len(lens.sections)))           # what a section only spreads, no film can gather
    if method == "real":
        axes = [0, 1] if lens.is_rotationally_symmetric else which

        def of_rays(nearness: float) -> float:
            places, slopes, weights = pupil_rays(lens, np.array([nearness]))
            return _sharpest(places[0][:, axes], slopes[0][:, axes], weights[0, :, None])
        return of_rays

    rays = [_axial_ray(lens.sections[k]) for k in which]

    def of_sections(nearness: float) -> float:
        if len(rays) == 1:                              # the stop does not count
            height, slope, _ = rays[0](nearness)
            return -height / slope
        heights, slopes, stops = np.array([ray(nearness) for ray in rays]).T
        return _sharpest(heights, slopes, (lens.stop.semi_diameter / stops) ** 2)
    return of_sections


def _axial_ray(lens: Lens) -> Callable[[float], tuple[float, float, float]]:
    """Nearness of an axis point → height and slope behind the last vertex of its paraxial ray, and height at the stop.

    The ray is 1 mm high on the first vertex.
    """
    (a, b, c, d), (a_stop, b_stop, _, _) = (ray_matrix(lens, 0, end) for end in (len(lens.surfaces), lens.stop_index))
    n = lens.front_index

    def ray(nearness: float) -> tuple[float, float, float]:
        return a + b * nearness * n, c + d * nearness * n, a_stop + b_stop * nearness * n
    return ray


def _sharpest(heights: np.ndarray, slopes: np.ndarray, weights: np.ndarray) -> float:
    """The distance at which Σ weights · (heights + distance · slopes)² is least."""
    return float(-np.sum(weights * heights * slopes) / np.sum(weights * slopes * slopes))


def _hiatus(lens: Lens, fo: FirstOrder) -> float:
    """Front → rear principal plane (mm)."""
    return lens.length + fo.rear_principal - fo.front_principal


def _focusable(lens: Lens) -> FirstOrder:
    """First order of a lens that forms a real image, at least by one of its sections."""
    if lens.indices()[-1] != 1.0:
        raise FocusError("this lens ends in glass: its film must stand in air")
    for section in reversed(lens.sections):
        fo = first_order(section)
        if 0.0 < fo.efl < inf:
            return fo
    raise FocusError("this lens does not converge: it forms no real image and has no nearest distance")


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
