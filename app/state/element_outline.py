"""Outlines of the elements of a lens, and convex strips that fill them.

Lengths in mm, lens frame, in the meridional plane: points are (z, y). Where the
two surfaces of an element have different semi-diameters, the smaller one ends in
a flat shoulder, and the edge is a cylinder of the larger one.
"""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, isfinite, sqrt

import numpy as np

from lensbench.optics.glass import Glass
from lensbench.optics.prescription import Lens, Surface

STEP = 0.06             # of the edge's radius, the tallest strip: its chord errs by less than a pixel on a screen
SURFACE_POINTS = 33     # of an outline's curve, rim to rim


@dataclass(frozen=True, eq=False)
class Element:
    """One piece of glass between surfaces `front` and `front` + 1.

    outline (n, 2): closed, counter-clockwise from the front's lower rim or so.
    strips (m, 4, 2): quadrilaterals, each convex, that fill it without overlap.
    """

    front: int
    glass: Glass
    outline: np.ndarray
    strips: np.ndarray

    def holds(self, z: float, y: float) -> bool:
        """Whether a point lies in the glass."""
        inside = False
        points = self.outline
        for (z0, y0), (z1, y1) in zip(points, np.roll(points, -1, axis=0), strict=True):
            if (y0 > y) != (y1 > y) and z < z0 + (y - y0) / (y1 - y0) * (z1 - z0):
                inside = not inside
        return inside


def sag(surface: Surface, height: float) -> float:
    """Depth of a surface at a height in the y–z section, flat beyond its rim and beyond the sphere's equator."""
    c = surface.curvature
    r = min(abs(height), surface.semi_diameter, 1.0 / abs(c) if c else np.inf)
    if not surface.is_spherical:
        depth = float(surface.sag(0.0, min(abs(height), surface.semi_diameter)))
        if isfinite(depth):
            return depth
    return c * r * r / (1.0 + sqrt(max(1.0 - c * c * r * r, 0.0)))


@lru_cache(maxsize=32)
def elements(lens: Lens) -> tuple[Element, ...]:
    """Every piece of glass of the lens, from the scene to the film."""
    vertices = lens.vertices
    found = []
    for i, surface in enumerate(lens.surfaces[:-1]):
        if surface.glass.n_d > 1.0:
            rear = lens.surfaces[i + 1]
            found.append(_element(i, surface, vertices[i], rear, vertices[i + 1]))
    return tuple(found)


def _element(index: int, front: Surface, front_z: float, rear: Surface, rear_z: float) -> Element:
    def front_at(y: float) -> float:
        return front_z + sag(front, y)

    def rear_at(y: float) -> float:
        return rear_z + sag(rear, y)

    # The edge lies at the largest height with glass between both surfaces
    edge = max(front.semi_diameter, rear.semi_diameter)
    if rear_at(edge) < front_at(edge):
        low, high = 0.0, edge
        for _ in range(40):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if rear_at(middle) >= front_at(middle) else (low, middle)
        edge = low

    def curve(at, semi_diameter: float) -> np.ndarray:
        """From the lower edge to the upper: shoulder, surface, shoulder."""
        rim = min(semi_diameter, edge)
        y = rim * np.sin(np.linspace(-0.5 * np.pi, 0.5 * np.pi, SURFACE_POINTS))
        if rim < edge:
            y = np.concatenate([[-edge], y, [edge]])
        return np.array([(at(height), height) for height in y])

    outline = np.concatenate([curve(front_at, front.semi_diameter), curve(rear_at, rear.semi_diameter)[::-1]])

    # Strips between heights, among them those of the rims, where the shape has corners
    corners = sorted({0.0, min(front.semi_diameter, edge), min(rear.semi_diameter, edge), edge})
    heights = [0.0]
    for low, high in zip(corners, corners[1:], strict=False):
        count = max(1, ceil((high - low) / (STEP * edge)))
        heights += [low + (high - low) * (k + 1) / count for k in range(count)]
    y = np.array([-h for h in reversed(heights[1:])] + heights)
    z_front, z_rear = np.array([front_at(h) for h in y]), np.array([rear_at(h) for h in y])
    left, right = np.stack([z_front, y], axis=1), np.stack([z_rear, y], axis=1)
    strips = np.stack([left[:-1], left[1:], right[1:], right[:-1]], axis=1)
    return Element(index, front.glass, outline, strips)
