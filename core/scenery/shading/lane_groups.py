"""Groups of lit lanes of a block that see nearly the same lights.

A group holds the lanes of a chunk of neighbouring pixels, or, where these lie at two depths, as at the edge of an
object, half of them.
"""

import math

import numpy as np

from lensbench.kernels.block import (
    A0,
    A1,
    A2,
    A11,
    BLUE,
    DEPTH,
    GREEN,
    NX,
    NY,
    NZ,
    RED,
    B,
    L,
    M,
    N,
    X,
    Y,
    Z,
    rows,
    stage,
)
from lensbench.kernels.layout import offsets
from lensbench.kernels.tile_order import STRIP_WIDTH

WIDE, HIGH = 8, 4       # pixels of a chunk, in a strip of the film of full width
CHUNKS = B // (WIDE * HIGH)
GROUPS = 2 * CHUNKS
DEEP = 1.1              # greatest depth of a chunk over its least, from which on it is halved
STEPS = 8.0             # of a millimetre: bounds are found of integers, as in `block_bounds`
FINE = 1024.0           # steps of a component of a normal
MOST = 1 << 30
# A group: middle and half-widths of the box around its points, mm, and the mean of their normals
BOX_MIDDLE, BOX_HALF, NORMAL, GROUP = offsets(3, 3, 3)


@stage
def group_lanes(lanes, groups, many):
    """Find the points A0 A1 A2 and the group A11 of each lane, and bound the groups; many: lit lanes of each."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, depth = row[X], row[Y], row[Z], row[L], row[M], row[N], row[DEPTH]
    nx, ny, nz, red, green, blue = row[NX], row[NY], row[NZ], row[RED], row[GREEN], row[BLUE]
    hx, hy, hz, number = row[A0], row[A1], row[A2], row[A11]
    for i in range(B):
        t = depth[i]
        hx[i], hy[i], hz[i] = x[i] + t * dx[i], y[i] + t * dy[i], z[i] + t * dz[i]
    most, least, step, fine = np.int32(MOST), np.int32(-MOST), real(STEPS), real(FINE)
    for c in range(CHUNKS):
        first = c // (STRIP_WIDTH // WIDE) * (HIGH * STRIP_WIDTH) + c % (STRIP_WIDTH // WIDE) * WIDE

        # Halve the lit lanes by depth
        near, far = most, np.int32(0)
        for k in range(HIGH):
            for e in range(WIDE):
                i = first + k * STRIP_WIDTH + e
                inside = red[i] + green[i] + blue[i] > real(0)
                t = np.int32(depth[i] * step if inside else real(0))
                near, far = min(near, t if inside else most), max(far, t)
        halved = real(far) > real(DEEP) * real(near)
        cut = math.sqrt(real(near) * real(far)) / step if halved else real(math.inf)
        many[2 * c + 1] = 0

        # Bound each half
        for part in range(2 if halved else 1):
            x0, x1, y0, y1, z0, z1 = most, least, most, least, most, least
            sx, sy, sz, lit = np.int32(0), np.int32(0), np.int32(0), np.int32(0)
            for k in range(HIGH):
                for e in range(WIDE):
                    i = first + k * STRIP_WIDTH + e
                    beyond = depth[i] > cut
                    inside = (red[i] + green[i] + blue[i] > real(0)) & (beyond == (part == 1))
                    n = np.int32(hx[i] * step if inside else real(0))
                    x0, x1 = min(x0, n if inside else most), max(x1, n if inside else least)
                    n = np.int32(hy[i] * step if inside else real(0))
                    y0, y1 = min(y0, n if inside else most), max(y1, n if inside else least)
                    n = np.int32(hz[i] * step if inside else real(0))
                    z0, z1 = min(z0, n if inside else most), max(z1, n if inside else least)
                    sx = np.int32(sx + np.int32(nx[i] * fine if inside else real(0)))
                    sy = np.int32(sy + np.int32(ny[i] * fine if inside else real(0)))
                    sz = np.int32(sz + np.int32(nz[i] * fine if inside else real(0)))
                    lit = np.int32(lit + np.int32(inside))
                    number[i] = real(2 * c + 1) if beyond else real(2 * c)
            g = 2 * c + part
            many[g] = lit
            box, half = groups[g * GROUP:], real(0.5) / step
            per = real(1) / (fine * real(max(lit, np.int32(1))))
            box[BOX_MIDDLE], box[BOX_HALF] = (real(x0) + real(x1)) * half, (real(x1) - real(x0)) * half
            box[BOX_MIDDLE + 1], box[BOX_HALF + 1] = (real(y0) + real(y1)) * half, (real(y1) - real(y0)) * half
            box[BOX_MIDDLE + 2], box[BOX_HALF + 2] = (real(z0) + real(z1)) * half, (real(z1) - real(z0)) * half
            box[NORMAL], box[NORMAL + 1], box[NORMAL + 2] = real(sx) * per, real(sy) * per, real(sz) * per
