"""Irregular exit-pupil regions: those that are not star-shaped, and the convex outline around each.

At the edge of the light of some lenses a hole opens in a region, a piece comes off, or it bends round; a steep asphere
may pass light beyond an edge. A camera then samples the convex outline around all of it: every ray is traced, so the
dark part costs samples but no light. Lens frame, mm.
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.core.kernels.cache import njit
from lensbench.core.optics.block_trace import ClearanceTracer, clearances
from lensbench.core.optics.prescription import Lens
from lensbench.core.pupils.rim_solver import ROUGH, rear_interval

NEIGHBOURS = 4                  # film radii to either side, in the rings of a table, whose regions bound the search
SCAN_CLOSELY = 256              # points of the meridian in the search for narrow regions, twice
WIDER, HIGHER = 0.5, 1.25       # the search beyond the solved rim: × its width on either side, and × its height
MARGIN = 1.0                    # × the mean chord of a rim: distance from it at which light or its absence counts
JUMP, STEEPER = 0.15, 2.5       # least change of width between radii, × the width, and × the changes beside it
DARK, MUCH = 0.05, 0.3          # shares of an outline without light
LOOKS = 10                      # at a region, to find the box of its light


class _Grids(NamedTuple):
    """Numbers of rays across and up of search, look and measurement; enough: rays that contradict a rim."""

    search: tuple[int, int]
    enough: int
    look: tuple[int, int]
    cells: tuple[int, int]


# Pieces are narrow across
MEASURE, ENCLOSE = _Grids((64, 8), 1, (256, 40), (1024, 160)), _Grids((32, 8), 2, (64, 20), (128, 40))
REAR = 96, 24                   # rays across and up in the search of the whole rear opening
CLOSELY = ENCLOSE._replace(search=MEASURE.search, enough=MEASURE.enough)


class IrregularRegion(NamedTuple):
    """A region of several pieces, with a hole, or bent: its light, and the convex outline around all of it."""

    area: float                 # mm²
    cos4_area: float            # ∫ cos⁴θ dA, mm²
    centre: float               # x of the outline's middle, mm
    rim: np.ndarray             # (points, 2) of the upper half of the outline, from there, mm

    @property
    def dark_share(self) -> float:
        """Part of the area within the outline that has no light."""
        x, y = self.rim.T
        return 1.0 - self.area / float((x[:-1] * y[1:] - x[1:] * y[:-1]).sum())


def irregular_regions(lens: Lens, film_distance: float, radii: np.ndarray, centres: np.ndarray, rims: np.ndarray,
                      by: ClearanceTracer) -> dict[int, IrregularRegion]:
    """Those regions of film radii (n,) that the rims (n, points, 2) of `solve_rims` do not describe, by index.

    Also narrow ones, and those off the meridian, where `solve_rims` found no light.
    """
    left, right = rear_interval(lens, film_distance, radii)
    top = rear_interval(lens, film_distance, np.zeros(len(radii)))[1]
    far, light = _searched(film_distance, radii, centres, rims, by, np.stack([left, right, top], 1), REAR)
    boxes = _joined(_search_boxes(centres, rims, 0), light, _boxes_on_meridian(lens, film_distance, radii, by))
    near, _ = _searched(film_distance, radii, centres, rims, by, boxes, MEASURE.search)
    which = np.flatnonzero(far + near >= MEASURE.enough)
    return _measured(film_distance, radii, which, rims.shape[1], by, boxes, MEASURE)


def enclose_irregular_regions(film_distance: float, radii: np.ndarray, centres: np.ndarray, rims: np.ndarray,
                              by: ClearanceTracer) -> tuple[np.ndarray, np.ndarray, bool]:
    """Centres (n,) and rims (n, m, 2) of `solve_rims` for rising radii, with outlines around irregular regions.

    Also whether more than DARK of an outline is without light. The outlines of such a radius and its neighbours, and of
    radii between which the width jumps, hold the regions of each other, so that interpolation loses no light.
    """
    boxes = _search_boxes(centres, rims, NEIGHBOURS)
    irregular = _irregular(film_distance, radii, centres, rims, by, boxes, ENCLOSE)
    more, known = irregular, set(irregular)
    while more:                                 # as closely as may be beside those that are bent most
        near = {j for k, region in more.items() if region.dark_share > MUCH for j in range(k - 2, k + 3)} - known
        known |= near
        beside = np.full_like(boxes, np.nan)
        inside = [k for k in near if 0 <= k < len(radii)]
        beside[inside] = boxes[inside]
        more = _irregular(film_distance, radii, centres, rims, by, beside, CLOSELY)
        irregular |= more
    joined = _jumps(rims[:, 0, 0] - rims[:, -1, 0])
    dark = bool(joined.any()) or any(region.dark_share > DARK for region in irregular.values())
    for k in irregular:
        joined[max(k - 1, 0):k + 1] = True
    if not joined.any():
        return centres, rims, False
    own = {k: rims[k] + [centres[k], 0.0] for k in range(len(radii)) if rims[k].any()}
    own |= {k: region.rim + [region.centre, 0.0] for k, region in irregular.items()}
    centres, rims = centres.copy(), rims.copy()
    for k in own:
        neighbours = [own[j] for j in (k - 1, k + 1) if j in own and joined[min(j, k)]]
        if neighbours or k in irregular:
            centres[k], rims[k] = _outline(np.concatenate([own[k], *neighbours]), rims.shape[1])
    return centres, rims, dark


def _jumps(widths: np.ndarray) -> np.ndarray:
    """Whether the widths (n,) of regions jump from each radius to the next (n − 1,): a piece ends between them."""
    both = (widths[1:] > 0.0) & (widths[:-1] > 0.0)
    change = np.where(both, np.abs(np.diff(widths)), np.inf)
    beside = np.maximum(np.append(change[1:], np.inf), np.append(np.inf, change[:-1]))
    jumps: np.ndarray = both & (change > JUMP * np.maximum(widths[1:], widths[:-1])) & (change > STEEPER * beside)
    return jumps


def _irregular(film_distance: float, radii: np.ndarray, centres: np.ndarray, rims: np.ndarray, by: ClearanceTracer,
           boxes: np.ndarray, grids: _Grids) -> dict[int, IrregularRegion]:
    """The irregular ones among the regions, measured, by index. boxes: (n, 3), as `_search_boxes` returns them."""
    against, _ = _searched(film_distance, radii, centres, rims, by, boxes, grids.search)
    return _measured(film_distance, radii, np.flatnonzero(against >= grids.enough), rims.shape[1], by, boxes, grids)


def _measured(film_distance: float, radii: np.ndarray, which: np.ndarray, points: int, by: ClearanceTracer,
              boxes: np.ndarray, grids: _Grids) -> dict[int, IrregularRegion]:
    """The regions of the radii `which`, those without light left out, with so many points on their rims."""
    regions = {int(k): _measure(film_distance, radii[k], boxes[k], grids, points, by) for k in which}
    return {k: region for k, region in regions.items() if region is not None}


def _searched(film_distance: float, radii: np.ndarray, centres: np.ndarray, rims: np.ndarray, by: ClearanceTracer,
              boxes: np.ndarray, rays: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Numbers (n,) of rays in boxes (n, 3) that contradict the rims, and boxes around the lit ones, NaN without any."""
    across, up = rays
    step = (boxes[:, 1:2] - boxes[:, :1]) / across
    x, y = boxes[:, :1] + step * (np.arange(across) + 0.5), boxes[:, 2:] * np.arange(up) / (up - 1)
    searched = np.flatnonzero(np.isfinite(boxes[:, 0]))
    lit = np.zeros((len(radii), up, across), bool)
    lit[searched] = _levels(radii[searched], x[searched], y[searched], film_distance, by) <= 1.0
    columns, rows = np.asarray(lit.any(1)), np.asarray(lit.any(2))
    k, last = np.arange(len(radii)), up - 1 - rows[:, ::-1].argmax(1)
    light = np.stack([x[k, columns.argmax(1)] - step[:, 0], x[k, across - 1 - columns[:, ::-1].argmax(1)] + step[:, 0],
                      y[k, last] + y[:, 1]], 1)
    light[~columns.any(1)] = np.nan
    return _contradictions(x, y, lit, centres, rims), light


