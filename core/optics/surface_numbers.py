"""The numbers of a surface by name: what an editor, a rule or an improvement reads and changes.

Lengths in mm, curvatures in 1/mm, angles in radians.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from lensbench.core.optics.lens_surface import Surface
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.surfaces import HIGHEST_POWER

CURVATURE, CURVATURE_X, THICKNESS, SEMI_DIAMETER, CONIC = ("curvature", "curvature_x", "thickness", "semi_diameter",
                                                           "conic")
QUANTITIES = (CURVATURE, CURVATURE_X, THICKNESS, SEMI_DIAMETER, CONIC,
              *(f"r{power}" for power in range(2, HIGHEST_POWER + 1)))
WORDS = {CURVATURE: "radius", CURVATURE_X: "radius of the section x–z", THICKNESS: "thickness",
         SEMI_DIAMETER: "semi-diameter", CONIC: "conic constant"}
# Numbers of a tilted or decentred surface, which `poses` edits; no rule holds them
POSE = {"decentre_x": "decentre along x", "decentre_y": "decentre along y", "tilt_x": "tilt about x",
        "tilt_y": "tilt about y", "roll": "roll about its axis"}


def value_of(surface: Surface, quantity: str) -> float:
    """A number of a surface, one of QUANTITIES or of POSE: mm, 1/mm, radians or mm^(1 − p).

    `curvature_x` of a rotationally symmetric surface is its curvature.
    """
    if quantity == CURVATURE_X:
        return surface.curvature if surface.curvature_x is None else surface.curvature_x
    if quantity in POSE:
        return 0.0 if surface.pose is None else float(getattr(surface.pose, quantity))
    if quantity in WORDS:
        return float(getattr(surface, quantity))
    return dict(surface.aspheric).get(int(quantity[1:]), 0.0)


def with_value_of(surface: Surface, quantity: str, value: float) -> Surface:
    """The surface with another number, one of QUANTITIES, in the unit of `value_of`; LensError for an invalid one."""
    if quantity in WORDS:
        changed: dict[str, Any] = {quantity: value}
        return replace(surface, **changed)
    power = int(quantity[1:])
    return replace(surface, aspheric=(*((p, a) for p, a in surface.aspheric if p != power), (power, value)))


def with_surfaces(lens: Lens, changed: Sequence[tuple[int, Surface]]) -> Lens:
    """The lens with some surfaces, by their index, replaced."""
    surfaces = list(lens.surfaces)
    for i, surface in changed:
        surfaces[i] = surface
    return replace(lens, surfaces=tuple(surfaces))
