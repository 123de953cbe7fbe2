"""Sharp clear coats and glass below a sky that a picture shows."""

import math

import numpy as np

from lensbench.kernels.block import A3, A4, A5, A6, A7, A8, A9, A10, A11, H0, B, Step, rows, stage
from lensbench.kernels.layout import Packed
from lensbench.scenery.intersect.image_sky import IMAGE_SKY, image_sky_step, look_up_sky
from lensbench.scenery.shading.clearcoat import IS_LAST, LIGHTS, PLANAR_LIGHTS, sharp_close, sharp_lights, sharp_open

SKY_INTEGERS = 4


def image_clearcoat_step(sky, parameters: Packed) -> Step:
    """The stage `image_clearcoat` for an `ImageSky`; parameters: clearcoat_parameters without a sun."""
    step = image_sky_step(sky, image_clearcoat)
    return step._replace(parameters=np.concatenate([step.parameters, parameters.parameters]),
                         integers=np.concatenate([step.integers, np.asarray(parameters.integers, np.int64)]))


@stage
def image_clearcoat(lanes, p, ints, key):
    """`clearcoat` that reflects the picture of the sky.  p, ints: image_clearcoat_step."""
    if sharp_open(lanes, p[IMAGE_SKY:], ints[SKY_INTEGERS:]) == 0:
        return
    real = lanes.dtype.type
    row = rows(lanes)
    near, red, green, blue = row[A9], row[A6], row[A7], row[A8]
    r, g, b = row[A10], row[A11], row[H0]
    look_up_sky(lanes, p, ints, row[A3], row[A4], row[A5], r, g, b)
    for i in range(B):
        open_ = near[i] == real(math.inf)
        red[i], green[i], blue[i] = r[i] if open_ else red[i], g[i] if open_ else green[i], b[i] if open_ else blue[i]
    sharp_lights(lanes, p[IMAGE_SKY + LIGHTS:], ints[SKY_INTEGERS + PLANAR_LIGHTS])
    sharp_close(lanes, ints[SKY_INTEGERS + IS_LAST])
