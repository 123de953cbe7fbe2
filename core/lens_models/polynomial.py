"""Polynomial optics: a lens as a polynomial from a film point and a direction there to the ray in front of the lens.

By rotational symmetry the ray depends on the film point u and the aim v, both scaled to at most 1, through a = u·u, b =
v·v and c = u·v. Its direction is (F u + G v, H), and its point nearest to the entrance pupil is (P u + Q v, R), with
six polynomials of a, b and c: of degree n for directions, lower for positions, which distance does not magnify. The aim
is the point where the ray meets the plane of the rear vertex, minus the drift of the pupil regions' centres across the
film. All three components of the direction are fitted, so a field beyond 90° is no special case. The fit runs over the
solved exit-pupil regions. Camera frame, mm. (Hullin, Hanika and Heidrich 2012, Polynomial optics, for the idea.)
"""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, CLEARANCE, B, L, M, N, Step, X, Y, Z, rows, stage
)
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.program import Program
from lensbench.core.lens_models.invariant_least_squares import evaluate_polynomials, fit_vector_fields
from lensbench.core.optics.block_trace import trace_steps
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.paraxial import FirstOrder, first_order, scene_side_origin
from lensbench.core.optics.prescription import Lens
from lensbench.core.pupils.radial_sampler import PupilTable

# Parameters of the stage: −film distance over the reach of the aim, (1 − drift) over that reach (1/mm), 1 / film radius
# (1/mm), z of the centre (mm), 1 / distance from it to objects in focus (1/mm), coefficients of F, G, H, P, Q and R
DISTANCE_SHARE, DRIFT_SHARE, INVERSE_RADIUS, CENTRE_Z, NEARNESS, COEFFICIENTS = range(6)
DIRECTION_DEGREE, POSITION_DEGREE = range(2)        # integers: degrees in a, b and c of F, G, H and of P, Q, R


def monomial_count(n: int) -> int:
    """Number of monomials of three variables up to the total degree n."""
    return (n + 1) * (n + 2) * (n + 3) // 6


def position_degree(n: int) -> int:
    """Degree in a, b and c of the positions."""
    return min(n, max(n - 1, 2))


@njit(inline="always")
def _of_two(q, k, b, c, n, real):
    """Terms of one power of a: all monomials in b and c up to the degree n, by Horner's rule."""
    total = real(0)
    for j in range(n + 1):
        inner = q[k]
        k += 1
        for _ in range(j):
            inner = inner * c + q[k]
            k += 1
        total = total * b + inner
    return total


