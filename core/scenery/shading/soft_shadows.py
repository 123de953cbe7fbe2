"""Sun and lamps: for each sample one point of the light, chosen by V0 and V1, and one shadow ray to it.

A light is three stages: `sun_rays` or `lamp_rays` find the shadow ray A0 … A5, its length A6 and what arrives
unhindered, A7; `shadows`, and those of meshes, darken A7; `add_lit` adds it to the path. Each lane has moving lamps and
occluders as they are at its TIME.

Lights cast no shadow themselves. The shadow of a glass ball is bright in its middle: it transmits what its two surfaces
do, concentrated towards the axis, an approximation without a second ray (its flux is right, and its place where the
ball touches a surface).
"""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, A7, BEAM, BLUE, DEPTH, GREEN, NX, NY, NZ, RED, SB, SG, SR, TIME, V0, V1, B, L, Packed,
    X, join, offsets, pack, rows, stage, vector
)
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.sampling import concentric_disk
from lensbench.core.scenery.intersect.block_bounds import (
    beam_misses, boxes_disjoint, plane_misses, shadow_beam, shadow_bounds
)
from lensbench.core.scenery.intersect.moving_objects import (
    COUNT, GROUP, LENGTH, MOTION, WHICH, after, enter_rest_frame, keep_world, leave_rest_frame, motion_of,
    motion_parameters, moving_groups, swept_bounds, time_bounds, to_world_frame
)
from lensbench.core.scenery.intersect.spheres import (
    CROWD, bounding_sphere, closest_approach, counts_below, inside_edge, plane_point, sphere_tree
)
from lensbench.core.scenery.objects.shape import Shape, by_family, displaced
from lensbench.core.scenery.objects.surroundings import Sun
from lensbench.core.scenery.shading.bounces import rounded_length
from lensbench.core.scenery.shading.illumination import (
    POINT, POINT_AREA, POINT_LIGHT, POINT_PLACE, POINT_RADIUS2, met_points
)
from lensbench.core.scenery.values import across, unit

# Occluders: spheres and nodes of many, then planar shapes. RADIUS2: of a node, of a sphere around it. TRANSMITTED,
# PANE_TRANSMITTED: part of the light that passes a sphere, a planar shape
CENTRE, RADIUS2, TRANSMITTED, BALL = offsets(3, 1, 1)
_, NORMAL, AXIS_U, AXIS_V, PANE_TRANSMITTED, HALF_WIDTHS, SHADE = offsets(3, 3, 3, 3, 1, 3)
# Integers: how many spheres and nodes, how many planar shapes; then for each sphere and node how many follow it and
# belong to it, and for each planar shape whether it is a disk, 1, or a rectangle, 0
BALLS, SHADES, OCCLUDER_INTEGERS = range(3)
GLASS_BALL = 0.85       # part of the light that passes a glass ball, averaged over incidences

# The sun. RIGHT, UP: unit axes across its direction times the tangent of its angular radius
DIRECTION, RIGHT, UP, SUN = offsets(3, 3, 3)
# A lamp: half-axes, normal and area of a planar one; radius² of a sphere. Integer: its kind
MIDDLE, HALF_A, HALF_B, FACING, AREA, LAMP_RADIUS2, LAMP = offsets(3, 3, 3, 3, 1, 1)
RECTANGLE_LAMP, DISK_LAMP, SPHERE_LAMP = range(3)


def _occluder(shape: Any) -> np.ndarray:
    """A sphere or planar shape as `shadow` reads it."""
    glass = shape.material.kind == "glass"
    if shape.family == "sphere":
        return pack(BALL, {CENTRE: shape.centre, RADIUS2: shape.radius**2, TRANSMITTED: GLASS_BALL if glass else 0.0})
    centre, a, b, normal = shape.frame
    return pack(SHADE, {CENTRE: centre, NORMAL: normal, AXIS_U: a / (a @ a), AXIS_V: b / (b @ b),
                        PANE_TRANSMITTED: 1.0 if glass else 0.0, HALF_WIDTHS: abs(a) + abs(b)})


def occluder_parameters(spheres: Sequence[Any], planar: Sequence[Any]) -> Packed:
    """Parameters of `shadow`: a tree of the spheres, then the planar shapes."""
    centres, radii = np.array([o.centre for o in spheres]).reshape(-1, 3), np.array([o.radius for o in spheres])
    tree, numbers = sphere_tree(centres), [np.zeros(0)]
    for members, below in tree:
        if below:
            middle, reach = bounding_sphere(centres[members], radii[members])
            numbers.append(pack(BALL, {CENTRE: middle, RADIUS2: reach**2}))
        else:
            numbers.append(_occluder(spheres[members[0]]))
    return Packed(np.concatenate([*numbers, *(_occluder(o) for o in planar)]),
                  [len(tree), len(planar), *counts_below(tree), *(o.round for o in planar)])


