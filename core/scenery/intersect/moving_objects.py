"""Moving shapes: rays are transformed to the frame where a shape rests, meet it there, and are transformed back.

Neighbours of one motion make a group, which rests in one frame: its pivot is where it was at TIME = 0, and nothing
rotates. Every lane has a TIME of its own. A group that no ray of a block can meet at any of the block's times costs a
few comparisons.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from lensbench.core.kernels.block import (
    BEAM, DEPTH, H0, H1, H2, H3, H4, H5, H6, H7, H8, NX, NY, NZ, TIME, B, L, Packed, X, join, offsets, pack, rows,
    stage, vector
)
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.numeric import sine_versine
from lensbench.core.scenery.intersect.block_bounds import FORWARD, RIGHTWARD, UPWARD, beam, beam_misses
from lensbench.core.scenery.intersect.planar import planar, planar_parameters
from lensbench.core.scenery.intersect.spheres import sphere_parameters, spheres
from lensbench.core.scenery.objects.shape import Shape, by_family, displaced

# A motion: unit AXIS, RATE (rotations per second), PHASE (rotations at TIME 0); then a sphere that holds all that
# moves so, at rest: MIDDLE and REACH (mm)
PIVOT, VELOCITY, AXIS, RATE, PHASE, MIDDLE, REACH, MOTION = offsets(3, 3, 3, 1, 1, 3, 1)
# A group is a motion, then its shapes. Integers: how many numbers and integers it has, which motion; then its shapes'
LENGTH, COUNT, WHICH, GROUP = range(4)
CROWD = 20              # a group is split until it holds no more
TICKS = 65536.0         # steps of a second
LONGEST = 30000.0       # s, the most that these can count


def motion_parameters(shapes: Sequence[Shape], opening: float) -> np.ndarray:
    """The MOTION numbers of shapes that move alike, displaced to `opening` (s), which is their TIME 0."""
    first = shapes[0]
    rate = math.sqrt(float(np.dot(first.spin, first.spin)))
    axis = np.asarray(first.spin) / rate if rate > 0.0 else np.zeros(3)
    rotations = rate / (2.0 * math.pi)
    centres = np.array([o.centre for o in shapes])
    middle = (centres.min(0) + centres.max(0)) / 2.0
    reach = max(math.dist(o.centre, middle) + o.bounding_radius for o in shapes) * (1.0 + 1e-5)
    return pack(MOTION, {PIVOT: first.centre if first.pivot is None else first.pivot, VELOCITY: first.velocity,
                         AXIS: axis, RATE: rotations, PHASE: math.remainder(rotations * opening, 1.0),
                         MIDDLE: middle, REACH: reach})


def _neighbours(shapes: list[Shape]) -> list[list[Shape]]:
    """Groups of at most CROWD, halved along their widest direction."""
    if len(shapes) <= CROWD:
        return [shapes]
    centres = np.array([o.centre for o in shapes])
    order = np.argsort(centres[:, np.argmax(np.ptp(centres, 0))], kind="stable")
    half = len(shapes) // 2
    return [group for indices in (order[:half], order[half:]) for group in _neighbours([shapes[j] for j in indices])]


def moving_groups(shapes: Sequence[Shape], opening: float,
                  packer: Callable[[list[Any], list[Any]], Packed]) -> Packed:
    """Groups of moving shapes, each followed by its spheres and planar shapes as packed by `packer`.

    opening: seconds at TIME 0.
    """
    groups: dict[Any, list[Shape]] = {}
    for o in shapes:
        centre_of_rotation = any(o.spin) and (o.centre if o.pivot is None else o.pivot)
        groups.setdefault((o.velocity, o.spin, centre_of_rotation), []).append(displaced(o, opening))
    packed = []
    for which, alike in enumerate(groups.values()):
        for group in _neighbours(alike):
            contents = packer(*by_family(group))
            packed += [Packed(motion_parameters(group, opening),
                              [MOTION + contents.parameters.size, GROUP + np.size(contents.integers), which]), contents]
    return join(*packed)


def after(still: Packed, moved: Packed) -> Packed:
    """What is still, then groups of what moves; the first integer is the number of parameters of what is still."""
    return join(Packed(np.zeros(0), [still.parameters.size]), still, moved)


def moving_parameters(shapes: Sequence[Shape], opening: float) -> Packed:
    """Parameters of the stage `moving`; the integers of a group begin with how many its spheres have of each."""
    def both(balls: list[Any], flat: list[Any]) -> Packed:
        first = sphere_parameters(balls) if balls else join()
        sizes = Packed(np.zeros(0), [first.parameters.size, np.size(first.integers)])
        return join(sizes, first, planar_parameters(flat))
    return moving_groups(shapes, opening, both)


@njit(inline="always")
def motion_of(p, s):
    """The motion at p[s …] without its sphere: pivot, velocity, axis, rate, phase."""
    (px, py, pz), (vx, vy, vz), (ax, ay, az) = vector(p, s + PIVOT), vector(p, s + VELOCITY), vector(p, s + AXIS)
    return px, py, pz, vx, vy, vz, ax, ay, az, p[s + RATE], p[s + PHASE]


@njit(inline="always")
def rotated(sine, versine, ax, ay, az, x, y, z):
    """A vector rotated about a unit axis (Rodrigues)."""
    along = ax * x + ay * y + az * z
    return (x + sine * (ay * z - az * y) + versine * (ax * along - x),
            y + sine * (az * x - ax * z) + versine * (ay * along - y),
            z + sine * (ax * y - ay * x) + versine * (az * along - z))


@njit(inline="always")
def swept_bounds(real, p, s, early, late):
    """Bounds of what moves by p[s …] between two times: centre (3) and radius at mid-time, half of the translation (3).

    All of it lies within the radius of the segment from the centre minus the half translation to it plus that.
    """
    px, py, pz, vx, vy, vz, ax, ay, az, rate, phase = motion_of(p, s)
    middle, half = (early + late) * real(0.5), (late - early) * real(0.5)
    sine, versine = sine_versine(real, rate * middle + phase)
    cx, cy, cz = p[s + MIDDLE] - px, p[s + MIDDLE + 1] - py, p[s + MIDDLE + 2] - pz
    qx, qy, qz = rotated(sine, versine, ax, ay, az, cx, cy, cz)
    swing = half * rate * real(2 * math.pi) * math.sqrt(cx * cx + cy * cy + cz * cz)
    return (qx + px + vx * middle, qy + py + vy * middle, qz + pz + vz * middle, p[s + REACH] + swing,
            half * vx, half * vy, half * vz)


@njit(inline="always")
def to_rest_frame(real, motion, t, x, y, z, dx, dy, dz):
    """A point and a direction of the world at the time t in the frame where the group rests."""
    px, py, pz, vx, vy, vz, ax, ay, az, rate, phase = motion
    s, v = sine_versine(real, rate * t + phase)
    qx, qy, qz = rotated(-s, v, ax, ay, az, x - (px + vx * t), y - (py + vy * t), z - (pz + vz * t))
    ex, ey, ez = rotated(-s, v, ax, ay, az, dx, dy, dz)
    return qx + px, qy + py, qz + pz, ex, ey, ez


@njit(inline="always")
def to_world_frame(real, motion, t, x, y, z, dx, dy, dz):
    """A point and a direction of the frame where the group rests in the world at the time t."""
    px, py, pz, vx, vy, vz, ax, ay, az, rate, phase = motion
    s, v = sine_versine(real, rate * t + phase)
    qx, qy, qz = rotated(s, v, ax, ay, az, x - px, y - py, z - pz)
    ex, ey, ez = rotated(s, v, ax, ay, az, dx, dy, dz)
    return qx + (px + vx * t), qy + (py + vy * t), qz + (pz + vz * t), ex, ey, ez


@stage(inlined=True)
def copy_vectors(lanes, source, target):
    """Copy three rows from `source` on to those from `target` on."""
    row = rows(lanes)
    for k in range(3):
        for i in range(B):
            row[target + k, i] = row[source + k, i]


@stage(inlined=True)
def keep_world(lanes, point, way, normals):
    """Keep points (3 rows from `point` on, mm) and directions (from `way`) in H0 … H5; normals: NX NY NZ in H6 … H8."""
    copy_vectors(lanes, point, H0)
    copy_vectors(lanes, way, H3)
    if normals:
        copy_vectors(lanes, NX, H6)


@stage(inlined=True)
def enter_rest_frame(lanes, motion, point, way, normals):
    """Write what `keep_world` kept to its rows, in the frame where a group rests."""
    real = lanes.dtype.type
    row = rows(lanes)
    time, x, y, z, dx, dy, dz = (row[TIME], row[point], row[point + 1], row[point + 2], row[way], row[way + 1],
                                 row[way + 2])
    hx, hy, hz, ex, ey, ez = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5]
    for i in range(B):
        x[i], y[i], z[i], dx[i], dy[i], dz[i] = to_rest_frame(real, motion, time[i], hx[i], hy[i], hz[i],
                                                              ex[i], ey[i], ez[i])
    if normals:
        nx, ny, nz, ux, uy, uz = row[NX], row[NY], row[NZ], row[H6], row[H7], row[H8]
        for i in range(B):
            _, _, _, nx[i], ny[i], nz[i] = to_rest_frame(real, motion, time[i], hx[i], hy[i], hz[i],
                                                         ux[i], uy[i], uz[i])


@stage(inlined=True)
def leave_rest_frame(lanes, point, way, normals):
    """Write what `keep_world` kept back to its rows, in the world."""
    copy_vectors(lanes, H0, point)
    copy_vectors(lanes, H3, way)
    if normals:
        copy_vectors(lanes, H6, NX)


@stage
def time_bounds(lanes):
    """Earliest and latest TIME of the block (s), rounded outwards."""
    real = lanes.dtype.type
    row = rows(lanes)
    time = row[TIME]
    low, high = np.int32(1 << 30), np.int32(-(1 << 30))
    for i in range(B):
        t = time[i] if time[i] < real(LONGEST) else real(LONGEST)
        k = np.int32((t if t > real(-LONGEST) else real(-LONGEST)) * real(TICKS))
        low, high = min(low, k), max(high, k)
    latest = real(np.int32(high + 1)) * real(1 / TICKS)
    return real(np.int32(low - 1)) * real(1 / TICKS), latest if latest < real(LONGEST) else real(math.inf)


@stage
def moving(lanes, p, ints, key):
    """Intersect rays with moving shapes, after `beam`; the nearest surface stays.  p: moving_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    depth, near, world_beam = row[DEPTH], row[H6], row[H7]

    # Keep the rays and their beam in the world
    early, late = time_bounds(lanes)
    keep_world(lanes, X, L, False)
    for i in range(B):
        world_beam[i] = row[BEAM][i]
    s, k, last, current = 0, 0, 0, -1
    while s < p.size:
        motion, begin, which = s, s + MOTION, ints[k + WHICH]
        flat, ball_integers = begin + ints[k + GROUP], k + GROUP + 2
        flat_integers = ball_integers + ints[k + GROUP + 1]
        s, k = s + ints[k + LENGTH], k + ints[k + COUNT]

        # Skip a group that the beam misses wherever the group is meanwhile
        cx, cy, cz, wide, wx, wy, wz = swept_bounds(real, p, motion, early, late)
        (fx, fy, fz), (ux, uy, uz) = vector(world_beam, FORWARD), vector(world_beam, UPWARD)
        rx, rz = world_beam[RIGHTWARD], world_beam[RIGHTWARD + 2]
        if beam_misses(world_beam, cx, cy, cz, wide + abs(wx * fx + wy * fy + wz * fz),
                       wide + abs(wx * ux + wy * uy + wz * uz), wide + abs(wx * rx + wz * rz)):
            continue

        # Transform the rays to the frame where the group rests
        if which != current:
            if current >= 0:
                _normals_to_world(lanes, p, last)
            enter_rest_frame(lanes, motion_of(p, motion), X, L, False)
            for i in range(B):
                near[i] = depth[i]
            beam(lanes, p, ints, key)
            last, current = motion, which

        # Intersect them there
        spheres(lanes, p[begin:flat], ints[ball_integers:flat_integers], key)
        planar(lanes, p[flat:s], ints[flat_integers:k], key)
    if current >= 0:
        _normals_to_world(lanes, p, last)
    leave_rest_frame(lanes, X, L, False)


@stage
def _normals_to_world(lanes, p, s):
    """Rotate the normals of what was met nearer than H6 from the frame of the motion p[s …] to the world."""
    real = lanes.dtype.type
    row = rows(lanes)
    time, depth, near, nx, ny, nz = row[TIME], row[DEPTH], row[H6], row[NX], row[NY], row[NZ]
    motion = motion_of(p, s)
    count = np.int32(0)
    for i in range(B):
        count = np.int32(count + np.int32(depth[i] < near[i]))
    if count == 0:
        return
    for i in range(B):
        _, _, _, ux, uy, uz = to_world_frame(real, motion, time[i], real(0), real(0), real(0), nx[i], ny[i], nz[i])
        hit = depth[i] < near[i]
        nx[i], ny[i], nz[i] = ux if hit else nx[i], uy if hit else ny[i], uz if hit else nz[i]
