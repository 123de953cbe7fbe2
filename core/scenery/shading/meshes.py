"""Light around meshes: the shadows that they cast, the sky seen between them, and meshes that shine themselves."""

import math
from typing import Any

import numpy as np

from lensbench.core.kernels.arrays import address, borrowed
from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, A10, BLUE, DEPTH, GREEN, NX, NY, NZ, RED, V0, V1, B, Step, rows, stage,
    vector
)
from lensbench.core.kernels.byte_cache import byte_cache
from lensbench.core.kernels.eights import GROUP
from lensbench.core.kernels.sampling import cosine_direction
from lensbench.core.scenery.intersect.meshes import (
    CORNER_COUNT, CORNERS, LEAF_COUNT, LEAVES, NODE_COUNT, NODES, STACK, VERTEX_COUNT, VERTICES, corner_places, surfaces
)
from lensbench.core.scenery.intersect.sky import gradient, sky_radiance
from lensbench.core.scenery.intersect.triangle_tree import inverse_of, place_ray, scratch_of, search, search_group
from lensbench.core.scenery.shading.bounces import rounded_length
from lensbench.core.scenery.shading.illumination import AMBIENT, F0, met_points, schlick_edge

LIFT = 2e-5             # offset of a shadow ray from its surface, as a fraction of `rounded_length`
CROSSINGS = 16          # surfaces of glass that light passes at the most


def mesh_shadow_steps(meshes: tuple[Any, ...], lamp: Any = None) -> tuple[Step, ...]:
    """The stages `mesh_shadows` and `glass_shadows` for the meshes that hide light; none for those that shine.

    lamp: a mesh that hides its own light, or None.
    """
    opaque = tuple(o for o in meshes if o.material.kind != "glass" and (o is lamp or not o.material.shines))
    clear = tuple(o for o in meshes if o.material.kind == "glass")
    steps = []
    if opaque:
        tree = surfaces(opaque)
        steps.append(Step(mesh_shadows, (), tree.tree_integers, kept=tree))
    if clear:
        tree = surfaces(clear)
        steps.append(Step(glass_shadows, (), tree.find_integers, kept=tree))
    return tuple(steps)


@stage(allocates=True)
def mesh_shadows(lanes, p, ints, key):
    """Darken A7, the light at A0 A1 A2 from A3 A4 A5 at the distance A6, where a mesh hides it.  ints: the tree's."""
    real = lanes.dtype.type
    row = rows(lanes)
    hx, hy, hz, wx, wy, wz, far, light = (row[A0], row[A1], row[A2], row[A3], row[A4], row[A5], row[A6], row[A7])
    nx, ny, nz, red, green, blue = row[NX], row[NY], row[NZ], row[RED], row[GREEN], row[BLUE]
    depth = row[DEPTH]
    nodes = borrowed(ints[NODES], ints[NODE_COUNT], np.float32)
    leaves = borrowed(ints[LEAVES], ints[LEAF_COUNT], np.float32)
    scratch = scratch_of(real, ints[STACK])
    for first in range(0, B, GROUP):
        for k in range(GROUP):
            i = np.uint64(first + k)
            lit = (light[i] > real(0)) & (red[i] + green[i] + blue[i] > real(0))
            lift = real(LIFT) * rounded_length(hx[i], hy[i], hz[i], depth[i])
            origin = (hx[i] + lift * nx[i], hy[i] + lift * ny[i], hz[i] + lift * nz[i])
            place_ray(real, scratch.group, k, origin, (wx[i], wy[i], wz[i]),
                      far[i] - real(2) * lift if lit else real(-1))
        search_group(real, nodes, leaves, True, scratch)
        for k in range(GROUP):
            light[first + k] = real(0) if scratch.numbers[k] >= 0 else light[first + k]


