"""Patterns and images on shapes, averaged over the footprint of a pixel.

The footprint of a ray on a surface is a box along the axes of the pattern; along each axis it is as wide as a square
pixel, rotated in any way, spreads there (the same variance). At zero width a pattern has its value at the point.

A small image of a planar shape travels with the parameters of its stage, as a `Ripmap`: halved again and again in width
and height independently, so that an image on an inclined surface, whose footprint is longer than wide, stays sharp
across it.

Other images, a `Texture`, are read where they lie (`borrowed`): 16 bits a channel, the square root of the part of its
greatest value, halved in both directions at once. A footprint looks up the reduction of its shorter side, but none with
texels shorter than an eighth of its longer one.
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.core.kernels.arrays import address, borrowed
from lensbench.core.kernels.block import A1, A2, A3, A4, A5, A6, A7, A8, A9, A10, PATH, B, Packed, gather, rows, stage
from lensbench.core.kernels.byte_cache import byte_cache
from lensbench.core.kernels.cache import njit
from lensbench.core.scenery.objects.material import Image
from lensbench.core.scenery.surface_codes import DIRECT

THIN = 1e-4             # of a pattern's period: narrower footprints see sharp lines, the limit of float32


@njit(inline="always")
def footprint_stretch(real, along, steep):
    """Width of a footprint along an axis of the surface over its width across the ray.

    along: cosine between ray and axis; steep: 1 / cosine between ray and normal.
    """
    slope = along * steep
    return math.sqrt(real(1) + slope * slope)


@njit(inline="always")
def filtered_contrast(real, off, width):
    """Mean over a box of a square wave of ±1 with edges at the integers, times its sign at the middle of the box.

    off: distance to the nearest edge; width: of the box; both in half-waves. Exact for widths below 2, the full
    wave; the lobes beyond, at most a third and of the opposite sign, are dropped.
    """
    inverse = real(1) / (width + real(1e-20))
    left, level = real(2) * off * inverse, real(2) * inverse - real(1)
    level = level if level < real(1) else real(1)
    level = level if level > real(0) else real(0)
    return left if left < level else level


@njit(inline="always")
def parity(real, k):
    """0 for an even whole number, 1/2 for an odd one."""
    return k * real(0.5) - np.floor(k * real(0.5))


@njit(inline="always")
def checker_contrast(real, a, b, wide_a, wide_b):
    """Contrast of a checker of unit fields at a, b, averaged over a box wide_a × wide_b: 1 sharp, 0 uniform."""
    return (filtered_contrast(real, abs(a - np.floor(a + real(0.5))), wide_a)
            * filtered_contrast(real, abs(b - np.floor(b + real(0.5))), wide_b))


@njit(inline="always")
def line_coverage(real, position, line, width):
    """Part of a box that lines about all integers cover; place, line and box width in periods of the lines."""
    off, half, reach = position - _nearest(real, position), real(0.5) * line, real(0.5) * width
    high, low = off + reach, off - reach
    above, below = _nearest(real, high), _nearest(real, low)
    high, low = high - above, low - below
    high = high if high < half else half
    high = high if high > -half else -half
    low = low if low < half else half
    low = low if low > -half else -half
    covered = ((above - below) * line + high - low) / (width + real(1e-20))
    sharp = real(1) if abs(off) <= half else real(0)
    return sharp if width < real(THIN) else covered


@njit(inline="always")
def _nearest(real, x):
    """Nearest integer."""
    return np.floor(x + real(0.5))


ENOUGH = 1.3            # texels of a reduction that a footprint covers at least
RIPMAP_STRIP = 512             # rows that are averaged at a time, to bound the memory
# Integers: first texel that all paths see but DIRECT ones, level counts, first texel of each reduction. Parameters:
# texels across at each horizontal level, texels down at each vertical level, then the texels
SECOND, LEVELS_U, LEVELS_V, STARTS = range(4)


class Ripmap(NamedTuple):
    """All reductions of an image: first the image itself, then those reduced in both directions."""

    across: list[int]       # texels across at each horizontal level
    down: list[int]         # texels down at each vertical level
    starts: list[int]       # index of the first texel: of the image, then for each level across all levels down
    texels: np.ndarray      # (n, 3)

    def packed(self, *second: "Ripmap") -> list[Packed]:
        """Parameters of `look_up`. second: those of another image of this size, for paths that are not DIRECT."""
        return [Packed(np.array([*self.across, *self.down], float),
                       [len(self.texels) if second else 0, len(self.across), len(self.down), *self.starts]),
                *(Packed(image.texels.ravel()) for image in (self, *second))]


def _sizes(size: int) -> list[int]:
    """Texels along a side at each level: at least two levels, the last of 2 or 3 texels."""
    return [max(2, size >> k) for k in range(max(2, size.bit_length() - 1))]


def _prefix_sums(values: np.ndarray) -> np.ndarray:
    """Sums of the first 0, 1, … entries of the first axis."""
    return np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, 0, np.float64)])


def _means(values: np.ndarray, sums: np.ndarray, bins: int) -> np.ndarray:
    """Means over equal parts of the first axis, from its prefix sums."""
    edges = np.linspace(0.0, len(values), bins + 1)
    k = np.minimum(edges.astype(int), len(values) - 1)
    sums = sums[k] + (edges - k)[:, None, None] * values[k]
    return np.diff(sums, axis=0) * (bins / len(values))


def ripmap(image: np.ndarray) -> Ripmap:
    """Reductions of an image (height, width, 3), as numbers of its type."""
    height, width = image.shape[:2]
    across, down = _sizes(width), _sizes(height)
    narrow = [np.empty((m, height, 3)) for m in across[1:]]
    for top in range(0, height, RIPMAP_STRIP):
        strip = image[top:top + RIPMAP_STRIP].transpose(1, 0, 2)
        sums = _prefix_sums(strip)
        for reduced, m in zip(narrow, across[1:], strict=True):
            reduced[:, top:top + RIPMAP_STRIP] = _means(strip, sums, m)
    parts = [image.reshape(-1, 3)]
    while narrow:
        lines = narrow.pop(0).transpose(1, 0, 2)
        sums = _prefix_sums(lines)
        parts += [_means(lines, sums, n).reshape(-1, 3).astype(image.dtype) for n in down[1:]]
    starts = np.cumsum([0] + [len(level) for level in parts[:-1]]).tolist()
    return Ripmap(across, down, starts, np.concatenate(parts))


@njit(inline="always")
def _bilinear(texels, k, below, right, across, down):
    """One channel between four texels."""
    e, f = texels[k], texels[k + right]
    g, h = texels[below], texels[below + right]
    upper, lower = e + across * (f - e), g + across * (h - g)
    return upper + down * (lower - upper)


@stage
def look_up(lanes, p, ints):
    """Colours A4 A5 A6 of the image at A1, A2 (u, v in [−1, 1]; the first row at v = 1), bilinear between texels.

    The reduction is the one whose texels are about as large as the footprint, A7 of u wide and A8 of v.
    p, ints: Ripmap.packed.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    u, v, across, down = row[A1], row[A2], row[A1], row[A2]
    reduction, line, column = row[A9], row[A3], row[A10]
    level_u, level_v, columns, lines = row[A4], row[A5], row[A7], row[A8]
    red, green, blue, path = row[A4], row[A5], row[A6], row[PATH]
    most_u, most_v, starts = ints[LEVELS_U], ints[LEVELS_V], ints[STARTS:]
    sizes_u, sizes_v, texels = p, p[most_u:], p[most_u + most_v:]

    # Choose the level of each direction
    for i in range(B):
        level_u[i], level_v[i] = real(0), real(0)
    least = real(2 * ENOUGH)
    for level in range(1, max(most_u, most_v)):
        size_u, size_v = least / sizes_u[0] * real(2), least / sizes_v[0] * real(2)
        for i in range(B):
            level_u[i] += real(1) if (columns[i] > size_u) & (level < most_u) else real(0)
            level_v[i] += real(1) if (lines[i] > size_v) & (level < most_v) else real(0)
        least *= real(2)

    # Find where the reduction begins; one that is reduced in a single direction is not kept
    across_levels = real(most_v - 1)
    for i in range(B):
        either = level_u[i] + level_v[i] > real(0)
        a, b = level_u[i], level_v[i]
        a, b = a if a > real(1) else real(1), b if b > real(1) else real(1)
        level_u[i], level_v[i] = a if either else real(0), b if either else real(0)
        reduction[i] = real(1) + (a - real(1)) * across_levels + b - real(1) if either else real(0)
    gather(columns, sizes_u, level_u)
    gather(lines, sizes_v, level_v)

    # Find the upper left of the four texels around the point, and the place between them
    for i in range(B):
        wide, tall = columns[i], lines[i]
        a = (u[i] + real(1)) * real(0.5) * wide - real(0.5)
        b = (real(1) - v[i]) * real(0.5) * tall - real(0.5)
        a = a if a > real(0) else real(0)
        a = a if a < wide - real(1) else wide - real(1)
        b = b if b > real(0) else real(0)
        b = b if b < tall - real(1) else tall - real(1)
        ka, kb = np.floor(a), np.floor(b)
        ka = ka if ka < wide - real(2) else wide - real(2)
        kb = kb if kb < tall - real(2) else tall - real(2)
        line[i], column[i], across[i], down[i] = kb, ka, a - ka, b - kb

    # Interpolate; texels are counted in integers, which single precision holds up to 2²⁴ only
    right, green_at, blue_at = np.uint64(3), np.uint64(1), np.uint64(2)
    other, none = np.uint64(ints[SECOND]), np.uint64(0)
    for i in range(B):
        wide = np.uint64(np.uint32(columns[i]))
        k = np.uint64(starts[np.uint32(reduction[i])])
        k += np.uint64(np.uint32(line[i])) * wide + np.uint64(np.uint32(column[i]))
        k = (k + (other if path[i] > real(DIRECT) else none)) * right
        below = k + wide * right
        a, b = across[i], down[i]
        red[i] = _bilinear(texels, k, below, right, a, b)
        green[i] = _bilinear(texels, k + green_at, below + green_at, right, a, b)
        blue[i] = _bilinear(texels, k + blue_at, below + blue_at, right, a, b)


