"""Pictures on shapes, read where they lie: on spheres, on the floor, and large ones on planar shapes.

A stage for each shape, which only a scene with such a shape has.
"""

import math
from typing import Any

import numpy as np

from lensbench.core.kernels.block import (
    A0, A1, A2, A4, A5, A6, A7, A8, BLUE, DEPTH, EMITS, FINISH, GREEN, NX, NY, NZ, PIXEL_SIDE, PIXEL_SPREAD, RED, B, L,
    M, N, Step, X, Y, Z, offsets, pack, rows, stage, vector
)
from lensbench.core.scenery.intersect.planar import (
    COLOUR as PLANAR_COLOUR, PLANAR, fields_of, footprint, intersect, paint_image, record
)
from lensbench.core.scenery.intersect.sky import (
    AXIS_A, AXIS_B, COLOUR as FLOOR_COLOUR, FLOOR, SHIFT, floor_parameters, half_turn, meet_floor
)
from lensbench.core.scenery.intersect.spheres import closest_approach
from lensbench.core.scenery.intersect.texture import AROUND, REPEATED, footprint_stretch, look_up_texture, texture
from lensbench.core.scenery.objects.surroundings import Floor

LARGE = 1 << 20         # texels of an image of a planar shape that is read where it lies

# BALL_GREATEST: that of the `Texture`; so is the last number of planar shapes and of the floor
CENTRE, RADIUS2, RADIUS, COLOUR, EMISSION, OWN_FINISH, BALL_GREATEST, BALL = offsets(3, 1, 1, 3, 1, 1, 1)


def is_large(shape: Any) -> bool:
    """Whether a shape has an image that its own stage shows: of a sphere, or a large one."""
    pattern = shape.material.pattern
    if pattern is None or pattern.image is None or shape.moves:
        return False
    large = pattern.image.width * pattern.image.height > LARGE
    return shape.family == "sphere" or (shape.family == "planar" and large)


def pictured_step(shape: Any, emission: float) -> Step:
    """The stage of a still shape with an image. emission: value of the row EMITS."""
    picture = texture(shape.material.pattern.image)
    if shape.family == "planar":
        return Step(pictured_planar, [*pack(PLANAR, fields_of(shape, emission)), picture.greatest],
                    [shape.round, *picture.integers()], kept=picture)
    material = shape.material
    return Step(pictured_sphere,
                pack(BALL, {CENTRE: shape.centre, RADIUS2: shape.radius**2, RADIUS: shape.radius,
                            COLOUR: material.colour, EMISSION: emission, OWN_FINISH: material.finish(shape.radius),
                            BALL_GREATEST: picture.greatest}), picture.integers(AROUND), kept=picture)


def pictured_floor_step(floor: Floor) -> Step:
    """The stage of a floor with an image."""
    assert floor.image is not None
    picture, numbers = texture(floor.image), floor_parameters(floor)
    numbers[AXIS_B:AXIS_B + 3] *= -floor.image.width / floor.image.height       # its rows run against the axis
    return Step(pictured_floor, [*numbers, picture.greatest], picture.integers(REPEATED), kept=picture)


@stage
def pictured_planar(lanes, p, ints, key):
    """Intersect rays with a planar shape that has a large image.  p, ints: pictured_step."""
    if intersect(lanes, p, ints[0]) == 0:
        return
    record(lanes, p)
    footprint(lanes, p)
    look_up_texture(lanes, p[PLANAR], ints[1:])
    paint_image(lanes, p[PLANAR_COLOUR:])


