"""Film grid: exit-pupil regions of film points over a quadrant of the film, for `PupilGrid` to interpolate.

Film coordinates u and v are x and y over half the film's width and height. The nodes lie on rings about the film's
centre and on columns, which fan out from there at even shares v / (u + v). The last ring lies where the light ends, or
at the film's corner; towards an end of the light the rings crowd, for a region shrinks there as a square root. A
polynomial, the course, first takes up the motion of the regions' centres, for the region of a small stop moves by many
times its size. A lens with two planes of symmetry needs one quadrant of the film; a lens with surfaces out of line
needs four, each of which is the first quadrant of the mirrored lens. Lens frame, mm.
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.kernels.cache import njit
from lensbench.optics.prescription import Lens
from lensbench.pupils.equal_areas import equal_areas
from lensbench.pupils.image_circle import edge_of_light
from lensbench.pupils.outline_solver import solve_outlines
from lensbench.pupils.ray_aiming import Aim
from lensbench.pupils.rim_solver import REACH

RINGS, COLUMNS, SECTORS = 16, 11, 48        # of nodes; and triangles in a region
EDGE_POINTS = 8 * (COLUMNS - 1) + 1         # columns at which the distance of the last ring is known
POINTS = 64                     # solved points on each rim
TERMS, GENERAL_TERMS = 10, 21   # coefficients of the course along x, and along y: of one quadrant, and of four
DEGREE = 5                      # of the course of four quadrants
SIDES = ((1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0))           # signs of x and y in the quadrants
MILD_CROWDING = 0.25            # of the rings where the light does not end
LARGEST_GROWTH = 2.5            # × a node's region: beyond it, the neighbours' outline replaces the region
SPREAD = 1.003                  # sampled region over the true one where they are compared: it bulges between


class Nodes(NamedTuple):
    """RINGS × COLUMNS film points in each of q quadrants, one or four, the region of each cut into SECTORS triangles.

    Everything is given as mirrored into the quadrant x ≥ 0, y ≥ 0. edge: (q, EDGE_POINTS) distance √(u² + v²) of the
    last ring at even shares v / (u + v); no light falls beyond it. Ring k lies where 1 − √(1 − crowding · √(u² + v²) /
    edge) is k / (RINGS − 1) of its value at the edge. course: (2, TERMS or GENERAL_TERMS) coefficients of
    `course_terms` for x and y of the centres (mm), to which `centres` (q, RINGS, COLUMNS, 2) in mm is added. outline:
    (q, RINGS, COLUMNS, SECTORS + 1, 2) corners in mm from there, counter-clockwise from the one in +x, at equal areas;
    0 where there is no light.
    """

    edge: np.ndarray
    crowding: float
    course: np.ndarray
    centres: np.ndarray
    outline: np.ndarray


def solve_nodes(lens: Lens, film_distance: float, half_film: np.ndarray, wavelength: float) -> Nodes:
    """Nodes of a film with half sides half_film (2,) mm, enlarged until the regions between them hold all light."""
    tolerance = 2e-4 * REACH * min(lens.surfaces[-1].semi_diameter, lens.stop.semi_diameter)
    sides = np.array(SIDES[:1] if lens.is_in_line else SIDES)
    lenses = [lens.mirrored(*(side < 0.0)) for side in sides]
    share = np.linspace(0.0, 1.0, 2 * COLUMNS - 1)
    directions = np.stack([1.0 - share, share], 1) / np.hypot(1.0 - share, share)[:, None]
    ends = {each: edge_of_light(Aim(each, film_distance, wavelength), directions * half_film, math.sqrt(2.0))
            for each in dict.fromkeys(lenses)}
    crowding = 1.0 if any(light_ends for _, light_ends in ends.values()) else MILD_CROWDING
    rings = (1.0 - (1.0 - np.linspace(0.0, 1.0, 2 * RINGS - 1) * (1.0 - math.sqrt(1.0 - crowding))) ** 2) / crowding
    # Solve grids twice as fine as the nodes, which show how much larger the nodes' regions must be
    films = {each: (rings[:, None] * edge)[:, :, None] * directions for each, (edge, _) in ends.items()}
    solved = {each: solve_outlines(each, film_distance, (film * half_film).reshape(-1, 2), POINTS, tolerance,
                                   wavelength) for each, film in films.items()}
    # Fit the course to the centres of all quadrants
    shape = films[lens].shape
    film = np.stack([films[each].reshape(-1, 2) for each in lenses]) * sides[:, None]
    centres = np.stack([solved[each][0] for each in lenses])
    rims = np.stack([solved[each][1].reshape(*shape[:2], POINTS, 2) for each in lenses])
    of_film = course_terms(film.reshape(-1, 2), len(sides) > 1)
    lit, true = np.asarray(rims.any((3, 4))).ravel(), (centres * sides[:, None]).reshape(-1, 2)
    course = np.array([np.linalg.lstsq(power[lit], true[lit, axis], rcond=None)[0]
                       for axis, power in enumerate(of_film)])
    off = (centres - course_at(course, of_film).reshape(centres.shape) * sides[:, None]).reshape(-1, *shape)
    cut = [_cut(*quadrant) for quadrant in zip(off, rims, strict=True)]
    edges = [_cubic_midpoints(_cubic_midpoints(ends[each][0])) for each in lenses]
    return Nodes(np.stack(edges), crowding, course, *(np.stack(part) for part in zip(*cut, strict=True)))


def _cut(centres: np.ndarray, rims: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres and outlines of the nodes of a quadrant, from those of the grid twice as fine.

    A node that is dark, or would grow too much, takes the outline of its neighbours.
    """
    at, outline = centres[::2, ::2].copy(), rims[::2, ::2].copy()
    _adopt_neighbours(centres, rims, np.asarray(~outline.any((2, 3))), at, outline)
    growth = _growth(centres, rims, at, _corners(outline))
    _adopt_neighbours(centres, rims, growth.max(2) > LARGEST_GROWTH, at, outline)
    corners = _corners(outline)
    return at, corners * (SPREAD * _growth(centres, rims, at, corners))[..., None]


