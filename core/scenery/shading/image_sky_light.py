"""Light of a sky shown by a picture: for each sample one direction, chosen by V0 and V1 in proportion to its radiance.

The picture is a table of cells of uniform radiance. A row of cells is chosen by the cumulative share of its light, then
a cell of the row, then a direction in the cell, uniform over its solid angle: what a sample adds then depends on
nothing but the tint of its cell, the angle of incidence and the shadow. Neighbouring samples give neighbouring
directions.
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.core.kernels.arrays import address, borrowed
from lensbench.core.kernels.block import (
    A3, A4, A5, A6, A7, A8, A9, A10, BLUE, GREEN, NX, NY, NZ, RED, SB, SG, SR, V0, V1, B, Step, offsets, pack, rows,
    stage
)
from lensbench.core.kernels.byte_cache import byte_cache
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.numeric import sine_versine
from lensbench.core.scenery.intersect.sky import sky_place
from lensbench.core.scenery.objects.surroundings import ImageSky
from lensbench.core.scenery.shading.illumination import met_points

MOST_KEPT = 256 << 20   # bytes of tables and their pictures: two skies of 4096 × 2048, whose tables take 1.5 s
LEAST_ACROSS, MOST_ACROSS = 512, 2048   # cells across: finer than a small picture, coarser than a large one

# FLUX: ∫ radiance dω, the mean of the colours, / π
COSINE, SINE, FLUX, SKY_LIGHT = offsets(1, 1, 1)
# Integers: places of the tables (float32), cells across and down, steps of their binary searches
ROWS_PLACE, CELLS_PLACE, TINTS_PLACE, ACROSS, DOWN, ROW_STEPS, CELL_STEPS, CELL_INTEGERS = range(8)


class SkyCells(NamedTuple):
    """Cells of uniform radiance: cumulative shares of the light over rows (h + 1,) and in each row (h, w + 1), tints.

    tints (h, w, 3): colour of a cell over the mean of its channels; flux: ∫ mean radiance dω, brightness included.
    """

    rows: np.ndarray
    cells: np.ndarray
    tints: np.ndarray
    flux: float


@byte_cache(MOST_KEPT, 4)
def sky_cells(sky: ImageSky) -> SkyCells:
    """The cells of a sky."""
    values = _cells(sky.image.values) * sky.brightness
    height, width = values.shape[:2]
    mean = values.mean(2)
    edges = np.cos(math.pi * np.arange(height + 1) / height)
    light = mean * ((edges[:-1] - edges[1:]) * 2.0 * math.pi / width)[:, None]
    lines = light.sum(1)
    flux = float(lines.sum())
    cumulative = np.concatenate([np.zeros((height, 1)), np.cumsum(light, 1)], 1)
    cumulative /= np.maximum(cumulative[:, -1:], 1e-300)
    down = np.concatenate([[0.0], np.cumsum(lines)]) / max(flux, 1e-300)
    tints = values / np.maximum(mean, 1e-300)[..., None]
    return SkyCells(np.ascontiguousarray(down, np.float32), np.ascontiguousarray(cumulative, np.float32),
                    np.ascontiguousarray(tints, np.float32), flux)


def _cells(values: np.ndarray) -> np.ndarray:
    """Radiance of the cells: means over parts of a large picture, a small one interpolated as it is shown."""
    height, width = values.shape[:2]
    if width > MOST_ACROSS or height > MOST_ACROSS // 2:
        most_down, most_across = min(height, MOST_ACROSS // 2), min(width, MOST_ACROSS)
        lines = _means(values, _levels(height), _levels(most_down))
        columns = _means(lines.swapaxes(0, 1), np.linspace(0.0, 1.0, width + 1), np.linspace(0.0, 1.0, most_across + 1))
        return columns.swapaxes(0, 1)
    if width >= LEAST_ACROSS:
        return values.astype(np.float64)
    finer = -(-LEAST_ACROSS // width)
    down = np.clip((np.arange(height * finer) + 0.5) / finer - 0.5, 0.0, height - 1.0)
    line = np.minimum(down.astype(int), height - 2)
    share = (down - line)[:, None, None]
    tall = values[line] * (1.0 - share) + values[line + 1] * share
    along = (np.arange(width * finer) + 0.5) / finer - 0.5
    left = np.floor(along).astype(int)
    share = (along - left)[:, None]
    return tall[:, left % width] * (1.0 - share) + tall[:, (left + 1) % width] * share


def _levels(count: int) -> np.ndarray:
    """Edges (count + 1,) of the rows of a picture, in the solid angle above them over 4π."""
    return (1.0 - np.cos(math.pi * np.arange(count + 1) / count)) / 2.0


def _means(values: np.ndarray, edges: np.ndarray, wider: np.ndarray) -> np.ndarray:
    """Means (m, …) of rows (n, …), which lie between `edges` (n + 1,), over the parts between `wider` (m + 1,).

    Rows count with what of them lies in a part, so that no light is lost or won at its edges.
    """
    means = np.empty((len(wider) - 1, *values.shape[1:]))
    firsts = np.maximum(np.searchsorted(edges, wider[:-1], "right") - 1, 0)
    ends = np.minimum(np.searchsorted(edges, wider[1:], "left"), len(values))
    for k, (first, end) in enumerate(zip(firsts, ends, strict=True)):
        shared = np.minimum(edges[first + 1:end + 1], wider[k + 1]) - np.maximum(edges[first:end], wider[k])
        means[k] = np.tensordot(shared / shared.sum(), values[first:end], 1)
    return means


def sky_rays_step(sky: ImageSky) -> Step:
    """The stage `sky_rays`."""
    cells = sky_cells(sky)
    height, width = cells.tints.shape[:2]
    return Step(sky_rays, pack(SKY_LIGHT, {COSINE: math.cos(sky.turn), SINE: math.sin(sky.turn),
                                           FLUX: cells.flux / math.pi}),
                [address(cells.rows), address(cells.cells), address(cells.tints), width, height,
                 height.bit_length(), width.bit_length()], kept=cells)


@njit(inline="always")
def _find(real, table, first, count, steps, share):
    """Cell k < count with table[first + k] ≤ share < table[first + k + 1], for a cumulative table."""
    low, size = np.int64(0), np.int64(count)
    for _ in range(steps):
        half = size >> 1
        middle = low + half
        inside = real(table[first + np.uint64(middle)]) <= share
        low = middle if inside & (half > 0) else low
        size = size - half
    return low


@stage
def sky_rays(lanes, p, ints, key):
    """Sample a direction of the sky: A0 … A7 as `shadow` reads them, and its tint times the flux, A8 A9 A10.

    p, ints: sky_rays_step.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    nx, ny, nz = row[NX], row[NY], row[NZ]
    wx, wy, wz, far, light = row[A3], row[A4], row[A5], row[A6], row[A7]
    r, g, b, v0, v1 = row[A8], row[A9], row[A10], row[V0], row[V1]
    across, down = ints[ACROSS], ints[DOWN]
    lines = borrowed(ints[ROWS_PLACE], down + 1, np.float32)
    cells = borrowed(ints[CELLS_PLACE], down * (across + 1), np.float32)
    tints = borrowed(ints[TINTS_PLACE], down * across * 3, np.float32)
    cosine, sine, flux = p[COSINE], p[SINE], p[FLUX]
    per_across, per_down = real(1) / real(across), real(math.pi) / real(down)

    # Choose a cell, and a place in it: far and light hold its turn and its line for now
    for i in range(B):
        k = _find(real, lines, np.uint64(0), down, ints[ROW_STEPS], v0[i])
        first = np.uint64(k) * np.uint64(across + 1)
        c = _find(real, cells, first, across, ints[CELL_STEPS], v1[i])
        a, e = real(lines[np.uint64(k)]), real(lines[np.uint64(k + 1)])
        f, h = real(cells[first + np.uint64(c)]), real(cells[first + np.uint64(c + 1)])
        s = (v0[i] - a) / (e - a) if e > a else real(0.5)
        t = (v1[i] - f) / (h - f) if h > f else real(0.5)
        far[i], light[i], wx[i] = (real(c) + t) * per_across - real(0.5), real(k), s
        m = (np.uint64(k) * np.uint64(across) + np.uint64(c)) * np.uint64(3)
        r[i], g[i], b[i] = (flux * real(tints[m]), flux * real(tints[m + np.uint64(1)]),
                            flux * real(tints[m + np.uint64(2)]))

    # Find its direction, uniform over the solid angle of the cell
    met_points(lanes)
    for i in range(B):
        c0, c1 = math.cos(light[i] * per_down), math.cos((light[i] + real(1)) * per_down)
        high = c0 + wx[i] * (c1 - c0)
        level = math.sqrt(max(real(1) - high * high, real(0)))
        turned, versine = sine_versine(real, far[i])
        a, c = level * turned, level * (versine - real(1))
        wx[i], wy[i], wz[i] = cosine * a + sine * c, high, cosine * c - sine * a
        slant = nx[i] * wx[i] + ny[i] * wy[i] + nz[i] * wz[i]
        far[i] = real(math.inf)
        light[i] = slant if slant > real(0) else real(0)


