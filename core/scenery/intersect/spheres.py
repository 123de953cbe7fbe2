"""Spheres, seen from outside: one stage for all of them, and a tree that other stages share.

Most spheres are far from every ray of a block. Each is first compared with the block's beam, then with every ray, and
only a sphere that some ray crosses is intersected. Many spheres make a tree, whose nodes are compared in the same way:
a list in preorder, a node before the nodes and spheres below it, with an integer for how many of them follow. A stage
that is done with a node goes on behind these. The spheres of a small scene make a plain list.

Intersection with a sphere or a plane is written for one lane, without branches; rays are o + t d, d a unit vector.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from lensbench.core.kernels.block import (
    A0, A1, BEAM, BLUE, DEPTH, EMITS, FINISH, GREEN, NX, NY, NZ, RED, B, L, M, N, Packed, X, Y, Z, offsets, pack, rows,
    stage, vector
)
from lensbench.core.kernels.cache import njit
from lensbench.core.scenery.intersect.block_bounds import beam_misses

CROWD = 8               # a node is halved until it holds no more spheres; a scene of twice as many has a tree


class Entry(NamedTuple):
    """A sphere, or a node with all spheres below it."""

    members: np.ndarray         # indices of the spheres
    below: int                  # entries that follow and belong to it: 0 for a sphere


def sphere_tree(centres: np.ndarray) -> list[Entry]:
    """Entries in preorder for spheres with these centres (n, 3), halved along the widest side of a node."""
    everything = np.arange(len(centres))
    if len(centres) <= 2 * CROWD:
        return [Entry(everything[j:j + 1], 0) for j in everything]
    return _below(np.asarray(centres, np.float64), everything)


def _below(centres: np.ndarray, which: np.ndarray) -> list[Entry]:
    """Entries below a node, without its own."""
    if len(which) <= CROWD:
        return [Entry(which[j:j + 1], 0) for j in range(len(which))]
    order = which[np.argsort(centres[which, np.argmax(np.ptp(centres[which], 0))], kind="stable")]
    entries = []
    for half in (order[:len(order) // 2], order[len(order) // 2:]):
        inner = _below(centres, half)
        entries += [Entry(half, len(inner)), *inner]
    return entries


def counts_below(entries: Sequence[Entry]) -> list[int]:
    """How many entries follow each and belong to it."""
    return [entry.below for entry in entries]


def bounding_sphere(centres: np.ndarray, radii: np.ndarray) -> tuple[np.ndarray, float]:
    """Centre and radius of a sphere around spheres, larger by what float32 may round."""
    middle = (centres.min(0) + centres.max(0)) / 2
    return middle, float((np.linalg.norm(centres - middle, axis=1) + radii).max()) * (1.0 + 1e-5)


@njit(inline="always")
def closest_approach(cx, cy, cz, dx, dy, dz):
    """Distance along a ray to the point nearest to a centre at c from its origin, and the square of that miss."""
    along = cx * dx + cy * dy + cz * dz
    ox, oy, oz = cx - along * dx, cy - along * dy, cz - along * dz
    return along, ox * ox + oy * oy + oz * oz


@njit(inline="always")
def plane_point(ox, oy, oz, dx, dy, dz, ux, uy, uz, ax, ay, az, bx, by, bz):
    """Distance to the plane through the centre, at −o from the ray's origin, with the normal u; and u, v there.

    a, b: the half-axes over the squares of their lengths.
    """
    t = -(ox * ux + oy * uy + oz * uz) / (dx * ux + dy * uy + dz * uz)
    qx, qy, qz = ox + t * dx, oy + t * dy, oz + t * dz
    return t, qx * ax + qy * ay + qz * az, qx * bx + qy * by + qz * bz


@njit(inline="always")
def inside_edge(real, u, v, disk):
    """Whether a point at u, v half-axes lies on a rectangle (disk = 0) or an ellipse (disk = 1)."""
    u2, v2 = u * u, v * v
    most = u2 if u2 > v2 else v2
    return most + disk * (u2 + v2 - most) <= real(1)


# A sphere, or a node of the tree of spheres, which has only the first three. Integers: how many follow each and belong
# to it
CENTRE, RADIUS2, RADIUS, COLOUR, EMISSION, OWN_FINISH, SPHERE = offsets(3, 1, 1, 3, 1, 1)


def sphere_parameters(spheres: Sequence[Any], emission: Sequence[float] | None = None) -> Packed:
    """Parameters of the stage `spheres`: a tree of neighbours as seen from the origin.

    emission: value of the row EMITS for each sphere; by default 1 where it shines and 0 elsewhere.
    """
    emission = [float(s.material.shines) for s in spheres] if emission is None else emission
    centres, radii = np.array([s.centre for s in spheres]), np.array([s.radius for s in spheres])
    distance = np.linalg.norm(centres, axis=1) + radii
    tree = sphere_tree(np.column_stack([centres[:, :2] / distance[:, None], np.log(distance)]))
    packed = []
    for members, below in tree:
        if below:
            middle, reach = bounding_sphere(centres[members], radii[members])
            packed.append(pack(SPHERE, {CENTRE: middle, RADIUS2: reach**2, RADIUS: reach}))
            continue
        s, shines = spheres[members[0]], emission[members[0]]
        packed.append(pack(SPHERE, {CENTRE: s.centre, RADIUS2: s.radius**2, RADIUS: s.radius,
                                    COLOUR: s.material.colour, EMISSION: shines,
                                    OWN_FINISH: s.material.finish(s.radius)}))
    return Packed(np.concatenate(packed), counts_below(tree))


@stage
def spheres(lanes, p, ints, key):
    """Intersect rays with spheres, after `beam`; the nearest surface stays.  p: sphere_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, emits, finish, nx, ny, nz = row[DEPTH], row[EMITS], row[FINISH], row[NX], row[NY], row[NZ]
    red, green, blue, ahead, inside = row[RED], row[GREEN], row[BLUE], row[A0], row[A1]
    bounds = row[BEAM]
    s, k = 0, 0
    while s < p.size:
        (cx, cy, cz), r2, radius, below = vector(p, s + CENTRE), p[s + RADIUS2], p[s + RADIUS], ints[k]
        (r, g, b), emission, own_finish = vector(p, s + COLOUR), p[s + EMISSION], p[s + OWN_FINISH]
        s, k = s + SPHERE, k + 1

        # Skip a sphere or a whole node that the block's beam misses
        if beam_misses(bounds, cx, cy, cz, radius, radius, radius):
            s, k = s + below * SPHERE, k + below
            continue
        if below > CROWD:
            continue

        # Find the closest approach of each ray to the centre; enter or skip a small node
        crossed = np.int32(0)
        for i in range(B):
            along, miss2 = closest_approach(cx - x[i], cy - y[i], cz - z[i], dx[i], dy[i], dz[i])
            room = r2 - miss2
            ahead[i], inside[i] = along, room
            crossed = np.int32(crossed + np.int32(room > real(0)))
        if crossed == 0:
            s, k = s + below * SPHERE, k + below
        if (crossed == 0) | (below > 0):
            continue

        # Record the front of the sphere where it is the nearest surface
        scale = real(1) / radius
        for i in range(B):
            t, near = ahead[i] - math.sqrt(inside[i]), depth[i]
            hit = (t > real(0)) & (t < near)
            depth[i] = t if hit else near
            nx[i] = (x[i] + t * dx[i] - cx) * scale if hit else nx[i]
            ny[i] = (y[i] + t * dy[i] - cy) * scale if hit else ny[i]
            nz[i] = (z[i] + t * dz[i] - cz) * scale if hit else nz[i]
            red[i] = r if hit else red[i]
            green[i] = g if hit else green[i]
            blue[i] = b if hit else blue[i]
            emits[i] = emission if hit else emits[i]
            finish[i] = own_finish if hit else finish[i]
