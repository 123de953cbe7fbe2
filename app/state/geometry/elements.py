"""Outlines of the glass of a lens in the meridional plane, element by element.

Lengths in mm, lens frame: points are (z, y). The meridional plane cuts surfaces out of line where they stand. Where the
two surfaces of an element have different semi-diameters, the smaller one ends in a flat shoulder, and the edge is a
cylinder of the larger one.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

import lensbench as lb
from lensbench.kernels.rotation import rotation_about_z

STEP = 0.06             # of the edge's radius, the tallest strip: its chord errs by less than a pixel on a screen
SURFACE_POINTS = 33     # of an outline's curve, rim to rim
HEIGHTS = np.sin(np.linspace(-0.5 * np.pi, 0.5 * np.pi, SURFACE_POINTS))      # of the rim, closer towards it
CUT_STEPS = 20          # of the iteration for the cut of a surface out of line
EDGE_POINTS, EDGE_STEPS = 65, 7     # heights of which one is the edge, and how often the gap beside it is divided


@dataclass(frozen=True, eq=False)
class Element:
    """One piece of glass between surfaces `front` and `front` + 1.

    outline (n, 2): closed, counter-clockwise, from the lower end of the front surface.
    front_at, rear_at: points (n, 2) of the two surfaces at heights, which a surface out of line measures from its own
    axis; corners: heights from 0 at which the shape has corners.
    """

    front: int
    glass: lb.Glass
    outline: np.ndarray
    front_at: Callable[[ArrayLike], np.ndarray]
    rear_at: Callable[[ArrayLike], np.ndarray]
    corners: tuple[float, ...]

    @cached_property
    def strips(self) -> np.ndarray:
        """Quadrilaterals (m, 4, 2), each convex, that fill the outline without overlap."""
        upper, edge = [0.0], self.corners[-1]
        for low, high in pairwise(self.corners):
            count = max(1, math.ceil((high - low) / (STEP * edge)))
            upper += [low + (high - low) * (k + 1) / count for k in range(count)]
        y = np.array([-h for h in reversed(upper[1:])] + upper)
        left, right = self.front_at(y), self.rear_at(y)
        return np.stack([left[:-1], left[1:], right[1:], right[:-1]], axis=1)

    def holds(self, z: float, y: float) -> bool:
        """Whether a point lies in the glass."""
        inside = False
        points = self.outline
        for (z0, y0), (z1, y1) in zip(points, np.roll(points, -1, axis=0), strict=True):
            if (y0 > y) != (y1 > y) and z < z0 + (y - y0) / (y1 - y0) * (z1 - z0):
                inside = not inside
        return inside


def sag(surface: lb.Surface, x: ArrayLike, y: ArrayLike) -> np.ndarray:
    """Depth of a surface at points of its frame before its roll, flat beyond its rim and beyond a sphere's equator."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    c, height = surface.curvature, np.hypot(x, y)
    r = np.minimum(height, min(surface.semi_diameter, 1.0 / abs(c) if c else np.inf))
    depth = c * r * r / (1.0 + np.sqrt(np.maximum(1.0 - c * c * r * r, 0.0)))
    if not surface.is_spherical:
        roll = surface.pose.roll if surface.pose is not None else 0.0
        cosine, sine = math.cos(roll), math.sin(roll)
        within = surface.semi_diameter / np.maximum(height, surface.semi_diameter)
        own = surface.sag(within * (cosine * x + sine * y), within * (cosine * y - sine * x))
        depth = np.where(np.isfinite(own), own, depth)
    return depth


def before_roll(lens: lb.Lens, i: int) -> np.ndarray:
    """Axes (3, 3), in columns, of the frame of a surface out of line before its roll."""
    frame, pose = lens.frames[i], lens.surfaces[i].pose
    assert frame is not None and pose is not None
    return frame.rotation @ rotation_about_z(-pose.roll) if pose.roll else frame.rotation


@lru_cache(maxsize=32)
def elements(lens: lb.Lens) -> tuple[Element, ...]:
    """Every piece of glass of the lens, from the scene to the film."""
    return tuple(_element(lens, i) for i, surface in enumerate(lens.surfaces[:-1]) if surface.glass.n_d > 1.0)


def cut(lens: lb.Lens, i: int, heights: ArrayLike, reach: float) -> np.ndarray:
    """Points (n, 2) of surface i in the meridional plane, at heights from its own axis.

    The plane cuts a surface that is decentred or tilted sideways beside its vertex: heights shrink there, so that they
    end at the circle of radius `reach` (mm) about its axis.
    """
    surface, frame, vertex = lens.surfaces[i], lens.frames[i], lens.vertices[i]
    y = np.asarray(heights, float)
    if frame is None:
        return np.stack([vertex + sag(surface, 0.0, y), y], axis=-1)
    axes = before_roll(lens, i)
    (xx, xy, xz), aside = axes[0], float(frame.at(vertex)[0])
    y = y * math.sqrt(max(0.0, 1.0 - min(1.0, (aside / (xx * reach)) ** 2)))
    x, depth = np.full(y.shape, -aside / xx), np.zeros(y.shape)
    for _ in range(CUT_STEPS):
        depth = sag(surface, x, y)
        x = np.clip(-(aside + xy * y + xz * depth) / xx, -reach, reach)
    at = np.stack([x, y, vertex + depth], axis=-1) @ axes.T + frame.shift
    return at[..., [2, 1]]


@lru_cache(maxsize=16)
def surface_curves(lens: lb.Lens) -> tuple[np.ndarray, ...]:
    """Each surface from rim to rim as points (n, 2) of (z, y), index by index."""
    return tuple(cut(lens, i, surface.semi_diameter * HEIGHTS, surface.semi_diameter)
                 for i, surface in enumerate(lens.surfaces))


def _element(lens: lb.Lens, index: int) -> Element:
    front, rear = lens.surfaces[index], lens.surfaces[index + 1]

    def glass_at(y: ArrayLike) -> np.ndarray:
        """Length of glass at heights, without decentres and tilts."""
        return front.thickness + sag(rear, 0.0, y) - sag(front, 0.0, y)

    # The edge lies at the largest height with glass between both surfaces
    edge = max(front.semi_diameter, rear.semi_diameter)
    if glass_at(edge) < 0.0:
        low, high = 0.0, edge
        for _ in range(EDGE_STEPS):
            heights = np.linspace(low, high, EDGE_POINTS)
            beyond = max(1, int(np.argmax(glass_at(heights) < 0.0)))
            low, high = float(heights[beyond - 1]), float(heights[beyond])
        edge = low

    def front_at(y: ArrayLike) -> np.ndarray:
        return cut(lens, index, y, edge)

    def rear_at(y: ArrayLike) -> np.ndarray:
        return cut(lens, index + 1, y, edge)

    def curve(at: Callable[[ArrayLike], np.ndarray], semi_diameter: float) -> np.ndarray:
        """From the lower edge to the upper: shoulder, surface, shoulder."""
        rim = min(semi_diameter, edge)
        y = rim * HEIGHTS
        if rim < edge:
            y = np.concatenate([[-edge], y, [edge]])
        return at(y)

    outline = np.concatenate([curve(front_at, front.semi_diameter), curve(rear_at, rear.semi_diameter)[::-1]])
    corners = sorted({0.0, min(front.semi_diameter, edge), min(rear.semi_diameter, edge), edge})
    return Element(index, front.glass, outline, front_at, rear_at, tuple(corners))
