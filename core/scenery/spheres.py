"""Spheres, seen from outside: one stage for all of them."""

import math

import numpy as np

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
    BLUE,
    DEPTH,
    GLOSS,
    GLOW,
    GREEN,
    NX,
    NY,
    NZ,
    RED,
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

SPHERE = 10             # numbers per sphere: centre (3), radius², 1/radius, colour (3), glow, gloss


@stage
def spheres(lanes, p, key):
    """Offer the spheres where they are nearer.  p: SPHERE numbers for each."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, glow, gloss, nx, ny, nz = row[DEPTH], row[GLOW], row[GLOSS], row[NX], row[NY], row[NZ]
    red, green, blue, which, ahead, inside = row[RED], row[GREEN], row[BLUE], row[A0], row[A1], row[A2]
    a, b, c, d, e, f, g, h, o = row[A1], row[A2], row[A3], row[A4], row[A5], row[A6], row[A7], row[A8], row[A9]
    for i in range(B):
        which[i] = real(-1)
    found = False
    for s in range(0, p.size, SPHERE):
        cx, cy, cz, r2, name = p[s], p[s + 1], p[s + 2], p[s + 3], real(s)
        # how far each ray passes from the centre; most spheres are far from every ray of a block
        crossed = 0
        for i in range(B):
            dx, dy, dz = cx - x[i], cy - y[i], cz - z[i]
            along = dx * l[i] + dy * m[i] + dz * n[i]
            ox, oy, oz = dx - along * l[i], dy - along * m[i], dz - along * n[i]
            room = r2 - (ox * ox + oy * oy + oz * oz)
            ahead[i], inside[i] = along, room
            crossed += (room > real(0)) & (along > real(0))
        if crossed == 0:
            continue
        found = True
        for i in range(B):
            t, near, known = ahead[i] - math.sqrt(inside[i]), depth[i], which[i]
            hit = (t > real(0)) & (t < near)
            depth[i] = t if hit else near
            which[i] = name if hit else known
    if not found:
        return
    for i in range(B):
        k = which[i]
        k = np.uint64(np.uint32(k if k > real(0) else real(0)))
        a[i], b[i], c[i], d[i] = p[k], p[k + np.uint64(1)], p[k + np.uint64(2)], p[k + np.uint64(4)]
        e[i], f[i], g[i] = p[k + np.uint64(5)], p[k + np.uint64(6)], p[k + np.uint64(7)]
        h[i], o[i] = p[k + np.uint64(8)], p[k + np.uint64(9)]
    for i in range(B):
        t, hit = depth[i], which[i] >= real(0)
        nx[i] = (x[i] + t * l[i] - a[i]) * d[i] if hit else nx[i]
        ny[i] = (y[i] + t * m[i] - b[i]) * d[i] if hit else ny[i]
        nz[i] = (z[i] + t * n[i] - c[i]) * d[i] if hit else nz[i]
        red[i] = e[i] if hit else red[i]
        green[i] = f[i] if hit else green[i]
        blue[i] = g[i] if hit else blue[i]
        glow[i] = h[i] if hit else glow[i]
        gloss[i] = o[i] if hit else gloss[i]
