"""Spheres, seen from outside: one stage for all of them.

Most spheres are far from every ray of a block: each is first held against the
block's beam, then against every ray, and only one that some ray crosses is offered.
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
    GLASS,
    GLOSS,
    GREEN,
    METAL,
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
from lensbench.scenery.intersect.block_bounds import beam_misses

SPHERE = 10             # numbers per sphere: centre (3), radius², radius, colour (3), glow, gloss
GROUP = 6               # numbers before a group: a sphere round it (centre, radius², radius), how many spheres
CROWD = 8               # a group is split until it holds no more


def gloss_of(material, radius: float = 0.0) -> float:
    """The value of GLOSS: 0 matte, (0, 1] a coat, METAL, or GLASS + radius (mm; 0 for a pane)."""
    return {"coat": material.gloss, "metal": METAL, "glass": GLASS + radius}.get(material.kind, 0.0)


def _groups(seen: np.ndarray, which: np.ndarray) -> list[np.ndarray]:
    """Those that lie together, halved along the widest of three coordinates (n, 3)."""
    if len(which) <= CROWD:
        return [which]
    order = which[np.argsort(seen[which, np.argmax(np.ptp(seen[which], 0))], kind="stable")]
    half = len(which) // 2
    return _groups(seen, order[:half]) + _groups(seen, order[half:])


def sphere_parameters(spheres, glows=None) -> np.ndarray:
    """What the stage `spheres` reads: groups of neighbours as seen from the origin, each with its spheres.

    glows: the EMITS of each, in place of 1 for what shines and 0 for what does not.
    """
    glows = [float(s.material.shines) for s in spheres] if glows is None else glows
    packed: list[float] = []
    seen = np.array([(s.centre[0], s.centre[1], 0.0) for s in spheres])
    distance = np.array([math.dist(s.centre, (0.0, 0.0, 0.0)) + s.radius for s in spheres])
    seen /= distance[:, None]
    seen[:, 2] = np.log(distance)
    all_of_them = np.arange(len(spheres))
    groups = _groups(seen, all_of_them) if len(spheres) > 2 * CROWD else [all_of_them]
    for group in groups:
        centres = np.array([spheres[j].centre for j in group])
        middle = (centres.min(0) + centres.max(0)) / 2
        reach = max(math.dist(spheres[j].centre, middle) + spheres[j].radius for j in group) * (1.0 + 1e-5)
        packed += [*middle, math.inf if len(groups) == 1 else reach**2, reach, len(group)]
        for j in group:
            s = spheres[j]
            packed += [*s.centre, s.radius**2, s.radius, *s.material.colour, glows[j], gloss_of(s.material, s.radius)]
    return np.array(packed)


@stage
def spheres(lanes, p, key):
    """Offer the spheres where they are nearer, after `beam`.  p: sphere_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, glow, gloss, nx, ny, nz = row[DEPTH], row[EMITS], row[GLOSS], row[NX], row[NY], row[NZ]
    red, green, blue, ahead, inside = row[RED], row[GREEN], row[BLUE], row[A0], row[A1]
    seen = row[BEAM]
    s, left = 0, 0
    while s < p.size:
        heading = left == 0
        cx, cy, cz, r2, radius = p[s], p[s + 1], p[s + 2], p[s + 3], p[s + 4]
        if beam_misses(seen, cx, cy, cz, radius, radius, radius):
            s += SPHERE if not heading else GROUP + SPHERE * int(p[s + 5])
            left -= 0 if heading else 1
            continue
        # how far from the centre each ray passes
        crossed = np.int32(0)
        for i in range(B):
            ax, ay, az = cx - x[i], cy - y[i], cz - z[i]
            along = ax * dx[i] + ay * dy[i] + az * dz[i]
            ox, oy, oz = ax - along * dx[i], ay - along * dy[i], az - along * dz[i]
            room = r2 - (ox * ox + oy * oy + oz * oz)
            ahead[i], inside[i] = along, room
            crossed = np.int32(crossed + np.int32(room > real(0)))
        # a group: into it, or past it
        if heading:
            left = int(p[s + 5])
            s += GROUP
            if crossed == 0:
                s += left * SPHERE
                left = 0
            continue
        scale = real(1) / radius
        r, g, b, shine, coat = p[s + 5], p[s + 6], p[s + 7], p[s + 8], p[s + 9]
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
            glow[i] = shine if hit else glow[i]
            gloss[i] = coat if hit else gloss[i]
