"""Solving the whole outline of the exit-pupil region, for film points anywhere and lenses of any symmetry.

As `pupil_rim`, but a region has no axis of symmetry here: its centre is looked for
in both directions of the plane, and its rim all the way around. Lens frame, mm, float64.
"""

import math

import numpy as np

from lensbench.blocktracer import tracer
from lensbench.driver import stage_address
from lensbench.glass import D_LINE
from lensbench.lanes import KEYS, bench
from lensbench.paraxial import first_order
from lensbench.prescription import Lens
from lensbench.pupil_rim import REACH, ROUGH, margins, rims, span

SCAN = 16               # points each way in one look for a region
ZOOMS = 5               # looks, each SCAN / 2 times as fine
ROUGH_POINTS = 16       # of a first rim, which tells where on the rim the others are to be
LOOKS = 128             # directions in which its length is measured


def solve_outlines(lens: Lens, film_distance: float, film_points, points: int, tolerance: float,
                   wavelength: float = D_LINE) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, 2), and (n, points, 2) of each rim seen from them, counter-clockwise from the one in +x, in mm.

    The centre is the centroid; the points are evenly spaced along the rim to about a tenth. A film
    point whose region is empty has all its points at 0. tolerance: of a rim, in mm.
    """
    film = np.ascontiguousarray(np.transpose(np.asarray(film_points, float)))
    n = film.shape[1]
    step = tracer(lens, film_distance, wavelength)
    machine = bench(np.float64), stage_address(step.kernel, np.float64), step.parameters, np.zeros(KEYS, np.uint32)
    rear = lens.surfaces[-1].semi_diameter
    reach, size = REACH * rear, REACH * min(rear, lens.stop.semi_diameter)

    def levels(which: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        out = np.empty(which.size)
        margins(film[0, which], film[1, which], x, y, film_distance, out, which.size, *machine)
        return out

    def solved(centre: np.ndarray, level: np.ndarray, cosine: np.ndarray, sine: np.ndarray, guess: np.ndarray,
               accuracy: float) -> np.ndarray:
        rim = np.zeros(cosine.shape)
        rims(film[0], film[1], np.ascontiguousarray(centre[:, 0]), np.ascontiguousarray(centre[:, 1]), level,
             np.ascontiguousarray(cosine), np.ascontiguousarray(sine), guess, film_distance, reach, accuracy, rim,
             *machine)
        return rim

    # A point in each region: on the paraxial chief ray, or where a scan of the plane finds the least margin
    everywhere = np.arange(n)
    centre = _paraxial_centres(lens, film_distance, film, wavelength)
    level = levels(everywhere, centre[:, 0].copy(), centre[:, 1].copy())
    dark = everywhere[~(level < 1.0)]
    centre[dark], level[dark] = _scanned(lens, film_distance, film, dark, levels)
    lit = level < 1.0

    # A rough rim, and from its centroid the directions of the final one
    turn = 2.0 * math.pi * np.arange(ROUGH_POINTS) / ROUGH_POINTS
    cosine, sine = (np.tile(f(turn), (n, 1)) for f in (np.cos, np.sin))
    begin = np.where(lit, 0.6 * reach * np.maximum(1.0 - level, 1e-3), reach)
    rough = solved(centre, level, cosine, sine, np.tile(begin[:, None], ROUGH_POINTS), ROUGH * size)
    outline = np.stack([rough * cosine, rough * sine], 2)
    moved = centre + _centroids(outline)
    there = levels(everywhere, moved[:, 0].copy(), moved[:, 1].copy())
    better = lit & (there < 1.0)                        # or stay where light is known
    outline += np.where(better[:, None], centre - moved, 0.0)[:, None, :]
    centre, level = np.where(better[:, None], moved, centre), np.where(better, there, level)
    angle, guess = _even_directions(outline, points)
    rim = solved(centre, level, np.cos(angle), np.sin(angle), np.maximum(guess, 1e-3 * tolerance), tolerance)
    centre[~lit] = 0.0
    return centre, np.stack([rim * np.cos(angle), rim * np.sin(angle)], 2)


def _paraxial_centres(lens: Lens, film_distance: float, film: np.ndarray, wavelength: float) -> np.ndarray:
    """(n, 2) where the lines from film points (2, n) to the middle of the paraxial exit pupil cross the rear plane.

    Each section has its own exit pupil.
    """
    centres = []
    for heights, section in zip(film, ("x", "y"), strict=True):
        behind = first_order(lens.section(section), wavelength).exit_pupil.z - lens.length
        toward = film_distance / (film_distance - behind) if behind != film_distance else 0.0
        centres.append(heights * (1.0 - toward))
    return np.stack(centres, 1)


def _scanned(lens: Lens, film_distance: float, film: np.ndarray, which: np.ndarray,
             levels) -> tuple[np.ndarray, np.ndarray]:
    """Points (k, 2) of least root margin for the film points `which`, and that margin: ≥ 1 where no light was found."""
    low, high = np.stack([span(lens, film_distance, heights[which], upright)
                          for heights, upright in ((film[0], False), (film[1], True))], 2)
    centre, level = np.zeros((which.size, 2)), np.full(which.size, np.inf)
    cells = (np.stack(np.meshgrid(np.arange(SCAN), np.arange(SCAN)), 2).reshape(-1, 2) + 0.5) / SCAN
    left = np.arange(which.size)
    for _ in range(ZOOMS):
        if not left.size:
            break
        places = low[left, None, :] + (high - low)[left, None, :] * cells
        found = levels(np.repeat(which[left], len(cells)), places[..., 0].ravel(), places[..., 1].ravel())
        found = np.nan_to_num(found.reshape(left.size, -1), nan=np.inf)
        least = np.argmin(found, 1)
        centre[left] = places[np.arange(left.size), least]
        level[left] = found[np.arange(left.size), least]
        width = (high - low)[left] / SCAN
        low[left], high[left] = centre[left] - width, centre[left] + width
        left = left[~(level[left] < 1.0)]
    return centre, level


def _centroids(outlines: np.ndarray) -> np.ndarray:
    """(n, 2) of polygons (n, m, 2); 0 where one is empty."""
    after = np.roll(outlines, -1, 1)
    cross = outlines[..., 0] * after[..., 1] - outlines[..., 1] * after[..., 0]
    area = cross.sum(1)[:, None]
    moment = (cross[..., None] * (outlines + after)).sum(1) / 3.0
    return np.divide(moment, area, out=np.zeros_like(moment), where=area > 0.0)


def _even_directions(outlines: np.ndarray, points: int) -> tuple[np.ndarray, np.ndarray]:
    """Angles (n, points), from 0, of places evenly spaced along outlines (n, m, 2) about 0, and how far they are."""
    around = 2.0 * math.pi * np.arange(LOOKS + 1) / LOOKS
    angles, sizes = np.zeros((2, len(outlines), points))
    for k, line in enumerate(outlines):
        size = np.interp(around, np.arctan2(line[:, 1], line[:, 0]), np.hypot(line[:, 0], line[:, 1]),
                         period=2.0 * math.pi)
        along = np.append(0.0, np.cumsum(np.hypot(np.diff(size * np.cos(around)), np.diff(size * np.sin(around)))))
        if along[-1] > 0.0:
            angles[k] = np.interp(along[-1] * np.arange(points) / points, along, around)
            sizes[k] = np.interp(angles[k], around, size)
    return angles, sizes
