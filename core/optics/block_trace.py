"""The block tracer: rays through every surface of a lens, in either direction.

Camera frame in and out: mm, the film's centre at the origin, the scene at −z.
For each surface the loops over the lanes that its kind needs: one for spheres and
planes alike, one for conics, and Newton's, without a branch, for the others. The
direction is carried n times as long, n the index it runs in; the ray is first
brought to the foot of the perpendicular from the vertex, so that only small
numbers are squared; a ray that misses or is totally reflected becomes a NaN.
(Welford, Aberrations of Optical Systems, ch. 4, for the quotient form; the foot
is the usual cure of its cancellation.)
"""

import math

import numpy as np

from lensbench.kernels.block import A0, A1, A2, A3, A4, A5, CLEARANCE, WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage
from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens
from lensbench.optics.surfaces import (
    ACROSS,
    ASPHERE,
    CONIC,
    EVEN,
    FIRST_TERM,
    HIGHEST_POWER,
    KIND,
    SPHERE,
    TERMS,
    TOROID,
    UNIT,
)

SURFACE = 7             # numbers of any surface: kind, gap, curvature, rim: 1 / h², 1 / n², n′² − n², n² c
MORE = {SPHERE: 0, CONIC: 1, EVEN: 1 + HIGHEST_POWER // 2, ASPHERE: 1 + TERMS, TOROID: 1}     # k and terms, or c_x
EVENS, ALL = SURFACE + MORE[EVEN], SURFACE + MORE[ASPHERE]
STEPS = (3, 6)          # of Newton's method from the conic, in float32 and in float64
MORE_STEPS = 5          # in a block of which some ray still moves
STILL = 1e-8            # (last step / h)² that is taken for convergence: the next would be as its square
NEAR_EQUATOR = 1e-4     # of 1 − (1 + k) c² r²: Newton goes no nearer, or farther


def pack_lens(lens: Lens, film_distance: float, wavelength: float = D_LINE, towards: str = "scene",
           part: slice = slice(None)) -> np.ndarray:
    """The parameters of `trace`: which way, then SURFACE numbers and MORE for each surface in the order met.

    film_distance: last vertex → film (mm). towards: "scene" (from the film), or "film" (from the scene).
    part: of the surfaces in that order; between two parts a direction is as long as the index it runs in.
    """
    indices, vertices = lens.indices(wavelength), lens.vertices
    sceneward = towards == "scene"
    order = (range(len(vertices) - 1, -1, -1) if sceneward else range(len(vertices)))[part]
    sign = -1.0 if sceneward else 1.0
    at = 0.0
    numbers = [sign]
    for i in order:
        surface, shape = lens.surfaces[i], lens.surfaces[i].shape
        before, after = (indices[i + 1], indices[i]) if sceneward else (indices[i], indices[i + 1])
        place = sign * (vertices[i] - lens.length - film_distance)
        c, kind = sign * surface.curvature, int(shape[KIND])
        numbers += [kind, place - at, c, shape[UNIT], before**-2, after**2 - before**2, before**2 * c]
        if kind == TOROID:
            numbers.append(sign * shape[ACROSS])
        elif kind != SPHERE:
            numbers += [surface.conic, *(sign * shape[FIRST_TERM:FIRST_TERM + MORE[kind] - 1])]
        at = place
    return np.array([*numbers, at])


@stage
def trace(lanes, p, key):
    """Follow the ray through every surface; it ends on the last one, its direction a unit vector in air.

    CLEARANCE becomes the greatest (r / semi-diameter)² met, inf where the ray
    turned back or met a surface beyond its equator or not at all; what is not ≤ 1 loses its WEIGHT.
    p: as `packed` gives them.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    Z_, N_, W_, V_ = row[Z], row[N], row[WEIGHT], row[CLEARANCE]
    sign, end = p[0], p[p.size - 1]
    for i in range(B):
        Z_[i] *= sign
        N_[i] *= sign
        V_[i] = real(0)
    s = 1
    while s < p.size - 1:
        kind = p[s]
        if kind == SPHERE:
            _sphere(lanes, p, s)
            s += SURFACE
        elif kind == CONIC:
            _conic(lanes, p, s)
            s += SURFACE + 1
        elif kind == TOROID:
            _toroid(lanes, p, s)
            s += SURFACE + 1
        elif kind == EVEN:
            _even(lanes, p, s)
            s += EVENS
        else:
            _asphere(lanes, p, s)
            s += ALL
    for i in range(B):
        Z_[i] = (Z_[i] + end) * sign
        N_[i] *= sign
        W_[i] = W_[i] if V_[i] <= real(1) else real(0)


@stage
def trace_spheres(lanes, p, key):
    """As `trace`, for lenses of spheres and planes alone: quicker to compile, and the first start waits for it."""
    real = lanes.dtype.type
    row = rows(lanes)
    Z_, N_, W_, V_ = row[Z], row[N], row[WEIGHT], row[CLEARANCE]
    sign, end = p[0], p[p.size - 1]
    for i in range(B):
        Z_[i] *= sign
        N_[i] *= sign
        V_[i] = real(0)
    for s in range(1, p.size - 1, SURFACE):
        _sphere(lanes, p, s)
    for i in range(B):
        Z_[i] = (Z_[i] + end) * sign
        N_[i] *= sign
        W_[i] = W_[i] if V_[i] <= real(1) else real(0)


@stage
def _sphere(lanes, p, s):
    """Through a sphere or a plane."""
    real = lanes.dtype.type
    row = rows(lanes)
    X_, Y_, Z_, L_, M_, N_, V_ = row[X], row[Y], row[Z], row[L], row[M], row[N], row[CLEARANCE]
    gap, c, rim, slow, step, bend = p[s + 1], p[s + 2], p[s + 3], p[s + 4], p[s + 5], p[s + 6]
    for i in range(B):
        l, m, n = L_[i], M_[i], N_[i]
        x, y, z = X_[i], Y_[i], Z_[i] - gap
        e = -(l * x + m * y + n * z) * slow
        x, y, z = x + e * l, y + e * m, z + e * n
        d = c * (x * x + y * y + z * z) - (z + z)
        before2 = n * n - bend * d
        before, after = math.sqrt(before2), math.sqrt(before2 + step)
        t = d / (n + before)
        x, y, z = x + t * l, y + t * m, z + t * n
        g = after - before
        gc = g * c
        side = real(1) - c * z
        n = n + g * side
        X_[i], Y_[i], Z_[i] = x, y, z
        L_[i], M_[i], N_[i] = l - gc * x, m - gc * y, n
        v = (x * x + y * y) * rim
        v = v if (side > real(0)) & (n > real(0)) else real(np.inf)
        V_[i] = V_[i] if V_[i] >= v else v              # and NaN stays, for all that follows is NaN


@stage
def _conic(lanes, p, s):
    """Through a conic: D − 2 b t + a t² = 0 from the foot, the root where the ray goes through as it travels."""
    real = lanes.dtype.type
    row = rows(lanes)
    X_, Y_, Z_, L_, M_, N_, V_ = row[X], row[Y], row[Z], row[L], row[M], row[N], row[CLEARANCE]
    gap, c, rim, slow, step, bend, k = p[s + 1], p[s + 2], p[s + 3], p[s + 4], p[s + 5], p[s + 6], p[s + 7]
    kc, kc2 = k * c, k * c * c
    for i in range(B):
        l, m, n = L_[i], M_[i], N_[i]
        x, y, z = X_[i], Y_[i], Z_[i] - gap
        e = -(l * x + m * y + n * z) * slow
        x, y, z = x + e * l, y + e * m, z + e * n
        d = c * (x * x + y * y + z * z) + kc * z * z - (z + z)
        a, b = bend + kc * n * n, n * (real(1) - kc * z)
        root = math.sqrt(b * b - a * d)
        above, below = (d, b + root) if b > real(0) else (b - root, a)
        t = above / below
        x, y, z = x + t * l, y + t * m, z + t * n
        side = real(1) - (c + kc) * z
        r2 = x * x + y * y
        steep = real(1) - kc2 * r2                      # squared length of the gradient (−c x, −c y, side)
        before2 = root * root / steep
        g = (math.sqrt(before2 + step) - math.sqrt(before2)) / math.sqrt(steep)
        n = n + g * side
        X_[i], Y_[i], Z_[i] = x, y, z
        L_[i], M_[i], N_[i] = l - g * c * x, m - g * c * y, n
        v = r2 * rim
        v = v if (side > real(0)) & (n > real(0)) else real(np.inf)
        V_[i] = V_[i] if V_[i] >= v else v


@stage
def _begin(lanes, p, s, c, k):
    """To the foot, and in A0 the t of the hit on the conic (c, k), or on the plane: where Newton begins."""
    real = lanes.dtype.type
    row = rows(lanes)
    X_, Y_, Z_, L_, M_, N_, T_ = row[X], row[Y], row[Z], row[L], row[M], row[N], row[A0]
    gap, slow = p[s + 1], p[s + 4]
    bend, kc = c / slow, k * c
    for i in range(B):
        l, m, n = L_[i], M_[i], N_[i]
        x, y, z = X_[i], Y_[i], Z_[i] - gap
        e = -(l * x + m * y + n * z) * slow
        x, y, z = x + e * l, y + e * m, z + e * n
        X_[i], Y_[i], Z_[i] = x, y, z
        d = c * (x * x + y * y + z * z) + kc * z * z - (z + z)
        a, b = bend + kc * n * n, n * (real(1) - kc * z)
        root = math.sqrt(max(b * b - a * d, real(0)))
        above, below = (d, b + root) if b > real(0) else (b - root, a)
        t = above / below
        T_[i] = t if (c + kc) * (z + t * n) < real(1) else -z / n


@stage
def _still(lanes, p, s):
    """Whether Newton's method has come to rest for every ray: A1 holds the last step."""
    real = lanes.dtype.type
    last, limit = rows(lanes)[A1], real(STILL) * p[s + 4] / p[s + 3]
    moving = 0
    for i in range(B):
        moving += 1 if last[i] * last[i] > limit else 0         # a lost ray is NaN, and moves no more
    return moving == 0


@stage
def _even(lanes, p, s):
    """Through an asphere of even powers: Newton's method on z = sag(r²), then the refraction.

    The height above the surface and its derivative along the ray are both carried
    times √ (1 + √), √ that of the conic, so that a step has one root and one division.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    X_, Y_, Z_, L_, M_, N_ = row[X], row[Y], row[Z], row[L], row[M], row[N]
    T_, H_, SX, SY = row[A0], row[A1], row[A2], row[A3]
    c, unit, k = p[s + 2], p[s + 3], p[s + 7]
    a, b, d, e, f = p[s + 8], p[s + 9], p[s + 10], p[s + 11], p[s + 12]
    g, h, j, o, q = p[s + 13], p[s + 14], p[s + 15], p[s + 16], p[s + 17]
    curl = (real(1) + k) * c * c
    _begin(lanes, p, s, c, k)
    for step in range(STEPS[lanes.itemsize // 8] + 1 + MORE_STEPS):
        if step > STEPS[lanes.itemsize // 8] and _still(lanes, p, s):
            break
        for i in range(B):
            x, y, z = X_[i] + T_[i] * L_[i], Y_[i] + T_[i] * M_[i], Z_[i] + T_[i] * N_[i]
            r2 = x * x + y * y
            root = math.sqrt(max(real(1) - curl * r2, real(NEAR_EQUATOR)))
            whole = root * (real(1) + root)
            u = r2 * unit
            more = ((((((((q * u + o) * u + j) * u + h) * u + g) * u + f) * u + e) * u + d) * u + b) * u + a
            steeper = ((((real(20) * q * u + real(18) * o) * u + real(16) * j) * u + real(14) * h) * u
                       + real(12) * g) * u + real(10) * f
            steeper = (((steeper * u + real(8) * e) * u + real(6) * d) * u + real(4) * b) * u + real(2) * a
            height = (z - more * u) * whole - c * r2 * root
            slope = c * (real(1) + root) + steeper * unit * whole
            advance = height / (N_[i] * whole - slope * (x * L_[i] + y * M_[i]))
            slope = slope / whole
            H_[i], SX[i], SY[i] = advance, slope * x, slope * y
            T_[i] = T_[i] - advance
    _refract(lanes, p, s, curl, curl)


@stage
def _asphere(lanes, p, s):
    """Through an asphere of any powers, as `_even`; the terms are summed in loops of their own."""
    real = lanes.dtype.type
    row = rows(lanes)
    X_, Y_, Z_, L_, M_, N_ = row[X], row[Y], row[Z], row[L], row[M], row[N]
    T_, H_, SX, SY, MORE_, STEEPER = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    c, unit, k = p[s + 2], p[s + 3], p[s + 7]
    curl = (real(1) + k) * c * c
    _begin(lanes, p, s, c, k)
    for step in range(STEPS[lanes.itemsize // 8] + 1 + MORE_STEPS):
        if step > STEPS[lanes.itemsize // 8] and _still(lanes, p, s):
            break
        for i in range(B):
            x, y = X_[i] + T_[i] * L_[i], Y_[i] + T_[i] * M_[i]
            SX[i] = math.sqrt((x * x + y * y) * unit)
            MORE_[i], STEEPER[i] = real(0), real(0)
        for j in range(TERMS - 1, -1, -1):
            term = p[s + SURFACE + 1 + j]
            more = real(j + 2) * term
            for i in range(B):
                MORE_[i], STEEPER[i] = MORE_[i] * SX[i] + term, STEEPER[i] * SX[i] + more
        for i in range(B):
            x, y, z = X_[i] + T_[i] * L_[i], Y_[i] + T_[i] * M_[i], Z_[i] + T_[i] * N_[i]
            r2 = x * x + y * y
            root = math.sqrt(max(real(1) - curl * r2, real(NEAR_EQUATOR)))
            whole = root * (real(1) + root)
            height = (z - MORE_[i] * r2 * unit) * whole - c * r2 * root
            slope = c * (real(1) + root) + STEEPER[i] * unit * whole
            advance = height / (N_[i] * whole - slope * (x * L_[i] + y * M_[i]))
            slope = slope / whole
            H_[i], SX[i], SY[i] = advance, slope * x, slope * y
            T_[i] = T_[i] - advance
    _refract(lanes, p, s, curl, curl)


@stage
def _toroid(lanes, p, s):
    """Through a cylinder or toroid: Newton's method from the sphere of mean curvature, then the refraction.

    The sag is A / (1 + √); height and derivative are carried times √ (1 + √)².
    """
    real = lanes.dtype.type
    row = rows(lanes)
    X_, Y_, Z_, L_, M_, N_ = row[X], row[Y], row[Z], row[L], row[M], row[N]
    T_, H_, SX, SY = row[A0], row[A1], row[A2], row[A3]
    c, across = p[s + 2], p[s + 7]
    _begin(lanes, p, s, real(0.5) * (c + across), real(0))
    for step in range(STEPS[lanes.itemsize // 8] + 1 + MORE_STEPS):
        if step > STEPS[lanes.itemsize // 8] and _still(lanes, p, s):
            break
        for i in range(B):
            x, y, z = X_[i] + T_[i] * L_[i], Y_[i] + T_[i] * M_[i], Z_[i] + T_[i] * N_[i]
            bend_x, bend_y = across * x, c * y
            root = math.sqrt(max(real(1) - bend_x * bend_x - bend_y * bend_y, real(NEAR_EQUATOR)))
            outer = real(1) + root
            whole = root * outer * outer
            bend = bend_x * x + bend_y * y
            both = real(2) * root * outer
            slope_x, slope_y = bend_x * (both + bend * across), bend_y * (both + bend * c)
            advance = (z * whole - bend * root * outer) / (N_[i] * whole - slope_x * L_[i] - slope_y * M_[i])
            share = real(1) / whole
            H_[i], SX[i], SY[i] = advance, slope_x * share, slope_y * share
            T_[i] = T_[i] - advance
    _refract(lanes, p, s, across * across, c * c)


@stage
def _refract(lanes, p, s, curl_x, curl_y):
    """Refract where Newton ended: A0 t from the foot, A1 the last step, A2 and A3 the slopes of the sag.

    curl_x, curl_y: the equator is where curl_x x² + curl_y y² is 1.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    X_, Y_, Z_, L_, M_, N_, V_ = row[X], row[Y], row[Z], row[L], row[M], row[N], row[CLEARANCE]
    T_, H_, SX, SY = row[A0], row[A1], row[A2], row[A3]
    rim, slow, step = p[s + 3], p[s + 4], p[s + 5]
    for i in range(B):
        l, m, n = L_[i], M_[i], N_[i]
        x, y, z = X_[i] + T_[i] * l, Y_[i] + T_[i] * m, Z_[i] + T_[i] * n
        slope_x, slope_y = SX[i], SY[i]
        steep = math.sqrt(real(1) + slope_x * slope_x + slope_y * slope_y)
        before = (n - slope_x * l - slope_y * m) / steep
        g = (math.sqrt(before * before + step) - before) / steep
        n = n + g
        X_[i], Y_[i], Z_[i] = x, y, z
        L_[i], M_[i], N_[i] = l - g * slope_x, m - g * slope_y, n
        found = (H_[i] * H_[i] * rim <= real(STILL) * slow) & (curl_x * x * x + curl_y * y * y < real(1))
        v = (x * x + y * y) * rim
        v = v if found & (before > real(0)) & (n > real(0)) else real(np.inf)
        V_[i] = V_[i] if V_[i] >= v else v


def trace_step(lens: Lens, film_distance: float, wavelength: float = D_LINE, towards: str = "scene",
           part: slice = slice(None)) -> Step:
    """The step that traces this lens, its stop a circle, with its film this far behind the last vertex (mm).

    Before the lens a direction is as long as the index there.
    """
    spherical = all(surface.is_spherical for surface in lens.surfaces)
    return Step(trace_spheres if spherical else trace, pack_lens(lens, film_distance, wavelength, towards, part))


@stage
def scale_directions(lanes, p, key):
    """Make the direction p times as long: a ray carries its index, and is a unit vector outside."""
    row = rows(lanes)
    l, m, n = row[L], row[M], row[N]
    factor = p[0]
    for i in range(B):
        l[i], m[i], n[i] = l[i] * factor, m[i] * factor, n[i] * factor


def round_stop_steps(lens: Lens, film_distance: float, wavelength: float = D_LINE,
                     towards: str = "scene") -> list[Step]:
    """The steps that trace this lens, its stop a circle: `tracer`, for unit vectors in whatever lies before it."""
    return _between_units(lens, [trace_step(lens, film_distance, wavelength, towards)], towards)


def _between_units(lens: Lens, steps: list[Step], towards: str) -> list[Step]:
    n = lens.front_index
    if n == 1.0:
        return steps
    return [*steps, Step(scale_directions, [1.0 / n])] if towards == "scene" else [Step(scale_directions, [n]), *steps]


def trace_steps(lens: Lens, film_distance: float, wavelength: float = D_LINE, towards: str = "scene") -> list[Step]:
    """The steps that trace this lens as `round_through` does, with the blades of its stop."""
    blocking = lens.iris.blocking(lens.stop.semi_diameter)
    if not blocking:
        return round_stop_steps(lens, film_distance, wavelength, towards)
    stop = lens.stop_index if towards == "film" else len(lens.surfaces) - 1 - lens.stop_index
    first, second = (trace_step(lens, film_distance, wavelength, towards, part)
                     for part in (slice(0, stop + 1), slice(stop + 1, len(lens.surfaces))))
    parts = [first, *blocking, second] if stop + 1 < len(lens.surfaces) else [first, *blocking]
    return _between_units(lens, parts, towards)
