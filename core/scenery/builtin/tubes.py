"""Tubes and rings of triangles: stems, and what is made of pipes."""

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.objects.mesh import Mesh


def tube(path: ArrayLike, radius: float, material: Material, end: float = 0.5, sides: int = 6,
         name: str = "stem") -> Mesh:
    """A round tube along a path (n, 3) in mm, thinner towards its end by a factor."""
    path = np.asarray(path, float)
    n = len(path)
    angle = 2.0 * np.pi * np.arange(sides) / sides
    ways = np.gradient(path, axis=0)
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    right = np.cross(ways, [0.0, 0.3, 1.0])
    right /= np.linalg.norm(right, axis=1)[:, None]
    up = np.cross(right, ways)
    size = radius * np.linspace(1.0, end, n)[:, None, None]
    away = np.cos(angle)[:, None] * right[:, None] + np.sin(angle)[:, None] * up[:, None]
    points = (path[:, None] + size * away).reshape(-1, 3)
    k, j = np.meshgrid(np.arange(n - 1), np.arange(sides), indexing="ij")
    a, b = k * sides + j, k * sides + (j + 1) % sides
    faces = np.concatenate([np.stack([a, b, a + sides], -1).reshape(-1, 3),
                            np.stack([b, b + sides, a + sides], -1).reshape(-1, 3)])
    return Mesh.of(points, faces, material, normals=away.reshape(-1, 3), name=name)


def ring(centre: ArrayLike, radius: float, thickness: float, material: Material, name: str = "ring") -> Mesh:
    """A torus about the axis z, mm."""
    turn = np.linspace(0.0, 2.0 * np.pi, 97)
    away = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], -1)
    angle = 2.0 * np.pi * np.arange(10) / 10
    normals = np.cos(angle)[:, None] * away[:, None] + np.sin(angle)[:, None] * np.array([0.0, 0.0, 1.0])
    points = np.asarray(centre, float) + radius * away[:, None] + thickness * normals
    k, j = np.meshgrid(np.arange(96), np.arange(10), indexing="ij")
    a, b = k * 10 + j, k * 10 + (j + 1) % 10
    faces = np.concatenate([np.stack([a, a + 10, b], -1).reshape(-1, 3),
                            np.stack([b, a + 10, b + 10], -1).reshape(-1, 3)])
    return Mesh.of(points.reshape(-1, 3), faces, material, normals=normals.reshape(-1, 3), name=name)


def joined(parts: list[Mesh], turn: float, place: ArrayLike, name: str) -> list[Mesh]:
    """Meshes of one material each from many, turned about y (radians) and moved (mm)."""
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    found = []
    for material in dict.fromkeys(part.material for part in parts):
        alike = [part for part in parts if part.material == material]
        starts = np.cumsum([0, *(len(part.points) for part in alike)])
        points = np.concatenate([part.points for part in alike]) @ rotation.T + place
        normals = np.concatenate([np.frombuffer(part.normals, np.float32).reshape(-1, 3) for part in alike])
        faces = np.concatenate([part.triangles + start for part, start in zip(alike, starts, strict=False)])
        found.append(Mesh.of(points, faces, material, normals=normals @ rotation.T, name=name))
    return found
