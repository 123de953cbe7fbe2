"""Shapes of surfaces that formats can hold: each format lists them, and writers report the others.

Until a format lists a new `Shape`, every writer reports that it writes another lens.
"""

from lensbench.optics.finding import Finding, Kind
from lensbench.optics.lens_surface import Shape
from lensbench.optics.prescription import Lens

# Sets for the rows of formats. No set is all of `Shape`: no format holds a new member until its set names it
ROTATIONAL = frozenset({Shape.SPHERE, Shape.CONIC, Shape.EVEN_ASPHERE, Shape.ASPHERE})
COMMON = ROTATIONAL | {Shape.CYLINDER, Shape.TOROID}


def lost_poses(lens: Lens) -> list[Finding]:
    """A warning for each surface out of line, for a format that holds no decentre and no tilt."""
    return [Finding(Kind.SHAPE, i, f"surface {i} is decentred or tilted, which this format cannot hold: it is written "
                                   "in line, and this is another lens")
            for i, surface in enumerate(lens.surfaces) if surface.pose is not None]


def lost_shapes(lens: Lens, held: frozenset[Shape], instead: str) -> list[Finding]:
    """A warning for each surface whose shape a format cannot hold. instead: the shape written in its place."""
    found = [(i, surface.form) for i, surface in enumerate(lens.surfaces)]
    return [Finding(Kind.SHAPE, i, f"surface {i} is {shape.value}, which this format cannot hold: {instead}, and this "
                                   "is another lens") for i, shape in found if shape not in held]