def all_occluders(shapes: Iterable[Shape], opening: float) -> Packed:
    """Parameters of `shadows` for spheres and planar shapes, still and moving; lights are left out.

    opening: seconds at TIME 0. No parameters where nothing hides light.
    """
    shapes = [o for o in shapes if not o.material.shines]
    return after(occluder_parameters(*by_family(o for o in shapes if not o.moves)),
                 moving_groups([o for o in shapes if o.moves], opening, occluder_parameters))


def _lamp(shape: Any) -> Packed:
    """A lamp as `lamp_rays` reads it; a mesh as the sphere of its silhouette, for pictures without shadows."""
    if shape.family == "planar":
        centre, a, b, normal = shape.frame
        return Packed(pack(LAMP, {MIDDLE: centre, HALF_A: a, HALF_B: b, FACING: normal, AREA: shape.area}),
                      [DISK_LAMP if shape.round else RECTANGLE_LAMP])
    radius2 = shape.radius**2 if shape.family == "sphere" else shape.area / math.pi
    return Packed(pack(LAMP, {MIDDLE: shape.centre, LAMP_RADIUS2: radius2}), [SPHERE_LAMP])


def lamp_parameters(lamp: Shape, opening: float) -> Packed:
    """Parameters of `lamp_rays`. opening: seconds at TIME 0, if it moves."""
    lamp = displaced(lamp, opening)
    motion = [Packed(motion_parameters([lamp], opening))] if lamp.moves else []
    return join(_lamp(lamp), *motion)


def point_parameters(shape: Shape) -> np.ndarray:
    """A lamp as `open_light` reads it: a point at its middle."""
    lamp = _lamp(shape).parameters
    return pack(POINT, {POINT_PLACE: lamp[MIDDLE:MIDDLE + 3],
                        POINT_AREA: lamp[FACING:FACING + 3] * lamp[AREA] / math.pi,
                        POINT_RADIUS2: lamp[LAMP_RADIUS2], POINT_LIGHT: shape.material.colour})


def sun_parameters(sun: Sun) -> np.ndarray:
    """Parameters of `sun_rays`."""
    right, up = across(sun.direction)
    size = math.tan(sun.angular_radius)
    return pack(SUN, {DIRECTION: unit(sun.direction), RIGHT: right * size, UP: up * size})


