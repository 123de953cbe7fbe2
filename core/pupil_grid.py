"""What a camera samples behind a lens without rotational symmetry: the regions of a grid of film points.

A lens with a cylinder or toroid has two planes of symmetry: one quadrant of the
film stands for all four. The regions of the grid's nodes are cut into triangles of
equal area, and those between are interpolated. They are made a hair larger than
need be at the nodes and between them, so that no light is lost; the tracer kills
what does not pass, and the weight holds the area of the very triangle sampled.
Lens frame, mm.
"""

import math
from dataclasses import dataclass

import numpy as np

from lensbench.glass import D_LINE
from lensbench.lanes import (
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
from lensbench.prescription import Lens
from lensbench.pupil_outline import solve_outlines
from lensbench.pupil_rim import REACH

NODES, SECTORS = 15, 48         # film points each way in a quadrant, and triangles in a region
POINTS = 64                     # solved on each rim
FAR = 1.3                       # × what is interpolated: where a region ends at once, its neighbours say too little
SPREAD = 1.003                  # the sampled region over the true one where they are compared: it bulges between


@dataclass(frozen=True, eq=False)
class PupilGrid:
    """The regions of NODES × NODES film points in the quadrant x ≥ 0, y ≥ 0, each cut into SECTORS triangles.

    outline: (NODES, NODES, SECTORS + 1, 2) corners from the region's centre, counter-clockwise from the one in
    +x, at equal areas; centres: (NODES, NODES, 2). The first index is that of y. 0 where there is no light.
    """

    film_distance: float
    half_width: float               # of the film, mm
    half_height: float
    outline: np.ndarray
    centres: np.ndarray

    @classmethod
    def of(cls, lens: Lens, film_distance: float, half_width: float, half_height: float,
           wavelength: float = D_LINE) -> "PupilGrid":
        """Solve the grid for film points up to half_width and half_height (mm) from the axis."""
        tolerance = 2e-4 * REACH * min(lens.surfaces[-1].semi_diameter, lens.stop.semi_diameter)
        half_width, half_height = max(half_width, 1e-30), max(half_height, 1e-30)
        # Twice as fine as the table: what lies between its nodes says how much larger these must be
        fine = 2 * NODES - 1
        x, y = np.meshgrid(np.linspace(0.0, half_width, fine), np.linspace(0.0, half_height, fine))
        centres, rims = solve_outlines(lens, film_distance, np.stack([x.ravel(), y.ravel()], 1), POINTS, tolerance,
                                       wavelength)
        centres, rims = centres.reshape(fine, fine, 2), rims.reshape(fine, fine, POINTS, 2)
        at, outline = centres[::2, ::2].copy(), rims[::2, ::2].copy()
        _lend(centres, rims, np.asarray(~outline.any((2, 3))), at, outline)
        corners = _equal_areas(outline)
        wide = _needed(centres, rims, at, corners)
        _lend(centres, rims, wide.max(2) > FAR, at, outline)
        corners = _equal_areas(outline)
        wide = _needed(centres, rims, at, corners)
        return cls(film_distance, half_width, half_height, corners * (SPREAD * wide)[..., None], at)

    def area_at(self, film_xy: np.ndarray, rear_xy: np.ndarray) -> np.ndarray:
        """Over what area (n,) in mm² the samples of film points (n, 2) are spread, as densely as at rear points (n, 2).

        That of the triangle there times their number; 0 where the region is empty.
        """
        # The corners of each film point's triangles, and where it aims, both from the region's centre
        cells = np.minimum(np.abs(film_xy) * (NODES - 1) / [self.half_width, self.half_height], NODES - 1.001)
        i, f = cells.astype(int), cells % 1.0
        corners, centre = np.zeros((len(i), SECTORS + 1, 2)), np.zeros((len(i), 2))
        for x in (0, 1):
            for y in (0, 1):
                share = np.abs(1 - x - f[:, 0]) * np.abs(1 - y - f[:, 1])
                corners += share[:, None, None] * self.outline[i[:, 1] + y, i[:, 0] + x]
                centre += share[:, None] * self.centres[i[:, 1] + y, i[:, 0] + x]
        at = rear_xy * np.where(film_xy < 0.0, -1.0, 1.0) - centre
        # The last corner that it lies beyond, counter-clockwise
        turn = np.unwrap(np.arctan2(corners[..., 1], corners[..., 0]))
        angle = turn[:, 0] + (np.arctan2(at[:, 1], at[:, 0]) - turn[:, 0]) % (2.0 * math.pi)
        k = np.clip((turn <= angle[:, None]).sum(1) - 1, 0, SECTORS - 1)
        (ax, ay), (bx, by) = corners[np.arange(len(k)), k].T, corners[np.arange(len(k)), k + 1].T
        return 0.5 * SECTORS * np.maximum(ax * by - bx * ay, 0.0)

    def step(self, normaliser: float) -> Step:
        """The step that aims from the film into the region; WEIGHT becomes cos⁴ · area / normaliser."""
        head = [self.film_distance, (NODES - 1) / self.half_width, (NODES - 1) / self.half_height, 1.0 / normaliser]
        tables = [self.outline[..., 0], self.outline[..., 1], self.centres[..., 0], self.centres[..., 1]]
        return Step(aim_between, np.concatenate([head, *(table.ravel() for table in tables)]))


def _lend(centres: np.ndarray, rims: np.ndarray, which: np.ndarray, at: np.ndarray, outline: np.ndarray) -> None:
    """Give the nodes `which` the convex outline about all regions up to their neighbours; at, outline are changed."""
    lit = np.asarray(rims.any((2, 3)))
    for i, j in zip(*np.nonzero(which), strict=True):
        around = (slice(max(2 * i - 2, 0), 2 * i + 3), slice(max(2 * j - 2, 0), 2 * j + 3))
        if lit[around].any():
            points = (centres[around][:, :, None] + rims[around])[lit[around]].reshape(-1, 2)
            at[i, j] = 0.5 * (points.min(0) + points.max(0))
            outline[i, j] = _hull(points - at[i, j])


def _hull(points: np.ndarray) -> np.ndarray:
    """(POINTS, 2) at equal angles on the convex outline about points (p, 2), which holds 0, from the direction +x."""
    turn = 2.0 * math.pi * np.arange(POINTS) / POINTS
    normals = 2.0 * math.pi * np.arange(4 * POINTS) / (4 * POINTS)
    support = (points @ np.stack([np.cos(normals), np.sin(normals)])).max(0)
    facing = np.cos(turn[:, None] - normals)
    reach = np.where(facing > 1e-3, support / np.maximum(facing, 1e-3), np.inf).min(1)
    return np.stack([reach * np.cos(turn), reach * np.sin(turn)], 1)


def _equal_areas(outline: np.ndarray) -> np.ndarray:
    """(…, POINTS, 2) of closed rims → (…, SECTORS + 1, 2) corners at equal areas along the same chords."""
    closed = np.concatenate([outline, outline[..., :1, :]], -2)
    x, y = closed[..., 0], closed[..., 1]
    area = np.zeros(x.shape)
    area[..., 1:] = np.cumsum(x[..., :-1] * y[..., 1:] - x[..., 1:] * y[..., :-1], -1)
    corners = np.zeros((*outline.shape[:-2], SECTORS + 1, 2))
    for k in np.ndindex(outline.shape[:-2]):
        if area[k][-1] > 0.0:
            wanted = np.linspace(0.0, area[k][-1], SECTORS + 1)
            corners[k] = np.stack([np.interp(wanted, area[k], x[k]), np.interp(wanted, area[k], y[k])], 1)
    return corners


def _needed(centres: np.ndarray, rims: np.ndarray, at: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """By how much each corner is to be drawn out, that what lies between the nodes holds the finer grid's regions."""
    true = rims + (centres - _between(at))[:, :, None]
    polygon = _between(corners)
    # The chord of the polygon that each point of a rim looks through, and how far beyond it the point lies
    turn = np.unwrap(np.arctan2(polygon[..., 1], polygon[..., 0]))
    angle = turn[..., :1] + (np.arctan2(true[..., 1], true[..., 0]) - turn[..., :1]) % (2.0 * math.pi)
    chord = np.clip((turn[:, :, None, :] <= angle[..., None]).sum(-1) - 1, 0, SECTORS - 1)[..., None]
    a, b = np.take_along_axis(polygon, chord, 2), np.take_along_axis(polygon, chord + 1, 2)
    doubled = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    beyond = true[..., 0] * (b - a)[..., 1] - true[..., 1] * (b - a)[..., 0]
    needed = np.divide(beyond, doubled, out=np.ones_like(beyond), where=doubled > 0.0)
    factors = np.ones(polygon.shape[:3])
    i, j = np.ogrid[:len(factors), :len(factors)]
    for end in (0, 1):
        np.maximum.at(factors, (i[..., None], j[..., None], chord[..., 0] + end), needed)
    factors[..., 0] = factors[..., -1] = np.maximum(factors[..., 0], factors[..., -1])
    # A node's corner stands for all points that lie beside it
    padded = np.pad(factors, ((1, 1), (1, 1), (0, 0)), mode="edge")
    return np.max([padded[i:i + 2 * NODES - 1:2, j:j + 2 * NODES - 1:2] for i in range(3) for j in range(3)], 0)


def _between(nodes: np.ndarray) -> np.ndarray:
    """Values (NODES, NODES, …) → (2 NODES − 1, 2 NODES − 1, …), with the means between neighbours."""
    for axis in (0, 1):
        nodes = np.moveaxis(nodes, axis, 0)
        finer = np.empty((2 * len(nodes) - 1, *nodes.shape[1:]))
        finer[::2], finer[1::2] = nodes, 0.5 * (nodes[:-1] + nodes[1:])
        nodes = np.moveaxis(finer, 0, axis)
    return nodes


_CORNERS = SECTORS + 1
_Y, _CENTRE_X, _CENTRE_Y = NODES**2 * _CORNERS, 2 * NODES**2 * _CORNERS, NODES**2 * (2 * _CORNERS + 1)


@stage
def aim_between(lanes, p, key):
    """From a film point X, Y (mm, Z = 0) aim into the region that it sees: L, M, N and WEIGHT.

    p: film distance, nodes per mm in x and in y, 1 / normaliser, then the table: x and y of every corner, x and y of
    the centres. The film point is mirrored into the first quadrant, its region interpolated between four nodes,
    and the ray mirrored back.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, u, v, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[U0], row[U1], row[WEIGHT]
    node, right, up, turn, corner, found = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    ax, ay, bx, by, centre_x, centre_y = row[A6], row[A7], row[A8], row[A9], row[A10], row[A11]
    at, share = row[L], row[M]
    distance, across, along, gain = p[0], p[1], p[2], p[3]
    table = p[4:]
    last = real(NODES - 1.001)
    for i in range(B):
        s, t = abs(x[i]) * across, abs(y[i]) * along
        s, t = s if s < last else last, t if t < last else last
        node[i] = np.floor(t) * real(NODES) + np.floor(s)
        right[i], up[i], turn[i] = s - np.floor(s), t - np.floor(t), u[i] * real(SECTORS)
        ax[i], ay[i], bx[i], by[i], centre_x[i], centre_y[i] = real(0), real(0), real(0), real(0), real(0), real(0)
    for k in range(4):
        beside, above = real(k % 2), real(k // 2)
        for i in range(B):
            f, g = right[i], up[i]
            f, g = beside * f + (real(1) - beside) * (real(1) - f), above * g + (real(1) - above) * (real(1) - g)
            share[i] = f * g
            at[i] = node[i] + beside + above * real(NODES)
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
        weight[i] = gain * c2 * c2 * real(SECTORS) * (area if area > real(0) else real(0))
        z[i] = real(0)
    alive = np.int32(0)
    for i in range(B):
        alive += np.int32(1) if weight[i] > real(0) else np.int32(0)
    if alive == 0:
        key[ALIVE] = np.uint32(LOST)
