"""Spheres, rectangles and disks. The planar shapes have two half-axes a (right) and b (up) at right angles."""

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from lensbench.core.lazy import hashed_once
from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.objects.shape import Moving
from lensbench.core.scenery.values import SceneError, Triple, across, check, cross, triple
from lensbench.core.text import significant


@hashed_once
@dataclass(frozen=True)
class Sphere(Moving):
    """Sphere, visible from outside.

    Args:
        centre: (x, y, z). mm, world frame.
        radius: mm.
        material: Without a pattern, or with an image that goes once around the sphere (of a sphere at rest that is no
            lamp): its top row is at +y, its middle column at +z, and its columns go on towards +x.
        name: Keyword. By which it is found; "" for none.
        velocity, spin, pivot: Keywords; see `Moving`.
    Raises:
        SceneError: If a value is out of range.
    """

    centre: Triple
    radius: float
    material: Material = Material()
    name: str = field(default="", kw_only=True)

    family = "sphere"
    round = True
    half_axes = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        check(self, ("radius",))
        pattern = self.material.pattern
        if pattern is not None and pattern.image is None:
            raise SceneError("a sphere has no pattern but an image: give the pattern to a rectangle or a disk")
        if pattern is not None and self.moves:
            raise SceneError("a sphere with an image cannot move")
        if pattern is not None and self.material.kind == "lamp":
            raise SceneError('a spherical lamp cannot have an image: make it a "light"')

    @property
    def label(self) -> str:
        """Name shown to the user."""
        return self.name or f"sphere of {significant(2.0 * self.radius, 3)} mm"

    @property
    def bounding_radius(self) -> float:
        """Its radius, mm."""
        return self.radius

    @property
    def area(self) -> float:
        """Area of its silhouette, mm²."""
        return math.pi * self.radius**2

    def silhouette(self, direction: np.ndarray) -> float:
        """Area seen from any direction, mm²."""
        return self.area

    def distance(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Distance (n,) along rays (n, 3) to the front of the sphere; nan where a ray misses."""
        to = origins - np.asarray(self.centre)
        half = np.sum(to * directions, 1)
        return -half - np.sqrt(half**2 - np.sum(to * to, 1) + self.radius**2)

    def locate(self, point: np.ndarray, tolerance: float) -> np.ndarray | None:
        """A point of the surface relative to the centre, along the world's axes; None off the surface."""
        away = point - np.asarray(self.centre)
        return away if abs(np.linalg.norm(away) - self.radius) < tolerance + 1e-3 * self.radius else None

    def outline(self, count: int) -> np.ndarray:
        """Its equator, (count, 3)."""
        angle = 2.0 * np.pi * np.arange(count) / count
        return np.asarray(self.centre) + self.radius * np.column_stack([np.cos(angle), 0.0 * angle, np.sin(angle)])


class Frame(NamedTuple):
    """A planar shape as arrays, mm, world frame."""

    centre: np.ndarray
    a: np.ndarray           # half-axis to the right
    b: np.ndarray           # half-axis upwards
    normal: np.ndarray      # unit vector along a × b


class Planar(Moving):
    """Base of the planar shapes: the geometry that follows from centre, half-axes and a straight or round edge.

    Raises:
        SceneError: If a value is out of range or the half-axes are not at right angles.
    """

    centre: Triple
    right: Triple
    up: Triple
    material: Material
    family = "planar"
    round = False

    def __post_init__(self) -> None:
        check(self)
        a, b = np.asarray(self.right), np.asarray(self.up)
        if not (a @ a > 0.0 and b @ b > 0.0):
            raise SceneError(f"the half-axes of a {self.label} cannot be zero")
        if abs(a @ b) > 1e-6 * math.sqrt((a @ a) * (b @ b)):
            raise SceneError(f"the half-axes of a {self.label} must be at right angles")

    @property
    def label(self) -> str:
        """Name shown to the user."""
        return type(self).__name__.lower()

    @property
    def half_axes(self) -> tuple[Triple, Triple]:
        """Half-axes right and up, mm."""
        return self.right, self.up

    @cached_property
    def frame(self) -> Frame:
        """Centre, half-axes and unit normal."""
        a, b = np.asarray(self.right, np.float64), np.asarray(self.up, np.float64)
        normal = cross(a, b)
        return Frame(np.asarray(self.centre, np.float64), a, b, normal / math.sqrt(normal @ normal))

    @property
    def bounding_radius(self) -> float:
        """Distance from the centre to the farthest point, mm."""
        _, a, b, _ = self.frame
        return math.sqrt(max(a @ a, b @ b) if self.round else a @ a + b @ b)

    @property
    def area(self) -> float:
        """Area, mm²."""
        _, a, b, _ = self.frame
        return math.sqrt((a @ a) * (b @ b)) * (math.pi if self.round else 4.0)

    def silhouette(self, direction: np.ndarray) -> float:
        """Area foreshortened towards a unit direction, mm²."""
        return self.area * abs(float(self.frame.normal @ direction))

    def covers(self, u: Any, v: Any) -> Any:
        """Whether points of the plane lie on the shape.

        Args:
            u, v: float or (n,) array. Coordinates along the two half-axes, in units of their lengths.
        Returns:
            bool or (n,) bool array.
        """
        return u**2 + v**2 <= 1.0 if self.round else (abs(u) <= 1.0) & (abs(v) <= 1.0)

    def distance(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Distance (n,) along rays (n, 3); nan where a ray misses."""
        centre, a, b, normal = self.frame
        t = ((centre - origins) @ normal) / (directions @ normal)
        q = origins + t[:, None] * directions - centre
        return np.where(self.covers(q @ a / (a @ a), q @ b / (b @ b)), t, math.nan)

    def locate(self, point: np.ndarray, tolerance: float) -> np.ndarray | None:
        """A point of the shape in mm along right, up and the normal; None off the shape."""
        centre, a, b, normal = self.frame
        away = point - centre
        if not self.covers(away @ a / (a @ a), away @ b / (b @ b)) or abs(away @ normal) >= tolerance:
            return None
        return np.array([a / np.linalg.norm(a), b / np.linalg.norm(b), normal]) @ away

    def outline(self, count: int) -> np.ndarray:
        """Its edge: (count, 3) points of an ellipse, or four corners."""
        angle = 2.0 * np.pi * np.arange(count) / count
        edge = np.column_stack([np.cos(angle), np.sin(angle)]) if self.round else \
            np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        return np.asarray(self.centre) + edge @ np.array(self.half_axes)


@hashed_once
@dataclass(frozen=True)
class Rectangle(Planar):
    """Rectangle, visible from both sides.

    Args:
        centre: (x, y, z). mm, world frame.
        right, up: (x, y, z). Half-axes at right angles: from the centre to the middle of an edge, mm, world frame.
        material: Its pattern, if any, has its lower left corner at centre − right − up.
        name: Keyword. By which it is found; "" for none.
        velocity, spin, pivot: Keywords; see `Moving`.
    Raises:
        SceneError: If a value is out of range or the half-axes are not at right angles.
    """

    centre: Triple
    right: Triple
    up: Triple
    material: Material = Material()
    name: str = field(default="", kw_only=True)

    @classmethod
    def facing(cls, centre: Triple, target: Triple, width: float, height: float,
               material: Material = Material()) -> "Rectangle":    # noqa: B008  (frozen)
        """Rectangle whose front faces a point and whose upper edge is horizontal.

        Args:
            centre, target: (x, y, z). Its centre and the point that it faces, mm, world frame.
            width, height: Full lengths of the edges, mm.
            material: Its surface.
        """
        right, up = across(np.subtract(target, centre))
        return cls(centre, triple(right * width / 2), triple(up * height / 2), material)


@hashed_once
@dataclass(frozen=True)
class Disk(Planar):
    """Disk, visible from both sides.

    Args:
        centre: (x, y, z). mm, world frame.
        normal: (x, y, z). Direction of its axis, of any length, world frame.
        radius: mm.
        material: Its surface.
        name: Keyword. By which it is found; "" for none.
        velocity, spin, pivot: Keywords; see `Moving`.
    Raises:
        SceneError: If a value is out of range.
    """

    centre: Triple
    normal: Triple
    radius: float
    material: Material = Material()
    name: str = field(default="", kw_only=True)
    round = True

    def __post_init__(self) -> None:
        check(self, ("radius",))
        if not np.any(self.normal):
            raise SceneError("the normal of a disk cannot be zero")

    @property
    def right(self) -> Triple:      # type: ignore[override]
        """Half-axis to the right (mm), horizontal."""
        return triple(across(self.normal)[0] * self.radius)

    @property
    def up(self) -> Triple:         # type: ignore[override]
        """Half-axis upwards (mm)."""
        return triple(across(self.normal)[1] * self.radius)
