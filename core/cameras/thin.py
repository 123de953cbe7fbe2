"""The ideal lenses: a pinhole, and a thin lens that images every film point to a point of the plane in focus."""

import math

import numpy as np

from lensbench.disk import concentric
from lensbench.lanes import U0, U1, WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage


@stage
def thin_lens(lanes, p, key):
    """From the film point X, Y to a ray through the lens, in the camera frame.

    p: z of the lens, radius of the lens, distance z′ from the lens to its
    (imagined) film, 1 / distance from the lens to the plane in focus, area / normaliser.
    WEIGHT becomes cos⁴θ · area / normaliser, θ seen from the film at z′.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    u, v = row[U0], row[U1]
    place, radius, behind, near, gain = p[0], p[1], p[2], p[3], p[4]
    slope = real(-1) / behind
    for i in range(B):
        a, b = concentric(real, v[i], u[i])                 # v = 1/2 and u = 1/2: the centre
        a, b = a * radius, b * radius
        dx, dy = x[i] * slope - a * near, y[i] * slope - b * near
        size = real(1) / math.sqrt(dx * dx + dy * dy + real(1))
        l[i], m[i], n[i] = dx * size, dy * size, -size
        ex, ey = (a - x[i]) * slope, (b - y[i]) * slope
        c2 = real(1) / (ex * ex + ey * ey + real(1))
        weight[i] = c2 * c2 * gain
        x[i], y[i], z[i] = a, b, place


@stage
def pinhole(lanes, p, key):
    """From the film point X, Y to the ray through a hole. p: z of the hole, z′ to its film, area / normaliser."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    place, slope, gain = p[0], real(-1) / p[1], p[2]
    for i in range(B):
        dx, dy = x[i] * slope, y[i] * slope
        c2 = real(1) / (dx * dx + dy * dy + real(1))
        size = math.sqrt(c2)
        l[i], m[i], n[i] = dx * size, dy * size, -size
        weight[i] = c2 * c2 * gain
        x[i], y[i], z[i] = real(0), real(0), place


def axis_irradiance(radius: float, z: float) -> float:
    """∫ cos⁴θ dA over a disk of this radius (mm), from the axis point at distance z (mm): mm²."""
    return math.pi * radius**2 * z**2 / (z**2 + radius**2)


def ideal(place: float, radius: float, behind: float, focus: float, gain: float) -> Step:
    """The step of a thin lens, or of a pinhole where the radius is 0: mm, as in `thin_lens`; focus may be inf."""
    if radius == 0.0:
        return Step(pinhole, np.array([place, behind, gain]))
    return Step(thin_lens, np.array([place, radius, behind, 1.0 / focus, gain]))
