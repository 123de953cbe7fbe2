"""Light that is traced from the scene through a real lens to its film: where it lands, and its importance.

Camera frame, mm: the origin is the film's centre, and the camera looks along −z.
"""

import math

import numpy as np

from lensbench.cameras.film_landing import FilmLanding, landing_step, posed_landing_step
from lensbench.cameras.film_regions import Regions
from lensbench.cameras.importance import FilmImportance
from lensbench.imaging.film import Film
from lensbench.imaging.film_pose import FilmPose
from lensbench.kernels.block import WEIGHT, L, M, N, X, Y, Z
from lensbench.kernels.program import Program
from lensbench.optics.block_trace import trace_steps
from lensbench.optics.prescription import Lens


def traced_landing(lens: Lens, film: Film, film_distance: float, pose: FilmPose, gain: float,
                   wavelength: float) -> FilmLanding:
    """Film landing by the full trace; gain: the pixel value of an étendue of 1 mm² sr; wavelength in µm."""
    arriving = landing_step(film, gain) if pose.is_upright else posed_landing_step(film, pose, gain)
    whole = trace_steps(lens, film_distance, wavelength, "film", blades=False)
    first = lens.surfaces[0]
    reach = float(np.hypot(*first_surface(lens)[:, :2].T).max())
    reach += min(abs(float(first.sag(first.semi_diameter))), first.semi_diameter)
    return FilmLanding([*trace_steps(lens, film_distance, wavelength, "film"), arriving], [*whole, arriving],
                       (0.0, 0.0, -lens.length - film_distance), reach)


def traced_importance(lens: Lens, film_distance: float, pose: FilmPose, film_area: float, regions: Regions,
                      gain: float, origins: np.ndarray, directions: np.ndarray, wavelength: float) -> FilmImportance:
    """Importance of rays traced back to a film that emits `gain` (sr) evenly over its area (mm²).

    origins, directions: (n, 3), mm and unit vectors towards the scene; wavelength in µm.
    """
    rays = dict(zip((X, Y, Z, L, M, N), (*origins.T, *-directions.T), strict=True))
    back = Program(trace_steps(lens, film_distance, wavelength, towards="film"), np.float64).run(
        {**rays, WEIGHT: np.ones(len(origins))}, [X, Y, Z, L, M, N, WEIGHT], len(origins))
    points, cosine = back[:2].T, back[5]
    slope = back[3:5].T / cosine[:, None]
    film, rear = points - back[2][:, None] * slope, points - (back[2] + film_distance)[:, None] * slope
    share = back[6]                                 # that the stop passes
    passes, distance, facing = share > 0.0, np.array(film_distance), np.array(1.0)
    if not pose.is_upright:
        film = pose.film_points(film, slope)
        points = pose.points(film)
        distance = film_distance + points[:, 2]
        facing = (np.column_stack([slope, np.ones(len(slope))]) * pose.normals(points)).sum(1)     # cos φ / cos θ
        passes = passes & (facing > 0.0)
    area = np.zeros(len(passes))
    area[passes] = regions.sampled_area(film[passes], rear[passes])
    with np.errstate(divide="ignore"):
        direction_pdf = distance**2 / (area * cosine**3)
    position_pdf = np.ones(len(passes)) / film_area
    we = share * facing * position_pdf * gain
    return FilmImportance(film, we, position_pdf, direction_pdf, passes & (area > 0.0))


def foremost(lens: Lens) -> float:
    """Coordinate z (mm, lens frame) of a lens's foremost point: its first vertex, or glass or rim before it."""
    return min(0.0, float(np.fmin.reduce(first_surface(lens)[:, 2])))


def first_surface(lens: Lens) -> np.ndarray:
    """Points (n, 3) of the first surface, lens frame (mm): one of its rim where it is in line, else all over it."""
    first, frame = lens.surfaces[0], lens.frames[0]
    if frame is None:
        return np.array([[first.semi_diameter, 0.0, float(first.sag(first.semi_diameter))]])
    r = first.semi_diameter * np.linspace(0.0, 1.0, 33)[:, None]
    turn = np.linspace(0.0, 2.0 * math.pi, 33)
    x, y = (r * np.cos(turn)).ravel(), (r * np.sin(turn)).ravel()
    return np.column_stack([x, y, first.sag(x, y)]) @ frame.rotation.T + frame.shift
