"""Order of the pixels of a film: along strips, so that a block is a compact piece.

A film is cut into bands of BAND_LINES lines, one below the other, and a band into upright strips of at most STRIP_WIDTH
pixels. The first strip runs down line by line, each line from left to right, the second up, and so on: successive
pixels are neighbours on the film, also where one strip ends and the next begins. So the rays of a block meet few
objects, and few blocks meet mirrors or glass. A band is whole blocks, as many as the film has columns, so that a
picture can be finished band by band. Every pixel occurs once; after the last one the order goes on beyond the right
edge of the film.
"""

import numpy as np

from lensbench.core.kernels.block import PIXEL, B, X, Y, rows, stage
from lensbench.core.kernels.cache import njit

STRIP_WIDTH = 32                # pixels: two registers of float32; 16 lines of a strip are a block
BAND_LINES = B                  # a power of two; the last band of a film has the rest of the lines
WIDTH, HEIGHT = 0, 1            # parameters of stages that use this order: pixels across and down


def strip_count(w: int) -> int:
    """Number of strips of a film w pixels across; their widths differ by at most one."""
    return -(-w // STRIP_WIDTH)


@njit(inline="always")
def pixel_at(k, w, h):
    """(strip, its first column, its last column + 1, column, line) of pixel k in the order; all int64."""
    top = k // (w * BAND_LINES) * BAND_LINES
    k, h = k - w * top, min(BAND_LINES, h - top)
    n = (w + STRIP_WIDTH - 1) // STRIP_WIDTH
    strip = ((k // h + 1) * n - 1) // w
    left, end = strip * w // n, (strip + 1) * w // n
    rest, wide = k - left * h, end - left
    line = rest // wide
    return strip, left, end, left + rest - line * wide, top + (line if strip % 2 == 0 else h - 1 - line)


@njit(inline="always")
def next_line(strip, left, end, line, w, h):
    """(strip, its first column, its last column + 1, line) of the next line of the block in the order."""
    after = line + 1 - 2 * (strip & 1)
    if (after ^ line) & -BAND_LINES != 0 or after == h:
        return strip + 1, end, (strip + 2) * w // ((w + STRIP_WIDTH - 1) // STRIP_WIDTH), line
    return strip, left, end, after


@stage
def add_corners(lanes, p, ints, key):
    """Raster X, Y: the corner of each lane's pixel added to X, Y within the pixel. p: WIDTH, HEIGHT."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y = row[X], row[Y]
    w, h = np.int64(p[WIDTH]), np.int64(p[HEIGHT])
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


def raster_image(sums: np.ndarray, w: int, h: int, scale: float | np.ndarray = 1.0) -> np.ndarray:
    """The picture (h, w, c) of c sums a pixel, stored by blocks in this order as (n, c B); each times `scale`.

    scale: a number, or an array (n,) with one for each block. The sums of some successive bands with the lines of these
    bands for h give this part of the film's picture.
    """
    picture = np.empty((h, w, sums.shape[1] // B), sums.dtype)
    scales = np.empty(len(sums), sums.dtype)
    scales[:] = scale
    for top in range(0, h, BAND_LINES):
        _unroll(sums[top * w // B:], scales[top * w // B:], picture[top:top + BAND_LINES])
    return picture


@njit(nogil=True, cache=True, error_model="numpy")
def _unroll(sums, scales, picture):
    """Write the picture of one band."""
    h, w, colours = picture.shape
    strip, left, end, _, line = pixel_at(0, w, h)
    k, column = 0, left
    while k < w * h:
        block, i = k // B, k % B
        run = min(B - i, end - column)
        for colour in range(colours):
            for q in range(run):
                picture[line, column + q, colour] = sums[block, colour * B + i + q] * scales[block]
        k, column = k + run, column + run
        if column == end:
            strip, left, end, line = next_line(strip, left, end, line, w, h)
            column = left
