"""The exit-pupil region: from where on the rear plane a film point receives light.

The region is a set of points of the plane through the last vertex. Seen from a
point inside it is star-shaped, so one radius per direction describes it; by the
lens's rotational symmetry it is solved for film points (+r, 0) only, and for
directions 0 … π, its lower half being the mirror image. A point is inside
where the greatest (r / semi-diameter)² along its ray, the *margin*, is at
most 1; that smooth function is what the solver follows to the rim.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit

from lensbench.blocktracer import packed, trace
from lensbench.driver import Program, _address, _call
from lensbench.glass import D_LINE
from lensbench.lanes import (
    A0,
    A1,
    A2,
    A3,
    A4,
    A5,
    A6,
    A7,
    A8,
    A9,
    ALIVE,
    KEYS,
    LOST,
    MARGIN,
    PITCH,
    U0,
    U1,
    WEIGHT,
    B,
    L,
    M,
    N,
    Step,
    X,
    Y,
    Z,
    bench,
    gather,
    rows,
    stage,
)
from lensbench.prescription import Lens, LensError

REACH = 1.2             # × the rear semi-diameter: how far the region is looked for (rims have sag)
SCAN = 32               # points along the meridian in one look for the region
ZOOMS = 6               # looks, each SCAN / 2 times as fine
RINGS, SECTORS = 64, 32         # of the table that a camera samples: film radii, triangles in half the region
POINTS = 41                     # solved on the upper half of each rim for that table
STEEP = 0.5                     # root margin − 1 beyond which it is not taken at its word
ROUGH, ROUGH_POINTS = 0.004, 17        # how well the first rims are solved (× reach), and at how many points
GRID = 4096                     # cells across the table's corners: two coordinates fit one float32 exactly
SPREAD = 1.004                  # the sampled region over the solved one, for what lies between the table's points


@njit(cache=True, error_model="numpy", nogil=True)
def _margins(film_radius, px, py, distance, out, n, lanes, code, p, key):
    """The square root of the margin of the rays from (film_radius, 0) to (px, py), inf where there is none."""
    for start in range(0, n, B):
        for i in range(B):
            j = min(start + i, n - 1)
            dx, dy = px[j] - film_radius[j], py[j]
            size = 1.0 / math.sqrt(dx * dx + dy * dy + distance * distance)
            lanes[X * PITCH + i], lanes[Y * PITCH + i], lanes[Z * PITCH + i] = film_radius[j], 0.0, 0.0
            lanes[L * PITCH + i], lanes[M * PITCH + i], lanes[N * PITCH + i] = dx * size, dy * size, -distance * size
        _call(code, lanes, p, key)
        for i in range(min(B, n - start)):
            v = lanes[MARGIN * PITCH + i]
            out[start + i] = math.sqrt(v) if v < math.inf else math.inf


@njit(cache=True, error_model="numpy", nogil=True)
def _centres(radii, distance, reach, centre, level, lanes, code, p, key):
    """For each film radius a point (centre, 0) well inside its region; level is its root margin, ≥ 1: none found.

    The meridian is scanned ever more finely about the point of least margin until that passes.
    """
    n = radii.size
    low, high = np.full(n, -reach), np.full(n, reach)
    level[:] = math.inf
    film, px, py, out = np.empty(n * SCAN), np.empty(n * SCAN), np.zeros(n * SCAN), np.empty(n * SCAN)
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
        _margins(film, px, py, distance, out, count, lanes, code, p, key)
        at = 0
        for k in range(n):
            if not level[k] < 1.0:
                least = 0
                for j in range(1, SCAN):
                    least = j if out[at + j] < out[at + least] else least
                centre[k], level[k] = px[at + least], out[at + least]
                width = (high[k] - low[k]) / SCAN
                low[k], high[k] = centre[k] - width, centre[k] + width
                at += SCAN


@njit(cache=True, error_model="numpy", nogil=True)
def _rims(radii, centre, level, cosine, sine, guess, distance, reach, tolerance, rim, lanes, code, p, key):
    """Distance from each centre to the rim of its region in each direction: rim (radii, directions).

    A bracketed secant (Illinois) on root margin − 1, which is nearly linear up
    to STEEP; beyond, and where a ray is no number, that value stands for it.
    """
    m = cosine.shape[1]
    size = radii.size * m
    film, px, py, out = np.empty(size), np.empty(size), np.empty(size), np.empty(size)
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
            film[q] = radii[k]
            px[q], py[q] = centre[k] + trial[i] * cosine[k, j], trial[i] * sine[k, j]
        _margins(film, px, py, distance, out, count, lanes, code, p, key)
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
def _solve(radii, distance, reach, tolerance, centre, rim, cosine, sine, rough, lanes, code, p):
    """Centres, the directions of m points of each rim, and their distances; returns the first centres' root margins.

    A rough rim from a first centre gives the centroid, and m directions from
    there that are evenly spaced along the rim, so that the tips of a cat's eye are met.
    """
    key = np.zeros(KEYS, np.uint32)
    n, m = rim.shape
    level, guess, moved = np.empty(n), np.empty((n, m)), np.empty(n)
    first, turn_x, turn_y = np.empty((n, rough)), np.empty((n, rough)), np.empty((n, rough))
    start = np.empty((n, rough))
    _centres(radii, distance, reach, centre, level, lanes, code, p, key)
    for k in range(n):
        start[k, :] = 0.6 * reach * (1.0 - level[k])
        for j in range(rough):
            angle = math.pi * j / (rough - 1)
            turn_x[k, j], turn_y[k, j] = math.cos(angle), math.sin(angle) if j < rough - 1 else 0.0
    _rims(radii, centre, level, turn_x, turn_y, start, distance, reach, ROUGH * reach, first, lanes, code, p, key)
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
    film, out = radii.copy(), np.empty(n)
    _margins(film, moved, np.zeros(n), distance, out, n, lanes, code, p, key)
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
    _rims(radii, centre, out, cosine, sine, guess, distance, reach, tolerance, rim, lanes, code, p, key)
    return level


def solve(lens: Lens, film_distance: float, film_radii, points: int, tolerance: float,
          wavelength: float = D_LINE) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n,) on the meridian, and (n, points, 2) of the upper half of each rim seen from them, in mm.

    From the furthest point in +x to that in −x, evenly spaced to about a
    twentieth. A radius whose region is empty has all its points at 0.
    tolerance: of a rim, in mm.
    """
    radii = np.ascontiguousarray(film_radii, float)
    shape = (radii.size, points)
    centre, rim, cosine, sine = np.zeros(radii.size), np.zeros(shape), np.zeros(shape), np.zeros(shape)
    reach = REACH * lens.surfaces[-1].semi_diameter
    level = _solve(radii, film_distance, reach, tolerance, centre, rim, cosine, sine, ROUGH_POINTS, bench(np.float64),
                   _address(trace, np.float64), packed(lens, film_distance, wavelength))
    centre[~(level < 1.0)] = 0.0
    return centre, np.stack([rim * cosine, rim * sine], 2)


