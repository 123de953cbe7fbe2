"""Disjoint exit-pupil regions: one convex outline around all pieces.

Seen from a point inside, a region is star-shaped, except at the edge of the light of some fisheyes, where it splits. A
camera then samples the convex outline around the pieces: every ray is traced, so the blocked part between the pieces
costs samples but no light. Lens frame, mm.
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.kernels.cache import njit
from lensbench.optics.clearance import ClearanceTracer, clearances
from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens
from lensbench.pupils.rim_solver import REACH, ROUGH, rear_interval, solve_rims

SCAN = 96               # points of the meridian in the search for pieces
CELL_CENTRES = np.arange(SCAN) + 0.5
SCAN_CLOSELY = 256      # points of the meridian in the search for a split, twice
COLUMNS, ROWS = 1024, 160       # of the grid of rays that measures a split region; pieces are narrow across
NEIGHBOURS = 4          # film radii to either side whose regions bound the search


def enclose_disjoint_regions(lens: Lens, film_distance: float, radii: np.ndarray, centres: np.ndarray, rims: np.ndarray,
                             tolerance: float, by: ClearanceTracer, wavelength: float = D_LINE
                             ) -> tuple[np.ndarray, np.ndarray, bool]:
    """Centres (n,) and rims (n, m, 2) of `solve_rims` for rising radii, with outlines around disjoint regions.

    Also returns whether there are any, whose outlines then contain more than light.

    The neighbouring radii get the outline around those pieces and their own region, so that interpolation between the
    radii loses no light.
    """
    pieces = _pieces(lens, film_distance, radii, centres, rims, tolerance, by, wavelength)
    if not pieces:
        return centres, rims, False
    centres, rims = centres.copy(), rims.copy()
    own = {k: pieces.get(k, rims[k] + [centres[k], 0.0]) for k in range(len(radii)) if k in pieces or rims[k].any()}
    for k in own:
        beside = [pieces[j] for j in (k - 1, k + 1) if j in pieces]
        if beside or k in pieces:
            centres[k], rims[k] = _outline(np.concatenate([own[k], *beside]), rims.shape[1])
    return centres, rims, True


def _outline(points: np.ndarray, count: int) -> tuple[float, np.ndarray]:
    """Centre x, and points (count, 2) from there, evenly along the upper half of the hull around points (p, 2)."""
    outline = _upper_hull(points)
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(outline, axis=0).T)))
    wanted = np.linspace(0.0, along[-1], count)
    centre = 0.5 * (outline[0, 0] + outline[-1, 0])
    return centre, np.stack([np.interp(wanted, along, outline[:, 0]) - centre,
                             np.interp(wanted, along, outline[:, 1])], 1)


class SplitRegion(NamedTuple):
    """Region of several pieces, or with a hole: its light, and the convex outline around all of it."""

    area: float                 # mm²
    cos4_area: float            # ∫ cos⁴θ dA, mm²
    centre: float               # x of the outline's middle, mm
    rim: np.ndarray             # (points, 2) of the upper half of the outline, from there, mm


def split_regions(lens: Lens, film_distance: float, radii: np.ndarray, rims: np.ndarray,
                  by: ClearanceTracer) -> dict[int, SplitRegion]:
    """Regions of film radii (n,) whose meridian begins to pass light more than once, by index.

    Also those that pass light where `solve_rims` found none, with rims (n, points, 2) of 0: narrow ones. A grid of rays
    over the lit part of the rear plane measures them; on its lines the edges are interpolated.
    """
    left, right = rear_interval(lens, film_distance, radii)
    k = np.arange(len(radii))                   # radii with light on the meridian
    for _ in range(2):                          # over all of it, then closer about what is lit
        step = (right - left) / SCAN_CLOSELY
        along = left[:, None] + step[:, None] * (np.arange(SCAN_CLOSELY) + 0.5)
        film, zero, out = np.repeat(radii[k], SCAN_CLOSELY), np.zeros(along.size), np.empty(along.size)
        clearances(film, zero, zero, along.ravel(), zero, film_distance, out, by, ROUGH)
        lit = out.reshape(along.shape) <= 1.0
        any_lit = lit.any(1)
        k, lit, step, start = k[any_lit], lit[any_lit], step[any_lit], left[any_lit]
        first, last = lit.argmax(1), SCAN_CLOSELY - 1 - lit[:, ::-1].argmax(1)
        left, right = start + step * (first - 1.0), start + step * (last + 2.0)
    split = (lit[:, 1:] & ~lit[:, :-1]).sum(1) + lit[:, 0] > 1
    found = {}
    for number, a, b, several in zip(k, left, right, split, strict=True):
        if several or not rims[number].any():
            region = _measured(lens, film_distance, radii[number], a, b, rims.shape[1], by)
            if region is not None:
                found[int(number)] = region
    return found


def _measured(lens: Lens, film_distance: float, radius: float, left: float, right: float, points: int,
              by: ClearanceTracer) -> SplitRegion | None:
    """A region that is lit on the meridian from about `left` to `right` (mm); None where the grid meets no light."""
    wide = right - left
    left, right, low, high = left - wide, right + wide, 0.0, REACH * lens.surfaces[-1].semi_diameter
    for _ in range(3):                          # the box of the light, closer each time
        x = np.linspace(left, right, COLUMNS + 1)
        dx, dy = x[1] - x[0], (high - low) / ROWS
        y = low + dy * (np.arange(ROWS) + 0.5)
        level = _levels(radius, x, y, film_distance, by)
        rows, columns = (np.flatnonzero((level <= 1.0).any(axis)) for axis in (1, 0))
        if not len(rows):
            return None
        left, right = x[columns[0]] - 2.0 * dx, x[columns[-1]] + 2.0 * dx
        high = y[rows[-1]] + 2.0 * dy
    # Part of each cell that is lit, from the levels at its ends
    a, b = level[:, :-1], level[:, 1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.nan_to_num((1.0 - np.minimum(a, b)) / np.abs(a - b), nan=0.5)
    share = np.where(np.isfinite(a) & np.isfinite(b), share, 0.5)
    lit = np.where((a <= 1.0) & (b <= 1.0), 1.0, np.where((a <= 1.0) | (b <= 1.0), share, 0.0))
    middle = 0.5 * (x[1:] + x[:-1])
    cos2 = film_distance**2 / (film_distance**2 + (middle - radius) ** 2 + y[:, None] ** 2)
    # Ends of the light on each line
    edges = []
    for j in np.flatnonzero(lit.any(1)):
        first, last = np.flatnonzero(lit[j])[[0, -1]]
        edges += [(x[first + 1] - lit[j, first] * dx, y[j]), (x[last] + lit[j, last] * dx, y[j])]
    centre, rim = _outline(np.array([*edges, (edges[0][0], 0.0), (edges[1][0], 0.0)]), points)
    return SplitRegion(2.0 * dx * dy * float(lit.sum()), 2.0 * dx * dy * float((lit * cos2**2).sum()), centre, rim)


def _levels(radius: float, x: np.ndarray, y: np.ndarray, film_distance: float, by: ClearanceTracer) -> np.ndarray:
    """Clearances (len(y), len(x)) of rays from a film point to the points of a grid on the rear plane."""
    px, py = (values.ravel() for values in np.meshgrid(x, y))
    out, zero = np.empty(px.size), np.zeros(px.size)
    clearances(np.full(px.size, radius), zero, zero, px, py, film_distance, out, by, ROUGH)
    return out.reshape(len(y), len(x))


def _pieces(lens: Lens, film_distance: float, radii: np.ndarray, centres: np.ndarray, rims: np.ndarray,
            tolerance: float, by: ClearanceTracer, wavelength: float) -> dict[int, np.ndarray]:
    """Points (p, 2) on the outermost pieces of each radius whose meridian begins to pass light more than once.

    Where `solve_rims` found no region, once is enough.
    """
    n, lit = len(radii), rims[:, 0, 0] > rims[:, -1, 0]
    low, step = _search_intervals(centres + rims[:, -1, 0], centres + rims[:, 0, 0], lit)
    along, film = (low[:, None] + step[:, None] * CELL_CENTRES).ravel(), np.repeat(radii, SCAN)
    clearance, zero = np.empty(n * SCAN), np.zeros(n * SCAN)
    clearances(film, zero, zero, along, zero, film_distance, clearance, by, ROUGH)
    light = (clearance <= 1.0).reshape(n, SCAN)
    split = (light[:, 1:] & ~light[:, :-1]).sum(1) + light[:, 0] > lit
    # Solve the outermost pieces, each within its own interval
    pieces = {}
    for k in np.flatnonzero(split):
        along = low[k] + step[k] * CELL_CENTRES
        begins = np.diff(light[k], prepend=False) & light[k]
        points = []
        for begin in {np.argmax(begins), SCAN - 1 - np.argmax(begins[::-1])}:
            end = begin + np.append(light[k, begin:], False).argmin()
            span = along[begin] - step[k], along[end - 1] + step[k]
            centre, rim = solve_rims(lens, film_distance, radii[k:k + 1], rims.shape[1], tolerance, wavelength, span,
                                     by)
            points.append(rim[0] + [centre[0], 0.0])
        pieces[int(k)] = np.concatenate(points)
    return pieces


@njit(cache=True, error_model="numpy", nogil=True)
def _search_intervals(left, right, lit):
    """Low end and step (n,) of the search on each meridian, from the regions of this radius and its neighbours."""
    low, step = np.zeros(lit.size), np.zeros(lit.size)
    for k in range(lit.size):
        least, most = math.inf, -math.inf
        for j in range(max(k - NEIGHBOURS, 0), min(k + NEIGHBOURS + 1, lit.size)):
            if lit[j]:
                least, most = min(least, left[j]), max(most, right[j])
        if least < most:
            low[k], step[k] = least, (most - least) / SCAN
    return low, step


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
