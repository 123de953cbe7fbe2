"""Film landing: the raster point and the pixel value of traced light, and the importance of rays.

A ray of the camera frame that travels towards the film carries in WEIGHT an étendue, cos θ · area · solid angle, in mm²
sr. The stages find where it lands, and turn WEIGHT into the pixel value of radiance 1 in that étendue alone: the same
measure that the camera's own rays estimate.

The mean of a film's readings of a radiance L is ∫∫ W L cos θ dω dA over all rays that leave the camera, θ from its
axis. `Camera.generate_rays` chooses rays with one density per area and one per solid angle: W cos θ is the product of
both and of the ray's weight. (Veach 1997, Robust Monte Carlo Methods for Light Transport Simulation, ch. 8; Pharr,
Jakob and Humphreys, Physically Based Rendering, third edition, ch. 16, where every weight is 1.)
"""

import math
from typing import NamedTuple

import numpy as np

from lensbench.core.cameras.ideal_lens import Gaussian
from lensbench.core.imaging.film import Film, FilmPose
from lensbench.core.kernels.block import CLEARANCE, WEIGHT, B, L, M, N, Step, X, Y, Z, rows, stage

HIT = 1e-6              # mm from the one point, or radians from the one direction, of a camera with a single one


class Importance(NamedTuple):
    """Importance and densities of n rays. A ray that no film point sends has zeros and a NaN raster point.

    Source: Veach 1997, ch. 8.

    Behind a bare sensor or a real lens, both densities are those of the ray where it leaves the film, which determines
    the ray in the scene: W and cos θ dω dA are the same before and behind a lens.

    Args:
        we: (n,) array. Importance W in 1 / (mm² sr), times seconds with physical weights. For a camera that sees from a
            point it is in 1 / sr (for a panorama or an ideal fisheye, which have no axis, with θ = 0); for parallel
            rays in 1 / mm².
        position_pdf: (n,) array. Density (1 / mm²) of the point where the ray crosses the entrance pupil or, for a
            pupil at infinity, the plane in focus; 1 where there is one choice.
        direction_pdf: (n,) array. Density (1 / sr) of the direction at that point; 1 where there is one choice.
        raster: (n, 2) array. Raster points (pixels) of the rays.
        visible: (n,) bool array. Whether each ray is a ray of this camera.
    """

    we: np.ndarray
    position_pdf: np.ndarray
    direction_pdf: np.ndarray
    raster: np.ndarray
    visible: np.ndarray


class FilmImportance(NamedTuple):
    """`Importance` by film points (n, 2) in mm; `passes` says whether each ray passes the camera."""

    film: np.ndarray
    we: np.ndarray
    position_pdf: np.ndarray
    direction_pdf: np.ndarray
    passes: np.ndarray
    is_point: bool = False      # whether all rays cross one point, so that W has no area


def gaussian_importance(lens: Gaussian, gain: float, film_area: float, origins: np.ndarray,
                        directions: np.ndarray) -> FilmImportance:
    """Importance of rays of an ideal lens: origins (mm) and unit directions (n, 3), camera frame; film_area: mm²."""
    is_point = lens.is_hole and lens.slope_film != 0.0
    cosine = -directions[:, 2]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        slope = directions[:, :2] / cosine[:, None]
        crossing = origins[:, :2] + (origins[:, 2] - lens.z)[:, None] * slope
        one, per_slope = np.ones(len(cosine)), 1.0 / cosine**3          # sr per unit of slope²
        a, share = np.zeros_like(slope), one
        if is_point:
            film, position_pdf = slope / lens.slope_film, one
            direction_pdf = per_slope / (film_area * lens.slope_film**2)
            passes = np.hypot(crossing[:, 0], crossing[:, 1]) <= HIT
        elif lens.is_hole:
            film, direction_pdf = crossing / lens.origin_film, one
            position_pdf = one / (film_area * lens.origin_film**2)
            passes = np.hypot(slope[:, 0], slope[:, 1]) <= HIT
        else:
            determinant = lens.origin_film * lens.slope_pupil - lens.origin_pupil * lens.slope_film
            film = (lens.slope_pupil * crossing - lens.origin_pupil * slope) / determinant
            a = (lens.origin_film * slope - lens.slope_film * crossing) / determinant
            share = lens.iris.transmission(a[:, 0], a[:, 1])
            passes = share > 0.0
            if lens.slope_film != 0.0:
                position_pdf = one / (lens.iris.sampled_area * (determinant / lens.slope_film) ** 2)
                direction_pdf = per_slope / (film_area * lens.slope_film**2)
            else:
                position_pdf = one / (film_area * lens.origin_film**2)
                direction_pdf = per_slope / (lens.iris.sampled_area * lens.slope_pupil**2)
        approach = lens.approach_film * film + lens.approach_pupil * a
        weight = share * gain / (1.0 + (approach**2).sum(1)) ** 2
        we = weight * position_pdf * direction_pdf / cosine
        return FilmImportance(film, we, position_pdf, direction_pdf, passes & (cosine > 0.0), is_point)


