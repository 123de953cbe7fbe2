"""A lens as a polynomial: from a film point and a direction there, straight to the ray in front of the lens.

By rotational symmetry the ray can only depend on film point u and aim v (both made as large
as 1) through the invariants a = u·u, b = v·v and c = u·v. Its direction is
(F u + G v, H) and its point nearest to the entrance pupil (P u + Q v, R), six polynomials of a, b, c;
with F, G and H of total degree n the map is said to be of degree 2 n + 1 in the film and the aim. The aim
is where the ray meets the rear vertex's plane, less what the middle of the pupil region drifts across the film;
all three components of the direction are fitted, so that a field beyond 90° is nothing special. Positions matter
less than directions, for they are not magnified by the distance: their degree is lower by 4.

The fit is by least squares over the solved exit-pupil regions, through the normal equations, of which
the weights of the invariants themselves make every block. Camera frame, mm. The idea of polynomial optics: Hullin,
Hanika and Heidrich 2012.
"""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numba import njit

from lensbench.kernels.block import (
    A0,
    A1,
    A2,
    A3,
    A4,
    A5,
    A6,
    A7,
    A8,
    CLEARANCE,
    B,
    L,
    M,
    N,
    Step,
    X,
    Y,
    Z,
    rows,
    stage,
)
from lensbench.kernels.program import Program
from lensbench.lens_models.invariant_least_squares import evaluate_polynomials, fit_vector_fields
from lensbench.optics.block_trace import round_stop_steps
from lensbench.optics.glass import D_LINE
from lensbench.optics.paraxial import FirstOrder, first_order, scene_side_origin
from lensbench.optics.prescription import Lens, LensError
from lensbench.pupils.radial_sampler import PupilTable

DEGREES = (3, 5, 7, 9, 11)
HEAD = 5                    # numbers before the coefficients
LEAST = 0.02                # of a ray's share
SLACK = 1.05                # (r / semi-diameter)² up to which a ray beyond the rim still serves the fit
JUDGES = 127                # rays on which the error is measured; with those of degree 9, one block of lanes
EVENLY = 0.6                # how far the rays' weights go from Chebyshev's (0) to their share of film and pupil (1)
SPREAD = (0.7548776662466927, 0.5698402909980532)       # whose multiples fill a square evenly: 1/ρ, 1/ρ² of ρ³ = ρ + 1
DRIFTS = 17                 # film points between which the middles of the regions are followed


