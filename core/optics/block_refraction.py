"""Refraction of a block of rays at the surfaces of a lens: a stage for each kind, over a run of surfaces of that kind.

The frame is that of the last vertex met, z runs with the light, mm. Directions are optical: (L, M, N) has the length n,
the index of the medium. A ray that misses or is totally reflected becomes NaN.

The intersection is Welford's quotient (Aberrations of Optical Systems, ch. 4), with his F, and with K = c (n′ cos I′ −
n cos I) of the refraction. The ray is first moved to the foot of the perpendicular from the vertex: only small numbers
are squared then, and his G is N.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from lensbench.core.kernels.block import A0, A1, A2, A3, A4, A5, CLEARANCE, B, L, M, N, X, Y, Z, rows, stage
from lensbench.core.kernels.cache import njit
from lensbench.core.optics import surfaces
from lensbench.core.optics.surfaces import ASPHERE, CONIC, EVEN, HIGHEST_POWER, OUTSIDE, SPHERE, TERMS, TOROID

# The record of a surface; those of a run, in the order met, are the parameters of its step
(GAP,                                   # from the vertex before to this one, along the light (mm)
 CURVATURE,                             # c of the section y–z, positive towards the light's end (1/mm)
 RIM,                                   # 1 / h², h the semi-diameter
 SLOWNESS,                              # 1 / n², n the index before the surface
 STEP,                                  # n′² − n², n′ the index behind it
 BEND,                                  # n² c
 LEAST,                                 # behind the surface, a ray with no larger N is lost: 0, or −inf if tilted
 SPHERE_RECORD,                         # length of the record of a sphere or plane; the other kinds have more
 ) = range(8)
K, COEFFICIENTS = SPHERE_RECORD, SPHERE_RECORD + 1  # conic constant; coefficients of its kind, for r in units of h
CURVATURE_X = SPHERE_RECORD                         # c of the section x–z of a toroid
CONIC_RECORD = TOROID_RECORD = COEFFICIENTS
EVEN_RECORD, ASPHERE_RECORD = COEFFICIENTS + HIGHEST_POWER // 2, COEFFICIENTS + TERMS

# Scratch rows of Newton's method
DISTANCE, LAST_STEP, SLOPE_X, SLOPE_Y, SUM, SUM_SLOPE = A0, A1, A2, A3, A4, A5

STEPS = (3, 6)          # of Newton's method from the conic, in float32 and in float64
MORE_STEPS = 10         # further ones in a block with a ray that has not converged
CONVERGED = 1e-8        # greatest (last step / h)²; the step after it would be about the square
NEAR_EQUATOR = 1e-4     # least 1 − (1 + k) c² r² that Newton's method evaluates


@stage
def refract_at_spheres(lanes, p, ints, key):
    """Rays through a run of spheres and planes."""
    real = lanes.dtype.type
    row = rows(lanes)
    X_, Y_, Z_, L_, M_, N_, clearance = row[X], row[Y], row[Z], row[L], row[M], row[N], row[CLEARANCE]
    for s in range(0, p.size, SPHERE_RECORD):
        gap, c, rim, least = p[s + GAP], p[s + CURVATURE], p[s + RIM], p[s + LEAST]
        slowness, step, bend = p[s + SLOWNESS], p[s + STEP], p[s + BEND]
        for i in range(B):
            # Move to the foot of the perpendicular from the vertex
            l, m, n = L_[i], M_[i], N_[i]
            x, y, z = X_[i], Y_[i], Z_[i] - gap
            e = -(l * x + m * y + n * z) * slowness
            x, y, z = x + e * l, y + e * m, z + e * n

            # Intersect: t = F / (G + n cos I), (n cos I)² = G² − n² c F
            F = c * (x * x + y * y + z * z) - (z + z)
            cos2_in = n * n - bend * F
            cos_in, cos_out = math.sqrt(cos2_in), math.sqrt(cos2_in + step)
            t = F / (n + cos_in)
            x, y, z = x + t * l, y + t * m, z + t * n

            # Refract
            g = cos_out - cos_in
            K_ = g * c
            side = real(1) - c * z
            n = n + g * side
            X_[i], Y_[i], Z_[i] = x, y, z
            L_[i], M_[i], N_[i] = l - K_ * x, m - K_ * y, n

            # Keep the greatest clearance; a NaN stays, for all that follows is NaN
            v = (x * x + y * y) * rim
            v = v if (side > real(0)) & (n > least) else real(np.inf)
            clearance[i] = clearance[i] if clearance[i] >= v else v


@stage
def refract_at_conics(lanes, p, ints, key):
    """Rays through a run of conics."""
    real = lanes.dtype.type
    row = rows(lanes)
    X_, Y_, Z_, L_, M_, N_, clearance = row[X], row[Y], row[Z], row[L], row[M], row[N], row[CLEARANCE]
    for s in range(0, p.size, CONIC_RECORD):
        gap, c, rim, k, least = p[s + GAP], p[s + CURVATURE], p[s + RIM], p[s + K], p[s + LEAST]
        slowness, step, bend = p[s + SLOWNESS], p[s + STEP], p[s + BEND]
        kc, kc2 = k * c, k * c * c
        for i in range(B):
            # Move to the foot of the perpendicular from the vertex
            l, m, n = L_[i], M_[i], N_[i]
            x, y, z = X_[i], Y_[i], Z_[i] - gap
            e = -(l * x + m * y + n * z) * slowness
            x, y, z = x + e * l, y + e * m, z + e * n

            # Intersect: F − 2 b t + a t² = 0, the root where the ray crosses the surface along its travel
            F = c * (x * x + y * y + z * z) + kc * z * z - (z + z)
            a, b = bend + kc * n * n, n * (real(1) - kc * z)
            root = math.sqrt(b * b - a * F)
            above, below = (F, b + root) if b > real(0) else (b - root, a)
            t = above / below
            x, y, z = x + t * l, y + t * m, z + t * n

            # Refract at the gradient (−c x, −c y, side)
            side = real(1) - (c + kc) * z
            r2 = x * x + y * y
            steep = real(1) - kc2 * r2                      # its squared length
            cos2_in = root * root / steep
            g = (math.sqrt(cos2_in + step) - math.sqrt(cos2_in)) / math.sqrt(steep)
            n = n + g * side
            X_[i], Y_[i], Z_[i] = x, y, z
            L_[i], M_[i], N_[i] = l - g * c * x, m - g * c * y, n

            # Keep the greatest clearance
            v = r2 * rim
            v = v if (side > real(0)) & (n > least) else real(np.inf)
            clearance[i] = clearance[i] if clearance[i] >= v else v


@stage
def _start_newton(lanes, p, s, c, k):
    """The foot of the perpendicular, and DISTANCE to the conic (c, k), or to the plane where the ray misses the conic.

    So too where it meets the conic beyond the clear aperture: a strong asphere may have a tenth of its conic's sag.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    X_, Y_, Z_, L_, M_, N_, distance = row[X], row[Y], row[Z], row[L], row[M], row[N], row[DISTANCE]
    gap, slowness, rim = p[s + GAP], p[s + SLOWNESS], p[s + RIM]
    bend, kc = c / slowness, k * c
    for i in range(B):
        l, m, n = L_[i], M_[i], N_[i]
        x, y, z = X_[i], Y_[i], Z_[i] - gap
        e = -(l * x + m * y + n * z) * slowness
        x, y, z = x + e * l, y + e * m, z + e * n
        X_[i], Y_[i], Z_[i] = x, y, z
        F = c * (x * x + y * y + z * z) + kc * z * z - (z + z)
        a, b = bend + kc * n * n, n * (real(1) - kc * z)
        root = math.sqrt(max(b * b - a * F, real(0)))
        above, below = (F, b + root) if b > real(0) else (b - root, a)
        t = above / below
        at_x, at_y = x + t * l, y + t * m
        near = ((c + kc) * (z + t * n) < real(1)) & ((at_x * at_x + at_y * at_y) * rim < real(OUTSIDE))
        distance[i] = t if near else -z / n


