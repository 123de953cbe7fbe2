"""Sampler on a film grid: exit-pupil regions behind a lens without rotational symmetry, for a camera to sample.

A lens with a cylinder or toroid has two planes of symmetry, so one quadrant of the film serves for all four; a lens
with surfaces out of line, or any lens before a film out of line, has four of its own, mirrored into the first. The
sampler interpolates the regions between the
nodes of `film_grid`, which are a hair larger than the true ones, so that no light is lost; the trace blocks the rest.
The weight holds the area of the sampled triangle. Lens frame, mm.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lensbench.imaging.film_pose import UPRIGHT, FilmPose, film_normal, place_on_film
from lensbench.kernels.block import ALIVE, LOST, U1, WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage
from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens
from lensbench.pupils.film_grid import (
    COLUMNS,
    EDGE_POINTS,
    RINGS,
    SECTORS,
    Nodes,
    course_at,
    course_terms,
    solve_nodes,
)
from lensbench.pupils.film_grid_lookup import (
    CENTRE_X,
    CENTRE_Y,
    CORNER_AX,
    CORNER_AY,
    CORNER_BX,
    CORNER_BY,
    COURSE,
    CROWDING,
    FILM_DISTANCE,
    GAIN,
    INVERSE_HEIGHT,
    INVERSE_WIDTH,
    POSE,
    RING_SCALE,
    ROUNDING,
    TURN,
    find_triangle,
)


@dataclass(frozen=True, eq=False)
class PupilGrid:
    """Exit-pupil regions over a film of half_width and half_height, film_distance behind the last vertex (mm).

    pose: of the film; film points are those of its own frame.
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
        """Area (n,) in mm² over which the samples of film points (n, 2) are spread, from their density at rear points.

        That is the area of the triangle at the rear point (n, 2) mm times the number of triangles; 0 where no sample
        goes.
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
        at = rear_xy * side - (centre + course * side if general else centre + course)
        # Last corner, counter-clockwise, before the rear point
        turn = np.unwrap(np.arctan2(corners[..., 1], corners[..., 0]))
        angle = turn[:, 0] + (np.arctan2(at[:, 1], at[:, 0]) - turn[:, 0]) % (2.0 * math.pi)
        k = np.clip((turn <= angle[:, None]).sum(1) - 1, 0, SECTORS - 1)
        (ax, ay), (bx, by) = corners[np.arange(len(k)), k].T, corners[np.arange(len(k)), k + 1].T
        twice = ax * by - bx * ay
        within = (at[:, 0] * (by - ay) - at[:, 1] * (bx - ax) <= twice) & (distance <= 1.0 + ROUNDING)
        return np.where(within, 0.5 * SECTORS * np.maximum(twice, 0.0), 0.0)

    def step(self, normaliser: float) -> Step:
        """Step that aims from the film into the region; WEIGHT becomes cos⁴θ · area / normaliser.

        From a film out of line cos³θ · cos φ · area · (distances)² / normaliser: θ is measured from the axis, φ from
        the film's normal; the ray then starts at z = 0.
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
    """Aim from a film point X, Y (mm, Z = 0) into its exit-pupil region: L, M, N and WEIGHT. p: see FILM_DISTANCE.

    ints: see QUADRANTS. The film point is mirrored into the first quadrant, its region interpolated between four nodes,
    and the ray mirrored back.
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
    # Skip all further steps where no lane has any weight
    alive = np.int32(0)
    for i in range(B):
        alive += np.int32(1) if weight[i] > real(0) else np.int32(0)
    if alive == 0:
        key[ALIVE] = np.uint32(LOST)


@stage
def aim_from_posed_grid(lanes, p, ints, key):
    """Aim from a point X, Y of a film out of line into its exit-pupil region: the ray at z = 0, and WEIGHT.

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
    # Skip all further steps where no lane has any weight
    alive = np.int32(0)
    for i in range(B):
        alive += np.int32(1) if weight[i] > real(0) else np.int32(0)
    if alive == 0:
        key[ALIVE] = np.uint32(LOST)
