"""Cells of the exit pupil of a ray grid, found from the film, and the object's rays through them in each wavelength.

Lengths in mm, lens frame. F fields, C wavelengths, N × N cells of a field. See `traced_grid` for the reference points,
axes and pupil coordinates.

Cells of the exit pupil: the part of each that rims leave open, and sums over these parts.

Arrays of F fields × C wavelengths × N × N cells, the last axis sagittal and the one before it tangential.

Light of an evenly lit beam in the cells of a pupil grid, by where their rays run in the scene.
"""

import math
from math import inf, isinf, nan
from typing import NamedTuple

import numpy as np

from lensbench.core.analysis.grids.field_beams import LANDED, LEVEL, OFFSET_S, PUPIL_S, PUPIL_T, SLOPE_S, FieldBeams
from lensbench.core.analysis.grids.field_conditions import Conditions, each_in_turn, each_of
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.pauses import pause


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
                    share = open_cells[f, first + c, i, j]
                    light = beam[f, i, j] * share if weighed else beam[f, i, j]
                    out[f, c, i, j] = light
                    if share > 0.0:
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
                nearness, other = plane[i, j], columns - 1 - j
                lit, of_beam, ds, dt = 0.0, 0.0, 0.0, 0.0
                if nearness < np.inf:
                    up, right = cell_slope(plane, i, j, 0), cell_slope(plane, i, j, 1)
                    moved = (up * (grid[f, 1, i] - t[f, c, i, j]) * per_t
                             + right * (grid[f, 0, j] - s[f, c, i, j]) * per_s)
                    if np.isnan(moved):                 # a ray that reaches the stop and has no pupil coordinates
                        moved = 0.0
                    a, b = max(abs(up), abs(right)), min(abs(up), abs(right))
                    lit, of_beam = _below(1.0 - nearness - moved, a, b), _below(1.0 - nearness, a, b)
                    if nearness >= 1.0 and lit + of_beam > 0.0 and not _beside_light(plane, i, j):
                        lit, of_beam = 0.0, 0.0
                    if of_beam < 1.0 and a > 0.0:
                        ds, dt = -0.5 * (1.0 - of_beam) * right / a, -0.5 * (1.0 - of_beam) * up / a
                coverage[f, c, i, j], weight[f, c, i, j] = lit, of_beam
                centre[0, f, c, i, j], centre[1, f, c, i, j] = ds, dt
                if mirrored and other != j:
                    coverage[f, c, i, other], weight[f, c, i, other] = lit, of_beam
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
                value = values[f, i, j]
                if ds != 0.0 or dt != 0.0:
                    value += 0.5 * (ds * _limited_slope(values[f], i, j, 1) + dt * _limited_slope(values[f], i, j, 0))
                out[f, i, j] = value if weight[f, i, j] > 0.0 else 0.0


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
    middle = level[i, j]
    after = level[i + di, j + dj] if i + di < rows and j + dj < columns else np.nan
    before = level[i - di, j - dj] if i >= di and j >= dj else np.nan
    has_after, has_before = abs(after) < np.inf, abs(before) < np.inf
    if has_after and has_before:
        return 0.5 * (after - before)
    if has_after:
        return after - middle
    return middle - before if has_before else 0.0


LARGEST = 20.0          # × the median of the open cells: of lenses in use the light of a cell is at most six times it


def beam_areas(beams: FieldBeams, places: np.ndarray, level: np.ndarray) -> np.ndarray:
    """(F, N, N) light of an evenly lit beam per cell of the grid, from `towards_scene` of its rays.

    An object at infinity lights the beam's area evenly, one nearby by Lambert's law. Cells of rays that do not
    come through have no light, and neither have those beyond a fold, or beside a place where rays part without limit:
    their places belong to other cells too.
    """
    out = np.zeros(places.shape[:3])
    _areas(places, level, out)
    for areas, shares in zip(out, level, strict=True):
        open_ = areas[(shares < 1.0) & (areas > 0.0)]
        if open_.size:
            middle = open_.size // 2
            areas[areas > LARGEST * np.partition(open_, middle)[middle]] = 0.0
    if not isinf(beams.object_distance):
        reach = beams.reaches[:, None, None]
        far = np.sqrt(reach**2 + np.where(np.isfinite(places), places, 0.0)**2 @ np.ones(2))
        along = (np.einsum("fija,fa->fij", np.nan_to_num(places), beams.frames[:, :, 2])
                 + reach * beams.chief.directions[:, 2, None, None])
        out *= np.nan_to_num((reach / far) ** 3 * np.abs(along / far))
    return out


