"""Lenses without aberrations, in the frame of the camera (mm): pinhole, thin lens, thick lens, telecentric lens.

What such a lens does is linear, and the same across and up: the ray of the film
point x, by the place a of the unit disk in the pupil, crosses a plane z at
origin_film x + origin_pupil a, and runs there on by slope_film x + slope_pupil a for each mm towards
the scene. (Gaussian optics: Welford, Aberrations of Optical Systems, ch. 3.)
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.kernels.block import U0, U1, WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage
from lensbench.kernels.concentric_map import concentric_disk
from lensbench.kernels.program import Program
from lensbench.optics.iris import Iris
from lensbench.optics.paraxial import first_order, ray_matrix
from lensbench.optics.prescription import Lens

ROUND = Iris()


class Gaussian(NamedTuple):
    """The rays of such a lens, which start on the plane z (camera frame, mm).

    approach_film and approach_pupil: the slope on the film's side of the lens, by which
    the light falls off as cos⁴. iris: what of the unit disk is open.
    """

    z: float
    origin_film: float
    origin_pupil: float         # mm
    slope_film: float           # 1/mm
    slope_pupil: float
    approach_film: float        # 1/mm
    approach_pupil: float
    iris: Iris = ROUND

    @property
    def is_hole(self) -> bool:
        """Whether every film point has one ray."""
        return self.origin_pupil == 0.0 and self.slope_pupil == 0.0

    @property
    def cone(self) -> float:
        """Area of the pupil over its squared distance from the film's centre: π tan² of the half angle."""
        return self.iris.area * self.approach_pupil**2

    @property
    def axis_irradiance(self) -> float:
        """∫ cos⁴θ dA / z² on the axis, which is π sin² of the half angle where the iris is round."""
        return self.iris.axis_irradiance(self.approach_pupil, 1.0)

    def steps(self, gain: float) -> list[Step]:
        """The steps from the film point X, Y to its ray; WEIGHT becomes cos⁴θ · gain, θ that of the film's side."""
        if self.is_hole:
            return [Step(hole, np.array([self.z, self.origin_film, self.slope_film, self.approach_film, gain]))]
        return [*self.iris.steps, Step(gaussian, np.array([*self[:-1], gain]))]

    def film_slopes(self, directions: np.ndarray) -> np.ndarray:
        """(2, n, 6): what a mm of film in x and in y adds to origins (mm) and unit directions (n, 3), at a place a."""
        slopes = np.zeros((2, len(directions), 6))
        for axis in range(2):
            slopes[axis, :, axis] = self.origin_film
            change = np.eye(3)[axis] * self.slope_film
            slopes[axis, :, 3:] = unit_direction_change(change, directions, -directions[:, 2])
        return slopes

    def film_points(self, points: np.ndarray, pupil_uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Film points (n, 2) whose rays by these places of the unit square (n, 2) meet points (n, 3), all in mm.

        And which of the points, in the camera frame, lie before the lens, (n,) bool.
        """
        n = len(points)
        given = {X: np.zeros(n), Y: np.zeros(n), U0: pupil_uv[:, 0], U1: pupil_uv[:, 1]}
        x, y, l, m, n_ = Program(self.steps(1.0), np.float64).run(given, [X, Y, L, M, N], n)    # of the film's centre
        before = self.z - points[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            film = np.stack([points[:, 0] - x + before * l / n_, points[:, 1] - y + before * m / n_], 1)
            film /= (self.origin_film + before * self.slope_film)[:, None]
        return film, (before > 0.0) & np.isfinite(film).all(1)


def unit_direction_change(change: np.ndarray, directions: np.ndarray, size: np.ndarray) -> np.ndarray:
    """What a change (…, 3) of vectors adds to their unit directions (n, 3); size (n,): 1 / their lengths."""
    along = (change * directions).sum(-1)[..., None]
    return (change - along * directions) * size[:, None]


def thin(z: float, radius: float, behind: float, focus: float, iris: Iris = ROUND) -> Gaussian:
    """A thin lens at z, or a pinhole where its radius is 0.

    behind: to its (imagined) film; focus: to the plane in focus; mm from the lens, focus may be inf.
    """
    return Gaussian(z, 0.0, radius, -1.0 / behind, -radius / focus, -1.0 / behind, radius / behind, iris)


def telecentric(scale: float, radius: float, focus: float, iris: Iris = ROUND) -> Gaussian:
    """Rays along the axis at z = 0 for every film point, `scale` mm of scene to one of film, in cones of `radius`.

    The cones have their points on the plane at `focus`, mm, which may be inf: then every ray of a point is the same.
    """
    if radius == 0.0 or math.isinf(focus):
        return Gaussian(0.0, -scale, 0.0, 0.0, 0.0, 0.0, 0.0)
    return Gaussian(0.0, -scale, radius, 0.0, -radius / focus, 0.0, radius / focus, iris)


def thick(lens: Lens, film_distance: float) -> Gaussian:
    """A real lens to first order: the principal planes image every film point, and its rays aim at the exit pupil.

    The rays start on the entrance pupil where that lies between the first vertex and the film, otherwise on the
    plane of the first vertex: a pupil at infinity, out in the scene or behind the camera is only pointed at. The
    film is in air, and the exit pupil does not lie on it.
    """
    fo, film = first_order(lens), lens.length + film_distance
    # On the film's side: dy/dz towards the exit pupil, which is the stop's image and may be upside down
    _, _, c, d = ray_matrix(lens, lens.stop_index, len(lens.surfaces))
    if math.isinf(fo.exit_pupil.z):
        film_aims, pupil_aims = 0.0, c * fo.stop_radius
    else:
        away = fo.exit_pupil.z - film
        film_aims, pupil_aims = -1.0 / away, math.copysign(fo.exit_pupil.radius, d) / away
    # To the last vertex, by the inverse of the matrix to the first, and from there to where the rays start
    a, b, c, d = ray_matrix(lens, 0, len(lens.surfaces))
    within = 0.0 <= fo.entrance_pupil.z <= film
    start = fo.entrance_pupil.z if within else 0.0
    rays = []
    for height, slope in ((1.0, film_aims), (0.0, pupil_aims)):
        height -= film_distance * slope
        height, slope = d * height - b * slope, a * slope - c * height
        slope /= lens.front_index
        rays.append((height + start * slope, -slope))
    (origin_film, slope_film), (origin_pupil, slope_pupil) = rays
    if within:
        origin_film = 0.0                               # but for its rounding: all film points share the entrance pupil
    return Gaussian(start - film, origin_film, origin_pupil, slope_film, slope_pupil, -film_aims, -pupil_aims,
                    lens.iris)


@stage
def gaussian(lanes, p, key):
    """From the film point X, Y and the place in the pupil U0, U1 to the ray. p: the numbers of `Gaussian`, gain."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    u, v = row[U0], row[U1]
    place, origin, origin_p, slope, slope_p, aim, aim_p, gain = p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]
    for i in range(B):
        a, b = concentric_disk(real, v[i], u[i])                 # v = 1/2 and u = 1/2: the centre
        dx, dy = x[i] * slope + a * slope_p, y[i] * slope + b * slope_p
        size = real(1) / math.sqrt(dx * dx + dy * dy + real(1))
        l[i], m[i], n[i] = dx * size, dy * size, -size
        ex, ey = x[i] * aim + a * aim_p, y[i] * aim + b * aim_p
        c2 = real(1) / (ex * ex + ey * ey + real(1))
        weight[i] = c2 * c2 * gain
        x[i], y[i], z[i] = x[i] * origin + a * origin_p, y[i] * origin + b * origin_p, place


@stage
def hole(lanes, p, key):
    """From the film point X, Y to its only ray. p: z, origin_film, slope_film, approach_film of `Gaussian`, gain."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    place, origin, slope, aim, gain = p[0], p[1], p[2], p[3], p[4]
    for i in range(B):
        dx, dy = x[i] * slope, y[i] * slope
        size = real(1) / math.sqrt(dx * dx + dy * dy + real(1))
        l[i], m[i], n[i] = dx * size, dy * size, -size
        ex, ey = x[i] * aim, y[i] * aim
        c2 = real(1) / (ex * ex + ey * ey + real(1))
        weight[i] = c2 * c2 * gain
        x[i], y[i], z[i] = x[i] * origin, y[i] * origin, place
