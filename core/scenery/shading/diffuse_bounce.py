"""One bounce of diffuse light: what a matte surface sends to another, such as the red of a wall to the floor.

From the first matte surface of a path one ray goes on, in proportion to the cosine. What it meets is lit by every light
and adds its light to the path; the sky adds its own. Lights that the ray meets by chance add nothing, because the
surface has their light already. Mirrors and glass end the ray, and surfaces seen in mirrors have no such light.

`diffuse_bend` finds the ray before `specular_bounce`, `diffuse_leave` sends it, together with the paths by mirrors;
PATH holds DIFFUSE meanwhile. `diffuse_sky` and `diffuse_end` close the round.
"""

import numpy as np
from numba import uint32

from lensbench.kernels.block import (
    ALIVE,
    BLUE,
    DEPTH,
    EMITS,
    GREEN,
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
    PATH,
    PIXEL,
    RED,
    SAMPLE,
    SEED,
    TB,
    TG,
    TR,
    V0,
    V1,
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
from lensbench.kernels.concentric_map import cosine_direction
from lensbench.kernels.layout import vector
from lensbench.kernels.sampling import mix
from lensbench.scenery.emission import DIFFUSE, shines
from lensbench.scenery.intersect.sky import SKY_DISTANCE, gradient
from lensbench.scenery.shading.illumination import AMBIENT
from lensbench.scenery.shading.rounding import rounded_length

LIFT = 2e-5             # offset of the new ray from the surface, as a fraction of `rounded_length`
MARK = 2.0              # H6 of a path that bounces


@stage
def diffuse_bend(lanes, p, ints, key):
    """H0 … H5: a ray from each matte surface, in proportion to the cosine by V0 and V1; H6: MARK for these."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, depth = row[X], row[Y], row[Z], row[L], row[M], row[N], row[DEPTH]
    nx, ny, nz, red, green, blue, v0, v1 = row[NX], row[NY], row[NZ], row[RED], row[GREEN], row[BLUE], row[V0], row[V1]
    px, py, pz, qx, qy, qz, on = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5], row[H6]
    for i in range(B):
        lit = red[i] + green[i] + blue[i] > real(0)
        t = depth[i]
        hx, hy, hz = x[i] + t * dx[i], y[i] + t * dy[i], z[i] + t * dz[i]
        lift = real(LIFT) * rounded_length(hx, hy, hz, t)
        a, b, c = cosine_direction(real, v0[i], v1[i], nx[i], ny[i], nz[i])
        px[i] = hx + lift * nx[i] if lit else px[i]
        py[i] = hy + lift * ny[i] if lit else py[i]
        pz[i] = hz + lift * nz[i] if lit else pz[i]
        qx[i], qy[i], qz[i] = a if lit else qx[i], b if lit else qy[i], c if lit else qz[i]
        on[i] = real(MARK) if lit else on[i] if on[i] != real(MARK) else real(0)


@stage
def diffuse_leave(lanes, p, ints, key):
    """Send the rays of `diffuse_bend`, after `specular_bounce` and `solid_leave`, with light samples of their own."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, tr, tg, tb = row[X], row[Y], row[Z], row[L], row[M], row[N], row[TR], row[TG], row[TB]
    red, green, blue, path, v0, v1 = row[RED], row[GREEN], row[BLUE], row[PATH], row[V0], row[V1]
    px, py, pz, qx, qy, qz, on = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5], row[H6]
    many = np.int32(0)
    for i in range(B):
        sent = on[i] == real(MARK)
        x[i], y[i], z[i] = px[i] if sent else x[i], py[i] if sent else y[i], pz[i] if sent else z[i]
        dx[i], dy[i], dz[i] = qx[i] if sent else dx[i], qy[i] if sent else dy[i], qz[i] if sent else dz[i]
        tr[i], tg[i], tb[i] = red[i] if sent else tr[i], green[i] if sent else tg[i], blue[i] if sent else tb[i]
        path[i] = real(DIFFUSE) if sent else path[i]
        many = np.int32(many + np.int32(sent))
    if many == 0:
        return
    key[ALIVE] = np.uint32(1)
    salt = mix(uint32(key[SAMPLE] + mix(uint32(key[SEED] + np.uint32(0x51ED270B)))))
    unit = real(1 / 16777216)
    for i in range(B):
        a = mix(uint32(uint32(key[PIXEL] + uint32(i)) ^ salt))
        b = mix(uint32(a + np.uint32(0x9E3779B9)))
        sent = on[i] == real(MARK)
        v0[i] = real(np.int32(a >> np.uint32(8))) * unit if sent else v0[i]
        v1[i] = real(np.int32(b >> np.uint32(8))) * unit if sent else v1[i]


@stage
def diffuse_sky(lanes, p, ints, key):
    """Sky and ambient light for rays after a diffuse bounce that meet the sky.  p: SURROUND numbers."""
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, depth, emits, path = row[L], row[M], row[N], row[DEPTH], row[EMITS], row[PATH]
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    (er, eg, eb), (dr, dg, db), (gr, gg, gb), (ux, uy, uz) = gradient(p, 0)
    ar, ag, ab = vector(p, AMBIENT)
    for i in range(B):
        escaped = (path[i] == real(DIFFUSE)) & (depth[i] >= real(SKY_DISTANCE)) & shines(real, emits[i])
        up = ux * dx[i] + uy * dy[i] + uz * dz[i]
        above = up >= real(0)
        red[i] = ar + (er + up * dr if above else gr) if escaped else red[i]
        green[i] = ag + (eg + up * dg if above else gg) if escaped else green[i]
        blue[i] = ab + (eb + up * db if above else gb) if escaped else blue[i]


@stage
def diffuse_end(lanes, p, ints, key):
    """End the paths of a diffuse bounce, after `gather_emission`: the light of their surface is still to be added."""
    real = lanes.dtype.type
    row = rows(lanes)
    tr, tg, tb, path = row[TR], row[TG], row[TB], row[PATH]
    for i in range(B):
        done = path[i] == real(DIFFUSE)
        tr[i], tg[i], tb[i] = real(0) if done else tr[i], real(0) if done else tg[i], real(0) if done else tb[i]
