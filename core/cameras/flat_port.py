"""A flat window between a camera in air and a denser medium, before its foremost point."""

import math

import numpy as np

from lensbench.kernels.block import WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage


@stage
def port(lanes, p, key):
    """On to the window and into the medium, in the camera frame; a ray that runs along it or back is lost.

    p: z of the window (mm), 1 / index of the medium, what weights are multiplied by.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    window, ratio, gain = p[0], p[1], p[2]
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
    """The step of a window at z (mm, camera frame) into a medium of this index."""
    return Step(port, np.array([z, 1.0 / index, gain]))
