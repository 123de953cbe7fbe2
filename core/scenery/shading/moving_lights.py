"""Light in a scene where shapes move: every lane has the shadows and lamps of its TIME.

Each stage has the parts of its counterpart for a still scene, and goes on to the moving shapes. Shadow rays are
transformed to the frame where the occluder rests, and lit points to that of a moving lamp.

Lights in three stages: points of the light, shadows of each kind of occluder, and the sum.

Where spheres and planar shapes alone hide a light, one stage does all of it (`soft_shadows`, `moving_lights`). A sky
shown by a picture, and a scene with meshes, put the parts together as they need them. A0 … A7, as `shadow` reads them,
stay from the first part to the last.
"""

from collections.abc import Sequence

import numpy as np

from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, H0, H1, H2, H3, H4, H5, H6, H7, H8, NX, NY, NZ, TIME, B, L, M, N, Packed, X, Y, Z, join,
    pack, rows, stage, vector
)
from lensbench.core.kernels.numeric import sine_versine
from lensbench.core.scenery.intersect.block_bounds import boxes_disjoint, shadow_bounds
from lensbench.core.scenery.intersect.moving_objects import (
    COUNT, GROUP, LENGTH, MOTION, WHICH, motion_of, moving_groups, rotated, swept_bounds, time_bounds, to_rest_frame,
    to_world_frame
)
from lensbench.core.scenery.intersect.spheres import counts_below, sphere_tree
from lensbench.core.scenery.objects.shape import Shape
from lensbench.core.scenery.objects.sphere import Sphere
from lensbench.core.scenery.shading.illumination import (
    CENTRE, OCCLUDER, RADIUS2, REACH, SURROUND, add_sky, count_lit, sky_begin, sky_occlusion, unoccluded
)
from lensbench.core.scenery.shading.soft_shadows import (
    IRRADIANCE, LAMP, RADIANCE, SUN, add_light, occluder_integers, occluder_parameters, sample_lamp, sample_sun, shadow
)


def moving_occluders(shapes: Sequence[Shape], opening: float) -> Packed:
    """Parameters of `shadow_moving`; lights are left out. opening: seconds at TIME 0."""
    return moving_groups([o for o in shapes if not o.material.shines], opening, occluder_parameters)


def sky_occluders(spheres: Sequence[Sphere]) -> Packed:
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


def moving_sky_occluders(spheres: Sequence[Sphere], opening: float) -> Packed:
    """Parameters of `moving_ambient` for moving spheres. opening: seconds at TIME 0."""
    return moving_groups(spheres, opening, lambda group, _: sky_occluders(group))


def after(still: Packed, moved: Packed) -> Packed:
    """What is still, then groups of what moves; the first integer is the number of parameters of what is still."""
    return join(Packed(np.zeros(0), [still.parameters.size]), still, moved)


@stage
def moving_ambient(lanes, p, ints, key):
    """`ambient` with moving spheres.  p, ints: `after` of the parameters of `ambient` and moving_sky_occluders."""
    if count_lit(lanes) == 0:
        return
    real = lanes.dtype.type
    row = rows(lanes)
    nx, ny, nz, hx, hy, hz, free, time = row[NX], row[NY], row[NZ], row[A0], row[A1], row[A2], row[A3], row[TIME]
    sine, versine = row[A4], row[A5]
    sky_begin(lanes)
    s = ints[0]
    k = 1 + (s - SURROUND) // OCCLUDER
    sky_occlusion(lanes, p[SURROUND:s], ints[1:])
    while s < p.size:
        end, motion = s + ints[k + LENGTH], motion_of(p, s)
        px, py, pz, vx, vy, vz, ax, ay, az, rate, phase = motion
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
    add_sky(lanes, p)


@stage
def shadow_moving(lanes, p, ints):
    """Multiply A7 by what moving occluders pass, as `shadow` does for still ones.  p, ints: moving_occluders."""
    if p.size == 0:
        return
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, time = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5], row[TIME]
    hx, hy, hz, ex, ey, ez = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5]
    box, (early, late) = shadow_bounds(lanes), time_bounds(lanes)
    for i in range(B):
        hx[i], hy[i], hz[i], ex[i], ey[i], ez[i] = x[i], y[i], z[i], dx[i], dy[i], dz[i]
    s, k, current = 0, 0, -1
    while s < p.size:
        here, held, which = s, k + GROUP, ints[k + WHICH]
        s, k = s + ints[k + LENGTH], k + ints[k + COUNT]

        # Skip a group that lies beside all shadow rays
        cx, cy, cz, wide, wx, wy, wz = swept_bounds(real, p, here, early, late)
        if boxes_disjoint(box, cx, cy, cz, wide + abs(wx), wide + abs(wy), wide + abs(wz)):
            continue

        # Transform the shadow rays to the frame where it rests
        if which != current:
            motion, current = motion_of(p, here), which
            for i in range(B):
                x[i], y[i], z[i], dx[i], dy[i], dz[i] = to_rest_frame(real, motion, time[i], hx[i], hy[i], hz[i],
                                                                      ex[i], ey[i], ez[i])
        shadow(lanes, p[here + MOTION:s], ints[held:k])
    for i in range(B):
        x[i], y[i], z[i], dx[i], dy[i], dz[i] = hx[i], hy[i], hz[i], ex[i], ey[i], ez[i]


