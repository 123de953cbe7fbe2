"""Things that move: rays are carried into the frame where a thing rests, meet it there, and are carried back.

Neighbours of one motion make a group, and a group rests in one frame: its pivot stays where it was at TIME = 0,
and nothing turns. Every lane has a TIME of its own. A group that no ray of a block can meet, wherever it
was meanwhile, costs the block a few comparisons.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numba import njit

from lensbench.kernels.block import (
    BEAM,
    DEPTH,
    H0,
    H1,
    H2,
    H3,
    H4,
    H5,
    H6,
    H7,
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
from lensbench.scenery.intersect.block_bounds import beam, beam_misses
from lensbench.scenery.intersect.planar import plate_frame, plate_parameters, plates
from lensbench.scenery.intersect.spheres import sphere_parameters, spheres
from lensbench.scenery.objects import Plate, Sphere, triple

MOTION = 15             # numbers of a motion: pivot, velocity, axis (3 each), turns per second, turns at TIME 0; then
#                         a sphere that holds all that moves so, at rest: its middle and reach
HEAD = 3 + MOTION       # before a group's data: how many numbers in all, how many of spheres, which motion; its numbers
CROWD = 20              # a group is split until it holds no more
TICKS = 65536.0         # steps of a second
LONGEST = 30000.0       # s, that these can count


def displaced(thing, seconds: float):
    """The thing where its velocity has brought it by then, not turned."""
    way = np.multiply(thing.velocity, seconds)
    pivot = None if thing.pivot is None else triple(np.add(thing.pivot, way))
    return replace(thing, centre=triple(np.add(thing.centre, way)), pivot=pivot)


def _half_size(thing) -> float:
    """How far a thing reaches from its centre (mm)."""
    if isinstance(thing, Sphere):
        return thing.radius
    _, a, b, _, disk = plate_frame(thing)
    return math.sqrt(max(a @ a, b @ b) if disk else a @ a + b @ b)


def motion_parameters(things: Sequence[Sphere | Plate], opening: float) -> np.ndarray:
    """The MOTION numbers of things that move alike, displaced to `opening` (s), which is their TIME 0."""
    first = things[0]
    rate = math.sqrt(float(np.dot(first.spin, first.spin)))
    axis = np.asarray(first.spin) / rate if rate > 0.0 else np.zeros(3)
    turns = rate / (2.0 * math.pi)
    centres = np.array([thing.centre for thing in things])
    middle = (centres.min(0) + centres.max(0)) / 2.0
    reach = max(math.dist(thing.centre, middle) + _half_size(thing) for thing in things) * (1.0 + 1e-5)
    return np.array([*(first.centre if first.pivot is None else first.pivot), *first.velocity, *axis, turns,
                     math.remainder(turns * opening, 1.0), *middle, reach])


def _neighbours(things: list[Sphere | Plate]) -> list[list[Sphere | Plate]]:
    """Halved along their widest direction until none is a crowd."""
    if len(things) <= CROWD:
        return [things]
    centres = np.array([thing.centre for thing in things])
    order = np.argsort(centres[:, np.argmax(np.ptp(centres, 0))], kind="stable")
    half = len(things) // 2
    return [group for part in (order[:half], order[half:]) for group in _neighbours([things[j] for j in part])]


def moving_groups(things: Sequence[Sphere | Plate], opening: float,
                  data: Callable[[list[Sphere], list[Plate]], tuple[np.ndarray, int]]) -> np.ndarray:
    """All of these things that move, in groups: HEAD, then what `data` makes of a group's spheres and plates.

    data also tells how many of its numbers are of spheres. opening: seconds at TIME 0.
    """
    groups: dict[tuple, list[Sphere | Plate]] = {}
    for thing in things:
        turning = any(thing.spin) and (thing.centre if thing.pivot is None else thing.pivot)
        groups.setdefault((thing.velocity, thing.spin, turning), []).append(displaced(thing, opening))
    packed = [np.zeros(0)]
    for which, alike in enumerate(groups.values()):
        for group in _neighbours(alike):
            balls = [thing for thing in group if isinstance(thing, Sphere)]
            numbers, of_balls = data(balls, [thing for thing in group if not isinstance(thing, Sphere)])
            packed.append(np.concatenate([[HEAD + numbers.size, of_balls, which], motion_parameters(group, opening),
                                          numbers]))
    return np.concatenate(packed)


def moving_parameters(things: Sequence[Sphere | Plate], opening: float) -> np.ndarray:
    """What the stage `moving` reads."""
    def both(balls: list[Sphere], flat: list[Plate]) -> tuple[np.ndarray, int]:
        round_ones = sphere_parameters(balls) if balls else np.zeros(0)
        return np.concatenate([round_ones, plate_parameters(flat) if flat else np.zeros(0)]), round_ones.size
    return moving_groups(things, opening, both)


@njit(inline="always")
def motion_of(p, s):
    """The numbers of a motion, from p[s] on, without its sphere."""
    return (p[s], p[s + 1], p[s + 2], p[s + 3], p[s + 4], p[s + 5], p[s + 6], p[s + 7], p[s + 8], p[s + 9], p[s + 10])


@njit(inline="always")
def rotated(sine, versine, ax, ay, az, x, y, z):
    """A vector turned about a unit axis (Rodrigues)."""
    along = ax * x + ay * y + az * z
    return (x + sine * (ay * z - az * y) + versine * (ax * along - x),
            y + sine * (az * x - ax * z) + versine * (ay * along - y),
            z + sine * (ax * y - ay * x) + versine * (az * along - z))


@njit(inline="always")
def swept_bounds(real, p, s, early, late):
    """Where what moves by p[s …] is from `early` to `late`: the middle of its sphere half way, and how far it reaches.

    Then half of the way that its velocity brings it (3).
    """
    px, py, pz, vx, vy, vz, ax, ay, az, rate, first = motion_of(p, s)
    middle, half = (early + late) * real(0.5), (late - early) * real(0.5)
    sine, versine = sine_versine(real, rate * middle + first)
    cx, cy, cz = p[s + 11] - px, p[s + 12] - py, p[s + 13] - pz
    qx, qy, qz = rotated(sine, versine, ax, ay, az, cx, cy, cz)
    swing = half * rate * real(2 * math.pi) * math.sqrt(cx * cx + cy * cy + cz * cz)
    return (qx + px + vx * middle, qy + py + vy * middle, qz + pz + vz * middle, p[s + 14] + swing,
            half * vx, half * vy, half * vz)


@njit(inline="always")
def to_rest_frame(real, motion, t, x, y, z, dx, dy, dz):
    """A point and a direction of the world at the time t in the frame where the group rests."""
    px, py, pz, vx, vy, vz, ax, ay, az, rate, first = motion
    s, v = sine_versine(real, rate * t + first)
    qx, qy, qz = rotated(-s, v, ax, ay, az, x - (px + vx * t), y - (py + vy * t), z - (pz + vz * t))
    ex, ey, ez = rotated(-s, v, ax, ay, az, dx, dy, dz)
    return qx + px, qy + py, qz + pz, ex, ey, ez


@njit(inline="always")
def to_world_frame(real, motion, t, x, y, z, dx, dy, dz):
    """A point and a direction of the frame where the group rests in the world at the time t."""
    px, py, pz, vx, vy, vz, ax, ay, az, rate, first = motion
    s, v = sine_versine(real, rate * t + first)
    qx, qy, qz = rotated(s, v, ax, ay, az, x - px, y - py, z - pz)
    ex, ey, ez = rotated(s, v, ax, ay, az, dx, dy, dz)
    return qx + (px + vx * t), qy + (py + vy * t), qz + (pz + vz * t), ex, ey, ez


@stage
def time_bounds(lanes):
    """The earliest and the latest TIME of the block, and as much more as these are known: s."""
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
def moving(lanes, p, key):
    """Offer the things that move where they are nearer, after `beam`.  p: moving_parameters."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, dx, dy, dz, time = row[X], row[Y], row[Z], row[L], row[M], row[N], row[TIME]
    depth = row[DEPTH]
    hx, hy, hz, ex, ey, ez, near, seen = row[H0], row[H1], row[H2], row[H3], row[H4], row[H5], row[H6], row[H7]
    early, late = time_bounds(lanes)
    for i in range(B):
        hx[i], hy[i], hz[i], ex[i], ey[i], ez[i] = x[i], y[i], z[i], dx[i], dy[i], dz[i]
        seen[i] = row[BEAM][i]
    s, last, current = 0, 0, real(-1)
    while s < p.size:
        size, balls, which, here = int(p[s]), int(p[s + 1]), p[s + 2], s + 3
        first, end = s + HEAD, s + size
        cx, cy, cz, wide, wx, wy, wz = swept_bounds(real, p, here, early, late)
        s += size
        if beam_misses(seen, cx, cy, cz, wide + abs(wx * seen[4] + wy * seen[5] + wz * seen[6]),
                   wide + abs(wx * seen[7] + wy * seen[8] + wz * seen[9]), wide + abs(wx * seen[10] + wz * seen[12])):
            continue
        if which != current:
            if current >= real(0):
                _normals(lanes, p, last)
            motion = motion_of(p, here)
            for i in range(B):
                x[i], y[i], z[i], dx[i], dy[i], dz[i] = to_rest_frame(real, motion, time[i], hx[i], hy[i], hz[i],
                                                                ex[i], ey[i], ez[i])
                near[i] = depth[i]
            beam(lanes, p, key)
            last, current = here, which
        if balls > 0:
            spheres(lanes, p[first:first + balls], key)
        if first + balls < end:
            plates(lanes, p[first + balls:end], key)
    if current >= real(0):
        _normals(lanes, p, last)
    for i in range(B):
        x[i], y[i], z[i], dx[i], dy[i], dz[i] = hx[i], hy[i], hz[i], ex[i], ey[i], ez[i]


@stage
def _normals(lanes, p, s):
    """Where something nearer than H6 has been met by the motion p[s …], its normal is turned into the world."""
    real = lanes.dtype.type
    row = rows(lanes)
    time, depth, near, nx, ny, nz = row[TIME], row[DEPTH], row[H6], row[NX], row[NY], row[NZ]
    motion = motion_of(p, s)
    many = np.int32(0)
    for i in range(B):
        many = np.int32(many + np.int32(depth[i] < near[i]))
    if many == 0:
        return
    for i in range(B):
        _, _, _, ux, uy, uz = to_world_frame(real, motion, time[i], real(0), real(0), real(0), nx[i], ny[i], nz[i])
        hit = depth[i] < near[i]
        nx[i], ny[i], nz[i] = ux if hit else nx[i], uy if hit else ny[i], uz if hit else nz[i]
