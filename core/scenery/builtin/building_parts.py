"""What built-in scenes are made of: boxes, bars and rings of rectangles; tubes, tori and a bicycle of triangles; signs.

Lengths in mm.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.scenery.objects.basic_shapes import Rectangle
from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.objects.mesh import Mesh
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


def joined(parts: list[Mesh], turn: float, position: ArrayLike, name: str) -> list[Mesh]:
    """Meshes of one material each from many, turned about y (radians) and moved (mm)."""
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    meshes = []
    for material in dict.fromkeys(mesh.material for mesh in parts):
        alike = [mesh for mesh in parts if mesh.material == material]
        starts = np.cumsum([0, *(len(mesh.points) for mesh in alike)])
        points = np.concatenate([mesh.points for mesh in alike]) @ rotation.T + position
        normals = np.concatenate([np.frombuffer(mesh.normals, np.float32).reshape(-1, 3) for mesh in alike])
        faces = np.concatenate([mesh.triangles + start for mesh, start in zip(alike, starts, strict=False)])
        meshes.append(Mesh.of(points, faces, material, normals=normals @ rotation.T, name=name))
    return meshes


# A bicycle, built in the plane z = 0, the ground at y = 0, the front wheel at +x

REAR, FRONT, CRANK = np.array([-500.0, 335.0, 0.0]), np.array([510.0, 335.0, 0.0]), np.array([-75.0, 285.0, 0.0])
SEAT, HEAD, FORK = np.array([-215.0, 770.0, 0.0]), np.array([345.0, 800.0, 0.0]), np.array([378.0, 660.0, 0.0])
WHEEL, SPOKES = 318.0, 28
BEAM = (558.0, 730.0, 0.0)      # middle of the head light


def bicycle(turn: float, position: ArrayLike, paint: Material) -> list[Mesh]:
    """A bicycle turned about y (radians), its wheels below the middle at `position` (mm)."""
    steel, rubber = Material((0.80, 0.81, 0.83), "metal"), Material((0.022, 0.022, 0.024))
    leather = Material((0.16, 0.07, 0.03))
    side = np.array([0.0, 0.0, 1.0])

    def pipe(points: list[np.ndarray], radius: float, material: Material, end: float = 1.0) -> Mesh:
        return tube(np.array(points), radius, material, end, sides=10, name="bicycle")

    parts = [pipe([SEAT, HEAD - [0.0, 12.0, 0.0]], 14.0, paint), pipe([CRANK, FORK], 16.0, paint),
             pipe([CRANK, SEAT], 15.0, paint), pipe([HEAD + [-8.0, 34.0, 0.0], FORK + [4.0, -18.0, 0.0]], 18.0, paint)]
    for s in (-1.0, 1.0):
        out = s * 62.0 * side
        parts += [pipe([CRANK + 0.4 * out, REAR + out], 9.0, paint, 0.8),
                  pipe([SEAT + 0.3 * out, REAR + out], 8.0, paint, 0.8)]
        t = np.linspace(0.0, 1.0, 9)[:, None]
        bow = FORK + (FRONT - FORK) * t + [0.0, -40.0, 0.0] * (t * (1.0 - t)) + out * np.minimum(0.5 + t, 1.0)
        parts.append(pipe(list(bow + np.array([-52.0, 0.0, 0.0]) * t * (1.0 - t)), 12.0, paint, 0.7))
        # Handlebar: out from the stem, back to the grip
        t = np.linspace(0.0, 1.0, 14)[:, None]
        bar = (HEAD + [30.0, 105.0, 0.0] + s * 290.0 * side * np.sin(np.minimum(t * 1.5, 1.0) * np.pi / 2.0)
               + np.array([-185.0, 25.0, 0.0]) * np.maximum(t - 0.35, 0.0) ** 1.5 * 1.7)
        parts += [pipe(list(bar), 11.0, steel), pipe(list(bar[-5:] + [0.0, 1.0, 0.0]), 16.0, leather)]
        # Crank arm and pedal
        arm = CRANK + s * 70.0 * side
        foot = arm + s * np.array([150.0, -75.0, 0.0])
        far, along = foot + s * 30.0 * side, np.array([42.0, 0.0, 0.0])
        parts += [pipe([CRANK, arm], 12.0, steel), pipe([arm, foot], 10.0, steel),
                  pipe([foot, far], 6.0, steel),
                  pipe([far - along, far + along], 15.0, rubber)]
    for hub in (REAR, FRONT):
        parts += [torus(hub, WHEEL, 17.0, rubber), torus(hub, WHEEL - 20.0, 8.0, steel),
                  pipe([hub - 66.0 * side, hub + 66.0 * side], 15.0, steel)]
        for k in range(SPOKES):
            phi, across = 2.0 * np.pi * k / SPOKES, (22.0 if k % 2 else -22.0) * side
            lean = phi + (0.9 if k // 2 % 2 else -0.9)
            parts.append(tube(np.stack([hub + across + 24.0 * np.array([np.cos(lean), np.sin(lean), 0.0]),
                                        hub + (WHEEL - 22.0) * np.array([np.cos(phi), np.sin(phi), 0.0])]), 1.6, steel,
                              1.0, 4, "bicycle"))
        # Mudguard
        low, high = (0.15, 1.05) if hub is REAR else (0.18, 0.72)
        turns = np.pi * np.linspace(low, high, 20)[:, None]
        parts.append(pipe(list(hub + (WHEEL + 32.0) * np.concatenate([np.cos(turns), np.sin(turns), 0.0 * turns], 1)),
                          14.0, steel))
    # Drive: chain wheel, chain; saddle on its post; stem; lamp
    parts += [torus(CRANK + 46.0 * side, 88.0, 5.0, steel), torus(CRANK + 46.0 * side, 52.0, 4.0, steel),
              torus(REAR + 46.0 * side, 38.0, 5.0, steel),
              *(pipe([CRANK + [0.0, s * 86.0, 46.0], REAR + [0.0, s * 37.0, 46.0]], 4.0, rubber) for s in (-1.0, 1.0)),
              pipe([SEAT, SEAT + [-38.0, 125.0, 0.0]], 12.0, steel),
              pipe([HEAD + [-8.0, 30.0, 0.0], HEAD + [-18.0, 95.0, 0.0], HEAD + [30.0, 105.0, 0.0]], 12.0, steel),
              pipe([SEAT + [-170.0, 150.0, 0.0], SEAT + [-150.0, 152.0, 0.0], SEAT + [-60.0, 146.0, 0.0],
                    SEAT + [60.0, 140.0, 0.0], SEAT + [105.0, 132.0, 0.0]], 62.0, leather, 0.25),
              pipe([HEAD + [40.0, 40.0, 0.0], np.array(BEAM) - [75.0, -10.0, 0.0]], 7.0, steel),
              pipe([np.array(BEAM) - [x, 0.0, 0.0] for x in (80.0, 40.0, 4.0)], 30.0, steel, 1.6)]
    return joined(parts, turn, position, "bicycle")


# Figures for signs, five dots wide and seven high

_GLYPHS = {
    "0": "01110 10001 10011 10101 11001 10001 01110", "1": "00100 01100 00100 00100 00100 00100 01110",
    "2": "01110 10001 00001 00110 01000 10000 11111", "3": "01110 10001 00001 00110 00001 10001 01110",
    "4": "00010 00110 01010 10010 11111 00010 00010", "5": "11111 10000 11110 00001 00001 10001 01110",
    "6": "01110 10000 11110 10001 10001 10001 01110", "7": "11111 00001 00010 00100 01000 01000 01000",
    "8": "01110 10001 10001 01110 10001 10001 01110", "9": "01110 10001 10001 01111 00001 00001 01110",
    ".": "00000 00000 00000 00000 00000 00100 00100", "m": "00000 00000 11010 10101 10101 10101 10101",
    " ": "00000 00000 00000 00000 00000 00000 00000",
}


def lettering(text: str, dots: int = 1) -> np.ndarray:
    """The text as an array (7 dots high, 6 a letter wide): 1 where it is inked; each dot `dots` texels wide."""
    letters = [np.array([[int(c) for c in line] + [0] for line in _GLYPHS[letter].split()], np.float32)
               for letter in text]
    return np.kron(np.concatenate(letters, 1)[:, :-1], np.ones((dots, dots), np.float32))
