"""Rim of the exit-pupil region of a rotationally symmetric lens, for film points (+r, 0).

The region lies on the plane of the last vertex. Seen from a point inside it is star-shaped: one distance per direction
describes it, and the lower half is the mirror image. A point is inside where the clearance of its ray is at most 1; the
solver follows this smooth function to the rim. Lens frame, mm; float64 but for the first scans.
"""

import math
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.kernels.cache import njit
from lensbench.core.optics.block_trace import ClearanceTracer, clearance_tracer, clearances
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens

REACH = 1.2             # × the rear semi-diameter: extent of the search (rims have sag)
HEIGHTS = 17            # on the last surface, whose projections on the plane bound the search
SCAN = 32               # points along the meridian in one scan for the region
ZOOMS = 6               # scans, each SCAN / 2 times as fine
FINE = 256              # points of a scan after those have found nothing
STEEP = 0.5             # largest clearance − 1 that the secant uses
DIGITS = 0.25           # error of clearances, as a share of the tolerance
ROUGH, ROUGH_POINTS = 0.004, 17         # tolerance of the rough rims (× the stop), and points on them


@njit(cache=True, error_model="numpy", nogil=True)
def _centres(radii, distance, low, high, guess, centre, level, tracer):
    """Find points inside the regions: centre (radii,) on the meridian, and level (radii,), its clearance.

    Scans from low to high (radii,), which it overwrites, then ever more finely about the point of least clearance,
    until it passes, or about the guess (radii,) where no ray comes through.
    """
    n = radii.size
    level[:] = math.inf
    film, px, out, zero = np.empty(n * SCAN), np.empty(n * SCAN), np.empty(n * SCAN), np.zeros(n * SCAN)
    for _ in range(ZOOMS):
        count = 0
        for k in range(n):
            if not level[k] < 1.0:
                for j in range(SCAN):
                    film[count] = radii[k]
                    px[count] = low[k] + (high[k] - low[k]) * (j + 0.5) / SCAN
                    count += 1
        if count == 0:
            return
        clearances(film, zero, zero, px, zero, distance, out[:count], tracer, ROUGH)
        first = 0
        for k in range(n):
            if not level[k] < 1.0:
                least = 0
                for j in range(1, SCAN):
                    least = j if out[first + j] < out[first + least] else least
                level[k] = out[first + least]
                centre[k] = px[first + least] if level[k] < math.inf else guess[k]
                width = (high[k] - low[k]) / SCAN
                low[k], high[k] = centre[k] - width, centre[k] + width
                first += SCAN


