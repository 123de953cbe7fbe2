"""Projection through a real lens, and light that is traced to its film. Lengths in mm, camera frame.

Newton's method finds the film point with the very stages that the camera renders with, in double precision. It brings
to zero the angle between the ray and the line from its origin to the point, which has no singular direction: points
next to and behind the front of a fisheye are found as well.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lensbench.core.cameras.film_landing import FilmImportance, FilmLanding, landing_step, posed_landing_step
from lensbench.core.imaging.film import Film, FilmPose
from lensbench.core.kernels.block import U0, U1, WEIGHT, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import unit_disk
from lensbench.core.optics.block_trace import trace_steps
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.paraxial import first_order, ray_matrix
from lensbench.core.optics.prescription import Lens
from lensbench.core.pupils.film_grid_sampler import PupilGrid, SpectralPupilGrid
from lensbench.core.pupils.posed_sampler import PosedPupil
from lensbench.core.pupils.radial_sampler import PupilTable

Regions = PupilTable | PupilGrid | PosedPupil


@dataclass(frozen=True, eq=False)
class FilmRegions:
    """Exit-pupil regions of a film. widened: for rays that are traced, so that none is missed at the edge."""

    lens: Lens
    film: Film
    film_distance: float
    pose: FilmPose
    widened: bool

    def at(self, wavelength: float) -> Regions:
        """The regions at a wavelength (µm): by film radius, over a film grid, or by radius and distance."""
        lens, distance = self.lens, self.film_distance
        if not lens.is_rotationally_symmetric:
            return self._grids.at(wavelength)
        if self.pose.is_upright:
            return PupilTable.of(lens, distance, self.film.diagonal / 2.0, wavelength, widened=self.widened)
        return PosedPupil.of(lambda z, radius: PupilTable.of(lens, z, radius, wavelength, self.widened),
                             distance, lens.length + distance - first_order(lens, D_LINE).exit_pupil.z, self.pose,
                             self.pose.extent(self.film.width, self.film.height))

    @cached_property
    def _grids(self) -> SpectralPupilGrid:
        return SpectralPupilGrid(self.lens, self.film_distance, self.film.width / 2.0, self.film.height / 2.0,
                                 self.pose)

    def stage_uv(self, film_xy: np.ndarray, pupil_uv: np.ndarray) -> np.ndarray:
        """Angle (turns) and squared radius (n, 2) of pupil samples in the regions of film points, both (n, 2).

        In the direction of `unit_disk`: the same sample is nearly the same pupil point for every film point and model.
        """
        disk = unit_disk(pupil_uv) * self._pupil_side
        if self.lens.is_rotationally_symmetric:         # regions rotate with the film point, and halves are mirrored
            if not self.pose.is_upright:
                film_xy = self.pose.points(film_xy)[:, :2]
            azimuth = np.where((film_xy * film_xy).sum(1) > 1e-12, np.arctan2(film_xy[:, 1], film_xy[:, 0]), 0.0)
            angle = np.arctan2(disk[:, 1], disk[:, 0]) - azimuth
            turn = np.arctan2(np.sin(angle), np.cos(angle)) / (2.0 * math.pi)
            turn = np.where(turn < 0.0, 0.5 - turn, np.minimum(turn, np.nextafter(0.5, 0.0)))
        else:                                           # regions are mirrored into the first quadrant of the film
            disk = disk * np.where(film_xy < 0.0, -1.0, 1.0)
            turn = np.arctan2(disk[:, 1], disk[:, 0]) / (2.0 * math.pi) % 1.0
        return np.stack([np.clip(turn, 0.0, np.nextafter(1.0, 0.0)), np.minimum((disk * disk).sum(1), 1.0)], 1)

    @property
    def reach(self) -> float:
        """Largest distance from the axis (mm) at which rays of a posed film cross z = 0."""
        rear = self.lens.surfaces[-1].semi_diameter
        extent = self.pose.extent(self.film.width, self.film.height)
        r, z = np.hypot(extent[:, 0], extent[:, 1]), extent[:, 2]
        return float((r + np.abs(z) * (r + rear) / (self.film_distance + z)).max())

    @cached_property
    def _pupil_side(self) -> float:
        """Sign of the height of a point of the stop in the exit pupil: −1 where that is an inverted image of it."""
        return math.copysign(1.0, ray_matrix(self.lens, self.lens.stop_index, len(self.lens.surfaces))[3])


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
    """Points (n, 3) of the first surface, lens frame (mm): one of its edge where it is centred, else all over it."""
    first, frame = lens.surfaces[0], lens.frames[0]
    if frame is None:
        return np.array([[first.semi_diameter, 0.0, float(first.sag(first.semi_diameter))]])
    r = first.semi_diameter * np.linspace(0.0, 1.0, 33)[:, None]
    turn = np.linspace(0.0, 2.0 * math.pi, 33)
    x, y = (r * np.cos(turn)).ravel(), (r * np.sin(turn)).ravel()
    return np.column_stack([x, y, first.sag(x, y)]) @ frame.rotation.T + frame.shift


RADII = 129             # film radii of the table that gives the starting points
BEYOND = 1.25           # largest of them over the film's radius: a central ray may fall beside the film
ITERATIONS = 60         # of Newton's method; five or six suffice except near the end of the light
RESTARTS = 12           # further starting points after a failure
CONVERGED = 1e-10       # radians

StageUV = Callable[[np.ndarray, np.ndarray], np.ndarray]        # film points (n, 2) and pupil samples → U0, U1 (n, 2)


def solve_film_points(program: Program, points: np.ndarray, pupil_uv: np.ndarray, stage_uv: StageUV,
                      middle: tuple[float, float], film_radius: float,
                      start: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Film points (n, 2) in mm for points (n, 3) in mm, and which of them the camera sees, (n,) bool.

    program: the camera's steps from the film to the ray, in float64. stage_uv turns pupil samples (n, 2) into U0, U1
    for a film point. The search begins with the ray of U0, U1 = middle, or at film points start (n, 2). NaN where none
    is found within BEYOND · film_radius. Several film points may see a point far out of focus; the result is one of
    them.
    """
    reach = BEYOND * film_radius
    film = starting_points(program, points, middle, reach) if start is None else start.copy()
    axes, visible = _perpendicular_axes(points), np.zeros(len(points), bool)
    todo = np.nonzero(np.isfinite(film).all(1))[0]
    for again in range(RESTARTS + 1):
        if again:                                       # start on a spiral that fills the film
            angle, radius = again * math.pi * (3.0 - math.sqrt(5.0)), film_radius * math.sqrt(again / (RESTARTS + 1))
            film[todo] = radius * math.cos(angle), radius * math.sin(angle)
        film[todo], visible[todo] = _newton(program, film[todo], points[todo], pupil_uv[todo], stage_uv, axes[todo],
                                            film_radius)
        todo = todo[np.isnan(film[todo, 0])]
        if not todo.size:
            break
    return film, visible


