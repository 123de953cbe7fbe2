"""Light on surfaces: the sky's and the ambient light, and the bookkeeping of a path.

Without shadows, mirrors and lamps, one stage does everything: `daylight`. Otherwise a path is a round of stages: the
intersections, the coats, `gather_emission`, then each light adds to the sum S; `specular_bounce` begins the next
round, and `finish_path` ends the last.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, BLUE, DEPTH, EMITS, FINISH, GREEN, LIT, NX, NY, NZ, PATH, RED, SB, SG, SR, TB, TG, TIME, TR,
    B, L, M, N, Packed, X, Y, Z, offsets, pack, rows, stage, vector
)
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.numeric import sine_versine
from lensbench.core.scenery.intersect.block_bounds import lit_bounds
from lensbench.core.scenery.intersect.moving_objects import COUNT, LENGTH, MOTION, motion_of, moving_groups, rotated
from lensbench.core.scenery.intersect.sky import SKY, gradient
from lensbench.core.scenery.intersect.spheres import CROWD, counts_below, sphere_tree
from lensbench.core.scenery.objects.shape import Shape
from lensbench.core.scenery.surface_codes import DIRECT, is_ball, is_glass, is_seen, is_specular, shines

# ∫ (w·u)₊ (w·n)₊ dw / π over the cosine of the angle between u and n: a quartic, exact at −1, 0 and 1, within 0.002
RISE0, RISE1, RISE2, RISE4 = 2 / (3 * math.pi), 1 / 3, 1 / (3 * math.pi), 1 / 3 - 1 / math.pi
INDEX = 1.5             # of glass and coats
F0 = ((INDEX - 1) / (INDEX + 1)) ** 2

# Light from everywhere: the sky's numbers, then the AMBIENT radiance. Spheres that occlude the sky follow, or lamps
_, AMBIENT, SURROUND = offsets(SKY, 3)
# RADIUS2: of a node of many spheres, the sum of theirs, and CENTRE their mean; REACH: what they extend from there (mm).
# Integers: how many follow each and belong to it
CENTRE, RADIUS2, REACH, OCCLUDER = offsets(3, 1, 1)
FAR = 4.0               # × the reach of a node: from there on it is one sphere,
FAINT = 0.04            # if it covers no more of the sky than this. Light is then right to half a percent
# `daylight`, after SURROUND
SUN_DIRECTION, SUN_IRRADIANCE, DAYLIGHT = SURROUND, SURROUND + 3, SURROUND + 6
# A lamp without shadows. POINT_AREA: unit normal times area / π; POINT_RADIUS2: of a sphere, else 0
POINT_PLACE, POINT_AREA, POINT_RADIUS2, POINT_LIGHT, POINT = offsets(3, 3, 1, 3)


@njit(inline="always")
def schlick_edge(real, cosine):
    """(1 − cos θ)⁵ of Schlick's reflectance F0 + (1 − F0) (1 − cos θ)⁵ (Schlick 1994)."""
    edge = real(1) - (cosine if cosine > real(0) else real(0))
    edge2 = edge * edge
    return edge2 * edge2 * edge


@njit(inline="always")
def rise(real, up):
    """Share of the difference zenith − horizon in the irradiance on a surface whose normal has this part along up."""
    return real(RISE0) + up * (real(RISE1) + up * (real(RISE2) + up * up * real(RISE4)))


@njit(inline="always")
def irradiance(real, p):
    """Coefficients of the irradiance / π of sky and ambient light, 3 each.

    Mean, its change with the height of the normal, difference zenith − horizon, up.
    """
    (r, g, b), change, (gr, gg, gb), up = gradient(p, 0)
    ar, ag, ab = vector(p, AMBIENT)
    half = real(0.5)
    return ((ar + half * (r + gr), ag + half * (g + gg), ab + half * (b + gb)),
            (half * (r - gr), half * (g - gg), half * (b - gb)), change, up)


