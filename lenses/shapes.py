"""Shapes of surfaces: each format lists those that it can hold, and writers report the others.

A new kind of surface needs a member of `Shape` and a line in `shape_of`. Until a format lists it, every writer reports
that it writes another lens.
"""

from enum import Enum

from lensbench.optics.finding import Finding, Kind
from lensbench.optics.lens_surface import Surface
from lensbench.optics.prescription import Lens


class Shape(Enum):
    """A kind of surface; the value is its name in a sentence."""

    SPHERE = "a sphere"                             # or a plane
    CONIC = "a conic"
    EVEN_ASPHERE = "an asphere of even powers"      # r⁴, r⁶ …
    ASPHERE = "an asphere with odd powers or r²"
    CYLINDER = "a cylinder"                         # one of its two sections is straight
    TOROID = "a toroid"


# Sets for the rows of formats. No set is all of `Shape`: no format holds a new member until its set names it
ROTATIONAL = frozenset({Shape.SPHERE, Shape.CONIC, Shape.EVEN_ASPHERE, Shape.ASPHERE})
COMMON = ROTATIONAL | {Shape.CYLINDER, Shape.TOROID}


def shape_of(surface: Surface) -> Shape:
    """The simplest shape that describes a surface."""
    if surface.curvature_x is not None:
        return Shape.TOROID if surface.curvature and surface.curvature_x else Shape.CYLINDER
    if surface.aspheric:
        even = all(power % 2 == 0 and power > 2 for power, _ in surface.aspheric)
        return Shape.EVEN_ASPHERE if even else Shape.ASPHERE
    return Shape.CONIC if surface.conic else Shape.SPHERE


def lost_poses(lens: Lens) -> list[Finding]:
    """A warning for each surface out of line, for a format that holds no decentre and no tilt."""
    return [Finding(Kind.SHAPE, i, f"surface {i} is decentred or tilted, which this format cannot hold: it is written "
                                   "in line, and this is another lens")
            for i, surface in enumerate(lens.surfaces) if surface.pose is not None]


def lost_shapes(lens: Lens, held: frozenset[Shape], instead: str) -> list[Finding]:
    """A warning for each surface whose shape a format cannot hold. instead: the shape written in its place."""
    found = [(i, shape_of(surface)) for i, surface in enumerate(lens.surfaces)]
    return [Finding(Kind.SHAPE, i, f"surface {i} is {shape.value}, which this format cannot hold: {instead}, and this "
                                   "is another lens") for i, shape in found if shape not in held]
