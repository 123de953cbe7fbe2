"""A look from inside a panorama: where to, and how wide. Angles in radians, directions in the camera's frame."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import lensbench as lb

NARROWEST, WIDEST = math.radians(10.0), math.radians(130.0)
STEEPEST = math.radians(90.0)


@dataclass(frozen=True)
class LookAround:
    """yaw to the left, pitch up, fov: the angle along the longer side of the view."""

    yaw: float = 0.0
    pitch: float = 0.0
    fov: float = math.radians(90.0)

    def reach(self, size: tuple[float, float]) -> tuple[float, float]:
        """Tangents of half the angles across and down of a view of this size."""
        most = math.tan(0.5 * self.fov) / max(*size, 1e-6)
        return size[0] * most, size[1] * most

    @property
    def axes(self) -> NDArray[np.float64]:
        """Right, up and back of the view as columns (3, 3)."""
        cy, sy, cp, sp = math.cos(self.yaw), math.sin(self.yaw), math.cos(self.pitch), math.sin(self.pitch)
        return np.array([[cy, sy * sp, sy * cp], [0.0, cp, -sp], [-sy, cy * sp, cy * cp]])

    def dragged(self, x: float, y: float, size: tuple[float, float]) -> "LookAround":
        """The look after a drag by x to the right and y down (pixels): what was in the middle goes with the mouse."""
        across, down = self.reach(size)
        yaw = math.remainder(self.yaw + math.atan(2.0 * x * across / max(size[0], 1.0)), 2.0 * math.pi)
        pitch = self.pitch + math.atan(2.0 * y * down / max(size[1], 1.0))
        return replace(self, yaw=yaw, pitch=min(max(pitch, -STEEPEST), STEEPEST))

    def zoomed(self, steps: float) -> "LookAround":
        """The look after so many clicks of the wheel: narrower for positive ones."""
        return replace(self, fov=min(max(self.fov * 0.92**steps, NARROWEST), WIDEST))

    def raster(self, at: tuple[float, float], size: tuple[float, float], film: lb.Film, layout: str,
               ) -> tuple[float, float]:
        """The raster point of the panorama at a place of the view, in parts of its width and height."""
        across, down = self.reach(size)
        direction = self.axes @ [(2.0 * at[0] - 1.0) * across, (1.0 - 2.0 * at[1]) * down, -1.0]
        (x, y), = lb.EnvironmentCamera(film, layout=layout).film_from_point(direction[None], None)[0]
        return float((0.5 - x / film.width) * film.pixels_x), float((0.5 + y / film.height) * film.pixels_y)
