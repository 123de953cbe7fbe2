"""Focusing: the film distance for an object's distance, and the plane in focus for a film distance.

Lengths in mm. The object's distance is measured from the film, as engraved on a lens, and may be math.inf. The film
distance runs from the last vertex to the film, which is in air; before the lens there may be water.

A lens moves as a whole (unit focusing) unless its positions describe moving groups. Then the film is at the last gap of
those positions, corrected once for each zoom position so that infinity is sharp: this compensates the interpolation
between tabulated positions, which a maker's cam does not have, and the rounding of the table.

A lens with cylinders has different foci in its sections x–z and y–z (`section_foci`). Its film lies where the whole
pupil has the least rms blur: paraxially at their mean, each weighted by the square of its cone's slope; at the focus of
the one section that converges, if only one does.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from math import ceil, floor, inf, log10, nan, sqrt

import numpy as np

from lensbench.core.kernels.numeric import find_minimum, find_root
from lensbench.core.optics.axial_bundle import pupil_rays
from lensbench.core.optics.axis_contrast import D_LIGHT, Light, best_contrast
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LensError, check_film_distance
from lensbench.core.optics.paraxial import FirstOrder, first_order, ray_matrix
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import fixed, significant

METHODS = ("paraxial", "real", "contrast")
FAR_NEARNESS = 1e-3             # of an object a thousand focal lengths away
MOST_STEPS = 200                # of a bracket; twenty suffice for magnification 1
ROUNDING = 4e-15                # rounding error of the place of an image, over the lens's length
LARGEST_SQUARE = 0.5           # of a magnification: nearer, the film no longer follows the object's distance
SAME = 4e-15                    # relative difference of distances that differ by rounding alone


class FocusError(LensError):
    """A distance at which the lens cannot be focused; the message gives the nearest one in metres."""


def film_distance(lens: Lens, focus_distance: float, method: str = "paraxial", light: Light = D_LIGHT) -> float:
    """Film distance that focuses a lens on an object.

    Args:
        lens: The lens. One with focus groups is taken as `focused(lens, focus_distance, method)`.
        focus_distance: Film → object (mm); math.inf is allowed.
        method: {"paraxial", "real", "contrast"}. "paraxial": the thick lens in closed form. "real": least rms blur of
            the traced bundle over the full pupil. The former ignores decentres and tilts: it focuses the centred lens.
            For a lens with a cylinder or toroid both are the best compromise between its two foci; "paraxial" is the
            limit of "real" as the stop closes. "contrast": best contrast of 30 cycles/mm on the axis, near the least
            blur; focus groups stay where they are for that, and the film moves.
        light: Wavelengths (µm) and weights of the light whose contrast counts.
    Returns:
        Last vertex → film (mm).
    Raises:
        FocusError: If the object is nearer than the lens can focus, or if the lens forms no real image.
        ValueError: For another method.
    """
    _check_method(method)
    if method == "contrast":
        film, shift = film_distance(lens, focus_distance, "real"), contrast_shift(lens, focus_distance, light)
        fo, before = first_order(lens), focus_distance - lens.length - film
        if focus_distance == inf or lens.has_focus_groups:
            return film + shift
        # Away from the object by as much, the lens forms its image nearer by m² times that
        return film + shift / (1.0 - min(lens.front_index * (fo.efl / (before + fo.ffl))**2, LARGEST_SQUARE))
    if lens.has_focus_groups:
        moved = focused(lens, focus_distance, method)
        return moved.surfaces[-1].thickness + _travel(moved.at(close=0.0), method)[0]
    if method == "real" or len(lens.sections) > 1:
        return _solved(lens, focus_distance, method)
    fo = _focusable(lens)
    _check_distance(focus_distance, nearest_focus(lens))
    # Small root of e² − (T − (n + 1) f) e + n f² = 0, with e = s' − f and T = s + s' between the conjugates
    n, f = lens.front_index, fo.efl
    free = focus_distance - _hiatus(lens, fo) - (n + 1.0) * f
    return fo.bfl + 2.0 * n * f * (f / (free * (1.0 + sqrt(max(0.0, 1.0 - 4.0 * n * (f / free) ** 2)))))


@lru_cache(maxsize=64)
def contrast_shift(lens: Lens, focus_distance: float, light: Light = D_LIGHT) -> float:
    """How far behind the film of the least blur that of the best contrast lies.

    Args:
        lens, focus_distance, light: As for `film_distance`.
    Returns:
        mm; 0 where no ray passes.
    Raises:
        FocusError: As `film_distance`.
    """
    film, moved = film_distance(lens, focus_distance, "real"), focused(lens, focus_distance, "real")
    best = best_contrast(moved, film, focus_distance - moved.length - film, light)
    return 0.0 if best != best else best - film


def best_focus(lens: Lens, wavelengths: Sequence[float] = (D_LINE,), weights: Sequence[float] | None = None,
               object_distance: float = inf) -> float:
    """Best focus of a lens: the film of the least rms spot of an axis point, about its centroid in all wavelengths.

    At the d line it is what `film_distance(lens, distance, "real")` finds for a lens that moves as a whole. Improve and
    Tolerances focus their lenses by the same definition, in their own wavelengths.

    Args:
        lens: The lens, its focus groups as they are, with the stop as it is; the rays cover the whole open pupil.
        wavelengths: µm.
        weights: Of the wavelengths; None: alike.
        object_distance: Axis point → first vertex (mm).
    Returns:
        Last vertex → film (mm); NaN where no ray passes.
    """
    shares = np.ones(len(wavelengths)) if weights is None else np.asarray(weights, float)
    traced = [pupil_rays(lens, np.array([1.0 / object_distance]), wavelength) for wavelength in wavelengths]
    places, slopes = (np.concatenate([one[quantity][0] for one in traced]) for quantity in (0, 1))
    rays = np.concatenate([share * one[2][0] for share, one in zip(shares / shares.sum(), traced, strict=True)])
    if not lens.is_centred:                             # the spot lies beside the axis: its blur is about its centroid
        places, slopes = places - rays @ places, slopes - rays @ slopes
    axes = _converging(lens) if len(lens.sections) > 1 else [0, 1]
    return sharpest(places[:, axes], slopes[:, axes], rays[:, None])


def focused(lens: Lens, focus_distance: float, method: str = "paraxial") -> Lens:
    """The lens with its focus groups moved for an object.

    Args:
        lens: The lens; one without focus groups is returned as it is, since its film moves.
        focus_distance: Film → object (mm); math.inf is allowed.
        method: {"paraxial", "real", "contrast"}. As for `film_distance`; "contrast" as "real".
    Raises:
        FocusError: If the object is nearer than the lens can focus.
    """
    _check_method(method)
    return _focused(lens, focus_distance, method.replace("contrast", "real")) if lens.has_focus_groups else lens


@lru_cache(maxsize=64)
def _focused(lens: Lens, focus_distance: float, method: str) -> Lens:
    at_infinity = lens.at(close=0.0)
    off, nearest = _travel(at_infinity, method)
    if focus_distance == inf:
        return at_infinity
    _check_distance(focus_distance, nearest)

    def excess(close: float) -> float:
        """Distance of the film behind the image."""
        moved = lens.at(close=close)
        film = moved.surfaces[-1].thickness + off
        return film - _imager(moved, method)(1.0 / (focus_distance - moved.length - film))

    small = ROUNDING * (at_infinity.length + lens.surfaces[-1].thickness)
    current = lens.positions.close if lens.positions else 0.0
    if current and abs(excess(current)) <= small:         # the current position is right
        return lens.at()
    if not excess(1.0) > 0.0:                       # the nearest distance
        return lens.at(close=1.0)
    return lens.at(close=find_root(excess, 0.0, 1.0, small))


def nearest_focus(lens: Lens, method: str = "paraxial") -> float:
    """Nearest focus distance of a lens.

    With unit focusing it is where object and image are nearest to each other, paraxially f (1 + √n)² + the
    hiatus with n the index in front of the lens (in air at magnification −1), or where the object
    would touch the first vertex if that is farther. With focus groups it is that of the nearest
    station; inf if that is not nearer than infinity.

    Args:
        lens: The lens.
        method: {"paraxial", "real", "contrast"}. As for `film_distance`: aberrations move the image, and so the nearest
            distance. "contrast" as "real".
    Returns:
        Film → object (mm).
    Raises:
        FocusError: If the lens forms no real image.
        ValueError: For another method.
    """
    _check_method(method)
    method = method.replace("contrast", "real")
    if lens.has_focus_groups:
        return _travel(lens.at(close=0.0), method)[1]
    fo = _focusable(lens)
    if method == "real" or len(lens.sections) > 1:
        return _conjugates(lens, _imager(lens, method))[1]
    n = lens.front_index
    object_distance = max((n + sqrt(n)) * fo.efl, fo.front_principal)       # from the front principal plane
    return _hiatus(lens, fo) + object_distance + fo.efl * object_distance / (object_distance - n * fo.efl)


def focused_distance(lens: Lens, film_distance: float) -> float:
    """Plane in focus of a lens at its current position: the inverse of `film_distance`, paraxially.

    Beyond magnification −1 the distance grows again, and
    unit focusing would choose the other, shorter film distance for it. For a lens with a cylinder or toroid it is the
    plane whose best focus lies on the film.

    Args:
        lens: The lens, its focus groups as they are.
        film_distance: Last vertex → film (mm).
    Returns:
        Film → object in focus (mm); inf if the film is at the rear focus or nearer to the lens.
    Raises:
        FocusError: If the lens forms no real image.
        LensError: If the film distance is not finite.
    """
    check_film_distance(film_distance)
    fo = _focusable(lens)
    if len(lens.sections) > 1:
        return _object_of(lens, film_distance, _imager(lens, "paraxial"))
    extension = film_distance - fo.bfl
    if not extension > 0.0:
        return inf
    n = lens.front_index
    return _hiatus(lens, fo) + (n + 1.0) * fo.efl + extension + n * fo.efl**2 / extension


@lru_cache(maxsize=64)
def _solved(lens: Lens, focus_distance: float, method: str) -> float:
    """`_solved_film_distance`, cached: a camera and its read-outs ask for it repeatedly."""
    return _solved_film_distance(lens, focus_distance, _imager(lens, method))


def _solved_film_distance(lens: Lens, focus_distance: float, image: Callable[[float], float]) -> float:
    """Film distance (mm) that solves x + length + image(1 / x) = focus_distance, x from object to first vertex."""
    if focus_distance == inf:
        _focusable(lens)
        return image(0.0)
    if not focus_distance > 0.0:
        _check_distance(focus_distance, nearest_focus(lens))

    def excess(x: float) -> float:
        return x + lens.length + image(1.0 / x) - focus_distance

    # Solve beyond the minimum of the sum of the conjugates
    near, nearest = _conjugates(lens, image, closely=not focus_distance > 2.0 * nearest_focus(lens))
    _check_distance(focus_distance, nearest)
    if focus_distance <= nearest:
        return image(1.0 / near)
    far = max(focus_distance - lens.length, near)
    while excess(far) < 0.0:                            # an image before the last vertex: the object is farther
        far *= 2.0
    return image(1.0 / find_root(excess, near, far))


def _conjugates(lens: Lens, image: Callable[[float], float], closely: bool = True) -> tuple[float, float]:
    """Nearest conjugates: the object's distance before the first vertex, and its distance from the film (mm).

    closely: find the minimum near magnification −1; otherwise its estimate, which suffices for a much farther object.
    """
    fo, n = _focusable(lens), lens.front_index

    def total(x: float) -> float:
        return x + lens.length + image(1.0 / x)

    near = max((n + sqrt(n)) * fo.efl, fo.front_principal) - fo.front_principal
    near = max(near, 1e-6 * fo.efl)
    near = find_minimum(total, 0.5 * near, 2.0 * near) if closely else near
    return near, total(near)


def _object_of(lens: Lens, film_distance: float, image: Callable[[float], float]) -> float:
    """Film → object in focus (mm) for a film distance (mm); inf for a film before the rear focus."""
    rear_focus = image(0.0)
    if not film_distance > rear_focus:
        return inf

    # An object nearer than the front focus has a virtual image or, of real rays, none: bracket from afar
    high, beyond = FAR_NEARNESS / _focusable(lens).efl, inf
    for _ in range(MOST_STEPS):
        behind = image(high)
        if behind >= film_distance:
            break
        if not behind >= rear_focus:
            beyond = high
            high *= 0.5
        else:
            high = min(1.5 * high, 0.5 * (high + beyond))
    else:
        raise FocusError(f"no object has its image {fixed(film_distance, 3)} mm behind the last vertex")
    nearness = find_root(lambda nearness: image(nearness) - film_distance, 0.0, high)
    return lens.length + film_distance + (1.0 / nearness if nearness > 0.0 else inf)


@lru_cache(maxsize=64)
def _travel(at_infinity: Lens, method: str) -> tuple[float, float]:
    """Offset (mm) of the film from the last gap that makes infinity sharp, and the nearest focus distance (mm)."""
    off = _imager(at_infinity, method)(0.0) - at_infinity.surfaces[-1].thickness
    moved = at_infinity.at(close=1.0)
    film = moved.surfaces[-1].thickness + off
    if method == "paraxial":
        return off, focused_distance(moved, film)
    return off, _object_of(moved, film, _imager(moved, method))


def _imager(lens: Lens, method: str) -> Callable[[float], float]:
    """The function from the nearness (1/mm) of an axis point before the first vertex to its image distance (mm)."""
    if method == "real":
        return lambda nearness: best_focus(lens, object_distance=1.0 / nearness if nearness else inf)
    rays = [_axial_ray(lens.sections[k]) for k in _converging(lens)]

    def of_sections(nearness: float) -> float:
        if len(rays) == 1:                              # one section: the stop's size has no effect
            height, slope, _ = rays[0](nearness)
            return -height / slope
        heights, slopes, stops = np.array([ray(nearness) for ray in rays]).T
        return sharpest(heights, slopes, (lens.stop.semi_diameter / stops) ** 2)
    return of_sections


def _axial_ray(lens: Lens) -> Callable[[float], tuple[float, float, float]]:
    """Function from nearness (1/mm) to height and slope behind a lens, and height at its stop, of a ray 1 mm high."""
    (a, b, c, d), (a_stop, b_stop, _, _) = (ray_matrix(lens, 0, end) for end in (len(lens.surfaces), lens.stop_index))
    n = lens.front_index

    def ray(nearness: float) -> tuple[float, float, float]:
        return a + b * nearness * n, c + d * nearness * n, a_stop + b_stop * nearness * n
    return ray


def _converging(lens: Lens) -> list[int]:
    """The sections that converge; all, where none does: one that only diverges does not count."""
    converging = [k for k, section in enumerate(lens.sections) if 0.0 < first_order(section, D_LINE).efl < inf]
    return converging if converging and len(lens.sections) > 1 else list(range(len(lens.sections)))


def sharpest(heights: np.ndarray, slopes: np.ndarray, weights: np.ndarray) -> float:
    """Distance that minimises Σ weights · (heights + distance · slopes)²; nan where no ray has a weight."""
    weighted = weights * slopes
    spread = np.sum(weighted * slopes)
    return float(-np.sum(weighted * heights) / spread) if spread > 0.0 else nan


def _check_method(method: str) -> None:
    """ValueError for a focus method that does not exist."""
    if method not in METHODS:
        raise ValueError(f"focus method {method!r}: it must be 'paraxial', 'real' or 'contrast'")


def _hiatus(lens: Lens, fo: FirstOrder) -> float:
    """Front → rear principal plane (mm)."""
    return lens.length + fo.rear_principal - fo.front_principal


def _focusable(lens: Lens) -> FirstOrder:
    """First-order data of a lens that forms a real image, at least by one of its sections; FocusError otherwise."""
    if lens.indices()[-1] != 1.0:
        raise FocusError("this lens ends in glass: its film must be in air")
    for section in reversed(lens.sections):
        fo = first_order(section, D_LINE)
        if 0.0 < fo.efl < inf:
            return fo
    raise FocusError("this lens does not converge: it forms no real image and has no nearest distance")


def _check_distance(focus_distance: float, nearest: float) -> None:
    """FocusError if the object is nearer than the nearest distance by more than rounding, both mm from the film."""
    if focus_distance >= min(nearest, nearest * (1.0 - SAME)):
        return
    limit = (f"{significant(_rounded_up(nearest / 1000.0), 4)} m from the film" if nearest < inf else
             "infinity: its focus groups reach no nearer object")
    raise FocusError(f"focus at {significant(focus_distance / 1000.0, 6)} m: the nearest distance of this "
                     f"lens is {limit}")


def _rounded_up(value: float) -> float:
    """The value, of either sign, rounded up to four digits, so that a limit in a message is itself allowed."""
    if value == 0.0:
        return value
    unit = 10.0 ** (floor(log10(abs(value))) - 3)
    return ceil(value / unit) * unit
