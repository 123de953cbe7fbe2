"""The sky, the farthest surface: a gradient of three colours, and the sun's disk.

Radiance along a unit direction whose component along `up` is m:
horizon + m (zenith − horizon) for m ≥ 0, and `ground` below the horizon.
"""

import math

import numpy as np

from lensbench.kernels.block import BLUE, DEPTH, EMITS, FINISH, GREEN, NX, NY, NZ, RED, B, L, M, N, rows, stage
from lensbench.kernels.cache import njit
from lensbench.kernels.layout import offsets, pack, vector
from lensbench.scenery.values import unit

FAR = 1e9               # mm: DEPTH of the sky
SKY_DISTANCE = 1e8      # mm: what is farther counts as the sky
ZENITH, HORIZON, GROUND, UP, SKY = offsets(3, 3, 3, 3)
DIRECTION, CHORD2, RADIANCE, SUN_DISK = offsets(3, 1, 3)


def sky_parameters(sky) -> np.ndarray:
    """Radiances and unit up direction of a `Sky`."""
    return pack(SKY, {ZENITH: sky.zenith, HORIZON: sky.horizon, GROUND: sky.ground, UP: unit(sky.up)})


def sun_disk_parameters(sun, radius: float) -> np.ndarray:
    """Direction, squared chord and radiance of a `Sun` shown as a disk of this angular radius (radians)."""
    return pack(SUN_DISK, {DIRECTION: unit(sun.direction), CHORD2: (2.0 * math.sin(radius / 2)) ** 2,
                           RADIANCE: np.asarray(sun.colour) / math.sin(radius) ** 2})


@njit(inline="always")
def gradient(p, k):
    """Coefficients of the sky at p[k …]: radiance at the horizon, its change to the zenith, ground, up; 3 each."""
    (zr, zg, zb), (r, g, b) = vector(p, k + ZENITH), vector(p, k + HORIZON)
    return (r, g, b), (zr - r, zg - g, zb - b), vector(p, k + GROUND), vector(p, k + UP)


@stage
def sky(lanes, p, ints, key):
    """Begin the intersection of rays: each sees the sky.  p: sky_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz = row[L], row[M], row[N]
    depth, emits, finish = row[DEPTH], row[EMITS], row[FINISH]
    nx, ny, nz = row[NX], row[NY], row[NZ]
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    (r, g, b), (dr, dg, db), (gr, gg, gb), (ux, uy, uz) = gradient(p, 0)
    for i in range(B):
        up = ux * dx[i] + uy * dy[i] + uz * dz[i]
        above = up >= real(0)
        depth[i], emits[i], finish[i] = real(FAR), real(1), real(0)
        nx[i], ny[i], nz[i] = real(0), real(0), real(0)
        red[i] = r + up * dr if above else gr
        green[i] = g + up * dg if above else gg
        blue[i] = b + up * db if above else gb


@stage
def sun_disk(lanes, p, ints, key):
    """Draw the sun on the sky, directly after `sky`.  p: sun_disk_parameters.

    The squared chord |d − s|² = (2 sin α/2)² is exact in float32 where the cosine of so small an angle α is not.
    """
    row = rows(lanes)
    dx, dy, dz, red, green, blue = row[L], row[M], row[N], row[RED], row[GREEN], row[BLUE]
    (sx, sy, sz), chord2, (r, g, b) = vector(p, DIRECTION), p[CHORD2], vector(p, RADIANCE)
    for i in range(B):
        ax, ay, az = dx[i] - sx, dy[i] - sy, dz[i] - sz
        seen = ax * ax + ay * ay + az * az < chord2
        red[i] = r if seen else red[i]
        green[i] = g if seen else green[i]
        blue[i] = b if seen else blue[i]
