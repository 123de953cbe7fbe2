"""Ideal lenses, free of aberrations: pinhole, thin lens, thick lens and telecentric lens. Camera frame, mm.

An ideal lens maps film and pupil linearly to rays, equally across and up. The ray of the film point x through the pupil
point a of the unit disk crosses the plane z at origin_film · x + origin_pupil · a, and moves sideways by slope_film · x
+ slope_pupil · a for each mm towards the scene (Welford, Aberrations of Optical Systems, ch. 3).

The film may have a pose. The ray of its point P, z behind the upright film, meets that plane at P + z s, with the slope
towards the scene s = (approach_film · P + approach_pupil · a) / (1 − approach_film · z), and goes on as from there.
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.core.imaging.film import NUMBERS, FilmPose, film_normal, place_on_film
from lensbench.core.kernels.block import U0, U1, WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import concentric_disk, unit_disk
from lensbench.core.optics.iris import Iris

ROUND = Iris()

# Parameters of `gaussian` and `hole`: the numbers of `Gaussian` in their order, then the weight of the axial ray
(PLANE_Z, ORIGIN_FILM, ORIGIN_PUPIL, SLOPE_FILM, SLOPE_PUPIL, APPROACH_FILM, APPROACH_PUPIL, AXIAL_WEIGHT) = range(8)


class Gaussian(NamedTuple):
    """Linear map from film point x (mm) and pupil point a to rays that start on the plane z (mm, camera frame).

    The slope on the film's side, x · approach_film + a · approach_pupil, gives the angle θ of the falloff cos⁴θ. iris:
    the open part of the unit disk.
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
        """Pupil area over its squared distance from the film's centre: of samples, or of a pinhole."""
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
        """Film points (n, 2) whose rays through pupil samples (n, 2) meet points (n, 3), camera frame, mm; and which
        lie before it.
        """
        n = len(points)
        inputs = {X: np.zeros(n), Y: np.zeros(n), U0: pupil_uv[:, 0], U1: pupil_uv[:, 1]}
        x, y, l, m, n_ = Program(self.steps(1.0), np.float64).run(inputs, [X, Y, L, M, N], n)    # of the film's centre
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
    """Thin lens at z, a pinhole for radius 0; behind: to the film, focus: to the plane in focus, also inf; mm."""
    return Gaussian(z, 0.0, radius, -1.0 / behind, -radius / focus, -1.0 / behind, radius / behind, iris)


def telecentric(scale: float, radius: float, focus: float, iris: Iris = ROUND) -> Gaussian:
    """Telecentric lens: every film point sees along the axis, `scale` mm of scene for each mm of film.

    Its rays form cones of `radius` at z = 0 with their apex at `focus` (mm); a single ray for inf.
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


# Parameters of `gaussian_from_posed_film`, behind the numbers of the pose: those of `gaussian`; then 1 where the light
# falls off with the angles and the distance, 0 where every ray has the same weight
(POSED_PLANE_Z, POSED_ORIGIN_FILM, POSED_ORIGIN_PUPIL, POSED_SLOPE_FILM, POSED_SLOPE_PUPIL, POSED_APPROACH_FILM,
 POSED_APPROACH_PUPIL, POSED_AXIAL_WEIGHT, FALLS_OFF) = range(NUMBERS, NUMBERS + 9)


def posed_steps(lens: Gaussian, pose: FilmPose, gain: float, falls_off: bool) -> list[Step]:
    """Steps from the film point X, Y of a posed film to its ray; WEIGHT becomes cos³θ · cos φ · (distances)² · gain.

    θ is measured from the axis, φ from the film's normal; falls_off: False for the weight `gain` of every ray.
    """
    if lens.is_hole:
        lens = lens._replace(approach_pupil=0.0)        # kept by a pinhole for its brightness alone
    p = np.concatenate([pose.numbers, lens[:-1], [gain, float(falls_off)]])
    if lens.is_hole:
        return [Step(gaussian_from_posed_film, p)]
    return [*lens.iris.steps, Step(gaussian_from_posed_film, p), *lens.iris.weighing]


def posed_film_points(lens: Gaussian, pose: FilmPose, points: np.ndarray,
                      pupil_uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """`Gaussian.film_points` for a posed film, in the film's own frame (mm)."""
    upright, visible = lens.film_points(points, pupil_uv)
    # The slope on the film's side, from the pupil point that the ray has in common with the film's centre
    slopes = lens.approach_film * upright
    if not lens.is_hole:
        if lens.iris.steps:
            pupil_uv = Program(lens.iris.steps, np.float64).run({U0: pupil_uv[:, 0], U1: pupil_uv[:, 1]}, [U0, U1],
                                                                len(pupil_uv)).T
        slopes = slopes + lens.approach_pupil * unit_disk(pupil_uv)
    film = pose.film_points(upright, -slopes)
    return film, visible & np.isfinite(film).all(1)


@stage
def gaussian_from_posed_film(lanes, p, ints, key):
    """Turn the film point X, Y of a posed film and the pupil sample U0, U1 into a ray. p: the pose, then PLANE_Z …"""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    u, v = row[U0], row[U1]
    plane, origin, origin_p = p[POSED_PLANE_Z], p[POSED_ORIGIN_FILM], p[POSED_ORIGIN_PUPIL]
    slope, slope_p = p[POSED_SLOPE_FILM], p[POSED_SLOPE_PUPIL]
    aim, aim_p, gain, falls = p[POSED_APPROACH_FILM], p[POSED_APPROACH_PUPIL], p[POSED_AXIAL_WEIGHT], p[FALLS_OFF]
    for i in range(B):
        a, b = concentric_disk(real, v[i], u[i])
        px, py, pz = place_on_film(p, x[i], y[i])
        fx, fy, fz = film_normal(p, px, py, pz)
        # Slope towards the scene on the film's side, and where the ray meets z = 0
        nearer = real(1) / (real(1) - aim * pz)
        ex, ey = (px * aim + a * aim_p) * nearer, (py * aim + b * aim_p) * nearer
        qx, qy = px + pz * ex, py + pz * ey
        # The ray in front of the lens
        dx, dy = qx * slope + a * slope_p, qy * slope + b * slope_p
        size = real(1) / math.sqrt(dx * dx + dy * dy + real(1))
        l[i], m[i], n[i] = dx * size, dy * size, -size
        x[i], y[i], z[i] = qx * origin + a * origin_p, qy * origin + b * origin_p, plane
        # cos³θ · cos φ on the film's side, over the squared distance to the pupil
        c2 = real(1) / (ex * ex + ey * ey + real(1))
        facing = fz - fx * ex - fy * ey
        facing = facing if (facing > real(0)) & (nearer > real(0)) else real(0)
        weight[i] = gain * (falls * c2 * c2 * facing * nearer * nearer + real(1) - falls)
