"""The eye of the 3-D view: turned about a point by hand. Lengths in mm, angles in radians, the camera's frame."""

import math
from dataclasses import dataclass, replace

import numpy as np

STEEPEST = math.radians(89.0)
OPENING = math.radians(28.0)    # of the shorter side of the view
NEAR, FAR = 0.02, 400.0         # of the distance: planes between which things are drawn
CLOSEST, FARTHEST = 1.0, 2e5    # mm


@dataclass(frozen=True)
class Eye:
    """Looks at `target` (mm) from a distance; yaw about the upward axis from +z, pitch above the horizon."""

    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    distance: float = 300.0
    yaw: float = math.radians(-65.0)
    pitch: float = math.radians(18.0)

    @property
    def axes(self) -> np.ndarray:
        """Rows: right, up, and from the target to the eye; unit vectors."""
        cy, sy, cp, sp = math.cos(self.yaw), math.sin(self.yaw), math.cos(self.pitch), math.sin(self.pitch)
        return np.array([[cy, 0.0, -sy], [-sy * sp, cp, -cy * sp], [sy * cp, sp, cy * cp]])

    @property
    def place(self) -> np.ndarray:
        """Where the eye is (mm)."""
        return np.asarray(self.target) + self.distance * self.axes[2]

    def clip_from_camera(self, width: float, height: float) -> np.ndarray:
        """The matrix (4, 4) from the camera's frame to OpenGL's clip space, for a view of this shape."""
        view = np.eye(4)
        view[:3, :3] = self.axes
        view[:3, 3] = -self.axes @ self.place
        slope, shorter = math.tan(0.5 * OPENING), min(width, height)
        near, far = NEAR * self.distance, FAR * self.distance
        lens = np.zeros((4, 4))
        lens[0, 0], lens[1, 1] = shorter / width / slope, shorter / height / slope
        lens[2, 2], lens[2, 3], lens[3, 2] = (far + near) / (near - far), 2.0 * far * near / (near - far), -1.0
        return lens @ view

    def turned(self, right: float, down: float) -> "Eye":
        """Turned by a drag (radians): things follow the hand."""
        pitch = min(max(self.pitch + down, -STEEPEST), STEEPEST)
        return replace(self, yaw=math.remainder(self.yaw - right, 2.0 * math.pi), pitch=pitch)

    def moved(self, right: float, up: float) -> "Eye":
        """The target moved across the view by these lengths (mm)."""
        x, y, z = (float(v) for v in np.asarray(self.target) + right * self.axes[0] + up * self.axes[1])
        return replace(self, target=(x, y, z))

    def zoomed(self, factor: float) -> "Eye":
        """Nearer for a factor above 1."""
        return replace(self, distance=min(max(self.distance / factor, CLOSEST), FARTHEST))

    def fitted(self, low: np.ndarray, high: np.ndarray, width: float, height: float) -> "Eye":
        """In the same direction, with a box between two corners (3,) in a view of this shape."""
        corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        middle = 0.5 * (np.asarray(low) + np.asarray(high))
        right, up, back = ((corners - middle) @ self.axes.T).T
        slope, shorter = math.tan(0.5 * OPENING), min(width, height)
        needed = np.maximum(np.abs(right) * shorter / width, np.abs(up) * shorter / height) / slope + back
        x, y, z = (float(v) for v in middle)
        return replace(self, target=(x, y, z), distance=min(max(1.06 * float(needed.max()), CLOSEST), FARTHEST))
