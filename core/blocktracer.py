"""The block tracer: rays through every surface of a lens, in either direction.

Camera frame in and out: mm, the film's centre at the origin, the scene at −z.
One loop over the lanes for each surface, the same for spheres and planes. The
direction is carried n times as long, n the index it runs in; the ray is first
brought to the foot of the perpendicular from the vertex, so that only small
numbers are squared; a ray that misses or is totally reflected becomes a NaN.
(Welford, Aberrations of Optical Systems, ch. 4, for the quotient form; the foot
is the usual cure of its cancellation.)
"""

import math

import numpy as np

from lensbench.glass import D_LINE
from lensbench.lanes import MARGIN, WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage
from lensbench.prescription import Lens

SURFACE = 6             # numbers a surface: gap, curvature, 1 / semi-diameter², 1 / n², n′² − n², n² c


def packed(lens: Lens, film_distance: float, wavelength: float = D_LINE, towards: str = "scene") -> np.ndarray:
    """The parameters of `trace`: which way, then SURFACE numbers for each surface in the order met.

    film_distance: last vertex → film (mm). towards: "scene" (from the film), or "film" (from the scene).
    """
    indices, vertices = lens.indices(wavelength), lens.vertices
    sceneward = towards == "scene"
    order = range(len(vertices) - 1, -1, -1) if sceneward else range(len(vertices))
    sign = -1.0 if sceneward else 1.0
    at = 0.0
    numbers = [sign]
    for i in order:
        surface = lens.surfaces[i]
        before, after = (indices[i + 1], indices[i]) if sceneward else (indices[i], indices[i + 1])
        place = sign * (vertices[i] - lens.length - film_distance)
        c = sign * surface.curvature
        numbers += [place - at, c, surface.semi_diameter**-2, before**-2, after**2 - before**2, before**2 * c]
        at = place
    return np.array([*numbers, at])


@stage
def trace(lanes, p, key):
    """Follow the ray through every surface; it ends on the last one, its direction a unit vector in air.

    MARGIN becomes the greatest (r / semi-diameter)² met, inf where the ray
    turned back or met a sphere beyond its equator; what is not ≤ 1 loses its WEIGHT.
    p: as `packed` gives them.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    X_, Y_, Z_, L_, M_, N_, W_, V_ = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT], row[MARGIN]
    sign, end = p[0], p[p.size - 1]
    for i in range(B):
        Z_[i] *= sign
        N_[i] *= sign
        V_[i] = real(0)
    for s in range(1, p.size - SURFACE, SURFACE):
        gap, c, rim, slow, step, bend = p[s], p[s + 1], p[s + 2], p[s + 3], p[s + 4], p[s + 5]
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
    for i in range(B):
        Z_[i] = (Z_[i] + end) * sign
        N_[i] *= sign
        W_[i] = W_[i] if V_[i] <= real(1) else real(0)


def tracer(lens: Lens, film_distance: float, wavelength: float = D_LINE, towards: str = "scene") -> Step:
    """The step that traces this lens with its film this far behind the last vertex (mm)."""
    return Step(trace, packed(lens, film_distance, wavelength, towards))
