"""Cells of the exit pupil: the part of each that rims leave open, and sums over these parts.

Arrays of F fields × C wavelengths × N × N cells, the last axis sagittal and the one before it tangential.
"""

import math

import numpy as np

from lensbench.kernels.cache import njit


def open_areas(open_cells: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """(F,) areas in pupil coordinates of the open parts (F, N, N) of the cells of a grid (F, 2, N)."""
    return np.asarray(open_cells.sum((1, 2)) * np.nan_to_num((grid[:, :, 1] - grid[:, :, 0]).prod(1)))


@njit(cache=True, nogil=True, error_model="numpy")
def of_mean_1(beam, open_cells, first, weighed, out):
    """Light of the cells (F, C, N, N) from that of a beam (F, N, N), scaled to a mean of 1 over the open cells.

    open_cells: (F, …, N, N), from wavelength `first`. weighed: whether the light of a cell counts with its open part.
    """
    fields, colours, rows, columns = out.shape
    for f in range(fields):
        for c in range(colours):
            count, total = 0, 0.0
            for i in range(rows):
                for j in range(columns):
                    part = open_cells[f, first + c, i, j]
                    light = beam[f, i, j] * part if weighed else beam[f, i, j]
                    out[f, c, i, j] = light
                    if part > 0.0:
                        count += 1
                        total += light
            scale = count / total if total > 0.0 else 0.0
            for i in range(rows):
                for j in range(columns):
                    out[f, c, i, j] *= scale


@njit(cache=True, nogil=True, error_model="numpy")
def cover(level, c, s, t, grid, mirrored, coverage, weight, centre):
    """The parts of cells where the level is below 1, from its value and slopes, in wavelength c of (F, C, N, N).

    s, t: (F, C, N, N) pupil coordinates of the rays whose levels these are, near the cells' middles grid (F, 2, N);
    nan counts as the middle.
    A cell whose own ray is stopped has an open part only beside one whose ray passes: where neighbouring rays part,
    such as beside those that miss a surface, the slopes of the level say nothing about places cells away.
    mirrored: whether the columns of one half are the mirror images of the others. coverage (F, C, N, N) receives the
    open part of the cells of the exit pupil, weight that of the cells of the beam, whose middles the rays pass; centre
    (2, F, C, N, N) the centroid of the latter from the middle, in cells.
    """
    fields, _, rows, columns = level.shape
    for f in range(fields):
        plane = level[f, c]
        per_s, per_t = 1.0 / (grid[f, 0, 1] - grid[f, 0, 0]), 1.0 / (grid[f, 1, 1] - grid[f, 1, 0])
        for i in range(rows):
            for j in range(columns // 2 if mirrored else 0, columns):
                here, other = plane[i, j], columns - 1 - j
                part, of_beam, ds, dt = 0.0, 0.0, 0.0, 0.0
                if here < np.inf:
                    up, right = cell_slope(plane, i, j, 0), cell_slope(plane, i, j, 1)
                    moved = (up * (grid[f, 1, i] - t[f, c, i, j]) * per_t
                             + right * (grid[f, 0, j] - s[f, c, i, j]) * per_s)
                    if np.isnan(moved):                 # a ray that reaches the stop and has no pupil coordinates
                        moved = 0.0
                    a, b = max(abs(up), abs(right)), min(abs(up), abs(right))
                    part, of_beam = _below(1.0 - here - moved, a, b), _below(1.0 - here, a, b)
                    if here >= 1.0 and part + of_beam > 0.0 and not _beside_light(plane, i, j):
                        part, of_beam = 0.0, 0.0
                    if of_beam < 1.0 and a > 0.0:
                        ds, dt = -0.5 * (1.0 - of_beam) * right / a, -0.5 * (1.0 - of_beam) * up / a
                coverage[f, c, i, j], weight[f, c, i, j] = part, of_beam
                centre[0, f, c, i, j], centre[1, f, c, i, j] = ds, dt
                if mirrored and other != j:
                    coverage[f, c, i, other], weight[f, c, i, other] = part, of_beam
                    centre[0, f, c, i, other], centre[1, f, c, i, other] = -ds, dt


@njit(cache=True, nogil=True, error_model="numpy")
def _beside_light(level, i, j):
    """Whether the level of one of the eight cells around a cell is below 1."""
    for k in range(max(i - 1, 0), min(i + 2, level.shape[0])):
        for q in range(max(j - 1, 0), min(j + 2, level.shape[1])):
            if level[k, q] < 1.0:
                return True
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _below(d, a, b):
    """Part of a unit cell in the half-plane d + slopes · offset > 0; the greater slope is a, the other b."""
    half, flat = 0.5 * (a + b), 0.5 * (a - b)
    if abs(d) >= half or a == 0.0:
        return 1.0 if d >= 0.0 else 0.0
    if abs(d) <= flat:
        return 0.5 + d / a
    corner = (half - abs(d)) ** 2 / (2.0 * a * b)
    return 1.0 - corner if d > 0.0 else corner


@njit(cache=True, nogil=True, error_model="numpy")
def towards_centroids(values, weight, centre, out):
    """Values (n, N, N) halfway to the centroids (2, n, N, N) of the cells' open parts; 0 where the weight is 0."""
    for f in range(values.shape[0]):
        for i in range(values.shape[1]):
            for j in range(values.shape[2]):
                ds, dt = centre[0, f, i, j], centre[1, f, i, j]
                here = values[f, i, j]
                if ds != 0.0 or dt != 0.0:
                    here += 0.5 * (ds * _limited_slope(values[f], i, j, 1) + dt * _limited_slope(values[f], i, j, 0))
                out[f, i, j] = here if weight[f, i, j] > 0.0 else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _limited_slope(value, i, j, axis):
    """`cell_slope`, at most twice the change to either neighbour, and 0 at an extremum.

    Rays beyond the rim of a strong asphere land far from those within: their slope is none of the light's.
    """
    di, dj = (1, 0) if axis == 0 else (0, 1)
    rows, columns = value.shape
    slope = cell_slope(value, i, j, axis)
    if not (i + di < rows and j + dj < columns and i >= di and j >= dj):
        return slope
    after, before = value[i + di, j + dj] - value[i, j], value[i, j] - value[i - di, j - dj]
    if not (abs(after) < np.inf and abs(before) < np.inf):
        return slope
    if after * before <= 0.0:
        return 0.0
    most = 2.0 * min(abs(after), abs(before))
    return slope if abs(slope) <= most else math.copysign(most, slope)


@njit(cache=True, nogil=True, error_model="numpy")
def cell_slope(level, i, j, axis):
    """Change of a level per cell along an axis, from the neighbours that are finite; 0 where there is none."""
    di, dj = (1, 0) if axis == 0 else (0, 1)
    rows, columns = level.shape
    here = level[i, j]
    after = level[i + di, j + dj] if i + di < rows and j + dj < columns else np.nan
    before = level[i - di, j - dj] if i >= di and j >= dj else np.nan
    has_after, has_before = abs(after) < np.inf, abs(before) < np.inf
    if has_after and has_before:
        return 0.5 * (after - before)
    if has_after:
        return after - here
    return here - before if has_before else 0.0
