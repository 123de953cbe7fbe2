"""Coats in a scene where lights move: each lane's coat reflects them where they are at its TIME.

Sharp coats transform the reflected ray, rough ones the lit point with its normal, to the frame where the light rests.

Sharp clear coats and glass below a sky that a picture shows.
"""

import math
from collections.abc import Sequence

import numpy as np

from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, A6, A7, A8, A9, A10, A11, H0, H1, H2, H3, H4, H5, H6, H7, H8, NX, NY, NZ, TIME, B, L, M, N,
    Packed, Step, rows, stage
)
from lensbench.core.scenery.intersect.image_sky import IMAGE_SKY, image_sky_step, look_up_sky
from lensbench.core.scenery.intersect.moving_objects import (
    COUNT, GROUP, LENGTH, MOTION, motion_of, moving_groups, to_rest_frame
)
from lensbench.core.scenery.intersect.sky import SKY
from lensbench.core.scenery.objects.shape import Shape
from lensbench.core.scenery.shading.clearcoat import (
    IS_LAST, LIGHTS, PLANAR_LIGHTS, SWITCHES, reflected_parameters, sharp_close, sharp_lights, sharp_open
)
from lensbench.core.scenery.shading.moving_lights import after
from lensbench.core.scenery.shading.rough_clearcoat import highlight_parameters, rough_close, rough_lights, rough_open


def moving_reflected(lights: Sequence[Shape], opening: float) -> Packed:
    """Parameters of `moving_clearcoat` for moving lights. opening: seconds at TIME 0."""
    return moving_groups(lights, opening, reflected_parameters)


def moving_highlights(lights: Sequence[Shape], opening: float) -> Packed:
    """Parameters of `moving_rough_clearcoat` for moving lights. opening: seconds at TIME 0."""
    return moving_groups(lights, opening, lambda spheres, planar: Packed(highlight_parameters([*spheres, *planar])))


@stage
def moving_clearcoat(lanes, p, ints, key):
    """`clearcoat` with moving lights.  p, ints: `after` of clearcoat_parameters and moving_reflected."""
    if sharp_open(lanes, p, ints[1:]) > 0:
        reflect_moving(lanes, p, ints)


@stage
def reflect_moving(lanes, p, ints):
    """Show lights, still and moving, to the rays of `sharp_open`, and add what is reflected.  p, ints: as above."""
    still, switches = ints[0], ints[1:]
    sharp_lights(lanes, p[LIGHTS:still], switches[PLANAR_LIGHTS:])
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, time = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5], row[TIME]
    hx, hy, hz, ex, ey, ez = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5]
    for i in range(B):
        hx[i], hy[i], hz[i], ex[i], ey[i], ez[i] = x[i], y[i], z[i], dx[i], dy[i], dz[i]
    s, k = still, 1 + SWITCHES + switches[PLANAR_LIGHTS]
    while s < p.size:
        end, motion = s + ints[k + LENGTH], motion_of(p, s)
        for i in range(B):
            x[i], y[i], z[i], dx[i], dy[i], dz[i] = to_rest_frame(real, motion, time[i], hx[i], hy[i], hz[i],
                                                                  ex[i], ey[i], ez[i])
        sharp_lights(lanes, p[s + MOTION:end], ints[k + GROUP:])
        s, k = end, k + ints[k + COUNT]
    sharp_close(lanes, switches[IS_LAST])


@stage
def moving_rough_clearcoat(lanes, p, ints, key):
    """`rough_clearcoat` with moving lights.  p, ints: `after` of rough_clearcoat_parameters and moving_highlights."""
    still = ints[0]
    if rough_open(lanes, p) == 0:
        return
    rough_lights(lanes, p[SKY:still])
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, nx, ny, nz, time = (row[A0], row[A1], row[A2], row[L], row[M], row[N], row[NX], row[NY],
                                             row[NZ], row[TIME])
    hx, hy, hz, ex, ey, ez, ux, uy, uz = (row[H0], row[H1], row[H2], row[H3], row[H4], row[H5], row[H6], row[H7],
                                          row[H8])
    for i in range(B):
        hx[i], hy[i], hz[i], ex[i], ey[i], ez[i] = x[i], y[i], z[i], dx[i], dy[i], dz[i]
        ux[i], uy[i], uz[i] = nx[i], ny[i], nz[i]
    s, k = still, 1
    while s < p.size:
        end, motion = s + ints[k + LENGTH], motion_of(p, s)
        for i in range(B):
            x[i], y[i], z[i], dx[i], dy[i], dz[i] = to_rest_frame(real, motion, time[i], hx[i], hy[i], hz[i],
                                                                  ex[i], ey[i], ez[i])
            _, _, _, nx[i], ny[i], nz[i] = to_rest_frame(real, motion, time[i], hx[i], hy[i], hz[i],
                                                         ux[i], uy[i], uz[i])
        rough_lights(lanes, p[s + MOTION:end])
        s, k = end, k + ints[k + COUNT]
    for i in range(B):
        dx[i], dy[i], dz[i], nx[i], ny[i], nz[i] = ex[i], ey[i], ez[i], ux[i], uy[i], uz[i]
    rough_close(lanes)


SKY_INTEGERS = 4


def image_clearcoat_step(sky, still: Packed, moved: Packed) -> Step:
    """The stage of sharp coats for an `ImageSky`; still: clearcoat_parameters, moved: moving_reflected."""
    moves = moved.parameters.size > 0
    step = image_sky_step(sky, moving_image_clearcoat if moves else image_clearcoat)
    packed = after(still, moved) if moves else still
    return step._replace(parameters=np.concatenate([step.parameters, packed.parameters]),
                         integers=np.concatenate([step.integers, np.asarray(packed.integers, np.int64)]))


@stage
def image_clearcoat(lanes, p, ints, key):
    """`clearcoat` that reflects the picture of the sky.  p, ints: image_clearcoat_step."""
    if _image_open(lanes, p, ints, ints[SKY_INTEGERS:]) > 0:
        sharp_lights(lanes, p[IMAGE_SKY + LIGHTS:], ints[SKY_INTEGERS + PLANAR_LIGHTS:])
        sharp_close(lanes, ints[SKY_INTEGERS + IS_LAST])


@stage
def moving_image_clearcoat(lanes, p, ints, key):
    """`moving_clearcoat` that reflects the picture of the sky.  p, ints: image_clearcoat_step."""
    if _image_open(lanes, p, ints, ints[SKY_INTEGERS + 1:]) > 0:
        reflect_moving(lanes, p[IMAGE_SKY:], ints[SKY_INTEGERS:])


@stage
def _image_open(lanes, p, ints, switches):
    """`sharp_open` with the picture in place of the sky of three colours."""
    many = sharp_open(lanes, p[IMAGE_SKY:], switches)
    if many == 0:
        return many
    real = lanes.dtype.type
    row = rows(lanes)
    near, red, green, blue = row[A9], row[A6], row[A7], row[A8]
    r, g, b = row[A10], row[A11], row[H0]
    look_up_sky(lanes, p, ints, row[A3], row[A4], row[A5], r, g, b)
    for i in range(B):
        open_ = near[i] == real(math.inf)
        red[i], green[i], blue[i] = r[i] if open_ else red[i], g[i] if open_ else green[i], b[i] if open_ else blue[i]
    return many
