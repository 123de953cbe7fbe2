"""Bounds of a whole block of rays, so that one comparison for an object replaces B.

A block is a compact piece of the picture, so its rays fill a thin pyramid, the *beam*, and its shadow rays a small
box. Minima and maxima are taken of integers: their order does not matter, and they run in full vector registers.
"""

import math

import numpy as np

from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, BEAM, BLUE, GREEN, RED, B, L, M, N, X, Y, Z, offsets, rows, stage, vector
)
from lensbench.core.kernels.cache import njit

FINE = 1048576.0        # steps of a slope
STEPS = 8.0             # steps of a millimetre
MOST = 1 << 30

# Numbers of a beam, in the row BEAM. KNOWN: 1, or 0 where the rays diverge too far; ORIGIN: a point (mm), with unit
# axes FORWARD, UPWARD, RIGHTWARD. In that frame, over all rays: REAR, where the rearmost begins (mm); VERTICAL and
# HORIZONTAL, each an interval of places at ORIGIN and one of slopes
KNOWN, ORIGIN, FORWARD, UPWARD, RIGHTWARD, REAR, VERTICAL, HORIZONTAL, _ = offsets(1, 3, 3, 3, 3, 1, 4, 4)
LEAST, GREATEST, LEAST_SLOPE, GREATEST_SLOPE = range(4)


@stage
def beam(lanes, p, ints, key):
    """Bound the rays of the block by two pairs of planes: the row BEAM, read by `beam_misses`."""
    row = rows(lanes)
    bound_beam(row[X], row[Y], row[Z], row[L], row[M], row[N], row[BEAM])


@stage
def shadow_beam(lanes):
    """Bound the shadow rays of the block as `beam` does its rays; unlit lanes lose their direction, A3 A4 A5."""
    real = lanes.dtype.type
    row = rows(lanes)
    wx, wy, wz, red, green, blue = row[A3], row[A4], row[A5], row[RED], row[GREEN], row[BLUE]
    for i in range(B):
        lit = red[i] + green[i] + blue[i] > real(0)
        wx[i], wy[i], wz[i] = wx[i] if lit else real(0), wy[i] if lit else real(0), wz[i] if lit else real(0)
    bound_beam(row[A0], row[A1], row[A2], wx, wy, wz, row[BEAM])


@stage
def bound_beam(x, y, z, dx, dy, dz, out):
    """Bound rays from x, y, z along dx, dy, dz; a lane without a direction does not count."""
    real = x.dtype.type

    # Take the frame of a ray in the middle, or of the first one that has a direction
    k = B // 2
    if not dx[k] * dx[k] + dy[k] * dy[k] + dz[k] * dz[k] > real(0.5):
        k = 0
        while k < B - 1 and not dx[k] * dx[k] + dy[k] * dy[k] + dz[k] * dz[k] > real(0.5):
            k += 1
    ox, oy, oz, fx, fy, fz = x[k], y[k], z[k], dx[k], dy[k], dz[k]
    level = math.sqrt(fx * fx + fz * fz)
    per = real(1) / level if level > real(1e-3) else real(0)
    rx, rz = (-fz * per, fx * per) if level > real(1e-3) else (real(1), real(0))
    ux, uy, uz = -fy * rz, rz * fx - rx * fz, rx * fy

    # Bound the components of origins and directions; a lane without a direction counts as the first one
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

    # Write the beam; a number out of the integers' range was converted to the least of all
    known = (min(rear, low, left, flat, west) > least) & (max(front, high, right, steep, east) < most)
    out[KNOWN] = real(1) if known & (slow > np.int32(0.1 * FINE)) else real(0)
    out[ORIGIN], out[ORIGIN + 1], out[ORIGIN + 2] = ox, oy, oz
    out[FORWARD], out[FORWARD + 1], out[FORWARD + 2] = fx, fy, fz
    out[UPWARD], out[UPWARD + 1], out[UPWARD + 2] = ux, uy, uz
    out[RIGHTWARD], out[RIGHTWARD + 1], out[RIGHTWARD + 2] = rx, real(0), rz
    begin, end = _widened(real, rear, front, STEPS)
    out[REAR] = begin
    _interval(real, out[VERTICAL:], begin, end, fine / real(slow), low, high, flat, steep)
    _interval(real, out[HORIZONTAL:], begin, end, fine / real(slow), left, right, west, east)


@njit(inline="always")
def _widened(real, low, high, steps):
    """Least and greatest number, widened by what rounding to integers removed."""
    return (real(low) - real(2)) * real(1 / steps), (real(high) + real(2)) * real(1 / steps)


@njit(inline="always")
def _interval(real, out, begin, end, per, low, high, flat, steep):
    """Places projected to ORIGIN from between begin and end, and slopes of directions 1 … 1 / per forward."""
    low, high = _widened(real, low, high, STEPS)
    flat, steep = _widened(real, flat, steep, FINE)
    flat, steep = min(flat, flat * per), max(steep, steep * per)
    a, b, c, d = begin * flat, begin * steep, end * flat, end * steep
    out[LEAST], out[GREATEST] = low - max(a, b, c, d), high - min(a, b, c, d)
    out[LEAST_SLOPE], out[GREATEST_SLOPE] = flat, steep