@njit(cache=True, nogil=True, error_model="numpy")
def _areas(places, level, out):
    """Area of the beam per cell of the exit pupil (F, N, N), from places (F, N, N, 2) of rays with a finite level.

    A cell has the mean area of the parallelograms at its four corners, each with one neighbour along both axes: of
    those that turn as the field's open ones do, level < 1, and 0 unless most do.
    """
    fields, rows, columns, _ = places.shape
    for f in range(fields):
        turn = 0.0
        for i in range(rows - 1):
            for j in range(columns - 1):
                if level[f, i, j] < 1.0:
                    area = _parallelogram(places, level, f, i, j, 1, 1)
                    turn += area if abs(area) < np.inf else 0.0
        sign = 1.0 if turn >= 0.0 else -1.0
        for i in range(rows):
            for j in range(columns):
                total, alike, known = 0.0, 0, 0
                for di in (-1, 1):
                    for dj in (-1, 1):
                        area = sign * _parallelogram(places, level, f, i, j, di, dj)
                        if abs(area) < np.inf:
                            known += 1
                            if area > 0.0:
                                alike += 1
                                total += area
                out[f, i, j] = total / alike if 2 * alike > known else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _parallelogram(places, level, f, i, j, di, dj):
    """Signed area between a cell and its neighbours along both axes; NaN where one is missing or has a lost ray."""
    if not (0 <= i + di < places.shape[1] and 0 <= j + dj < places.shape[2]):
        return np.nan
    if not (level[f, i, j] < np.inf and level[f, i + di, j] < np.inf and level[f, i, j + dj] < np.inf):
        return np.nan
    s, t = places[f, i, j, 0], places[f, i, j, 1]
    return di * dj * ((places[f, i + di, j, 0] - s) * (places[f, i, j + dj, 1] - t)
                      - (places[f, i + di, j, 1] - t) * (places[f, i, j + dj, 0] - s))


FEW = 8000              # rays of all wavelengths, below which threads cost more than they save
MANY = 24               # fields, from which on a wavelength is divided among the threads
WIDENED, WIDER = 3, 0.25        # times that a field cut off at the edge of the grid is widened, by which part a side
FOLDED = 0.7            # × the square root of the open cells: open ones at a fold
SOUGHT = 33             # rays of the meridian of a field, that seek light apart from the cells
BEYOND = 4.0            # cells beyond the rims, of which rays are traced too: half of them


class Cells(NamedTuple):
    """The cells of the exit pupil, from the film.

    grid (F, 2, N): their middles. places (F, N, N, 2): where their rays run in the scene. open_ (F, N, N): their open
    parts. lost (F, N, N): whether their rays end on the way. beam (F, N, N): their light in an evenly lit beam; 0 for
    lost rays, and beyond a fold. keep (n,): of those whose rays are traced, indices into F × N × N; of mirrored
    beams, in one half alone.
    """

    grid: np.ndarray
    places: np.ndarray
    open_: np.ndarray
    lost: np.ndarray
    beam: np.ndarray
    keep: np.ndarray


class Landed(NamedTuple):
    """The object's rays in each wavelength: rows LANDED (9, F, C, N, N), and what RayGrid holds of the same name."""

    rows: np.ndarray
    victim: np.ndarray
    coverage: np.ndarray
    weight: np.ndarray          # open part of the cell of the beam
    open_centre: np.ndarray
    chief: np.ndarray


def trace_cells(beams: FieldBeams, boxes: np.ndarray, pupil: int,
                conditions: Conditions) -> tuple[Cells, Landed, np.ndarray]:
    """Cells of boxes (F, 2, 2) of the open region, the object's rays, and (F,) fields whose light they miss in part.

    The boxes of fields whose light reaches the edge of the rays are widened, in place.
    """
    wide, first = np.zeros(len(boxes), bool), boxes.copy()
    for _ in range(WIDENED + 1):
        pause()
        cells = _cells(beams, boxes, pupil, wide)
        landed = _landed(beams, cells, conditions.wavelengths)
        cut = _cut_off(cells, landed, conditions.primary)
        if not cut.any():
            break
        wide |= cut
        boxes[cut] += WIDER * np.diff(boxes[cut]) * [-1.0, 1.0]
    if wide.any():                                      # wider boxes that did not help: the first cells are the finest
        boxes[cut], wide[cut] = first[cut], False
        _tighten(boxes, wide, landed)
        cells = _cells(beams, boxes, pupil, wide)
        landed = _landed(beams, cells, conditions.wavelengths)
    missed = _folded(cells, landed, conditions.primary) | _elsewhere(beams, cells, landed, conditions.primary)
    return cells, landed, cut | missed