@stage
def shadow(lanes, p, ints):
    """Multiply A7, the light at A0 A1 A2 from the direction A3 A4 A5 at the distance A6, by what the occluders pass.

    p, ints: occluder_parameters.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    hx, hy, hz, wx, wy, wz, far, light = (row[A0], row[A1], row[A2], row[A3], row[A4], row[A5], row[A6], row[A7])
    depth = row[DEPTH]
    if p.size == 0:
        return
    box = shadow_bounds(lanes)

    # Spheres
    count = ints[BALLS]
    end, s, k, bounds = BALL * count, 0, OCCLUDER_INTEGERS, row[BEAM]
    crowded = count > 2 * CROWD
    if crowded:
        shadow_beam(lanes)
    while s < end:
        (cx, cy, cz), r2, clear, below = vector(p, s + CENTRE), p[s + RADIUS2], p[s + TRANSMITTED], ints[k]
        radius = math.sqrt(r2)
        missed = boxes_disjoint(box, cx, cy, cz, radius, radius, radius)
        if crowded:
            missed = missed or beam_misses(bounds, cx, cy, cz, radius, radius, radius)
        s, k = s + BALL, k + 1
        if missed:
            s, k = s + below * BALL, k + below
            continue
        if below > 0:
            continue
        for i in range(B):
            along, miss2 = closest_approach(cx - hx[i], cy - hy[i], cz - hz[i], wx[i], wy[i], wz[i])
            room = r2 - miss2
            inner = room / r2
            in_front = (room > real(0)) & (along > real(0)) & (along < far[i])
            # ∫ 4 (1 − ρ²)³ dρ² = 1: the flux over the ball's disk stays `clear`
            light[i] *= clear * real(4) * inner * inner * inner if in_front else real(1)

    # Planar shapes
    for j in range(ints[SHADES]):
        s = end + SHADE * j
        (cx, cy, cz), (ux, uy, uz) = vector(p, s + CENTRE), vector(p, s + NORMAL)
        (ax, ay, az), (bx, by, bz) = vector(p, s + AXIS_U), vector(p, s + AXIS_V)
        disk, clear = real(ints[OCCLUDER_INTEGERS + count + j]), p[s + PANE_TRANSMITTED]
        wide_x, wide_y, wide_z = vector(p, s + HALF_WIDTHS)
        if boxes_disjoint(box, cx, cy, cz, wide_x, wide_y, wide_z) or plane_misses(box, cx, cy, cz, ux, uy, uz):
            continue
        for i in range(B):
            ox, oy, oz = hx[i] - cx, hy[i] - cy, hz[i] - cz
            off = ox * ux + oy * uy + oz * uz
            # A point of the shape itself is off it by its rounding, whatever the angle
            blur = real(4e-6) * rounded_length(hx[i], hy[i], hz[i], depth[i])
            t, qa, qb = plane_point(ox, oy, oz, wx[i], wy[i], wz[i], ux, uy, uz, ax, ay, az, bx, by, bz)
            in_front = inside_edge(real, qa, qb, disk) & (t > real(0)) & (t < far[i]) & (abs(off) > blur)
            light[i] *= clear if in_front else real(1)


@stage
def shadow_moving(lanes, p, ints):
    """Multiply A7 by what moving occluders pass.  p, ints: groups of occluder_parameters."""
    if p.size == 0:
        return
    real = lanes.dtype.type
    box, (early, late) = shadow_bounds(lanes), time_bounds(lanes)
    keep_world(lanes, A0, A3, False)
    s, k, current = 0, 0, -1
    while s < p.size:
        motion, ball_integers, which = s, k + GROUP, ints[k + WHICH]
        s, k = s + ints[k + LENGTH], k + ints[k + COUNT]

        # Skip a group that lies beside all shadow rays
        cx, cy, cz, wide, wx, wy, wz = swept_bounds(real, p, motion, early, late)
        if boxes_disjoint(box, cx, cy, cz, wide + abs(wx), wide + abs(wy), wide + abs(wz)):
            continue

        # Transform the shadow rays to the frame where it rests
        if which != current:
            enter_rest_frame(lanes, motion_of(p, motion), A0, A3, False)
            current = which
        shadow(lanes, p[motion + MOTION:s], ints[ball_integers:k])
    leave_rest_frame(lanes, A0, A3, False)


@stage
def shadows(lanes, p, ints, key):
    """Multiply A7 by what spheres and planar shapes pass, still and moving.  p, ints: all_occluders."""
    still, ints = ints[0], ints[1:]
    shadow(lanes, p[:still], ints)
    shadow_moving(lanes, p[still:], ints[OCCLUDER_INTEGERS + ints[BALLS] + ints[SHADES]:])


@stage
def add_lit(lanes, p, ints, key):
    """Add the light A7, of the colour p (3), to what the path gathers."""
    row = rows(lanes)
    red, green, blue, sr, sg, sb, light = row[RED], row[GREEN], row[BLUE], row[SR], row[SG], row[SB], row[A7]
    r, g, b = vector(p, 0)
    for i in range(B):
        sr[i] += red[i] * light[i] * r
        sg[i] += green[i] * light[i] * g
        sb[i] += blue[i] * light[i] * b


@stage
def disk_points(lanes):
    """A6, A7: V0, V1 of the unit square mapped to the unit disk (concentric map: equal areas, neighbours kept)."""
    real = lanes.dtype.type
    row = rows(lanes)
    v0, v1, p, q = row[V0], row[V1], row[A6], row[A7]
    for i in range(B):
        p[i], q[i] = concentric_disk(real, v0[i], v1[i])


@stage
def sun_rays(lanes, p, ints, key):
    """Sample a point of the sun: A0 … A7 as `shadow` reads them.  p: sun_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    nx, ny, nz, wx, wy, wz, far, light = row[NX], row[NY], row[NZ], row[A3], row[A4], row[A5], row[A6], row[A7]
    (cx, cy, cz), (ax, ay, az), (bx, by, bz) = vector(p, DIRECTION), vector(p, RIGHT), vector(p, UP)
    met_points(lanes)
    disk_points(lanes)
    for i in range(B):
        a, b = far[i], light[i]
        qx, qy, qz = cx + a * ax + b * bx, cy + a * ay + b * by, cz + a * az + b * bz
        size = real(1) / math.sqrt(qx * qx + qy * qy + qz * qz)
        qx, qy, qz = qx * size, qy * size, qz * size
        slant = nx[i] * qx + ny[i] * qy + nz[i] * qz
        wx[i], wy[i], wz[i], far[i] = qx, qy, qz, real(math.inf)
        light[i] = slant if slant > real(0) else real(0)


