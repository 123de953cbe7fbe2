"""What a camera samples behind a lens without rotational symmetry: regions between the nodes of a grid.

A lens with a cylinder or toroid has two planes of symmetry: one quadrant of the film stands for all four. The
regions between the nodes of `film_grid` are interpolated; being a hair larger than need be, they lose no light. The
tracer kills what does not pass, and the weight holds the area of the very triangle sampled. Lens frame, mm.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lensbench.kernels.block import (
    A0,
    A1,
    A2,
    A3,
    A4,
    A5,
    A6,
    A7,
    A8,
    A9,
    A10,
    A11,
    ALIVE,
    LOST,
    U0,
    U1,
    WEIGHT,
    B,
    L,
    M,
    N,
    Step,
    X,
    Y,
    Z,
    gather,
    rows,
    stage,
)
from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens
from lensbench.pupils.film_grid import COLUMNS, EDGES, RINGS, SECTORS, Nodes, course_at, course_terms, solve_nodes

ROUNDING = 1e-5                 # by which a place in the film's corner may seem to lie beyond it in float32


@dataclass(frozen=True, eq=False)
class PupilGrid:
    """The regions all over a film of these half sides, for a camera with its film at film_distance to sample (mm)."""

    film_distance: float
    half_width: float
    half_height: float
    nodes: Nodes

    @classmethod
    def of(cls, lens: Lens, film_distance: float, half_width: float, half_height: float,
           wavelength: float = D_LINE) -> "PupilGrid":
        """Solve the grid for film points up to half_width and half_height (mm) from the axis."""
        half_width, half_height = max(half_width, 1e-30), max(half_height, 1e-30)
        nodes = solve_nodes(lens, film_distance, np.array([half_width, half_height]), wavelength)
        return cls(film_distance, half_width, half_height, nodes)

    @classmethod
    def interpolated(cls, grids: Sequence["PupilGrid"], shares: Sequence[float]) -> "PupilGrid":
        """The grid between `grids` of one film and crowding, by their shares (sum 1)."""
        first = grids[0]
        edge, course, centres, outline = (
            np.tensordot(shares, np.stack([getattr(grid.nodes, name) for grid in grids]), 1)
            for name in ("edge", "course", "centres", "outline"))
        return cls(first.film_distance, first.half_width, first.half_height,
                   Nodes(edge, first.nodes.crowding, course, centres, outline))

    def sampled_area(self, film_xy: np.ndarray, rear_xy: np.ndarray) -> np.ndarray:
        """Over what area (n,) in mm² the samples of film points (n, 2) are spread, as densely as at rear points (n, 2).

        That of the triangle there times their number; 0 where no sample goes.
        """
        nodes = self.nodes
        # The corners of each film point's triangles, and where it aims, both from the region's centre
        u, v = (np.abs(film_xy) / [self.half_width, self.half_height]).T
        column = np.divide(v, u + v, out=np.zeros_like(v), where=u + v > 0.0)
        distance = np.hypot(u, v) / np.interp(column, np.linspace(0.0, 1.0, EDGES), nodes.edge)
        ring = 1.0 - np.sqrt(1.0 - nodes.crowding * np.minimum(distance, 1.0))
        ring /= 1.0 - math.sqrt(1.0 - nodes.crowding)
        cells = np.stack([np.minimum(ring * (RINGS - 1), RINGS - 1.001),
                          np.minimum(column * (COLUMNS - 1), COLUMNS - 1.001)], 1)
        i, f = cells.astype(int), cells % 1.0
        corners, centre = np.zeros((len(i), SECTORS + 1, 2)), np.zeros((len(i), 2))
        for x in (0, 1):
            for y in (0, 1):
                share = np.abs(1 - x - f[:, 0]) * np.abs(1 - y - f[:, 1])
                corners += share[:, None, None] * nodes.outline[i[:, 0] + x, i[:, 1] + y]
                centre += share[:, None] * nodes.centres[i[:, 0] + x, i[:, 1] + y]
        centre += course_at(nodes.course, course_terms(np.stack([u, v], 1)))
        at = rear_xy * np.where(film_xy < 0.0, -1.0, 1.0) - centre
        # The last corner that it lies beyond, counter-clockwise
        turn = np.unwrap(np.arctan2(corners[..., 1], corners[..., 0]))
        angle = turn[:, 0] + (np.arctan2(at[:, 1], at[:, 0]) - turn[:, 0]) % (2.0 * math.pi)
        k = np.clip((turn <= angle[:, None]).sum(1) - 1, 0, SECTORS - 1)
        (ax, ay), (bx, by) = corners[np.arange(len(k)), k].T, corners[np.arange(len(k)), k + 1].T
        twice = ax * by - bx * ay
        within = (at[:, 0] * (by - ay) - at[:, 1] * (bx - ax) <= twice) & (distance <= 1.0 + ROUNDING)
        return np.where(within, 0.5 * SECTORS * np.maximum(twice, 0.0), 0.0)

    def step(self, normaliser: float) -> Step:
        """The step that aims from the film into the region; WEIGHT becomes cos⁴ · area / normaliser."""
        nodes = self.nodes
        apart = (RINGS - 1) / (1.0 - math.sqrt(1.0 - nodes.crowding))
        head = [self.film_distance, 1.0 / self.half_width, 1.0 / self.half_height, nodes.crowding, apart,
                1.0 / normaliser, *nodes.course.ravel(), *nodes.edge]
        tables = [nodes.outline[..., 0], nodes.outline[..., 1], nodes.centres[..., 0], nodes.centres[..., 1]]
        return Step(aim_in_quadrant, np.concatenate([head, *(table.ravel() for table in tables)]))


_HEAD, _CORNERS, _NODES = 26, SECTORS + 1, RINGS * COLUMNS
_Y, _CENTRE_X, _CENTRE_Y = _NODES * _CORNERS, 2 * _NODES * _CORNERS, _NODES * (2 * _CORNERS + 1)


@stage
def aim_in_quadrant(lanes, p, key):
    """From a film point X, Y (mm, Z = 0) aim into the region that it sees: L, M, N and WEIGHT.

    p: film distance, 1 / half the film's width and height, crowding, rings per 1 − √, 1 / normaliser, the course, the
    edge, then the table: x and y of every corner, x and y of the centres. The film point is mirrored into the first
    quadrant, its region interpolated between four nodes, and the ray mirrored back.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, v, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[U1], row[WEIGHT]
    node, right, up, turn, corner, found = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    ax, ay, bx, by, centre_x, centre_y = row[A6], row[A7], row[A8], row[A9], row[A10], row[A11]
    at, share = row[L], row[M]
    distance, gain = p[0], p[5]
    table = p[_HEAD + EDGES:]
    _find_cell(lanes, p)
    for k in range(4):
        beside, above = real(k % 2), real(k // 2)
        for i in range(B):
            f, g = right[i], up[i]
            f, g = beside * f + (real(1) - beside) * (real(1) - f), above * g + (real(1) - above) * (real(1) - g)
            share[i] = f * g
            at[i] = node[i] + beside + above * real(COLUMNS)
            corner[i] = at[i] * real(_CORNERS) + np.floor(turn[i])
        gather(found, table, corner)
        for i in range(B):
            ax[i] += share[i] * found[i]
        gather(found, table[1:], corner)
        for i in range(B):
            bx[i] += share[i] * found[i]
        gather(found, table[_Y:], corner)
        for i in range(B):
            ay[i] += share[i] * found[i]
        gather(found, table[_Y + 1:], corner)
        for i in range(B):
            by[i] += share[i] * found[i]
        gather(found, table[_CENTRE_X:], at)
        for i in range(B):
            centre_x[i] += share[i] * found[i]
        gather(found, table[_CENTRE_Y:], at)
        for i in range(B):
            centre_y[i] += share[i] * found[i]
    for i in range(B):
        g = turn[i] - np.floor(turn[i])
        h = real(1) - g
        reach = math.sqrt(v[i])
        dx = centre_x[i] + reach * (h * ax[i] + g * bx[i]) - abs(x[i])
        dy = centre_y[i] + reach * (h * ay[i] + g * by[i]) - abs(y[i])
        size = real(1) / math.sqrt(dx * dx + dy * dy + distance * distance)
        l[i], m[i] = (dx if x[i] >= real(0) else -dx) * size, (dy if y[i] >= real(0) else -dy) * size
        n[i] = -distance * size
        c2 = distance * size
        c2 = c2 * c2
        area = real(0.5) * (ax[i] * by[i] - bx[i] * ay[i])
        weight[i] *= gain * c2 * c2 * real(SECTORS) * (area if area > real(0) else real(0))
        z[i] = real(0)
    alive = np.int32(0)
    for i in range(B):
        alive += np.int32(1) if weight[i] > real(0) else np.int32(0)
    if alive == 0:
        key[ALIVE] = np.uint32(LOST)


@stage
def _find_cell(lanes, p):
    """A0 the node before the film point, A1 and A2 the way on from it in column and ring, A3 triangle and place in it.

    WEIGHT is 0 beyond the edge of light and else 1; A6 to A9 are cleared, A10 and A11 begin with the course.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, u, weight = row[X], row[Y], row[U0], row[WEIGHT]
    node, right, up, turn, place, near, far = row[A0], row[A1], row[A2], row[A3], row[A4], row[A6], row[A8]
    ax, ay, bx, by, centre_x, centre_y = row[A6], row[A7], row[A8], row[A9], row[A10], row[A11]
    across, along, crowding, apart = p[1], p[2], p[3], p[4]
    edge = p[_HEAD:_HEAD + EDGES]
    last_edge, last_ring, last_column = real(EDGES - 1.001), real(RINGS - 1.001), real(COLUMNS - 1.001)
    for i in range(B):
        s, t = abs(x[i]) * across, abs(y[i]) * along
        both = s + t
        up[i] = t / (both if both > real(0) else real(1))
        right[i] = math.sqrt(s * s + t * t)
        t = up[i] * real(EDGES - 1)
        t = t if t < last_edge else last_edge
        place[i], turn[i] = np.floor(t), t - np.floor(t)
    gather(near, edge, place)
    gather(far, edge[1:], place)
    for i in range(B):
        s = right[i] / (near[i] + turn[i] * (far[i] - near[i]))
        weight[i] = real(1) if s <= real(1 + ROUNDING) else real(0)
        s = s if s < real(1) else real(1)
        s, t = (real(1) - math.sqrt(real(1) - crowding * s)) * apart, up[i] * real(COLUMNS - 1)
        s, t = s if s < last_ring else last_ring, t if t < last_column else last_column
        node[i] = np.floor(s) * real(COLUMNS) + np.floor(t)
        right[i], up[i], turn[i] = t - np.floor(t), s - np.floor(s), u[i] * real(SECTORS)
        ax[i], ay[i], bx[i], by[i] = real(0), real(0), real(0), real(0)
    for i in range(B):
        e, f = abs(x[i]) * across, abs(y[i]) * along
        s, t = e * e, f * f
        centre_x[i] = e * (p[6] + s * (p[7] + s * (p[9] + s * p[12]) + t * (p[10] + s * p[13] + t * p[14]))
                           + t * (p[8] + t * (p[11] + t * p[15])))
        centre_y[i] = f * (p[16] + s * (p[17] + s * (p[19] + s * p[22]) + t * (p[20] + s * p[23] + t * p[24]))
                           + t * (p[18] + t * (p[21] + t * p[25])))
