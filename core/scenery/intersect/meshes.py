"""Triangle meshes: one tree for all meshes of a scene, searched by groups of rays, with eight boxes at a time.

Two stages: `find_meshes` finds the nearest triangle, its normal, its place in an image and the colour of its corners;
`mesh_surfaces` gives it the material of its mesh. Both read the tree and the corners where they lie (`borrowed`).
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from lensbench.core.kernels.arrays import address, borrowed
from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, A10, A11, BEAM, BLUE, DEPTH, EMITS, FINISH, GREEN, NX, NY, NZ, PIXEL_SIDE,
    PIXEL_SPREAD, RED, B, L, M, N, Step, X, Y, Z, offsets, pack, rows, stage, vector
)
from lensbench.core.kernels.byte_cache import byte_cache
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.eights import DIRECTION, GROUP, MOST, ORIGIN, SECOND, THIRD
from lensbench.core.scenery.intersect.block_bounds import beam_misses
from lensbench.core.scenery.intersect.texture import REPEATED, TEXTURE, look_up_texture, texture
from lensbench.core.scenery.intersect.triangle_tree import (
    TriangleTree, depth_of_stack, inverse_of, scratch_of, search, search_group, triangle_tree
)
from lensbench.core.scenery.surface_codes import INSIDE, SOLID, is_ball

MOST_KEPT, NEWEST = 48 << 20, 4         # bytes of trees and their meshes, for scenes seen before; trees of one scene

# Bounding sphere of all meshes
CENTRE, REACH, MESHES = offsets(3, 1)
# Integers of `find_meshes`: places and counts of the tree, and how deep its stack is; then those of the surfaces
NODES, NODE_COUNT, LEAVES, LEAF_COUNT, STACK, TREE = range(6)
CORNERS, CORNER_COUNT, VERTICES, VERTEX_COUNT, OWNERS = range(TREE, TREE + 5)
# Of a vertex: position, normal (0 where there is none), place in the image, colour
PLACE, NORMAL, UV, TINT, VERTEX = offsets(3, 3, 2, 3)
# Of a mesh in `mesh_surfaces`; GREATEST: of its texture. Integers: whether it has one, and those of the texture
COLOUR, EMISSION, OWN_FINISH, GREATEST, SURFACE = offsets(3, 1, 1, 1)
TEXTURED, SURFACE_INTEGERS = 0, 1 + TEXTURE


class Surfaces(NamedTuple):
    """Triangles of several meshes: tree, corners (n, 3) int32, vertices (m, VERTEX) float32, meshes (n,) int32."""

    tree: TriangleTree
    corners: np.ndarray
    vertices: np.ndarray
    owners: np.ndarray

    @property
    def tree_integers(self) -> list[int]:
        """Where the tree lies, for `search`."""
        nodes, leaves = self.tree.nodes, self.tree.leaves
        return [address(nodes), nodes.size, address(leaves), leaves.size, depth_of_stack(len(self.corners))]

    @property
    def find_integers(self) -> list[int]:
        """Integers of `find_meshes`."""
        return [*self.tree_integers, address(self.corners), self.corners.size, address(self.vertices),
                self.vertices.size, address(self.owners)]

    @property
    def bounds(self) -> np.ndarray:
        """Bounding sphere of all triangles."""
        low, high = self.tree.low, self.tree.high
        return pack(MESHES, {CENTRE: (low + high) / 2.0, REACH: math.dist(low, high) / 2.0 * (1.0 + 1e-5) + 1e-3})


@byte_cache(MOST_KEPT, 8, NEWEST)
def surfaces(meshes: tuple[Any, ...]) -> Surfaces:
    """One tree over all triangles of some meshes."""
    corners, vertices, owners, first = [], [], [], 0
    for k, mesh in enumerate(meshes):
        table = np.zeros((len(mesh.points), VERTEX), np.float32)
        table[:, PLACE:NORMAL], table[:, TINT:] = mesh.points, 1.0
        for data, begin, end in ((mesh.normals, NORMAL, UV), (mesh.uv, UV, TINT), (mesh.colours, TINT, VERTEX)):
            if data:
                table[:, begin:end] = np.frombuffer(data, np.float32).reshape(len(table), -1)
        corners.append(mesh.triangles + np.int32(first))
        vertices.append(table)
        owners.append(np.full(len(mesh.triangles), k, np.int32))
        first += len(table)
    all_corners, all_vertices = np.concatenate(corners), np.concatenate(vertices)
    tree = triangle_tree(all_vertices[all_corners, :NORMAL])
    return Surfaces(tree, np.ascontiguousarray(all_corners, np.int32), all_vertices, np.concatenate(owners))


def mesh_steps(meshes: Sequence[Any], emission: Sequence[float]) -> list[Step]:
    """The stages of meshes, after `beam`. emission: value of the row EMITS for each."""
    tree = surfaces(tuple(meshes))
    numbers, integers, kept = [], [], []
    for mesh, emits in zip(meshes, emission, strict=True):
        material = mesh.material
        image = None if material.pattern is None else texture(material.pattern.image)
        numbers.append(pack(SURFACE, {COLOUR: material.colour, EMISSION: emits, OWN_FINISH: material.finish(SOLID),
                                      GREATEST: 0.0 if image is None else image.greatest}))
        integers += [int(image is not None), *([0] * TEXTURE if image is None else image.integers(REPEATED))]
        kept.append(image)
    return [Step(find_meshes, tree.bounds, tree.find_integers, kept=tree),
            Step(mesh_surfaces, np.concatenate(numbers), integers, kept=kept)]


@stage(allocates=True)
def find_meshes(lanes, p, ints, key):
    """Find the nearest triangles, after `beam`, for `mesh_surfaces`.  p, ints: mesh_steps.

    A0: distance where a triangle is the nearest surface, else 0; A1, A2: u and v of its image in [−1, 1]; A3: its mesh;
    A7: sides of the footprint in the image; A8: 1 where the corners turn clockwise, the inside of a closed mesh;
    A9 A10 A11: the colour of its corners. DEPTH and the normal are recorded.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, depth = row[X], row[Y], row[Z], row[L], row[M], row[N], row[DEPTH]
    nx, ny, nz, side, spread = row[NX], row[NY], row[NZ], row[PIXEL_SIDE], row[PIXEL_SPREAD]
    met, u, v, mesh, wide, back = row[A0], row[A1], row[A2], row[A3], row[A7], row[A8]
    r, g, b = row[A9], row[A10], row[A11]
    for i in range(B):
        met[i] = real(0)
    (cx, cy, cz), reach = vector(p, CENTRE), p[REACH]
    if beam_misses(row[BEAM], cx, cy, cz, reach, reach, reach):
        return
    nodes = borrowed(ints[NODES], ints[NODE_COUNT], np.float32)
    leaves = borrowed(ints[LEAVES], ints[LEAF_COUNT], np.float32)
    corners = borrowed(ints[CORNERS], ints[CORNER_COUNT], np.int32)
    vertices = borrowed(ints[VERTICES], ints[VERTEX_COUNT], np.float32)
    owners = borrowed(ints[OWNERS], ints[CORNER_COUNT], np.int32)
    scratch = scratch_of(real, ints[STACK])
    group, numbers = scratch.group, scratch.numbers
    for i in range(B):
        ray = np.uint64(i % GROUP)
        if ray == np.uint64(0):
            for table, line in ((x, ORIGIN), (y, ORIGIN + 1), (z, ORIGIN + 2), (dx, DIRECTION), (dy, DIRECTION + 1),
                                (dz, DIRECTION + 2), (depth, MOST)):
                for e in range(GROUP):
                    group[line * GROUP + e] = table[i + e]
            search_group(real, nodes, leaves, False, scratch)
        number = numbers[ray]
        if number < 0:
            continue
        t = group[np.uint64(MOST * GROUP) + ray]
        second, third = group[np.uint64(SECOND * GROUP) + ray], group[np.uint64(THIRD * GROUP) + ray]

        # Interpolate between the corners
        k = np.uint64(number) * np.uint64(3)
        q, m = np.uint64(corners[k]) * np.uint64(VERTEX), np.uint64(corners[k + np.uint64(1)]) * np.uint64(VERTEX)
        n = np.uint64(corners[k + np.uint64(2)]) * np.uint64(VERTEX)
        first = real(1) - second - third
        _, (bx, by, bz), (cx, cy, cz) = corner_places(real, corners, vertices, number)
        fx, fy, fz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
        area = math.sqrt(fx * fx + fy * fy + fz * fz)
        sx = _between(real, vertices, q, m, n, first, second, third, NORMAL)
        sy = _between(real, vertices, q, m, n, first, second, third, NORMAL + 1)
        sz = _between(real, vertices, q, m, n, first, second, third, NORMAL + 2)
        smooth = math.sqrt(sx * sx + sy * sy + sz * sz)
        facing = real(-1) if fx * dx[i] + fy * dy[i] + fz * dz[i] > real(0) else real(1)
        if smooth > real(1e-3):
            # The smooth normal on the side of the ray, and never away from it
            per = real(1) / smooth
            per = -per if (sx * fx + sy * fy + sz * fz) * facing < real(0) else per
            sx, sy, sz = sx * per, sy * per, sz * per
            away = sx * dx[i] + sy * dy[i] + sz * dz[i]
            if away > real(-1e-3):
                away += real(1e-3)
                sx, sy, sz = sx - away * dx[i], sy - away * dy[i], sz - away * dz[i]
                per = real(1) / math.sqrt(sx * sx + sy * sy + sz * sz)
                sx, sy, sz = sx * per, sy * per, sz * per
        else:
            per = facing / area
            sx, sy, sz = fx * per, fy * per, fz * per
        ua, va = _at(real, vertices, q, UV), _at(real, vertices, q, UV + 1)
        ub, vb = _at(real, vertices, m, UV) - ua, _at(real, vertices, m, UV + 1) - va
        uc, vc = _at(real, vertices, n, UV) - ua, _at(real, vertices, n, UV + 1) - va
        ua, va = ua + second * ub + third * uc, va + second * vb + third * vc
        met[i], depth[i], mesh[i] = t, t, real(owners[np.uint64(number)])
        nx[i], ny[i], nz[i], back[i] = sx, sy, sz, real(0.5) * (real(1) - facing)
        u[i], v[i] = real(2) * (ua - np.floor(ua)) - real(1), real(2) * (va - np.floor(va)) - real(1)
        wide[i] = real(2) * abs(side[i] + t * spread[i]) * math.sqrt(abs(ub * vc - uc * vb) / area)
        r[i] = _between(real, vertices, q, m, n, first, second, third, TINT)
        g[i] = _between(real, vertices, q, m, n, first, second, third, TINT + 1)
        b[i] = _between(real, vertices, q, m, n, first, second, third, TINT + 2)


