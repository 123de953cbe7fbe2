"""Ideal lenses in front of a film out of line. Camera frame, mm.

A ray of the film point P, which lies z behind the plane of the film in line, meets that plane at P + z s, where s is
its slope towards the scene: s = (approach_film · P + approach_pupil · a) / (1 − approach_film · z) for the pupil point
a. From there on the ray is that of `Gaussian`.
"""

import math

import numpy as np

from lensbench.cameras.ideal_lens import Gaussian
from lensbench.imaging.film_pose import NUMBERS, FilmPose, film_normal, place_on_film
from lensbench.kernels.block import U0, U1, WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage
from lensbench.kernels.concentric_map import concentric_disk, unit_disk
from lensbench.kernels.program import Program

# Parameters of `gaussian_from_posed_film`, behind the numbers of the pose: those of `gaussian`; then 1 where the light
# falls off with the angles and the distance, 0 where every ray has the same weight
(PLANE_Z, ORIGIN_FILM, ORIGIN_PUPIL, SLOPE_FILM, SLOPE_PUPIL, APPROACH_FILM, APPROACH_PUPIL, AXIAL_WEIGHT,
 FALLS_OFF) = range(NUMBERS, NUMBERS + 9)


def posed_steps(lens: Gaussian, pose: FilmPose, gain: float, falls_off: bool) -> list[Step]:
    """Steps from the film point X, Y of a posed film to its ray; WEIGHT becomes cos³θ · cos φ · (distances)² · gain.

    θ is measured from the axis, φ from the film's normal. falls_off: False for the weight `gain` of every ray.
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
    plane, origin, origin_p, slope, slope_p = p[PLANE_Z], p[ORIGIN_FILM], p[ORIGIN_PUPIL], p[SLOPE_FILM], p[SLOPE_PUPIL]
    aim, aim_p, gain, falls = p[APPROACH_FILM], p[APPROACH_PUPIL], p[AXIAL_WEIGHT], p[FALLS_OFF]
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
