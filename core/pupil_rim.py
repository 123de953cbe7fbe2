"""Solving the rim of the exit-pupil region.

The region is a set of points of the plane through the last vertex. Seen from a
point inside it is star-shaped, so one radius per direction describes it; by the
lens's rotational symmetry it is solved for film points (+r, 0) only, and for
its upper half, the lower being the mirror image. A point is inside where the
greatest (r / semi-diameter)² along its ray, the *margin*, is at most 1; that
smooth function is what the solver follows to the rim. Lens frame, mm, float64.
"""

import math

import numpy as np
from numba import njit

from lensbench.blocktracer import tracer
from lensbench.driver import call_stage, stage_address
from lensbench.glass import D_LINE
from lensbench.lanes import KEYS, MARGIN, PITCH, B, L, M, N, X, Y, Z, bench
from lensbench.paraxial import first_order
from lensbench.prescription import Lens, LensError

REACH = 1.2             # × the rear semi-diameter: how far the region is looked for (rims have sag)
HEIGHTS = 17            # on the last surface, whose shadows on the plane say where the region can be
SCAN = 32               # points along the meridian in one look for the region
ZOOMS = 6               # looks, each SCAN / 2 times as fine
FINE = 256              # points of a look where those have found nothing
STEEP = 0.5             # root margin − 1 beyond which it is not taken at its word
ROUGH, ROUGH_POINTS = 0.004, 17         # how well the first rims are solved (× the stop), and at how many points


@njit(cache=True, error_model="numpy", nogil=True)
def margins(film_x, film_y, px, py, distance, out, n, lanes, code, p, key):
    """The square root of the margin of the rays from (film_x, film_y) to (px, py), inf where there is none."""
    for start in range(0, n, B):
        for i in range(B):
            j = min(start + i, n - 1)
            dx, dy = px[j] - film_x[j], py[j] - film_y[j]
            size = 1.0 / math.sqrt(dx * dx + dy * dy + distance * distance)
            lanes[X * PITCH + i], lanes[Y * PITCH + i], lanes[Z * PITCH + i] = film_x[j], film_y[j], 0.0
            lanes[L * PITCH + i], lanes[M * PITCH + i], lanes[N * PITCH + i] = dx * size, dy * size, -distance * size
        call_stage(code, lanes, p, key)
        for i in range(min(B, n - start)):
            v = lanes[MARGIN * PITCH + i]
            out[start + i] = math.sqrt(v) if v < math.inf else math.inf