def _joined(*boxes: np.ndarray) -> np.ndarray:
    """The box (n, 3) around several (n, 3), of which NaN are none."""
    low, high, top = np.moveaxis(np.stack(boxes), 2, 0)
    return np.stack([np.fmin.reduce(low), np.fmax.reduce(high), np.fmax.reduce(top)], 1)


@njit(cache=True, error_model="numpy", nogil=True)
def _search_boxes(centres, rims, neighbours):
    """Boxes (n, 3), low and high x and high y, where light can lie near the rims of a radius and its neighbours."""
    n = centres.size
    boxes = np.full((n, 3), math.nan)
    for k in range(n):
        low, high, top = math.inf, -math.inf, 0.0
        for j in range(max(k - neighbours, 0), min(k + neighbours + 1, n)):
            for i in range(rims.shape[1]):
                if rims[j, 0, 0] > rims[j, -1, 0]:
                    low, high = min(low, centres[j] + rims[j, i, 0]), max(high, centres[j] + rims[j, i, 0])
                    top = max(top, rims[j, i, 1])
        if low < high:
            wider = WIDER * (high - low)
            boxes[k, 0], boxes[k, 1], boxes[k, 2] = low - wider, high + wider, HIGHER * top
    return boxes


def _boxes_on_meridian(lens: Lens, film_distance: float, radii: np.ndarray, by: ClearanceTracer) -> np.ndarray:
    """Boxes (n, 3) around the light that a close search of the meridian meets; NaN where it meets none."""
    boxes = np.full((len(radii), 3), np.nan)
    left, right = rear_interval(lens, film_distance, radii)
    k = np.arange(len(radii))                   # radii with light on the meridian
    for _ in range(2):                          # over all of it, then closer about what is lit
        step = (right - left) / SCAN_CLOSELY
        along = left[:, None] + step[:, None] * (np.arange(SCAN_CLOSELY) + 0.5)
        lit = _levels(radii[k], along, np.zeros((len(k), 1)), film_distance, by)[:, 0] <= 1.0
        any_lit = lit.any(1)
        k, lit, step, start = k[any_lit], lit[any_lit], step[any_lit], left[any_lit]
        first, last = lit.argmax(1), SCAN_CLOSELY - 1 - lit[:, ::-1].argmax(1)
        left, right = start + step * (first - 1.0), start + step * (last + 2.0)
    boxes[k] = np.stack([left, right, right - left], 1)
    return boxes


