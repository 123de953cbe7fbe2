"""Meshes of glass: rays bend at each of their surfaces, where balls and panes are crossed in one step.

`solid_bend` finds where a path goes on before `specular_bounce`, for which the surface then is a mirror, and
`solid_leave` sends it there. From inside a path is reflected with the probability F of Schlick's reflectance.
"""

import math

from lensbench.kernels.block import (
    DEPTH,
    FINISH,
    H0,
    H1,
    H2,
    H3,
    H4,
    H5,
    H6,
    NX,
    NY,
    NZ,
    TB,
    TG,
    TR,
    B,
    L,
    M,
    N,
    X,
    Y,
    Z,
    rows,
    stage,
)
from lensbench.scenery.finish import INSIDE, METAL, is_solid
from lensbench.scenery.shading.illumination import F0, INDEX, schlick_edge
from lensbench.scenery.shading.rounding import rounded_length
from lensbench.scenery.shading.specular_bounce import chance, chance_salt

LIFT = 2e-5             # offset of the new ray from the surface, as a fraction of `rounded_length`


@stage
def solid_bend(lanes, p, ints, key):
    """H0 … H5: where paths that met a mesh of glass go on; H6: 1 for these, whose FINISH becomes METAL."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, finish, nx, ny, nz = row[DEPTH], row[FINISH], row[NX], row[NY], row[NZ]
    px, py, pz, qx, qy, qz, on = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5], row[H6]
    salt = chance_salt(key)
    for i in range(B):
        inside = finish[i] == real(INSIDE)
        solid = is_solid(real, finish[i])
        t = depth[i]
        u, v, w, ux, uy, uz = dx[i], dy[i], dz[i], nx[i], ny[i], nz[i]
        hx, hy, hz = x[i] + t * u, y[i] + t * v, z[i] + t * w
        cosine = -(u * ux + v * uy + w * uz)
        ratio = real(INDEX) if inside else real(1 / INDEX)
        square = real(1) - ratio * ratio * (real(1) - cosine * cosine)
        inner = math.sqrt(square if square > real(0) else real(0))
        f = real(F0) + real(1 - F0) * schlick_edge(real, inner if inside else cosine)
        total = (square < real(0)) | (inside & (chance(real, key, salt, i, cosine) < f))
        bend = ratio * cosine - inner
        a, b, c = ratio * u + bend * ux, ratio * v + bend * uy, ratio * w + bend * uz
        mirror = real(2) * cosine
        a, b, c = (u + mirror * ux if total else a, v + mirror * uy if total else b, w + mirror * uz if total else c)
        lift = real(LIFT) * rounded_length(hx, hy, hz, t)
        lift = lift if total else -lift
        px[i], py[i], pz[i] = hx + lift * ux, hy + lift * uy, hz + lift * uz
        size = real(1) / math.sqrt(a * a + b * b + c * c)
        qx[i], qy[i], qz[i] = a * size, b * size, c * size

        on[i] = real(1) if solid else real(0)
        finish[i] = real(METAL) if solid else finish[i]


@stage
def solid_leave(lanes, p, ints, key):
    """Send the paths that met a mesh of glass where `solid_bend` found, after `specular_bounce`."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, tr, tg, tb = row[X], row[Y], row[Z], row[L], row[M], row[N], row[TR], row[TG], row[TB]
    px, py, pz, qx, qy, qz, on = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5], row[H6]
    for i in range(B):
        solid = (on[i] > real(0.5)) & (tr[i] + tg[i] + tb[i] > real(0))
        x[i], y[i], z[i] = px[i] if solid else x[i], py[i] if solid else y[i], pz[i] if solid else z[i]
        dx[i], dy[i], dz[i] = qx[i] if solid else dx[i], qy[i] if solid else dy[i], qz[i] if solid else dz[i]
