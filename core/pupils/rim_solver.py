"""Solving the rim of the exit-pupil region.

The region is a set of points of the plane through the last vertex. Seen from a
point inside it is star-shaped, so one radius per direction describes it; by the
lens's rotational symmetry it is solved for film points (+r, 0) only, and for
its upper half, the lower being the mirror image. A point is inside where the
greatest (r / semi-diameter)² along its ray, the *margin*, is at most 1; that
smooth function is what the solver follows to the rim. Lens frame, mm; float64 but for the first looks.
"""

import math
from functools import cache
from typing import Any

import numpy as np
from numba import njit

from lensbench.optics.clearance import ClearanceTracer, clearance_tracer, clearances
from lensbench.optics.glass import D_LINE
from lensbench.optics.paraxial import first_order
from lensbench.optics.prescription import Lens, LensError

REACH = 1.2             # × the rear semi-diameter: how far the region is looked for (rims have sag)
HEIGHTS = 17            # on the last surface, whose shadows on the plane say where the region can be
SCAN = 32               # points along the meridian in one look for the region
ZOOMS = 6               # looks, each SCAN / 2 times as fine
FINE = 256              # points of a look where those have found nothing
STEEP = 0.5             # root margin − 1 beyond which it is not taken at its word
DIGITS = 0.25           # of a tolerance: how large an error its root margins may have
ROUGH, ROUGH_POINTS = 0.004, 17         # how well the first rims are solved (× the stop), and at how many points