@njit(cache=True, error_model="numpy", nogil=True)
def _contradictions(x, y, lit, centres, rims):
    """Number (n,) of points x (n, columns), y (n, rows) whose light contradicts the rims by MARGIN chords."""
    n, m = rims.shape[:2]
    counts = np.zeros(n, np.int64)
    for k in range(n):
        rim = rims[k]
        chord = 0.0
        for i in range(m - 1):
            chord += math.hypot(rim[i + 1, 0] - rim[i, 0], rim[i + 1, 1] - rim[i, 1]) / (m - 1)
        for row in range(y.shape[1]):
            for column in range(x.shape[1]):
                if chord == 0.0:
                    counts[k] += lit[k, row, column]
                    continue
                px, py = x[k, column] - centres[k], y[k, row]
                first, last = 0, m - 1                          # points of the rim to either side in azimuth
                while last - first > 1:
                    middle = (first + last) // 2
                    if rim[middle, 0] * py - rim[middle, 1] * px >= 0.0:
                        first = middle
                    else:
                        last = middle
                ex, ey = rim[last, 0] - rim[first, 0], rim[last, 1] - rim[first, 1]
                inside = ex * (py - rim[first, 1]) - ey * (px - rim[first, 0])
                far = abs(inside) > MARGIN * chord * math.hypot(ex, ey)
                counts[k] += far and lit[k, row, column] != (inside > 0.0)
    return counts


