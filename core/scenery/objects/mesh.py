"""Triangle meshes."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.lazy import hashed_once
from lensbench.core.scenery.intersect.triangle_tree import MOST_TRIANGLES
from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.values import SceneError, Triple, triple
from lensbench.core.text import significant

MOST_OPEN = 0.01        # of the edges of a solid: where its surface may have gaps
SAME = 1e-5             # of its size: nearer vertices are one


@hashed_once
@dataclass(frozen=True)
class Mesh:
    """Triangles of one material, visible from both sides, at rest. Compared by value; see `Mesh.of`.

    Args:
        vertices: (n, 3) float32, mm, world frame.
        faces: (m, 3) int32: the three corners of each triangle.
        material: Of the whole mesh. Its image, if any, needs `uv`; other patterns are refused. "glass" is a solid of
            index 1.5 with a closed surface; `Mesh.of` turns its triangles outward. A "lamp" shines evenly to both
            sides, without image and colours.
        normals, uv, colours: Of each vertex, or empty: unit normals (n, 3), which smooth the surface, places (n, 2) in
            the image, from 0, 0 at its lower left corner to 1, 1, repeated beyond, and linear colours (n, 3), which
            multiply the material's.
        name: Shown to the user.
    Raises:
        SceneError: For a pattern other than an image, an image without `uv`, and a lamp with image or colours.
    """

    vertices: bytes
    faces: bytes
    material: Material = Material()
    normals: bytes = b""
    uv: bytes = b""
    colours: bytes = b""
    name: str = "mesh"

    family = "mesh"
    round = False
    moves = False
    half_axes = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    velocity = spin = (0.0, 0.0, 0.0)
    pivot = None

    @classmethod
    def of(cls, vertices: ArrayLike, faces: ArrayLike, material: Material = Material(), *,     # noqa: B008  (frozen)
           normals: ArrayLike | None = None, uv: ArrayLike | None = None, colours: ArrayLike | None = None,
           name: str = "mesh") -> "Mesh":
        """Mesh from arrays.

        Args:
            vertices: array_like, shape (n, 3). mm, world frame.
            faces: array_like of int, shape (m, 3). Corners of each triangle. Triangles without an area are left out.
            material: See `Mesh`.
            normals, uv, colours: Of each vertex: (n, 3) of any length, (n, 2) and (n, 3).
            name: Shown to the user.
        Raises:
            SceneError: If a shape is wrong, a number is not finite, a corner does not exist, no triangle has an area,
                or the surface of a mesh of glass is open.
        """
        points = _table(vertices, 3, "vertices")
        corners = np.asarray(faces)
        if corners.ndim != 2 or corners.shape[1] != 3 or not np.issubdtype(corners.dtype, np.integer):
            raise SceneError("the faces of a mesh are whole numbers, three for each triangle")
        if not len(corners):
            raise SceneError("a mesh without triangles shows nothing")
        if len(corners) > MOST_TRIANGLES:
            raise SceneError(f"a mesh of {len(corners)} triangles is too large: at most {MOST_TRIANGLES}")
        if corners.min() < 0 or corners.max() >= len(points):
            raise SceneError(f"a triangle of the mesh has a corner that does not exist ({len(points)} vertices)")
        if not np.isfinite(points[corners]).all():
            raise SceneError("a vertex of the mesh is not finite")
        if np.abs(points).max() > 1e8:
            raise SceneError("a vertex of the mesh lies more than 100 km away")
        a, b, c = (points[corners[:, k]].astype(np.float64) for k in range(3))
        kept = (np.cross(b - a, c - a) != 0.0).any(1)
        if not kept.any():
            raise SceneError("no triangle of the mesh has an area")
        extra = {}
        for key, values, width in (("normals", normals, 3), ("uv", uv, 2), ("colours", colours, 3)):
            if values is None:
                continue
            table = _table(values, width, key)
            if len(table) != len(points):
                raise SceneError(f"the {key} of a mesh must be as many as its vertices ({len(points)})")
            if key == "normals":
                length = np.linalg.norm(table, axis=1, keepdims=True)
                table = np.where(length > 0.0, table / np.maximum(length, 1e-30), 0.0)
            extra[key] = np.nan_to_num(np.ascontiguousarray(table, np.float32)).tobytes()
        kept_corners = np.ascontiguousarray(corners[kept], np.int32)
        if material.kind == "glass":
            kept_corners = _solid(points.astype(np.float64), kept_corners)
        return cls(points.tobytes(), kept_corners.tobytes(), material, name=name, **extra)

    def __post_init__(self) -> None:
        pattern = self.material.pattern
        if pattern is not None and pattern.image is None:
            raise SceneError("a mesh has no pattern but an image")
        if pattern is not None and not self.uv:
            raise SceneError("a mesh with an image needs places in it (uv)")
        if self.material.kind == "lamp" and (pattern is not None or self.colours):
            raise SceneError('a mesh that is a lamp shines evenly: leave image and colours out, or make it a "light"')

    @cached_property
    def points(self) -> np.ndarray:
        """Vertices (n, 3), float32, read-only."""
        return np.frombuffer(self.vertices, np.float32).reshape(-1, 3)

    @cached_property
    def triangles(self) -> np.ndarray:
        """Corners (m, 3), int32, read-only."""
        return np.frombuffer(self.faces, np.int32).reshape(-1, 3)

    @cached_property
    def _bounds(self) -> tuple[np.ndarray, np.ndarray]:
        used = self.points[np.unique(self.triangles)]
        return used.min(0).astype(float), used.max(0).astype(float)

    @property
    def centre(self) -> Triple:
        """Middle of the bounding box, mm."""
        low, high = self._bounds
        return triple((low + high) / 2.0)

    @property
    def bounding_radius(self) -> float:
        """Half the diagonal of the bounding box, mm."""
        low, high = self._bounds
        return math.dist(low, high) / 2.0

    @property
    def triangle_count(self) -> int:
        """Number of triangles."""
        return len(self.triangles)

    @property
    def label(self) -> str:
        """Name shown to the user."""
        return f"{self.name} of {significant(2.0 * self.bounding_radius, 3)} mm"

    @cached_property
    def area(self) -> float:
        """A quarter of the surface, mm²: the mean silhouette of a convex shape (Cauchy)."""
        a, b, c = (self.points[self.triangles[:, k]].astype(float) for k in range(3))
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 8.0

    def silhouette(self, direction: np.ndarray) -> float:
        """Area seen from a direction, mm²: the mean over all."""
        return self.area

    def distance(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Distance (n,) along rays (n, 3) to the nearest triangle; nan where a ray misses."""
        from lensbench.core.scenery.intersect.meshes import nearest_distances

        return nearest_distances((self,), origins, directions)

    def locate(self, point: np.ndarray, tolerance: float) -> np.ndarray | None:
        """A point of the surface relative to the centre, along the world's axes; None off the surface."""
        corners = self.points[self.triangles]
        near = ((corners.min(1) <= point + tolerance) & (corners.max(1) >= point - tolerance)).all(1)
        a, b, c = (corners[near, k].astype(float) for k in range(3))
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        off = np.abs(np.sum((point - a) * normal, 1))
        sides = [np.sum(np.cross(q - p, point - p) * normal, 1) / np.linalg.norm(q - p, axis=1)
                 for p, q in ((a, b), (b, c), (c, a))]
        return point - np.asarray(self.centre) if ((off < tolerance) & (np.min(sides, 0) > -tolerance)).any() else None

    def outline(self, count: int) -> np.ndarray:
        """Its convex outline seen from above, (count, 3): the farthest vertices in directions around it."""
        angle = 2.0 * np.pi * np.arange(count) / count
        away = self.points[:, [0, 2]] @ np.stack([np.cos(angle), np.sin(angle)])
        return self.points[np.argmax(away, 0)].astype(float)

    def facets(self, most: int) -> np.ndarray:
        """Triangles (n, 3, 3) for a drawing, evenly chosen where there are more than `most`."""
        return self.points[self.triangles[::-(-len(self.triangles) // most)]].astype(float)


def _solid(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """The corners (m, 3) of a closed surface, anticlockwise seen from outside; SceneError where it is open."""
    size = float(np.ptp(points[corners.ravel()], 0).max())
    _, ids = np.unique(np.round(points / (SAME * size)), axis=0, return_inverse=True)
    corner_ids = ids.reshape(-1)[corners]
    ways = np.concatenate([corner_ids[:, [0, 1]], corner_ids[:, [1, 2]], corner_ids[:, [2, 0]]])
    ways = ways[ways[:, 0] != ways[:, 1]]
    edges, sides = np.unique(np.sort(ways, 1), axis=0, return_counts=True)
    single = int((sides == 1).sum())
    if single > MOST_OPEN * len(edges):
        raise SceneError(f"a mesh of glass is a solid, and {single} of the {len(edges)} edges of this one belong to "
                         "one triangle alone: close its surface, or give it another material")
    a, b, c = (points[corners[:, k]] - points[corners[0, 0]] for k in range(3))
    volume = np.einsum("nk,nk->", a, np.cross(b, c))
    return corners if volume >= 0.0 else np.ascontiguousarray(corners[:, ::-1])


def _table(values: ArrayLike, width: int, what: str) -> np.ndarray:
    """Rows of a number of float32; SceneError where the shape is another."""
    table = np.asarray(values)
    if table.ndim != 2 or table.shape[1] != width:
        raise SceneError(f"the {what} of a mesh have the shape {table.shape}: give {width} numbers for each")
    with np.errstate(over="ignore"):
        return np.ascontiguousarray(table, np.float32)