@dataclass(frozen=True, eq=False)
class ExitPupil:
    """The exit-pupil region of a lens for film points (+r, 0), r in film_radii, on the plane of the last vertex.

    Lens frame, mm. A film point at another azimuth sees the region turned with it.
    """

    lens: Lens
    film_distance: float
    film_radii: np.ndarray          # (n,)
    centres: np.ndarray             # (n,) on the meridian: the x that the rims are seen from
    rims: np.ndarray                # (n, m, 2) points of the upper half, from the centre; 0 where no light passes

    def boundary(self, i: int) -> np.ndarray:
        """(2 m − 2, 2) points of the rim, counter-clockwise from the one furthest in +x."""
        half = self.rims[i] + [self.centres[i], 0.0]
        return np.concatenate([half, half[-2:0:-1] * [1.0, -1.0]])

    @property
    def area(self) -> np.ndarray:
        """(n,) mm²: ∫ r²/2 over all directions, by the trapezium rule."""
        return _integral(self.rims, lambda r2: r2)

    @property
    def cos4_area(self) -> np.ndarray:
        """(n,) ∫ cos⁴θ dA in mm², θ at the film point; divided by film_distance² it is the irradiance of radiance 1.

        By Gauss's rule along every radius of the region and the trapezium rule around it.
        """
        node, weight = np.polynomial.legendre.leggauss(12)
        total = np.zeros(len(self.rims))
        for t, w in zip(0.5 * (node + 1.0), 0.5 * weight, strict=True):
            offset = t * self.rims + np.stack([self.centres - self.film_radii, 0.0 * self.centres], 1)[:, None, :]
            cos2 = self.film_distance**2 / (self.film_distance**2 + (offset**2).sum(2))
            total += w * _integral(self.rims, lambda r2, t=t, cos2=cos2: 2.0 * t * r2 * cos2**2)
        return total

    @property
    def bounds(self) -> np.ndarray:
        """(n, 4) x0, y0, x1, y1: the box about the region that pbrt samples."""
        tops = np.array([_peak(rim[:, 1]) for rim in self.rims])
        left, right = (np.array([_peak(sign * rim[:, 0]) for rim in self.rims]) for sign in (-1.0, 1.0))
        return np.stack([self.centres - left, -tops, self.centres + right, tops], 1)

    @cached_property
    def _table(self) -> "PupilTable":
        return PupilTable.of(self.lens, self.film_distance, float(self.film_radii.max()))

    def sample(self, film_xy, uv) -> tuple[np.ndarray, np.ndarray]:
        """Points (n, 2) of the regions that film_xy (n, 2) mm sees, and those regions' areas (n,) mm².

        uv (n, 2) in [0, 1): equal areas stay equal. The very sampling that a
        LensCamera uses: its region is a hair larger than the true one.
        """
        film_xy, uv = np.asarray(film_xy, float), np.asarray(uv, float)
        n = len(film_xy)
        x, y, l, m, n_, weight = Program([self._table.step(1.0)], np.float64).run(
            {X: film_xy[:, 0], Y: film_xy[:, 1], U0: uv[:, 0], U1: uv[:, 1], WEIGHT: np.ones(n)},
            [X, Y, L, M, N, WEIGHT], n)
        along = self.film_distance / -n_
        return np.stack([x + along * l, y + along * m], 1), weight / n_**4


