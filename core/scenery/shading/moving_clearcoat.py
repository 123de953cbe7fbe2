"""Coats in a scene where lights move: each lane's coat reflects them where they are at its TIME.

Sharp coats transform the reflected ray, rough ones the lit point with its normal, to the frame where the light rests.
"""

from collections.abc import Sequence

import numpy as np

from lensbench.kernels.block import (
    A0,
    A1,
    A2,
    A3,
    A4,
    A5,
    H0,
    H1,
    H2,
    H3,
    H4,
    H5,
    H6,
    H7,
    H8,
    NX,
    NY,
    NZ,
    TIME,
    B,
    L,
    M,
    N,
    rows,
    stage,
)
from lensbench.kernels.layout import integer
from lensbench.scenery.intersect.moving_objects import (
    FIRST,
    GROUP,
    GROUP_MOTION,
    LENGTH,
    motion_of,
    moving_groups,
    to_rest_frame,
)
from lensbench.scenery.objects import Shape
from lensbench.scenery.shading.clearcoat import (
    LIGHTS,
    PLANAR_LIGHTS,
    reflected_parameters,
    sharp_close,
    sharp_lights,
    sharp_open,
)
from lensbench.scenery.shading.rough_clearcoat import SKY, highlight_parameters, rough_close, rough_lights, rough_open


def moving_reflected(lights: Sequence[Shape], opening: float) -> np.ndarray:
    """Parameters of `moving_clearcoat` for moving lights. opening: seconds at TIME 0."""
    return moving_groups(lights, opening,
                         lambda spheres, planar: (reflected_parameters(spheres, planar), len(planar)))


def moving_highlights(lights: Sequence[Shape], opening: float) -> np.ndarray:
    """Parameters of `moving_rough_clearcoat` for moving lights. opening: seconds at TIME 0."""
    return moving_groups(lights, opening, lambda spheres, planar: (highlight_parameters([*spheres, *planar]), 0))


@stage
def moving_clearcoat(lanes, p, ints, key):
    """`clearcoat` with moving lights.  p: length of clearcoat_parameters, these, then moving_reflected."""
    still = 1 + int(p[0])
    if sharp_open(lanes, p[1:still]) == 0:
        return
    sharp_lights(lanes, p[1 + LIGHTS:still], int(p[1 + PLANAR_LIGHTS]))
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, time = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5], row[TIME]
    hx, hy, hz, ex, ey, ez = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5]
    for i in range(B):
        hx[i], hy[i], hz[i], ex[i], ey[i], ez[i] = x[i], y[i], z[i], dx[i], dy[i], dz[i]
    s = still
    while s < p.size:
        end, motion = s + integer(p, s + LENGTH), motion_of(p, s + GROUP_MOTION)
        for i in range(B):
            x[i], y[i], z[i], dx[i], dy[i], dz[i] = to_rest_frame(real, motion, time[i], hx[i], hy[i], hz[i],
                                                                  ex[i], ey[i], ez[i])
        sharp_lights(lanes, p[s + GROUP:end], int(p[s + FIRST]))
        s = end
    sharp_close(lanes, p[1:still])


@stage
def moving_rough_clearcoat(lanes, p, ints, key):
    """`rough_clearcoat` with moving lights.  p: length of rough_clearcoat_parameters, these, then moving_highlights."""
    still = 1 + int(p[0])
    if rough_open(lanes, p[1:still]) == 0:
        return
    rough_lights(lanes, p[1 + SKY:still])
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, nx, ny, nz, time = (row[A0], row[A1], row[A2], row[L], row[M], row[N], row[NX], row[NY],
                                             row[NZ], row[TIME])
    hx, hy, hz, ex, ey, ez, ux, uy, uz = (row[H0], row[H1], row[H2], row[H3], row[H4], row[H5], row[H6], row[H7],
                                          row[H8])
    for i in range(B):
        hx[i], hy[i], hz[i], ex[i], ey[i], ez[i] = x[i], y[i], z[i], dx[i], dy[i], dz[i]
        ux[i], uy[i], uz[i] = nx[i], ny[i], nz[i]
    s = still
    while s < p.size:
        end, motion = s + integer(p, s + LENGTH), motion_of(p, s + GROUP_MOTION)
        for i in range(B):
            x[i], y[i], z[i], dx[i], dy[i], dz[i] = to_rest_frame(real, motion, time[i], hx[i], hy[i], hz[i],
                                                                  ex[i], ey[i], ez[i])
            _, _, _, nx[i], ny[i], nz[i] = to_rest_frame(real, motion, time[i], hx[i], hy[i], hz[i],
                                                         ux[i], uy[i], uz[i])
        rough_lights(lanes, p[s + GROUP:end])
        s = end
    for i in range(B):
        dx[i], dy[i], dz[i], nx[i], ny[i], nz[i] = ex[i], ey[i], ez[i], ux[i], uy[i], uz[i]
    rough_close(lanes)
