"""Entrance bounds: where light from a point must cross the entrance plane of a lens to reach the film.

Each point has a rectangle on a plane through a point before the lens, perpendicular to the direction of the
light; the first axis of the rectangle lies in the plane through the light and the optical axis. The search traces a
grid of rays, then ever finer grids in the rectangle about the rays that passed, or about the ray that
came nearest to passing. Camera frame, mm.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from lensbench.core.cameras.film_landing import FilmLanding
from lensbench.core.kernels.block import CLEARANCE, KEYS, PITCH, WEIGHT, B, L, M, N, X, Y, Z, lane_buffer
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.program import Program, raise_pending, run_steps

COLUMNS = 16                # rays along the first axis
ROWS = B // COLUMNS         # and along the second
MOST_GRIDS = 6              # for one point
ENOUGH = 0.6                # share of the rays in the rectangle that pass, above which it is not narrowed any further
STEADY = 0.85               # share of its area that the rectangle keeps, above which it is not narrowed any further
RIM = 2 * (COLUMNS + ROWS) - 4                      # cells along the rim of the rectangle
SAMPLES = np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])     # of a sphere, in its radii
MOST_WIDENINGS, WIDENING = 8, 0.06      # how often a rectangle is widened, and by what part of its half-axes
SAME_DIRECTION = 0.06       # difference of two unit directions that may share a rectangle
LEAST_COSINE = 0.02         # of the light's angle from the axis
LEAST_DISTANCE = 4.0        # of a light, in units of its own radius and the lens's


class EntranceBounds(NamedTuple):
    """Rectangles on the entrance planes of n points."""

    middles: np.ndarray         # (n, 3)
    axes: np.ndarray            # (n, 2, 3) half-axes
    towards: np.ndarray         # (n, 3) unit, from the lens to the point
    passing: np.ndarray         # (n,) share of the rays through the rectangle that pass; 0: none, or unknown
    best: np.ndarray            # (n, 3) the point of the plane whose ray passes with the most clearance


@njit(nogil=True, cache=True, error_model="numpy")
def _set_ray(lanes, i, u, v, frame, front, px, py, pz):
    """Set lane i to the ray from a point P through the place (u, v) of its entrance plane."""
    x = u * frame[0, 0] + v * frame[1, 0] + front[0]
    y = u * frame[0, 1] + v * frame[1, 1] + front[1]
    z = u * frame[0, 2] + v * frame[1, 2] + front[2]
    l, m, n = x - px, y - py, z - pz
    size = 1.0 / math.sqrt(l * l + m * m + n * n)
    lanes[X * PITCH + i], lanes[Y * PITCH + i], lanes[Z * PITCH + i] = x, y, z
    lanes[L * PITCH + i], lanes[M * PITCH + i], lanes[N * PITCH + i] = l * size, m * size, n * size
    lanes[WEIGHT * PITCH + i] = 1.0


@njit(nogil=True, cache=True, error_model="numpy")
def _cell(i, middle, half, cells):
    """The middle of cell i of an axis."""
    return middle + half * (2.0 * (i + 0.5) / cells - 1.0)


@njit(nogil=True, cache=True, error_model="numpy")
def _find_bounds(points, radii, front, frames, boxes, passing, best, lanes, code):
    """Narrow the boxes (n, 4: middles, then halves of both axes) to the rays from points (n, 3) that pass.

    Then widen them for spheres about the points.
    """
    key = np.zeros(KEYS, np.uint32)
    rim_a, rim_b = np.empty(RIM, np.int64), np.empty(RIM, np.int64)
    n = 0
    for i in range(B):
        a, b = i % COLUMNS, i // COLUMNS
        if a == 0 or a == COLUMNS - 1 or b == 0 or b == ROWS - 1:
            rim_a[n], rim_b[n] = a, b
            n += 1
    for j in range(len(points)):
        passing[j] = _narrow(points[j], front, frames[j], boxes[j], best[j], lanes, code, key)
        if passing[j] == 0.0:
            continue
        size = boxes[j, 2] * boxes[j, 3]
        _widen(points[j], radii[j], front, frames[j], boxes[j], rim_a, rim_b, lanes, code, key)
        passing[j] *= size / (boxes[j, 2] * boxes[j, 3])


@njit(nogil=True, cache=True, error_model="numpy")
def _narrow(point, front, frame, box, best, lanes, code, key):
    """Narrow a box to the rays from a point that pass; returns the share of the rays through the box that pass."""
    u0, v0, hu, hv = box[0], box[1], box[2], box[3]
    passing = 0.0
    for _ in range(MOST_GRIDS):
        # Trace a grid of rays
        for i in range(B):
            _set_ray(lanes, i, _cell(i % COLUMNS, u0, hu, COLUMNS), _cell(i // COLUMNS, v0, hv, ROWS), frame, front,
                     point[0], point[1], point[2])
        run_steps(lanes, code, key)

        # Find the cells that pass, and the one that comes nearest to passing
        count, a0, a1, b0, b1 = 0, COLUMNS, -1, ROWS, -1
        least, nearest = np.inf, -1
        for i in range(B):
            clearance = lanes[CLEARANCE * PITCH + i]
            if clearance < least:
                least, nearest = clearance, i
            if lanes[WEIGHT * PITCH + i] > 0.0:
                count += 1
                a, b = i % COLUMNS, i // COLUMNS
                a0, a1, b0, b1 = min(a0, a), max(a1, a), min(b0, b), max(b1, b)
        passing = count / B
        if nearest < 0:
            break
        best[0] = _cell(nearest % COLUMNS, u0, hu, COLUMNS)
        best[1] = _cell(nearest // COLUMNS, v0, hv, ROWS)
        if count > ENOUGH * B:
            break
        if count == 0:
            a0, a1, b0, b1 = nearest % COLUMNS, nearest % COLUMNS, nearest // COLUMNS, nearest // COLUMNS

        # Narrow the box to these, out to the neighbours that do not pass
        left, low = _cell(a0 - 1, u0, hu, COLUMNS), _cell(b0 - 1, v0, hv, ROWS)
        right, high = _cell(a1 + 1, u0, hu, COLUMNS), _cell(b1 + 1, v0, hv, ROWS)
        shrunk = (right - left) * (high - low) / (4.0 * hu * hv)
        passing /= shrunk
        u0, v0, hu, hv = 0.5 * (left + right), 0.5 * (low + high), 0.5 * (right - left), 0.5 * (high - low)
        if count > 0 and shrunk > STEADY:
            break
    box[0], box[1], box[2], box[3] = u0, v0, hu, hv
    return passing


@njit(nogil=True, cache=True, error_model="numpy")
def _widen(point, radius, front, frame, box, rim_a, rim_b, lanes, code, key):
    """Widen a box until no ray from the SAMPLES of a sphere about the point passes through the cells of its rim."""
    u0, v0, hu, hv = box[0], box[1], box[2], box[3]
    for _ in range(MOST_WIDENINGS):
        for i in range(B):
            k = min(i // RIM, 4)
            a, b = radius * SAMPLES[k, 0], radius * SAMPLES[k, 1]
            u, v = _cell(rim_a[i % RIM], u0, hu, COLUMNS), _cell(rim_b[i % RIM], v0, hv, ROWS)
            _set_ray(lanes, i, u, v, frame, front,
                     point[0] + a * frame[0, 0] + b * frame[1, 0], point[1] + a * frame[0, 1] + b * frame[1, 1],
                     point[2] + a * frame[0, 2] + b * frame[1, 2])
        run_steps(lanes, code, key)
        left, right, low, high = 0.0, 0.0, 0.0, 0.0
        for i in range(B):
            if lanes[WEIGHT * PITCH + i] > 0.0:
                a, b = rim_a[i % RIM], rim_b[i % RIM]
                left, right = 1.0 if a == 0 else left, 1.0 if a == COLUMNS - 1 else right
                low, high = 1.0 if b == 0 else low, 1.0 if b == ROWS - 1 else high
        if left + right + low + high == 0.0:
            break
        u0, hu = u0 + WIDENING * hu * (right - left), hu * (1.0 + WIDENING * (left + right))
        v0, hv = v0 + WIDENING * hv * (high - low), hv * (1.0 + WIDENING * (low + high))
    box[0], box[1], box[2], box[3] = u0, v0, hu, hv


def entrance_bounds(landing: FilmLanding, points: np.ndarray, radii: np.ndarray, real: Any = np.float32
                    ) -> EntranceBounds:
    """The rectangles for light from spheres of these radii (n,) about points (n, 3); camera frame, mm."""
    n = len(points)
    towards, _ = _directions(landing, points)
    across = np.hypot(towards[:, 0], towards[:, 1])
    sideways = np.stack([-towards[:, 1], towards[:, 0], np.zeros(n)], 1) / np.maximum(across, 1e-9)[:, None]
    sideways[across < 1e-9] = [0.0, 1.0, 0.0]
    frames = np.stack([np.cross(sideways, towards), sideways], 1)
    passing, best = np.zeros(n), np.zeros((n, 2))
    boxes = np.zeros((n, 4))
    boxes[:, 2:] = landing.radius
    if landing.radius > 0.0:
        program = Program(landing.bounding, real)
        _find_bounds(points, radii, np.array(landing.front), frames, boxes, passing, best, lane_buffer(real),
                     program.code)
        raise_pending()
    else:
        passing[:] = 1.0
        towards, frames = np.tile([0.0, 0.0, -1.0], (n, 1)), np.tile([[1.0, 0, 0], [0, 1.0, 0]], (n, 1, 1))
    passing[~is_boundable(landing, points, radii)] = 0.0
    start = np.array(landing.front)
    return EntranceBounds(start + np.einsum("ni,nij->nj", boxes[:, :2], frames), boxes[:, 2:, None] * frames,
                          towards, passing, start + np.einsum("ni,nij->nj", best, frames))


def shared_entrance_bounds(landing: FilmLanding, points: np.ndarray, radii: np.ndarray, real: Any = np.float32
                           ) -> EntranceBounds:
    """`entrance_bounds`, but points in nearly the same direction share a rectangle that is wide enough for all."""
    if landing.radius == 0.0 or len(points) < 2:
        return entrance_bounds(landing, points, radii, real)

    # Group the points by direction and distance
    ahead, away = _directions(landing, points)
    wide = radii > 0.5 * SAME_DIRECTION * away
    cells = np.column_stack([np.floor(ahead / SAME_DIRECTION), np.floor(np.log2(away)), wide]).astype(int)
    _, group, size = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    group = group.reshape(-1)

    # Enclose each group in a sphere at the mean distance: its points with their radii, and the
    # change of their rays' directions with their own distance
    middle: np.ndarray = np.stack([np.bincount(group, coordinate) for coordinate in ahead.T], 1)
    middle = middle / np.sqrt((middle**2).sum(1))[:, None]
    far: np.ndarray = np.bincount(group, away) / size
    ratio = far[group] / away
    needed = np.sqrt(((ahead - middle[group])**2).sum(1)) * far[group]
    needed = needed + radii * ratio + landing.radius * abs(1.0 - ratio)
    enclosing = np.zeros(len(far))
    with np.errstate(invalid="ignore"):                 # points that are nowhere have no sphere
        np.maximum.at(enclosing, group, needed)

    # Find the rectangle of each group; where its middle is dark, that of every point
    bounds = entrance_bounds(landing, landing.front + middle * far[:, None], enclosing, real)
    bounds = EntranceBounds(*(values[group] for values in bounds))
    alone = np.nonzero(bounds.passing == 0.0)[0]
    if alone.size:
        for values, own in zip(bounds, entrance_bounds(landing, points[alone], radii[alone], real), strict=True):
            values[alone] = own
    return bounds


def is_boundable(landing: FilmLanding, points: np.ndarray, radii: np.ndarray | float) -> np.ndarray:
    """Whether spheres about points (…, 3) have entrance bounds: they lie before the lens, and not near it."""
    towards = points - landing.front
    distance = np.sqrt((towards**2).sum(-1))
    return ((towards[..., 2] <= -LEAST_COSINE * distance)
            & (distance >= LEAST_DISTANCE * (landing.radius + radii)))


def _directions(landing: FilmLanding, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit directions (n, 3) and distances (n,) of points (n, 3) from the point before the lens."""
    towards = points - landing.front
    distance = np.sqrt((towards**2).sum(1))
    return towards / distance[:, None], distance
