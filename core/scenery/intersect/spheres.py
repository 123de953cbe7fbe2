"""Spheres, seen from outside: one stage for all of them.

Most spheres are far from every ray of a block. Each is first compared with the block's beam, then with every ray, and
only a sphere that some ray crosses is intersected. Many spheres are packed in groups of neighbours, each with a
sphere around it that is compared in the same way.
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
    GLOSS,
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

# A sphere begins as a group does, whose spheres follow its own numbers; integers: how many, for each group
CENTRE, RADIUS2, RADIUS, COLOUR, EMISSION, COAT, SPHERE = offsets(3, 1, 1, 3, 1, 1)
GROUP = RADIUS + 1
CROWD = 8               # a group is split until it holds no more


def _groups(seen: np.ndarray, which: np.ndarray) -> list[np.ndarray]:
    """Groups of neighbours, halved along the widest of three coordinates (n, 3)."""
    if len(which) <= CROWD:
        return [which]
    order = which[np.argsort(seen[which, np.argmax(np.ptp(seen[which], 0))], kind="stable")]
    half = len(which) // 2
    return _groups(seen, order[:half]) + _groups(seen, order[half:])


def sphere_parameters(spheres, emission=None) -> Packed:
    """Parameters of the stage `spheres`: groups of neighbours as seen from the origin, each with its spheres.

    emission: value of the row EMITS for each sphere; by default 1 where it shines and 0 elsewhere.
    """
    emission = [float(s.material.shines) for s in spheres] if emission is None else emission
    packed: list[np.ndarray] = []
    seen = np.array([(s.centre[0], s.centre[1], 0.0) for s in spheres])
    distance = np.array([math.dist(s.centre, (0.0, 0.0, 0.0)) + s.radius for s in spheres])
    seen /= distance[:, None]
    seen[:, 2] = np.log(distance)
    everything = np.arange(len(spheres))
    groups = _groups(seen, everything) if len(spheres) > 2 * CROWD else [everything]
    for group in groups:
        centres = np.array([spheres[j].centre for j in group])
        middle = (centres.min(0) + centres.max(0)) / 2
        reach = max(math.dist(spheres[j].centre, middle) + spheres[j].radius for j in group) * (1.0 + 1e-5)
        packed.append(pack(GROUP, {CENTRE: middle, RADIUS2: math.inf if len(groups) == 1 else reach**2, RADIUS: reach}))
        for j in group:
            s = spheres[j]
            packed.append(pack(SPHERE, {CENTRE: s.centre, RADIUS2: s.radius**2, RADIUS: s.radius,
                                        COLOUR: s.material.colour, EMISSION: emission[j],
                                        COAT: s.material.gloss_code(s.radius)}))
    return Packed(np.concatenate(packed), [len(group) for group in groups])


@stage
def spheres(lanes, p, ints, key):
    """Intersect rays with spheres, after `beam`; the nearest surface stays.  p: sphere_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, emits, gloss, nx, ny, nz = row[DEPTH], row[EMITS], row[GLOSS], row[NX], row[NY], row[NZ]
    red, green, blue, ahead, inside = row[RED], row[GREEN], row[BLUE], row[A0], row[A1]
    seen = row[BEAM]
    s, group, left = 0, 0, 0
    while s < p.size:
        heading = left == 0
        (cx, cy, cz), r2, radius = vector(p, s + CENTRE), p[s + RADIUS2], p[s + RADIUS]

        # Skip a sphere or a whole group that the block's beam misses
        if beam_misses(seen, cx, cy, cz, radius, radius, radius):
            s += GROUP + SPHERE * ints[group] if heading else SPHERE
            group += 1 if heading else 0
            left -= 0 if heading else 1
            continue

        # Find the closest approach of each ray to the centre
        crossed = np.int32(0)
        for i in range(B):
            along, miss2 = closest_approach(cx - x[i], cy - y[i], cz - z[i], dx[i], dy[i], dz[i])
            room = r2 - miss2
            ahead[i], inside[i] = along, room
            crossed = np.int32(crossed + np.int32(room > real(0)))

        # Enter or skip a group
        if heading:
            left = ints[group]
            s, group = s + GROUP, group + 1
            if crossed == 0:
                s += left * SPHERE
                left = 0
            continue

        # Record the front of the sphere where it is the nearest surface
        scale = real(1) / radius
        (r, g, b), emission, coat = vector(p, s + COLOUR), p[s + EMISSION], p[s + COAT]
        s += SPHERE
        left -= 1
        if crossed == 0:
            continue
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
            gloss[i] = coat if hit else gloss[i]
