"""Light on the surfaces: sky, sun and lamps."""

import numpy as np

from lensbench.lanes import BLUE, GLOW, GREEN, NX, NY, NZ, RED, B, rows, stage

# ∫ (w·u)₊ (w·n)₊ dw / π over the cosine of the angle between u and n, a quartic exact at −1, 0 and 1
RISE0, RISE1, RISE2, RISE4 = 2 / (3 * np.pi), 1 / 3, 1 / (3 * np.pi), 1 / 3 - 1 / np.pi


@stage
def daylight(lanes, p, key):
    """Sky and sun without shadows, in one: RED, GREEN, BLUE become radiance.

    p: sky_parameters (12), direction to the sun (3, unit), its irradiance / π (3).
    """
    real = lanes.dtype.type
    row = rows(lanes)
    glow, nx, ny, nz = row[GLOW], row[NX], row[NY], row[NZ]
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    zr, zg, zb = p[0] - p[3], p[1] - p[4], p[2] - p[5]
    half = real(0.5)
    er, eg, eb = half * (p[3] + p[6]), half * (p[4] + p[7]), half * (p[5] + p[8])
    dr, dg, db = half * (p[3] - p[6]), half * (p[4] - p[7]), half * (p[5] - p[8])
    ux, uy, uz, sx, sy, sz, sr, sg, sb = p[9], p[10], p[11], p[12], p[13], p[14], p[15], p[16], p[17]
    for i in range(B):
        up = ux * nx[i] + uy * ny[i] + uz * nz[i]
        rise = real(RISE0) + up * (real(RISE1) + up * (real(RISE2) + up * up * real(RISE4)))
        slant = sx * nx[i] + sy * ny[i] + sz * nz[i]
        slant = slant if slant > real(0) else real(0)
        shine = glow[i] > real(0)
        red[i] *= real(1) if shine else er + up * dr + rise * zr + slant * sr
        green[i] *= real(1) if shine else eg + up * dg + rise * zg + slant * sg
        blue[i] *= real(1) if shine else eb + up * db + rise * zb + slant * sb
