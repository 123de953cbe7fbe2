"""Spheres."""

import math
from dataclasses import dataclass

import numpy as np

from lensbench.core.lazy import hashed_once
from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.objects.shape import Moving
from lensbench.core.scenery.values import SceneError, Triple, check
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
        velocity, spin, pivot: Keywords; see `Moving`.
    Raises:
        SceneError: If a value is out of range.
    """

    centre: Triple
    radius: float
    material: Material = Material()

    family = "sphere"
    round = True
    half_axes = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)

    def __post_init__(self):
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
        return f"sphere of {significant(2.0 * self.radius, 3)} mm"

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
