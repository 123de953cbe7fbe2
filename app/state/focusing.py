"""How the film is put in its place: paraxially, or where the whole bundle has its least blur; and what that gains.

Automatically it is the paraxial focus, the limit of small stops, for as long as that is as good: where it blurs a point
in focus by half a pixel more than need be, the film moves to the least blur.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import lensbench as lb
from lensbench.app.state.settings import REAL, Settings

ENOUGH = 0.5                    # of a pixel, from which the place of the film counts


class FocusPosition(NamedTuple):
    """How a lens is focused, as `lb.film_distance` names it: "paraxial" or "real".

    paraxial_blur, least_blur: diameters (mm, 2√2 × rms) of an axis point in focus, by real rays, with the one and the
    other; None where there is none to tell.
    """

    method: str
    paraxial_blur: float | None = None
    least_blur: float | None = None

    @property
    def blur(self) -> float | None:
        """With the film where it stands."""
        return self.least_blur if self.method == "real" else self.paraxial_blur


def focusing(lens: lb.Lens, settings: Settings) -> FocusPosition:
    """Of a lens that is stopped down, for the model, the focus and the film of the settings.

    Ideal models have the paraxial focus alone; so has what is nearer than the whole bundle can be focused.
    """
    if settings.model not in REAL:
        return FocusPosition("paraxial")
    return _weighed(lens, settings.focus_distance, settings.focusing, ENOUGH * settings.film.pitch)


@lru_cache(maxsize=64)
def _weighed(lens: lb.Lens, distance: float, asked: str, enough: float) -> FocusPosition:
    try:
        paraxial, least = (_blur(lens, distance, method) for method in ("paraxial", "real"))
    except lb.LensError:
        return FocusPosition("paraxial")
    if not (math.isfinite(paraxial) and math.isfinite(least)):
        return FocusPosition("paraxial")
    better = asked == "real" or asked == "auto" and paraxial - least > enough
    return FocusPosition("real" if better else "paraxial", paraxial, least)


def _blur(lens: lb.Lens, distance: float, method: str) -> float:
    """Of the axis point in focus (mm)."""
    stands = lb.focused(lens, distance, method)
    film_distance = lb.film_distance(stands, distance, method)
    return float(lb.real_circle_of_confusion(stands, film_distance, [distance])[0][0])


def words(found: FocusPosition) -> str:
    """What is done, and why, in a sentence or two."""
    if found.paraxial_blur is None or found.least_blur is None:
        return "Paraxially: the limit of small stops, which ideal models have alone"
    way, blur = "by the least blur" if found.method == "real" else "paraxially", found.blur or 0.0
    other, else_blur = (("paraxially", found.paraxial_blur) if found.method == "real"
                        else ("by the least blur", found.least_blur))
    return (f"Focused {way}: a point in focus is {1000.0 * blur:.3g} µm wide on the axis, {1000.0 * else_blur:.3g} µm "
            f"{other}. The difference is spherical aberration, which grows with the aperture")
