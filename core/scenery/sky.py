"""The sky: the farthest thing there is, a gradient of three colours.

Radiance along a unit direction whose part along `up` is m:
horizon + m (zenith − horizon) for m ≥ 0, and `ground` below the horizon.
"""

import math

import numpy as np

from lensbench.lanes import BLUE, DEPTH, GLOSS, GLOW, GREEN, NX, NY, NZ, RED, B, L, M, N, rows, stage

FAR = 1e9               # mm: DEPTH of the sky


def sky_parameters(zenith, horizon, ground, up) -> np.ndarray:
    """Zenith, horizon, ground (radiance), up (unit): 12 numbers."""
    return np.array([*zenith, *horizon, *ground, *up], np.float64)


@stage
def sky(lanes, p, key):
    """Nothing nearer than the sky.  p: sky_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    l, m, n = row[L], row[M], row[N]
    depth, glow, gloss = row[DEPTH], row[GLOW], row[GLOSS]
    nx, ny, nz = row[NX], row[NY], row[NZ]
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    r, g, b, dr, dg, db = p[3], p[4], p[5], p[0] - p[3], p[1] - p[4], p[2] - p[5]
    gr, gg, gb = p[6], p[7], p[8]
    ux, uy, uz = p[9], p[10], p[11]
    for i in range(B):
        up = ux * l[i] + uy * m[i] + uz * n[i]
        above = up >= real(0)
        depth[i], glow[i], gloss[i] = real(FAR), real(1), real(0)
        nx[i], ny[i], nz[i] = real(0), real(0), real(0)
        red[i] = r + up * dr if above else gr
        green[i] = g + up * dg if above else gg
        blue[i] = b + up * db if above else gb


def sky_irradiance(up, p):
    """Irradiance / π on a surface whose normal has the part `up` along the sky's up; p: sky_parameters.

    ∫ (w·u)₊ (w·n)₊ dw = ⅔ (sin θ + (π − θ) cos θ), the arc-cosine kernel of degree one.
    """
    theta = np.arccos(np.clip(up, -1.0, 1.0))
    rise = 2.0 / 3.0 * (np.sin(theta) + (math.pi - theta) * np.cos(theta)) / math.pi
    zenith, horizon, ground = (np.asarray(p[j:j + 3]) for j in (0, 3, 6))
    up = np.asarray(up)[..., None]
    return horizon * (1 + up) / 2 + (zenith - horizon) * rise[..., None] + ground * (1 - up) / 2