@njit(cache=True, error_model="numpy", nogil=True)
def _centres(radii, distance, low, high, guess, centre, level, tracer):
    """Scan the meridian from low to high (radii,), then ever more finely about the point of least margin.

    Until that passes; or about the guess (radii,) where no ray comes through at all. low and high are overwritten.
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
        clearances(film, zero, px, zero, distance, out[:count], tracer, ROUGH)
        at = 0
        for k in range(n):
            if not level[k] < 1.0:
                least = 0
                for j in range(1, SCAN):
                    least = j if out[at + j] < out[at + least] else least
                centre[k], level[k] = px[at + least] if out[at + least] < math.inf else guess[k], out[at + least]
                width = (high[k] - low[k]) / SCAN
                low[k], high[k] = centre[k] - width, centre[k] + width
                at += SCAN


@njit(cache=True, error_model="numpy", nogil=True)
def rim_distances(film_x, film_y, centre_x, centre_y, level, cosine, sine, guess, distance, reach, tolerance, rim,
                  tracer, accuracy):
    """Distance from each centre to the rim of its region in each direction: rim (film points, directions).

    A bracketed secant (Illinois) on root margin − 1, which is nearly linear up
    to STEEP; beyond, and where a ray is no number, that value stands for it.
    """
    m = cosine.shape[1]
    size = film_x.size * m
    from_x, from_y, px, py, out = np.empty(size), np.empty(size), np.empty(size), np.empty(size), np.empty(size)
    which, waiting, of = np.empty(size, np.int64), np.empty(size, np.int64), np.empty(size, np.int64)
    inner, f_inner = np.zeros(size), np.empty(size)
    outer, f_outer = np.full(size, math.inf), np.full(size, math.inf)
    trial, side, turn_x, turn_y, found = guess.ravel(), np.zeros(size), cosine.ravel(), sine.ravel(), rim.ravel()
    count = 0
    for k in range(film_x.size):
        for i in range(k * m, k * m + m):
            of[i], f_inner[i], found[i] = k, level[k] - 1.0, 0.0
            if level[k] < 1.0:
                which[count] = i
                count += 1
    for _ in range(100):
        if count == 0:
            return
        for q in range(count):
            i = which[q]
            k, x = of[i], trial[i]
            from_x[q], from_y[q] = film_x[k], film_y[k]
            px[q], py[q] = centre_x[k] + x * turn_x[i], centre_y[k] + x * turn_y[i]
        clearances(from_x, from_y, px, py, distance, out[:count], tracer, accuracy)
        left = 0
        for q in range(count):
            i = which[q]
            x, f = trial[i], out[q] - 1.0
            slope = (f - f_inner[i]) / (x - inner[i]) if x > inner[i] else 0.0
            # Keep the bracket, and halve the value at an end that stays for the second time.
            if f <= 0.0:
                inner[i], f_inner[i] = x, f
                f_outer[i] *= 0.5 if side[i] == 1.0 else 1.0
                side[i] = 1.0
            else:
                outer[i], f_outer[i] = x, min(f, STEEP)
                f_inner[i] *= 0.5 if side[i] == -1.0 else 1.0
                side[i] = -1.0
            # Where to look next.
            if outer[i] == math.inf:
                ahead = -f / slope if slope > 0.0 else x
                x_next = x + max(min(ahead * 1.02, x), tolerance)
            else:
                x_next = inner[i] - f_inner[i] * (outer[i] - inner[i]) / (f_outer[i] - f_inner[i])
            trial[i] = found[i] = x_next
            done = outer[i] < math.inf and abs(x_next - x) <= tolerance
            if not done and x_next < 3.0 * reach:
                waiting[left] = i
                left += 1
        which, waiting = waiting, which
        count = left


def find_interior_points(radii: np.ndarray, distance: float, low: np.ndarray, high: np.ndarray, aimed: np.ndarray,
           tracer: ClearanceTracer) -> tuple[np.ndarray, np.ndarray]:
    """For each film radius a point (centre, 0) well inside its region, and its root margin, ≥ 1: none found.

    low, high: where the meridian is seen; aimed: at the paraxial exit pupil. What is dark nearer to the axis than
    others that are lit, or where none is, is looked for more closely.
    """
    centre, level = np.empty(len(radii)), np.empty(len(radii))
    _centres(radii, distance, low.copy(), high.copy(), aimed, centre, level, tracer)
    dark = np.flatnonzero(~(level < 1.0))
    if 0 < dark.size < len(radii):
        dark = dark[radii[dark] < radii[level < 1.0].max()]
    for k in dark:
        centre[k], level[k] = _found_elsewhere(radii[k], distance, low[k], high[k], tracer)
    return centre, level


def _found_elsewhere(radius: float, distance: float, low: float, high: float,
                     tracer: ClearanceTracer) -> tuple[float, float]:
    """As `find_interior_points` for one film radius, about every least margin of a finer scan.

    Where the stop's image folds over, a coarse scan may follow the wrong one.
    """
    zero, width = np.zeros(FINE), (high - low) / FINE
    px, out = low + width * (np.arange(FINE) + 0.5), np.empty(FINE)
    clearances(np.full(FINE, radius), zero, px, zero, distance, out, tracer, ROUGH)
    least = (out[1:-1] < math.inf) & (out[1:-1] <= out[:-2]) & (out[1:-1] <= out[2:])
    centre, level = np.empty(1), np.empty(1)
    for best in px[1:-1][least]:
        at = np.array([best])
        _centres(np.array([radius]), distance, at - width, at + width, at, centre, level, tracer)
        if level[0] < 1.0:
            return float(centre[0]), float(level[0])
    return 0.0, math.inf


@njit(cache=True, error_model="numpy", nogil=True)
def _centroids(centre, rough, cosine, sine):
    """(n,) on the meridian, by symmetry, of regions whose rims are `rough` (n, m) from the centre."""
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
    """The directions of points evenly spaced along rough rims, and where to begin along them, no nearer than `least`.

    moved: by how much the centre of the rims is to lie to the left of that of the directions.
    """
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
    """From where to where in x a film point of each height x can see the last surface through its vertex's plane.

    (n,) and (n,) mm; upright: all in y. Widened by REACH, but no further than the solver looks.
    """
    return project_rear_rim(np.ascontiguousarray(heights), *rear_rim(lens, film_distance, upright))


def rear_rim(lens: Lens, film_distance: float, upright: bool = False) -> tuple[np.ndarray, np.ndarray, float]:
    """What `shadows` reads of the last surface: heights on it, by how much a film point there is nearer; and the limit.

    Seen at a steep angle, a rim that lies before or behind the vertex's plane falls far beside its own height.
    """
    surface = lens.surfaces[-1]
    a = surface.semi_diameter
    rim = np.linspace(-a, a, HEIGHTS)
    sag = surface.sag(0.0, rim) if upright else surface.sag(rim)
    rim, sag = rim[np.isfinite(sag)], sag[np.isfinite(sag)]
    return rim, film_distance / np.maximum(film_distance - sag, 0.1 * film_distance), 3.0 * REACH * a


@njit(cache=True, error_model="numpy", nogil=True)
def project_rear_rim(heights, rim, share, furthest):
    """As `rear_interval`, of what `rear_rim` gives."""
    low, high = np.empty(heights.size), np.empty(heights.size)
    for k in range(heights.size):
        least, most = math.inf, -math.inf
        for j in range(rim.size):
            seen = heights[k] * (1.0 - share[j]) + rim[j] * share[j]
            least, most = min(least, seen), max(most, seen)
        middle, half, limit = 0.5 * (most + least), 0.5 * REACH * (most - least), max(furthest, heights[k])
        low[k], high[k] = max(middle - half, -limit), min(middle + half, limit)
    return low, high


def solve_rims(lens: Lens, film_distance: float, film_radii, points: int, tolerance: float, wavelength: float = D_LINE,
          within: tuple[Any, Any] | None = None, by: ClearanceTracer | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n,) on the meridian, and (n, points, 2) of the upper half of each rim seen from them, in mm.

    From the furthest point in +x to that in −x, evenly spaced to about a
    twentieth. A radius whose region is empty has all its points at 0.
    tolerance: of a rim, in mm. within: from where to where on the meridian to look for the regions (mm, of all radii or
    of each), if not wherever they can be. by: what traces this lens, where that is at hand. LensError for a lens with
    a cylinder or toroid.
    """
    if not lens.is_rotationally_symmetric:
        raise LensError("a lens with a cylinder or toroid has no exit pupil by film radius: "
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

    # A rough rim from a first centre gives the centroid, if that is in the region; on the axis it is known
    turn_x, turn_y = _half_turn()
    rough, start = np.zeros((n, ROUGH_POINTS)), np.repeat(0.6 * reach * (1.0 - level), ROUGH_POINTS)
    cosine, sine = np.tile(turn_x, (n, 1)), np.tile(turn_y, (n, 1))
    rim_distances(radii, zero, centre, zero, level, cosine, sine, start.reshape(n, ROUGH_POINTS), film_distance, reach,
         ROUGH * size, rough, by, ROUGH)
    middle, there = np.where(radii > 0.0, _centroids(centre, rough, turn_x, turn_y), 0.0), np.empty(n)
    clearances(radii, zero, middle, zero, film_distance, there, by, 0.0)
    inside = lit & (there < 1.0)
    middle, level = np.where(inside, middle, centre), np.where(inside, there, level)

    # Directions from there that are evenly spaced along the rim, so that the tips of a cat's eye are met
    cosine, sine, guess, rim = (np.zeros((n, points)) for _ in range(4))
    _directions(middle - centre, rough, turn_x, turn_y, 1e-3 * tolerance, cosine, sine, guess)
    rim_distances(radii, zero, middle, zero, level, cosine, sine, guess, film_distance, reach, tolerance, rim, by,
         DIGITS * tolerance / size)
    middle[~lit] = 0.0
    return middle, np.stack([rim * cosine, rim * sine], 2)


@cache
def _half_turn() -> tuple[np.ndarray, np.ndarray]:
    """The directions of a rough rim: cosines and sines (ROUGH_POINTS,)."""
    angle = math.pi * np.arange(ROUGH_POINTS) / (ROUGH_POINTS - 1)
    sine = np.sin(angle)
    sine[-1] = 0.0
    return np.cos(angle), sine


def region_scale(lens: Lens, film_distance: float, wavelength: float = D_LINE) -> float:
    """What regions are at most about as large as, mm: the last surface, the stop, or the cone of light on its way.

    That of a lens without an f-number, afocal (inf) or telecentric towards the scene (0), counts as endless.
    """
    f_number = first_order(lens, wavelength).f_number
    cone = 0.5 / f_number if 0.0 < f_number < math.inf else math.inf
    return REACH * min(lens.surfaces[-1].semi_diameter, lens.stop.semi_diameter, film_distance * cone)


def paraxial_centre_ratio(lens: Lens, film_distance: float, wavelength: float = D_LINE) -> float:
    """Where on the plane of the last vertex a film point sees the paraxial exit pupil: this times its own x."""
    ahead = lens.length + film_distance - first_order(lens, wavelength).exit_pupil.z
    return 1.0 - film_distance / ahead if ahead else 1.0