@njit(inline="always")
def corner_places(real, corners, vertices, number):
    """The first corner of a triangle, and the way from there to the others; all in mm."""
    k = np.uint64(number) * np.uint64(3)
    q, m = np.uint64(corners[k]) * np.uint64(VERTEX), np.uint64(corners[k + np.uint64(1)]) * np.uint64(VERTEX)
    n = np.uint64(corners[k + np.uint64(2)]) * np.uint64(VERTEX)
    x, y, z = _at(real, vertices, q, PLACE), _at(real, vertices, q, PLACE + 1), _at(real, vertices, q, PLACE + 2)
    return ((x, y, z),
            (_at(real, vertices, m, PLACE) - x, _at(real, vertices, m, PLACE + 1) - y,
             _at(real, vertices, m, PLACE + 2) - z),
            (_at(real, vertices, n, PLACE) - x, _at(real, vertices, n, PLACE + 1) - y,
             _at(real, vertices, n, PLACE + 2) - z))


@njit(inline="always")
def _at(real, table, first, k):
    """A number of a vertex in the type of the lanes."""
    return real(table[first + np.uint64(k)])


@njit(inline="always")
def _between(real, table, q, m, n, first, second, third, k):
    """A number of three vertices, from q, m and n on, weighed by their shares."""
    return first * _at(real, table, q, k) + second * _at(real, table, m, k) + third * _at(real, table, n, k)