def _integral(rims: np.ndarray, radial) -> np.ndarray:
    """∫ radial(r²) dθ over whole regions, (n,): twice the integral of f r dr from 0 to the rim, for the upper half."""
    value = radial((rims**2).sum(2))
    return ((value[:, 1:] + value[:, :-1]) * 0.5 * np.diff(np.arctan2(rims[..., 1], rims[..., 0]))).sum(1)


def _peak(values: np.ndarray) -> float:
    """The maximum of a curve known at equal steps: of the parabola through the three highest neighbours."""
    i = int(np.argmax(values))
    if not 0 < i < len(values) - 1:
        return float(values[i])
    before, at, after = values[i - 1:i + 2]
    bend = before - 2.0 * at + after
    return float(at - (after - before) ** 2 / (8.0 * bend)) if bend < 0.0 else float(at)


def exit_pupil(lens: Lens, film_distance: float, film_radii, wavelength: float = D_LINE,
               points: int = 257) -> ExitPupil:
    """Solve the exit-pupil region for film points at these radii (mm); LensError for radii or distances that cannot be.

    film_distance: last vertex → film, mm. Rims to 1e-10 of the rear semi-diameter.
    """
    radii = np.atleast_1d(np.asarray(film_radii, float))
    if not (np.isfinite(radii).all() and (radii >= 0.0).all() and math.isfinite(film_distance) and film_distance > 0.0):
        raise LensError("the exit pupil needs film radii of at least 0 mm and a film behind the lens")
    tolerance = 1e-10 * lens.surfaces[-1].semi_diameter
    return ExitPupil(lens, film_distance, radii, *solve(lens, film_distance, radii, points, tolerance, wavelength))


