"""Where light from a point has to cross a plane before a lens to reach the film: a rectangle for each point.

The plane goes through an axis point before the lens, square to the direction of the
light; its first axis lies in the plane through the light and the axis. What passes
is looked for on a grid of rays, then ever more finely in the rectangle about what was
found, or about the ray that came nearest to passing. Camera frame, mm.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from lensbench.cameras.film_landing import FilmLanding
from lensbench.kernels.block import CLEARANCE, KEYS, PITCH, WEIGHT, B, L, M, N, X, Y, Z, lane_buffer
from lensbench.kernels.program import Program, run_steps

ACROSS = 16                 # rays along the first axis; B / ACROSS along the other
DOWN = B // ACROSS
LOOKS = 6                   # at the most
ENOUGH = 0.6                # part of the rays in the rectangle that pass, above which it is not looked at any closer
EDGE = 2 * (ACROSS + DOWN) - 4                      # cells along the edge of the rectangle
DISPLACED = np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
WIDENED, WIDER = 8, 0.06    # how often a rectangle is widened, and by what part of its half-axes
SAME = 0.06                 # difference of two directions that may share a rectangle
HEAD_ON = 0.02              # least cosine of the light's angle from the axis


class EntranceBounds(NamedTuple):
    """Of n points: rectangles on the planes before the lens."""

    middles: np.ndarray         # (n, 3)
    axes: np.ndarray            # (n, 2, 3) half-axes
    towards: np.ndarray         # (n, 3) unit, from the lens to the point
    passing: np.ndarray         # (n,) part of the rays through the rectangle that pass; 0: none, or not known
    best: np.ndarray            # (n, 3) the point of the plane whose ray passes with most to spare


@njit(nogil=True, cache=True, error_model="numpy")
def _set(lanes, i, u, v, e, front, px, py, pz):
    """Lane i: the ray from a point P through the place u, v of the plane."""
    x, y, z = u * e[0, 0] + v * e[1, 0], u * e[0, 1] + v * e[1, 1], u * e[0, 2] + v * e[1, 2] + front
    l, m, n = x - px, y - py, z - pz
    size = 1.0 / math.sqrt(l * l + m * m + n * n)
    lanes[X * PITCH + i], lanes[Y * PITCH + i], lanes[Z * PITCH + i] = x, y, z
    lanes[L * PITCH + i], lanes[M * PITCH + i], lanes[N * PITCH + i] = l * size, m * size, n * size
    lanes[WEIGHT * PITCH + i] = 1.0


@njit(nogil=True, cache=True, error_model="numpy")
def _place(i, middle, half, cells):
    """The middle of a cell."""
    return middle + half * (2.0 * (i + 0.5) / cells - 1.0)


@njit(nogil=True, cache=True, error_model="numpy")
def _look(points, radii, front, frames, boxes, passing, best, lanes, code, gated, data, ends):
    """Narrow the boxes (n, 4: middle and half of each axis) down to what passes from the points (n, 3).

    Then widen them for spheres about the points, until none of five of their points brings light through the
    outermost cells.
    """
    key = np.zeros(KEYS, np.uint32)
    edge_a, edge_b = np.empty(EDGE, np.int64), np.empty(EDGE, np.int64)
    n = 0
    for i in range(B):
        a, b = i % ACROSS, i // ACROSS
        if a == 0 or a == ACROSS - 1 or b == 0 or b == DOWN - 1:
            edge_a[n], edge_b[n] = a, b
            n += 1
    for j in range(len(points)):
        u0, v0, hu, hv = boxes[j, 0], boxes[j, 1], boxes[j, 2], boxes[j, 3]
        e, px, py, pz = frames[j], points[j, 0], points[j, 1], points[j, 2]
        for _ in range(LOOKS):
            for i in range(B):
                _set(lanes, i, _place(i % ACROSS, u0, hu, ACROSS), _place(i // ACROSS, v0, hv, DOWN), e, front,
                     px, py, pz)
            run_steps(lanes, code, gated, data, ends, key)
            # the cells that pass, and the one that comes nearest to it
            count, a0, a1, b0, b1 = 0, ACROSS, -1, DOWN, -1
            least, nearest = np.inf, -1
            for i in range(B):
                margin = lanes[CLEARANCE * PITCH + i]
                if margin < least:
                    least, nearest = margin, i
                if lanes[WEIGHT * PITCH + i] > 0.0:
                    count += 1
                    a, b = i % ACROSS, i // ACROSS
                    a0, a1, b0, b1 = min(a0, a), max(a1, a), min(b0, b), max(b1, b)
            passing[j] = count / B
            if nearest < 0:
                break
            best[j, 0], best[j, 1] = _place(nearest % ACROSS, u0, hu, ACROSS), _place(nearest // ACROSS, v0, hv, DOWN)
            if count > ENOUGH * B:
                break
            if count == 0:
                a0, a1, b0, b1 = nearest % ACROSS, nearest % ACROSS, nearest // ACROSS, nearest // ACROSS
            # out to where the neighbours were seen not to pass
            narrow, low = _place(a0 - 1, u0, hu, ACROSS), _place(b0 - 1, v0, hv, DOWN)
            wide, high = _place(a1 + 1, u0, hu, ACROSS), _place(b1 + 1, v0, hv, DOWN)
            shrunk = (wide - narrow) * (high - low) / (4.0 * hu * hv)
            passing[j] /= shrunk
            u0, v0, hu, hv = 0.5 * (narrow + wide), 0.5 * (low + high), 0.5 * (wide - narrow), 0.5 * (high - low)
            if count > 0 and shrunk > 0.85:
                break
        if passing[j] == 0.0:
            continue
        size = hu * hv
        for _ in range(WIDENED):
            for i in range(B):
                k = min(i // EDGE, 4)
                along, up = radii[j] * DISPLACED[k, 0], radii[j] * DISPLACED[k, 1]
                u, v = _place(edge_a[i % EDGE], u0, hu, ACROSS), _place(edge_b[i % EDGE], v0, hv, DOWN)
                _set(lanes, i, u, v, e, front,
                     px + along * e[0, 0] + up * e[1, 0], py + along * e[0, 1] + up * e[1, 1],
                     pz + along * e[0, 2] + up * e[1, 2])
            run_steps(lanes, code, gated, data, ends, key)
            left, right, low, high = 0.0, 0.0, 0.0, 0.0
            for i in range(B):
                if lanes[WEIGHT * PITCH + i] > 0.0:
                    a, b = edge_a[i % EDGE], edge_b[i % EDGE]
                    left, right = 1.0 if a == 0 else left, 1.0 if a == ACROSS - 1 else right
                    low, high = 1.0 if b == 0 else low, 1.0 if b == DOWN - 1 else high
            if left + right + low + high == 0.0:
                break
            u0, hu = u0 + WIDER * hu * (right - left), hu * (1.0 + WIDER * (left + right))
            v0, hv = v0 + WIDER * hv * (high - low), hv * (1.0 + WIDER * (low + high))
        passing[j] *= size / (hu * hv)
        boxes[j, 0], boxes[j, 1], boxes[j, 2], boxes[j, 3] = u0, v0, hu, hv


def entrance_bounds(way: FilmLanding, points: np.ndarray, radii: np.ndarray, real=np.float32) -> EntranceBounds:
    """The rectangles for light from spheres of these radii (n,) about points (n, 3) of the camera frame, mm."""
    n = len(points)
    towards = points - [0.0, 0.0, way.front]
    away = np.sqrt((towards**2).sum(1))
    towards = towards / away[:, None]
    across = np.hypot(towards[:, 0], towards[:, 1])
    sideways = np.stack([-towards[:, 1], towards[:, 0], np.zeros(n)], 1) / np.maximum(across, 1e-9)[:, None]
    sideways[across < 1e-9] = [0.0, 1.0, 0.0]
    frames = np.stack([np.cross(sideways, towards), sideways], 1)
    passing, best = np.zeros(n), np.zeros((n, 2))
    boxes = np.zeros((n, 4))
    boxes[:, 2:] = way.radius
    if way.radius > 0.0:
        program = Program(way.bounding, real)
        _look(points, radii, way.front, frames, boxes, passing, best, lane_buffer(real), program.code, program.gated,
              program.data, program.ends)
    else:
        passing[:] = 1.0
        towards, frames = np.tile([0.0, 0.0, -1.0], (n, 1)), np.tile([[1.0, 0, 0], [0, 1.0, 0]], (n, 1, 1))
    passing[~is_boundable(way, points, radii)] = 0.0
    start = np.array([0.0, 0.0, way.front])
    return EntranceBounds(start + np.einsum("ni,nij->nj", boxes[:, :2], frames), boxes[:, 2:, None] * frames,
                          towards, passing, start + np.einsum("ni,nij->nj", best, frames))


def shared_entrance_bounds(way: FilmLanding, points: np.ndarray, radii: np.ndarray, real=np.float32) -> EntranceBounds:
    """As `fronts`, but points that lie nearly in the same direction share a rectangle that is wide enough for all."""
    if way.radius == 0.0 or len(points) < 2:
        return entrance_bounds(way, points, radii, real)
    ahead = points - [0.0, 0.0, way.front]
    away = np.sqrt((ahead**2).sum(1))
    ahead = ahead / away[:, None]
    cells = np.column_stack([np.floor(ahead / SAME), np.floor(np.log2(away)), radii > 0.5 * SAME * away]).astype(int)
    _, group, size = np.unique(cells, axis=0, return_inverse=True, return_counts=True)
    group = group.reshape(-1)
    middle: np.ndarray = np.stack([np.bincount(group, part) for part in ahead.T], 1)
    middle = middle / np.sqrt((middle**2).sum(1))[:, None]
    far: np.ndarray = np.bincount(group, away) / size
    # At the distance of their mean: each with its radius, and as much as its own distance changes its rays' directions
    ratio = far[group] / away
    wide = np.sqrt(((ahead - middle[group])**2).sum(1)) * far[group] + radii * ratio + way.radius * abs(1.0 - ratio)
    reach = np.zeros(len(far))
    np.maximum.at(reach, group, wide)
    found = entrance_bounds(way, [0.0, 0.0, way.front] + middle * far[:, None], reach, real)
    found = EntranceBounds(*(values[group] for values in found))
    alone = np.nonzero(found.passing == 0.0)[0]         # of the middle; some of them may still be seen
    if alone.size:
        for values, own in zip(found, entrance_bounds(way, points[alone], radii[alone], real), strict=True):
            values[alone] = own
    return found


def is_boundable(way: FilmLanding, points: np.ndarray, radii) -> np.ndarray:
    """Whether rectangles for light from spheres about points (…, 3) can be found: they are before it, and not near."""
    ahead = points - [0.0, 0.0, way.front]
    away = np.sqrt((ahead**2).sum(-1))
    return (ahead[..., 2] <= -HEAD_ON * away) & (away >= 4.0 * (way.radius + radii))
