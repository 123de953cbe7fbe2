"""Nodes: the exit-pupil regions of film points all over a quadrant, solved and cut for `PupilGrid` to interpolate.

A film point is told by u and v, its x and y in halves of the film. Nodes lie on rings about the film's centre and on
columns, which fan out from there at even shares v / (u + v). The last ring lies where the light ends, or at the
film's corner; towards an end of the light the rings crowd, for there a region shrinks as a root. A polynomial first
takes up the way that the regions' centres go, which a small stop's region leaves soon. Lens frame, mm.
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.optics.prescription import Lens
from lensbench.pupils.image_circle import edge_of_light
from lensbench.pupils.outline_solver import solve_outlines
from lensbench.pupils.ray_aiming import Aim
from lensbench.pupils.rim_solver import REACH

RINGS, COLUMNS, SECTORS = 16, 11, 48        # of nodes, and triangles in a region
EDGES = 8 * (COLUMNS - 1) + 1   # places at which the last ring is told
POINTS = 64                     # solved on each rim
SPARE = 0.25                    # the crowding of the rings where the light does not end
FAR = 2.5                       # × what is interpolated: where a region ends at once, its neighbours say too little
SPREAD = 1.003                  # the sampled region over the true one where they are compared: it bulges between


class Nodes(NamedTuple):
    """RINGS × COLUMNS film points in the quadrant x ≥ 0, y ≥ 0, the region of each cut into SECTORS triangles.

    edge: (EDGES,) √(u² + v²) of the last ring, at even shares v / (u + v); no light falls beyond it. Ring k stands
    where 1 − √(1 − crowding · √(u² + v²) / edge) is k / (RINGS − 1) of what it is at the edge. course: (2, 10)
    coefficients of `powers`, the centres' x and y in mm but for what `centres` (RINGS, COLUMNS, 2) adds. outline:
    (RINGS, COLUMNS, SECTORS + 1, 2) corners in mm from there, counter-clockwise from the one in +x, at equal areas;
    0 where there is no light.
    """

    edge: np.ndarray
    crowding: float
    course: np.ndarray
    centres: np.ndarray
    outline: np.ndarray


def solve_nodes(lens: Lens, film_distance: float, half_film: np.ndarray, wavelength: float) -> Nodes:
    """Solve the regions of a film whose halves are half_film (2,) mm, and draw them out until they hold all light."""
    tolerance = 2e-4 * REACH * min(lens.surfaces[-1].semi_diameter, lens.stop.semi_diameter)
    # Twice as fine as the nodes: what lies between them says how much larger their regions must be
    share = np.linspace(0.0, 1.0, 2 * COLUMNS - 1)
    ways = np.stack([1.0 - share, share], 1) / np.hypot(1.0 - share, share)[:, None]
    edge, ends = edge_of_light(Aim(lens, film_distance, wavelength), ways * half_film, math.sqrt(2.0))
    crowding = 1.0 if ends else SPARE
    rings = 1.0 - np.linspace(0.0, 1.0, 2 * RINGS - 1) * (1.0 - math.sqrt(1.0 - crowding))
    film = (((1.0 - rings**2) / crowding)[:, None] * edge)[:, :, None] * ways
    centres, rims = solve_outlines(lens, film_distance, (film * half_film).reshape(-1, 2), POINTS, tolerance,
                                   wavelength)
    # Take up the course of the centres
    lit, of_film = np.asarray(rims.any((1, 2))), course_terms(film.reshape(-1, 2))
    course = np.array([np.linalg.lstsq(power[lit], centres[lit, axis], rcond=None)[0]
                       for axis, power in enumerate(of_film)])
    centres = (centres - course_at(course, of_film)).reshape(film.shape)
    rims = rims.reshape(*film.shape[:2], POINTS, 2)
    # Cut the regions, those that are dark or say too little enlarged by their neighbours'
    at, outline = centres[::2, ::2].copy(), rims[::2, ::2].copy()
    _lend(centres, rims, np.asarray(~outline.any((2, 3))), at, outline)
    wide = _needed(centres, rims, at, _equal_areas(outline))
    _lend(centres, rims, wide.max(2) > FAR, at, outline)
    corners = _equal_areas(outline)
    wide = _needed(centres, rims, at, corners)
    return Nodes(_smooth(_smooth(edge)), crowding, course, at, corners * (SPREAD * wide)[..., None])


def course_at(course: np.ndarray, of_film: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """(n, 2) mm: the course (2, 10) at film points whose `powers` these are."""
    return np.stack([power @ terms for power, terms in zip(of_film, course, strict=True)], 1)


def course_terms(film: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, 10) each, for film points (n, 2): u and v times the powers of u² and v² up to the third."""
    u, v = film.T
    s, t = u * u, v * v
    course_terms = np.stack([u**0, s, t, s * s, s * t, t * t, s**3, s * s * t, s * t * t, t**3], 1)
    return course_terms * u[:, None], course_terms * v[:, None]


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
    lit = np.asarray(rims.any((2, 3)))[:, :, None]
    needed = np.divide(beyond, doubled, out=np.ones_like(beyond), where=(doubled > 0.0) & lit)
    factors = np.ones(polygon.shape[:3])
    i, j = np.ogrid[:2 * RINGS - 1, :2 * COLUMNS - 1]
    for end in (0, 1):
        np.maximum.at(factors, (i[..., None], j[..., None], chord[..., 0] + end), needed)
    factors[..., 0] = factors[..., -1] = np.maximum(factors[..., 0], factors[..., -1])
    # A node's corner stands for all points that lie beside it
    padded = np.pad(factors, ((1, 1), (1, 1), (0, 0)), mode="edge")
    return np.max([padded[i:i + 2 * RINGS - 1:2, j:j + 2 * COLUMNS - 1:2] for i in range(3) for j in range(3)], 0)


def _between(nodes: np.ndarray) -> np.ndarray:
    """Values (RINGS, COLUMNS, …) → (2 RINGS − 1, 2 COLUMNS − 1, …), with the means between neighbours."""
    for axis in (0, 1):
        nodes = np.moveaxis(nodes, axis, 0)
        finer = np.empty((2 * len(nodes) - 1, *nodes.shape[1:]))
        finer[::2], finer[1::2] = nodes, 0.5 * (nodes[:-1] + nodes[1:])
        nodes = np.moveaxis(finer, 0, axis)
    return nodes


def _smooth(values: np.ndarray) -> np.ndarray:
    """Values (n,) → (2 n − 1,) with those of a cubic through four neighbours between, mirrored at either end."""
    padded = np.pad(values, 1, mode="reflect")
    finer = np.empty(2 * len(values) - 1)
    finer[::2] = values
    finer[1::2] = (9.0 * (padded[1:-2] + padded[2:-1]) - padded[:-3] - padded[3:]) / 16.0
    return finer
