"""What built-in scenes are made of: boxes, bars, spokes and rings of rectangles; tubes and tori of triangles.

Lengths in mm.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.objects.mesh import Mesh
from lensbench.core.scenery.objects.planar import Rectangle
from lensbench.core.scenery.values import Triple, across, triple, unit


def box(x0: float, x1: float, y0: float, y1: float, z0: float, z1: float, material: Material) -> list[Rectangle]:
    """The six faces of a box between two corners."""
    cx, cy, cz, a, b, c = (x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2, (x1 - x0) / 2, (y1 - y0) / 2, (z1 - z0) / 2
    faces = []
    for s in (-1.0, 1.0):
        faces += [Rectangle((cx + s * a, cy, cz), (0.0, 0.0, c), (0.0, b, 0.0), material),
                  Rectangle((cx, cy + s * b, cz), (a, 0.0, 0.0), (0.0, 0.0, c), material),
                  Rectangle((cx, cy, cz + s * c), (a, 0.0, 0.0), (0.0, b, 0.0), material)]
    return faces


def bar(start: Triple, end: Triple, width: float, towards: Triple, material: Material) -> Rectangle:
    """A flat bar between two points; its broad side faces a third."""
    length = np.subtract(end, start)
    middle = np.add(start, end) / 2.0
    side = unit(np.cross(length, np.subtract(towards, middle)))
    return Rectangle(triple(middle), triple(length / 2.0), triple(side * width / 2.0), material)


def spokes(centre: Triple, axis: Triple, inner: float, outer: float, count: int, width: float,
           materials: Sequence[Material], tilt: float = 0.0) -> list[Rectangle]:
    """Blades between two radii about an axis, with the materials in turn, each tilted about its length (rad)."""
    right, up = across(axis)
    blades = []
    for k in range(count):
        angle = 2.0 * math.pi * k / count
        out = math.cos(angle) * right + math.sin(angle) * up
        side = math.cos(tilt) * (math.cos(angle) * up - math.sin(angle) * right) + math.sin(tilt) * unit(axis)
        blades.append(Rectangle(triple(centre + (inner + outer) / 2.0 * out), triple((outer - inner) / 2.0 * out),
                                triple(width / 2.0 * side), materials[k % len(materials)]))
    return blades


def ring(centre: Triple, axis: Triple, radius: float, count: int, width: float, material: Material) -> list[Rectangle]:
    """A flat ring of `count` straight pieces."""
    right, up = across(axis)
    half = math.pi / count
    pieces = []
    for k in range(count):
        angle = 2.0 * half * (k + 0.5)
        out = math.cos(angle) * right + math.sin(angle) * up
        along = math.cos(angle) * up - math.sin(angle) * right
        pieces.append(Rectangle(triple(centre + radius * math.cos(half) * out),
                                triple((radius + width / 2.0) * math.sin(half) * along), triple(width / 2.0 * out),
                                material))
    return pieces


# Of triangles


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


def torus(centre: ArrayLike, radius: float, thickness: float, material: Material, name: str = "ring") -> Mesh:
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