@dataclass(frozen=True, eq=False)
class PupilTable:
    """The regions of RINGS film radii, each cut into 2 SECTORS triangles of equal area, for a camera to sample.

    outline: (RINGS, SECTORS + 1, 2) corners in the upper half, from the region's
    centre; centres: (RINGS,). Ring k stands where 1 − √(1 − r / end) is k / (RINGS − 1)
    of what it is at the last: the rings crowd towards a radius `end` where the light
    ends, for there a region shrinks as a root. No light falls beyond dark_beyond.
    """

    film_distance: float
    radius: float                   # of the last ring, mm
    end: float
    dark_beyond: float
    outline: np.ndarray
    centres: np.ndarray

    @classmethod
    def of(cls, lens: Lens, film_distance: float, film_radius: float, wavelength: float = D_LINE) -> "PupilTable":
        """Solve the table for film radii 0 … film_radius, or to where the light ends."""
        tolerance = 2e-4 * REACH * lens.surfaces[-1].semi_diameter

        def solved(radii, accuracy=tolerance):
            return solve(lens, film_distance, radii, POINTS, accuracy, wavelength)

        end, dark = 4.0 * max(film_radius, 1e-30), math.inf
        radii = _ring_radii(film_radius, end)
        centres, rims = solved(radii)
        lit = np.nonzero(rims[:, 0, 0] > rims[:, -1, 0])[0]
        if lit.size and lit[-1] < RINGS - 1:    # find where the light ends, spread the rings to there
            low, high = radii[lit[-1]], radii[lit[-1] + 1]
            for _ in range(3):
                between = np.linspace(low, high, 18)[1:-1]
                alive = np.nonzero(solved(between)[1][:, 0, 0] > 0.0)[0]
                last = alive[-1] if alive.size else -1
                low, high = (between[last] if last >= 0 else low), (between[last + 1] if last < 15 else high)
            film_radius = end = dark = high
            centres, rims = solved(_ring_radii(high, high))
            centres[-1] = centres[-2]
        return cls(film_distance, film_radius, end, dark if lit.size else 0.0, _equal_areas(rims * SPREAD), centres)

    def step(self, normaliser: float) -> Step:
        """The step that aims from the film into the region; WEIGHT becomes cos⁴ · area / normaliser."""
        scale = (RINGS - 1) / (1.0 - math.sqrt(1.0 - self.radius / self.end))
        size = max(float(np.abs(self.outline).max()), 1e-30)
        cells = np.round((self.outline / size + 1.0) * (0.5 * (GRID - 1)))
        head = [self.film_distance, scale, 1.0 / self.end, self.dark_beyond, 1.0 / normaliser]
        return Step(aim, np.concatenate([
            [*head, 2.0 * size / (GRID - 1), -size],
            (cells[:, :, 0] + GRID * cells[:, :, 1]).ravel(), self.centres]))


def _ring_radii(radius: float, end: float) -> np.ndarray:
    """(RINGS,) film radii 0 … radius, ever denser towards `end`."""
    last = 1.0 - math.sqrt(1.0 - radius / end)
    return end * (1.0 - (1.0 - np.linspace(0.0, last, RINGS)) ** 2)


def _equal_areas(rims: np.ndarray) -> np.ndarray:
    """(rings, points, 2) of the rims → (rings, SECTORS + 1, 2) corners at equal areas along the same chords."""
    x, y = rims[..., 0], rims[..., 1]
    cross = x[:, :-1] * y[:, 1:] - x[:, 1:] * y[:, :-1]
    area = np.concatenate([np.zeros((len(rims), 1)), np.cumsum(cross, 1)], 1)
    corners = np.zeros((len(rims), SECTORS + 1, 2))
    for ring in range(len(rims)):
        if area[ring, -1] > 0.0:
            wanted = np.linspace(0.0, area[ring, -1], SECTORS + 1)
            corners[ring, :, 0] = np.interp(wanted, area[ring], x[ring])
            corners[ring, :, 1] = np.interp(wanted, area[ring], y[ring])
    return corners


