"""Exit-pupil regions in pieces: one convex outline about all of them.

Seen from a point inside it a region is star-shaped, save at the edge of the light
of some fisheyes, where it splits. A camera then samples the convex outline about
the pieces: every ray is traced, so what is blocked between them costs samples
and no light. Lens frame, mm.
"""

import math

import numpy as np
from numba import njit

from lensbench.optics.clearance import ClearanceTracer, clearances
from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens
from lensbench.pupils.rim_solver import ROUGH, solve_rims

LOOKS = 96              # points of the meridian in the search for pieces
EVENLY = np.arange(LOOKS) + 0.5
NEIGHBOURS = 4          # film radii to either side whose regions say where pieces can be


def enclose_disjoint_regions(lens: Lens, film_distance: float, radii: np.ndarray, centres: np.ndarray, rims: np.ndarray,
             tolerance: float, by: ClearanceTracer, wavelength: float = D_LINE) -> tuple[np.ndarray, np.ndarray]:
    """The centres (n,) and rims (n, m, 2) of `solve_rims` for rising radii, with an outline about regions in pieces.

    The radii beside such a one get the outline about its pieces and their own region, so that no light is
    lost between them.
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

    Or once, where no region had been found.
    """
    n, lit = len(radii), rims[:, 0, 0] > rims[:, -1, 0]
    low, step = _where_light_is(centres + rims[:, -1, 0], centres + rims[:, 0, 0], lit)
    along, film, margin = (low[:, None] + step[:, None] * EVENLY).ravel(), np.repeat(radii, LOOKS), np.empty(n * LOOKS)
    clearances(film, 0.0 * film, along, 0.0 * film, film_distance, margin, by, ROUGH)
    light = (margin <= 1.0).reshape(n, LOOKS)
    split = (light[:, 1:] & ~light[:, :-1]).sum(1) + light[:, 0] > lit
    # Solve the outermost pieces, each from a look at itself alone
    pieces = {}
    for k in np.flatnonzero(split):
        along = low[k] + step[k] * EVENLY
        begins = np.diff(light[k], prepend=False) & light[k]
        points = []
        for begin in {np.argmax(begins), LOOKS - 1 - np.argmax(begins[::-1])}:
            end = begin + np.append(light[k, begin:], False).argmin()
            span = along[begin] - step[k], along[end - 1] + step[k]
            centre, rim = solve_rims(lens, film_distance, radii[k:k + 1], rims.shape[1], tolerance, wavelength, span,
                                     by)
            points.append(rim[0] + [centre[0], 0.0])
        pieces[int(k)] = np.concatenate(points)
    return pieces


@njit(cache=True, error_model="numpy", nogil=True)
def _where_light_is(left, right, lit):
    """Where each meridian (n,) is looked at, for this radius's region or its neighbours': its low end, and the step."""
    low, step = np.zeros(lit.size), np.zeros(lit.size)
    for k in range(lit.size):
        least, most = math.inf, -math.inf
        for j in range(max(k - NEIGHBOURS, 0), min(k + NEIGHBOURS + 1, lit.size)):
            if lit[j]:
                least, most = min(least, left[j]), max(most, right[j])
        if least < most:
            low[k], step[k] = least, (most - least) / LOOKS
    return low, step


def _upper_hull(points: np.ndarray) -> np.ndarray:
    """(q, 2) corners of the upper half of the convex hull of (p, 2) points and their mirror images, from +x to −x."""
    chain: list[np.ndarray] = []
    for point in points[np.lexsort((points[:, 1], -points[:, 0]))]:
        while len(chain) > 1 and np.linalg.det([chain[-1] - chain[-2], point - chain[-2]]) <= 0.0:
            chain.pop()
        chain.append(point)
    return np.array([[chain[0][0], 0.0], *chain, [chain[-1][0], 0.0]])
