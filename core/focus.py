"""Focusing: where the film must stand for an object's distance, and what plane a film is focused on.

Lengths in mm. The whole lens moves (unit focusing); the object's distance is
measured from the film plane, as engraved on a lens, and math.inf is allowed. The
film distance runs from the last vertex to the film. Both sides are in air.
"""

from math import ceil, floor, inf, isinf, log10, sqrt

from lensbench.paraxial import FirstOrder, first_order
from lensbench.prescription import Lens, LensError


class FocusError(LensError):
    """A distance at which this lens cannot be focused; the message names the nearest one in metres."""


def film_distance(lens: Lens, focus_distance: float, method: str = "paraxial") -> float:
    """Last vertex → film (mm) for an object at focus_distance (mm) from the film.

    "paraxial": the thick lens in closed form. FocusError where the object is nearer
    than nearest_focus(lens), or where the lens forms no real image behind itself.
    """
    if method != "paraxial":
        raise ValueError(f"focus method {method!r}: it must be 'paraxial' or 'real'")
    fo = _focusable(lens)
    _check_distance(focus_distance, nearest_focus(lens))
    # With T = s + s' between the conjugates, s' − f = f x / (1 + √(1 − x))², x = 4 f / T: nothing cancels at infinity
    x = 4.0 * fo.efl / (focus_distance - _hiatus(lens, fo))
    return fo.bfl + fo.efl * x / (1.0 + sqrt(max(0.0, 1.0 - x))) ** 2


def nearest_focus(lens: Lens) -> float:
    """The nearest object that unit focusing can reach: mm from the film, paraxially.

    At magnification −1 (4 f + the hiatus), or where the object would touch the
    first vertex if that is farther. FocusError where the lens forms no real image.
    """
    fo = _focusable(lens)
    object_distance = max(2.0 * fo.efl, fo.front_principal)      # from the front principal plane
    return _hiatus(lens, fo) + object_distance + fo.efl * object_distance / (object_distance - fo.efl)


def focused_distance(lens: Lens, film_distance: float) -> float:
    """The plane in focus, mm from the film, for a film at film_distance (mm) from the last vertex: the inverse.

    inf where the film stands at the rear focus or nearer to the lens. Beyond
    magnification −1 the distance grows again, and film_distance would find the
    other, shorter place of the film for it.
    """
    fo = _focusable(lens)
    extension = film_distance - fo.bfl
    if not extension > 0.0:
        return inf
    return _hiatus(lens, fo) + 2.0 * fo.efl + extension + fo.efl**2 / extension


def _hiatus(lens: Lens, fo: FirstOrder) -> float:
    """Front → rear principal plane (mm)."""
    return lens.length + fo.rear_principal - fo.front_principal


def _focusable(lens: Lens) -> FirstOrder:
    fo = first_order(lens)
    if isinf(fo.efl) or fo.efl < 0.0:
        raise FocusError("this lens does not converge: it forms no real image and has no nearest distance")
    return fo


def _check_distance(focus_distance: float, nearest: float) -> None:
    if not focus_distance >= nearest:
        raise FocusError(f"focus at {focus_distance / 1000.0:.4g} m: "
                         f"the nearest distance of this lens is {_rounded_up(nearest / 1000.0):.4g} m from the film")


def _rounded_up(value: float) -> float:
    """To four digits, upwards, so that a named limit is itself allowed."""
    unit = 10.0 ** (floor(log10(value)) - 3)
    return ceil(value / unit) * unit
