"""The kernel of novel views: what a ray sees by an array of pinholes; see `lumigraph`.

A ray is named by (u, v), where it crosses the plane of the pinholes, and (s, t), where it crosses the plane before
them; mm. Nearness is the distance of the plane (s, t) over the depth of a thing. Each texel of a pinhole holds four
half floats: three colours and 1 / depth.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from lensbench.core.kernels.arrays import EXPONENT_SCALE, texel_sum, unscaled
from lensbench.core.kernels.cache import njit

STEPS_PER_PIXEL = 2.0   # along a ray, for each pixel by which its image moves
MOST_STEPS = 1024
HIDDEN = 0.5            # pixels of disagreement between neighbours, above which an object hides the surface from one
LEAST_COSINE = 1e-6     # between a ray and the normal of the plane (s, t)
LEAST_TAKEN = np.float32(0.3)       # weight of the texels that see the surface, below which a pinhole does not count
EDGE = 1e-6             # spacings by which a ray may pass beside the array

# Entries of `Pinholes.geometry`
(FIRST_X, FIRST_Y,      # position of the first pinhole, mm
 SPACING,               # between neighbours, mm
 PIXELS_S, PIXELS_T,    # per mm of the plane (s, t), across and down
 AXIS_S, AXIS_T,        # raster point where the axis meets that plane, pixels
 DISTANCE,              # of that plane, mm
 ) = range(8)


class Pinholes(NamedTuple):
    """An array of pinholes, for the kernels."""

    views: tuple[int, int]      # across and down
    pixels: tuple[int, int]     # of the picture of each, across and down
    geometry: np.ndarray        # (8,) FIRST_X … DISTANCE
    offsets: np.ndarray         # (n, 2) of each pixel grid, to the right and down, pixels

    @classmethod
    def of(cls, first: Any, spacing: float, raster: np.ndarray, distance: float, offsets: np.ndarray,
           pixels: tuple[int, int]) -> "Pinholes":
        """From raster (4,): mm per pixel of the plane (s, t), across and down, and where the axis meets it, pixels."""
        down, across = offsets.shape[:2]
        geometry = np.array([*first, spacing, *(1.0 / raster[:2]), *raster[2:], distance])
        return cls((across, down), pixels, geometry, offsets.reshape(-1, 2))


class Surface(NamedTuple):
    """Surface of the scene: a nearness for each pixel of some pinholes, or one distance for all."""

    known: np.ndarray           # nearness over `unit`, of pinhole after pinhole; empty: all at one distance
    stride: int                 # from one pixel to the next
    start: int                  # index of the first
    unit: float
    nearest: float              # nearness
    farthest: float             # nearness; also where none is known


@njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract"})
def render_rows(lines, traced, side, pinholes, texels, by, surface, own, out, covered, first, last):
    """Set the rows first … last − 1 of a picture (h, w, 3) and of the pixels that were recorded (h, w).

    lines: (6, 3) origin and direction of the rays in the array's frame, linear in the raster's x, y and 1, unless
    `traced` (n, 6) holds the rays. side: rays per pixel, across and down. texels: half floats, pinhole after pinhole.
    by: the pinholes whose pixels the surface describes; own: whether these are the array's own, which may not see the
    surface.
    """
    # All arrays are unpacked here: taken from the tuples in the loops, they would be reference-counted for every ray
    views, pixels, geometry, offsets = pinholes
    by_views, by_pixels, by_geometry, by_offsets = by
    known, stride, start, unit, nearest, farthest = surface
    distance, w, n = geometry[DISTANCE], out.shape[1], 1.0 / side
    hidden = HIDDEN / (geometry[PIXELS_S] * geometry[SPACING])
    ray, blended = np.zeros(6), np.zeros(3, np.float32)
    for y in range(first, last):
        for x in range(w):
            red, green, blue, whole = np.float32(0), np.float32(0), np.float32(0), True
            for k in range(side * side):
                # Find the ray
                if len(traced):
                    for m in range(6):
                        ray[m] = traced[(y * side + k // side) * w * side + x * side + k % side, m]
                else:
                    for m in range(6):
                        ray[m] = (lines[m, 0] * (x + (k % side + 0.5) * n) + lines[m, 1] * (y + (k // side + 0.5) * n)
                                  + lines[m, 2])
                size = math.sqrt(ray[3] * ray[3] + ray[4] * ray[4] + ray[5] * ray[5])
                whole = -ray[5] > LEAST_COSINE * size           # false for NaN
                if whole:
                    # Find where it crosses both planes, and where it meets the surface
                    right, up = ray[3] / -ray[5], ray[4] / -ray[5]
                    u, v = ray[0] + ray[2] * right, ray[1] + ray[2] * up
                    s, t = u + distance * right, v + distance * up
                    q = farthest
                    if known.size:
                        behind = -distance / ray[2] if ray[2] < 0.0 else math.inf
                        q = _meet_surface(u, v, s, t, min(nearest, behind), farthest, hidden, by_views, by_pixels,
                                          by_geometry, by_offsets, known, stride, start, unit)

                    # Blend the colours that the pinholes around it see there
                    whole = _blend(u, v, s, t, q, views, pixels, geometry, offsets, texels,
                                   hidden / unit if own else math.inf, unit, blended)
                if not whole:
                    break
                red, green, blue = red + blended[0], green + blended[1], blue + blended[2]
            mean = np.float32(n * n * EXPONENT_SCALE if whole else 0.0)
            covered[y, x] = whole
            out[y, x, 0], out[y, x, 1], out[y, x, 2] = mean * red, mean * green, mean * blue


@njit(inline="always")
def _meet_surface(u, v, s, t, high, low, jump, views, pixels, geometry, offsets, known, stride, start, unit):
    """Nearness where a ray meets the surface seen by the pinhole nearest to the ray; without a hit, the last one seen.

    March from near (high) to far (low), in steps that move the image by 1 / STEPS_PER_PIXEL of a pixel: a hit is where
    the ray gets behind the surface, but not where the surface jumps before it at once.
    """
    w, h = pixels

    # The image of the ray in that pinhole: a point for each nearness, on a line
    i = min(max(int(math.floor((u - geometry[FIRST_X]) / geometry[SPACING] + 0.5)), 0), views[0] - 1)
    j = min(max(int(math.floor((v - geometry[FIRST_Y]) / geometry[SPACING] + 0.5)), 0), views[1] - 1)
    number = j * views[0] + i
    right = (u - (geometry[FIRST_X] + i * geometry[SPACING])) * geometry[PIXELS_S]
    up = (v - (geometry[FIRST_Y] + j * geometry[SPACING])) * geometry[PIXELS_T]
    x0 = s * geometry[PIXELS_S] + geometry[AXIS_S] - offsets[number, 0] - right
    y0 = geometry[AXIS_T] - t * geometry[PIXELS_T] - offsets[number, 1] + up

    # March along it
    high *= 1.001
    steps = int(min(math.ceil(max(abs(right), abs(up)) * (high - low) * STEPS_PER_PIXEL), MOST_STEPS)) + 2
    step = (low * 0.999 - high) / steps
    before, last = math.nan, math.nan
    for m in range(steps + 1):
        q = high + m * step
        x, y, surface = int(x0 + right * q + w) - w, int(y0 - up * q + h) - h, math.nan
        if 0 <= x < w and 0 <= y < h:
            surface = unscaled(known[((number * h + y) * w + x) * stride + start]) * unit
            last = surface
            if q <= surface and (surface <= q - 2.0 * step or (before > 0.0 and surface - (q - step) <= jump)):
                break
        before = q - surface
    return last if last == last else 1.0


@njit(inline="always")
def _catmull_rom(f):
    """Weights of the pixels at −1, 0, 1 and 2 at f in [0, 1), by Catmull and Rom's cubics."""
    half, one = np.float32(0.5), np.float32(1)
    g = one - f
    return (-half * f * g * g, one + f * f * (np.float32(1.5) * f - np.float32(2.5)),
            one + g * g * (np.float32(1.5) * g - np.float32(2.5)), -half * f * f * g)