def course_at(course: np.ndarray, of_film: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Course (n, 2) in mm at film points with these `course_terms`; course: (2, terms) coefficients."""
    return np.stack([power @ terms for power, terms in zip(of_film, course, strict=True)], 1)


def course_terms(film: np.ndarray, general: bool) -> tuple[np.ndarray, np.ndarray]:
    """Terms (n, terms) of the course along x and y at film points (n, 2).

    For two planes of symmetry they are u, or v, times powers of u² and v² up to 3; in general all u^i v^j with
    i + j ≤ DEGREE, by rising i, then j.
    """
    u, v = film.T
    if general:
        terms = np.stack([u**i * v**j for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i)], 1)
        return terms, terms
    s, t = u * u, v * v
    even = np.stack([u**0, s, t, s * s, s * t, t * t, s**3, s * s * t, s * t * t, t**3], 1)
    return even * u[:, None], even * v[:, None]


def _adopt_neighbours(centres: np.ndarray, rims: np.ndarray, which: np.ndarray, at: np.ndarray,
                      outline: np.ndarray) -> None:
    """Give the nodes `which` the convex outline around all regions up to their neighbours; change at and outline."""
    lit = np.asarray(rims.any((2, 3)))
    for i, j in zip(*np.nonzero(which), strict=True):
        around = (slice(max(2 * i - 2, 0), 2 * i + 3), slice(max(2 * j - 2, 0), 2 * j + 3))
        if lit[around].any():
            points = (centres[around][:, :, None] + rims[around])[lit[around]].reshape(-1, 2)
            at[i, j] = 0.5 * (points.min(0) + points.max(0))
            outline[i, j] = _hull(points - at[i, j])


def _hull(points: np.ndarray) -> np.ndarray:
    """Points (POINTS, 2) at equal angles from +x on the convex outline around points (p, 2) about 0."""
    turn = 2.0 * math.pi * np.arange(POINTS) / POINTS
    normals = 2.0 * math.pi * np.arange(4 * POINTS) / (4 * POINTS)
    support = (points @ np.stack([np.cos(normals), np.sin(normals)])).max(0)
    facing = np.cos(turn[:, None] - normals)
    reach = np.where(facing > 1e-3, support / np.maximum(facing, 1e-3), np.inf).min(1)
    return np.stack([reach * np.cos(turn), reach * np.sin(turn)], 1)


def _corners(outline: np.ndarray) -> np.ndarray:
    """Corners (…, SECTORS + 1, 2) at equal areas along the chords of closed rims (…, POINTS, 2)."""
    closed = np.concatenate([outline, outline[..., :1, :]], -2)
    return equal_areas(closed.reshape(-1, *closed.shape[-2:]), SECTORS).reshape(*outline.shape[:-2], SECTORS + 1, 2)


def _growth(centres: np.ndarray, rims: np.ndarray, at: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Factor (RINGS, COLUMNS, SECTORS + 1) for each corner so that interpolated regions hold the finer grid's."""
    true = rims + (centres - _midpoints(at))[:, :, None]
    polygon = _midpoints(corners)
    # Chord of the polygon in the direction of each rim point, and how far beyond it the point lies
    turn = np.unwrap(np.arctan2(polygon[..., 1], polygon[..., 0]))
    angle = turn[..., :1] + (np.arctan2(true[..., 1], true[..., 0]) - turn[..., :1]) % (2.0 * math.pi)
    chord = _chords(turn, angle)[..., None]
    a, b = np.take_along_axis(polygon, chord, 2), np.take_along_axis(polygon, chord + 1, 2)
    doubled = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    beyond = true[..., 0] * (b - a)[..., 1] - true[..., 1] * (b - a)[..., 0]
    lit = np.asarray(rims.any((2, 3)))[:, :, None]
    needed = np.divide(beyond, doubled, out=np.ones_like(beyond), where=(doubled > 0.0) & lit)
    factors = np.ones(polygon.shape[:3])
    i, j = np.ogrid[:2 * RINGS - 1, :2 * COLUMNS - 1]
    for end in (0, 1):
        np.maximum.at(factors, (i[..., None], j[..., None], chord[..., 0] + end), needed)
    factors[..., 0] = factors[..., -1] = np.maximum(factors[..., 0], factors[..., -1])
    # A node's corner serves all points of the finer grid beside it
    padded = np.pad(factors, ((1, 1), (1, 1), (0, 0)), mode="edge")
    return np.max([padded[i:i + 2 * RINGS - 1:2, j:j + 2 * COLUMNS - 1:2] for i in range(3) for j in range(3)], 0)


@njit(cache=True, error_model="numpy", nogil=True)
def _chords(turn, angle):
    """Indices (rings, columns, points) of chords between corners at angles (…, SECTORS + 1), by angles (…, points)."""
    rings, columns, points = angle.shape
    found = np.empty(angle.shape, np.int64)
    for i in range(rings):
        for j in range(columns):
            for point in range(points):
                before = 0
                for k in range(SECTORS + 1):
                    before += turn[i, j, k] <= angle[i, j, point]
                found[i, j, point] = min(max(before - 1, 0), SECTORS - 1)
    return found


def _midpoints(nodes: np.ndarray) -> np.ndarray:
    """Values (RINGS, COLUMNS, …) → (2 RINGS − 1, 2 COLUMNS − 1, …), with the means of neighbours between them."""
    for axis in (0, 1):
        nodes = np.moveaxis(nodes, axis, 0)
        finer = np.empty((2 * len(nodes) - 1, *nodes.shape[1:]))
        finer[::2], finer[1::2] = nodes, 0.5 * (nodes[:-1] + nodes[1:])
        nodes = np.moveaxis(finer, 0, axis)
    return nodes


def _cubic_midpoints(values: np.ndarray) -> np.ndarray:
    """Values (n,) → (2 n − 1,), with cubic interpolation of four neighbours between them, mirrored at the ends."""
    padded = np.pad(values, 1, mode="reflect")
    finer = np.empty(2 * len(values) - 1)
    finer[::2] = values
    finer[1::2] = (9.0 * (padded[1:-2] + padded[2:-1]) - padded[:-3] - padded[3:]) / 16.0
    return finer
