"""Cells of the exit pupil of a ray grid, found from the film, and the object's rays through them in each wavelength.

Lengths in mm, lens frame. F fields, C wavelengths, N × N cells of a field. See `traced_grid` for the reference points,
axes and pupil coordinates.
"""

from math import inf, isinf, nan
from typing import NamedTuple

import numpy as np

from lensbench.analysis.grids.beam_areas import beam_areas
from lensbench.analysis.grids.cell_coverage import cover
from lensbench.analysis.grids.field_beams import LANDED, LEVEL, OFFSET_S, PUPIL_S, PUPIL_T, SLOPE_S, FieldBeams
from lensbench.analysis.grids.field_conditions import Conditions
from lensbench.analysis.grids.field_threads import each_in_turn, each_of
from lensbench.kernels.cache import njit
from lensbench.kernels.pauses import pause

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
    s, t = (np.ascontiguousarray(np.broadcast_to(each, (len(grid), pupil, pupil)))
            for each in (grid[:, 0, None, :], grid[:, 1, :, None]))
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
    found = np.zeros(count, bool)
    found[of_field[victim == -1]] = True
    return found


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

    def trace(at: tuple[int, slice]) -> None:
        """Fill the arrays of one wavelength for some fields."""
        c, some = at
        part = slice(*np.searchsorted(of_field, (some.start, some.stop)))
        made.rows[:, some, c], made.victim[some, c] = nan, -2
        landed, victim = beams.forward(wavelengths[c], of_field[part], starts[:, part])
        _scatter(landed, victim, cells.keep[part], c, mirrored, made.rows, made.victim)
        level, own_s, own_t = (made.rows[k, some] for k in (LEVEL, PUPIL_S, PUPIL_T))
        cover(level, c, own_s, own_t, cells.grid[some], mirrored, made.coverage[some], made.weight[some],
              made.open_centre[:, some])

    colours, half = range(len(wavelengths)), count // 2
    parts = [slice(0, count)] if count < MANY else [slice(0, half), slice(half, count)]
    each = each_in_turn if of_field.size * len(wavelengths) < FEW else each_of
    each(find_chief, colours)
    each(trace, [(c, some) for c in colours for some in parts])
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