@njit(cache=True, error_model="numpy", nogil=True)
def rim_distances(film_x, film_y, film_z, centre_x, centre_y, level, cosine, sine, guess, distance, reach, tolerance,
                  rim, tracer, accuracy):
    """Distances rim (film points, directions) from each centre to the rim of its region.

    film_x … level: (film points,), the latter the clearance at the centre. cosine, sine, guess: (film points,
    directions). A bracketed secant, Illinois form, solves clearance − 1 = 0, values beyond STEEP replaced by it.
    """
    m = cosine.shape[1]
    size = film_x.size * m
    from_x, from_y, from_z = np.empty(size), np.empty(size), np.empty(size)
    px, py, out = np.empty(size), np.empty(size), np.empty(size)
    which, waiting, of = np.empty(size, np.int64), np.empty(size, np.int64), np.empty(size, np.int64)
    inner, f_inner = np.zeros(size), np.empty(size)
    outer, f_outer = np.full(size, math.inf), np.full(size, math.inf)
    trial, side, turn_x, turn_y, distances = guess.ravel(), np.zeros(size), cosine.ravel(), sine.ravel(), rim.ravel()
    count = 0
    for k in range(film_x.size):
        for i in range(k * m, k * m + m):
            of[i], f_inner[i], distances[i] = k, level[k] - 1.0, 0.0
            if level[k] < 1.0:
                which[count] = i
                count += 1
    for _ in range(100):
        if count == 0:
            return
        for q in range(count):
            i = which[q]
            k, x = of[i], trial[i]
            from_x[q], from_y[q], from_z[q] = film_x[k], film_y[k], film_z[k]
            px[q], py[q] = centre_x[k] + x * turn_x[i], centre_y[k] + x * turn_y[i]
        clearances(from_x, from_y, from_z, px, py, distance, out[:count], tracer, accuracy)
        left = 0
        for q in range(count):
            i = which[q]
            x, f = trial[i], out[q] - 1.0
            slope = (f - f_inner[i]) / (x - inner[i]) if x > inner[i] else 0.0
            # Keep the bracket, and halve the value at an end that stays for the second time
            if f <= 0.0:
                inner[i], f_inner[i] = x, f
                f_outer[i] *= 0.5 if side[i] == 1.0 else 1.0
                side[i] = 1.0
            else:
                outer[i], f_outer[i] = x, min(f, STEEP)
                f_inner[i] *= 0.5 if side[i] == -1.0 else 1.0
                side[i] = -1.0
            # Step outwards until the rim is bracketed, then by the secant
            if outer[i] == math.inf:
                ahead = -f / slope if slope > 0.0 else x
                x_next = x + max(min(ahead * 1.02, x), tolerance)
            else:
                x_next = inner[i] - f_inner[i] * (outer[i] - inner[i]) / (f_outer[i] - f_inner[i])
            trial[i] = distances[i] = x_next
            done = outer[i] < math.inf and abs(x_next - x) <= tolerance
            if not done and x_next < 3.0 * reach:
                waiting[left] = i
                left += 1
        which, waiting = waiting, which
        count = left


def find_interior_points(radii: np.ndarray, distance: float, low: np.ndarray, high: np.ndarray, guess: np.ndarray,
           tracer: ClearanceTracer) -> tuple[np.ndarray, np.ndarray]:
    """Points (centre, 0) well inside the regions of film radii, and their clearances; ≥ 1 where none was found.

    low, high: ends of the search on the meridian; guess: centre of the paraxial exit pupil there.
    """
    centre, level = np.empty(len(radii)), np.empty(len(radii))
    _centres(radii, distance, low.copy(), high.copy(), guess, centre, level, tracer)
    dark = np.flatnonzero(~(level < 1.0))
    if 0 < dark.size < len(radii):
        dark = dark[radii[dark] < radii[level < 1.0].max()]
    for k in dark:
        centre[k], level[k] = _found_elsewhere(radii[k], distance, low[k], high[k], tracer)
    return centre, level


def _found_elsewhere(radius: float, distance: float, low: float, high: float,
                     tracer: ClearanceTracer) -> tuple[float, float]:
    """Centre and clearance for one film radius, about every local minimum of a finer scan, for images may fold over."""
    zero, width = np.zeros(FINE), (high - low) / FINE
    px, out = low + width * (np.arange(FINE) + 0.5), np.empty(FINE)
    clearances(np.full(FINE, radius), zero, zero, px, zero, distance, out, tracer, ROUGH)
    least = (out[1:-1] < math.inf) & (out[1:-1] <= out[:-2]) & (out[1:-1] <= out[2:])
    centre, level = np.empty(1), np.empty(1)
    for best in px[1:-1][least]:
        start = np.array([best])
        _centres(np.array([radius]), distance, start - width, start + width, start, centre, level, tracer)
        if level[0] < 1.0:
            return float(centre[0]), float(level[0])
    return 0.0, math.inf


