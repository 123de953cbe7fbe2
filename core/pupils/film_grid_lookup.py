"""Film-grid lookup: the triangle of a pupil sample in the exit-pupil region of a film point, by the nodes around it.

A part of the stages that aim from a film in line and from one out of line. Lens frame, mm.
"""

import math

import numpy as np

from lensbench.kernels.block import (
    A0,
    A1,
    A2,
    A3,
    A4,
    A6,
    A7,
    A8,
    A9,
    A10,
    A11,
    U0,
    WEIGHT,
    B,
    X,
    Y,
    rows,
    stage,
    weigh_four,
)
from lensbench.pupils.film_grid import COLUMNS, DEGREE, EDGE_POINTS, GENERAL_TERMS, RINGS, SECTORS, TERMS

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
# Integers: number of quadrants, 1 or 4; offsets of the tables, and of the pose of a film out of line behind them
QUADRANTS, EDGE, CORNERS, CENTRES, POSE = range(5)
# Scratch rows with the triangle: the place of the sample in it, its corners, and the region's centre
TURN, CORNER_AX, CORNER_AY, CORNER_BX, CORNER_BY, CENTRE_X, CENTRE_Y = A3, A6, A7, A8, A9, A10, A11


@stage(part=True)
def find_triangle(lanes, p, ints):
    """Find the triangle of each pupil sample, as mirrored into the first quadrant: rows TURN to CENTRE_Y.

    Adds up the corners and the centres of the four nodes around the film point X, Y. WEIGHT: 0 beyond the last ring,
    else 1.
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
        at, sector = np.uint32(node[i]), np.uint32(turn[i])
        f, g = right[i], up[i]
        shares = (real(1) - f) * (real(1) - g), f * (real(1) - g), (real(1) - f) * g, f * g
        beside, above, both = at + np.uint32(1), at + np.uint32(COLUMNS), at + np.uint32(COLUMNS + 1)
        size, corner = np.uint32(2 * NODE_CORNERS), np.uint32(2) * sector
        ax[i], ay[i], bx[i], by[i] = weigh_four(
            corners, (at * size + corner, beside * size + corner, above * size + corner, both * size + corner), shares)
        for k in range(4):
            d = np.uint32(2) * (at + np.uint32(k % 2 + k // 2 * COLUMNS))
            centre_x[i] += shares[k] * centres[d]
            centre_y[i] += shares[k] * centres[d + np.uint32(1)]


@stage
def _find_cell(lanes, p, ints):
    """Find the grid cell of each film point.

    A0: the node below it; A1, A2: how far it lies towards the next column and ring; A3: triangle, and place in it.
    WEIGHT: 0 beyond the last ring, else 1. A6 to A9 become 0; A10, A11: the course at the film point.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, u, weight = row[X], row[Y], row[U0], row[WEIGHT]
    node, right, up, turn, place, near, far = row[A0], row[A1], row[A2], row[A3], row[A4], row[A6], row[A8]
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
        place[i], turn[i] = np.floor(t), t - np.floor(t)
    # Quadrant of a lens without planes of symmetry
    for i in range(B):
        quadrant = (real(1) if x[i] < real(0) else real(0)) + (real(2) if y[i] < real(0) else real(0))
        ax[i] = quadrant if four else real(0)
    for i in range(B):
        node[i], place[i] = ax[i] * real(NODES), place[i] + ax[i] * real(EDGE_POINTS)
    # Ring, from the distance of the last ring at this column
    for i in range(B):
        at = np.uint32(place[i])
        near[i], far[i] = edges[at], edges[at + np.uint32(1)]
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
