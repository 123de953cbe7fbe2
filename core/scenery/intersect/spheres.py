"""Spheres, seen from outside: one stage for all of them.

Most spheres are far from every ray of a block. Each is first compared with the block's beam, then with every ray, and
only a sphere that some ray crosses is intersected. Many spheres make a tree, whose nodes are compared in the same way.
"""

import math

import numpy as np

from lensbench.kernels.block import (
    A0,
    A1,
    BEAM,
    BLUE,
    DEPTH,
    EMITS,
    FINISH,
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
from lensbench.kernels.layout import Packed, offsets, pack, vector
from lensbench.scenery.intersect.block_bounds import beam_misses
from lensbench.scenery.intersect.quadrics import closest_approach
from lensbench.scenery.intersect.sphere_tree import CROWD, bounding_sphere, counts_below, sphere_tree

# A sphere, or a node of the tree of spheres, which has only the first three. Integers: how many follow each and belong
# to it
CENTRE, RADIUS2, RADIUS, COLOUR, EMISSION, OWN_FINISH, SPHERE = offsets(3, 1, 1, 3, 1, 1)


def sphere_parameters(spheres, emission=None) -> Packed:
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
    seen = row[BEAM]
    s, k = 0, 0
    while s < p.size:
        (cx, cy, cz), r2, radius, below = vector(p, s + CENTRE), p[s + RADIUS2], p[s + RADIUS], ints[k]
        (r, g, b), emission, own_finish = vector(p, s + COLOUR), p[s + EMISSION], p[s + OWN_FINISH]
        s, k = s + SPHERE, k + 1

        # Skip a sphere or a whole node that the block's beam misses
        if beam_misses(seen, cx, cy, cz, radius, radius, radius):
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
