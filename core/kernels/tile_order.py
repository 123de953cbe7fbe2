"""The order in which the pixels of a film are worked on: along strips, so that a block is a compact piece.

A film is cut into upright strips of at most WIDE pixels. The first is walked down line by line, each line from left to
right, the next one up, and so on: what follows each other lies close together, also where one strip ends and the next
begins. So the rays of a block meet few things, and few blocks meet mirrors or glass. Every pixel is there once, without
gaps; past the last one the walk goes on beyond the right edge of the film.
"""

import numpy as np
from numba import njit

from lensbench.kernels.block import PIXEL, B, X, Y, rows, stage

STRIP_WIDTH = 32               # pixels: two registers of float32, and 16 lines of them are a block


def strip_count(w: int) -> int:
    """Of a film w pixels across; they differ in width by at most one."""
    return -(-w // STRIP_WIDTH)


@njit(inline="always")
def pixel_at(k, w, h):
    """Where pixel k of the order lies: strip, its first column and the one past its last, column, line; all int64."""
    n = (w + STRIP_WIDTH - 1) // STRIP_WIDTH
    strip = ((k // h + 1) * n - 1) // w
    left, end = strip * w // n, (strip + 1) * w // n
    rest, wide = k - left * h, end - left
    line = rest // wide
    return strip, left, end, left + rest - line * wide, line if strip % 2 == 0 else h - 1 - line


@njit(inline="always")
def next_line(strip, left, end, line, w, h):
    """The strip with its edges, and the line, after a line."""
    after = line + 1 - 2 * (strip & 1)
    if after < 0 or after == h:
        return strip + 1, end, (strip + 2) * w // ((w + STRIP_WIDTH - 1) // STRIP_WIDTH), line
    return strip, left, end, after


@stage
def add_corners(lanes, p, key):
    """To X, Y, places in the pixel, the corner of each lane's pixel: raster X, Y.  p: pixels across and down."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y = row[X], row[Y]
    w, h = np.int64(p[0]), np.int64(p[1])
    strip, left, end, column, line = pixel_at(np.int64(key[PIXEL]), w, h)
    i = np.uint64(0)
    while i < np.uint64(B):
        run = min(np.uint64(B) - i, np.uint64(end - column))
        x0, y0 = real(np.int32(column)), real(np.int32(line))
        for q in range(run):
            x[i + q] += x0 + real(np.int32(q))
            y[i + q] += y0
        i += run
        strip, left, end, line = next_line(strip, left, end, line, w, h)
        column = left


def raster_image(sums: np.ndarray, w: int, h: int, scale: float = 1.0) -> np.ndarray:
    """Several sums of every pixel by blocks, (n, c B) in this order, as a picture (h, w, c), each times `scale`."""
    picture = np.empty((h, w, sums.shape[1] // B), sums.dtype)
    _unroll(sums, sums.dtype.type(scale), picture)
    return picture


@njit(nogil=True, cache=True, error_model="numpy")
def _unroll(sums, scale, picture):
    h, w, colours = picture.shape
    strip, left, end, _, line = pixel_at(0, w, h)
    k, column = 0, left
    while k < w * h:
        block, i = k // B, k % B
        run = min(B - i, end - column)
        for colour in range(colours):
            for q in range(run):
                picture[line, column + q, colour] = sums[block, colour * B + i + q] * scale
        k, column = k + run, column + run
        if column == end:
            strip, left, end, line = next_line(strip, left, end, line, w, h)
            column = left