@stage
def polynomial(lanes, p, ints, key):
    """Replace the ray at the film by that in front of the lens. p: DISTANCE_SHARE …, ints: DIRECTION_DEGREE …."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n_ = row[X], row[Y], row[Z], row[L], row[M], row[N]
    a, b, c, total = row[A0], row[A1], row[A2], row[A3]
    f, g, h, pu, pv, pw = row[A4], row[A5], row[A6], row[A7], row[A8], row[A9]
    reach, drift, scale = p[DISTANCE_SHARE], p[DRIFT_SHARE], p[INVERSE_RADIUS]
    centre, near = p[CENTRE_Z], p[NEARNESS]
    # Invariants of the film point u and the aim v
    for i in range(B):
        ux, uy = x[i] * scale, y[i] * scale
        away = reach / n_[i]
        vx, vy = l[i] * away + x[i] * drift, m[i] * away + y[i] * drift
        a[i], b[i], c[i] = ux * ux + uy * uy, vx * vx + vy * vy, ux * vx + uy * vy
    # Polynomials F, G and H of the direction, then P, Q and R of the position: a loop for each power of a, whose
    # coefficients are so few that they stay in registers
    first = COEFFICIENTS
    for k in range(6):
        n = ints[DIRECTION_DEGREE] if k < 3 else ints[POSITION_DEGREE]
        q = p[first:]
        for i in range(B):
            total[i] = q[0] * a[i] + _of_two(q, 1, b[i], c[i], 1, real)
        if n >= 2:
            for i in range(B):
                total[i] = total[i] * a[i] + _of_two(q, 4, b[i], c[i], 2, real)
        if n >= 3:
            for i in range(B):
                total[i] = total[i] * a[i] + _of_two(q, 10, b[i], c[i], 3, real)
        if n >= 4:
            for i in range(B):
                total[i] = total[i] * a[i] + _of_two(q, 20, b[i], c[i], 4, real)
        if n >= 5:
            for i in range(B):
                total[i] = total[i] * a[i] + _of_two(q, 35, b[i], c[i], 5, real)
        value = row[A4 + k]
        for i in range(B):
            value[i] = total[i]
        first += (n + 1) * (n + 2) * (n + 3) // 6
    for i in range(B):
        # Position (P u + Q v, R), and direction from there to objects in focus
        ux, uy = x[i] * scale, y[i] * scale
        away = reach / n_[i]
        vx, vy = l[i] * away + x[i] * drift, m[i] * away + y[i] * drift
        px, py, pz = pu[i] * ux + pv[i] * vx, pu[i] * uy + pv[i] * vy, pw[i]
        dx, dy = f[i] * ux + g[i] * vx - near * px, f[i] * uy + g[i] * vy - near * py
        dz = h[i] - near * pz
        # Normalise what is nearly a unit vector: two steps of Newton's method for 1 / √
        square = dx * dx + dy * dy + dz * dz
        size = real(1.5) - real(0.5) * square
        size = size * (real(1.5) - real(0.5) * square * size * size)
        l[i], m[i], n_[i] = dx * size, dy * size, dz * size
        x[i], y[i], z[i] = px, py, pz + centre


DEGREES = (3, 5, 7, 9, 11)
LEAST = 0.02                # smallest weight of a ray
SLACK = 1.05                # (r / semi-diameter)² up to which a ray beyond the rim still serves the fit
HELD_OUT = 127              # rays on which the error is measured; with those of degree 9, one block of lanes
EVENLY = 0.6                # exponent of the weights, from Chebyshev's (0) to shares of film and pupil area (1)
SPREAD = (0.7548776662466927, 0.5698402909980532)       # whose multiples fill a square evenly: 1/ρ, 1/ρ² of ρ³ = ρ + 1
OFF = 0.05                  # of the length of a fitted direction from 1; two steps of Newton's method leave 3e-5
DRIFT_POINTS = 17           # film points at which the drift of the regions' centres is measured


@dataclass(frozen=True, eq=False)
class Polynomial:
    """Fitted lens: degree in film point and aim, numbers of the stage, rms and worst error in mm on the film."""

    degree: int
    numbers: np.ndarray
    rms: float
    worst: float

    @classmethod
    def fit(cls, lens: Lens, film_distance: float, table: PupilTable, degree: int = 9, wavelength: float = D_LINE,
            distance: float = math.inf) -> "Polynomial":
        """Fit a lens for the film points and exit-pupil regions of a table, not widened.

        film_distance: last vertex → film (mm). degree: one of DEGREES. wavelength: µm. distance: film → objects (mm)
        for which the errors are measured. LensError for another degree, a lens without rotational symmetry, regions of
        several pieces, too little light, or directions that are far from unit vectors.
        """
        if degree not in DEGREES:
            raise LensError(f"polynomial degree {degree}: choose one of {', '.join(map(str, DEGREES))}")
        if not lens.is_rotationally_symmetric:
            raise LensError(f"a polynomial is fitted in rotation invariants, and this lens has {lens.asymmetry}")
        if table.irregular:
            raise LensError("no polynomial: some exit-pupil regions of this lens are split or bent, as near the edge "
                            "of the light, and only the trace finds the dark beside them: choose the trace, or a "
                            "smaller film")
        n, low = degree // 2, position_degree(degree // 2)
        places, shares = _sample_places(n)
        film, aim, drift = _aim_rays(table.outline, table.course, table.offsets, table.radius, table.end, table.scale,
                                   *places)
        fo = first_order(lens, wavelength)
        centre = scene_side_origin(lens, wavelength)
        eye = centre - lens.length - film_distance
        lines = _trace_rays(lens, film_distance, film, aim, wavelength)
        nearness = 1.0 / (distance + eye)
        abc, weights, fields, v, reach, served = _fit_data(film, aim, lines, shares, table.radius, drift, eye,
                                                             nearness)
        if served < 2 * monomial_count(n):
            raise LensError("too little light passes this lens for a polynomial to be fitted: open the stop")
        towards, points = fit_vector_fields(abc, weights, fields, n, low)

        directions, positions = evaluate_polynomials(abc, towards, n), evaluate_polynomials(abc, points, low)
        if not _holds(film, table.radius, v, directions, positions, nearness):
            raise LensError(f"no polynomial of degree {degree} fits this lens on this film: choose another degree, "
                            "a smaller film or the full trace")

        # Measure the error on the rays that were held out
        held_out = slice(len(shares), None)
        rms, worst = _errors(film, lines, v, table.radius, np.ascontiguousarray(directions[:, held_out]),
                             np.ascontiguousarray(positions[:, held_out]), nearness, len(shares))
        scale = _film_scale(lens, fo, nearness, centre)
        p = np.empty(COEFFICIENTS + towards.size + points.size)
        p[DISTANCE_SHARE], p[DRIFT_SHARE] = -film_distance / reach, (1.0 - drift) / reach
        p[INVERSE_RADIUS], p[CENTRE_Z], p[NEARNESS] = 1.0 / table.radius, eye, nearness
        p[COEFFICIENTS:] = np.concatenate([towards.ravel(), points.ravel()])
        return cls(degree, p, rms * scale, worst * scale)

    @property
    def step(self) -> Step:
        """Step from an aimed ray at the film to the ray in front of the lens."""
        n = self.degree // 2
        return Step(polynomial, self.numbers, (n, position_degree(n)))


@cache
def _sample_places(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions (3, rays) of the rays: shares of the film's radius, of a region's, and along its rim; and weights
    (fits,).

    Those of the fit crowd towards the edges of field and pupil; the last HELD_OUT measure the error.
    """
    grid = np.meshgrid(np.sin(np.linspace(0.0, 0.5 * math.pi, 2 * n + 3)),
                       np.sin(0.5 * math.pi * np.arange(1, n + 2) / (n + 1)),
                       (np.arange(n + 3) + 0.5) / (n + 3), indexing="ij")
    r, reach, turn = (share.ravel() for share in grid)
    shares = r * reach * np.sqrt(np.maximum((1.0 - r * r) * (1.0 - reach * reach), 0.0))
    k = np.arange(HELD_OUT)
    judges = np.stack([np.sqrt((k + 0.5) / HELD_OUT), np.sqrt(k * SPREAD[0] % 1.0), k * SPREAD[1] % 1.0])
    return np.concatenate([np.stack([r, reach, turn]), judges], 1), np.maximum(shares, LEAST) ** EVENLY


