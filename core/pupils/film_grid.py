"""Film grid: exit-pupil regions of film points over a quadrant of the film, for `PupilGrid` to interpolate.

Film coordinates u and v are x and y over half the film's width and height. The nodes lie on rings about the film's
centre and on columns at even shares v / (u + v). The last ring lies where the light ends, or at the film's corner;
towards an end of the light the rings crowd, for a region shrinks there as a square root. A polynomial, the course,
first takes up the motion of the regions' centres. A lens with two planes of symmetry needs one quadrant; a tilted or
decentred lens or film needs four, each the first quadrant of the mirrored lens and film. Lens frame, mm.
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from lensbench.core.imaging.film import STEEPEST_SIDE, UPRIGHT, FilmPose
from lensbench.core.kernels.cache import njit
from lensbench.core.optics.prescription import Lens
from lensbench.core.pupils.outline_solver import Aim, Placement, edge_of_light, solve_outlines
from lensbench.core.pupils.radial_sampler import equal_areas
from lensbench.core.pupils.rim_solver import REACH

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

    All as mirrored into the quadrant x ≥ 0, y ≥ 0. edge: (q, EDGE_POINTS) distance √(u² + v²) of the last ring at even
    shares v / (u + v). Ring k lies where 1 − √(1 − crowding · √(u² + v²) / edge) is k / (RINGS − 1) of its value at the
    edge. course: (2, TERMS or GENERAL_TERMS) coefficients of `course_terms` for the centres (mm), to which `centres`
    (q, RINGS, COLUMNS, 2) is added. outline: (q, RINGS, COLUMNS, SECTORS + 1, 2) corners in mm from there,
    counter-clockwise from +x, at equal areas; 0 without light.
    """

    edge: np.ndarray
    crowding: float
    course: np.ndarray
    centres: np.ndarray
    outline: np.ndarray


def solve_nodes(lens: Lens, film_distance: float, half_film: np.ndarray, wavelength: float,
                pose: FilmPose = UPRIGHT) -> Nodes:
    """Nodes of a film with half sides half_film (2,) mm, enlarged until the regions between them hold all light."""
    tolerance = 2e-4 * REACH * min(lens.surfaces[-1].semi_diameter, lens.stop.semi_diameter)
    sides = np.array(SIDES[:1] if lens.is_mirror_symmetric and pose.is_upright else SIDES)
    places = [(lens.mirrored(*(side < 0.0)), pose.mirrored(*(side < 0.0).tolist())) for side in sides]
    # The rings reach beyond the film: there a posed film comes no nearer to the lens than half as near as within it
    nearest = film_distance + (0.0 if pose.is_upright else float(pose.extent(*(2.0 * half_film).tolist())[:, 2].min()))
    placed = {half: _placement(half[1], 0.5 * nearest - film_distance) for half in places}
    share = np.linspace(0.0, 1.0, 2 * COLUMNS - 1)
    directions = np.stack([1.0 - share, share], 1) / np.hypot(1.0 - share, share)[:, None]
    ends = {half: edge_of_light(Aim(half[0], film_distance, wavelength), directions * half_film, math.sqrt(2.0),
                                placed[half]) for half in dict.fromkeys(places)}
    crowding = 1.0 if any(light_ends for _, light_ends in ends.values()) else MILD_CROWDING
    rings = (1.0 - (1.0 - np.linspace(0.0, 1.0, 2 * RINGS - 1) * (1.0 - math.sqrt(1.0 - crowding))) ** 2) / crowding
    # Solve grids twice as fine as the nodes, which show how much larger the nodes' regions must be
    films = {half: (rings[:, None] * edge)[:, :, None] * directions for half, (edge, _) in ends.items()}
    solved = {half: solve_outlines(half[0], film_distance, (film * half_film).reshape(-1, 2), POINTS, tolerance,
                                   wavelength, placed[half]) for half, film in films.items()}
    # Fit the course to the centres of all quadrants
    shape = films[places[0]].shape
    film = np.stack([films[half].reshape(-1, 2) for half in places]) * sides[:, None]
    centres = np.stack([solved[half][0] for half in places])
    rims = np.stack([solved[half][1].reshape(*shape[:2], POINTS, 2) for half in places])
    of_film = course_terms(film.reshape(-1, 2), len(sides) > 1)
    lit, true = np.asarray(rims.any((3, 4))).ravel(), (centres * sides[:, None]).reshape(-1, 2)
    course = np.array([np.linalg.lstsq(power[lit], true[lit, axis], rcond=None)[0]
                       for axis, power in enumerate(of_film)])
    off = (centres - course_at(course, of_film).reshape(centres.shape) * sides[:, None]).reshape(-1, *shape)
    cut = [_cut(*quadrant) for quadrant in zip(off, rims, strict=True)]
    edges = [_cubic_midpoints(_cubic_midpoints(ends[half][0])) for half in places]
    return Nodes(np.stack(edges), crowding, course, *(np.stack(table) for table in zip(*cut, strict=True)))