@njit(cache=True, error_model="numpy", nogil=True)
def _centroids(centre, rough, cosine, sine):
    """Centroids (n,), on the meridian by symmetry, of regions with rims at the distances `rough` (n, m)."""
    out = centre.copy()
    for k in range(centre.size):
        area, moment = 0.0, 0.0
        for j in range(cosine.size - 1):
            x0, y0 = rough[k, j] * cosine[j], rough[k, j] * sine[j]
            x1, y1 = rough[k, j + 1] * cosine[j + 1], rough[k, j + 1] * sine[j + 1]
            cross = x0 * y1 - x1 * y0
            area += cross
            moment += cross * (x0 + x1) / 3.0
        out[k] += moment / area if area > 0.0 else 0.0
    return out


@njit(cache=True, error_model="numpy", nogil=True)
def _directions(moved, rough, turn_x, turn_y, least, cosine, sine, guess):
    """Write cosine, sine, guess (n, m): points evenly along rough rims, seen from centres `moved` (n,) mm in +x."""
    n, m = cosine.shape
    last = turn_x.size - 1
    x, y, along = np.empty(last + 1), np.empty(last + 1), np.zeros(last + 1)
    for k in range(n):
        for j in range(last + 1):
            x[j], y[j] = rough[k, j] * turn_x[j] - moved[k], rough[k, j] * turn_y[j]
        for j in range(1, last + 1):
            along[j] = along[j - 1] + math.sqrt((x[j] - x[j - 1]) ** 2 + (y[j] - y[j - 1]) ** 2)
        chord = 0
        for j in range(m):
            target = along[last] * j / (m - 1)
            while chord < last - 1 and along[chord + 1] < target:
                chord += 1
            width = along[chord + 1] - along[chord]
            f = (target - along[chord]) / width if width > 0.0 else 0.0
            px, py = x[chord] + f * (x[chord + 1] - x[chord]), y[chord] + f * (y[chord + 1] - y[chord])
            guess[k, j] = max(math.sqrt(px * px + py * py), least)
            cosine[k, j], sine[k, j] = px / guess[k, j], py / guess[k, j]
        cosine[k, 0], sine[k, 0], cosine[k, m - 1], sine[k, m - 1] = 1.0, 0.0, -1.0, 0.0