def point_importance(film: np.ndarray, density: np.ndarray, visible: np.ndarray, origins: np.ndarray,
                     directions: np.ndarray) -> FilmImportance:
    """Importance for a camera that sees from its origin with weight 1; density: of its directions (1 / sr)."""
    along = (origins * directions).sum(1)[:, None]
    aside = np.linalg.norm(origins - along * directions, axis=1)
    return FilmImportance(film, density, np.ones(len(film)), density, visible & (aside <= HIT), True)


# Parameters of `land`: mm per pixel and half the film (mm), across and down, as for the film's step; then the gain.
# `land_ideal` has these, then z of a plane (mm): a ray that crosses it at P with the slope S towards the scene comes
# from the film point FILM_P · P + FILM_S · S by the pupil point PUPIL_P · P + PUPIL_S · S of the unit disk, and its
# slope on the film's side is APPROACH_FILM · film point + APPROACH_PUPIL · pupil point.
(PIXEL_X, HALF_X, PIXEL_Y, HALF_Y, GAIN,
 PLANE_Z, FILM_P, FILM_S, PUPIL_P, PUPIL_S, APPROACH_FILM, APPROACH_PUPIL) = range(12)


Triple = tuple[float, float, float]


class FilmLanding(NamedTuple):
    """Stages of a camera for light that is traced from its source."""

    steps: list[Step]       # from a ray towards the film, X … N, and its WEIGHT to raster X, Y and WEIGHT
    bounding: list[Step]    # the same without the stop's blades; CLEARANCE then says by how much a ray passes or misses
    front: Triple           # point before the lens (mm, camera frame) at which rays are aimed
    radius: float           # mm; rays that miss the sphere of this radius about that point are blocked; 0: a pinhole


@stage
def land(lanes, p, ints, key):
    """Land a ray behind the last surface on the film: raster X, Y and WEIGHT. p: PIXEL_X … GAIN."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    across, right, down, bottom, gain = real(1) / p[PIXEL_X], p[HALF_X], real(1) / p[PIXEL_Y], p[HALF_Y], p[GAIN]
    for i in range(B):
        t = -z[i] / n[i]
        x[i] = (right - (x[i] + t * l[i])) * across
        y[i] = (bottom + (y[i] + t * m[i])) * down
        z[i] = real(0)
        weight[i] *= gain


@stage
def land_on_posed_film(lanes, p, ints, key):
    """Land a ray behind the last surface on a tilted or curved film: raster X, Y and WEIGHT. p: PIXEL_X … GAIN, the
    pose.

    A pixel of a curved film is larger than its part of the plane of the film's middle, by the cosine between both.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT]
    across, right, down, bottom, gain = real(1) / p[PIXEL_X], p[HALF_X], real(1) / p[PIXEL_Y], p[HALF_Y], p[GAIN]
    q = p[GAIN + 1:]
    cx, cy, xx, xy, xz, yx, yy, yz, fx, fy, fz = q[0], q[1], q[2], q[3], q[4], q[5], q[6], q[7], q[8], q[9], q[10]
    c = q[11]
    for i in range(B):
        # Meet the plane of the film's middle, and from there the sphere: c |P + t d|² = 2 f · (P + t d)
        px, py = x[i] - cx, y[i] - cy
        across_plane = l[i] * fx + m[i] * fy + n[i] * fz
        t = -(px * fx + py * fy + z[i] * fz) / across_plane
        px, py, pz = px + t * l[i], py + t * m[i], z[i] + t * n[i]
        beyond = c * (px * px + py * py + pz * pz)
        slant = across_plane - c * (px * l[i] + py * m[i] + pz * n[i])
        left = slant * slant - c * beyond
        facing = math.sqrt(left if left > real(0) else real(0))         # cosine at the film, of the nearer crossing
        t = beyond / (slant + facing)
        px, py, pz = px + t * l[i], py + t * m[i], pz + t * n[i]
        upright = real(1) - c * (px * fx + py * fy + pz * fz)           # cosine between the film there and its middle
        x[i] = (right - (px * xx + py * xy + pz * xz)) * across
        y[i] = (bottom + (px * yx + py * yy + pz * yz)) * down
        z[i] = real(0)
        arrives = (slant + facing > real(0)) & (left > real(0)) & (upright > real(0))
        weight[i] = weight[i] * gain * upright if arrives else real(0)


