"""Light in a scene where something moves: every lane's shadows and lamps are those of its TIME.

Each stage is the one of a still scene, put together from the same parts, and goes
on to the things that move. Their shadow rays are carried into the frame where
the thing rests; so is the lit point where it is the lamp that moves.
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
    X,
    Y,
    Z,
    rows,
    stage,
)
from lensbench.kernels.rotation import sine_versine
from lensbench.scenery.intersect.block_bounds import boxes_disjoint, shadow_bounds
from lensbench.scenery.intersect.moving_objects import (
    HEAD,
    MOTION,
    motion_of,
    moving_groups,
    rotated,
    swept_bounds,
    time_bounds,
    to_rest_frame,
    to_world_frame,
)
from lensbench.scenery.objects import Plate, Sphere
from lensbench.scenery.shading.illumination import add_sky, count_lit, sky_begin, sky_occlusion, unoccluded
from lensbench.scenery.shading.soft_shadows import (
    LAMP,
    SUN,
    add_light,
    occluder_parameters,
    sample_lamp,
    sample_sun,
    shadow,
)

AMBIENT = 15            # numbers before the spheres of `ambient`


def moving_occluders(things: Sequence[Sphere | Plate], opening: float) -> np.ndarray:
    """What `shadow_moving` reads; lights are left out. opening: seconds at TIME 0."""
    return moving_groups([thing for thing in things if not thing.material.shines], opening,
                         lambda balls, flat: (occluder_parameters(balls, flat), 0))


def moving_sky_occluders(balls: Sequence[Sphere], opening: float, share) -> np.ndarray:
    """What `moving_ambient` reads of the spheres that hold off the sky's light; share: the part of each that does."""
    def four(group: list[Sphere], _: list[Plate]) -> tuple[np.ndarray, int]:
        return np.array([[*s.centre, s.radius**2 * share(s)] for s in group]).ravel(), 4 * len(group)
    return moving_groups(balls, opening, four)


def after(still: np.ndarray, *more: np.ndarray) -> np.ndarray:
    """How many numbers `still` has, then all of them."""
    return np.concatenate([[still.size], still, *more])


@stage
def moving_ambient(lanes, p, key):
    """`ambient`, where spheres move.  p: how many numbers `ambient` reads, these, then moving_sky_occluders."""
    if count_lit(lanes) == 0:
        return
    real = lanes.dtype.type
    row = rows(lanes)
    nx, ny, nz, hx, hy, hz, free, time = row[NX], row[NY], row[NZ], row[A0], row[A1], row[A2], row[A3], row[TIME]
    sine, versine = row[A4], row[A5]
    still = 1 + int(p[0])
    sky_begin(lanes)
    sky_occlusion(lanes, p[1 + AMBIENT:still])
    s = still
    while s < p.size:
        end, motion = s + int(p[s]), motion_of(p, s + 3)
        px, py, pz, vx, vy, vz, ax, ay, az, rate, first = motion
        for i in range(B):
            sine[i], versine[i] = sine_versine(real, rate * time[i] + first)
        for j in range(s + HEAD, end, 4):
            cx, cy, cz, r2 = p[j] - px, p[j + 1] - py, p[j + 2] - pz, p[j + 3]
            for i in range(B):
                qx, qy, qz = rotated(sine[i], versine[i], ax, ay, az, cx, cy, cz)
                free[i] *= unoccluded(real, qx + (px + vx * time[i]) - hx[i], qy + (py + vy * time[i]) - hy[i],
                                    qz + (pz + vz * time[i]) - hz[i], r2, nx[i], ny[i], nz[i])
        s = end
    add_sky(lanes, p[1:still])


@stage
def shadow_moving(lanes, p):
    """A7, less what stands between among the things that move; as `shadow`.  p: moving_occluders."""
    if p.size == 0:
        return
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, time = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5], row[TIME]
    hx, hy, hz, ex, ey, ez = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5]
    box, (early, late) = shadow_bounds(lanes), time_bounds(lanes)
    for i in range(B):
        hx[i], hy[i], hz[i], ex[i], ey[i], ez[i] = x[i], y[i], z[i], dx[i], dy[i], dz[i]
    s, current = 0, real(-1)
    while s < p.size:
        size, which, here = int(p[s]), p[s + 2], s + 3
        first, end = s + HEAD, s + size
        cx, cy, cz, wide, wx, wy, wz = swept_bounds(real, p, here, early, late)
        s += size
        if boxes_disjoint(box, cx, cy, cz, wide + abs(wx), wide + abs(wy), wide + abs(wz)):
            continue
        if which != current:
            motion, current = motion_of(p, here), which
            for i in range(B):
                x[i], y[i], z[i], dx[i], dy[i], dz[i] = to_rest_frame(real, motion, time[i], hx[i], hy[i], hz[i],
                                                                ex[i], ey[i], ez[i])
        shadow(lanes, p[first:end])
    for i in range(B):
        x[i], y[i], z[i], dx[i], dy[i], dz[i] = hx[i], hy[i], hz[i], ex[i], ey[i], ez[i]


@stage
def moving_sun(lanes, p, key):
    """`sun`, where casters move.  p: how many numbers `sun` reads, these, then moving_occluders."""
    if count_lit(lanes) == 0:
        return
    still = 1 + int(p[0])
    sample_sun(lanes, p[1:])
    shadow(lanes, p[1 + SUN:still])
    shadow_moving(lanes, p[still:])
    add_light(lanes, p[10], p[11], p[12])


@stage
def moving_lamp(lanes, p, key):
    """`lamp`, where it moves or casters do.

    p: the MOTION of the lamp, then how many numbers `lamp` reads, these, and moving_occluders.
    """
    if count_lit(lanes) == 0:
        return
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, time = row[X], row[Y], row[Z], row[L], row[M], row[N], row[TIME]
    nx, ny, nz = row[NX], row[NY], row[NZ]
    qx, qy, qz, wx, wy, wz = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    hx, hy, hz, ex, ey, ez, ux, uy, uz = (row[H0], row[H1], row[H2], row[H3], row[H4], row[H5], row[H6], row[H7],
                                          row[H8])
    motion, k = motion_of(p, 0), MOTION
    begin, still = k + 1, k + 1 + int(p[k])
    for i in range(B):
        hx[i], hy[i], hz[i], ex[i], ey[i], ez[i] = x[i], y[i], z[i], dx[i], dy[i], dz[i]
        ux[i], uy[i], uz[i] = nx[i], ny[i], nz[i]
    for i in range(B):
        x[i], y[i], z[i], dx[i], dy[i], dz[i] = to_rest_frame(real, motion, time[i], hx[i], hy[i], hz[i],
                                                            ex[i], ey[i], ez[i])
        _, _, _, nx[i], ny[i], nz[i] = to_rest_frame(real, motion, time[i], hx[i], hy[i], hz[i], ux[i], uy[i], uz[i])
    sample_lamp(lanes, p[begin:])
    for i in range(B):
        qx[i], qy[i], qz[i], wx[i], wy[i], wz[i] = to_world_frame(real, motion, time[i], qx[i], qy[i], qz[i],
                                                            wx[i], wy[i], wz[i])
    for i in range(B):
        x[i], y[i], z[i], dx[i], dy[i], dz[i] = hx[i], hy[i], hz[i], ex[i], ey[i], ez[i]
        nx[i], ny[i], nz[i] = ux[i], uy[i], uz[i]
    shadow(lanes, p[begin + LAMP:still])
    shadow_moving(lanes, p[still:])
    add_light(lanes, p[begin + 15], p[begin + 16], p[begin + 17])