def rear_interval(lens: Lens, film_distance: float, heights: np.ndarray,
                  upright: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Interval in x, (n,) and (n,) mm, on the plane of the last vertex in which film points at x (n,) see the last
    surface.

    upright: along y instead. Widened by REACH, within the solver's limit.
    """
    return project_rear_rim(np.ascontiguousarray(heights), *rear_rim(lens, film_distance, upright))


def rear_rim(lens: Lens, film_distance: float, upright: bool = False) -> tuple[np.ndarray, np.ndarray, float]:
    """Heights (mm) on the last surface, film distance over their distance to the film, and the search limit (mm)."""
    surface = lens.surfaces[-1]
    a = surface.semi_diameter
    rim = np.linspace(-a, a, HEIGHTS)
    sag = surface.sag(0.0, rim) if upright else surface.sag(rim)
    rim, sag = rim[np.isfinite(sag)], sag[np.isfinite(sag)]
    return rim, film_distance / np.maximum(film_distance - sag, 0.1 * film_distance), 3.0 * REACH * a


@njit(cache=True, error_model="numpy", nogil=True)
def project_rear_rim(heights, rim, share, furthest):
    """`rear_interval` from the values of `rear_rim`."""
    low, high = np.empty(heights.size), np.empty(heights.size)
    for k in range(heights.size):
        least, most = math.inf, -math.inf
        for j in range(rim.size):
            projected = heights[k] * (1.0 - share[j]) + rim[j] * share[j]
            least, most = min(least, projected), max(most, projected)
        middle, half, limit = 0.5 * (most + least), 0.5 * REACH * (most - least), max(furthest, heights[k])
        low[k], high[k] = max(middle - half, -limit), min(middle + half, limit)
    return low, high


def solve_rims(lens: Lens, film_distance: float, film_radii: ArrayLike, points: int, tolerance: float,
               wavelength: float = D_LINE, within: tuple[Any, Any] | None = None, by: ClearanceTracer | None = None
              ) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n,) on the meridian, and points (n, points, 2) of the upper half of each rim from its centre, in mm.

    From the farthest in +x to that in −x, evenly spaced to about a twentieth; 0 for an empty region. tolerance: of the
    rims (mm). within: ends of the search on the meridian (mm); by: tracer of this lens, if one exists already.
    LensError for a lens without rotational symmetry.
    """
    if not lens.is_rotationally_symmetric:
        raise LensError(f"a lens with {lens.asymmetry} has no exit pupil by film radius: "
                        "lb.open_region has it for film points")
    by = by or clearance_tracer(lens, film_distance, wavelength)
    radii = np.ascontiguousarray(film_radii, float)
    n, zero = radii.size, np.zeros(radii.size)
    reach = REACH * lens.surfaces[-1].semi_diameter
    size = region_scale(lens, film_distance, wavelength)
    low, high = rear_interval(lens, film_distance, radii) if within is None else (np.full(n, x) for x in within)
    guess = radii * paraxial_centre_ratio(lens, film_distance, wavelength)
    centre, level = find_interior_points(radii, film_distance, low, high, guess, by)
    lit = level < 1.0

    # Rough rims from the first centres, and their centroids; one outside its region is not used
    turn_x, turn_y = _half_turn()
    rough, start = np.zeros((n, ROUGH_POINTS)), np.repeat(0.6 * reach * (1.0 - level), ROUGH_POINTS)
    cosine, sine = np.tile(turn_x, (n, 1)), np.tile(turn_y, (n, 1))
    rim_distances(radii, zero, zero, centre, zero, level, cosine, sine, start.reshape(n, ROUGH_POINTS), film_distance,
         reach, ROUGH * size, rough, by, ROUGH)
    middle, there = np.where(radii > 0.0, _centroids(centre, rough, turn_x, turn_y), 0.0), np.empty(n)
    clearances(radii, zero, zero, middle, zero, film_distance, there, by, 0.0)
    inside = lit & (there < 1.0)
    middle, level = np.where(inside, middle, centre), np.where(inside, there, level)

    # Final rims, in directions evenly spaced along the rough ones so as to resolve the tips of a cat's eye
    cosine, sine, guess, rim = (np.zeros((n, points)) for _ in range(4))
    _directions(middle - centre, rough, turn_x, turn_y, 1e-3 * tolerance, cosine, sine, guess)
    rim_distances(radii, zero, zero, middle, zero, level, cosine, sine, guess, film_distance, reach, tolerance, rim,
         by, DIGITS * tolerance / size)
    middle[~lit] = 0.0
    return middle, np.stack([rim * cosine, rim * sine], 2)


@cache
def _half_turn() -> tuple[np.ndarray, np.ndarray]:
    """Directions of a rough rim: cosines and sines (ROUGH_POINTS,)."""
    angle = math.pi * np.arange(ROUGH_POINTS) / (ROUGH_POINTS - 1)
    sine = np.sin(angle)
    sine[-1] = 0.0
    return np.cos(angle), sine


def region_scale(lens: Lens, film_distance: float, wavelength: float = D_LINE) -> float:
    """Rough upper bound (mm) of the regions' size: the last surface, the stop, or the width of the cone of light."""
    f_number = first_order(lens, wavelength).f_number
    cone = 0.5 / f_number if 0.0 < f_number < math.inf else math.inf
    return REACH * min(lens.surfaces[-1].semi_diameter, lens.stop.semi_diameter, film_distance * cone)


def paraxial_centre_ratio(lens: Lens, film_distance: float, wavelength: float = D_LINE) -> float:
    """Ratio of the x where a film point sees the centre of the paraxial exit pupil, on the rear plane, to its own x."""
    ahead = lens.length + film_distance - first_order(lens, wavelength).exit_pupil.z
    return 1.0 - film_distance / ahead if ahead else 1.0