@stage
def land_ideal(lanes, p, ints, key):
    """Land a ray on the film through an ideal lens: raster X, Y, the pupil point in L, M, CLEARANCE and WEIGHT.

    p: PIXEL_X … APPROACH_PUPIL. Such a lens does not keep étendue: its pictures fall off as cos⁴θ on the film's side.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight, clearance = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT], row[CLEARANCE]
    across, right, down, bottom, gain = real(1) / p[PIXEL_X], p[HALF_X], real(1) / p[PIXEL_Y], p[HALF_Y], p[GAIN]
    film_p, film_s, pupil_p, pupil_s = p[FILM_P], p[FILM_S], p[PUPIL_P], p[PUPIL_S]
    plane, aim, aim_p = p[PLANE_Z], p[APPROACH_FILM], p[APPROACH_PUPIL]
    for i in range(B):
        # Cross the plane at P = (px, py) with the slope S = (sx, sy)
        t = (plane - z[i]) / n[i]
        px, py, sx, sy = x[i] + t * l[i], y[i] + t * m[i], -l[i] / n[i], -m[i] / n[i]
        # Film point, pupil point, and the slope between them
        fx, fy, a, b = film_p * px + film_s * sx, film_p * py + film_s * sy, pupil_p * px + pupil_s * sx, (
            pupil_p * py + pupil_s * sy)
        ex, ey = aim * fx + aim_p * a, aim * fy + aim_p * b
        # Étendue on the scene's side to cos⁴θ on the film's side
        c2 = (real(1) + sx * sx + sy * sy) / (real(1) + ex * ex + ey * ey)
        clearance[i] = a * a + b * b
        weight[i] = weight[i] * c2 * c2 * gain if (clearance[i] <= real(1)) & (n[i] > real(0)) else real(0)
        x[i], y[i], z[i], l[i], m[i] = (right - fx) * across, (bottom + fy) * down, real(0), a, b


def landing_step(film: Film, gain: float) -> Step:
    """Step from the last surface to the raster; gain: pixel value of an irradiance of radiance 1 times 1 sr."""
    p = np.empty(GAIN + 1)
    p[PIXEL_X:GAIN] = film.step.parameters
    p[GAIN] = gain / (p[PIXEL_X] * p[PIXEL_Y])
    return Step(land, p)


def posed_landing_step(film: Film, pose: FilmPose, gain: float) -> Step:
    """`landing_step` for a film with a pose."""
    return Step(land_on_posed_film, np.concatenate([landing_step(film, gain).parameters, pose.numbers]))


def ideal_film_landing(lens: Gaussian, film: Step, gain: float) -> FilmLanding | None:
    """Film landing of an ideal lens whose rays have the weight cos⁴θ · gain; film: step from raster to film.

    None for parallel rays, or rays that start on the film.
    """
    z, origin, origin_p, slope, slope_p, aim, aim_p, iris = lens
    determinant = origin * slope_p - origin_p * slope
    if slope == 0.0 or (determinant == 0.0 and origin != 0.0):
        return None
    p = np.zeros(APPROACH_PUPIL + 1)
    p[PIXEL_X:GAIN] = film.parameters
    pixel = p[PIXEL_X] * p[PIXEL_Y]
    p[PLANE_Z], p[APPROACH_FILM] = z, aim

    # A pinhole: the slope alone gives the film point
    if determinant == 0.0:
        p[GAIN], p[FILM_S] = gain / slope**2 / pixel, 1.0 / slope
        arriving = [Step(land_ideal, p)]
        return FilmLanding(arriving, arriving, (0.0, 0.0, z), 0.0)

    # Otherwise invert the 2 × 2 map from film and pupil point to P and S
    p[GAIN], p[APPROACH_PUPIL] = gain / (iris.sampled_area * determinant**2) / pixel, aim_p
    p[FILM_P], p[FILM_S] = slope_p / determinant, -origin_p / determinant
    p[PUPIL_P], p[PUPIL_S] = -slope / determinant, origin / determinant
    arriving = [Step(land_ideal, p)]
    swapped = Step(swap_raster_and_pupil, np.zeros(1))
    blades = [] if iris.is_round else [swapped, *iris.blocking(1.0), swapped]
    reach = abs(origin_p) + abs(origin) * math.hypot(p[HALF_X], p[HALF_Y])
    return FilmLanding([*arriving, *blades], arriving, (0.0, 0.0, z), reach)


@stage
def swap_raster_and_pupil(lanes, p, ints, key):
    """Swap X, Y with L, M: the raster point with the pupil point, after `land_ideal`."""
    row = rows(lanes)
    x, y, l, m = row[X], row[Y], row[L], row[M]
    for i in range(B):
        x[i], y[i], l[i], m[i] = l[i], m[i], x[i], y[i]