@stage
def daylight(lanes, p, ints, key):
    """Turn albedo into radiance under sky, ambient light and sun without shadows.  p: DAYLIGHT numbers."""
    real = lanes.dtype.type
    row = rows(lanes)
    emits, nx, ny, nz = row[EMITS], row[NX], row[NY], row[NZ]
    red, green, blue = row[RED], row[GREEN], row[BLUE]
    (er, eg, eb), (dr, dg, db), (zr, zg, zb), (ux, uy, uz) = irradiance(real, p)
    (sx, sy, sz), (sr, sg, sb) = vector(p, SUN_DIRECTION), vector(p, SUN_IRRADIANCE)
    for i in range(B):
        up = ux * nx[i] + uy * ny[i] + uz * nz[i]
        high = rise(real, up)
        slant = sx * nx[i] + sy * ny[i] + sz * nz[i]
        slant = slant if slant > real(0) else real(0)
        emitter = shines(real, emits[i])
        red[i] *= real(1) if emitter else er + up * dr + high * zr + slant * sr
        green[i] *= real(1) if emitter else eg + up * dg + high * zg + slant * sg
        blue[i] *= real(1) if emitter else eb + up * db + high * zb + slant * sb


@stage
def begin_path(lanes, p, ints, key):
    """Begin a path: full throughput (T = 1), no radiance gathered (S = 0)."""
    real = lanes.dtype.type
    row = rows(lanes)
    tr, tg, tb, sr, sg, sb, path = row[TR], row[TG], row[TB], row[SR], row[SG], row[SB], row[PATH]
    for i in range(B):
        path[i] = real(DIRECT)
        tr[i], tg[i], tb[i] = real(1), real(1), real(1)
        sr[i], sg[i], sb[i] = real(0), real(0), real(0)


