"""Light on its way to the camera: from a point of a small light to a point of a plane before the lens.

Both points are drawn evenly, the one from a parallelogram or ellipse that hides
the light as seen from there, the other from a rectangle through which passes all that
can pass the lens. The ray is followed *from* the plane to the light, as the
camera's own rays are, so that what is in between is found by the same stages; then
it is turned round. Camera frame, mm.
"""

import math

import numpy as np

from lensbench.disk import concentric
from lensbench.lanes import GLOW, PIXEL, U0, U1, V0, V1, WEIGHT, B, L, M, N, X, Y, Z, rows, stage

LIGHT = 27              # numbers per light: see `light_parameters`
FLOW, MARK = 25, 26     # of them the étendue of a sample, and the GLOW of the object


def light_parameters(marks, middles, half_axes, towards, centres, rights, ups, disks, shares) -> np.ndarray:
    """Numbers of n lights for `emit` and `turn_back`: (n, LIGHT).

    marks: the GLOW of what each shines from; middles (n, 3), half_axes (n, 2, 3), towards (n, 3): of the rectangle
    before the lens, its unit normal pointing at the light; centres, rights, ups (n, 3), disks (n,): what hides the
    light, half-axes; shares (n,): of its étendue that each sample stands for, with the rectangle's area in it.
    """
    normals = np.cross(rights, ups)
    areas = np.sqrt((normals**2).sum(1))
    flows = areas * np.where(disks, math.pi, 4.0) * shares
    return np.column_stack([middles, half_axes.reshape(-1, 6), towards, centres, rights, ups, normals / areas[:, None],
                            disks, flows, marks])


@stage
def emit(lanes, p, key):
    """From U0, U1 and V0, V1 a ray from the plane before the lens to light number key[PIXEL]; WEIGHT is its étendue.

    p: light_parameters of every light.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    s = np.int64(key[PIXEL]) * LIGHT
    wx, wy, wz, ux, uy, uz, flow = p[s + 9], p[s + 10], p[s + 11], p[s + 21], p[s + 22], p[s + 23], p[s + FLOW]
    _aim(lanes, p, s)
    l, m, n, weight = row[L], row[M], row[N], row[WEIGHT]
    for i in range(B):
        per = real(1) / (l[i] * l[i] + m[i] * m[i] + n[i] * n[i])
        size = math.sqrt(per)
        # cos · cos / d²: both of the products below hold d once
        weight[i] = abs(l[i] * wx + m[i] * wy + n[i] * wz) * per * abs(l[i] * ux + m[i] * uy + n[i] * uz) * per * flow
        l[i], m[i], n[i] = l[i] * size, m[i] * size, n[i] * size


@stage
def _aim(lanes, p, s):
    """X, Y, Z: the point of the plane; L, M, N: from there to the point of the light."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, u, v = row[X], row[Y], row[Z], row[L], row[M], row[N], row[U0], row[U1]
    v0, v1 = row[V0], row[V1]
    px, py, pz, ax, ay, az, bx, by, bz = p[s], p[s + 1], p[s + 2], p[s + 3], p[s + 4], p[s + 5], p[s + 6], p[s + 7], (
        p[s + 8])
    cx, cy, cz, ex, ey, ez, fx, fy, fz = p[s + 12], p[s + 13], p[s + 14], p[s + 15], p[s + 16], p[s + 17], p[s + 18], (
        p[s + 19]), p[s + 20]
    round_one = p[s + 24] > real(0)
    for i in range(B):
        a, b = real(2) * u[i] - real(1), real(2) * v[i] - real(1)
        x[i], y[i], z[i] = px + a * ax + b * bx, py + a * ay + b * by, pz + a * az + b * bz
    for i in range(B):
        q, r = concentric(real, v0[i], v1[i])
        a = q if round_one else real(2) * v0[i] - real(1)
        b = r if round_one else real(2) * v1[i] - real(1)
        l[i] = cx + a * ex + b * fx - x[i]
        m[i] = cy + a * ey + b * fy - y[i]
        n[i] = cz + a * ez + b * fz - z[i]


@stage
def turn_back(lanes, p, key):
    """The ray of `emit` again, but from its light to the lens; lost where GLOW, as marking_steps left it, is another's.

    p: as for `emit`.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    s = np.int64(key[PIXEL]) * LIGHT
    mark = p[s + MARK]
    _aim(lanes, p, s)
    l, m, n, weight, glow = row[L], row[M], row[N], row[WEIGHT], row[GLOW]
    for i in range(B):
        size = real(-1) / math.sqrt(l[i] * l[i] + m[i] * m[i] + n[i] * n[i])
        l[i], m[i], n[i] = l[i] * size, m[i] * size, n[i] * size
        weight[i] = weight[i] if glow[i] == mark else real(0)
