"""What a whole block of rays can reach: a few comparisons for an object in place of B.

A block is a piece of a row of the picture, so its rays fill a thin wedge, and
the points that they meet a thin box. Least and greatest values are taken of
whole numbers, for the order of such sums does not matter and they run in full registers.
"""

import math

import numpy as np

from lensbench.lanes import A0, A1, A2, A3, A4, A5, A6, BLUE, GREEN, RED, B, L, M, N, X, Y, Z, rows, stage

FINE = 1048576.0        # steps of a slope
STEPS = 8.0             # steps of a millimetre
MOST = 1 << 30


@stage
def wedge(lanes):
    """The wedge of the block's rays between two planes that meet near the horizontal: 14 numbers.

    0: 1 where there is such a wedge, 0 where the rays look too far apart; 1 … 3 a point; 4 … 9 unit axes forward
    and up, square to the row of the picture; then for all rays, in that frame, the least and the greatest height
    at the point (mm) and the least and the greatest slope.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
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
    low, high, flat, steep = np.int32(MOST), np.int32(-MOST), np.int32(MOST), np.int32(-MOST)
    wild = np.int32(0)
    for i in range(B):
        ax, ay, az = x[i] - ox, y[i] - oy, z[i] - oz
        ahead = dx[i] * fx + dy[i] * fy + dz[i] * fz
        slope = (dx[i] * ux + dy[i] * uy + dz[i] * uz) / ahead
        height = ax * ux + ay * uy + az * uz - slope * (ax * fx + ay * fy + az * fz)
        good = (ahead > real(0.1)) & (abs(height) < real(1e6))
        there = dx[i] * dx[i] + dy[i] * dy[i] + dz[i] * dz[i] > real(0.5)
        wild = np.int32(wild + np.int32(there & (not good)))
        h = np.int32(height * real(STEPS) if good else real(0))
        s = np.int32(slope * real(FINE) if good else real(0))
        low, high = min(low, h if good else np.int32(MOST)), max(high, h if good else np.int32(-MOST))
        flat, steep = min(flat, s if good else np.int32(MOST)), max(steep, s if good else np.int32(-MOST))
    whole = real(1) if (wild == 0) & (low <= high) else real(0)
    margin = np.int32(2)
    return (whole, ox, oy, oz, fx, fy, fz, ux, uy, uz,
            real(np.int32(low - margin)) * real(1 / STEPS), real(np.int32(high + margin)) * real(1 / STEPS),
            real(np.int32(flat - margin)) * real(1 / FINE), real(np.int32(steep + margin)) * real(1 / FINE))


@stage
def outside(wedge, cx, cy, cz, half_f, half_u):
    """Whether no ray of the wedge can meet a box: its centre, its half-widths along forward and up."""
    ax, ay, az = cx - wedge[1], cy - wedge[2], cz - wedge[3]
    f = ax * wedge[4] + ay * wedge[5] + az * wedge[6]
    u = ax * wedge[7] + ay * wedge[8] + az * wedge[9]
    near, far = f - half_f, f + half_f
    down = wedge[10] + min(near * wedge[12], far * wedge[12], near * wedge[13], far * wedge[13])
    up = wedge[11] + max(near * wedge[12], far * wedge[12], near * wedge[13], far * wedge[13])
    return ((down > u + half_u) | (up < u - half_u)) & (wedge[0] > 0)       # NaN, from an endless box: not outside


@stage
def reach(lanes):
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
def apart(box, cx, cy, cz, half_x, half_y, half_z):
    """Whether a box has nothing in common with another: its centre and half-widths."""
    return ((cx + half_x < box[0]) | (cx - half_x > box[3]) | (cy + half_y < box[1]) | (cy - half_y > box[4])
            | (cz + half_z < box[2]) | (cz - half_z > box[5]))


@stage
def one_side(box, cx, cy, cz, ux, uy, uz):
    """Whether a box lies wholly on one side of a plane: a point of the plane and its unit normal."""
    mx, my, mz = (box[0] + box[3]) / 2 - cx, (box[1] + box[4]) / 2 - cy, (box[2] + box[5]) / 2 - cz
    half = (abs(ux) * (box[3] - box[0]) + abs(uy) * (box[4] - box[1]) + abs(uz) * (box[5] - box[2])) / 2
    return abs(mx * ux + my * uy + mz * uz) > half