@stage
def gather_emission(lanes, p, ints, key):
    """Add emission to S, weight albedo by the throughput T, and tint T at metal and glass; set key[LIT].

    Albedo becomes T · albedo, what a unit of irradiance / π adds to S. Metal and glass have none: T is multiplied by
    Schlick's reflectance, by the part 1 − F that enters a ball or a mesh, or by (1 − F) / (1 + F) of a pane.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, nx, ny, nz = row[L], row[M], row[N], row[NX], row[NY], row[NZ]
    emits, finish, red, green, blue = row[EMITS], row[FINISH], row[RED], row[GREEN], row[BLUE]
    tr, tg, tb, sr, sg, sb, path = row[TR], row[TG], row[TB], row[SR], row[SG], row[SB], row[PATH]

    # Add emission, weight albedo
    mirrors, lit = np.int32(0), np.int32(0)
    for i in range(B):
        r, g, b = red[i] * tr[i], green[i] * tg[i], blue[i] * tb[i]
        emitter, shown, mirror = shines(real, emits[i]), is_seen(real, emits[i], path[i]), is_specular(real, finish[i])
        sr[i] += r if shown else real(0)
        sg[i] += g if shown else real(0)
        sb[i] += b if shown else real(0)
        red[i], green[i], blue[i] = real(0) if emitter else r, real(0) if emitter else g, real(0) if emitter else b
        albedo = real(0) if emitter | mirror else r + g + b
        mirrors, lit = np.int32(mirrors + np.int32(mirror)), np.int32(lit + np.int32(albedo > real(0)))
    key[LIT] = np.uint32(1) if lit > 0 else np.uint32(0)
    if mirrors == 0:
        return

    # Tint the throughput at metal and glass
    for i in range(B):
        edge5 = schlick_edge(real, -(dx[i] * nx[i] + dy[i] * ny[i] + dz[i] * nz[i]))
        f = real(F0) + real(1 - F0) * edge5
        clear = real(1) - f if is_ball(real, finish[i]) else (real(1) - f) / (real(1) + f)
        mirror, glass = is_specular(real, finish[i]), is_glass(real, finish[i])
        r, g, b = red[i], green[i], blue[i]
        tr[i] = r * clear if glass else r + edge5 * (tr[i] - r) if mirror else tr[i]
        tg[i] = g * clear if glass else g + edge5 * (tg[i] - g) if mirror else tg[i]
        tb[i] = b * clear if glass else b + edge5 * (tb[i] - b) if mirror else tb[i]
        red[i] = real(0) if mirror else r
        green[i] = real(0) if mirror else g
        blue[i] = real(0) if mirror else b


@stage
def finish_path(lanes, p, ints, key):
    """RED, GREEN, BLUE: the radiance that the path has gathered."""
    row = rows(lanes)
    red, green, blue, sr, sg, sb = row[RED], row[GREEN], row[BLUE], row[SR], row[SG], row[SB]
    for i in range(B):
        red[i], green[i], blue[i] = sr[i], sg[i], sb[i]


@stage(inlined=True)
def met_points(lanes):
    """A0, A1, A2: the points of the surfaces that the rays meet, mm."""
    row = rows(lanes)
    x, y, z, dx, dy, dz, depth = row[X], row[Y], row[Z], row[L], row[M], row[N], row[DEPTH]
    hx, hy, hz = row[A0], row[A1], row[A2]
    for i in range(B):
        t = depth[i]
        hx[i], hy[i], hz[i] = x[i] + t * dx[i], y[i] + t * dy[i], z[i] + t * dz[i]


def sky_occluders(spheres: Sequence[Any]) -> Packed:
    """A tree of spheres that occlude the sky, as `ambient` reads it; glass occludes a part of what it covers."""
    centres = np.array([s.centre for s in spheres]).reshape(-1, 3)
    radii = np.array([s.radius for s in spheres])
    covers = radii**2 * [0.4 if s.material.kind == "glass" else 1.0 for s in spheres]
    tree, numbers = sphere_tree(centres), [np.zeros(0)]
    for members, _ in tree:
        middle = np.average(centres[members], 0, covers[members]) if len(members) > 1 else centres[members[0]]
        reach = (np.linalg.norm(centres[members] - middle, axis=1) + radii[members]).max()
        numbers.append(pack(OCCLUDER, {CENTRE: middle, RADIUS2: covers[members].sum(), REACH: reach}))
    return Packed(np.concatenate(numbers), counts_below(tree))


def moving_sky_occluders(spheres: Sequence[Shape], opening: float) -> Packed:
    """What moving spheres occlude of the sky, as `ambient` reads it. opening: seconds at TIME 0."""
    return moving_groups(spheres, opening, lambda group, _: sky_occluders(group))


@stage
def ambient(lanes, p, ints, key):
    """Add the light of the sky and the ambient light, less what spheres occlude, in closed form.

    A sphere of radius r at distance d, its centre at the angle θ from the normal, covers cos θ r²/d² of the
    irradiance of a uniform sky (exact where it lies entirely above the surface's horizon); several multiply.
    p, ints: `after` of SURROUND numbers with sky_occluders, and moving_sky_occluders.
    """
    real, still = lanes.dtype.type, ints[0]
    met_points(lanes)
    free = rows(lanes)[A3]
    for i in range(B):
        free[i] = real(1)
    sky_occlusion(lanes, p[SURROUND:still], ints[1:])
    moving_sky_occlusion(lanes, p[still:], ints[1 + (still - SURROUND) // OCCLUDER:])
    add_sky(lanes, p)


@stage
def open_light(lanes, p, ints, key):
    """Add the light of the sky, the ambient light and that of lamps, each as a point at its middle, without shadows.

    A planar lamp gives L cos θ cos θ′ A / (π d²), a sphere by its solid angle L cos θ · 2 (1 − cos θm).
    p: SURROUND numbers, then POINT for each lamp.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    free = row[A3]
    for i in range(B):
        free[i] = real(1)
    add_sky(lanes, p)
    met_points(lanes)
    nx, ny, nz, red, green, blue = row[NX], row[NY], row[NZ], row[RED], row[GREEN], row[BLUE]
    hx, hy, hz, sr, sg, sb = row[A0], row[A1], row[A2], row[SR], row[SG], row[SB]
    for s in range(SURROUND, p.size, POINT):
        (cx, cy, cz), (ux, uy, uz) = vector(p, s + POINT_PLACE), vector(p, s + POINT_AREA)
        r2, (er, eg, eb) = p[s + POINT_RADIUS2], vector(p, s + POINT_LIGHT)
        if r2 > real(0):
            for i in range(B):
                qx, qy, qz = cx - hx[i], cy - hy[i], cz - hz[i]
                d2 = qx * qx + qy * qy + qz * qz
                sine2 = r2 / d2 if r2 < d2 else real(1)
                light = (nx[i] * qx + ny[i] * qy + nz[i] * qz) / math.sqrt(d2)
                light *= real(2) * sine2 / (real(1) + math.sqrt(real(1) - sine2))
                light = light if light > real(0) else real(0)
                sr[i] += red[i] * light * er
                sg[i] += green[i] * light * eg
                sb[i] += blue[i] * light * eb
            continue
        for i in range(B):
            qx, qy, qz = cx - hx[i], cy - hy[i], cz - hz[i]
            per = real(1) / math.sqrt(qx * qx + qy * qy + qz * qz)
            slant = (nx[i] * qx + ny[i] * qy + nz[i] * qz) * per
            light = slant * abs(ux * qx + uy * qy + uz * qz) * (per * per * per)
            light = light if light > real(0) else real(0)
            sr[i] += red[i] * light * er
            sg[i] += green[i] * light * eg
            sb[i] += blue[i] * light * eb


@stage
def sky_occlusion(lanes, p, ints):
    """Multiply A3 by what spheres leave of the sky.  p, ints: sky_occluders.

    A node of many spheres that is far from all lit points of the block counts as one (Barnes and Hut 1986).
    """
    real = lanes.dtype.type
    row = rows(lanes)
    nx, ny, nz, hx, hy, hz, free = row[NX], row[NY], row[NZ], row[A0], row[A1], row[A2], row[A3]
    box = lit_bounds(lanes) if p.size > 2 * CROWD * OCCLUDER else (real(0), real(0), real(0), real(0), real(0), real(0))
    s, k = 0, 0
    while s < p.size:
        (cx, cy, cz), r2, reach, below = vector(p, s + CENTRE), p[s + RADIUS2], p[s + REACH], ints[k]
        s, k = s + OCCLUDER, k + 1
        if below > 0:
            qx, qy, qz = outside(real, box[0], box[3], cx), outside(real, box[1], box[4], cy), outside(
                real, box[2], box[5], cz)
            d2 = qx * qx + qy * qy + qz * qz
            if (d2 < real(FAR * FAR) * reach * reach) | (d2 * real(FAINT) < r2):
                continue
            s, k = s + below * OCCLUDER, k + below
        for i in range(B):
            free[i] *= unoccluded(real, cx - hx[i], cy - hy[i], cz - hz[i], r2, nx[i], ny[i], nz[i])


@stage
def moving_sky_occlusion(lanes, p, ints):
    """Multiply A3 by what moving spheres leave of the sky at the TIME of each lane.  p, ints: moving_sky_occluders."""
    real = lanes.dtype.type
    row = rows(lanes)
    nx, ny, nz, hx, hy, hz, free, time = row[NX], row[NY], row[NZ], row[A0], row[A1], row[A2], row[A3], row[TIME]
    sine, versine = row[A4], row[A5]
    s, k = 0, 0
    while s < p.size:
        end = s + ints[k + LENGTH]
        px, py, pz, vx, vy, vz, ax, ay, az, rate, phase = motion_of(p, s)
        for i in range(B):
            sine[i], versine[i] = sine_versine(real, rate * time[i] + phase)
        for j in range(s + MOTION, end, OCCLUDER):
            (cx, cy, cz), r2 = vector(p, j + CENTRE), p[j + RADIUS2]
            cx, cy, cz = cx - px, cy - py, cz - pz
            for i in range(B):
                qx, qy, qz = rotated(sine[i], versine[i], ax, ay, az, cx, cy, cz)
                free[i] *= unoccluded(real, qx + (px + vx * time[i]) - hx[i], qy + (py + vy * time[i]) - hy[i],
                                      qz + (pz + vz * time[i]) - hz[i], r2, nx[i], ny[i], nz[i])
        s, k = end, k + ints[k + COUNT]


@njit(inline="always")
def outside(real, low, high, x):
    """Distance of a number from an interval."""
    return max(low - x, x - high, real(0))


@njit(inline="always")
def unoccluded(real, ax, ay, az, r2, nx, ny, nz):
    """Part of the sky's light that a sphere leaves, its centre at a from the point and its radius² r2."""
    d2 = ax * ax + ay * ay + az * az
    above = ax * nx + ay * ny + az * nz
    blocked = r2 * above / (d2 * math.sqrt(d2))
    blocked = blocked if blocked > real(0) else real(0)
    return real(1) - (blocked if blocked < real(1) else real(1))


@stage
def add_sky(lanes, p):
    """Add the light of the sky and the ambient light times A3.  p: SURROUND numbers."""
    real = lanes.dtype.type
    row = rows(lanes)
    nx, ny, nz, red, green, blue = row[NX], row[NY], row[NZ], row[RED], row[GREEN], row[BLUE]
    sr, sg, sb, free = row[SR], row[SG], row[SB], row[A3]
    (er, eg, eb), (gr, gg, gb), (zr, zg, zb), (ux, uy, uz) = irradiance(real, p)
    for i in range(B):
        up = ux * nx[i] + uy * ny[i] + uz * nz[i]
        high = rise(real, up)
        sr[i] += red[i] * free[i] * (er + up * gr + high * zr)
        sg[i] += green[i] * free[i] * (eg + up * gg + high * zg)
        sb[i] += blue[i] * free[i] * (eb + up * gb + high * zb)
