"""Disjoint exit-pupil regions: one convex outline around all pieces.

Seen from a point inside, a region is star-shaped, except at the edge of the light of some fisheyes, where it splits. A
camera then samples the convex outline around the pieces: every ray is traced, so the blocked part between the pieces
costs samples but no light. Lens frame, mm.
"""

import math

import numpy as np

from lensbench.kernels.cache import njit
from lensbench.optics.clearance import ClearanceTracer, clearances
from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens
from lensbench.pupils.rim_solver import ROUGH, solve_rims

SCAN = 96               # points of the meridian in the search for pieces
CELL_CENTRES = np.arange(SCAN) + 0.5
NEIGHBOURS = 4          # film radii to either side whose regions bound the search


def enclose_disjoint_regions(lens: Lens, film_distance: float, radii: np.ndarray, centres: np.ndarray, rims: np.ndarray,
             tolerance: float, by: ClearanceTracer, wavelength: float = D_LINE) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n,) and rims (n, m, 2) of `solve_rims` for rising radii, with outlines around disjoint regions.

    The neighbouring radii get the outline around those pieces and their own region, so that interpolation between the
    radii loses no light.
    """
    pieces = _pieces(lens, film_distance, radii, centres, rims, tolerance, by, wavelength)
    if not pieces:
        return centres, rims
    centres, rims = centres.copy(), rims.copy()
    own = {k: pieces.get(k, rims[k] + [centres[k], 0.0]) for k in range(len(radii)) if k in pieces or rims[k].any()}
    for k in own:
        beside = [pieces[j] for j in (k - 1, k + 1) if j in pieces]
        if beside or k in pieces:
            outline = _upper_hull(np.concatenate([own[k], *beside]))
            along = np.append(0.0, np.cumsum(np.hypot(*np.diff(outline, axis=0).T)))
            wanted = np.linspace(0.0, along[-1], rims.shape[1])
            centres[k] = 0.5 * (outline[0, 0] + outline[-1, 0])
            rims[k, :, 0] = np.interp(wanted, along, outline[:, 0]) - centres[k]
            rims[k, :, 1] = np.interp(wanted, along, outline[:, 1])
    return centres, rims


def _pieces(lens: Lens, film_distance: float, radii: np.ndarray, centres: np.ndarray, rims: np.ndarray,
            tolerance: float, by: ClearanceTracer, wavelength: float) -> dict[int, np.ndarray]:
    """Points (p, 2) on the outermost pieces of each radius whose meridian begins to pass light more than once.

    Where `solve_rims` found no region, once is enough.
    """
    n, lit = len(radii), rims[:, 0, 0] > rims[:, -1, 0]
    low, step = _search_intervals(centres + rims[:, -1, 0], centres + rims[:, 0, 0], lit)
    along, film = (low[:, None] + step[:, None] * CELL_CENTRES).ravel(), np.repeat(radii, SCAN)
    clearance = np.empty(n * SCAN)
    clearances(film, 0.0 * film, along, 0.0 * film, film_distance, clearance, by, ROUGH)
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
    chain: list[np.ndarray] = []
    for point in points[np.lexsort((points[:, 1], -points[:, 0]))]:
        while len(chain) > 1 and np.linalg.det([chain[-1] - chain[-2], point - chain[-2]]) <= 0.0:
            chain.pop()
        chain.append(point)
    return np.array([[chain[0][0], 0.0], *chain, [chain[-1][0], 0.0]])
