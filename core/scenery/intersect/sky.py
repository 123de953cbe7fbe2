"""The sky, the farthest thing there is: a gradient of three colours, and the sun's disk.

Radiance along a unit direction whose part along `up` is m:
horizon + m (zenith − horizon) for m ≥ 0, and `ground` below the horizon.
"""

import math

import numpy as np

from lensbench.kernels.block import BLUE, DEPTH, EMITS, GLOSS, GREEN, NX, NY, NZ, RED, B, L, M, N, rows, stage

FAR = 1e9               # mm: DEPTH of the sky


def sky_parameters(sky) -> np.ndarray:
    """Radiance at zenith, horizon and ground (9), unit up (3)."""
    up = np.asarray(sky.up, np.float64)
    return np.array([*sky.zenith, *sky.horizon, *sky.ground, *(up / math.sqrt(up @ up))])


@stage
def sky(lanes, p, key):
    """Nothing nearer than the sky.  p: sky_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz = row[L], row[M], row[N]
    depth, glow, gloss = row[DEPTH], row[EMITS], row[GLOSS]
    nx, ny, nz = row[NX], row[NY], row[NZ]
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    r, g, b, dr, dg, db = p[3], p[4], p[5], p[0] - p[3], p[1] - p[4], p[2] - p[5]
    gr, gg, gb = p[6], p[7], p[8]
    ux, uy, uz = p[9], p[10], p[11]
    for i in range(B):
        up = ux * dx[i] + uy * dy[i] + uz * dz[i]
        above = up >= real(0)
        depth[i], glow[i], gloss[i] = real(FAR), real(1), real(0)
        nx[i], ny[i], nz[i] = real(0), real(0), real(0)
        red[i] = r + up * dr if above else gr
        green[i] = g + up * dg if above else gg
        blue[i] = b + up * db if above else gb


@stage
def sun_disk(lanes, p, key):
    """The sun on the sky, directly after it.  p: unit direction (3), (2 sin of half its angular radius)², radiance (3).

    The chord |d − s| is exact in float32 where the cosine of so small an angle is not.
    """
    row = rows(lanes)
    dx, dy, dz, red, green, blue = row[L], row[M], row[N], row[RED], row[GREEN], row[BLUE]
    sx, sy, sz, chord2, r, g, b = p[0], p[1], p[2], p[3], p[4], p[5], p[6]
    for i in range(B):
        ax, ay, az = dx[i] - sx, dy[i] - sy, dz[i] - sz
        seen = ax * ax + ay * ay + az * az < chord2
        red[i] = r if seen else red[i]
        green[i] = g if seen else green[i]
        blue[i] = b if seen else blue[i]
