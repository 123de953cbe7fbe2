"""Members that every shape of a scene provides, and its motion.

A new shape is a frozen dataclass that derives from `Moving` and has the members of `Shape`; the
scene file reader gives it a row. Its `family` names the kernels that intersect, reflect and sample it: a shape that
these can describe (every flat one bounded by half-axes, say) needs no kernel.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol, TypeVar

import numpy as np

from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.values import Triple, triple


@dataclass(frozen=True, kw_only=True)
class Moving:
    """Motion of a shape, whose other fields describe it at the time 0 s.

    Args:
        velocity: (x, y, z). mm/s, world frame.
        spin: (x, y, z). Axis of rotation times angular speed, rad/s, right-handed, world frame.
        pivot: (x, y, z), optional. Point of the axis at 0 s, mm, world frame; it moves with `velocity`. None: the
            centre of the shape.
    """

    velocity: Triple = (0.0, 0.0, 0.0)
    spin: Triple = (0.0, 0.0, 0.0)
    pivot: Triple | None = None

    triangle_count = 0

    @property
    def moves(self) -> bool:
        """Whether the shape has a velocity or a spin."""
        return any(self.velocity) or any(self.spin)

    def facets(self, most: int) -> np.ndarray:
        """None: a shape of two half-axes or a radius is drawn smoothly."""
        return np.zeros((0, 3, 3))


class Shape(Protocol):
    """Members that cameras, lights, plans and scene files use of a shape. Lengths in mm, world frame, at 0 s."""

    __dataclass_fields__: ClassVar[dict[str, Any]]      # a shape is a dataclass

    @property
    def centre(self) -> Triple:
        """Middle of the shape."""

    @property
    def material(self) -> Material:
        """Material of the whole surface."""

    @property
    def velocity(self) -> Triple:
        """Velocity, mm/s."""

    @property
    def spin(self) -> Triple:
        """Axis of rotation times angular speed, rad/s."""

    @property
    def pivot(self) -> Triple | None:
        """Point of the axis of rotation."""

    @property
    def moves(self) -> bool:
        """Whether the shape has a velocity or a spin."""

    @property
    def family(self) -> str:
        """Key of its row in `families.FAMILIES`: the group of stages that read its numbers."""

    @property
    def round(self) -> bool:
        """Whether the silhouette along the normal is an ellipse rather than a rectangle."""

    @property
    def label(self) -> str:
        """Name shown to the user."""

    @property
    def half_axes(self) -> tuple[Triple, Triple]:
        """Half-axes right and up of a planar shape; zeros for a sphere."""

    @property
    def triangle_count(self) -> int:
        """Number of its triangles; 0 for a sphere or planar shape."""

    @property
    def bounding_radius(self) -> float:
        """Radius of the sphere about the centre that encloses the shape, mm."""

    @property
    def area(self) -> float:
        """Area of the largest silhouette, mm²."""

    def silhouette(self, direction: np.ndarray) -> float:
        """Area seen by a distant viewer.

        Args:
            direction: (3,) array. Unit vector towards the viewer, world frame.
        """

    def distance(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Distance along rays to the surface.

        Args:
            origins: (n, 3) array. World frame, mm.
            directions: (n, 3) array. Unit vectors.
        Returns:
            (n,) array. mm; NaN where a ray misses.
        """

    def locate(self, point: np.ndarray, tolerance: float) -> np.ndarray | None:
        """A point of the surface in the frame of the shape.

        Args:
            point: (3,) array. World frame, mm.
            tolerance: How far (mm) the point may lie off the surface.
        Returns:
            (3,) array or None. mm; None if it lies farther off.
        """

    def outline(self, count: int) -> np.ndarray:
        """Outline of the shape, seen from above.

        Args:
            count: Most points.
        Returns:
            (m, 3) array. Polygon of world points (mm), m ≤ count.
        """

    def facets(self, most: int) -> np.ndarray:
        """Triangles that a drawing shows of a shape that is neither a sphere nor planar.

        Args:
            most: Most triangles.
        Returns:
            (n, 3, 3) array. Corners of each, world frame, mm; n ≤ most, 0 for a sphere or planar shape.
        """


def by_family(shapes: Iterable[Any]) -> tuple[list[Any], list[Any]]:
    """Spheres, and planar shapes."""
    shapes = list(shapes)
    spheres, planar = ([o for o in shapes if o.family == family] for family in ("sphere", "planar"))
    return spheres, planar


Moved = TypeVar("Moved", bound=Shape)


def displaced(shape: Moved, seconds: float) -> Moved:
    """The shape translated by its velocity times a number of seconds, not rotated."""
    offset = np.multiply(shape.velocity, seconds)
    pivot = None if shape.pivot is None else triple(np.add(shape.pivot, offset))
    return replace(shape, centre=triple(np.add(shape.centre, offset)), pivot=pivot)


def rest_frame(origins: np.ndarray, directions: np.ndarray, shape: Shape, time: float
               ) -> tuple[np.ndarray, np.ndarray]:
    """Rays (n, 3) of the world at a time (s), in the frame where the shape lies as it does at 0 s."""
    if not shape.moves or time == 0.0:
        return origins, directions
    spin = np.asarray(shape.spin) * time
    angle = math.sqrt(spin @ spin)
    x, y, z = spin / angle if angle > 0.0 else spin
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation = np.eye(3) + math.sin(angle) * k + (1.0 - math.cos(angle)) * k @ k
    pivot = np.asarray(shape.centre if shape.pivot is None else shape.pivot)
    return (origins - pivot - np.multiply(shape.velocity, time)) @ rotation + pivot, directions @ rotation
