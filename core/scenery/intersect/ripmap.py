"""An image with its reductions, halved again and again in width and height independently (a ripmap), and its look-up.

A footprint on an inclined surface is longer than wide: a reduction of its own for each of the two directions keeps
the image sharp across it.
"""

from typing import NamedTuple

import numpy as np

from lensbench.kernels.block import A1, A2, A3, A4, A5, A6, A7, A8, A9, A10, PATH, B, gather, rows, stage
from lensbench.kernels.cache import njit
from lensbench.kernels.layout import Packed
from lensbench.scenery.emission import DIRECT

ENOUGH = 1.3            # texels of a reduction that a footprint covers at least
STRIP = 512             # rows that are averaged at a time, to bound the memory
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
    for top in range(0, height, STRIP):
        strip = image[top:top + STRIP].transpose(1, 0, 2)
        sums = _prefix_sums(strip)
        for reduced, m in zip(narrow, across[1:], strict=True):
            reduced[:, top:top + STRIP] = _means(strip, sums, m)
    parts = [image.reshape(-1, 3)]
    while narrow:
        lines = narrow.pop(0).transpose(1, 0, 2)
        sums = _prefix_sums(lines)
        parts += [_means(lines, sums, n).reshape(-1, 3).astype(image.dtype) for n in down[1:]]
    starts = np.cumsum([0] + [len(part) for part in parts[:-1]]).tolist()
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
    at, line, place = row[A9], row[A3], row[A10]
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
        at[i] = real(1) + (a - real(1)) * across_levels + b - real(1) if either else real(0)
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
        line[i], place[i], across[i], down[i] = kb, ka, a - ka, b - kb

    # Interpolate; texels are counted in integers, which single precision holds up to 2²⁴ only
    right, green_at, blue_at = np.uint64(3), np.uint64(1), np.uint64(2)
    other, none = np.uint64(ints[SECOND]), np.uint64(0)
    for i in range(B):
        wide = np.uint64(np.uint32(columns[i]))
        k = np.uint64(starts[np.uint32(at[i])])
        k += np.uint64(np.uint32(line[i])) * wide + np.uint64(np.uint32(place[i]))
        k = (k + (other if path[i] > real(DIRECT) else none)) * right
        below = k + wide * right
        a, b = across[i], down[i]
        red[i] = _bilinear(texels, k, below, right, a, b)
        green[i] = _bilinear(texels, k + green_at, below + green_at, right, a, b)
        blue[i] = _bilinear(texels, k + blue_at, below + blue_at, right, a, b)
