"""What a whole block of rays can reach: a few comparisons for an object in place of B.

A block is a compact piece of the picture, so its rays fill a thin pyramid, and
the points that they meet a small box. Least and greatest values are taken of
whole numbers, for the order of such sums does not matter and they run in full registers.
"""

import math

import numpy as np
from numba import njit

from lensbench.kernels.block import (
    A0,
    A1,
    A2,
    A3,
    A4,
    A5,
    A6,
    BEAM,
    BLUE,
    GREEN,
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

FINE = 1048576.0        # steps of a slope
STEPS = 8.0             # steps of a millimetre
MOST = 1 << 30


@stage
def beam(lanes, p, key):
    """The pyramid of the block's rays between two pairs of planes: 22 numbers in the row BEAM, for `outside`.

    0: 1 where there is such a beam, 0 where the rays look too far apart; 1 … 3 a point; 4 … 12 unit axes forward,
    up and right; then for all rays, in that frame, where the rearmost begins (mm), the least and the greatest height
    at the point (mm), the least and the greatest slope, and the same four to the right.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, out = row[X], row[Y], row[Z], row[L], row[M], row[N], row[BEAM]
    # the frame of a ray in the middle, or of the first one that has a direction
    k = B // 2
    if not dx[k] * dx[k] + dy[k] * dy[k] + dz[k] * dz[k] > real(0.5):
        k = 0
        while k < B - 1 and not dx[k] * dx[k] + dy[k] * dy[k] + dz[k] * dz[k] > real(0.5):
            k += 1
    ox, oy, oz, fx, fy, fz = x[k], y[k], z[k], dx[k], dy[k], dz[k]
    level = math.sqrt(fx * fx + fz * fz)
    turn = real(1) / level if level > real(1e-3) else real(0)
    rx, rz = (-fz * turn, fx * turn) if level > real(1e-3) else (real(1), real(0))
    ux, uy, uz = -fy * rz, rz * fx - rx * fz, rx * fy
    # of origins and directions what lies along the axes; a lane without a direction is as the first one is
    most, least = np.int32(MOST), np.int32(-MOST)
    rear, front, low, high, left, right = most, least, most, least, most, least
    slow, flat, steep, west, east = most, most, least, most, least
    step, fine = real(STEPS), real(FINE)
    for i in range(B):
        u, v, w = dx[i], dy[i], dz[i]
        there = u * u + v * v + w * w > real(0.5)
        ax, ay, az = (x[i] - ox) * step, (y[i] - oy) * step, (z[i] - oz) * step
        u, v, w = u * fine, v * fine, w * fine
        off, height, aside = ax * fx + ay * fy + az * fz, ax * ux + ay * uy + az * uz, ax * rx + az * rz
        ahead, rise, across = u * fx + v * fy + w * fz, u * ux + v * uy + w * uz, u * rx + w * rz
        n = np.int32(off if there else real(0))
        rear, front = min(rear, n), max(front, n)
        n = np.int32(height if there else real(0))
        low, high = min(low, n), max(high, n)
        n = np.int32(aside if there else real(0))
        left, right = min(left, n), max(right, n)
        slow = min(slow, np.int32(ahead if there else fine))
        n = np.int32(rise if there else real(0))
        flat, steep = min(flat, n), max(steep, n)
        n = np.int32(across if there else real(0))
        west, east = min(west, n), max(east, n)
    # a number that is too large has become the least or the greatest of all, as the processor has it
    known = (min(rear, low, left, flat, west) > least) & (max(front, high, right, steep, east) < most)
    out[0] = real(1) if known & (slow > np.int32(0.1 * FINE)) else real(0)
    out[1], out[2], out[3], out[4], out[5], out[6] = ox, oy, oz, fx, fy, fz
    out[7], out[8], out[9], out[10], out[11], out[12] = ux, uy, uz, rx, real(0), rz
    begin, end = _widened(real, rear, front, STEPS)
    out[13] = begin
    _side(real, out[14:], begin, end, fine / real(slow), low, high, flat, steep)
    _side(real, out[18:], begin, end, fine / real(slow), left, right, west, east)


@njit(inline="always")
def _widened(real, low, high, steps):
    """Least and greatest number, by as much more as was rounded away."""
    return (real(low) - real(2)) * real(1 / steps), (real(high) + real(2)) * real(1 / steps)


@njit(inline="always")
def _side(real, out, begin, end, per, low, high, flat, steep):
    """Heights as they are at the point, of places from begin to end, and slopes of directions 1 … 1 / per forward."""
    low, high = _widened(real, low, high, STEPS)
    flat, steep = _widened(real, flat, steep, FINE)
    flat, steep = min(flat, flat * per), max(steep, steep * per)
    a, b, c, d = begin * flat, begin * steep, end * flat, end * steep
    out[0], out[1], out[2], out[3] = low - max(a, b, c, d), high - min(a, b, c, d), flat, steep


@stage
def beam_misses(seen, cx, cy, cz, half_f, half_u, half_r):
    """Whether no ray of a `beam`, its row, can meet a box: its centre, its half-widths along forward, up and right."""
    ax, ay, az = cx - seen[1], cy - seen[2], cz - seen[3]
    f = ax * seen[4] + ay * seen[5] + az * seen[6]
    u = ax * seen[7] + ay * seen[8] + az * seen[9]
    r = ax * seen[10] + az * seen[12]
    near, far = f - half_f, f + half_f
    down = seen[14] + min(near * seen[16], far * seen[16], near * seen[17], far * seen[17])
    up = seen[15] + max(near * seen[16], far * seen[16], near * seen[17], far * seen[17])
    left = seen[18] + min(near * seen[20], far * seen[20], near * seen[21], far * seen[21])
    right = seen[19] + max(near * seen[20], far * seen[20], near * seen[21], far * seen[21])
    missed = (down > u + half_u) | (up < u - half_u) | (left > r + half_r) | (right < r - half_r) | (far < seen[13])
    return missed & (seen[0] > 0)                                   # NaN, from an endless box: not outside


@stage
def shadow_bounds(lanes):
    """The box round the lit points A0 A1 A2 and the points of the light that they see: lows (3), highs (3), in mm.

    A point of the light lies from there along A3 A4 A5 at the distance A6, no farther than 1 km.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    hx, hy, hz, wx, wy, wz, far = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5], row[A6]
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    x0, x1 = np.int32(MOST), np.int32(-MOST)
    y0, y1, z0, z1 = x0, x1, x0, x1
    for i in range(B):
        lit = red[i] + green[i] + blue[i] > real(0)
        t = far[i] if far[i] < real(1e6) else real(1e6)
        ax, ay, az = hx[i], hy[i], hz[i]
        bx, by, bz = ax + t * wx[i], ay + t * wy[i], az + t * wz[i]
        p, q = np.int32(ax if lit else real(0)), np.int32(bx if lit else real(0))
        x0, x1 = min(x0, min(p, q) if lit else np.int32(MOST)), max(x1, max(p, q) if lit else np.int32(-MOST))
        p, q = np.int32(ay if lit else real(0)), np.int32(by if lit else real(0))
        y0, y1 = min(y0, min(p, q) if lit else np.int32(MOST)), max(y1, max(p, q) if lit else np.int32(-MOST))
        p, q = np.int32(az if lit else real(0)), np.int32(bz if lit else real(0))
        z0, z1 = min(z0, min(p, q) if lit else np.int32(MOST)), max(z1, max(p, q) if lit else np.int32(-MOST))
    one = np.int32(2)
    return (real(np.int32(x0 - one)), real(np.int32(y0 - one)), real(np.int32(z0 - one)),
            real(np.int32(x1 + one)), real(np.int32(y1 + one)), real(np.int32(z1 + one)))


@stage
def boxes_disjoint(box, cx, cy, cz, half_x, half_y, half_z):
    """Whether a box has nothing in common with another: its centre and half-widths."""
    return ((cx + half_x < box[0]) | (cx - half_x > box[3]) | (cy + half_y < box[1]) | (cy - half_y > box[4])
            | (cz + half_z < box[2]) | (cz - half_z > box[5]))


@stage
def plane_misses(box, cx, cy, cz, ux, uy, uz):
    """Whether a box lies wholly on one side of a plane: a point of the plane and its unit normal."""
    mx, my, mz = (box[0] + box[3]) / 2 - cx, (box[1] + box[4]) / 2 - cy, (box[2] + box[5]) / 2 - cz
    half = (abs(ux) * (box[3] - box[0]) + abs(uy) * (box[4] - box[1]) + abs(uz) * (box[5] - box[2])) / 2
    return abs(mx * ux + my * uy + mz * uz) > half