@stage(allocates=True)
def mesh_surfaces(lanes, p, ints, key):
    """The materials of the meshes that `find_meshes` has found, directly after it.  p, ints: mesh_steps."""
    real = lanes.dtype.type
    row = rows(lanes)
    emits, finish, red, green, blue = row[EMITS], row[FINISH], row[RED], row[GREEN], row[BLUE]
    met, u, v, mesh, wide_u, wide_v = row[A0], row[A1], row[A2], row[A3], row[A7], row[A8]
    er, eg, eb, r, g, b = row[A4], row[A5], row[A6], row[A9], row[A10], row[A11]
    count = np.int32(0)
    for i in range(B):
        count = np.int32(count + np.int32(met[i] > real(0)))
    if count == 0:
        return
    kept = np.empty((7, B), lanes.dtype)
    for s in range(0, p.size, SURFACE):
        number = s // SURFACE
        this, k = real(number), number * SURFACE_INTEGERS
        (cr, cg, cb), emission, own_finish = vector(p, s + COLOUR), p[s + EMISSION], p[s + OWN_FINISH]
        greatest = p[s + GREATEST]
        count = np.int32(0)
        for i in range(B):
            count = np.int32(count + np.int32((met[i] > real(0)) & (mesh[i] == this)))
        if count == 0:
            continue
        for i in range(B):
            hit = (met[i] > real(0)) & (mesh[i] == this)
            inside = is_ball(real, own_finish) & (wide_v[i] > real(0.5))
            emits[i] = emission if hit else emits[i]
            finish[i] = (real(INSIDE) if inside else own_finish) if hit else finish[i]
            er[i], eg[i], eb[i] = (real(1) if inside else cr * r[i], real(1) if inside else cg * g[i],
                                   real(1) if inside else cb * b[i])
            red[i], green[i], blue[i] = (er[i] if hit else red[i], eg[i] if hit else green[i],
                                         eb[i] if hit else blue[i])
        if ints[k + TEXTURED] == 0:
            continue

        # Look up its image, and keep what the look-up overwrites for the other meshes
        for i in range(B):
            kept[0, i], kept[1, i], kept[2, i], kept[3, i] = u[i], v[i], mesh[i], wide_u[i]
            kept[4, i], kept[5, i], kept[6, i], wide_v[i] = r[i], g[i], wide_v[i], wide_u[i]
        look_up_texture(lanes, greatest, ints[k + 1:k + 1 + TEXTURE])
        for i in range(B):
            u[i], v[i], mesh[i], wide_u[i] = kept[0, i], kept[1, i], kept[2, i], kept[3, i]
            r[i], g[i], wide_v[i] = kept[4, i], kept[5, i], kept[6, i]
            hit = (met[i] > real(0)) & (mesh[i] == this)
            red[i], green[i], blue[i] = (red[i] * er[i] if hit else red[i], green[i] * eg[i] if hit else green[i],
                                         blue[i] * eb[i] if hit else blue[i])


@njit(nogil=True, cache=True, error_model="numpy")
def _distances(nodes, leaves, stack, origins, directions, out):
    links, entries, scratch = np.empty(stack, np.int32), np.empty(stack, np.float64), np.empty(24, np.float64)
    for i in range(len(origins)):
        direction = directions[i, 0], directions[i, 1], directions[i, 2]
        number, t, _, _ = search(np.float64, nodes, leaves, (origins[i, 0], origins[i, 1], origins[i, 2]), direction,
                                 inverse_of(np.float64, direction), np.inf, False, links, entries, scratch)
        out[i] = t if number >= 0 else np.nan


def nearest_distances(meshes: tuple[Any, ...], origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Distance (n,) along rays (n, 3), in double precision; nan where a ray misses all meshes."""
    tree, out = surfaces(meshes).tree, np.empty(len(origins))
    _distances(tree.nodes.ravel(), tree.leaves.ravel(), depth_of_stack(len(tree.leaves) * 8),
               np.ascontiguousarray(origins, np.float64), np.ascontiguousarray(directions, np.float64), out)
    return out