@stage
def lamp_rays(lanes, p, ints, key):
    """Sample a point of a lamp, where it is at the TIME of each lane: A0 … A7 as `shadow` reads them.

    p, ints: lamp_parameters; a MOTION at their end where the lamp moves.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    v0, v1, a, b, moves = row[V0], row[V1], row[A6], row[A7], p.size > LAMP

    # Find the lit points, in the frame where a moving lamp rests
    if moves:
        keep_world(lanes, X, L, True)
        enter_rest_frame(lanes, motion_of(p, LAMP), X, L, True)
    met_points(lanes)

    # Map V0, V1 to the square or the disk, and sample the lamp
    if ints[0] == RECTANGLE_LAMP:
        for i in range(B):
            a[i], b[i] = real(2) * v0[i] - real(1), real(2) * v1[i] - real(1)
    else:
        disk_points(lanes)
    if ints[0] == SPHERE_LAMP:
        _sample_sphere(lanes, p)
    else:
        _sample_planar(lanes, p)

    # Cast the shadow rays in the world
    if moves:
        leave_rest_frame(lanes, X, L, True)
        time, motion = row[TIME], motion_of(p, LAMP)
        qx, qy, qz, wx, wy, wz = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
        for i in range(B):
            qx[i], qy[i], qz[i], wx[i], wy[i], wz[i] = to_world_frame(real, motion, time[i], qx[i], qy[i], qz[i],
                                                                      wx[i], wy[i], wz[i])


@njit(inline="always")
def sphere_point(real, a, b, qx, qy, qz, r2):
    """A direction to a sphere, uniform over its solid angle 2π (1 − cos θm), sin θm = r / d; a distance; 1 − cos θm.

    a, b: a point of the unit disk; q: the way to the centre, mm. The distance is that of the edge of the sphere.
    """
    d2 = qx * qx + qy * qy + qz * qz
    size = real(1) / math.sqrt(d2)
    qx, qy, qz = qx * size, qy * size, qz * size
    sine2 = r2 / d2
    sine2 = sine2 if sine2 < real(1) else real(1)
    cap = sine2 / (real(1) + math.sqrt(real(1) - sine2))
    low = (a * a + b * b) * cap
    out = math.sqrt(cap * (real(2) - low))
    # Two axes across q, without a branch (Duff et al. 2017)
    sign = real(1) if qz >= real(0) else real(-1)
    e = real(-1) / (sign + qz)
    f = qx * qy * e
    a, b, c = a * out, b * out, real(1) - low
    return (c * qx + a * (real(1) + sign * qx * qx * e) + b * f, c * qy + a * sign * f + b * (sign + qy * qy * e),
            c * qz - a * sign * qx - b * qy, math.sqrt(d2 - r2 if d2 > r2 else real(0)), cap)


@stage
def _sample_sphere(lanes, p):
    """Sample the solid angle 2π (1 − cos θm), sin θm = r / d, of a sphere: the light is L cos θ · 2 (1 − cos θm).

    A6, A7: a point of the unit disk.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    nx, ny, nz, hx, hy, hz = row[NX], row[NY], row[NZ], row[A0], row[A1], row[A2]
    wx, wy, wz, far, light = row[A3], row[A4], row[A5], row[A6], row[A7]
    (cx, cy, cz), r2 = vector(p, MIDDLE), p[LAMP_RADIUS2]
    for i in range(B):
        px, py, pz, reach, cap = sphere_point(real, far[i], light[i], cx - hx[i], cy - hy[i], cz - hz[i], r2)
        slant = nx[i] * px + ny[i] * py + nz[i] * pz
        wx[i], wy[i], wz[i], far[i] = px, py, pz, reach
        light[i] = real(2) * cap * (slant if slant > real(0) else real(0))


@stage
def _sample_planar(lanes, p):
    """Sample the area A of a planar lamp, which shines to both sides: the light is L cos θ cos θ′ A / (π d²).

    A6, A7: a point of the square or the unit disk.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    nx, ny, nz, hx, hy, hz = row[NX], row[NY], row[NZ], row[A0], row[A1], row[A2]
    wx, wy, wz, far, light = row[A3], row[A4], row[A5], row[A6], row[A7]
    (cx, cy, cz), (ax, ay, az), (bx, by, bz) = vector(p, MIDDLE), vector(p, HALF_A), vector(p, HALF_B)
    (ux, uy, uz), flow = vector(p, FACING), p[AREA] * real(1 / math.pi)
    for i in range(B):
        a, b = far[i], light[i]
        qx, qy, qz = cx + a * ax + b * bx - hx[i], cy + a * ay + b * by - hy[i], cz + a * az + b * bz - hz[i]
        d2 = qx * qx + qy * qy + qz * qz
        size = real(1) / math.sqrt(d2)
        qx, qy, qz = qx * size, qy * size, qz * size
        slant = nx[i] * qx + ny[i] * qy + nz[i] * qz
        facing = abs(ux * qx + uy * qy + uz * qz)
        arriving = slant * facing * flow / d2
        wx[i], wy[i], wz[i], far[i] = qx, qy, qz, d2 * size
        light[i] = arriving if arriving > real(0) else real(0)
