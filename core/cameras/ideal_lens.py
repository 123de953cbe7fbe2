"""Ideal lenses, free of aberrations: pinhole, thin lens, thick lens and telecentric lens. Camera frame, mm.

An ideal lens maps film and pupil linearly to rays, alike across and up. The ray of the film point x through the pupil
point a of the unit disk crosses the plane z at origin_film · x + origin_pupil · a, and moves sideways by
slope_film · x + slope_pupil · a for each mm towards the scene. (Gaussian optics: Welford, Aberrations of Optical
Systems, ch. 3.)
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.kernels.block import U0, U1, WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage
from lensbench.kernels.concentric_map import concentric_disk
from lensbench.kernels.program import Program
from lensbench.optics.iris import Iris

ROUND = Iris()

# Parameters of `gaussian` and `hole`: the numbers of `Gaussian` in their order, then the weight of the axial ray
(PLANE_Z, ORIGIN_FILM, ORIGIN_PUPIL, SLOPE_FILM, SLOPE_PUPIL, APPROACH_FILM, APPROACH_PUPIL, AXIAL_WEIGHT) = range(8)


class Gaussian(NamedTuple):
    """Linear map from film point x (mm) and pupil point a to rays that start on the plane z (mm, camera frame).

    approach_film and approach_pupil give the slope on the film's side of the lens, x · approach_film +
    a · approach_pupil, with whose angle θ the light falls off as cos⁴θ. iris: the open part of the unit disk.
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
        """Whether every film point has a single ray."""
        return self.origin_pupil == 0.0 and self.slope_pupil == 0.0

    @property
    def cone(self) -> float:
        """Pupil area over its squared distance from the film's centre: π tan² of the half angle.

        The area is that of the pupil's samples; a pinhole has that of the light.
        """
        return (self.iris.area if self.is_hole else self.iris.sampled_area) * self.approach_pupil**2

    @property
    def axis_irradiance(self) -> float:
        """∫ cos⁴θ dA / z² on the axis; π sin² of the half angle for a round iris."""
        return self.iris.axis_irradiance(self.approach_pupil, 1.0)

    def steps(self, gain: float) -> list[Step]:
        """Steps from the film point X, Y to its ray; WEIGHT becomes cos⁴θ · gain, with θ on the film's side."""
        p = np.empty(AXIAL_WEIGHT + 1)
        p[:AXIAL_WEIGHT], p[AXIAL_WEIGHT] = self[:-1], gain
        return [Step(hole, p)] if self.is_hole else [*self.iris.steps, Step(gaussian, p), *self.iris.weighing]

    def film_slopes(self, directions: np.ndarray) -> np.ndarray:
        """Derivatives (2, n, 6) of origins (mm) and unit directions (n, 3) per mm of film in x and y, at a fixed a."""
        slopes = np.zeros((2, len(directions), 6))
        for axis in range(2):
            slopes[axis, :, axis] = self.origin_film
            change = np.eye(3)[axis] * self.slope_film
            slopes[axis, :, 3:] = unit_direction_change(change, directions, -directions[:, 2])
        return slopes

    def film_points(self, points: np.ndarray, pupil_uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Film points (n, 2) whose rays through pupil samples (n, 2) meet points (n, 3) of the camera frame, in mm.

        Also returns which points lie in front of the lens, (n,) bool.
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
    """Change of unit directions (n, 3) by a change (…, 3) of the vectors along them; size (n,): 1 / their lengths."""
    along = (change * directions).sum(-1)[..., None]
    return (change - along * directions) * size[:, None]


def thin(z: float, radius: float, behind: float, focus: float, iris: Iris = ROUND) -> Gaussian:
    """Thin lens at z (mm), a pinhole for radius 0.

    behind: distance to the (imagined) film; focus: distance to the plane in focus, which may be inf; both mm.
    """
    return Gaussian(z, 0.0, radius, -1.0 / behind, -radius / focus, -1.0 / behind, radius / behind, iris)


def telecentric(scale: float, radius: float, focus: float, iris: Iris = ROUND) -> Gaussian:
    """Telecentric lens: every film point sees along the axis, `scale` mm of scene for each mm of film.

    Its rays form cones of `radius` (mm) at z = 0 with their apex at the distance `focus` (mm); a single ray for inf.
    """
    if radius == 0.0 or math.isinf(focus):
        return Gaussian(0.0, -scale, 0.0, 0.0, 0.0, 0.0, 0.0)
    return Gaussian(0.0, -scale, radius, 0.0, -radius / focus, 0.0, radius / focus, iris)


@stage
def gaussian(lanes, p, ints, key):
    """Turn the film point X, Y and pupil sample U0, U1 into a ray of an ideal lens. p: PLANE_Z … AXIAL_WEIGHT."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    u, v = row[U0], row[U1]
    plane, origin, origin_p, slope, slope_p = p[PLANE_Z], p[ORIGIN_FILM], p[ORIGIN_PUPIL], p[SLOPE_FILM], p[SLOPE_PUPIL]
    aim, aim_p, gain = p[APPROACH_FILM], p[APPROACH_PUPIL], p[AXIAL_WEIGHT]
    for i in range(B):
        # Pupil point (a, b) of the unit disk; u = v = 1/2 is its centre
        a, b = concentric_disk(real, v[i], u[i])
        # Direction towards the scene
        dx, dy = x[i] * slope + a * slope_p, y[i] * slope + b * slope_p
        size = real(1) / math.sqrt(dx * dx + dy * dy + real(1))
        l[i], m[i], n[i] = dx * size, dy * size, -size
        # cos⁴θ on the film's side
        ex, ey = x[i] * aim + a * aim_p, y[i] * aim + b * aim_p
        c2 = real(1) / (ex * ex + ey * ey + real(1))
        weight[i] = c2 * c2 * gain
        x[i], y[i], z[i] = x[i] * origin + a * origin_p, y[i] * origin + b * origin_p, plane


@stage
def hole(lanes, p, ints, key):
    """Turn the film point X, Y into its only ray, through a pinhole or parallel. p: PLANE_Z … AXIAL_WEIGHT."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    plane, origin, slope, aim, gain = p[PLANE_Z], p[ORIGIN_FILM], p[SLOPE_FILM], p[APPROACH_FILM], p[AXIAL_WEIGHT]
    for i in range(B):
        # Direction towards the scene
        dx, dy = x[i] * slope, y[i] * slope
        size = real(1) / math.sqrt(dx * dx + dy * dy + real(1))
        l[i], m[i], n[i] = dx * size, dy * size, -size
        # cos⁴θ on the film's side
        ex, ey = x[i] * aim, y[i] * aim
        c2 = real(1) / (ex * ex + ey * ey + real(1))
        weight[i] = c2 * c2 * gain
        x[i], y[i], z[i] = x[i] * origin, y[i] * origin, plane