@njit(cache=True, error_model="numpy", nogil=True)
def _centres(radii, distance, low, high, guess, centre, level, lanes, code, p, key):
    """For each film radius a point (centre, 0) well inside its region; level is its root margin, ≥ 1: none found.

    The meridian is scanned from low to high (radii,), then ever more finely about the point of
    least margin until that passes, or about the guess (radii,) where no ray comes through at all; low and high
    are overwritten.
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
        margins(film, zero, px, zero, distance, out, count, lanes, code, p, key)
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
def _found_elsewhere(radius, distance, low, high, lanes, code, p, key):
    """As _centres for one film radius, about every least margin of a finer scan: (centre, level), level ≥ 1: none.

    Where the stop's image folds over, a coarse scan may follow the wrong one.
    """
    film, zero = np.full(FINE, radius), np.zeros(FINE)
    px, out = low + (high - low) * (np.arange(FINE) + 0.5) / FINE, np.empty(FINE)
    margins(film, zero, px, zero, distance, out, FINE, lanes, code, p, key)
    one = np.full(1, radius)
    centre, level, begin, end, best = np.empty(1), np.empty(1), np.empty(1), np.empty(1), np.empty(1)
    width = (high - low) / FINE
    for j in range(1, FINE - 1):
        if out[j] < math.inf and out[j] <= out[j - 1] and out[j] <= out[j + 1]:
            begin[0], end[0], best[0] = px[j] - width, px[j] + width, px[j]
            _centres(one, distance, begin, end, best, centre, level, lanes, code, p, key)
            if level[0] < 1.0:
                return centre[0], level[0]
    return 0.0, math.inf


@njit(cache=True, error_model="numpy", nogil=True)
def rims(film_x, film_y, centre_x, centre_y, level, cosine, sine, guess, distance, reach, tolerance, rim, lanes, code,
         p, key):
    """Distance from each centre to the rim of its region in each direction: rim (film points, directions).

    A bracketed secant (Illinois) on root margin − 1, which is nearly linear up
    to STEEP; beyond, and where a ray is no number, that value stands for it.
    """
    m = cosine.shape[1]
    size = film_x.size * m
    from_x, from_y, px, py, out = np.empty(size), np.empty(size), np.empty(size), np.empty(size), np.empty(size)
    which, waiting = np.empty(size, np.int64), np.empty(size, np.int64)
    inner, f_inner = np.zeros(size), np.empty(size)
    outer, f_outer = np.full(size, math.inf), np.full(size, math.inf)
    trial, side = np.empty(size), np.zeros(size)
    count = 0
    for i in range(size):
        k, j = i // m, i % m
        f_inner[i], trial[i], rim[k, j] = level[k] - 1.0, guess[k, j], 0.0
        if level[k] < 1.0:
            which[count] = i
            count += 1
    for _ in range(100):
        if count == 0:
            return
        for q in range(count):
            i = which[q]
            k, j = i // m, i % m
            from_x[q], from_y[q] = film_x[k], film_y[k]
            px[q], py[q] = centre_x[k] + trial[i] * cosine[k, j], centre_y[k] + trial[i] * sine[k, j]
        margins(from_x, from_y, px, py, distance, out, count, lanes, code, p, key)
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
            trial[i] = x_next
            rim[i // m, i % m] = x_next
            found = outer[i] < math.inf and abs(x_next - x) <= tolerance
            if not found and x_next < 3.0 * reach:
                waiting[left] = i
                left += 1
        which, waiting = waiting, which
        count = left


@njit(cache=True, error_model="numpy", nogil=True)
def _solve(radii, distance, low, high, aimed, reach, size, tolerance, centre, rim, cosine, sine, rough, lanes, code, p):
    """Centres, the directions of m points of each rim, and their distances; returns the first centres' root margins.

    A rough rim from a first centre gives the centroid, and m directions from
    there that are evenly spaced along the rim, so that the tips of a cat's eye are met.
    """
    key = np.zeros(KEYS, np.uint32)
    n, m = rim.shape
    level, guess, moved = np.empty(n), np.empty((n, m)), np.empty(n)
    first, turn_x, turn_y = np.empty((n, rough)), np.empty((n, rough)), np.empty((n, rough))
    start = np.empty((n, rough))
    first_low, first_high = low.copy(), high.copy()
    _centres(radii, distance, low, high, aimed, centre, level, lanes, code, p, key)
    # What is dark nearer to the axis than others that are lit, or where none is
    outermost = -1.0
    for k in range(n):
        outermost = max(outermost, radii[k]) if level[k] < 1.0 else outermost
    for k in range(n):
        if not level[k] < 1.0 and (radii[k] < outermost or outermost < 0.0):
            centre[k], level[k] = _found_elsewhere(radii[k], distance, first_low[k], first_high[k], lanes, code, p, key)
    for k in range(n):
        start[k, :] = 0.6 * reach * (1.0 - level[k])
        for j in range(rough):
            angle = math.pi * j / (rough - 1)
            turn_x[k, j], turn_y[k, j] = math.cos(angle), math.sin(angle) if j < rough - 1 else 0.0
    zero = np.zeros(n)
    rims(radii, zero, centre, zero, level, turn_x, turn_y, start, distance, reach, ROUGH * size, first, lanes, code, p,
         key)
    # The centroid of the region, on the meridian by symmetry.
    x, y, along = np.empty(rough), np.empty(rough), np.empty(rough)
    for k in range(n):
        area, moment = 0.0, 0.0
        for j in range(rough - 1):
            x0, y0 = first[k, j] * turn_x[k, j], first[k, j] * turn_y[k, j]
            x1, y1 = first[k, j + 1] * turn_x[k, j + 1], first[k, j + 1] * turn_y[k, j + 1]
            cross = x0 * y1 - x1 * y0
            area += cross
            moment += cross * (x0 + x1) / 3.0
        moved[k] = centre[k] + (moment / area if area > 0.0 else 0.0)
    out = np.empty(n)
    margins(radii, zero, moved, zero, distance, out, n, lanes, code, p, key)
    for k in range(n):
        if not level[k] < 1.0:
            continue
        if not out[k] < 1.0:            # its centroid is not in the region: stay where light is known
            out[k], moved[k] = level[k], centre[k]
        # Points evenly spaced along the rough rim give the directions, and where to begin along them.
        for j in range(rough):
            x[j], y[j] = centre[k] - moved[k] + first[k, j] * turn_x[k, j], first[k, j] * turn_y[k, j]
            along[j] = along[j - 1] + math.hypot(x[j] - x[j - 1], y[j] - y[j - 1]) if j > 0 else 0.0
        chord = 0
        for j in range(m):
            target = along[rough - 1] * j / (m - 1)
            while chord < rough - 2 and along[chord + 1] < target:
                chord += 1
            width = along[chord + 1] - along[chord]
            f = (target - along[chord]) / width if width > 0.0 else 0.0
            px, py = x[chord] + f * (x[chord + 1] - x[chord]), y[chord] + f * (y[chord + 1] - y[chord])
            guess[k, j] = max(math.hypot(px, py), 1e-3 * tolerance)
            cosine[k, j], sine[k, j] = px / guess[k, j], py / guess[k, j]
        cosine[k, 0], sine[k, 0], cosine[k, m - 1], sine[k, m - 1] = 1.0, 0.0, -1.0, 0.0
        centre[k] = moved[k]
    rims(radii, zero, centre, zero, out, cosine, sine, guess, distance, reach, tolerance, rim, lanes, code, p, key)
    return level


def span(lens: Lens, film_distance: float, heights: np.ndarray, upright: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """From where to where in x a film point of each height x can see the last surface through its vertex's plane.

    (n,) and (n,) mm; upright: all in y. Seen at a steep angle, a rim that lies before or behind that plane falls far
    beside its own height. Widened by REACH, but no further than the solver looks.
    """
    surface = lens.surfaces[-1]
    a = surface.semi_diameter
    rim = np.linspace(-a, a, HEIGHTS)
    sag = surface.sag(0.0, rim) if upright else surface.sag(rim)
    rim, sag = rim[np.isfinite(sag)], sag[np.isfinite(sag)]
    share = film_distance / np.maximum(film_distance - sag, 0.1 * film_distance)
    seen = heights[:, None] * (1.0 - share) + rim * share
    middle, half = 0.5 * (seen.max(1) + seen.min(1)), 0.5 * REACH * np.ptp(seen, axis=1)
    furthest = np.maximum(3.0 * REACH * a, heights)
    return np.maximum(middle - half, -furthest), np.minimum(middle + half, furthest)


def passes(lens: Lens, film_distance: float, film_radii: np.ndarray, heights: np.ndarray,
           wavelength: float = D_LINE) -> np.ndarray:
    """Whether the rays from film points (r, 0), r in film_radii (n,), to heights (n, k) on the meridian pass."""
    size = heights.size
    step = tracer(lens, film_distance, wavelength)
    film, out = np.repeat(film_radii, heights.shape[1]), np.empty(size)
    margins(film, np.zeros(size), heights.ravel(), np.zeros(size), film_distance, out, size, bench(np.float64),
             stage_address(step.kernel, np.float64), step.parameters, np.zeros(KEYS, np.uint32))
    return (out <= 1.0).reshape(heights.shape)


def solve(lens: Lens, film_distance: float, film_radii, points: int, tolerance: float, wavelength: float = D_LINE,
          within: tuple[float, float] | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n,) on the meridian, and (n, points, 2) of the upper half of each rim seen from them, in mm.

    From the furthest point in +x to that in −x, evenly spaced to about a
    twentieth. A radius whose region is empty has all its points at 0.
    tolerance: of a rim, in mm. within: where on the meridian to look for the regions, if not wherever they can be.
    LensError for a lens with a cylinder or toroid.
    """
    if not lens.is_rotationally_symmetric:
        raise LensError("a lens with a cylinder or toroid has no exit pupil by film radius: "
                        "lb.open_region has it for film points")
    radii = np.ascontiguousarray(film_radii, float)
    shape = (radii.size, points)
    centre, rim, cosine, sine = np.zeros(radii.size), np.zeros(shape), np.zeros(shape), np.zeros(shape)
    reach = REACH * lens.surfaces[-1].semi_diameter
    low, high = span(lens, film_distance, radii) if within is None else (np.full(radii.size, x) for x in within)
    ahead = lens.length + film_distance - first_order(lens, wavelength).exit_pupil.z
    aimed = radii * (1.0 - film_distance / ahead) if ahead else radii               # at the paraxial exit pupil
    size = min(reach, REACH * lens.stop.semi_diameter)
    step = tracer(lens, film_distance, wavelength)
    level = _solve(radii, film_distance, low, high, aimed, reach, size, tolerance, centre, rim, cosine, sine,
                   ROUGH_POINTS, bench(np.float64), stage_address(step.kernel, np.float64), step.parameters)
    centre[~(level < 1.0)] = 0.0
    return centre, np.stack([rim * cosine, rim * sine], 2)
