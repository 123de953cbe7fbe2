"""A sky shown by an equirectangular picture, the farthest surface; see `ImageSky`.

A direction d has the place u = ½ + atan2(x, −z) / 2π from the left and v = atan2(√(x² + z²), y) / π from the top, both
in the frame of the picture.
"""

import math

import numpy as np

from lensbench.core.kernels.arrays import address, borrowed
from lensbench.core.kernels.block import (
    A0, A1, A2, BLUE, DEPTH, EMITS, FINISH, GREEN, NX, NY, NZ, RED, B, L, M, N, Step, offsets, pack, rows, stage
)
from lensbench.core.kernels.cache import njit
from lensbench.core.scenery.intersect.sky import FAR

# COSINE, SINE: of the turn. Integers: place and count of the texels, texels across and down
COSINE, SINE, BRIGHTNESS, IMAGE_SKY = offsets(1, 1, 1)
PLACE, COUNT, ACROSS, DOWN = range(4)
_ATAN = (0.99999933, -0.33329856, 0.19946536, -0.13908534, 0.09642004, -0.05590983, 0.02186123, -0.00405406)


def image_sky_step(sky, kernel=None) -> Step:
    """The stage `image_sky`, or another that reads its numbers, for an `ImageSky`."""
    values = sky.image.values
    return Step(kernel or image_sky, image_sky_parameters(sky),
                [address(values), values.size, sky.image.width, sky.image.height], kept=(values,))


def image_sky_parameters(sky) -> np.ndarray:
    """Turn and brightness of an `ImageSky`."""
    return pack(IMAGE_SKY, {COSINE: math.cos(sky.turn), SINE: math.sin(sky.turn), BRIGHTNESS: sky.brightness})


@njit(inline="always")
def half_turn(real, y, x):
    """atan2(y, x) / π for y ≥ 0, in [0, 1], to 1e-8 (Abramowitz and Stegun 4.4.49)."""
    a, b = abs(x), y
    small, big = (a, b) if a < b else (b, a)
    low = small / (big + real(1e-30))
    q = low * low
    total = real(_ATAN[7])
    for k in range(6, -1, -1):
        total = total * q + real(_ATAN[k])
    angle = low * total * real(1 / math.pi)
    angle = real(0.5) - angle if b > a else angle
    return real(1) - angle if x < real(0) else angle


@njit(inline="always")
def sky_place(real, x, y, z, cosine, sine):
    """Place u, v of a direction in the picture, both in [0, 1]."""
    a, c = cosine * x - sine * z, sine * x + cosine * z
    turn = half_turn(real, abs(a), -c) * real(0.5)
    return real(0.5) + (turn if a > real(0) else -turn), half_turn(real, math.sqrt(a * a + c * c), y)


@stage
def look_up_sky(lanes, p, ints, x, y, z, r, g, b):
    """Radiance r, g, b of the picture along x, y, z (rows), bilinear between texels.  p, ints: image_sky_step."""
    real = lanes.dtype.type
    texels = borrowed(ints[PLACE], ints[COUNT], np.float32)
    across, down = real(ints[ACROSS]), real(ints[DOWN])
    wide, tall, right = np.uint64(ints[ACROSS]), np.uint64(ints[DOWN]), np.uint64(3)
    one, two = np.uint64(1), np.uint64(2)
    cosine, sine, brightness = p[COSINE], p[SINE], p[BRIGHTNESS]
    for i in range(B):
        u, v = sky_place(real, x[i], y[i], z[i], cosine, sine)
        x_, y_ = u * across - real(0.5), v * down - real(0.5)
        x_ = x_ if x_ >= real(0) else x_ + across
        y_ = y_ if y_ > real(0) else real(0)
        y_ = y_ if y_ < down - real(1) else down - real(1)
        r[i], g[i] = x_, y_
    for i in range(B):
        x_, y_ = r[i], g[i]
        x_ = x_ if x_ == x_ else real(0)                # a lane without a direction
        y_ = y_ if y_ == y_ else real(0)
        column, line = np.uint64(np.uint32(x_)), np.uint64(np.uint32(y_))
        s, t = x_ - real(np.uint32(column)), y_ - real(np.uint32(line))
        column = column if column < wide else wide - one
        beside = column + one if column + one < wide else np.uint64(0)
        below = line + one if line + one < tall else line
        k, m = (line * wide + column) * right, (line * wide + beside) * right
        q, w = (below * wide + column) * right, (below * wide + beside) * right
        e, f, h, j = (real(1) - s) * (real(1) - t), s * (real(1) - t), (real(1) - s) * t, s * t
        r[i] = brightness * (e * real(texels[k]) + f * real(texels[m]) + h * real(texels[q]) + j * real(texels[w]))
        g[i] = brightness * (e * real(texels[k + one]) + f * real(texels[m + one]) + h * real(texels[q + one])
                             + j * real(texels[w + one]))
        b[i] = brightness * (e * real(texels[k + two]) + f * real(texels[m + two]) + h * real(texels[q + two])
                             + j * real(texels[w + two]))


@stage
def image_sky(lanes, p, ints, key):
    """Begin the intersection of rays: each sees the picture of the sky.  p, ints: image_sky_step."""
    real = lanes.dtype.type
    row = rows(lanes)
    depth, emits, finish = row[DEPTH], row[EMITS], row[FINISH]
    nx, ny, nz = row[NX], row[NY], row[NZ]
    red, green, blue, r, g, b = row[RED], row[GREEN], row[BLUE], row[A0], row[A1], row[A2]
    look_up_sky(lanes, p, ints, row[L], row[M], row[N], r, g, b)
    for i in range(B):
        depth[i], emits[i], finish[i] = real(FAR), real(1), real(0)
        nx[i], ny[i], nz[i] = real(0), real(0), real(0)
        red[i], green[i], blue[i] = r[i], g[i], b[i]