@njit(cache=True, error_model="numpy", nogil=True)
def _aim_rays(outline, course, offsets, radius, end, scale, radii, reach, turn):
    """Film points x (n,), rear points (2, n), and the drift of the regions' centres, in mm per mm of film.

    radii: (n,) shares of the film's radius; reach: from a region's centre (0) to its rim (1); turn: along the upper
    half of the rim, 0 … 1; outline … scale: those of the table.
    """
    sectors = outline.shape[1] - 1
    film, aim = radii * radius, np.empty((2, radii.size))
    for q in range(radii.size):
        ring, f, middle = _middle(film[q], course, offsets, end, scale)
        t = turn[q] * sectors
        k = min(int(t), sectors - 1)
        g = t - k
        for axis in range(2):
            inner = outline[ring, k, axis] * (1.0 - g) + outline[ring, k + 1, axis] * g
            outer = outline[ring + 1, k, axis] * (1.0 - g) + outline[ring + 1, k + 1, axis] * g
            aim[axis, q] = reach[q] * (inner * (1.0 - f) + outer * f)
        aim[0, q] += middle
    above, below = 0.0, 0.0
    for q in range(DRIFT_POINTS):
        height = radius * q / (DRIFT_POINTS - 1)
        above += _middle(height, course, offsets, end, scale)[2] * height
        below += height * height
    return film, aim, above / below


@njit(inline="always")
def _middle(r, course, offsets, end, scale):
    """Inner ring of a film radius in the table, the share of the next ring, and the region's centre there."""
    ring_number = (1.0 - math.sqrt(max(1.0 - r / end, 0.0))) * scale
    ring = min(int(ring_number), offsets.size - 2)
    f, t = ring_number - ring, (r / end) ** 2
    middle = r * (course[0] + t * (course[1] + t * course[2]))
    return ring, f, middle + offsets[ring] * (1.0 - f) + offsets[ring + 1] * f


def _trace_rays(lens: Lens, film_distance: float, film: np.ndarray, aim: np.ndarray, wavelength: float) -> np.ndarray:
    """Rays (7, n) in front of the lens: X … N in the camera frame, and CLEARANCE."""
    x, y = aim[0] - film, aim[1]
    size = 1.0 / np.sqrt(x * x + y * y + film_distance**2)
    inputs = {X: film, L: x * size, M: y * size, N: -film_distance * size}
    return Program(trace_steps(lens, film_distance, wavelength, blades=False), np.float64).run(
        inputs, [X, Y, Z, L, M, N, CLEARANCE], len(film))