@stage
def moving_sun(lanes, p, ints, key):
    """`sun` with moving occluders.  p, ints: `after` of the parameters of `sun` and moving_occluders."""
    if count_lit(lanes) == 0:
        return
    still = ints[0]
    sample_sun(lanes, p)
    shadow(lanes, p[SUN:still], ints[1:])
    shadow_moving(lanes, p[still:], ints[1 + occluder_integers(ints[1:]):])
    add_light(lanes, p[IRRADIANCE:])


@stage
def moving_lamp(lanes, p, ints, key):
    """`lamp` where it moves or occluders do.

    p, ints: `after` of the MOTION of the lamp with the parameters of `lamp`, and moving_occluders.
    """
    if count_lit(lanes) == 0:
        return
    still = ints[0]
    sample_moving_lamp(lanes, p, ints[1])
    shadow(lanes, p[MOTION + LAMP:still], ints[2:])
    shadow_moving(lanes, p[still:], ints[2 + occluder_integers(ints[2:]):])
    add_light(lanes, p[MOTION + RADIANCE:])


@stage
def sample_moving_lamp(lanes, p, kind):
    """`sample_lamp` of a lamp in its place at the TIME of each lane.  p: its MOTION, then its own parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, time = row[X], row[Y], row[Z], row[L], row[M], row[N], row[TIME]
    nx, ny, nz = row[NX], row[NY], row[NZ]
    qx, qy, qz, wx, wy, wz = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    hx, hy, hz, ex, ey, ez, ux, uy, uz = (row[H0], row[H1], row[H2], row[H3], row[H4], row[H5], row[H6], row[H7],
                                          row[H8])
    motion = motion_of(p, 0)

    # Sample the lamp in the frame where it rests
    for i in range(B):
        hx[i], hy[i], hz[i], ex[i], ey[i], ez[i] = x[i], y[i], z[i], dx[i], dy[i], dz[i]
        ux[i], uy[i], uz[i] = nx[i], ny[i], nz[i]
    for i in range(B):
        x[i], y[i], z[i], dx[i], dy[i], dz[i] = to_rest_frame(real, motion, time[i], hx[i], hy[i], hz[i],
                                                              ex[i], ey[i], ez[i])
        _, _, _, nx[i], ny[i], nz[i] = to_rest_frame(real, motion, time[i], hx[i], hy[i], hz[i], ux[i], uy[i], uz[i])
    sample_lamp(lanes, p[MOTION:], kind)

    # Cast the shadow rays in the world
    for i in range(B):
        qx[i], qy[i], qz[i], wx[i], wy[i], wz[i] = to_world_frame(real, motion, time[i], qx[i], qy[i], qz[i],
                                                                  wx[i], wy[i], wz[i])
    for i in range(B):
        x[i], y[i], z[i], dx[i], dy[i], dz[i] = hx[i], hy[i], hz[i], ex[i], ey[i], ez[i]
        nx[i], ny[i], nz[i] = ux[i], uy[i], uz[i]


@stage
def sun_rays(lanes, p, ints, key):
    """Sample a point of the sun.  p: sun_parameters."""
    if count_lit(lanes) > 0:
        sample_sun(lanes, p)


@stage
def lamp_rays(lanes, p, ints, key):
    """Sample a point of a lamp.  p, ints: sphere_lamp or planar_lamp."""
    if count_lit(lanes) > 0:
        sample_lamp(lanes, p, ints[0])


@stage
def moving_lamp_rays(lanes, p, ints, key):
    """Sample a point of a moving lamp.  p: its MOTION, then as ints of sphere_lamp or planar_lamp."""
    if count_lit(lanes) > 0:
        sample_moving_lamp(lanes, p, ints[0])


@stage
def shadow_stage(lanes, p, ints, key):
    """Shadows of spheres and planar shapes.  p, ints: occluder_parameters."""
    if count_lit(lanes) > 0:
        shadow(lanes, p, ints)


@stage
def moving_shadows(lanes, p, ints, key):
    """Shadows of moving spheres and planar shapes.  p, ints: moving_occluders."""
    if count_lit(lanes) > 0:
        shadow_moving(lanes, p, ints)


@stage
def add_lit(lanes, p, ints, key):
    """Add the light A7 of the colour p (3)."""
    if count_lit(lanes) > 0:
        add_light(lanes, p)
