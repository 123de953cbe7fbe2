"""Cells of a ghost on the film: the light between neighbouring rays of a grid, spread over the pixels that it covers.

Four rays bound a cell, which lands on the film as two triangles. A cell has the mean light of its corners; a corner
that ends on the way has none. The light of a triangle is spread evenly over the pixels whose middles it covers, or
falls on one pixel where it is smaller than half a pixel. Raster points in pixels.

Ghosts cover each other many times, so that light is kept by its edges: what begins at a pixel of a line, and ends
before another one. The sum along the line is then the light of each pixel.
"""

import math

import numpy as np

from lensbench.kernels.cache import njit

SMALL = 0.5             # pixels: area of a triangle whose light falls on one pixel
LARGEST = 1e6           # pixels: a corner farther out belongs to a ray that grazes, and the cell is left out


@njit(nogil=True, cache=True, error_model="numpy")
def add_cells(edges, found, cells, across, top, bottom, gain):
    """Add the light of a grid of (cells + 1)² rays, `found` as of `GhostTracer.trace`, to the rows top … bottom − 1.

    edges: (rows, across + 1, 3) float64, what the light of a pixel has more than that of the pixel before. gain (3,):
    factor on red, green and blue.
    """
    wide = cells + 1
    light = np.zeros(3, np.float32)
    for j in range(cells):
        for i in range(cells):
            a = j * wide + i
            b, c, d = a + 1, a + wide, a + wide + 1
            total = found[2, a] + found[2, b] + found[2, c] + found[2, d]
            if not total > 0.0:
                continue
            y0, y1, y2, y3 = found[1, a], found[1, b], found[1, c], found[1, d]
            known = (abs(y0) < LARGEST) & (abs(y1) < LARGEST) & (abs(y2) < LARGEST) & (abs(y3) < LARGEST)
            if known & ((max(max(y0, y1), max(y2, y3)) < top) | (min(min(y0, y1), min(y2, y3)) >= bottom)):
                continue
            for k in range(3):
                r = 2 + k
                light[k] = np.float32(0.125) * gain[k] * (found[r, a] + found[r, b] + found[r, c] + found[r, d])
            if known & (abs(found[0, a] + found[0, b] + found[0, c] + found[0, d]) < 4.0 * LARGEST):
                _add_triangle(edges, found, a, b, d, light, across, top, bottom)
                _add_triangle(edges, found, a, d, c, light, across, top, bottom)
            else:
                _add_corners(edges, found, a, b, c, d, gain, across, top, bottom)


@njit(nogil=True, cache=True, error_model="numpy")
def _add_corners(edges, found, a, b, c, d, gain, across, top, bottom):
    """The light of a cell some of whose rays have no place on the film: each corner's on its own pixel."""
    for at in (a, b, c, d):
        x, y = found[0, at], found[1, at]
        if (found[2, at] > 0.0) & (x >= 0.0) & (x < across) & (y >= top) & (y < bottom):
            for k in range(3):
                _add_run(edges[int(y) - top], int(x), int(x) + 1, k, np.float32(0.25) * gain[k] * found[2 + k, at])


@njit(nogil=True, cache=True, error_model="numpy")
def _add_triangle(edges, found, a, b, c, light, across, top, bottom):
    x0, y0, x1, y1, x2, y2 = found[0, a], found[1, a], found[0, b], found[1, b], found[0, c], found[1, c]
    area = abs((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)) * 0.5
    if area < SMALL:
        x, y = (x0 + x1 + x2) / 3.0, (y0 + y1 + y2) / 3.0
        if (x >= 0.0) & (x < across) & (y >= top) & (y < bottom):
            for k in range(3):
                _add_run(edges[int(y) - top], int(x), int(x) + 1, k, light[k])
        return
    left, right = min(x0, min(x1, x2)), max(x0, max(x1, x2))
    if (right < 0.0) | (left >= across):
        return

    # Order the corners downwards, and loop over the middles of the rows
    if y1 < y0:
        x0, y0, x1, y1 = x1, y1, x0, y0
    if y2 < y0:
        x0, y0, x2, y2 = x2, y2, x0, y0
    if y2 < y1:
        x1, y1, x2, y2 = x2, y2, x1, y1
    red, green, blue = light[0] / area, light[1] / area, light[2] / area
    long = (x2 - x0) / (y2 - y0) if y2 > y0 else 0.0
    upper = (x1 - x0) / (y1 - y0) if y1 > y0 else 0.0
    lower = (x2 - x1) / (y2 - y1) if y2 > y1 else 0.0
    first = max(int(math.ceil(max(y0, -1.0) - 0.5)), top)
    last = min(int(math.ceil(min(y2, 1.0 + bottom) - 0.5)), bottom)
    for line in range(first, last):
        y = line + 0.5
        one = x0 + (y - y0) * long
        other = x0 + (y - y0) * upper if y < y1 else x1 + (y - y1) * lower
        begin = max(int(math.ceil(max(min(one, other), -1.0) - 0.5)), 0)
        end = min(int(math.ceil(min(max(one, other), across + 1.0) - 0.5)), across)
        if begin < end:
            row = edges[line - top]
            _add_run(row, begin, end, 0, red)
            _add_run(row, begin, end, 1, green)
            _add_run(row, begin, end, 2, blue)


@njit(nogil=True, cache=True, error_model="numpy", inline="always")
def _add_run(row, begin, end, k, light):
    """Light of a channel from pixel `begin` on, before pixel `end`."""
    row[begin, k] += light
    row[end, k] -= light


@njit(nogil=True, cache=True, error_model="numpy")
def add_lines(sums, edges, first):
    """Add the light that `edges` hold, (rows, across + 1, 3), to sums (pixels, 3) from the pixel `first` on."""
    p = first
    for j in range(edges.shape[0]):
        red, green, blue = 0.0, 0.0, 0.0
        for i in range(edges.shape[1] - 1):
            red, green, blue = red + edges[j, i, 0], green + edges[j, i, 1], blue + edges[j, i, 2]
            # Rounding may leave a little less than nothing behind the last edge
            sums[p, 0] += max(red, 0.0)
            sums[p, 1] += max(green, 0.0)
            sums[p, 2] += max(blue, 0.0)
            p += 1
