"""Flat port: a plane window between a camera in air and a medium of another index, at the camera's foremost point."""

import math

import numpy as np

from lensbench.kernels.block import WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage

# Parameters of `port`: z of the window (mm, camera frame), 1 / index of the medium, factor of the weights
WINDOW_Z, RATIO, GAIN = range(3)


@stage
def port(lanes, p, ints, key):
    """Refract the ray at the window by Snell's law, camera frame. p: see WINDOW_Z and following.

    A ray that runs along the window or backwards gets WEIGHT 0.
    """
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
