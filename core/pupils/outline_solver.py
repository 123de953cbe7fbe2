"""Outline of the exit-pupil region, for any film points and lenses of any symmetry.

As in `rim_solver`, but without an axis of symmetry: the search for the centre covers both directions of the plane, and
the rim is solved all the way around. Lens frame, mm, float64.
"""

import math

import numpy as np

from lensbench.imaging.film_pose import UPRIGHT
from lensbench.kernels.cache import njit
from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens
from lensbench.pupils.image_circle import Placement
from lensbench.pupils.ray_aiming import Aim
from lensbench.pupils.rim_solver import DIGITS, REACH, ROUGH, rim_distances

ROUGH_POINTS = 16       # of a rough rim, along which the final points are spaced evenly
DIRECTIONS = 128        # in which the length of the rough rim is measured


def solve_outlines(lens: Lens, film_distance: float, film_points, points: int, tolerance: float,
                   wavelength: float = D_LINE, place: Placement = UPRIGHT.points) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, 2), and points (n, points, 2) of each rim from its centre, counter-clockwise from +x, in mm.

    The centre is the centroid; the points are evenly spaced along the rim to about a tenth, and 0 for a film point
    whose region is empty. film_points: (n, 2) mm; tolerance: of the rims (mm); wavelength: µm; place: as in
    `edge_of_light`.
    """
    film = place(np.asarray(film_points, float))
    film_x, film_y, film_z = np.ascontiguousarray(film.T)
    n = len(film)
    aim = Aim(lens, film_distance, wavelength)
    rear = lens.surfaces[-1].semi_diameter
    reach, size = REACH * rear, REACH * min(rear, lens.stop.semi_diameter)

    def solved(centre: np.ndarray, level: np.ndarray, cosine: np.ndarray, sine: np.ndarray, guess: np.ndarray,
               accuracy: float, error: float) -> np.ndarray:
        """Distances (n, directions) to the rims from these centres, to `accuracy` mm; error: of clearances."""
        rim = np.zeros(cosine.shape)
        rim_distances(film_x, film_y, film_z, *np.ascontiguousarray(centre.T), level, np.ascontiguousarray(cosine),
             np.ascontiguousarray(sine), guess, film_distance, reach, accuracy, rim, aim.tracer, error)
        return rim

    centre, level = aim.find_light(film)
    lit = level < 1.0

    # Rough rims, and from their centroids the directions of the final ones
    turn = 2.0 * math.pi * np.arange(ROUGH_POINTS) / ROUGH_POINTS
    cosine, sine = (np.tile(f(turn), (n, 1)) for f in (np.cos, np.sin))
    begin = np.where(lit, 0.6 * reach * np.maximum(1.0 - level, 1e-3), reach)
    rough = solved(centre, level, cosine, sine, np.tile(begin[:, None], ROUGH_POINTS), ROUGH * size, ROUGH)
    outline = np.stack([rough * cosine, rough * sine], 2)
    moved = centre + _centroids(outline)
    there = aim.clearances(film, moved)
    better = lit & (there < 1.0)                        # otherwise keep the first centre
    outline += np.where(better[:, None], centre - moved, 0.0)[:, None, :]
    centre, level = np.where(better[:, None], moved, centre), np.where(better, there, level)
    angle, guess = _even_directions(outline, points)
    rim = solved(centre, level, np.cos(angle), np.sin(angle), np.maximum(guess, 1e-3 * tolerance), tolerance,
                 DIGITS * tolerance / size)
    centre[~lit] = 0.0
    return centre, np.stack([rim * np.cos(angle), rim * np.sin(angle)], 2)


def _centroids(outlines: np.ndarray) -> np.ndarray:
    """Centroids (n, 2) of polygons (n, m, 2); 0 for an empty one."""
    after = np.roll(outlines, -1, 1)
    cross = outlines[..., 0] * after[..., 1] - outlines[..., 1] * after[..., 0]
    area = cross.sum(1)[:, None]
    moment = (cross[..., None] * (outlines + after)).sum(1) / 3.0
    return np.divide(moment, area, out=np.zeros_like(moment), where=area > 0.0)


@njit(cache=True, error_model="numpy", nogil=True)
def _even_directions(outlines, points):
    """Angles (n, points), from 0, of points evenly spaced along outlines (n, m, 2) about 0, and their distances."""
    count, corners, _ = outlines.shape
    angles, sizes = np.zeros((count, points)), np.zeros((count, points))
    turn, length = np.empty(corners + 2), np.empty(corners + 2)
    size, along = np.empty(DIRECTIONS + 1), np.zeros(DIRECTIONS + 1)
    step = 2.0 * math.pi / DIRECTIONS
    cosine, sine = np.cos(step * np.arange(DIRECTIONS + 1)), np.sin(step * np.arange(DIRECTIONS + 1))
    for k in range(count):
        # Corners by rising angle in [0, 2π), and those at the ends once more beyond the other end
        for i in range(corners):
            x, y = outlines[k, i]
            angle, place = math.atan2(y, x) % (2.0 * math.pi), i + 1
            while place > 1 and turn[place - 1] > angle:
                turn[place], length[place] = turn[place - 1], length[place - 1]
                place -= 1
            turn[place], length[place] = angle, math.hypot(x, y)
        turn[0], length[0] = turn[corners] - 2.0 * math.pi, length[corners]
        turn[corners + 1], length[corners + 1] = turn[1] + 2.0 * math.pi, length[1]
        # Length of the outline up to even angles
        i = 0
        for j in range(DIRECTIONS):
            while turn[i + 1] <= j * step:
                i += 1
            share = (j * step - turn[i]) / (turn[i + 1] - turn[i])
            size[j] = length[i] + share * (length[i + 1] - length[i])
        size[DIRECTIONS] = size[0]
        for j in range(DIRECTIONS):
            along[j + 1] = along[j] + math.hypot(
                size[j + 1] * cosine[j + 1] - size[j] * cosine[j], size[j + 1] * sine[j + 1] - size[j] * sine[j])
        if along[DIRECTIONS] == 0.0:                    # an empty region
            continue
        i = 0
        for j in range(points):
            wanted = along[DIRECTIONS] * j / points
            while along[i + 1] <= wanted:
                i += 1
            share = (wanted - along[i]) / (along[i + 1] - along[i])
            angles[k, j] = (i + share) * step
            sizes[k, j] = size[i] + share * (size[i + 1] - size[i])
    return angles, sizes
