"""Light of meshes that shine: points of their triangles, drawn by area."""

import math

import numpy as np

from lensbench.kernels.block import (
    A0,
    A1,
    A2,
    A3,
    A4,
    A5,
    A6,
    A7,
    DEPTH,
    NX,
    NY,
    NZ,
    V0,
    V1,
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
from lensbench.kernels.borrowed_array import address, borrowed
from lensbench.kernels.byte_cache import byte_cache
from lensbench.scenery.shading.illumination import count_lit
from lensbench.scenery.shading.mesh_shadows import LIFT
from lensbench.scenery.shading.rounding import rounded_length

MOST_KEPT = 64 << 20    # bytes of the tables of meshes seen before
GRAZING = 0.02          # least cosine at the mesh that its own shadow regards
CORNER = 9              # numbers of a triangle: a corner and the ways to the others, mm
# Integers: places of both tables, and the number of triangles
SHARES, TRIANGLES, COUNT = range(3)


@byte_cache(MOST_KEPT, 8)
def _tables(mesh) -> tuple[np.ndarray, np.ndarray, float]:
    """Cumulative shares of the area (n,) and corners (n, CORNER) of the triangles; their area, mm²."""
    a, b, c = (mesh.points[mesh.triangles[:, k]].astype(float) for k in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    shares = np.cumsum(areas) / areas.sum()
    return shares, np.hstack([a, b - a, c - a]), float(areas.sum())


def mesh_lamp_step(mesh) -> Step:
    """The stage `mesh_lamp_rays` of a mesh that is a lamp."""
    tables = shares, triangles, area = _tables(mesh)
    return Step(mesh_lamp_rays, [area / math.pi], [address(shares), address(triangles), len(shares)], kept=tables)


@stage
def mesh_lamp_rays(lanes, p, ints, key):
    """Sample a point of a mesh, which shines to both sides: the light is L cos θ cos θ′ A / (π d²).

    A0 … A7 as `shadow` reads them. V0 chooses the triangle by its share of the area A, and its rest a point of it.
    p: A / π. ints: SHARES … COUNT.
    """
    if count_lit(lanes) == 0:
        return
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, v0, v1 = row[X], row[Y], row[Z], row[L], row[M], row[N], row[V0], row[V1]
    depth, nx, ny, nz, hx, hy, hz = row[DEPTH], row[NX], row[NY], row[NZ], row[A0], row[A1], row[A2]
    wx, wy, wz, far, light = row[A3], row[A4], row[A5], row[A6], row[A7]
    count = ints[COUNT]
    shares = borrowed(ints[SHARES], count, np.float64)
    triangles = borrowed(ints[TRIANGLES], count * CORNER, np.float64)
    for i in range(B):
        t = depth[i]
        hx[i], hy[i], hz[i] = x[i] + t * dx[i], y[i] + t * dy[i], z[i] + t * dz[i]

        # Choose a triangle: the first whose cumulative share exceeds V0
        u = np.float64(v0[i])
        low, high = 0, count - 1
        while low < high:
            middle = (low + high) // 2
            low, high = (middle + 1, high) if shares[middle] <= u else (low, middle)
        below = shares[low - 1] if low > 0 else 0.0
        u = min(max((u - below) / (shares[low] - below), 0.0), 1.0)

        # Choose a point of it (Turk 1990)
        root = math.sqrt(u)
        second, third = root * (1.0 - np.float64(v1[i])), root * np.float64(v1[i])
        k = low * CORNER
        bx, by, bz = triangles[k + 3], triangles[k + 4], triangles[k + 5]
        cx, cy, cz = triangles[k + 6], triangles[k + 7], triangles[k + 8]
        qx = real(triangles[k] + second * bx + third * cx) - hx[i]
        qy = real(triangles[k + 1] + second * by + third * cy) - hy[i]
        qz = real(triangles[k + 2] + second * bz + third * cz) - hz[i]
        ux, uy, uz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
        d2 = qx * qx + qy * qy + qz * qz
        size = real(1) / math.sqrt(d2)
        qx, qy, qz = qx * size, qy * size, qz * size
        slant = nx[i] * qx + ny[i] * qy + nz[i] * qz
        facing = abs(real(ux) * qx + real(uy) * qy + real(uz) * qz) / real(math.sqrt(ux * ux + uy * uy + uz * uz))
        arriving = slant * facing * p[0] / d2
        # `mesh_shadows` lifts the point before it looks for the mesh itself: end the ray before this triangle
        lift = real(LIFT) * rounded_length(hx[i], hy[i], hz[i], depth[i])
        wx[i], wy[i], wz[i], far[i] = qx, qy, qz, d2 * size - lift / max(facing, real(GRAZING))
        light[i] = arriving if arriving > real(0) else real(0)