@stage
def beam_misses(bounds, cx, cy, cz, half_f, half_u, half_r):
    """Whether no ray of a `beam` (its row) meets a box: its centre, and half-widths forward, upward and rightward."""
    (ox, oy, oz), (fx, fy, fz), (ux, uy, uz) = vector(bounds, ORIGIN), vector(bounds, FORWARD), vector(bounds, UPWARD)
    ax, ay, az = cx - ox, cy - oy, cz - oz
    f = ax * fx + ay * fy + az * fz
    u = ax * ux + ay * uy + az * uz
    r = ax * bounds[RIGHTWARD] + az * bounds[RIGHTWARD + 2]
    near, far = f - half_f, f + half_f
    low, high = _between(bounds, VERTICAL, near, far)
    left, right = _between(bounds, HORIZONTAL, near, far)
    missed = ((low > u + half_u) | (high < u - half_u) | (left > r + half_r) | (right < r - half_r)
              | (far < bounds[REAR]))
    return missed & (bounds[KNOWN] > 0)                               # NaN, from an endless box: not missed


@njit(inline="always")
def _between(bounds, k, near, far):
    """Least and greatest place of the rays, from near to far in front of ORIGIN."""
    least, greatest = bounds[k + LEAST_SLOPE], bounds[k + GREATEST_SLOPE]
    return (bounds[k + LEAST] + min(near * least, far * least, near * greatest, far * greatest),
            bounds[k + GREATEST] + max(near * least, far * least, near * greatest, far * greatest))


@njit(inline="always")
def widen(real, low, high, x, inside):
    """An interval of integers, widened to a number rounded towards 0 where it is `inside`."""
    n = np.int32(x if inside else real(0))
    return min(low, n if inside else np.int32(MOST)), max(high, n if inside else np.int32(-MOST))


@stage
def shadow_bounds(lanes):
    """Box around the shadow rays of the block: its least x, y, z and its greatest, in mm.

    Rays begin at the lit points A0 A1 A2 and end at the light, along A3 A4 A5 at the distance A6, at most 1 km.
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
        x0, x1 = widen(real, x0, x1, ax, lit)
        x0, x1 = widen(real, x0, x1, bx, lit)
        y0, y1 = widen(real, y0, y1, ay, lit)
        y0, y1 = widen(real, y0, y1, by, lit)
        z0, z1 = widen(real, z0, z1, az, lit)
        z0, z1 = widen(real, z0, z1, bz, lit)
    one = np.int32(2)
    return (real(np.int32(x0 - one)), real(np.int32(y0 - one)), real(np.int32(z0 - one)),
            real(np.int32(x1 + one)), real(np.int32(y1 + one)), real(np.int32(z1 + one)))


@stage
def lit_bounds(lanes):
    """Box around the lit points A0 A1 A2 of the block, as `shadow_bounds`."""
    real = lanes.dtype.type
    row = rows(lanes)
    hx, hy, hz, red, green, blue = row[A0], row[A1], row[A2], row[RED], row[GREEN], row[BLUE]
    most, least, one = np.int32(MOST), np.int32(-MOST), np.int32(2)
    x0, x1, y0, y1, z0, z1 = most, least, most, least, most, least
    for i in range(B):
        lit = red[i] + green[i] + blue[i] > real(0)
        x0, x1 = widen(real, x0, x1, hx[i], lit)
        y0, y1 = widen(real, y0, y1, hy[i], lit)
        z0, z1 = widen(real, z0, z1, hz[i], lit)
    return (real(np.int32(x0 - one)), real(np.int32(y0 - one)), real(np.int32(z0 - one)),
            real(np.int32(x1 + one)), real(np.int32(y1 + one)), real(np.int32(z1 + one)))


@stage
def boxes_disjoint(box, cx, cy, cz, half_x, half_y, half_z):
    """Whether a box is disjoint from another, given by its centre and half-widths."""
    return ((cx + half_x < box[0]) | (cx - half_x > box[3]) | (cy + half_y < box[1]) | (cy - half_y > box[4])
            | (cz + half_z < box[2]) | (cz - half_z > box[5]))


@stage
def plane_misses(box, cx, cy, cz, ux, uy, uz):
    """Whether a box lies entirely on one side of a plane, given by a point c and its unit normal u."""
    mx, my, mz = (box[0] + box[3]) / 2 - cx, (box[1] + box[4]) / 2 - cy, (box[2] + box[5]) / 2 - cz
    half = (abs(ux) * (box[3] - box[0]) + abs(uy) * (box[4] - box[1]) + abs(uz) * (box[5] - box[2])) / 2
    return abs(mx * ux + my * uy + mz * uz) > half