@stage
def _converged(lanes, p, s):
    """Whether LAST_STEP of every ray is small; a lost ray is NaN, and counts as converged."""
    real = lanes.dtype.type
    last, limit = rows(lanes)[LAST_STEP], real(CONVERGED) * p[s + SLOWNESS] / p[s + RIM]
    moving = 0
    for i in range(B):
        moving += 1 if last[i] * last[i] > limit else 0
    return moving == 0


@njit(inline="always")
def _newton_step(real, x, y, z, l, m, n, c, r2, root, terms, term_slope):
    """One step of Newton's method towards an asphere → (distance from the surface along the ray, slope of the sag).

    root = √(1 − (1 + k) c² r²); terms: Σ a_p r^p; slopes are derivatives by r divided by r. Height and slope are
    multiplied by root (1 + root), so that a step has one root and one division.
    """
    whole = root * (real(1) + root)
    height = (z - terms) * whole - c * r2 * root
    slope = c * (real(1) + root) + term_slope * whole
    return height / (n * whole - slope * (x * l + y * m)), slope / whole


@stage
def refract_at_even_aspheres(lanes, p, ints, key):
    """Rays through a run of aspheres of even powers: Newton's method on z = sag(r²), then refraction."""
    real = lanes.dtype.type
    row = rows(lanes)
    X_, Y_, Z_, L_, M_, N_ = row[X], row[Y], row[Z], row[L], row[M], row[N]
    distance, last, SX, SY = row[DISTANCE], row[LAST_STEP], row[SLOPE_X], row[SLOPE_Y]
    for s in range(0, p.size, EVEN_RECORD):
        c, unit, k, f = p[s + CURVATURE], p[s + RIM], p[s + K], s + COEFFICIENTS
        a2, a4, a6, a8, a10 = p[f], p[f + 1], p[f + 2], p[f + 3], p[f + 4]
        a12, a14, a16, a18, a20 = p[f + 5], p[f + 6], p[f + 7], p[f + 8], p[f + 9]
        equator = (real(1) + k) * c * c
        _start_newton(lanes, p, s, c, k)
        for step in range(STEPS[lanes.itemsize // 8] + 1 + MORE_STEPS):
            if step > STEPS[lanes.itemsize // 8] and _converged(lanes, p, s):
                break
            for i in range(B):
                x, y, z = X_[i] + distance[i] * L_[i], Y_[i] + distance[i] * M_[i], Z_[i] + distance[i] * N_[i]
                r2 = x * x + y * y
                root = math.sqrt(max(real(1) - equator * r2, real(NEAR_EQUATOR)))

                # Σ a u^j, u = (r / h)², and its derivative, both over u
                u = r2 * unit
                sum_ = ((((((((a20 * u + a18) * u + a16) * u + a14) * u + a12) * u + a10) * u + a8) * u + a6) * u + a4
                        ) * u + a2
                sum_slope = ((((real(20) * a20 * u + real(18) * a18) * u + real(16) * a16) * u + real(14) * a14) * u
                             + real(12) * a12) * u + real(10) * a10
                sum_slope = (((sum_slope * u + real(8) * a8) * u + real(6) * a6) * u + real(4) * a4) * u + real(2) * a2

                advance, slope = _newton_step(real, x, y, z, L_[i], M_[i], N_[i], c, r2, root, sum_ * u,
                                              sum_slope * unit)
                last[i], SX[i], SY[i] = advance, slope * x, slope * y
                distance[i] = distance[i] - advance
        _refract(lanes, p, s, equator, equator)


@stage
def refract_at_aspheres(lanes, p, ints, key):
    """Rays through a run of aspheres of any powers, as `refract_at_even_aspheres`; loops of their own sum the terms."""
    real = lanes.dtype.type
    row = rows(lanes)
    X_, Y_, Z_, L_, M_, N_ = row[X], row[Y], row[Z], row[L], row[M], row[N]
    distance, last, SX, SY = row[DISTANCE], row[LAST_STEP], row[SLOPE_X], row[SLOPE_Y]
    sums, sum_slopes = row[SUM], row[SUM_SLOPE]
    for s in range(0, p.size, ASPHERE_RECORD):
        c, unit, k = p[s + CURVATURE], p[s + RIM], p[s + K]
        equator = (real(1) + k) * c * c
        _start_newton(lanes, p, s, c, k)
        for step in range(STEPS[lanes.itemsize // 8] + 1 + MORE_STEPS):
            if step > STEPS[lanes.itemsize // 8] and _converged(lanes, p, s):
                break

            # Σ a u^j, u = r / h (held in SLOPE_X), and its derivative
            for i in range(B):
                x, y = X_[i] + distance[i] * L_[i], Y_[i] + distance[i] * M_[i]
                SX[i] = math.sqrt((x * x + y * y) * unit)
                sums[i], sum_slopes[i] = real(0), real(0)
            for j in range(TERMS - 1, -1, -1):
                term = p[s + COEFFICIENTS + j]
                more = real(j + 2) * term
                for i in range(B):
                    sums[i], sum_slopes[i] = sums[i] * SX[i] + term, sum_slopes[i] * SX[i] + more

            # One step of Newton's method
            for i in range(B):
                x, y, z = X_[i] + distance[i] * L_[i], Y_[i] + distance[i] * M_[i], Z_[i] + distance[i] * N_[i]
                r2 = x * x + y * y
                root = math.sqrt(max(real(1) - equator * r2, real(NEAR_EQUATOR)))
                advance, slope = _newton_step(real, x, y, z, L_[i], M_[i], N_[i], c, r2, root, sums[i] * r2 * unit,
                                              sum_slopes[i] * unit)
                last[i], SX[i], SY[i] = advance, slope * x, slope * y
                distance[i] = distance[i] - advance
        _refract(lanes, p, s, equator, equator)


@stage
def refract_at_toroids(lanes, p, ints, key):
    """Rays through a run of cylinders and toroids: Newton's method from the sphere of mean curvature.

    The sag is A / (1 + √), A = c_x x² + c_y y²; height and derivative are multiplied by √ (1 + √)².
    """
    real = lanes.dtype.type
    row = rows(lanes)
    X_, Y_, Z_, L_, M_, N_ = row[X], row[Y], row[Z], row[L], row[M], row[N]
    distance, last, SX, SY = row[DISTANCE], row[LAST_STEP], row[SLOPE_X], row[SLOPE_Y]
    for s in range(0, p.size, TOROID_RECORD):
        c_y, c_x = p[s + CURVATURE], p[s + CURVATURE_X]
        _start_newton(lanes, p, s, real(0.5) * (c_y + c_x), real(0))
        for step in range(STEPS[lanes.itemsize // 8] + 1 + MORE_STEPS):
            if step > STEPS[lanes.itemsize // 8] and _converged(lanes, p, s):
                break
            for i in range(B):
                x, y, z = X_[i] + distance[i] * L_[i], Y_[i] + distance[i] * M_[i], Z_[i] + distance[i] * N_[i]
                bend_x, bend_y = c_x * x, c_y * y
                root = math.sqrt(max(real(1) - bend_x * bend_x - bend_y * bend_y, real(NEAR_EQUATOR)))
                outer = real(1) + root
                whole = root * outer * outer
                A = bend_x * x + bend_y * y
                both = real(2) * root * outer
                slope_x, slope_y = bend_x * (both + A * c_x), bend_y * (both + A * c_y)
                advance = (z * whole - A * root * outer) / (N_[i] * whole - slope_x * L_[i] - slope_y * M_[i])
                share = real(1) / whole
                last[i], SX[i], SY[i] = advance, slope_x * share, slope_y * share
                distance[i] = distance[i] - advance
        _refract(lanes, p, s, c_x * c_x, c_y * c_y)


@stage
def _refract(lanes, p, s, equator_x, equator_y):
    """Refraction where Newton's method ended: DISTANCE from the foot, SLOPE_X and SLOPE_Y of the sag.

    A ray is lost if LAST_STEP is not small, or if equator_x x² + equator_y y² is not below 1.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    X_, Y_, Z_, L_, M_, N_, clearance = row[X], row[Y], row[Z], row[L], row[M], row[N], row[CLEARANCE]
    distance, last, SX, SY = row[DISTANCE], row[LAST_STEP], row[SLOPE_X], row[SLOPE_Y]
    rim, slowness, step, least = p[s + RIM], p[s + SLOWNESS], p[s + STEP], p[s + LEAST]
    for i in range(B):
        l, m, n = L_[i], M_[i], N_[i]
        x, y, z = X_[i] + distance[i] * l, Y_[i] + distance[i] * m, Z_[i] + distance[i] * n
        slope_x, slope_y = SX[i], SY[i]

        # Refract at the gradient (−slope_x, −slope_y, 1)
        steep = math.sqrt(real(1) + slope_x * slope_x + slope_y * slope_y)
        cos_in = (n - slope_x * l - slope_y * m) / steep
        g = (math.sqrt(cos_in * cos_in + step) - cos_in) / steep
        n = n + g
        X_[i], Y_[i], Z_[i] = x, y, z
        L_[i], M_[i], N_[i] = l - g * slope_x, m - g * slope_y, n

        # Keep the greatest clearance
        converged = (last[i] * last[i] * rim <= real(CONVERGED) * slowness) & (
            equator_x * x * x + equator_y * y * y < real(1))
        v = (x * x + y * y) * rim
        v = v if converged & (cos_in > real(0)) & (n > least) else real(np.inf)
        clearance[i] = clearance[i] if clearance[i] >= v else v


class Run(NamedTuple):
    """How a block meets the surfaces of one kind."""

    stage: Any
    length: int                                             # of a record
    columns: Callable[[np.ndarray, float], dict[int, Any]]  # of its shape; from a row of `surfaces`, and the sign of z


def _asphere(count: int) -> Callable[[np.ndarray, float], dict[int, Any]]:
    """The columns of an asphere with so many coefficients."""
    terms = slice(surfaces.FIRST_TERM, surfaces.FIRST_TERM + count)
    return lambda row, sign: {K: row[surfaces.K], COEFFICIENTS: sign * row[terms]}


RUNS = {
    SPHERE: Run(refract_at_spheres, SPHERE_RECORD, lambda row, sign: {}),
    CONIC: Run(refract_at_conics, CONIC_RECORD, lambda row, sign: {K: row[surfaces.K]}),
    EVEN: Run(refract_at_even_aspheres, EVEN_RECORD, _asphere(EVEN_RECORD - COEFFICIENTS)),
    ASPHERE: Run(refract_at_aspheres, ASPHERE_RECORD, _asphere(ASPHERE_RECORD - COEFFICIENTS)),
    TOROID: Run(refract_at_toroids, TOROID_RECORD, lambda row, sign: {CURVATURE_X: sign * row[surfaces.ACROSS]}),
}