def _placement(pose: FilmPose, lowest: float) -> Placement:
    """Camera-frame points of film points, at z (mm) of at least `lowest`; those beside a sphere are as deep as it."""
    def points_of(film: np.ndarray) -> np.ndarray:
        if pose.is_curved:
            r = np.hypot(*film.T)
            on_sphere = film * np.minimum(1.0, STEEPEST_SIDE * abs(pose.radius) / np.maximum(r, 1e-30))[:, None]
            points = pose.points(on_sphere) + (film - on_sphere) @ pose.axes[:2]
        else:
            points = pose.points(film)
        points[:, 2] = np.maximum(points[:, 2], lowest)
        return points

    return UPRIGHT.points if pose.is_upright else points_of


def _cut(centres: np.ndarray, rims: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres and outlines of the nodes of a quadrant, from a grid twice as fine; dark nodes take a neighbour's."""
    middles, outline = centres[::2, ::2].copy(), rims[::2, ::2].copy()
    _adopt_neighbours(centres, rims, np.asarray(~outline.any((2, 3))), middles, outline)
    growth = _growth(centres, rims, middles, _corners(outline))
    _adopt_neighbours(centres, rims, growth.max(2) > LARGEST_GROWTH, middles, outline)
    corners = _corners(outline)
    return middles, corners * (SPREAD * _growth(centres, rims, middles, corners))[..., None]


def course_at(course: np.ndarray, of_film: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Course (n, 2) in mm at film points with these `course_terms`; course: (2, terms) coefficients."""
    return np.stack([power @ terms for power, terms in zip(of_film, course, strict=True)], 1)


def course_terms(film: np.ndarray, general: bool) -> tuple[np.ndarray, np.ndarray]:
    """Terms (n, terms) of the course along x and y at film points (n, 2).

    For two planes of symmetry u, or v, times powers of u² and v² up to 3; in general all u^i v^j with i + j ≤ DEGREE.
    """
    u, v = film.T
    if general:
        terms = np.stack([u**i * v**j for i in range(DEGREE + 1) for j in range(DEGREE + 1 - i)], 1)
        return terms, terms
    s, t = u * u, v * v
    even = np.stack([u**0, s, t, s * s, s * t, t * t, s**3, s * s * t, s * t * t, t**3], 1)
    return even * u[:, None], even * v[:, None]


def _adopt_neighbours(centres: np.ndarray, rims: np.ndarray, which: np.ndarray, middles: np.ndarray,
                      outline: np.ndarray) -> None:
    """Give the nodes `which` the convex outline around all regions up to their neighbours; change at and outline."""
    lit = np.asarray(rims.any((2, 3)))
    for i, j in zip(*np.nonzero(which), strict=True):
        around = (slice(max(2 * i - 2, 0), 2 * i + 3), slice(max(2 * j - 2, 0), 2 * j + 3))
        if lit[around].any():
            points = (centres[around][:, :, None] + rims[around])[lit[around]].reshape(-1, 2)
            middles[i, j] = 0.5 * (points.min(0) + points.max(0))
            outline[i, j] = _hull(points - middles[i, j])


def _hull(points: np.ndarray) -> np.ndarray:
    """Points (POINTS, 2) at equal angles from +x on the convex outline around points (p, 2) about 0."""
    across, way, normals = _hull_directions()
    support = (points @ normals).max(0)
    return np.min(support * across, 1, where=across > 0.0, initial=np.inf)[:, None] * way


@cache
def _hull_directions() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of POINTS even directions and four times as many normals: 1 / cosine between them, or 0, and both."""
    turn = 2.0 * math.pi * np.arange(POINTS) / POINTS
    normals = 2.0 * math.pi * np.arange(4 * POINTS) / (4 * POINTS)
    facing = np.cos(turn[:, None] - normals)
    across = np.where(facing > 1e-3, 1.0 / np.maximum(facing, 1e-3), 0.0)
    return across, np.stack([np.cos(turn), np.sin(turn)], 1), np.stack([np.cos(normals), np.sin(normals)])


def _corners(outline: np.ndarray) -> np.ndarray:
    """Corners (…, SECTORS + 1, 2) at equal areas along the chords of closed rims (…, POINTS, 2)."""
    closed = np.concatenate([outline, outline[..., :1, :]], -2)
    return equal_areas(closed.reshape(-1, *closed.shape[-2:]), SECTORS).reshape(*outline.shape[:-2], SECTORS + 1, 2)


def _growth(centres: np.ndarray, rims: np.ndarray, middles: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Factor (RINGS, COLUMNS, SECTORS + 1) for each corner so that interpolated regions hold the finer grid's."""
    factors = _needed_growth(_midpoints(corners), rims, centres - _midpoints(middles))
    # A node's corner serves all points of the finer grid beside it
    padded = np.pad(factors, ((1, 1), (1, 1), (0, 0)), mode="edge")
    return np.max([padded[i:i + 2 * RINGS - 1:2, j:j + 2 * COLUMNS - 1:2] for i in range(3) for j in range(3)], 0)


@njit(cache=True, error_model="numpy", nogil=True)
def _needed_growth(polygons, rims, offsets):
    """Factors (rings, columns, SECTORS + 1), at least 1, for the corners of polygons that are to hold rims.

    polygons: (rings, columns, SECTORS + 1, 2) about 0; rims: (rings, columns, points, 2) about offsets, 0 without
    light.
    """
    rings, columns, points, _ = rims.shape
    corners = polygons.shape[2]
    factors, turn, whole = np.ones((rings, columns, corners)), np.empty(corners), 2.0 * math.pi
    for i in range(rings):
        for j in range(columns):
            if not rims[i, j].any():
                continue
            polygon = polygons[i, j]
            turn[0] = math.atan2(polygon[0, 1], polygon[0, 0])
            for k in range(1, corners):
                step = math.atan2(polygon[k, 1], polygon[k, 0]) - turn[k - 1]
                turn[k] = turn[k - 1] + (step + math.pi) % whole - math.pi
            chord = 0
            for point in range(points):
                x, y = rims[i, j, point, 0] + offsets[i, j, 0], rims[i, j, point, 1] + offsets[i, j, 1]
                angle = turn[0] + (math.atan2(y, x) - turn[0]) % whole
                # The chord in the direction of the rim point, mostly that of the point before or the next one, and
                # how far beyond it the point lies
                chord = chord if turn[chord] <= angle else 0
                while chord < corners - 2 and turn[chord + 1] <= angle:
                    chord += 1
                ax, ay = polygon[chord]
                bx, by = polygon[chord + 1]
                doubled = ax * by - ay * bx
                if doubled > 0.0:
                    needed = (x * (by - ay) - y * (bx - ax)) / doubled
                    for end in (chord, chord + 1):
                        factors[i, j, end] = max(factors[i, j, end], needed)
            factors[i, j, 0] = factors[i, j, -1] = max(factors[i, j, 0], factors[i, j, -1])
    return factors


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