@njit(inline="always")
def _blend(u, v, s, t, q, views, pixels, geometry, offsets, texels, hidden, unit, blended):
    """Set `blended` to the colour over EXPONENT_SCALE that the four pinholes about a ray see; False outside the array.

    Linear between pinholes, cubic between pixels. First only the pinholes and pixels count that see the surface, within
    hidden × unit of nearness q; where none does, all.
    """
    w, h = pixels
    a, b = (u - geometry[FIRST_X]) / geometry[SPACING], (v - geometry[FIRST_Y]) / geometry[SPACING]
    if not (-EDGE <= a <= views[0] - 1 + EDGE and -EDGE <= b <= views[1] - 1 + EDGE):
        return False
    left = min(max(int(math.floor(a)), 0), max(views[0] - 2, 0))
    low = min(max(int(math.floor(b)), 0), max(views[1] - 2, 0))
    within, depth = np.float32(hidden), np.float32(q / unit)
    for _ in range(2):
        total = np.float32(0)
        blended[:] = np.float32(0)
        for corner in range(4):
            i, j = left + corner % 2, low + corner // 2
            weight = np.float32((1.0 - abs(a - i)) * (1.0 - abs(b - j)))
            if i >= views[0] or j >= views[1] or weight <= np.float32(1e-6):
                continue
            number = j * views[0] + i

            # The surface point in the pinhole's picture, by similar triangles
            s_q, t_q = s + (a - i) * geometry[SPACING] * (q - 1.0), t + (b - j) * geometry[SPACING] * (q - 1.0)
            x = s_q * geometry[PIXELS_S] + geometry[AXIS_S] - offsets[number, 0] - 0.5
            y = geometry[AXIS_T] - t_q * geometry[PIXELS_T] - offsets[number, 1] - 0.5
            if not (-0.5 <= x <= w - 0.5 and -0.5 <= y <= h - 0.5):
                continue
            line = number * h
            texel = (line + min(int(y + 0.5), h - 1)) * w + min(int(x + 0.5), w - 1)
            if unscaled(texels[4 * texel + 3]) > depth + within:
                continue

            # Interpolate between its texels
            x0, y0 = int(x + 1.0) - 2, int(y + 1.0) - 2
            across, down = _catmull_rom(np.float32(x - x0 - 1)), _catmull_rom(np.float32(y - y0 - 1))
            taken, off = np.float32(1), np.float32(math.inf)
            if 0 <= x0 <= w - 4:
                lines = (4 * ((line + min(max(y0, 0), h - 1)) * w + x0),
                         4 * ((line + min(max(y0 + 1, 0), h - 1)) * w + x0),
                         4 * ((line + min(max(y0 + 2, 0), h - 1)) * w + x0),
                         4 * ((line + min(max(y0 + 3, 0), h - 1)) * w + x0))
                red, green, blue, off = texel_sum(texels, lines, down, across, depth)
            if not off <= within or off == np.float32(math.inf):
                red, green, blue, taken = _sum_near_texels(texels, line, w, h, x0, y0, down, across, depth, within)
                if taken < LEAST_TAKEN:
                    continue
            share = weight / taken
            blended[0] += share * red
            blended[1] += share * green
            blended[2] += share * blue
            total += weight
        if total > np.float32(0):
            for c in range(3):
                blended[c] /= total
            return True
        within = np.float32(math.inf)
    return False


@njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract"})
def _sum_near_texels(texels, line, w, h, x0, y0, down, across, depth, within):
    """Σ down · across · texel over EXPONENT_SCALE of 4 × 4 texels from x0, y0 near the surface, and their weight.

    line: index of the picture's first row. The last texel repeats beyond the picture's edge.
    """
    red, green, blue, taken = np.float32(0), np.float32(0), np.float32(0), np.float32(0)
    for m in range(4):
        begin = (line + min(max(y0 + m, 0), h - 1)) * w
        for n in range(4):
            k = 4 * (begin + min(max(x0 + n, 0), w - 1))
            if not abs(unscaled(texels[k + 3]) - depth) > within:
                count = down[m] * across[n]
                red += count * unscaled(texels[k])
                green += count * unscaled(texels[k + 1])
                blue += count * unscaled(texels[k + 2])
                taken += count
    return red, green, blue, taken