@njit(cache=True, error_model="numpy", nogil=True)
def _fit_data(film, aim, lines, shares, radius, drift, eye, nearness):
    """Data of the fit: invariants (3, n) of all rays, weights (fits,) and fields (6, fits) of the first ones.

    Also v (2, n), its reach (mm), and the number of rays that serve the fit. Moves the points of lines (7, n) to those
    nearest to the eye, relative to it; the clearance of rays that do not arrive becomes infinite.
    """
    rays, fits = film.size, shares.size
    v, abc, weights, fields = np.empty((2, rays)), np.empty((3, rays)), np.zeros(fits), np.zeros((6, fits))
    reach, served = 1e-30, 0
    for r in range(rays):
        v[0, r], v[1, r] = aim[0, r] - drift * film[r], aim[1, r]
        reach = max(reach, math.sqrt(v[0, r] ** 2 + v[1, r] ** 2))
    for r in range(rays):
        u, vx, vy = film[r] / radius, v[0, r] / reach, v[1, r] / reach
        v[0, r], v[1, r] = vx, vy
        abc[0, r], abc[1, r], abc[2, r] = u * u, vx * vx + vy * vy, u * vx
        x, y, z, dx, dy, dz = lines[0, r], lines[1, r], lines[2, r] - eye, lines[3, r], lines[4, r], lines[5, r]
        along = x * dx + y * dy + z * dz
        x, y, z = x - along * dx, y - along * dy, z - along * dz
        lines[0, r], lines[1, r], lines[2, r] = x, y, z
        if not (math.isfinite(along) and lines[6, r] < math.inf):
            lines[6, r] = math.inf
        elif r < fits and lines[6, r] < SLACK:
            weights[r] = shares[r]
            served += 1
            fields[3, r], fields[4, r], fields[5, r] = u * x, vx * x + vy * y, z
            x, y, z = dx + nearness * x, dy + nearness * y, dz + nearness * z
            fields[0, r], fields[1, r], fields[2, r] = u * x, vx * x + vy * y, z
    return abc, weights, fields, v, reach, served


@njit(cache=True, error_model="numpy", nogil=True)
def _errors(film, lines, v, radius, directions, positions, nearness, first):
    """Error (rms and worst, radians) of the rays from `first` on, for objects in focus and at infinity.

    directions, positions: values (3, …) of the polynomials for those rays: towards objects in focus, and of origins.
    """
    total, worst, count = 0.0, 0.0, 0
    for r in range(first, film.size):
        if lines[6, r] <= 1.0:
            q, u, vx, vy = r - first, film[r] / radius, v[0, r], v[1, r]
            px, py, pz = positions[0, q] * u + positions[1, q] * vx, positions[1, q] * vy, positions[2, q]
            dx, dy = directions[0, q] * u + directions[1, q] * vx - nearness * px, directions[1, q] * vy - nearness * py
            dz = directions[2, q] - nearness * pz
            size = math.sqrt(dx * dx + dy * dy + dz * dz)
            dx, dy, dz = dx / size - lines[3, r], dy / size - lines[4, r], dz / size - lines[5, r]
            far = dx * dx + dy * dy + dz * dz
            dx, dy = dx + nearness * (px - lines[0, r]), dy + nearness * (py - lines[1, r])
            dz += nearness * (pz - lines[2, r])
            square = max(dx * dx + dy * dy + dz * dz, far)
            total, worst, count = total + square, max(worst, square), count + 1
    return (math.sqrt(total / count), math.sqrt(worst)) if count else (math.inf, math.inf)


@njit(cache=True, error_model="numpy", nogil=True)
def _holds(film, radius, v, directions, positions, nearness):
    """Whether the fitted directions are unit vectors to OFF, which the stage normalises; see `_errors`."""
    for r in range(film.size):
        u, vx, vy = film[r] / radius, v[0, r], v[1, r]
        dx = directions[0, r] * u + directions[1, r] * vx - nearness * (positions[0, r] * u + positions[1, r] * vx)
        dy = (directions[1, r] - nearness * positions[1, r]) * vy
        dz = directions[2, r] - nearness * positions[2, r]
        if not abs(math.sqrt(dx * dx + dy * dy + dz * dz) - 1.0) <= OFF:
            return False
    return True


def _film_scale(lens: Lens, fo: FirstOrder, nearness: float, centre: float) -> float:
    """Paraxial image: mm of film per radian of an object seen from the centre; nearness: 1 / its distance (1/mm)."""
    efl = lens.front_index * fo.efl
    return abs(efl / (1.0 + nearness * (fo.front_principal - centre - efl)))
