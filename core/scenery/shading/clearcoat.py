"""Smooth clear coats: what they reflect of the lights, the sky and the floor, without noise.

Other shapes are not reflected. A coat of gloss 1, and glass, reflects the lights sharply, each lane those of its TIME;
a lower gloss spreads them over facets (`rough_clearcoat`).
"""

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, BLUE, DEPTH, FINISH, GREEN, NX, NY, NZ, PIXEL_SIDE, PIXEL_SPREAD, RED, SB,
    SG, SR, TB, TG, TR, B, L, M, N, Packed, Step, join, offsets, pack, rows, stage, vector
)
from lensbench.core.scenery.intersect import sky as ground
from lensbench.core.scenery.intersect.moving_objects import (
    COUNT, GROUP, LENGTH, MOTION, after, enter_rest_frame, keep_world, motion_of, moving_groups
)
from lensbench.core.scenery.intersect.sky import (
    CHORD2, DIRECTION, FAR, IMAGE_SKY, RADIANCE, SKY, SKY_INTEGERS, SUN_DISK, gradient, image_sky_parameters,
    look_up_sky, sky_radiance, tile_side
)
from lensbench.core.scenery.intersect.spheres import closest_approach, inside_edge, plane_point
from lensbench.core.scenery.objects.shape import Shape, by_family
from lensbench.core.scenery.objects.surroundings import ImageSky
from lensbench.core.scenery.shading.illumination import F0, met_points, schlick_edge
from lensbench.core.scenery.surface_codes import GLASS, is_glass, is_metal, is_sharp_coat, is_specular

# SURROUND: the numbers of a sky of three colours, PICTURE: of a sky's picture, FLOOR: of the floor, FLOOR_LIGHT:
# irradiance / π on it, SUN: of the sun's disk; then the lights
SURROUND, PICTURE, FLOOR, FLOOR_LIGHT, SUN, LIGHTS = offsets(SKY, IMAGE_SKY, ground.FLOOR, 3, SUN_DISK)
# Integers: after STILL those of the sky's picture; then of the lights PLANAR_LIGHTS: how many; for each of them follows
# whether it is a disk, 1, or a rectangle, 0. STILL: how many numbers belong to what is at rest
STILL, IS_LAST, HAS_FLOOR, HAS_SUN, HAS_PICTURE, PICTURE_PLACE = range(6)
PLANAR_LIGHTS = PICTURE_PLACE + SKY_INTEGERS
CENTRE, NORMAL, AXIS_U, AXIS_V, COLOUR, PANEL = offsets(3, 3, 3, 3, 3)
_, RADIUS2, BULB_COLOUR, BULB = offsets(3, 1, 3)


def clearcoat_step(sky: np.ndarray, picture: ImageSky | None, floor: np.ndarray | None, floor_light: np.ndarray,
                   sun: np.ndarray | None, lights: Iterable[Shape], opening: float, last: bool) -> Step:
    """The stage `clearcoat`.

    sky: sky_parameters, unless a picture shows the sky; floor: floor_parameters or None, with floor_light, the
    irradiance / π on it (3); sun: sun_disk_parameters or None; opening: seconds at TIME 0; last: the path ends here,
    and metal reflects as a coat does.
    """
    shown = Packed(np.zeros(1), [0] * SKY_INTEGERS) if picture is None else image_sky_parameters(picture)
    numbers = pack(LIGHTS, {SURROUND: sky, PICTURE: shown.parameters, FLOOR: np.zeros(1) if floor is None else floor,
                            FLOOR_LIGHT: floor_light, SUN: np.zeros(1) if sun is None else sun})
    fixed = Packed(numbers, [last, floor is not None, sun is not None, picture is not None])
    shown, lights = shown._replace(parameters=np.zeros(0)), list(lights)
    still = reflected_parameters(*by_family(o for o in lights if not o.moves))
    moved = moving_groups([o for o in lights if o.moves], opening, reflected_parameters)
    kept = () if picture is None else (picture.image.values,)
    return Step(clearcoat, *after(join(fixed, shown, still), moved), kept=kept)


