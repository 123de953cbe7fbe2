"""The position of the film behind a focused lens: the paraxial focus, or the position of least blur of all rays.

"auto" takes the paraxial focus, the limit of small stops, unless it blurs a point in focus by half a pixel more than
the position of least blur does.
"""

import math
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import lensbench as lb

if TYPE_CHECKING:
    from lensbench.app.state.settings import Settings

ENOUGH = 0.5                    # of a pixel: a smaller gain does not move the film


class FocusPosition(NamedTuple):
    """Method by which a lens is focused, as in `lb.film_distance`: "paraxial" or "real" (least blur).

    paraxial_blur, least_blur: diameters (mm, 2√2 × rms) of an axis point in focus, by real rays, at either position;
    None where they are not known.
    """

    method: str
    paraxial_blur: float | None = None
    least_blur: float | None = None

    @property
    def blur(self) -> float | None:
        """The diameter at the position of the film."""
        return self.least_blur if self.method == "real" else self.paraxial_blur


def focusing(lens: lb.Lens, settings: "Settings") -> FocusPosition:
    """The position of the film behind a lens that is stopped down already.

    It is the paraxial focus for ideal models, and where the whole bundle cannot be focused so near.
    """
    if not settings.follows_lens:
        return FocusPosition("paraxial")
    return _compared(lens, settings.focus_distance, settings.focus_position, ENOUGH * settings.film.pitch)


@lru_cache(maxsize=64)
def _compared(lens: lb.Lens, distance: float, asked: str, enough: float) -> FocusPosition:
    try:
        paraxial, least = (_blur(lens, distance, method) for method in ("paraxial", "real"))
    except lb.LensError:
        return FocusPosition("paraxial")
    if not (math.isfinite(paraxial) and math.isfinite(least)):
        return FocusPosition("paraxial")
    better = asked == "real" or asked == "auto" and paraxial - least > enough
    return FocusPosition("real" if better else "paraxial", paraxial, least)


def _blur(lens: lb.Lens, distance: float, method: str) -> float:
    """The diameter (mm) of the axis point in focus."""
    focused = lb.focused(lens, distance, method)
    film_distance = lb.film_distance(focused, distance, method)
    return float(lb.real_circle_of_confusion(focused, film_distance, [distance])[0][0])


def words(found: FocusPosition) -> str:
    """The position and its reason in a sentence or two."""
    if found.paraxial_blur is None or found.least_blur is None:
        return "Paraxial focus: the limit of small stops, the only focus of an ideal model"
    method, blur = "by the least blur" if found.method == "real" else "paraxially", found.blur or 0.0
    other_method, other_blur = (("paraxially", found.paraxial_blur) if found.method == "real"
                                else ("by the least blur", found.least_blur))
    return (f"Focused {method}: a point in focus is {1000.0 * blur:.3g} µm wide on the axis, {1000.0 * other_blur:.3g} "
            f"µm {other_method}. The difference is spherical aberration, which grows with the aperture")