def _cells(beams: FieldBeams, boxes: np.ndarray, pupil: int, wide: np.ndarray) -> Cells:
    """The cells of boxes (F, 2, 2) of the open region, and which of them rays of the object are traced for.

    wide: (F,) fields of which all cells are traced.
    """
    share = (np.arange(pupil) + 0.5) / pupil
    grid = boxes[..., :1] + share * (boxes[..., 1:] - boxes[..., :1])
    if beams.mirrored:
        grid[:, 0] = 0.5 * (grid[:, 0] - grid[:, 0, ::-1])
    s, t = (np.ascontiguousarray(np.broadcast_to(coordinate, (len(grid), pupil, pupil)))
            for coordinate in (grid[:, 0, None, :], grid[:, 1, :, None]))
    places, level = beams.grid_towards_scene(s, t)
    open_ = np.empty((len(grid), 1, pupil, pupil))
    cover(level[:, None], 0, s[:, None], t[:, None], grid, beams.mirrored, open_, np.empty_like(open_),
          np.empty((2, *open_.shape)))
    near = (level <= 1.0 + BEYOND / pupil) | (beams.linear_stop_share(s, t) <= 1.0)
    near[wide] = True
    near &= np.isfinite(places).all(-1)
    if beams.mirrored:
        near[:, :, :pupil // 2] = False
    keep = np.flatnonzero(near.ravel())
    lost = np.isinf(level) | ~np.isfinite(places).all(-1)
    return Cells(grid, places, open_[:, 0], lost, beam_areas(beams, places, level), keep)


def _tighten(boxes: np.ndarray, wide: np.ndarray, landed: Landed) -> None:
    """Narrow the boxes (F, 2, 2) of widened fields to their cells with light, and half a cell more."""
    pupil, light = landed.coverage.shape[-1], (landed.coverage > 0.0) | (landed.weight > 0.0)
    for f in np.flatnonzero(wide):
        for axis in (0, 1):
            lit = np.flatnonzero(light[f].any((0, 1 + axis)))
            if lit.size:
                low, high = boxes[f, axis]
                share = np.clip([lit[0] - 0.5, lit[-1] + 1.5], 0.0, pupil) / pupil
                boxes[f, axis] = low + share * (high - low)


def _cut_off(cells: Cells, landed: Landed, primary: int) -> np.ndarray:
    """(F,) fields whose light reaches cells beside such as no ray was traced for: more of it may lie there.

    Rays of the object at the rim then pass the exit pupil far from where those of the reference point do. Cells whose
    rays miss a surface lie beyond a rim: no light is sought there.
    """
    settled = (landed.victim[:, primary] != -2) | cells.lost
    traced = np.pad(settled, ((0, 0), (1, 1), (1, 1)))
    inner = traced[:, 2:, 1:-1] & traced[:, :-2, 1:-1] & traced[:, 1:-1, 2:] & traced[:, 1:-1, :-2]
    open_ = np.maximum(landed.coverage, landed.weight)[:, primary] > 0.999
    return np.asarray((open_ & ~inner).any((1, 2)))


def _elsewhere(beams: FieldBeams, cells: Cells, landed: Landed, primary: int) -> np.ndarray:
    """(F,) fields whose light also passes apart from the cells: aberrations may turn it back into the stop.

    It is sought by rays of the meridian, across the first surface.
    """
    first, count = beams.lens.surfaces[0], len(beams.axes)
    rim = first.semi_diameter * np.array([-1.0, 1.0])[:, None] * beams.axes[:, None, 1]            # (F, 2, 2)
    points = np.concatenate([rim, np.broadcast_to(first.sag(0.0, first.semi_diameter), (count, 2, 1))], 2)
    along = beams.chief.directions[:, None] + 0.0 * points
    if not isinf(beams.object_distance):
        along = points - np.column_stack([beams.sources, np.full(count, -beams.object_distance)])[:, None]
    ends = beams.across(points.transpose(2, 0, 1), along.transpose(2, 0, 1))
    low, high = ends[:, :1], ends[:, 1:]
    # Parts of the way between both rims: of the lit cells of the middle columns, and of the rays
    middle = slice((landed.victim.shape[3] - 1) // 2, landed.victim.shape[3] // 2 + 1)
    size = ((high - low)**2).sum(2)
    share = ((cells.places[:, :, middle] - low[:, None]) * (high - low)[:, None]).sum(3) / size[:, :, None]
    lit = landed.victim[:, primary, :, middle] == -1
    near, far = (np.where(lit, share, fill).reshape(count, -1) for fill in (inf, -inf))
    sought, apart = np.linspace(0.0, 1.0, SOUGHT), 1.5 / SOUGHT
    out = (sought < near.min(1)[:, None] - apart) | (sought > far.max(1)[:, None] + apart)
    of_field, ray = np.nonzero(out & lit.any((1, 2))[:, None])
    places = low[of_field, 0] + (high - low)[of_field, 0] * sought[ray, None]
    _, victim = beams.forward(beams.wavelength, of_field, beams.starts(of_field, places))
    beyond = np.zeros(count, bool)
    beyond[of_field[victim == -1]] = True
    return beyond


def _folded(cells: Cells, landed: Landed, primary: int) -> np.ndarray:
    """(F,) fields whose light reaches a fold, where neighbouring rays cross in the scene.

    Two rays of the exit pupil then belong to one place of the beam, and places past the fold have none.
    """
    beyond = np.pad((cells.beam == 0.0) & ~cells.lost, ((0, 0), (1, 1), (1, 1)))
    beside = beyond[:, 2:, 1:-1] | beyond[:, :-2, 1:-1] | beyond[:, 1:-1, 2:] | beyond[:, 1:-1, :-2]
    open_ = landed.coverage[:, primary] > 0.999
    return np.asarray((open_ & beside).sum((1, 2)) > FOLDED * np.sqrt(open_.sum((1, 2))))


def _landed(beams: FieldBeams, cells: Cells, wavelengths: tuple[float, ...]) -> Landed:
    """The object's rays through the cells that are kept, forward in each wavelength (µm)."""
    count, pupil = cells.grid.shape[::2]
    of_field = cells.keep // pupil**2
    starts = beams.starts(of_field, cells.places.reshape(-1, 2)[cells.keep])
    shape = count, len(wavelengths), pupil, pupil
    made = Landed(np.empty((LANDED, *shape)), np.empty(shape, np.int16), np.empty(shape), np.empty(shape),
                   np.empty((2, *shape)), np.zeros((count, len(wavelengths), 2)))
    mirrored = beams.mirrored

    def find_chief(c: int) -> None:
        """The chief rays of one wavelength, and the program of its rays."""
        made.chief[:, c] = beams.on_axes(beams.chief_of(wavelengths[c]).images - beams.chief.images)
        beams.forward_program(wavelengths[c])

    def trace(colour_and_fields: tuple[int, slice]) -> None:
        """Fill the arrays of one wavelength for some fields."""
        c, some = colour_and_fields
        rays = slice(*np.searchsorted(of_field, (some.start, some.stop)))
        made.rows[:, some, c], made.victim[some, c] = nan, -2
        landed, victim = beams.forward(wavelengths[c], of_field[rays], starts[:, rays])
        _scatter(landed, victim, cells.keep[rays], c, mirrored, made.rows, made.victim)
        level, own_s, own_t = (made.rows[k, some] for k in (LEVEL, PUPIL_S, PUPIL_T))
        cover(level, c, own_s, own_t, cells.grid[some], mirrored, made.coverage[some], made.weight[some],
              made.open_centre[:, some])

    colours, half = range(len(wavelengths)), count // 2
    parts = [slice(0, count)] if count < MANY else [slice(0, half), slice(half, count)]
    run = each_in_turn if of_field.size * len(wavelengths) < FEW else each_of
    run(find_chief, colours)
    run(trace, [(c, some) for c in colours for some in parts])
    dark = np.broadcast_to((cells.beam == 0.0)[:, None], shape)
    made.coverage[dark], made.weight[dark] = 0.0, 0.0
    return made


@njit(cache=True, nogil=True, error_model="numpy")
def _scatter(landed, victims, keep, c, mirrored, rows, victim):
    """Put the rows (9, n) and victims (n,) of rays into wavelength c of (9, F, C, N, N) and (F, C, N, N).

    keep: (n,) cells of the rays, indices into F × N × N. mirrored: whether a ray counts for its mirror image too.
    """
    columns = rows.shape[4]
    cells = rows.shape[3] * columns
    for k in range(keep.size):
        f, cell = keep[k] // cells, keep[k] % cells
        i, j = cell // columns, cell % columns
        for q in range(rows.shape[0]):
            rows[q, f, c, i, j] = landed[q, k]
        victim[f, c, i, j] = victims[k]
        other = columns - 1 - j
        if mirrored and other != j:
            for q in range(rows.shape[0]):
                sagittal = q == OFFSET_S or q == SLOPE_S or q == PUPIL_S
                rows[q, f, c, i, other] = -landed[q, k] if sagittal else landed[q, k]
            victim[f, c, i, other] = victims[k]
