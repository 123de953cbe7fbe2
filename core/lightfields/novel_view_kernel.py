"""What a ray sees by an array of pinholes: where it meets what they recorded, and what they saw there.

A ray is named by (u, v), where it comes through the plane of the pinholes, and (s, t), where it meets the plane before
them of which all see the same; both in mm. Nearness is the distance of that plane over the depth of a thing. The
texels of a pinhole are four numbers each: three colours and 1 / depth.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from lensbench.kernels.half_float import EXPONENT_SCALE, texel_sum, unscaled

PARTS = 2.0             # steps along a ray for each pixel by which its picture moves
MOST_STEPS = 1024
GHOST = 0.5             # pixels by which neighbours may disagree before one of them is said to be hidden
TOWARDS = 1e-6          # the least cosine of a ray with the way to the (s, t) plane
SEEN = np.float32(0.3)  # the least that counts, of the pixels about a place


class Pinholes(NamedTuple):
    """An array as kernels take it."""

    views: tuple[int, int]      # across and down
    pixels: tuple[int, int]     # of the picture of each, across and down
    place: np.ndarray           # (8,) where the first stands, and from one to the next, mm; of (s, t) the pixels for
                                # each mm, across and down, and those where the axis meets it; how far it is, mm
    offsets: np.ndarray         # (n, 2) by what part of a pixel each grid lies aside, to the right and down

    @classmethod
    def of(cls, first, spacing: float, raster, distance: float, offsets: np.ndarray, pixels) -> "Pinholes":
        """raster: mm a pixel of the plane (s, t) across and down, and the pixels where the axis meets it."""
        down, across = offsets.shape[:2]
        place = np.array([*first, spacing, *(1.0 / raster[:2]), *raster[2:], distance])
        return cls((across, down), pixels, place, offsets.reshape(-1, 2))


class Surface(NamedTuple):
    """Where things are taken to be: by each pixel of these pinholes, or all as far away."""

    known: np.ndarray           # nearness over `unit`, of pinhole after pinhole; empty: all as far away
    each: int                   # from one pixel to the next
    shift: int                  # of the first
    unit: float
    nearest: float              # nearness
    farthest: float             # nearness, also of what is not known


@njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract"})
def render_rows(lines, given, many, pinholes, texels, by, surface, own, out, covered, first, last):
    """Lines first … last − 1 of a picture (h, w, 3), and which of its pixels were recorded; many² rays a pixel.

    lines: (6, 3) origin and direction of the rays in the array's frame, linear in the raster's x, y and 1; or, where
    `given` (n, 6) is not empty, those. texels: half floats of pinhole after pinhole. by: the pinholes to which the
    surface's pixels belong; own: whether those are the array's own, so that of what is hidden from one it is not asked.
    """
    views, pixels, place, offsets = pinholes
    by_views, by_pixels, by_place, by_offsets = by
    known, each, shift, unit, nearest, farthest = surface
    distance, w, n = place[7], out.shape[1], 1.0 / many
    ghost = GHOST / (place[3] * place[2])
    ray, part = np.zeros(6), np.zeros(3, np.float32)
    for y in range(first, last):
        for x in range(w):
            red, green, blue, whole = np.float32(0), np.float32(0), np.float32(0), True
            for k in range(many * many):
                if len(given):
                    for m in range(6):
                        ray[m] = given[(y * many + k // many) * w * many + x * many + k % many, m]
                else:
                    for m in range(6):
                        ray[m] = (lines[m, 0] * (x + (k % many + 0.5) * n) + lines[m, 1] * (y + (k // many + 0.5) * n)
                                  + lines[m, 2])
                size = math.sqrt(ray[3] * ray[3] + ray[4] * ray[4] + ray[5] * ray[5])
                whole = -ray[5] > TOWARDS * size                # which NaN is not
                if whole:
                    right, up = ray[3] / -ray[5], ray[4] / -ray[5]
                    u, v = ray[0] + ray[2] * right, ray[1] + ray[2] * up
                    s, t = u + distance * right, v + distance * up
                    q = farthest
                    if known.size:
                        begins = -distance / ray[2] if ray[2] < 0.0 else math.inf
                        q = _met(u, v, s, t, min(nearest, begins), farthest, ghost, by_views, by_pixels, by_place,
                                 by_offsets, known, each, shift, unit)
                    whole = _blend(u, v, s, t, q, views, pixels, place, offsets, texels,
                                   ghost / unit if own else math.inf, unit, part)
                if not whole:
                    break
                red, green, blue = red + part[0], green + part[1], blue + part[2]
            mean = np.float32(n * n * EXPONENT_SCALE if whole else 0.0)
            covered[y, x] = whole
            out[y, x, 0], out[y, x, 1], out[y, x, 2] = mean * red, mean * green, mean * blue


@njit(inline="always")
def _met(u, v, s, t, high, low, jump, views, pixels, place, offsets, known, each, shift, unit):
    """Nearness where a ray meets what the pinhole nearest to it has seen; the last nearness where it never does.

    Along the ray from near (high) to far (low), as far as it moves by 1 / PARTS of a pixel in the pinhole's picture: it
    has met the surface where it comes to lie behind it, but not where the surface jumps before it all at once.
    """
    w, h = pixels
    i = min(max(int(math.floor((u - place[0]) / place[2] + 0.5)), 0), views[0] - 1)
    j = min(max(int(math.floor((v - place[1]) / place[2] + 0.5)), 0), views[1] - 1)
    number = j * views[0] + i
    right, up = (u - (place[0] + i * place[2])) * place[3], (v - (place[1] + j * place[2])) * place[4]
    x0 = s * place[3] + place[5] - offsets[number, 0] - right
    y0 = place[6] - t * place[4] - offsets[number, 1] + up
    high *= 1.001
    steps = int(min(math.ceil(max(abs(right), abs(up)) * (high - low) * PARTS), MOST_STEPS)) + 2
    step = (low * 0.999 - high) / steps
    before, found = math.nan, math.nan
    for m in range(steps + 1):
        q = high + m * step
        x, y, here = int(x0 + right * q + w) - w, int(y0 - up * q + h) - h, math.nan
        if 0 <= x < w and 0 <= y < h:
            here = unscaled(known[((number * h + y) * w + x) * each + shift]) * unit
            found = here
            if q <= here and (here <= q - 2.0 * step or (before > 0.0 and here - (q - step) <= jump)):
                break
        before = q - here
    return found if found == found else 1.0


@njit(inline="always")
def _cubic(f):
    """Catmull and Rom's: what the pixels at −1, 0, 1 and 2 count at f in [0, 1)."""
    half, one = np.float32(0.5), np.float32(1)
    g = one - f
    return (-half * f * g * g, one + f * f * (np.float32(1.5) * f - np.float32(2.5)),
            one + g * g * (np.float32(1.5) * g - np.float32(2.5)), -half * f * f * g)