@stage(allocates=True)
def glass_shadows(lanes, p, ints, key):
    """Darken A7, as `mesh_shadows`, by what surfaces of glass reflect of light that runs straight through them.

    ints: Surfaces.find_integers.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    hx, hy, hz, wx, wy, wz, far, light = (row[A0], row[A1], row[A2], row[A3], row[A4], row[A5], row[A6], row[A7])
    nx, ny, nz, red, green, blue = row[NX], row[NY], row[NZ], row[RED], row[GREEN], row[BLUE]
    depth = row[DEPTH]
    nodes = borrowed(ints[NODES], ints[NODE_COUNT], np.float32)
    leaves = borrowed(ints[LEAVES], ints[LEAF_COUNT], np.float32)
    corners = borrowed(ints[CORNERS], ints[CORNER_COUNT], np.int32)
    vertices = borrowed(ints[VERTICES], ints[VERTEX_COUNT], np.float32)
    links, entries, scratch = np.empty(ints[STACK], np.int32), np.empty(ints[STACK], real), np.empty(24, real)
    for i in range(B):
        if not ((light[i] > real(0)) & (red[i] + green[i] + blue[i] > real(0))):
            continue
        dx, dy, dz = wx[i], wy[i], wz[i]
        lift = real(LIFT) * rounded_length(hx[i], hy[i], hz[i], depth[i])
        x, y, z, left = hx[i] + lift * nx[i], hy[i] + lift * ny[i], hz[i] + lift * nz[i], far[i] - real(2) * lift
        inverse = inverse_of(real, (dx, dy, dz))
        for _ in range(CROSSINGS):
            number, t, _, _ = search(real, nodes, leaves, (x, y, z), (dx, dy, dz), inverse, left, False, links, entries,
                                     scratch)
            if number < 0:
                break
            (ax, ay, az), (bx, by, bz), (cx, cy, cz) = corner_places(real, corners, vertices, number)
            fx, fy, fz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
            cosine = abs(fx * dx + fy * dy + fz * dz) / math.sqrt(fx * fx + fy * fy + fz * fz)
            light[i] *= real(1 - F0) * (real(1) - schlick_edge(real, cosine))
            t += real(LIFT) * rounded_length(x, y, z, depth[i] + t)
            x, y, z, left = x + t * dx, y + t * dy, z + t * dz, left - t


@stage
def gradient_rays(lanes, p, ints, key):
    """Sample a direction of sky and ambient light by the cosine: A0 … A7 as `shadow` reads them, radiance A8 A9 A10.

    p: SURROUND numbers of `ambient`.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    nx, ny, nz, wx, wy, wz, far, light = row[NX], row[NY], row[NZ], row[A3], row[A4], row[A5], row[A6], row[A7]
    r, g, b, v0, v1 = row[A8], row[A9], row[A10], row[V0], row[V1]
    colours, (ar, ag, ab) = gradient(p, 0), vector(p, AMBIENT)
    met_points(lanes)
    for i in range(B):
        wx[i], wy[i], wz[i] = cosine_direction(real, v0[i], v1[i], nx[i], ny[i], nz[i])
        far[i], light[i] = real(np.inf), real(1)
        er, eg, eb = sky_radiance(real, colours, wx[i], wy[i], wz[i])
        r[i], g[i], b[i] = ar + er, ag + eg, ab + eb


MOST_KEPT = 64 << 20    # bytes of the tables of meshes seen before
GRAZING = 0.02          # least cosine at the mesh that its own shadow regards
CORNER = 9              # numbers of a triangle: a corner and the ways to the others, mm
# Integers: places of both tables, and the number of triangles
SHARES, TRIANGLES, COUNT = range(3)


@byte_cache(MOST_KEPT, 8)
def _tables(mesh: Any) -> tuple[np.ndarray, np.ndarray, float]:
    """Cumulative shares of the area (n,) and corners (n, CORNER) of the triangles; their area, mm²."""
    a, b, c = (mesh.points[mesh.triangles[:, k]].astype(float) for k in range(3))
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    shares = np.cumsum(areas) / areas.sum()
    return shares, np.hstack([a, b - a, c - a]), float(areas.sum())


def mesh_lamp_step(mesh: Any) -> Step:
    """The stage `mesh_lamp_rays` of a mesh that is a lamp."""
    tables = shares, triangles, area = _tables(mesh)
    return Step(mesh_lamp_rays, [area / math.pi], [address(shares), address(triangles), len(shares)], kept=tables)


@stage
def mesh_lamp_rays(lanes, p, ints, key):
    """Sample a point of a mesh, which shines to both sides: the light is L cos θ cos θ′ A / (π d²).

    A0 … A7 as `shadow` reads them. V0 chooses the triangle by its share of the area A, and its rest a point of it.
    p: A / π. ints: SHARES … COUNT.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    v0, v1, depth, nx, ny, nz = row[V0], row[V1], row[DEPTH], row[NX], row[NY], row[NZ]
    hx, hy, hz, wx, wy, wz, far, light = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5], row[A6], row[A7]
    count = ints[COUNT]
    shares = borrowed(ints[SHARES], count, np.float64)
    triangles = borrowed(ints[TRIANGLES], count * CORNER, np.float64)
    met_points(lanes)
    for i in range(B):
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