def _newton(program: Program, film: np.ndarray, points: np.ndarray, pupil_uv: np.ndarray, stage_uv: StageUV,
            axes: np.ndarray, film_radius: float) -> tuple[np.ndarray, np.ndarray]:
    """`solve_film_points` with Newton's method, from starting film points (n, 2)."""
    step, reach = 1e-6 * film_radius, BEYOND * film_radius

    def miss(film: np.ndarray, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Angles (m, 2) between rays and points (radians), and weights (m,), −1 where a ray runs away."""
        o, d, weight = _rays(program, film, stage_uv(film, pupil_uv[which]))
        towards = points[which] - o
        with np.errstate(invalid="ignore"):
            towards /= np.sqrt((towards * towards).sum(1))[:, None]
            return (axes[which] @ (d - towards)[..., None])[..., 0], np.where((d * towards).sum(1) > 0.0, weight, -1.0)

    n = len(film)
    best, weights, change = np.full(n, np.inf), np.zeros(n), np.zeros((n, 2))
    film, trial, todo = film.copy(), film.copy(), np.arange(n)
    for _ in range(ITERATIONS):
        off, weight = miss(trial[todo], todo)
        size = np.hypot(off[:, 0], off[:, 1])
        better = size < best[todo]                      # False for NaN
        change[todo[~better]] *= 0.25                   # a shorter step from the same place
        new, off = todo[better], off[better]
        if new.size:
            # Newton's step, with the Jacobian by differences
            film[new], best[new], weights[new] = trial[new], size[better], weight[better]
            columns = [(miss(film[new] + shift, new)[0] - off) / step for shift in ((step, 0.0), (0.0, step))]
            (a, b), (c, d) = (column.T for column in columns)
            with np.errstate(divide="ignore", invalid="ignore"):
                u, v = off.T / (a * d - b * c)
                ahead = np.stack([c * v - d * u, b * u - a * v], 1)
                ahead *= np.minimum(1.0, 0.2 * film_radius / np.hypot(ahead[:, 0], ahead[:, 1]))[:, None]
            change[new] = np.where(np.isfinite(ahead), ahead, 0.0)
        trial[todo] = film[todo] + change[todo]
        far = todo[np.hypot(trial[todo, 0], trial[todo, 1]) > reach]
        change[far] *= 0.5
        trial[far] = film[far] + change[far]
        todo = todo[np.hypot(change[todo, 0], change[todo, 1]) > 1e-15 * film_radius]
        if not todo.size:
            break
    converged = (best < CONVERGED) & (weights >= 0.0)
    return np.where(converged[:, None], film, np.nan), converged & (weights > 0.0)


def _rays(program: Program, film: np.ndarray, pupil_uv: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Origins (n, 3), directions (n, 3) and weights (n,) of the rays of film points."""
    inputs = {X: film[:, 0], Y: film[:, 1], U0: pupil_uv[:, 0], U1: pupil_uv[:, 1]}
    out = program.run(inputs, [X, Y, Z, L, M, N, WEIGHT], len(film))
    return out[:3].T, out[3:6].T, out[6]


def _perpendicular_axes(points: np.ndarray) -> np.ndarray:
    """Two unit vectors (n, 2, 3) perpendicular to the direction of each point and to each other (Duff et al. 2017)."""
    with np.errstate(invalid="ignore"):
        x, y, z = (points / np.sqrt((points * points).sum(1))[:, None]).T
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    first = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], 1)
    return np.stack([first, np.stack([b, sign + y * y * a, -y], 1)], 1)