def reflected_parameters(spheres: Sequence[Any], planar: Sequence[Any]) -> Packed:
    """Parameters of `sharp_lights`: PANEL numbers for each planar light, then BULB for each sphere.

    Integers: the number of planar lights, then for each of them 1 for a disk and 0 for a rectangle.
    """
    numbers = [np.zeros(0)]
    for o in planar:
        centre, a, b, normal = o.frame
        numbers.append(pack(PANEL, {CENTRE: centre, NORMAL: normal, AXIS_U: a / (a @ a), AXIS_V: b / (b @ b),
                                    COLOUR: o.material.colour}))
    numbers += [pack(BULB, {CENTRE: o.centre, RADIUS2: o.radius**2, BULB_COLOUR: o.material.colour}) for o in spheres]
    return Packed(np.concatenate(numbers), [len(planar), *(o.round for o in planar)])


@stage
def clearcoat(lanes, p, ints, key):
    """Add what sharp coats and glass reflect; an albedo under a coat gets what the coat transmits.

    p, ints: clearcoat_step.
    """
    if sharp_open(lanes, p, ints) == 0:
        return
    s, k = ints[STILL], PLANAR_LIGHTS + 1 + ints[PLANAR_LIGHTS]
    sharp_lights(lanes, p[LIGHTS:s], ints[PLANAR_LIGHTS:])
    if s < p.size:
        keep_world(lanes, A0, A3, False)
    while s < p.size:
        end = s + ints[k + LENGTH]
        enter_rest_frame(lanes, motion_of(p, s), A0, A3, False)
        sharp_lights(lanes, p[s + MOTION:end], ints[k + GROUP:])
        s, k = end, k + ints[k + COUNT]
    sharp_close(lanes, ints[IS_LAST])


@stage
def sharp_open(lanes, p, ints):
    """Reflect the rays, A0 … A5, and find what they see of sky, floor and sun, A6 A7 A8, at the distance A9.

    The distance of the sky is infinite, that of the sun FAR.

    Returns how many lanes of the block reflect anything; nothing is done if none does.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, finish, nx, ny, nz = row[L], row[M], row[N], row[FINISH], row[NX], row[NY], row[NZ]
    wx, wy, wz, r, g, b, near = row[A3], row[A4], row[A5], row[A6], row[A7], row[A8], row[A9]
    last = ints[IS_LAST] != 0
    count = np.int32(0)
    for i in range(B):
        kind = finish[i]
        count = np.int32(count + np.int32(is_sharp_coat(real, kind) | is_glass(real, kind) |
                                        (last & is_specular(real, kind))))
    if count == 0:
        return count

    # Reflect the ray, and look up the sky in its direction
    met_points(lanes)
    for i in range(B):
        c = real(-2) * (dx[i] * nx[i] + dy[i] * ny[i] + dz[i] * nz[i])
        wx[i], wy[i], wz[i] = dx[i] + c * nx[i], dy[i] + c * ny[i], dz[i] + c * nz[i]
        near[i] = real(math.inf)
    if ints[HAS_PICTURE]:
        look_up_sky(lanes, p[PICTURE:], ints[PICTURE_PLACE:], wx, wy, wz, r, g, b)
    else:
        colours = gradient(p, SURROUND)
        for i in range(B):
            r[i], g[i], b[i] = sky_radiance(real, colours, wx[i], wy[i], wz[i])
    if ints[HAS_FLOOR]:
        _reflect_floor(lanes, p[FLOOR:], p[FLOOR_LIGHT:])

    # Show the sun where nothing hides it
    if ints[HAS_SUN]:
        (ux, uy, uz), chord2, (er, eg, eb) = vector(p, SUN + DIRECTION), p[SUN + CHORD2], vector(p, SUN + RADIANCE)
        for i in range(B):
            ax, ay, az = wx[i] - ux, wy[i] - uy, wz[i] - uz
            hit = (ax * ax + ay * ay + az * az < chord2) & (near[i] == real(math.inf))
            near[i] = real(FAR) if hit else near[i]
            r[i] = er if hit else r[i]
            g[i] = eg if hit else g[i]
            b[i] = eb if hit else b[i]
    return count


@stage
def _reflect_floor(lanes, p, light):
    """Show the floor to the reflected rays, under a uniform irradiance / π `light` (3).  p: floor_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    depth, side, spread = row[DEPTH], row[PIXEL_SIDE], row[PIXEL_SPREAD]
    hx, hy, hz, wx, wy, wz = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    r, g, b, near = row[A6], row[A7], row[A8], row[A9]
    (ux, uy, uz), height, per = vector(p, ground.NORMAL), p[ground.HEIGHT], p[ground.PER_TILE]
    a_axis, b_axis, a0, b0 = vector(p, ground.AXIS_A), vector(p, ground.AXIS_B), p[ground.SHIFT], p[ground.SHIFT + 1]
    (fr, fg, fb), (qr, qg, qb) = vector(p, ground.COLOUR), vector(p, ground.HALF_DIFFERENCE)
    (er, eg, eb), tile = vector(light, 0), real(1) / per
    for i in range(B):
        steep = real(1) / (ux * wx[i] + uy * wy[i] + uz * wz[i])
        t = (height - (ux * hx[i] + uy * hy[i] + uz * hz[i])) * steep
        hit = (t > real(0)) & (steep < real(0))
        px, py, pz = hx[i] + t * wx[i], hy[i] + t * wy[i], hz[i] + t * wz[i]
        wide = abs(side[i] + (t + depth[i]) * spread[i]) * per
        bright = tile_side(real, px, py, pz, wx[i], wy[i], wz[i], steep, wide, a_axis, b_axis, a0, b0, tile)
        near[i] = t if hit else near[i]
        r[i] = er * (fr + bright * qr) if hit else r[i]
        g[i] = eg * (fg + bright * qg) if hit else g[i]
        b[i] = eb * (fb + bright * qb) if hit else b[i]


