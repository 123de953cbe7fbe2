"""The light budget of a lens: where the light of one ray ends, all its reflections followed.

At every surface a ray divides into a reflected and a refracted one. Light that leaves towards the film after 0
reflections makes the picture, after 2, 4, … the ghosts; after an odd number it leaves towards the scene. The parts of
a budget add up to 1. Glass absorbs nothing. Light counts as unpolarised at every surface.
"""

import math
from dataclasses import dataclass

import numpy as np

from lensbench.optics.coatings import Coating
from lensbench.optics.ghost_path import Meetings
from lensbench.optics.glass import D_LINE
from lensbench.optics.lens_surface import LensError
from lensbench.optics.prescription import Lens
from lensbench.optics.scalar_trace import CLIPPED, PASSED

LEAST = 1e-6            # part of the light below which a ray is not followed: of a large lens, 1e-3 is then left
MOST_RAYS = 400_000     # that one budget follows


@dataclass(frozen=True)
class LightBudget:
    """Parts of the light of one ray, which add up to 1.

    Attributes
    ----------
    to_film : tuple of float
        Leaves towards the film, by the number of reflections: [0] the picture, [2], [4], … the ghosts.
    to_scene : tuple of float
        Leaves towards the scene, by the number of reflections.
    clipped : float
        Ends at rims, the stop and its blades: the mount absorbs it.
    lost : float
        Meets no surface where it should, or turns sideways: it ends in the barrel.
    left : float
        In rays too weak to be followed.
    """

    to_film: tuple[float, ...]
    to_scene: tuple[float, ...]
    clipped: float
    lost: float
    left: float

    @property
    def total(self) -> float:
        """Sum of all parts."""
        return sum(self.to_film) + sum(self.to_scene) + self.clipped + self.lost + self.left


def light_budget(lens: Lens, origin, direction, wavelength: float = D_LINE, coating: str | Coating = "uncoated",
                 least: float = LEAST, clip: bool = True) -> LightBudget:
    """The light budget of one ray.

    Parameters
    ----------
    lens : Lens
        The lens.
    origin, direction : (3,) array_like
        The ray towards the lens (mm, lens frame); the direction may have any length.
    wavelength : float
        Micrometres.
    coating : str or Coating
        Of the surfaces to air that have none of their own: "uncoated", "single-layer", "multi-layer", or any coating.
    least : float
        Part of the light below which a ray is not followed.
    clip : bool
        Whether rims, stop and blades end rays.

    Returns
    -------
    LightBudget

    Raises
    ------
    LensError
        For a direction that is no finite vector, and if more than 400,000 rays would have to be followed: choose a
        larger `least`.
    """
    meetings, count = Meetings(lens, wavelength, coating, clip), len(lens.surfaces)
    unit = np.asarray(direction, float)
    length = float(np.linalg.norm(unit))
    if not 0.0 < length < math.inf or not np.isfinite(np.asarray(origin, float)).all():
        raise LensError("light budget: a ray has an origin of finite numbers, and a direction that is not 0")
    unit = unit / length
    to_film: dict[int, float] = {}
    to_scene: dict[int, float] = {}
    clipped = lost = left = 0.0
    rays = 0
    # Next surface, whether towards the film, origin, direction, part of the light, reflections so far
    work = [(0, True, tuple(np.asarray(origin, float).tolist()), tuple(unit.tolist()), 1.0, 0)]
    while work:
        i, forward, point, ray, part, reflections = work.pop()
        if not 0 <= i < count:
            leaving = to_film if forward else to_scene
            leaving[reflections] = leaving.get(reflections, 0.0) + part
            continue
        if part < least:
            left += part
            continue
        rays += 1
        if rays > MOST_RAYS:
            raise LensError(f"light budget: more than {MOST_RAYS} rays; follow only those above a larger part `least`")
        met = meetings.meet(i, forward, point, ray)
        if met.fate != PASSED:
            clipped, lost = (clipped + part, lost) if met.fate == CLIPPED else (clipped, lost + part)
            continue
        back, on = part * met.reflectance, part * (1.0 - met.reflectance)
        step = 1 if forward else -1
        for after, share, ahead, more in ((met.refracted, on, forward, 0), (met.reflected, back, not forward, 1)):
            if share <= 0.0 or after is None:
                continue
            if (after[2] > 0.0) != ahead and (i > 0 or ahead):      # a fisheye may send light behind it
                lost += share                       # turned sideways: it meets no next surface in order
            else:
                work.append((i + (step if not more else -step), ahead, met.point, after, share, reflections + more))
    return LightBudget(_by_order(to_film), _by_order(to_scene), clipped, lost, left)


def _by_order(found: dict[int, float]) -> tuple[float, ...]:
    return tuple(found.get(k, 0.0) for k in range(max(found, default=0) + 1))
