"""Shapes of surfaces that formats can hold: each format lists them, and writers report the others.

Until a format lists a new `Shape`, every writer reports that it writes another lens.

Toroids of other programs' files: three shapes share two curvatures, and lensbench traces the biconic one.

    biconic         z = A / (1 + √(1 − c_x² x² − c_y² y²)), A = c_x x² + c_y y²
    torus           the arc of the section y–z, turned about an axis along y
    torus about x   the arc of the section x–z, turned about an axis along x
    arcs            the sum of the arcs of both sections

They agree in both sections, and everywhere where one of them is straight: a cylinder.
"""

from math import cos, pi, sin, sqrt

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.lens_surface import Shape, Surface
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant
from lensbench.lenses.tables.paraxial import sag

# Sets for the rows of formats. No set is all of `Shape`: no format holds a new member until its set names it
ROTATIONAL = frozenset({Shape.SPHERE, Shape.CONIC, Shape.EVEN_ASPHERE, Shape.ASPHERE})
COMMON = ROTATIONAL | {Shape.CYLINDER, Shape.TOROID}


def lost_poses(lens: Lens) -> list[Finding]:
    """A warning for each tilted or decentred surface, for a format that holds no decentre and no tilt."""
    return [Finding(Kind.SHAPE, i, f"surface {i} is decentred or tilted, which this format cannot hold: it is written "
                                   "in line, and this is another lens")
            for i, surface in enumerate(lens.surfaces) if surface.pose is not None]


def lost_shapes(lens: Lens, shapes: frozenset[Shape], instead: str) -> list[Finding]:
    """A warning for each surface whose shape a format cannot hold. instead: the shape written in its place."""
    forms = [(i, surface.form) for i, surface in enumerate(lens.surfaces)]
    return [Finding(Kind.SHAPE, i, f"surface {i} is {shape.value}, which this format cannot hold: {instead}, and this "
                                   "is another lens") for i, shape in forms if shape not in shapes]


NAMES = {"torus": "a torus", "torus about x": "a torus", "arcs": "the sum of two arcs"}
POINTS = 24


def finding(kind: str, surface: Surface, i: int) -> Finding | None:
    """The finding about surface i (mm) if its file means another toroid than the biconic one, else None."""
    if kind not in NAMES or not surface.curvature or not surface.curvature_x:
        return None
    away = departure(kind, surface)
    return note(Kind.SHAPE, f"surface {i}: {NAMES[kind]} in the file, it is traced as the biconic toroid of the same "
                            f"two curvatures, {significant(away, 2)} mm from it at the edge", i, departure=away)


def departure(kind: str, surface: Surface) -> float:
    """Largest distance (mm) along the axis between this kind of toroid and the biconic one, around the rim."""
    worst, h = 0.0, surface.semi_diameter
    for i in range(POINTS + 1):
        x, y = h * sin(0.5 * pi * i / POINTS), h * cos(0.5 * pi * i / POINTS)
        worst = max(worst, abs(_sag(kind, surface, x, y) - _sag("biconic", surface, x, y)))
    return worst


def _sag(kind: str, surface: Surface, x: float, y: float) -> float:
    """Sag (mm) of a toroid; that of its equator for heights beyond."""
    across, c = surface.curvature_x or 0.0, surface.curvature
    if kind == "biconic":
        return (across * x * x + c * y * y) / (1.0 + sqrt(max(0.0, 1.0 - (across * x) ** 2 - (c * y) ** 2)))
    if kind == "arcs":
        return sag(across, x) + sag(c, y)
    if kind == "torus about x":
        x, y, across, c = y, x, c, across
    profile = sag(c, y)
    reach = 1.0 - across * profile                      # of the axis, in its radius: 0 where the surface meets it
    return profile + (sag(across / reach, x) if reach else 0.0)