@stage
def sky_density(lanes, ints, cosine, sine, density):
    """Density per solid angle with which `sky_rays` chooses the direction A3 A4 A5, to the row `density`.

    ints: sky_rays_step; cosine, sine: of the turn of the sky.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    wx, wy, wz = row[A3], row[A4], row[A5]
    across, down = ints[ACROSS], ints[DOWN]
    lines = borrowed(ints[ROWS_PLACE], down + 1, np.float32)
    cells = borrowed(ints[CELLS_PLACE], down * (across + 1), np.float32)
    per_down, most = real(math.pi) / real(down), real(across) * real(1 / (2 * math.pi))
    for i in range(B):
        u, v = sky_place(real, wx[i], wy[i], wz[i], cosine, sine)
        u, v = u * real(across), v * real(down)
        u = min(u, real(across) - real(0.5)) if u > real(0) else real(0)       # NaN, of a lane without a direction: 0
        v = min(v, real(down) - real(0.5)) if v > real(0) else real(0)
        k, c = np.uint64(np.uint32(v)), np.uint64(np.uint32(u))
        m = k * np.uint64(across + 1) + c
        line = real(lines[k + np.uint64(1)]) - real(lines[k])
        share = line * (real(cells[m + np.uint64(1)]) - real(cells[m]))
        high = real(np.uint32(v))
        # cos a − cos (a + w) as a product, which keeps its digits near the poles
        size = real(2) * math.sin((high + real(0.5)) * per_down) * math.sin(real(0.5) * per_down)
        density[i] = share * most / size


@stage
def add_tinted(lanes, p, ints, key):
    """Add the light A7 of the tint A8 A9 A10 to what the path gathers."""
    row = rows(lanes)
    red, green, blue, sr, sg, sb, light = row[RED], row[GREEN], row[BLUE], row[SR], row[SG], row[SB], row[A7]
    r, g, b = row[A8], row[A9], row[A10]
    for i in range(B):
        sr[i] += red[i] * light[i] * r[i]
        sg[i] += green[i] * light[i] * g[i]
        sb[i] += blue[i] * light[i] * b[i]