@stage
def sharp_lights(lanes, p, ints):
    """Show lights to the reflected ray where they are nearer.  p, ints: reflected_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    hx, hy, hz, wx, wy, wz = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    r, g, b, near = row[A6], row[A7], row[A8], row[A9]
    count = ints[0]
    end = PANEL * count
    for j in range(count):
        s = PANEL * j
        (cx, cy, cz), (ux, uy, uz) = vector(p, s + CENTRE), vector(p, s + NORMAL)
        (ax, ay, az), (bx, by, bz), disk = vector(p, s + AXIS_U), vector(p, s + AXIS_V), real(ints[1 + j])
        er, eg, eb = vector(p, s + COLOUR)
        for i in range(B):
            t, qa, qb = plane_point(hx[i] - cx, hy[i] - cy, hz[i] - cz, wx[i], wy[i], wz[i], ux, uy, uz,
                                    ax, ay, az, bx, by, bz)
            hit = inside_edge(real, qa, qb, disk) & (t > real(0)) & (t < near[i])
            near[i] = t if hit else near[i]
            r[i] = er if hit else r[i]
            g[i] = eg if hit else g[i]
            b[i] = eb if hit else b[i]
    for s in range(end, p.size, BULB):
        (cx, cy, cz), r2, (er, eg, eb) = vector(p, s + CENTRE), p[s + RADIUS2], vector(p, s + BULB_COLOUR)
        for i in range(B):
            along, miss2 = closest_approach(cx - hx[i], cy - hy[i], cz - hz[i], wx[i], wy[i], wz[i])
            hit = (miss2 < r2) & (along > real(0)) & (along < near[i])
            near[i] = along if hit else near[i]
            r[i] = er if hit else r[i]
            g[i] = eg if hit else g[i]
            b[i] = eb if hit else b[i]


@stage
def sharp_close(lanes, is_last):
    """Add what is reflected (A6 A7 A8) times Schlick's reflectance F, 2 F / (1 + F) of both sides of a pane."""
    real = lanes.dtype.type
    row = rows(lanes)
    dx, dy, dz, finish, nx, ny, nz = row[L], row[M], row[N], row[FINISH], row[NX], row[NY], row[NZ]
    red, green, blue, tr, tg, tb, sr, sg, sb = (row[RED], row[GREEN], row[BLUE], row[TR], row[TG], row[TB],
                                                row[SR], row[SG], row[SB])
    r, g, b = row[A6], row[A7], row[A8]
    last = is_last != 0
    for i in range(B):
        edge5 = schlick_edge(real, -(dx[i] * nx[i] + dy[i] * ny[i] + dz[i] * nz[i]))
        f = real(F0) + real(1 - F0) * edge5
        coated = is_sharp_coat(real, finish[i])
        ends = is_metal(real, finish[i]) & last
        f = real(2) * f / (real(1) + f) if finish[i] == real(GLASS) else f
        f = f if coated | is_glass(real, finish[i]) else real(0)
        sr[i] += tr[i] * r[i] * (red[i] + (real(1) - red[i]) * edge5 if ends else f)
        sg[i] += tg[i] * g[i] * (green[i] + (real(1) - green[i]) * edge5 if ends else f)
        sb[i] += tb[i] * b[i] * (blue[i] + (real(1) - blue[i]) * edge5 if ends else f)
        under = real(1) - f if coated else real(1)
        red[i], green[i], blue[i] = red[i] * under, green[i] * under, blue[i] * under
