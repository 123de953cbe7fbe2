"""The way back: where light that reaches a camera falls on its film, and how bright it makes the picture.

A ray of the camera frame that travels towards the film carries in WEIGHT an
étendue: cos θ · area · solid angle, in mm² sr. These stages find its place on
the raster, and make its WEIGHT the value of a pixel on which radiance 1 in that
étendue falls alone: the very measure that the camera's own rays estimate.
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.cameras.ideal_lens import Gaussian
from lensbench.imaging.film import Film
from lensbench.kernels.block import CLEARANCE, WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage


class FilmLanding(NamedTuple):
    """What a camera does with light that comes to it."""

    steps: list[Step]       # from the ray towards the film (X … N) and its WEIGHT to raster X, Y and WEIGHT
    bounding: list[Step]    # the same without the blades of the stop: then CLEARANCE tells how near a ray is to passing
    front: float            # z (mm, camera frame) of the axis point before the lens that rays are aimed about
    radius: float           # mm: rays that miss the sphere of this radius about it do not pass; 0: a pinhole


@stage
def land(lanes, p, key):
    """From the last surface on to the film. p: mm per pixel across, half the width, the same downwards, the gain."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    across, right, down, bottom, gain = real(1) / p[0], p[1], real(1) / p[2], p[3], p[4]
    for i in range(B):
        t = -z[i] / n[i]
        x[i] = (right - (x[i] + t * l[i])) * across
        y[i] = (bottom + (y[i] + t * m[i])) * down
        z[i] = real(0)
        weight[i] *= gain


@stage
def land_ideal(lanes, p, key):
    """Through a lens without aberrations to the film.

    p: as for `land`, then z of a plane; a ray that crosses it at P with the slope S (to the scene, for each mm)
    comes from the film point p[6] P + p[7] S by the place p[8] P + p[9] S of the unit disk in the pupil, with the
    slopes p[10] of the one and p[11] of the other on the film's side. Such a lens keeps no
    étendue: the picture is cos⁴ of the film's side, for every part of the pupil. L, M become the place in the pupil.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight, margin = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT], row[CLEARANCE]
    across, right, down, bottom, gain, plane = real(1) / p[0], p[1], real(1) / p[2], p[3], p[4], p[5]
    film_p, film_s, pupil_p, pupil_s, aim, aim_p = p[6], p[7], p[8], p[9], p[10], p[11]
    for i in range(B):
        t = (plane - z[i]) / n[i]
        px, py, sx, sy = x[i] + t * l[i], y[i] + t * m[i], -l[i] / n[i], -m[i] / n[i]
        fx, fy, a, b = film_p * px + film_s * sx, film_p * py + film_s * sy, pupil_p * px + pupil_s * sx, (
            pupil_p * py + pupil_s * sy)
        ex, ey = aim * fx + aim_p * a, aim * fy + aim_p * b
        c2 = (real(1) + sx * sx + sy * sy) / (real(1) + ex * ex + ey * ey)
        margin[i] = a * a + b * b
        weight[i] = weight[i] * c2 * c2 * gain if (margin[i] <= real(1)) & (n[i] > real(0)) else real(0)
        x[i], y[i], z[i], l[i], m[i] = (right - fx) * across, (bottom + fy) * down, real(0), a, b


def landing_step(film: Film, gain: float) -> Step:
    """The step from the last surface to the raster; gain: the picture's value of an irradiance of 1 radiance · sr."""
    raster = film.step.parameters
    return Step(land, np.array([*raster, gain / (raster[0] * raster[2])]))


def ideal_film_landing(lens: Gaussian, film: Step, gain: float) -> FilmLanding | None:
    """Of a lens without aberrations whose rays have the weight cos⁴ · gain; film: the step from raster to film.

    None where its rays are parallel, or start on the film.
    """
    z, origin, origin_p, slope, slope_p, aim, aim_p, iris = lens
    pixel = film.parameters[0] * film.parameters[2]
    whole = origin * slope_p - origin_p * slope
    if slope == 0.0 or (whole == 0.0 and origin != 0.0):
        return None
    if whole == 0.0:
        numbers = [gain / slope**2 / pixel, z, 0.0, 1.0 / slope, 0.0, 0.0, aim, 0.0]
        arriving = [Step(land_ideal, np.array([*film.parameters, *numbers]))]
        return FilmLanding(arriving, arriving, z, 0.0)
    numbers = [gain / (iris.area * whole**2) / pixel, z, slope_p / whole, -origin_p / whole, -slope / whole,
               origin / whole, aim, aim_p]
    arriving = [Step(land_ideal, np.array([*film.parameters, *numbers]))]
    swapped = Step(swap_raster_and_pupil, np.zeros(1))
    covered = [] if iris.is_round else [swapped, *iris.blocking(1.0), swapped]
    reach = abs(origin_p) + abs(origin) * math.hypot(film.parameters[1], film.parameters[3])
    return FilmLanding([*arriving, *covered], arriving, z, reach)


@stage
def swap_raster_and_pupil(lanes, p, key):
    """X, Y and L, M change places: of the raster and of the pupil, after `land_ideal`."""
    row = rows(lanes)
    x, y, l, m = row[X], row[Y], row[L], row[M]
    for i in range(B):
        x[i], y[i], l[i], m[i] = l[i], m[i], x[i], y[i]
