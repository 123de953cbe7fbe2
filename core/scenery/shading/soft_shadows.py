"""Sun and lamps: for each sample one point of the light, chosen by V0 and V1, and one shadow ray to it.

Lights cast no shadow themselves. The shadow of a glass ball is bright in its middle: it transmits what its two
surfaces do, concentrated towards the axis, an approximation without a second ray (its flux is right, and its place
where the ball touches a surface).
"""

import math

import numpy as np

from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, A7, BEAM, BLUE, DEPTH, GREEN, NX, NY, NZ, RED, SB, SG, SR, V0, V1, B, L, M, N, Packed,
    X, Y, Z, offsets, pack, rows, stage, vector
)
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.sampling import concentric_disk
from lensbench.core.scenery.intersect.block_bounds import (
    beam_misses, boxes_disjoint, plane_misses, shadow_beam, shadow_bounds
)
from lensbench.core.scenery.intersect.spheres import (
    CROWD, bounding_sphere, closest_approach, counts_below, inside_edge, plane_point, sphere_tree
)
from lensbench.core.scenery.shading.bounces import rounded_length
from lensbench.core.scenery.shading.illumination import (
    POINT, POINT_AREA, POINT_LIGHT, POINT_PLACE, POINT_RADIUS2, count_lit
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

# The sun, before its occluders: RIGHT, UP: unit axes across its direction times the tangent of its angular radius
DIRECTION, RIGHT, UP, IRRADIANCE, SUN = offsets(3, 3, 3, 3)
# A lamp, before its occluders: half-axes, normal and area of a planar one; radius² of a sphere. Integer: its kind
MIDDLE, HALF_A, HALF_B, FACING, AREA, LAMP_RADIUS2, RADIANCE, LAMP = offsets(3, 3, 3, 3, 1, 1, 3)
RECTANGLE_LAMP, DISK_LAMP, SPHERE_LAMP = range(3)


def sphere_occluder(sphere) -> np.ndarray:
    """A sphere as `shadow` reads it."""
    return pack(BALL, {CENTRE: sphere.centre, RADIUS2: sphere.radius**2,
                       TRANSMITTED: GLASS_BALL if sphere.material.kind == "glass" else 0.0})


def planar_occluder(shape) -> np.ndarray:
    """A planar shape as `shadow` reads it."""
    centre, a, b, normal = shape.frame
    return pack(SHADE, {CENTRE: centre, NORMAL: normal, AXIS_U: a / (a @ a), AXIS_V: b / (b @ b),
                        PANE_TRANSMITTED: 1.0 if shape.material.kind == "glass" else 0.0,
                        HALF_WIDTHS: abs(a) + abs(b)})


def occluder_parameters(spheres, planar) -> Packed:
    """Parameters of `shadow`: a tree of the spheres, then the planar shapes; lights are left out."""
    spheres, planar = ([o for o in shapes if not o.material.shines] for shapes in (spheres, planar))
    centres, radii = np.array([o.centre for o in spheres]).reshape(-1, 3), np.array([o.radius for o in spheres])
    tree, numbers = sphere_tree(centres), [np.zeros(0)]
    for members, below in tree:
        if below:
            middle, reach = bounding_sphere(centres[members], radii[members])
            numbers.append(pack(BALL, {CENTRE: middle, RADIUS2: reach**2}))
        else:
            numbers.append(spheres[members[0]].occluder_numbers())
    return Packed(np.concatenate([*numbers, *(o.occluder_numbers() for o in planar)]),
                  [len(tree), len(planar), *counts_below(tree), *(o.round for o in planar)])


@njit(inline="always")
def occluder_integers(ints):
    """How many integers `shadow` reads."""
    return OCCLUDER_INTEGERS + ints[BALLS] + ints[SHADES]


def sphere_lamp(sphere) -> Packed:
    """A sphere as `lamp` reads it, without occluders."""
    return Packed(pack(LAMP, {MIDDLE: sphere.centre, LAMP_RADIUS2: sphere.radius**2,
                              RADIANCE: sphere.material.colour}), [SPHERE_LAMP])


def planar_lamp(shape) -> Packed:
    """A planar shape as `lamp` reads it, without occluders."""
    centre, a, b, normal = shape.frame
    return Packed(pack(LAMP, {MIDDLE: centre, HALF_A: a, HALF_B: b, FACING: normal, AREA: shape.area,
                              RADIANCE: shape.material.colour}), [DISK_LAMP if shape.round else RECTANGLE_LAMP])


def point_parameters(shape) -> np.ndarray:
    """A lamp as `open_light` reads it: a point at its middle."""
    lamp = shape.lamp_parameters().parameters
    return pack(POINT, {POINT_PLACE: lamp[MIDDLE:MIDDLE + 3],
                        POINT_AREA: lamp[FACING:FACING + 3] * lamp[AREA] / math.pi,
                        POINT_RADIUS2: lamp[LAMP_RADIUS2], POINT_LIGHT: lamp[RADIANCE:]})


def sun_parameters(sun) -> np.ndarray:
    """A `Sun` as the stage `sun` reads it, without occluders."""
    right, up = across(sun.direction)
    size = math.tan(sun.angular_radius)
    return pack(SUN, {DIRECTION: unit(sun.direction), RIGHT: right * size, UP: up * size, IRRADIANCE: sun.colour})


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
    end, s, k, seen = BALL * count, 0, OCCLUDER_INTEGERS, row[BEAM]
    crowded = count > 2 * CROWD
    if crowded:
        shadow_beam(lanes)
    while s < end:
        (cx, cy, cz), r2, clear, below = vector(p, s + CENTRE), p[s + RADIUS2], p[s + TRANSMITTED], ints[k]
        radius = math.sqrt(r2)
        missed = boxes_disjoint(box, cx, cy, cz, radius, radius, radius)
        if crowded:
            missed = missed or beam_misses(seen, cx, cy, cz, radius, radius, radius)
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
            held = (room > real(0)) & (along > real(0)) & (along < far[i])
            # ∫ 4 (1 − ρ²)³ dρ² = 1: the flux over the ball's disk stays `clear`
            light[i] *= clear * real(4) * inner * inner * inner if held else real(1)

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
            held = inside_edge(real, qa, qb, disk) & (t > real(0)) & (t < far[i]) & (abs(off) > blur)
            light[i] *= clear if held else real(1)


@stage
def disk_points(lanes):
    """A6, A7: V0, V1 of the unit square mapped to the unit disk (concentric map: equal areas, neighbours kept)."""
    real = lanes.dtype.type
    row = rows(lanes)
    v0, v1, p, q = row[V0], row[V1], row[A6], row[A7]
    for i in range(B):
        p[i], q[i] = concentric_disk(real, v0[i], v1[i])


@stage
def sun(lanes, p, ints, key):
    """Add the light of the sun.  p, ints: sun_parameters, occluder_parameters."""
    if count_lit(lanes) == 0:
        return
    sample_sun(lanes, p)
    shadow(lanes, p[SUN:], ints)
    add_light(lanes, p[IRRADIANCE:])


@stage
def lamp(lanes, p, ints, key):
    """Add the light of one lamp.  p, ints: sphere_lamp or planar_lamp, then occluder_parameters."""
    if count_lit(lanes) == 0:
        return
    sample_lamp(lanes, p, ints[0])
    shadow(lanes, p[LAMP:], ints[1:])
    add_light(lanes, p[RADIANCE:])


@stage
def add_light(lanes, colour):
    """Add the light A7, of a colour (3), to what the path gathers."""
    row = rows(lanes)
    red, green, blue, sr, sg, sb, light = row[RED], row[GREEN], row[BLUE], row[SR], row[SG], row[SB], row[A7]
    r, g, b = vector(colour, 0)
    for i in range(B):
        sr[i] += red[i] * light[i] * r
        sg[i] += green[i] * light[i] * g
        sb[i] += blue[i] * light[i] * b


@stage
def sample_sun(lanes, p):
    """Sample a point of the sun: A0 … A7 as `shadow` reads them.  p: sun_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, nx, ny, nz, hx, hy, hz = row[DEPTH], row[NX], row[NY], row[NZ], row[A0], row[A1], row[A2]
    wx, wy, wz, far, light = row[A3], row[A4], row[A5], row[A6], row[A7]
    (cx, cy, cz), (ax, ay, az), (bx, by, bz) = vector(p, DIRECTION), vector(p, RIGHT), vector(p, UP)
    disk_points(lanes)
    for i in range(B):
        t, a, b = depth[i], far[i], light[i]
        hx[i], hy[i], hz[i] = x[i] + t * dx[i], y[i] + t * dy[i], z[i] + t * dz[i]
        qx, qy, qz = cx + a * ax + b * bx, cy + a * ay + b * by, cz + a * az + b * bz
        size = real(1) / math.sqrt(qx * qx + qy * qy + qz * qz)
        qx, qy, qz = qx * size, qy * size, qz * size
        slant = nx[i] * qx + ny[i] * qy + nz[i] * qz
        wx[i], wy[i], wz[i], far[i] = qx, qy, qz, real(math.inf)
        light[i] = slant if slant > real(0) else real(0)


@stage
def sample_lamp(lanes, p, kind):
    """Sample a point of a lamp: A0 … A7 as `shadow` reads them.  p: sphere_lamp or planar_lamp."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, hx, hy, hz, v0, v1, a, b = row[DEPTH], row[A0], row[A1], row[A2], row[V0], row[V1], row[A6], row[A7]

    # Map V0, V1 to the square or the disk
    if kind == RECTANGLE_LAMP:
        for i in range(B):
            a[i], b[i] = real(2) * v0[i] - real(1), real(2) * v1[i] - real(1)
    else:
        disk_points(lanes)

    # Find the lit points, and the point of the lamp that each of them sees
    for i in range(B):
        t = depth[i]
        hx[i], hy[i], hz[i] = x[i] + t * dx[i], y[i] + t * dy[i], z[i] + t * dz[i]
    if kind == SPHERE_LAMP:
        _sample_sphere(lanes, p)
    else:
        _sample_planar(lanes, p)


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
