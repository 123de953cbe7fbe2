"""Flat port: a plane window between a camera in air and a medium of another index, at the camera's foremost point.

Seen through it along the axis, all beyond appears nearer to the window by the index (Jenkins and White, "Fundamentals
of Optics", section 2.6). Off the axis it appears nearer still, and as two foci.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from lensbench.core.kernels.block import WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage

# Parameters of `port`: z of the window (mm, camera frame), 1 / index of the medium, factor of the weights
WINDOW_Z, RATIO, GAIN = range(3)


@stage
def port(lanes, p, ints, key):
    """Refract the ray at the window by Snell's law; WEIGHT 0 for one along it or backwards. p: WINDOW_Z …."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    window, ratio, gain = p[WINDOW_Z], p[RATIO], p[GAIN]
    for i in range(B):
        out = n[i] < real(0)
        t = (window - z[i]) / n[i]
        a, b = ratio * l[i], ratio * m[i]
        x[i] += t * l[i]
        y[i] += t * m[i]
        z[i] = window
        l[i], m[i], n[i] = a, b, -math.sqrt(real(1) - a * a - b * b)
        weight[i] = weight[i] * gain if out else real(0)


def port_step(z: float, index: float, gain: float) -> Step:
    """Step through a window at z (mm, camera frame) into a medium of this index; gain: factor of the weights."""
    p = np.empty(3)
    p[WINDOW_Z], p[RATIO], p[GAIN] = z, 1.0 / index, gain
    return Step(port, p)


@dataclass(frozen=True)
class FlatPort:
    """A window `window` mm from where distances begin, and the index beyond, 1 without one; paraxially."""

    window: float = 0.0
    index: float = 1.0

    def apparent(self, distance: Any) -> Any:
        """The distance (mm, also an array, also inf) at which the camera sees what is at a distance before it."""
        return self.window + (distance - self.window) / self.index

    def true(self, apparent: Any) -> Any:
        """The distance (mm, also an array, also inf) of what the camera sees at a distance; inverse of `apparent`."""
        return self.window + self.index * (apparent - self.window)

    def seen_angle(self, angle: float) -> float:
        """The angle (radians) from the axis, beyond the window, of a ray that has an angle from it in air."""
        return math.asin(math.sin(min(angle, 0.5 * math.pi)) / self.index) if self.index != 1.0 else angle

    def stretch(self, slope: Any) -> Any:
        """True over apparent distance beyond the window for a ray of a slope (tan of the angle in air, also an array).

        The mean of the two foci of an oblique beam, n cos θ′ / cos θ and n cos³ θ′ / cos³ θ, θ′ beyond the window.
        """
        square = slope**2 / (1.0 + slope**2)                            # sin² θ
        ratio = np.sqrt((1.0 - square / self.index**2) / (1.0 - square))
        return self.index * 0.5 * (ratio + ratio**3)
