"""Shapes of surfaces: sag, gradient and intersection with a ray, for conics, aspheres, cylinders and toroids.

Lengths in mm. The vertex is the origin, light travels along +z, and the curvature c = 1/R is positive when the centre
of curvature lies at +z. The sag is z = c r² / (1 + √(1 − (1+k) c² r²)) + Σ a_p r^p; with different curvatures in the
sections x–z and y–z, z = A / (1 + √(1 − c_x² x² − c_y² y²)), A = c_x x² + c_y y². The gradient is that of F = 0 with
F_z > 0, of any length. The scalar tracer's table has a kind and a row of numbers for each surface; coefficients are
stored as a_p h^p, h the semi-diameter, so that float32 neither overflows nor underflows.
"""

from collections.abc import Iterable
from math import sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.kernels.block import offsets
from lensbench.core.kernels.cache import njit

SPHERE, CONIC, EVEN, ASPHERE, TOROID = range(5)         # kinds; EVEN: even powers only, ASPHERE: any
HIGHEST_POWER = 20                                      # of an aspheric term; the lowest is 2
TERMS = HIGHEST_POWER - 1

(CURVATURE,                             # c of the section y–z (1/mm)
 VERTEX,                                # z of the vertex in the lens frame (mm)
 RIM2,                                  # square of the semi-diameter (mm²)
 BEFORE, AFTER,                         # indices of the media on the scene's and on the film's side
 K,                                     # conic constant
 ACROSS,                                # c of the section x–z (1/mm)
 UNIT,                                  # 1 / h²
 PLACE,                                 # x, y, z of the vertex of a tilted or decentred surface, lens frame (mm)
 AXES,                                  # and its rotation, row by row
 FIRST_TERM,                            # coefficients of r², r³, … (ASPHERE) or r², r⁴, … (EVEN)
 COLUMNS) = offsets(1, 1, 1, 1, 1, 1, 1, 1, 3, 9, TERMS)

TOLERANCE = 450                 # × machine epsilon: residual of a hit, 1e-13 mm in float64
OUTSIDE = 1.0                   # (r / h)² of a point of the conic from which Newton's method no longer starts
_STEPS, _HALVINGS = 60, 30      # of Newton's method, and of one of its steps


class SurfaceTable(NamedTuple):
    """Surfaces as the scalar tracer reads them, from the scene to the film.

    kinds: (n,) of SPHERE … TOROID. posed: (n,) whether tilted or decentred. numbers: (n, COLUMNS), float32 or float64.
    """

    kinds: np.ndarray
    posed: np.ndarray
    numbers: np.ndarray

    def part(self, first: int, end: int) -> "SurfaceTable":
        """Surfaces first … end − 1, as views."""
        return SurfaceTable(self.kinds[first:end], self.posed[first:end], self.numbers[first:end])