def _measure(film_distance: float, radius: float, box: np.ndarray, grids: _Grids, points: int,
             by: ClearanceTracer) -> IrregularRegion | None:
    """A region with light in or beside a box (low and high x, high y; mm); None where the grid meets no light."""
    left, right, high = box

    def grid(cells: tuple[int, int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Corners x and middles y of cells in the box, and the clearances there."""
        x = np.linspace(left, right, cells[0] + 1)
        y = high * (np.arange(cells[1]) + 0.5) / cells[1]
        return x, y, _levels(np.array([radius]), x[None], y[None], film_distance, by)[0]

    for _ in range(LOOKS):                      # the box of the light: wider while it ends in light, then closer
        x, y, level = grid(grids.look)
        rows, columns = (np.flatnonzero((level <= 1.0).any(axis)) for axis in (1, 0))
        if not len(rows):
            return None
        width, top, dx, dy = right - left, high, x[1] - x[0], y[1] - y[0]
        cut = columns[0] == 0, columns[-1] == len(x) - 1, rows[-1] == len(y) - 1
        if any(cut):
            left, right, high = left - 0.5 * width * cut[0], right + 0.5 * width * cut[1], high * (1.0 + cut[2])
            continue
        left, right, high = x[columns[0]] - 2.0 * dx, x[columns[-1]] + 2.0 * dx, y[rows[-1]] + 2.0 * dy
        if right - left > 0.8 * width and high > 0.8 * top:
            break
    x, y, level = grid(grids.cells)
    dx, dy = x[1] - x[0], y[1] - y[0]
    # Part of each cell that is lit, from the levels at its ends
    a, b = level[:, :-1], level[:, 1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.nan_to_num((1.0 - np.minimum(a, b)) / np.abs(a - b), nan=0.5)
    share = np.where(np.isfinite(a) & np.isfinite(b), share, 0.5)
    lit = np.where((a <= 1.0) & (b <= 1.0), 1.0, np.where((a <= 1.0) | (b <= 1.0), share, 0.0))
    middle = 0.5 * (x[1:] + x[:-1])
    cos2 = film_distance**2 / (film_distance**2 + (middle - radius) ** 2 + y[:, None] ** 2)
    # An outline that holds the light: its ends on each line, a cell farther out, at the top of its cells
    rows = np.flatnonzero(lit.any(1))
    if not len(rows):
        return None
    first, last = (lit[rows] > 0.0).argmax(1), lit.shape[1] - 1 - (lit[rows, ::-1] > 0.0).argmax(1)
    top, low, far = y[rows] + 0.5 * dy, x[first] - dx, x[last + 1] + dx
    ends = np.concatenate([np.stack([low, top], 1), np.stack([far, top], 1), [[low[0], 0.0], [far[0], 0.0]]])
    centre, rim = _outline(ends, points)
    return IrregularRegion(2.0 * dx * dy * float(lit.sum()), 2.0 * dx * dy * float((lit * cos2**2).sum()), centre, rim)


def _levels(radii: np.ndarray, x: np.ndarray, y: np.ndarray, film_distance: float, by: ClearanceTracer) -> np.ndarray:
    """Clearances (n, rows, columns) of rays from film points to x (n, columns), y (n, rows) on the rear plane."""
    shape = (len(radii), y.shape[1], x.shape[1])
    film, px, py = (np.broadcast_to(values, shape).flatten() for values in
                    (radii[:, None, None], x[:, None], y[:, :, None]))
    out, zero = np.empty(film.size), np.zeros(film.size)
    clearances(film, zero, zero, px, py, film_distance, out, by, ROUGH)
    return out.reshape(shape)


def _outline(points: np.ndarray, count: int) -> tuple[float, np.ndarray]:
    """Centre x, and points (count, 2) from there, evenly along the upper half of the hull around points (p, 2)."""
    outline = _upper_hull(points)
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(outline, axis=0).T)))
    lengths = np.linspace(0.0, along[-1], count)
    centre = 0.5 * (outline[0, 0] + outline[-1, 0])
    return centre, np.stack([np.interp(lengths, along, outline[:, 0]) - centre,
                             np.interp(lengths, along, outline[:, 1])], 1)


def _upper_hull(points: np.ndarray) -> np.ndarray:
    """Corners (q, 2), from +x to −x, of the upper half of the convex hull of points (p, 2) and their mirror images."""
    chain: list[tuple[float, float]] = []
    for x, y in points[np.lexsort((points[:, 1], -points[:, 0]))].tolist():
        while len(chain) > 1:
            (x0, y0), (x1, y1) = chain[-2:]
            if (x1 - x0) * (y - y0) > (y1 - y0) * (x - x0):
                break
            chain.pop()
        chain.append((x, y))
    return np.array([(chain[0][0], 0.0), *chain, (chain[-1][0], 0.0)])
