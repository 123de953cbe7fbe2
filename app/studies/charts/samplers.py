"""Samplers for comparison with the default net.

All take the key (pixel, sample, dimension, seed) of the default sampler and fill the same rows. Sources: Roberts 2018
(additive recurrence of the generalised golden ratio); Cools, Kuo and Nuyens 2006 (generating vector of the lattice
sequence); Cranley and Patterson 1976 (a random shift for each pixel).
"""

import numpy as np
from numba import uint32

from lensbench.imaging.film import Film
from lensbench.kernels.block import PIXEL, SAMPLE, SEED, TIME, U0, U1, V0, V1, B, Step, X, Y, rows, stage
from lensbench.kernels.cache import njit
from lensbench.kernels.sampling import mix, sampling_steps, sobol
from lensbench.kernels.tile_order import add_corners

_u = np.uint32
DEFAULT, WHITE = "one scrambled net, blue-noise keys (the program's)", "white noise"
_ROWS = np.array([U0, U1, X, Y, V0, V1, TIME])
USED = len(_ROWS)
_ROOT = 1.1127756842787055      # x⁸ = x + 1
_STEPS = np.array([round(2.0**32 * _ROOT**-(d + 1)) % 2**32 for d in range(USED)], np.uint32)
_LATTICE = np.array([1, 182667, 469891, 498753, 110745, 446247, 250185], np.uint32)


@njit(inline="always")
def _seeded(pixel, seed, d):
    """Random number of the pixel for dimension d."""
    return mix(uint32(mix(uint32(pixel + _u(1))) + uint32(seed * _u(0x9E3779B9)) + uint32(_u(d) * _u(0x85EBCA6B))))


@njit(inline="always")
def _shift(lanes, key, d, step):
    """Set dimension d to the step plus a random shift of the pixel, modulo 1."""
    real = lanes.dtype.type
    out = rows(lanes)[_ROWS[d]]
    first, seed, unit = key[PIXEL], key[SEED], real(1 / 16777216)
    for i in range(B):
        number = uint32(_seeded(first + uint32(i), seed, d) + step)
        out[i] = real(np.int32(number >> _u(8))) * unit


@stage
def recurrence(lanes, p, ints, key):
    """Sample k lies k golden steps from a random start of the pixel."""
    for d in range(USED):
        _shift(lanes, key, d, uint32(key[SAMPLE] * _STEPS[d]))


@stage
def lattice(lanes, p, ints, key):
    """Sample k is a point of a rank-1 lattice in van der Corput's order, shifted for each pixel."""
    turned = uint32(0)
    for b in range(32):                 # van der Corput's order
        turned = uint32(turned | uint32((key[SAMPLE] >> _u(b)) & _u(1)) << _u(31 - b))
    for d in range(USED):
        _shift(lanes, key, d, uint32(turned * _LATTICE[d]))


@stage
def scrambled(lanes, p, ints, key):
    """Points of Sobol's sequence, Owen-scrambled for each pixel."""
    real = lanes.dtype.type
    unit = real(1 / 16777216)
    for d in range(USED):
        out = rows(lanes)[_ROWS[d]]
        for i in range(B):
            own = _seeded(key[PIXEL] + uint32(i), key[SEED], 0)
            out[i] = real(np.int32(sobol(key[SAMPLE], d, own) >> _u(8))) * unit


@stage
def white_noise(lanes, p, ints, key):
    """White noise: independent random numbers for all rows of the default samplers. p: width, height (pixels)."""
    real = lanes.dtype.type
    row = rows(lanes)
    u0, u1, x, y, v0, v1, time = row[U0], row[U1], row[X], row[Y], row[V0], row[V1], row[TIME]
    start = mix(uint32(key[SEED] * _u(0x9E3779B9) + key[SAMPLE]))
    unit = real(1 / 16777216)
    step = _u(0x9E3779B9)
    for i in range(B):
        a = mix(uint32(mix(uint32(key[PIXEL] + uint32(i))) + start))
        b = mix(uint32(a + step))
        c = mix(uint32(b + step))
        d = mix(uint32(c + step))
        u0[i] = real(np.int32(a >> _u(8))) * unit
        u1[i] = real(np.int32(b >> _u(8))) * unit
        x[i] = real(np.int32(c >> _u(8))) * unit
        y[i] = real(np.int32(d >> _u(8))) * unit
    for i in range(B):
        e = mix(uint32(mix(uint32(mix(uint32(key[PIXEL] + uint32(i))) + start)) ^ _u(0x68E31DA4)))
        f = mix(uint32(e + step))
        v0[i] = real(np.int32(e >> _u(8))) * unit
        v1[i] = real(np.int32(f >> _u(8))) * unit
        time[i] = real(np.int32(mix(uint32(f + step)) >> _u(8))) * unit
    add_corners(lanes, p, ints, key)


def samplers(film: Film, timed: bool = False) -> dict[str, list[Step]]:
    """Steps of every sampler by its name, the default first. timed: the scene or camera moves."""
    w, h = size = film.pixels_x, film.pixels_y
    corners = Step(add_corners, size)
    return {
        DEFAULT: sampling_steps(w, h, lit=True, timed=timed),
        "Sobol, scrambled for each pixel": [Step(scrambled), corners],
        "rank-1 lattice, shifted": [Step(lattice), corners],
        "additive recurrence, shifted": [Step(recurrence), corners],
        WHITE: [Step(white_noise, size)],
    }
