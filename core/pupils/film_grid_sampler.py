"""Sampler on a film grid: exit-pupil regions behind a lens without rotational symmetry, for a camera to sample.

The sampler interpolates the regions between the nodes of `film_grid`, which are a hair larger than the true ones, so
that no light is lost; the trace blocks the rest. The weight holds the area of the sampled triangle. One stage aims from
an upright film, one from a posed film. Regions move with the refractive indices, nearly a parabola in 1 / λ²: three
wavelengths are solved, and the grid of any other is interpolated. Lens frame, mm.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import prod

import numpy as np

from lensbench.core.imaging.film import UPRIGHT, FilmPose, film_normal, place_on_film
from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A6, A7, A8, A9, A10, A11, U0, U1, WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage, weigh_four
)
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.prescription import Lens
from lensbench.core.pupils.film_grid import (
    COLUMNS, DEGREE, EDGE_POINTS, GENERAL_TERMS, RINGS, SECTORS, TERMS, Nodes, course_at, course_terms, solve_nodes
)
from lensbench.core.pupils.radial_sampler import skip_if_dark

ROUNDING = 1e-5                 # share by which rounding may put a point in the film's corner beyond the last ring

# Parameters of `aim_in_quadrant` and `aim_from_posed_grid`, then the tables, quadrant by quadrant: distances of the
# last ring at EDGE_POINTS columns; the corners of all nodes, x and y of each; their centres, x and y of each
(FILM_DISTANCE,                 # mm
 INVERSE_WIDTH, INVERSE_HEIGHT, # 1 / half the film's width and height, 1/mm
 CROWDING,                      # of the rings
 RING_SCALE,                    # rings per unit of 1 − √(1 − crowding · distance)
 GAIN,                          # 1 / normaliser
 COURSE) = range(7)             # coefficients of the course, along x, then y
NODE_CORNERS, NODES = SECTORS + 1, RINGS * COLUMNS
# Integers: number of quadrants, 1 or 4; offsets of the tables, and of the pose of a tilted or shifted film behind them
QUADRANTS, EDGE, CORNERS, CENTRES, POSE = range(5)
# Scratch rows with the triangle: the place of the sample in it, its corners, and the region's centre
TURN, CORNER_AX, CORNER_AY, CORNER_BX, CORNER_BY, CENTRE_X, CENTRE_Y = A3, A6, A7, A8, A9, A10, A11


@stage(inlined=True)
def find_triangle(lanes, p, ints):
    """Find the triangle of each pupil sample, as mirrored into the first quadrant: rows TURN to CENTRE_Y.

    WEIGHT: 0 beyond the last ring, else 1.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    node, right, up, turn = row[A0], row[A1], row[A2], row[TURN]
    ax, ay, bx, by = row[CORNER_AX], row[CORNER_AY], row[CORNER_BX], row[CORNER_BY]
    centre_x, centre_y = row[CENTRE_X], row[CENTRE_Y]
    corners, centres = p[ints[CORNERS]:], p[ints[CENTRES]:]
    _find_cell(lanes, p, ints)
    # Add up the triangle's corners and the centre of the four nodes by their shares, lane by lane: what a node has lies
    # side by side, and the gather instructions of some processors cost more than its loads
    for i in range(B):
        first, sector = np.uint32(node[i]), np.uint32(turn[i])
        f, g = right[i], up[i]
        shares = (real(1) - f) * (real(1) - g), f * (real(1) - g), (real(1) - f) * g, f * g
        beside, above, both = first + np.uint32(1), first + np.uint32(COLUMNS), first + np.uint32(COLUMNS + 1)
        size, corner = np.uint32(2 * NODE_CORNERS), np.uint32(2) * sector
        offsets = first * size + corner, beside * size + corner, above * size + corner, both * size + corner
        ax[i], ay[i], bx[i], by[i] = weigh_four(corners, offsets, shares)
        for k in range(4):
            d = np.uint32(2) * (first + np.uint32(k % 2 + k // 2 * COLUMNS))
            centre_x[i] += shares[k] * centres[d]
            centre_y[i] += shares[k] * centres[d + np.uint32(1)]


@stage
def _find_cell(lanes, p, ints):
    """Find the grid cell of each film point.

    A0: the node below it; A1, A2: how far it lies towards the next column and ring; A3: triangle, and position in it.
    WEIGHT: 0 beyond the last ring, else 1. A6 to A9 become 0; A10, A11: the course at the film point.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, u, weight = row[X], row[Y], row[U0], row[WEIGHT]
    node, right, up, turn, edge, near, far = row[A0], row[A1], row[A2], row[A3], row[A4], row[A6], row[A8]
    ax, ay, bx, by = row[A6], row[A7], row[A8], row[A9]
    across, along, crowding, apart = p[INVERSE_WIDTH], p[INVERSE_HEIGHT], p[CROWDING], p[RING_SCALE]
    four, edges = ints[QUADRANTS] > 1, p[ints[EDGE]:]
    last_edge, last_ring, last_column = real(EDGE_POINTS - 1.001), real(RINGS - 1.001), real(COLUMNS - 1.001)
    # Distance from the film's centre, and column, of (s, t) = (u, v)
    for i in range(B):
        s, t = abs(x[i]) * across, abs(y[i]) * along
        both = s + t
        up[i] = t / (both if both > real(0) else real(1))
        right[i] = math.sqrt(s * s + t * t)
        t = up[i] * real(EDGE_POINTS - 1)
        t = t if t < last_edge else last_edge
        edge[i], turn[i] = np.floor(t), t - np.floor(t)
    # Quadrant of a lens without planes of symmetry
    for i in range(B):
        quadrant = (real(1) if x[i] < real(0) else real(0)) + (real(2) if y[i] < real(0) else real(0))
        ax[i] = quadrant if four else real(0)
    for i in range(B):
        node[i], edge[i] = ax[i] * real(NODES), edge[i] + ax[i] * real(EDGE_POINTS)
    # Ring, from the distance of the last ring at this column
    for i in range(B):
        inner = np.uint32(edge[i])
        near[i], far[i] = edges[inner], edges[inner + np.uint32(1)]
    for i in range(B):
        s = right[i] / (near[i] + turn[i] * (far[i] - near[i]))
        weight[i] = real(1) if s <= real(1 + ROUNDING) else real(0)
        s = s if s < real(1) else real(1)
        s, t = (real(1) - math.sqrt(real(1) - crowding * s)) * apart, up[i] * real(COLUMNS - 1)
        s, t = s if s < last_ring else last_ring, t if t < last_column else last_column
        node[i] += np.floor(s) * real(COLUMNS) + np.floor(t)
        right[i], up[i], turn[i] = t - np.floor(t), s - np.floor(s), u[i] * real(SECTORS)
        ax[i], ay[i], bx[i], by[i] = real(0), real(0), real(0), real(0)
    if four:
        _general_course(lanes, p)
    else:
        _symmetric_course(lanes, p)


@stage
def _symmetric_course(lanes, p):
    """A10, A11: the course at the film point, mirrored into the first quadrant, with the terms of `course_terms`."""
    row = rows(lanes)
    x, y, centre_x, centre_y = row[X], row[Y], row[A10], row[A11]
    across, along = p[INVERSE_WIDTH], p[INVERSE_HEIGHT]
    k = COURSE
    a0, a1, a2, a3, a4, a5, a6, a7, a8, a9 = (
        p[k], p[k + 1], p[k + 2], p[k + 3], p[k + 4], p[k + 5], p[k + 6], p[k + 7], p[k + 8], p[k + 9])
    k = COURSE + TERMS
    b0, b1, b2, b3, b4, b5, b6, b7, b8, b9 = (
        p[k], p[k + 1], p[k + 2], p[k + 3], p[k + 4], p[k + 5], p[k + 6], p[k + 7], p[k + 8], p[k + 9])
    for i in range(B):
        e, f = abs(x[i]) * across, abs(y[i]) * along
        s, t = e * e, f * f
        centre_x[i] = e * (a0 + s * (a1 + s * (a3 + s * a6) + t * (a4 + s * a7 + t * a8))
                           + t * (a2 + t * (a5 + t * a9)))
        centre_y[i] = f * (b0 + s * (b1 + s * (b3 + s * b6) + t * (b4 + s * b7 + t * b8))
                           + t * (b2 + t * (b5 + t * b9)))


@stage
def _general_course(lanes, p):
    """A10, A11: the course at the film point, with all terms u^i v^j, mirrored into the first quadrant."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, centre_x, centre_y = row[X], row[Y], row[A10], row[A11]
    across, along = p[INVERSE_WIDTH], p[INVERSE_HEIGHT]
    for i in range(B):
        centre_x[i], centre_y[i] = real(0), real(0)
    # Horner's rule in u; the coefficients of each u^i are a polynomial in v of degree DEGREE − i
    k = COURSE + GENERAL_TERMS
    for power in range(DEGREE, -1, -1):
        k -= DEGREE + 1 - power
        for i in range(B):
            u, v = x[i] * across, y[i] * along
            a, b = real(0), real(0)
            for j in range(DEGREE - power, -1, -1):
                a, b = a * v + p[k + j], b * v + p[k + GENERAL_TERMS + j]
            centre_x[i], centre_y[i] = centre_x[i] * u + a, centre_y[i] * u + b
    for i in range(B):
        centre_x[i] = -centre_x[i] if x[i] < real(0) else centre_x[i]
        centre_y[i] = -centre_y[i] if y[i] < real(0) else centre_y[i]


@dataclass(frozen=True, eq=False)
class PupilGrid:
    """Exit-pupil regions over a film of half_width and half_height, film_distance behind the last vertex (mm), in its
    pose.
    """

    film_distance: float
    half_width: float
    half_height: float
    nodes: Nodes
    pose: FilmPose = UPRIGHT

    @classmethod
    def of(cls, lens: Lens, film_distance: float, half_width: float, half_height: float,
           wavelength: float = D_LINE, pose: FilmPose = UPRIGHT) -> "PupilGrid":
        """Grid for film points up to half_width and half_height (mm) from the film's middle; wavelength in µm."""
        half_width, half_height = max(half_width, 1e-30), max(half_height, 1e-30)
        nodes = solve_nodes(lens, film_distance, np.array([half_width, half_height]), wavelength, pose)
        return cls(film_distance, half_width, half_height, nodes, pose)

    @classmethod
    def interpolated(cls, grids: Sequence["PupilGrid"], shares: Sequence[float]) -> "PupilGrid":
        """Grid interpolated between `grids` of one film and crowding, with shares that sum to 1."""
        first = grids[0]
        edge, course, centres, outline = (
            np.tensordot(shares, np.stack([getattr(grid.nodes, name) for grid in grids]), 1)
            for name in ("edge", "course", "centres", "outline"))
        return cls(first.film_distance, first.half_width, first.half_height,
                   Nodes(edge, first.nodes.crowding, course, centres, outline), first.pose)

    def sampled_area(self, film_xy: np.ndarray, rear_xy: np.ndarray) -> np.ndarray:
        """Area (n,) in mm² over which the samples of film points (n, 2) are spread, from their density at rear points
        (n, 2) mm.

        That of the triangle there times the number of triangles; 0 where no sample goes.
        """
        nodes = self.nodes
        # Corners of each film point's triangles, and its rear point, both from the region's centre
        signed = film_xy / [self.half_width, self.half_height]
        u, v = np.abs(signed).T
        general = len(nodes.edge) > 1
        quadrant = ((film_xy < 0.0) @ [1, 2]) * general
        column = np.divide(v, u + v, out=np.zeros_like(v), where=u + v > 0.0)
        at_columns = np.linspace(0.0, 1.0, EDGE_POINTS)
        distance = np.hypot(u, v) / np.choose(quadrant, [np.interp(column, at_columns, edge) for edge in nodes.edge])
        ring = 1.0 - np.sqrt(1.0 - nodes.crowding * np.minimum(distance, 1.0))
        ring /= 1.0 - math.sqrt(1.0 - nodes.crowding)
        cells = np.stack([np.minimum(ring * (RINGS - 1), RINGS - 1.001),
                          np.minimum(column * (COLUMNS - 1), COLUMNS - 1.001)], 1)
        i, f = cells.astype(int), cells % 1.0
        corners, centre = np.zeros((len(i), SECTORS + 1, 2)), np.zeros((len(i), 2))
        for x in (0, 1):
            for y in (0, 1):
                share = np.abs(1 - x - f[:, 0]) * np.abs(1 - y - f[:, 1])
                corners += share[:, None, None] * nodes.outline[quadrant, i[:, 0] + x, i[:, 1] + y]
                centre += share[:, None] * nodes.centres[quadrant, i[:, 0] + x, i[:, 1] + y]
        side = np.where(film_xy < 0.0, -1.0, 1.0)
        course = course_at(nodes.course, course_terms(signed if general else np.abs(signed), general))
        offset = rear_xy * side - (centre + course * side if general else centre + course)
        # Last corner, counter-clockwise, before the rear point
        turn = np.unwrap(np.arctan2(corners[..., 1], corners[..., 0]))
        angle = turn[:, 0] + (np.arctan2(offset[:, 1], offset[:, 0]) - turn[:, 0]) % (2.0 * math.pi)
        k = np.clip((turn <= angle[:, None]).sum(1) - 1, 0, SECTORS - 1)
        (ax, ay), (bx, by) = corners[np.arange(len(k)), k].T, corners[np.arange(len(k)), k + 1].T
        twice = ax * by - bx * ay
        within = (offset[:, 0] * (by - ay) - offset[:, 1] * (bx - ax) <= twice) & (distance <= 1.0 + ROUNDING)
        return np.where(within, 0.5 * SECTORS * np.maximum(twice, 0.0), 0.0)

    def step(self, normaliser: float) -> Step:
        """Step that aims from the film into the region; WEIGHT becomes cos⁴θ · area / normaliser.

        From a posed film cos³θ · cos φ · area · (distances)² / normaliser, φ from the film's normal; the ray starts at
        z = 0.
        """
        nodes = self.nodes
        tables = (nodes.course, nodes.edge, nodes.outline, nodes.centres)
        starts = np.cumsum([COURSE, *(table.size for table in tables[:-1])])
        p = np.empty(COURSE)
        p[FILM_DISTANCE] = self.film_distance
        p[INVERSE_WIDTH], p[INVERSE_HEIGHT] = 1.0 / self.half_width, 1.0 / self.half_height
        p[CROWDING], p[RING_SCALE] = nodes.crowding, (RINGS - 1) / (1.0 - math.sqrt(1.0 - nodes.crowding))
        p[GAIN] = 1.0 / normaliser
        packed, ints = [p, *(table.ravel() for table in tables)], [len(nodes.edge), *starts[1:].tolist()]
        if self.pose.is_upright:
            return Step(aim_in_quadrant, np.concatenate(packed), ints)
        return Step(aim_from_posed_grid, np.concatenate([*packed, self.pose.numbers]),
                    [*ints, sum(map(len, packed))])


@stage
def aim_in_quadrant(lanes, p, ints, key):
    """Aim from a film point X, Y (mm, Z = 0) into its exit-pupil region: L, M, N and WEIGHT.

    p: see FILM_DISTANCE, ints: see QUADRANTS. By way of the first quadrant.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, v, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[U1], row[WEIGHT]
    turn, centre_x, centre_y = row[TURN], row[CENTRE_X], row[CENTRE_Y]
    ax, ay, bx, by = row[CORNER_AX], row[CORNER_AY], row[CORNER_BX], row[CORNER_BY]
    distance, gain = p[FILM_DISTANCE], p[GAIN]
    find_triangle(lanes, p, ints)
    for i in range(B):
        # Choose a point of the triangle, and mirror the direction to it back
        g = turn[i] - np.floor(turn[i])
        h = real(1) - g
        reach = math.sqrt(v[i])
        dx = centre_x[i] + reach * (h * ax[i] + g * bx[i]) - abs(x[i])
        dy = centre_y[i] + reach * (h * ay[i] + g * by[i]) - abs(y[i])
        size = real(1) / math.sqrt(dx * dx + dy * dy + distance * distance)
        l[i], m[i] = (dx if x[i] >= real(0) else -dx) * size, (dy if y[i] >= real(0) else -dy) * size
        n[i] = -distance * size
        # Weight by cos⁴θ and the area of all triangles
        cosine2 = distance * size
        cosine2 = cosine2 * cosine2
        area = real(0.5) * (ax[i] * by[i] - bx[i] * ay[i])
        weight[i] *= gain * cosine2 * cosine2 * real(SECTORS) * (area if area > real(0) else real(0))
        z[i] = real(0)
    skip_if_dark(lanes, key)


@stage
def aim_from_posed_grid(lanes, p, ints, key):
    """Aim from a point X, Y of a posed film into its exit-pupil region: the ray at z = 0, and WEIGHT.

    p and ints as in `aim_in_quadrant`, then the pose.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, v, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[U1], row[WEIGHT]
    turn, centre_x, centre_y = row[TURN], row[CENTRE_X], row[CENTRE_Y]
    ax, ay, bx, by = row[CORNER_AX], row[CORNER_AY], row[CORNER_BX], row[CORNER_BY]
    distance0, gain, pose = p[FILM_DISTANCE], p[GAIN], p[ints[POSE]:]
    find_triangle(lanes, p, ints)
    for i in range(B):
        # Choose a point (a, b) of the triangle, and mirror it back
        g = turn[i] - np.floor(turn[i])
        h = real(1) - g
        reach = math.sqrt(v[i])
        a = centre_x[i] + reach * (h * ax[i] + g * bx[i])
        b = centre_y[i] + reach * (h * ay[i] + g * by[i])
        a, b = a if x[i] >= real(0) else -a, b if y[i] >= real(0) else -b
        # Aim at it from the place of the film point
        x[i], y[i], z[i] = place_on_film(pose, x[i], y[i])
        distance = distance0 + z[i]
        dx, dy = a - x[i], b - y[i]
        size = real(1) / math.sqrt(dx * dx + dy * dy + distance * distance)
        l[i], m[i], n[i] = dx * size, dy * size, -distance * size
        # Weight by the angles to the axis and to the film's normal, and by the area of all triangles
        fx, fy, fz = film_normal(pose, x[i], y[i], z[i])
        axial, facing = distance * size, -(l[i] * fx + m[i] * fy + n[i] * fz)
        nearer = distance0 / distance
        area = real(0.5) * (ax[i] * by[i] - bx[i] * ay[i])
        dense = gain * axial * axial * axial * nearer * nearer * real(SECTORS) * (area if area > real(0) else real(0))
        weight[i] *= dense * (facing if facing > real(0) else real(0))
        # Start the ray at z = 0
        back = z[i] / n[i]
        x[i] -= back * l[i]
        y[i] -= back * m[i]
        z[i] = real(0)
    skip_if_dark(lanes, key)


SOLVED = (0.44, D_LINE, 0.64)           # µm; the d line is solved for every camera
FIRST, LAST = 0.42, 0.651               # range of wavelengths (µm) in a picture


class SpectralPupilGrid:
    """Grids of one lens, with a film of half_width and half_height at film_distance (all mm), in a pose."""

    def __init__(self, lens: Lens, film_distance: float, half_width: float, half_height: float,
                 pose: FilmPose = UPRIGHT) -> None:
        self._film, self._pose = (lens, film_distance, half_width, half_height), pose

    def _solve(self, wavelength: float) -> PupilGrid:
        """Grid at a wavelength (µm), not interpolated."""
        return PupilGrid.of(*self._film, wavelength, self._pose)

    @cached_property
    def _at_d_line(self) -> PupilGrid:
        return self._solve(D_LINE)

    @cached_property
    def _solved(self) -> list[PupilGrid]:
        return [self._at_d_line if wavelength == D_LINE else self._solve(wavelength) for wavelength in SOLVED]

    @property
    def _can_interpolate(self) -> bool:
        """Whether the nodes of the solved grids are crowded alike: light ends at all these wavelengths, or at none."""
        return len({grid.nodes.crowding for grid in self._solved}) == 1

    def at(self, wavelength: float) -> PupilGrid:
        """Grid at a wavelength (µm), solved by itself outside the range of pictures and where some have no light."""
        if wavelength == D_LINE:
            return self._at_d_line
        if not FIRST <= wavelength <= LAST or not self._can_interpolate:
            return self._solve(wavelength)
        w, nodes = wavelength**-2, [solved**-2 for solved in SOLVED]
        shares = [prod((w - other) / (node - other) for other in nodes if other != node) for node in nodes]
        return PupilGrid.interpolated(self._solved, shares)