def starting_points(program: Program, points: np.ndarray, middle: tuple[float, float], reach: float) -> np.ndarray:
    """Starting film points (n, 2), at the radius whose central ray passes the point; NaN where no ray runs towards it.

    Between neighbours of a table of film radii, the signed angle from ray to point changes its sign in the plane of the
    axis and the point; where it never does, the nearest radius serves.
    """
    radii = np.linspace(0.0, reach, RADII)
    o, d, _ = _rays(program, np.stack([radii, 0.0 * radii], 1), np.tile(middle, (RADII, 1)))
    away = np.hypot(points[:, 0], points[:, 1])
    guess = np.full(len(points), np.nan)
    for first in range(0, len(points), 4096):           # a table of at most 4096 × RADII at a time
        chunk = slice(first, first + 4096)
        dx, dz = -away[chunk, None] - o[:, 0], points[chunk, None, 2] - o[:, 2]
        with np.errstate(invalid="ignore"):
            side = np.arctan2(d[:, 0] * dz - d[:, 2] * dx, d[:, 0] * dx + d[:, 2] * dz)     # angle from ray to point
            near = np.abs(side)
            turns = (side[:, :-1] * side[:, 1:] <= 0.0) & (near[:, :-1] + near[:, 1:] < 1.0)
        k = np.argmax(turns, 1)
        i = np.arange(len(k))
        low, high = side[i, k], side[i, k + 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(low != high, low / (low - high), 0.0)
        near = np.where(near < 1.0, near, np.inf)
        least = np.where(np.isfinite(near.min(1)), radii[np.argmin(near, 1)], np.nan)
        guess[chunk] = np.where(turns.any(1), radii[k] + share * (radii[1] - radii[0]), least)
    with np.errstate(divide="ignore", invalid="ignore"):
        return -points[:, :2] * np.where(away > 0.0, guess / away, 0.0)[:, None]