_NODES = SECTORS + 1


@stage
def aim(lanes, p, key):
    """From a film point X, Y (mm, Z = 0) aim into the region that it sees: L, M, N and WEIGHT.

    p: film distance, rings per unit of 1 − √(1 − r / end), 1 / end, the radius
    beyond which no light falls, 1 / normaliser, the size and origin of the corners' grid, then
    the table: both coordinates of every corner in one number, and the centres.
    The weight holds the exact area of the triangle that was sampled, so that
    neither the interpolation between rings nor the grid leaves an error, or a
    ring in the picture.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, u, v, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[U0], row[U1], row[WEIGHT]
    ring, between, turn, corner = row[A0], row[A1], row[A2], row[A3]
    inner0, inner1, outer0, outer1 = row[A4], row[A5], row[A6], row[A7]
    centre0, centre1 = row[A8], row[A9]
    distance, scale, end, dark, gain, cell, origin = p[0], p[1], p[2], p[3], p[4], p[5], p[6]
    table = p[7:]
    last = real(RINGS - 1.001)
    for i in range(B):
        r = math.sqrt(x[i] * x[i] + y[i] * y[i])
        left = real(1) - r * end
        k = (real(1) - math.sqrt(left if left > real(0) else real(0))) * scale
        k = k if k < last else last
        s = u[i] * real(2 * SECTORS)
        t = s - real(SECTORS) if s >= real(SECTORS) else s
        ring[i] = np.floor(k)
        between[i] = k - np.floor(k)
        turn[i] = t
        corner[i] = np.floor(k) * real(_NODES) + np.floor(t)
        weight[i] = gain if r <= dark else real(0)
    gather(inner0, table, corner)
    gather(inner1, table[1:], corner)
    gather(outer0, table[_NODES:], corner)
    gather(outer1, table[_NODES + 1:], corner)
    gather(centre0, table[RINGS * _NODES:], ring)
    gather(centre1, table[RINGS * _NODES + 1:], ring)
    unit = real(1 / GRID)
    for i in range(B):
        f = between[i]
        e = real(1) - f
        y0, y1, y2, y3 = (np.floor(inner0[i] * unit), np.floor(inner1[i] * unit),
                          np.floor(outer0[i] * unit), np.floor(outer1[i] * unit))
        x0, x1, x2, x3 = (inner0[i] - y0 * real(GRID), inner1[i] - y1 * real(GRID),
                          outer0[i] - y2 * real(GRID), outer1[i] - y3 * real(GRID))
        ax, bx = (e * x0 + f * x2) * cell + origin, (e * x1 + f * x3) * cell + origin
        ay, by = (e * y0 + f * y2) * cell + origin, (e * y1 + f * y3) * cell + origin
        g = turn[i] - np.floor(turn[i])
        h = real(1) - g
        reach = math.sqrt(v[i])
        a = e * centre0[i] + f * centre1[i] + reach * (h * ax + g * bx)
        b = reach * (h * ay + g * by)
        b = -b if u[i] >= real(0.5) else b
        r2 = x[i] * x[i] + y[i] * y[i]
        off = r2 > real(1e-12)                              # on the axis every azimuth is the same
        inverse = real(1) / math.sqrt(r2 if off else real(1))
        cosine, sine = x[i] * inverse if off else real(1), y[i] * inverse
        dx, dy = a * cosine - b * sine - x[i], a * sine + b * cosine - y[i]
        size = real(1) / math.sqrt(dx * dx + dy * dy + distance * distance)
        l[i], m[i], n[i] = dx * size, dy * size, -distance * size
        c2 = distance * size
        c2 = c2 * c2
        weight[i] *= c2 * c2 * real(SECTORS) * (ax * by - bx * ay)
        z[i] = real(0)
    alive = np.int32(0)
    for i in range(B):
        alive += np.int32(1) if weight[i] > real(0) else np.int32(0)
    if alive == 0:
        key[ALIVE] = np.uint32(LOST)