@njit(inline="always")
def _blend(u, v, s, t, q, views, pixels, place, offsets, texels, ghost, unit, part):
    """Of the four pinholes about a ray those that see its surface, each by cubics between its pixels; whether any do.

    First those that do, by pixels that do, which lie no more than `ghost` times `unit` before or behind it; where none
    does, all. `part` becomes the colour over ZERO.
    """
    w, h = pixels
    a, b = (u - place[0]) / place[2], (v - place[1]) / place[2]
    if not (-1e-6 <= a <= views[0] - 1 + 1e-6 and -1e-6 <= b <= views[1] - 1 + 1e-6):
        return False
    left = min(max(int(math.floor(a)), 0), max(views[0] - 2, 0))
    low = min(max(int(math.floor(b)), 0), max(views[1] - 2, 0))
    within, at = np.float32(ghost), np.float32(q / unit)
    for _ in range(2):
        total = np.float32(0)
        part[:] = np.float32(0)
        for corner in range(4):
            i, j = left + corner % 2, low + corner // 2
            weight = np.float32((1.0 - abs(a - i)) * (1.0 - abs(b - j)))
            if i >= views[0] or j >= views[1] or weight <= np.float32(1e-6):
                continue
            number = j * views[0] + i
            x = (s + (a - i) * place[2] * (q - 1.0)) * place[3] + place[5] - offsets[number, 0] - 0.5
            y = place[6] - (t + (b - j) * place[2] * (q - 1.0)) * place[4] - offsets[number, 1] - 0.5
            if not (-0.5 <= x <= w - 0.5 and -0.5 <= y <= h - 0.5):
                continue
            line = number * h
            here = (line + min(int(y + 0.5), h - 1)) * w + min(int(x + 0.5), w - 1)
            if unscaled(texels[4 * here + 3]) > at + within:
                continue
            x0, y0 = int(x + 1.0) - 2, int(y + 1.0) - 2
            across, down = _cubic(np.float32(x - x0 - 1)), _cubic(np.float32(y - y0 - 1))
            taken, off = np.float32(1), np.float32(math.inf)
            if 0 <= x0 <= w - 4:
                lines = (4 * ((line + min(max(y0, 0), h - 1)) * w + x0),
                         4 * ((line + min(max(y0 + 1, 0), h - 1)) * w + x0),
                         4 * ((line + min(max(y0 + 2, 0), h - 1)) * w + x0),
                         4 * ((line + min(max(y0 + 3, 0), h - 1)) * w + x0))
                red, green, blue, off = texel_sum(texels, lines, down, across, at)
            if not off <= within or off == np.float32(math.inf):
                red, green, blue, taken = _one_by_one(texels, line, w, h, x0, y0, down, across, at, within)
                if taken < SEEN:
                    continue
            share = weight / taken
            part[0] += share * red
            part[1] += share * green
            part[2] += share * blue
            total += weight
        if total > np.float32(0):
            for c in range(3):
                part[c] /= total
            return True
        within = np.float32(math.inf)
    return False


@njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract"})
def _one_by_one(texels, line, w, h, x0, y0, down, across, at, within):
    """Σ down · across · texel over ZERO, of four by four texels from x0, y0 of a picture whose lines begin at `line`.

    Of those alone that are near the surface; and what these count. Beyond the picture's edge its last texel.
    """
    red, green, blue, taken = np.float32(0), np.float32(0), np.float32(0), np.float32(0)
    for m in range(4):
        begin = (line + min(max(y0 + m, 0), h - 1)) * w
        for n in range(4):
            k = 4 * (begin + min(max(x0 + n, 0), w - 1))
            if not abs(unscaled(texels[k + 3]) - at) > within:
                count = down[m] * across[n]
                red += count * unscaled(texels[k])
                green += count * unscaled(texels[k + 1])
                blue += count * unscaled(texels[k + 2])
                taken += count
    return red, green, blue, taken