def shape(curvature: float, conic: float, aspheric: Iterable[tuple[int, float]], curvature_x: float | None,
          semi_diameter: float) -> tuple[int, np.ndarray]:
    """Kind, and a row of numbers (COLUMNS,) with the columns that describe the shape filled in; lengths in mm."""
    kind, row = SPHERE, np.zeros(COLUMNS)
    terms = dict(aspheric)
    row[CURVATURE], row[K], row[ACROSS], row[UNIT] = curvature, conic, curvature, semi_diameter**-2
    if curvature_x is not None:
        kind, row[ACROSS] = TOROID, curvature_x
    elif terms:
        even = all(power % 2 == 0 for power in terms)
        kind = EVEN if even else ASPHERE
        for power, a in terms.items():
            row[FIRST_TERM + (power // 2 - 1 if even else power - 2)] = a * semi_diameter**power
    elif conic != 0.0 and curvature != 0.0:
        kind = CONIC
    return kind, row


@njit(cache=True, nogil=True, error_model="numpy")
def _terms(table, i, r2):
    """(Σ a_p r^p, its derivative by r divided by r) for r² = r2."""
    numbers = table.numbers
    zero = numbers.dtype.type(0)
    value, slope = zero, zero
    u = r2 * numbers[i, UNIT]
    if table.kinds[i] == EVEN:
        for j in range(HIGHEST_POWER // 2 - 1, -1, -1):
            a = numbers[i, FIRST_TERM + j]
            value = value * u + a
            slope = slope * u + numbers.dtype.type(2 * j + 2) * a
    else:
        root = sqrt(u)
        for j in range(TERMS - 1, -1, -1):
            a = numbers[i, FIRST_TERM + j]
            value = value * root + a
            slope = slope * root + numbers.dtype.type(j + 2) * a
    return value * u, slope * numbers[i, UNIT]


@njit(cache=True, nogil=True, error_model="numpy")
def sag_and_slopes(table, i, x, y):
    """(sag, ∂/∂x, ∂/∂y) at (x, y); NaN beyond the equator of the conic or toroid."""
    numbers, kind = table.numbers, table.kinds[i]
    one, c = numbers.dtype.type(1), numbers[i, CURVATURE]
    if kind == TOROID:
        across = numbers[i, ACROSS]
        bend = across * x * x + c * y * y
        inside = one - across * across * x * x - c * c * y * y
        if not inside > numbers.dtype.type(0):
            nan = numbers.dtype.type(np.nan)
            return nan, nan, nan
        root = sqrt(inside)
        share = one / (one + root)
        z = bend * share
        return (z, across * x * share * (one + one + z * across / root),
                c * y * share * (one + one + z * c / root))
    r2 = x * x + y * y
    inside = one - (one + numbers[i, K]) * c * c * r2
    if not inside > numbers.dtype.type(0):
        nan = numbers.dtype.type(np.nan)
        return nan, nan, nan
    root = sqrt(inside)
    z, slope = c * r2 / (one + root), c / root
    if kind == EVEN or kind == ASPHERE:
        more, steeper = _terms(table, i, r2)
        z, slope = z + more, slope + steeper
    return z, slope * x, slope * y


@njit(cache=True, nogil=True, error_model="numpy")
def intersect(table, i, x, y, z, p, q, r, sign):
    """Intersection of a ray with a surface that is no sphere → (x, y, z, F_x, F_y, F_z); NaN for a miss.

    (x, y, z) is the foot of the perpendicular from the vertex on the ray, (p, q, r) its direction, of any length. sign:
    1 for light along +z, −1 against it; r may differ in sign for rays from beyond 90°. The hit is where the ray crosses
    the surface in the direction of `sign`, on the vertex's side of the equator. Conics in closed form, the others by
    Newton's method from the conic, its steps halved until the residual falls; without convergence to TOLERANCE it is a
    miss.
    """
    numbers = table.numbers
    real = numbers.dtype.type
    zero, one, half = real(0), real(1), real(0.5)
    kind, c, k = table.kinds[i], numbers[i, CURVATURE], numbers[i, K]
    nan = real(np.nan)
    if kind == TOROID:
        c, k = half * (c + numbers[i, ACROSS]), zero

    # Intersect the conic: F − 2 b t + a t² = 0
    squared = p * p + q * q + r * r
    F = c * (x * x + y * y + z * z + k * z * z) - z - z
    a, b = c * (squared + k * r * r), r * (one - c * k * z)
    discriminant = b * b - a * F
    if kind == CONIC and not discriminant >= zero:
        return nan, nan, nan, nan, nan, nan
    root = sign * sqrt(max(discriminant, zero))
    t = F / (b + root) if b * sign > zero else (b - root) / a
    side = one - (one + k) * c * (z + t * r)
    if kind == CONIC:
        if not side > zero:
            return nan, nan, nan, nan, nan, nan
        x, y, z = x + t * p, y + t * q, z + t * r
        return x, y, z, -c * x, -c * y, side

    # Start Newton's method on the conic, or else on the vertex's plane, or else nearest the axis. Beyond the rim the
    # sag of a strong asphere may be a tenth of its conic's, and the plane is nearer
    near = ((x + t * p) ** 2 + (y + t * q) ** 2) * numbers[i, UNIT] < real(OUTSIDE)
    height, slope_x, slope_y = sag_and_slopes(table, i, x + t * p, y + t * q)
    if not (side > zero and near and height == height):
        t = -z / r
        height, slope_x, slope_y = sag_and_slopes(table, i, x + t * p, y + t * q)
    if not height == height:
        t = -(x * p + y * q) / (p * p + q * q)
        height, slope_x, slope_y = sag_and_slopes(table, i, x + t * p, y + t * q)
    if not height == height:
        return nan, nan, nan, nan, nan, nan

    # Iterate, halving each step until the residual falls
    residual = z + t * r - height
    rounding = real(np.finfo(numbers.dtype).eps)
    least_step = rounding * (one + abs(x) + abs(y) + abs(z)) / sqrt(squared)
    for _ in range(_STEPS):
        through = sign * (r - slope_x * p - slope_y * q)
        if residual == zero or not through > zero:
            break
        step = -sign * residual / through
        if abs(step) <= least_step:
            break
        improved = False
        for _ in range(_HALVINGS):
            ahead = t + step
            height, new_x, new_y = sag_and_slopes(table, i, x + ahead * p, y + ahead * q)
            left = z + ahead * r - height
            if abs(left) < abs(residual):
                t, residual, slope_x, slope_y, improved = ahead, left, new_x, new_y, True
                break
            step *= half
            if abs(step) <= least_step:
                break
        if not improved:
            break

    # Reject a ray that has not converged, or that crosses the surface in the other direction
    x, y, z = x + t * p, y + t * q, z + t * r
    through = sign * (r - slope_x * p - slope_y * q)
    if not (abs(residual) <= real(TOLERANCE) * rounding * max(one, abs(z)) and through > zero):
        return nan, nan, nan, nan, nan, nan
    return x, y, z, -slope_x, -slope_y, one


@njit(cache=True, nogil=True, error_model="numpy")
def _sags(table, x, y, out):
    """Sag of surface 0 at points (n,) into out (n,)."""
    for j in range(x.size):
        out[j] = sag_and_slopes(table, 0, x[j], y[j])[0]


def sags(kind: int, row: np.ndarray, x: ArrayLike, y: ArrayLike) -> np.ndarray:
    """Sag (mm) of a kind with numbers (COLUMNS,) at points x, y (mm, broadcast); NaN beyond the equator."""
    # Copies: numpy 2.0 warns where numba asks whether a broadcast view may be written
    x, y = (np.array(coordinate) for coordinate in np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float)))
    out = np.empty(x.size)
    table = SurfaceTable(np.array([kind]), np.zeros(1, np.bool_), row[None, :])
    _sags(table, np.ascontiguousarray(x.ravel()), np.ascontiguousarray(y.ravel()), out)
    return out.reshape(x.shape)
