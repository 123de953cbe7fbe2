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

from lensbench.blocktracer import round_through
from lensbench.driver import Program
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
    MARGIN,
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
from lensbench.normal_equations import solved
from lensbench.paraxial import FirstOrder, first_order
from lensbench.prescription import Lens, LensError
from lensbench.pupil_table import PupilTable

DEGREES = (3, 5, 7, 9, 11)
HEAD = 5                    # numbers before the coefficients
LEAST = 0.02                # of a ray's share
SLACK = 1.05                # (r / semi-diameter)² up to which a ray beyond the rim still serves the fit
JUDGES = 127                # rays on which the error is measured; with those of degree 9, one block of lanes
EVENLY = 0.6                # how far the rays' weights go from Chebyshev's (0) to their share of film and pupil (1)
SPREAD = (0.7548776662466927, 0.5698402909980532)       # whose multiples fill a square evenly: 1/ρ, 1/ρ² of ρ³ = ρ + 1
FARTHEST = 20.0             # × the lens's length: an entrance pupil beyond it is no place to measure from


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
        film, aim = _aimed(table, *places)
        fo = first_order(lens, wavelength)
        centre = _centre(lens, fo)
        ray, margin = _traced(lens, film_distance, film, aim, centre, wavelength)

        # What the invariants are made of
        drift = _drift(table)
        u = film / table.radius
        v = aim - [drift * film, 0.0 * film]
        reach = max(float(np.hypot(*v).max()), 1e-30)
        v /= reach
        a, b, c = u * u, v[0] ** 2 + v[1] ** 2, u * v[0]
        fits = slice(0, len(shares))
        use = margin[fits] < SLACK
        if use.sum() < 2 * terms(n):
            raise LensError("too little light passes this lens for a polynomial to be fitted: open the stop")
        shares, ray = np.where(use, shares, 0.0), np.where(margin < math.inf, ray, 0.0)
        high, few = _basis(a, b, c, n), _basis(a, b, c, low)
        point, direction = ray[:3], ray[3:]
        nearness = 1.0 / (distance - lens.length - film_distance + centre)
        given = shares, u[fits], v[:, fits]
        towards = solved(high[fits], *given, (direction + nearness * point)[:, fits])
        points = solved(few[fits], *given, point[:, fits])

        # The error on the rays that were held out: of objects in focus, and at infinity
        seen = np.nonzero(margin <= 1.0)[0]
        seen = seen[seen >= len(shares)]
        from_there = _assembled(few[seen], points, u[seen], v[:, seen])
        there = _assembled(high[seen], towards, u[seen], v[:, seen]) - nearness * from_there
        off, beside = there / np.sqrt((there**2).sum(0)) - direction[:, seen], from_there - point[:, seen]
        behind = _behind(lens, fo, nearness, centre)
        error = np.sqrt(np.maximum(((off + nearness * beside) ** 2).sum(0), (off**2).sum(0))) * behind
        numbers = [-film_distance / reach, (1.0 - drift) / reach, 1.0 / table.radius,
                   centre - lens.length - film_distance, nearness]
        return cls(degree, np.concatenate([numbers, *towards, *points]),
                   float(np.sqrt((error**2).mean())) if seen.size else math.inf,
                   float(error.max()) if seen.size else math.inf)

    @property
    def step(self) -> Step:
        """The step from an aimed ray at the film to the ray in front of the lens."""
        return Step(_kernel(self.degree // 2), self.numbers)


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


def terms(n: int) -> int:
    """How many monomials three variables have up to the total degree n."""
    return (n + 1) * (n + 2) * (n + 3) // 6


def _low(n: int) -> int:
    """The degree in a, b, c of the positions."""
    return min(n, max(n - 1, 2))


@cache
def _powers(n: int) -> np.ndarray:
    """(3, terms) powers of a, b and c, in the order that the kernel sums them."""
    return np.array([(n - i, i - j, j - k) for i in range(n + 1) for j in range(i + 1) for k in range(j + 1)]).T


def _basis(a, b, c, n: int) -> np.ndarray:
    """(rays, terms) monomials."""
    powers = np.ones((3, n + 1, len(a)))
    for q in range(1, n + 1):
        powers[:, q] = powers[:, q - 1] * (a, b, c)
    i, j, k = _powers(n)
    return (powers[0, i] * powers[1, j] * powers[2, k]).T


def _aimed(table: PupilTable, radii, reach, turn) -> tuple[np.ndarray, np.ndarray]:
    """Rays from film points at the share `radii` of the table's radius to its regions' upper halves.

    reach: from the region's centre (0) to its rim (1); turn: along the rim, 0 … 1. Returns the film points' x
    (n,) and the points on the plane of the rear vertex (2, n), mm.
    """
    film = radii * table.radius
    ring, inner = table.ring(film)
    t = turn * (table.outline.shape[1] - 1)
    corner = np.minimum(t.astype(int), table.outline.shape[1] - 2)

    def along(which):
        f = (t - corner)[:, None]
        return table.outline[which, corner] * (1.0 - f) + table.outline[which, corner + 1] * f

    x, y = (reach[:, None] * (along(ring) * (1.0 - inner)[:, None] + along(ring + 1) * inner[:, None])).T
    return film, np.stack([x + table.centres[ring] * (1.0 - inner) + table.centres[ring + 1] * inner, y])


def _traced(lens: Lens, film_distance: float, film, aim, centre: float, wavelength: float):
    """(6, n) the point nearest to (0, 0, centre) on each ray in front, from there, and its direction; margins (n,)."""
    n = len(film)
    x, y = aim[0] - film, aim[1]
    size = 1.0 / np.sqrt(x * x + y * y + film_distance**2)
    given = {X: film, L: x * size, M: y * size, N: -film_distance * size}
    out = Program(round_through(lens, film_distance, wavelength), np.float64).run(given, [X, Y, Z, L, M, N, MARGIN], n)
    point, direction = out[:3], out[3:6]
    point[2] -= centre - lens.length - film_distance
    point -= (point * direction).sum(0) * direction
    return out[:6], np.where(np.isfinite(out[:6]).all(0), out[6], math.inf)


def _centre(lens: Lens, fo: FirstOrder) -> float:
    """From where rays in front of the lens are measured: its entrance pupil, or its first vertex (lens frame, mm)."""
    z = fo.entrance_pupil.z
    return z if abs(z) < FARTHEST * lens.length else 0.0


def _drift(table: PupilTable) -> float:
    """How far the middle of the regions moves for each mm that the film point does, along a straight line."""
    film = table.radius * np.linspace(0.0, 1.0, 17)
    ring, inner = table.ring(film)
    return float((table.centres[ring] * (1.0 - inner) + table.centres[ring + 1] * inner) @ film / (film @ film))


def _behind(lens: Lens, fo: FirstOrder, nearness: float, centre: float) -> float:
    """Film mm per radian of an object's place seen from the centre, paraxially; nearness: 1 / its distance."""
    efl = lens.front_index * fo.efl
    return efl / (1.0 + nearness * (fo.front_principal - centre - efl))


def _assembled(basis, polynomials, u, v) -> np.ndarray:
    """(3, rays) the vector field again."""
    along_u, along_v, along_z = (basis @ q for q in polynomials)
    return np.stack([along_u * u + along_v * v[0], along_v * v[1], along_z])


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
def _kernel(n: int):
    """The stage for polynomials of the degree n in a, b, c."""
    low = _low(n)
    high_terms, low_terms = terms(n), terms(low)

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
    def summed(lanes, q):
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

    return summed


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