@stage
def pictured_sphere(lanes, p, ints, key):
    """Intersect rays with a sphere that has an image around it.  p, ints: pictured_step."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    depth, emits, finish, nx, ny, nz = row[DEPTH], row[EMITS], row[FINISH], row[NX], row[NY], row[NZ]
    met, u, v, wide_u, wide_v = row[A0], row[A1], row[A2], row[A7], row[A8]
    side, spread = row[PIXEL_SIDE], row[PIXEL_SPREAD]
    (cx, cy, cz), r2 = vector(p, CENTRE), p[RADIUS2]
    emission, own_finish, scale = p[EMISSION], p[OWN_FINISH], real(1) / p[RADIUS]

    # Find the front of the sphere
    count = np.int32(0)
    for i in range(B):
        along, miss2 = closest_approach(cx - x[i], cy - y[i], cz - z[i], dx[i], dy[i], dz[i])
        t = along - math.sqrt(r2 - miss2)
        hit = (t > real(0)) & (t < depth[i])
        met[i] = t if hit else real(0)
        count = np.int32(count + np.int32(hit))
    if count == 0:
        return

    # Record the surface, its place in the picture and the footprint there
    for i in range(B):
        t = met[i]
        hit = t > real(0)
        qx, qy, qz = (x[i] + t * dx[i] - cx) * scale, (y[i] + t * dy[i] - cy) * scale, (z[i] + t * dz[i] - cz) * scale
        level = math.sqrt(qx * qx + qz * qz)
        turn = half_turn(real, abs(qx), qz)
        u[i] = turn if qx > real(0) else -turn
        v[i] = real(1) - real(2) * half_turn(real, level, qy)
        wide = abs(side[i] + t * spread[i]) * scale * real(1 / math.pi)
        wide_u[i], wide_v[i] = wide / (level + real(1e-6)), real(2) * wide
        depth[i] = t if hit else depth[i]
        nx[i], ny[i], nz[i] = qx if hit else nx[i], qy if hit else ny[i], qz if hit else nz[i]
        emits[i] = emission if hit else emits[i]
        finish[i] = own_finish if hit else finish[i]
    look_up_texture(lanes, p[BALL_GREATEST], ints)
    paint_image(lanes, p[COLOUR:])


@stage
def pictured_floor(lanes, p, ints, key):
    """Intersect rays with a floor that has an image, repeated.  p, ints: pictured_floor_step."""
    if meet_floor(lanes, p) == 0:
        return
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz = row[X], row[Y], row[Z], row[L], row[M], row[N]
    met, u, v, wide_u, wide_v = row[A0], row[A1], row[A2], row[A7], row[A8]
    red, green, blue, side, spread = row[RED], row[GREEN], row[BLUE], row[PIXEL_SIDE], row[PIXEL_SPREAD]
    (ax, ay, az), (bx, by, bz), a0, b0 = vector(p, AXIS_A), vector(p, AXIS_B), p[SHIFT], p[SHIFT + 1]
    per_a, per_b = math.sqrt(ax * ax + ay * ay + az * az), math.sqrt(bx * bx + by * by + bz * bz)

    # Find the place in the picture and the footprint there; A1 holds the steepness up to here
    for i in range(B):
        t, steep = met[i], u[i]
        hx, hy, hz = x[i] + t * dx[i], y[i] + t * dy[i], z[i] + t * dz[i]
        a, b = a0 + ax * hx + ay * hy + az * hz, b0 + bx * hx + by * hy + bz * hz
        u[i], v[i] = real(2) * (a - np.floor(a)) - real(1), real(2) * (b - np.floor(b)) - real(1)
        wide = real(2) * abs(side[i] + t * spread[i])
        wide_u[i] = wide * per_a * footprint_stretch(real, (ax * dx[i] + ay * dy[i] + az * dz[i]) / per_a, steep)
        wide_v[i] = wide * per_b * footprint_stretch(real, (bx * dx[i] + by * dy[i] + bz * dz[i]) / per_b, steep)

    # A footprint of half a picture or more sees the mean of its colours
    er, eg, eb = row[A4], row[A5], row[A6]
    r, g, b = vector(p, FLOOR_COLOUR)
    for i in range(B):
        widest = wide_u[i] if wide_u[i] > wide_v[i] else wide_v[i]
        fade = real(2) * widest - real(1)
        fade = fade if fade > real(0) else real(0)
        fade = fade if fade < real(1) else real(1)
        met[i] = met[i] if met[i] == real(0) else fade + real(1e-6)
    look_up_texture(lanes, p[FLOOR], ints)
    for i in range(B):
        hit, fade = met[i] > real(0), met[i]
        fade = fade if fade < real(1) else real(1)
        red[i] = er[i] + fade * (r - er[i]) if hit else red[i]
        green[i] = eg[i] + fade * (g - eg[i]) if hit else green[i]
        blue[i] = eb[i] + fade * (b - eb[i]) if hit else blue[i]
