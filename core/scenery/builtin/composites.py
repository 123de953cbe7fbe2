"""Groups of rectangles: boxes, bars, spokes and rings. Lengths in mm, world frame."""

import math
from collections.abc import Sequence

import numpy as np

from lensbench.core.scenery.objects.material import Material
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