ELONGATED = 0.125       # of the longer side of a footprint: least size of a texel
MOST_KEPT = 1 << 30     # bytes of coded pictures and their originals, for scenes seen before
STRIP = 256             # rows that are coded at a time, to bound the memory
# Integers: place and count of the texels, texels across and down, number of reductions with the picture itself, WRAPS
PLACE, COUNT, ACROSS, DOWN, LEVELS, WRAPS, TEXTURE = range(7)
AROUND, REPEATED = 1, 3     # WRAPS: columns go on from the last to the first; rows too


class Texture(NamedTuple):
    """A coded picture and all its reductions: texels uint16 (n, 3), and the value of the code 65535."""

    texels: np.ndarray
    across: int
    down: int
    levels: int
    greatest: float

    def integers(self, wraps: int = 0) -> list[int]:
        """Integers of `look_up_texture`. wraps: 0, AROUND or REPEATED."""
        return [address(self.texels), self.texels.size, self.across, self.down, self.levels, wraps]


@byte_cache(MOST_KEPT, 32)
def texture(image: Image) -> Texture:
    """The coded picture of an image; its values must not be negative."""
    values, greatest = image.values, float(max(image.values.max(), 1e-30))
    sizes = [(image.height, image.width)]
    while min(sizes[-1]) >= 4:
        sizes.append((sizes[-1][0] // 2, sizes[-1][1] // 2))
    texels = np.empty((sum(down * across for down, across in sizes), 3), np.uint16)     # no copy of all at the end
    start = 0
    for down, across in sizes:
        values = values if start == 0 else _halved(values)
        _code(values, greatest, texels[start:start + down * across].reshape(down, across, 3))
        start += down * across
    return Texture(texels, image.width, image.height, len(sizes), greatest)


def _halved(values: np.ndarray) -> np.ndarray:
    """Means of 2 × 2 texels; the last row or column of an odd number is left out."""
    height, width = (size // 2 * 2 for size in values.shape[:2])
    halved = np.empty((height // 2, width // 2, 3), np.float32)
    for top in range(0, height, 2 * STRIP):
        strip = values[top:min(top + 2 * STRIP, height), :width]
        halved[top // 2:(top + len(strip)) // 2] = 0.25 * (strip[::2, ::2] + strip[1::2, ::2] + strip[::2, 1::2]
                                                          + strip[1::2, 1::2])
    return halved


def _code(values: np.ndarray, greatest: float, into: np.ndarray) -> None:
    for top in range(0, len(values), STRIP):
        into[top:top + STRIP] = np.sqrt(np.maximum(values[top:top + STRIP], 0.0) / greatest) * 65535.0 + 0.5


@njit(inline="always")
def _decoded(real, texels, k, m, q, w, e, f, g, h):
    """One channel between four texels of a coded picture, weighed by e, f, g, h; codes are square roots."""
    a, b, c, d = real(texels[k]), real(texels[m]), real(texels[q]), real(texels[w])
    return e * a * a + f * b * b + g * c * c + h * d * d


@stage
def look_up_texture(lanes, greatest, ints):
    """Colours A4 A5 A6 of a picture at A1, A2 (u, v in [−1, 1]; its first row at v = 1), bilinear between texels.

    A7, A8: sides of the footprint in u and v. ints: Texture.integers.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    u, v, columns, lines = row[A1], row[A2], row[A7], row[A8]
    red, green, blue, level, wide_at, tall_at, first_at = (row[A4], row[A5], row[A6], row[A3], row[A9], row[A10],
                                                           row[A7])
    texels = borrowed(ints[PLACE], ints[COUNT], np.uint16)
    across, down, levels = ints[ACROSS], ints[DOWN], ints[LEVELS]
    scale = greatest * real(1 / 65535.0**2)

    # Choose the reduction
    per_u, per_v = real(across) * real(0.5 / ENOUGH), real(down) * real(0.5 / ENOUGH)
    for i in range(B):
        a, b = columns[i] * per_u, lines[i] * per_v
        shorter, longer = (a, b) if a < b else (b, a)
        longer *= real(ELONGATED)
        level[i] = shorter if shorter > longer else longer
    for i in range(B):
        wide_at[i], tall_at[i], first_at[i] = real(across), real(down), real(0)
    wide, tall, start, least = across, down, np.int64(0), real(2)
    for _ in range(1, levels):
        start += wide * tall
        wide, tall = wide >> 1, tall >> 1
        w, t, number = real(wide), real(tall), real(_)
        for i in range(B):
            coarser = level[i] >= least
            wide_at[i] = w if coarser else wide_at[i]
            tall_at[i] = t if coarser else tall_at[i]
            first_at[i] = number if coarser else first_at[i]
        least *= real(2)

    # Interpolate between four texels, counted in integers
    one, two, three, none = np.uint64(1), np.uint64(2), np.uint64(3), np.uint64(0)
    around, repeated = (ints[WRAPS] & 1) != 0, (ints[WRAPS] & 2) != 0
    for i in range(B):
        a = (u[i] + real(1)) * real(0.5) * wide_at[i] - real(0.5)
        b = (real(1) - v[i]) * real(0.5) * tall_at[i] - real(0.5)
        low_a, low_b = real(0) if not around else a + wide_at[i], real(0) if not repeated else b + tall_at[i]
        a, b = a if a >= real(0) else low_a, b if b >= real(0) else low_b
        a, b = a if a > real(0) else real(0), b if b > real(0) else real(0)             # NaN becomes 0
        u[i] = a if a < wide_at[i] else a - wide_at[i]
        v[i] = b if b < tall_at[i] else b - tall_at[i]
    for i in range(B):
        wide, tall, number = np.uint64(np.uint32(wide_at[i])), np.uint64(np.uint32(tall_at[i])), np.int64(first_at[i])
        x, y, first = across, down, np.int64(0)
        for _ in range(number):
            first += x * y
            x, y = x >> 1, y >> 1
        a, b = u[i], v[i]
        column, line = np.uint64(np.uint32(a)), np.uint64(np.uint32(b))
        column, line = column if column < wide else wide - one, line if line < tall else tall - one
        beside = column + one if column + one < wide else (none if around else column)
        below = line + one if line + one < tall else (none if repeated else line)
        s, t = a - real(np.uint32(column)), b - real(np.uint32(line))
        left, right = (np.uint64(first) + line * wide) * three, (np.uint64(first) + below * wide) * three
        k, m, q, w = left + column * three, left + beside * three, right + column * three, right + beside * three
        e, f, g, h = (real(1) - s) * (real(1) - t), s * (real(1) - t), (real(1) - s) * t, s * t
        red[i] = scale * _decoded(real, texels, k, m, q, w, e, f, g, h)
        green[i] = scale * _decoded(real, texels, k + one, m + one, q + one, w + one, e, f, g, h)
        blue[i] = scale * _decoded(real, texels, k + two, m + two, q + two, w + two, e, f, g, h)
