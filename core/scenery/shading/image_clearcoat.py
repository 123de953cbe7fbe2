"""Sharp clear coats and glass below a sky that a picture shows."""

import math

import numpy as np

from lensbench.kernels.block import A3, A4, A5, A6, A7, A8, A9, A10, A11, H0, B, Step, rows, stage
from lensbench.kernels.layout import Packed
from lensbench.scenery.intersect.image_sky import IMAGE_SKY, image_sky_step, look_up_sky
from lensbench.scenery.shading.clearcoat import IS_LAST, LIGHTS, PLANAR_LIGHTS, sharp_close, sharp_lights, sharp_open
from lensbench.scenery.shading.moving_clearcoat import reflect_moving
from lensbench.scenery.shading.moving_lights import after

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