@dataclass(frozen=True, eq=False)
class Polynomial:
    """A fitted lens.

    degree: in film point and aim. numbers: what the stage reads. rms, worst: the error on rays that did not
    serve the fit, as mm on the film, for objects at the distance that the fit was told.
    """

    degree: int
    numbers: np.ndarray
    rms: float
    worst: float

    @classmethod
    def fit(cls, lens: Lens, film_distance: float, table: PupilTable, degree: int = 9, wavelength: float = D_LINE,
            distance: float = math.inf) -> "Polynomial":
        """Fit the lens as it stands before its film, for the film points and regions of the table.

        film_distance: last vertex → film (mm); distance: from the film to what the errors are stated for (mm).
        LensError for a degree that is none of DEGREES, a lens without rotational symmetry, and one that
        passes too little light to be fitted.
        """
        if degree not in DEGREES:
            raise LensError(f"polynomial degree {degree}: choose one of {', '.join(map(str, DEGREES))}")
        if not lens.is_rotationally_symmetric:
            raise LensError("a polynomial is fitted in rotation invariants, and this lens has a cylinder or toroid")
        n, low = degree // 2, _low(degree // 2)
        places, shares = _places(n)
        film, aim, drift = _aimed(table.outline, table.course, table.offsets, table.radius, table.end, table.scale,
                                   *places)
        fo = first_order(lens, wavelength)
        centre = scene_side_origin(lens, wavelength)
        eye = centre - lens.length - film_distance
        lines = _traced(lens, film_distance, film, aim, wavelength)
        nearness = 1.0 / (distance + eye)
        abc, weights, fields, v, reach, served = _invariants(film, aim, lines, shares, table.radius, drift, eye,
                                                             nearness)
        if served < 2 * monomial_count(n):
            raise LensError("too little light passes this lens for a polynomial to be fitted: open the stop")
        towards, points = fit_vector_fields(abc, weights, fields, n, low)

        # The error on the rays that were held out
        held = np.ascontiguousarray(abc[:, len(shares):])
        rms, worst = _errors(film, lines, v, table.radius, evaluate_polynomials(held, towards, n),
                             evaluate_polynomials(held, points, low), nearness, len(shares))
        behind = _behind(lens, fo, nearness, centre)
        numbers = [-film_distance / reach, (1.0 - drift) / reach, 1.0 / table.radius, eye, nearness]
        return cls(degree, np.concatenate([numbers, towards.ravel(), points.ravel()]), rms * behind, worst * behind)

    @property
    def step(self) -> Step:
        """The step from an aimed ray at the film to the ray in front of the lens."""
        return Step(polynomial_stage(self.degree // 2), self.numbers)


@cache
def _places(n: int) -> tuple[np.ndarray, np.ndarray]:
    """(3, rays) where a fit looks: shares of the film's radius, of a region's, and along its rim; (fits,) weights.

    The first rays crowd towards the edges of field and pupil, and stand for the less of the light; the last JUDGES lie
    between them, to judge the fit by.
    """
    grid = np.meshgrid(np.sin(np.linspace(0.0, 0.5 * math.pi, 2 * n + 3)),
                       np.sin(0.5 * math.pi * np.arange(1, n + 2) / (n + 1)),
                       (np.arange(n + 3) + 0.5) / (n + 3), indexing="ij")
    r, reach, turn = (each.ravel() for each in grid)
    shares = r * reach * np.sqrt(np.maximum((1.0 - r * r) * (1.0 - reach * reach), 0.0))
    k = np.arange(JUDGES)
    judges = np.stack([np.sqrt((k + 0.5) / JUDGES), np.sqrt(k * SPREAD[0] % 1.0), k * SPREAD[1] % 1.0])
    return np.concatenate([np.stack([r, reach, turn]), judges], 1), np.maximum(shares, LEAST) ** EVENLY


def monomial_count(n: int) -> int:
    """How many monomials three variables have up to the total degree n."""
    return (n + 1) * (n + 2) * (n + 3) // 6


def _low(n: int) -> int:
    """The degree in a, b, c of the positions."""
    return min(n, max(n - 1, 2))


@njit(cache=True, error_model="numpy", nogil=True)
def _aimed(outline, course, offsets, radius, end, scale, radii, reach, turn):
    """Rays from film points at the share `radii` of the table's radius to its regions' upper halves.

    outline … scale: the table's. reach: from the region's centre (0) to its rim (1); turn: along the rim, 0 … 1.
    Returns the film points' x (n,) and the points on the plane of the rear vertex (2, n), mm; and how far the middle of
    the regions moves for each mm that the film point does, along a straight line.
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
    for q in range(DRIFTS):
        at = radius * q / (DRIFTS - 1)
        above += _middle(at, course, offsets, end, scale)[2] * at
        below += at * at
    return film, aim, above / below


@njit(inline="always")
def _middle(r, course, offsets, end, scale):
    """Between which rings of the table a film radius lies: the inner one, the share of the next; and their centre."""
    place = (1.0 - math.sqrt(max(1.0 - r / end, 0.0))) * scale
    ring = min(int(place), offsets.size - 2)
    f, t = place - ring, (r / end) ** 2
    middle = r * (course[0] + t * (course[1] + t * course[2]))
    return ring, f, middle + offsets[ring] * (1.0 - f) + offsets[ring + 1] * f


def _traced(lens: Lens, film_distance: float, film: np.ndarray, aim: np.ndarray, wavelength: float) -> np.ndarray:
    """(7, n) the rays in front, X … N in the camera's frame, and their CLEARANCE."""
    x, y = aim[0] - film, aim[1]
    size = 1.0 / np.sqrt(x * x + y * y + film_distance**2)
    given = {X: film, L: x * size, M: y * size, N: -film_distance * size}
    return Program(round_stop_steps(lens, film_distance, wavelength), np.float64).run(
        given, [X, Y, Z, L, M, N, CLEARANCE], len(film))


@njit(cache=True, error_model="numpy", nogil=True)
def _invariants(film, aim, lines, shares, radius, drift, eye, nearness):
    """What is fitted: of all rays the invariants (3, n); of the first ones weights (fits,) and fields (6, fits).

    And v (2, n), its reach in mm, and how many rays serve the fit. The places of lines (7, n) become the points of
    the rays that are nearest to the eye, from there; what does not arrive has an infinite margin.
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
def _errors(film, lines, v, radius, there, here, nearness, first):
    """How far off (rms, worst, in radians) the rays from the first on are: of objects in focus, and at infinity.

    there, here: (3, …) the polynomials' sums at those rays, of directions to objects in focus and of places.
    """
    total, worst, seen = 0.0, 0.0, 0
    for r in range(first, film.size):
        if lines[6, r] <= 1.0:
            q, u, vx, vy = r - first, film[r] / radius, v[0, r], v[1, r]
            px, py, pz = here[0, q] * u + here[1, q] * vx, here[1, q] * vy, here[2, q]
            dx, dy = there[0, q] * u + there[1, q] * vx - nearness * px, there[1, q] * vy - nearness * py
            dz = there[2, q] - nearness * pz
            size = math.sqrt(dx * dx + dy * dy + dz * dz)
            dx, dy, dz = dx / size - lines[3, r], dy / size - lines[4, r], dz / size - lines[5, r]
            far = dx * dx + dy * dy + dz * dz
            dx, dy = dx + nearness * (px - lines[0, r]), dy + nearness * (py - lines[1, r])
            dz += nearness * (pz - lines[2, r])
            square = max(dx * dx + dy * dy + dz * dz, far)
            total, worst, seen = total + square, max(worst, square), seen + 1
    return (math.sqrt(total / seen), math.sqrt(worst)) if seen else (math.inf, math.inf)


def _behind(lens: Lens, fo: FirstOrder, nearness: float, centre: float) -> float:
    """Film mm per radian of an object's place seen from the centre, paraxially, whichever way up its image stands.

    nearness: 1 / its distance.
    """
    efl = lens.front_index * fo.efl
    return abs(efl / (1.0 + nearness * (fo.front_principal - centre - efl)))


# The stage


@njit(inline="always")
def _of_two(q, k, b, c, n, real):
    """The part of one power of a: all terms in b and c up to the degree n, nested."""
    total = real(0)
    for j in range(n + 1):
        part = q[k]
        k += 1
        for _ in range(j):
            part = part * c + q[k]
            k += 1
        total = total * b + part
    return total


@cache
def polynomial_stage(n: int):
    """The stage for polynomials of the degree n in a, b, c."""
    low = _low(n)
    high_terms, low_terms = monomial_count(n), monomial_count(low)

    @stage
    def polynomial(lanes, p, key):
        """Replace the ray at the film by the ray in front of the lens. p: −film distance and 1 − drift over the reach,
        1 / film radius, z of the centre, 1 / distance from it, then the six polynomials.
        """
        real = lanes.dtype.type
        row = rows(lanes)
        x, y, z, l, m, n_ = row[X], row[Y], row[Z], row[L], row[M], row[N]
        a, b, c, total = row[A0], row[A1], row[A2], row[A3]
        f, g, h, e, d = row[A4], row[A5], row[A6], row[A7], row[A8]
        reach, drift, scale, centre, near = p[0], p[1], p[2], p[3], p[4]
        for i in range(B):
            ux, uy = x[i] * scale, y[i] * scale
            away = reach / n_[i]
            vx, vy = l[i] * away + x[i] * drift, m[i] * away + y[i] * drift
            a[i], b[i], c[i] = ux * ux + uy * uy, vx * vx + vy * vy, ux * vx + uy * vy
        at = HEAD
        _summed(lanes, p[at:], n)
        for i in range(B):
            f[i] = total[i]
        _summed(lanes, p[at + high_terms:], n)
        for i in range(B):
            g[i] = total[i]
        _summed(lanes, p[at + 2 * high_terms:], n)
        for i in range(B):
            h[i] = total[i]
        at += 3 * high_terms
        _summed(lanes, p[at:], low)
        for i in range(B):
            e[i] = total[i]
        _summed(lanes, p[at + low_terms:], low)
        for i in range(B):
            d[i] = total[i]
        _summed(lanes, p[at + 2 * low_terms:], low)
        for i in range(B):
            ux, uy = x[i] * scale, y[i] * scale
            away = reach / n_[i]
            vx, vy = l[i] * away + x[i] * drift, m[i] * away + y[i] * drift
            px, py, pz = e[i] * ux + d[i] * vx, e[i] * uy + d[i] * vy, total[i]
            dx, dy = f[i] * ux + g[i] * vx - near * px, f[i] * uy + g[i] * vy - near * py
            dz = h[i] - near * pz
            # Nearly a unit vector: two steps of Newton's for 1 / √
            square = dx * dx + dy * dy + dz * dz
            size = real(1.5) - real(0.5) * square
            size = size * (real(1.5) - real(0.5) * square * size * size)
            l[i], m[i], n_[i] = dx * size, dy * size, dz * size
            x[i], y[i], z[i] = px, py, pz + centre

    return polynomial


@cache
def _sum(n: int):
    """The function that leaves one polynomial of the rows A0, A1, A2 in A3: one loop, so few coefficients that
    they stay in registers.
    """
    @stage
    def sum_polynomial(lanes, q):
        real = lanes.dtype.type
        row = rows(lanes)
        a, b, c, total = row[A0], row[A1], row[A2], row[A3]
        for i in range(B):
            t = q[0] * a[i] + _of_two(q, 1, b[i], c[i], 1, real)
            if n >= 2:
                t = t * a[i] + _of_two(q, 4, b[i], c[i], 2, real)
            if n >= 3:
                t = t * a[i] + _of_two(q, 10, b[i], c[i], 3, real)
            if n >= 4:
                t = t * a[i] + _of_two(q, 20, b[i], c[i], 4, real)
            if n >= 5:
                t = t * a[i] + _of_two(q, 35, b[i], c[i], 5, real)
            total[i] = t

    return sum_polynomial


# Under names of the module: a function in the closure of a kernel would keep numba from finding that in its cache
_of_1, _of_2, _of_3, _of_4, _of_5 = (_sum(n) for n in range(1, 6))


@njit(inline="always")
def _summed(lanes, q, n):
    """One polynomial of the degree n, a constant."""
    if n == 1:
        _of_1(lanes, q)
    elif n == 2:
        _of_2(lanes, q)
    elif n == 3:
        _of_3(lanes, q)
    elif n == 4:
        _of_4(lanes, q)
    else:
        _of_5(lanes, q)
