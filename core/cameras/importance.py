"""Importance of rays, and the densities with which a camera chooses them.

The mean of a film's readings of a radiance L is ∫∫ W L cos θ dω dA over all rays that leave the camera, θ measured from
its axis. `Camera.generate_rays` chooses rays, for raster points and pupil samples that are drawn uniformly, with one
density per area and one per solid angle: W cos θ is the product of both and of the ray's weight. (Veach 1997, Robust
Monte Carlo Methods for Light Transport Simulation, ch. 8; Pharr, Jakob and Humphreys, Physically Based Rendering, third
edition, ch. 16, where every weight is 1.)
"""

from typing import NamedTuple

import numpy as np

from lensbench.cameras.ideal_lens import Gaussian

HIT = 1e-6              # mm from the one point, or radians from the one direction, of a camera with a single one


class Importance(NamedTuple):
    """Importance and densities of n rays. A ray that no film point sends has zeros and a NaN raster point.

    Behind a bare sensor or a real lens, both densities are those of the ray where it leaves the film, which determines
    the ray in the scene: W and cos θ dω dA are the same before and behind a lens.

    Parameters
    ----------
    we : (n,) array
        Importance W in 1 / (mm² sr), times seconds with physical weights. For a camera that sees from a point it is in
        1 / sr (for a panorama or an ideal fisheye, which have no axis, with θ = 0); for parallel rays in 1 / mm².
    position_pdf : (n,) array
        Density (1 / mm²) of the point where the ray crosses the entrance pupil or, for a pupil at infinity, the plane
        in focus; 1 where there is one choice.
    direction_pdf : (n,) array
        Density (1 / sr) of the direction at that point; 1 where there is one choice.
    raster : (n, 2) array
        Raster points (pixels) of the rays.
    visible : (n,) bool array
        Whether each ray is a ray of this camera.

    References
    ----------
    Veach 1997, Robust Monte Carlo Methods for Light Transport Simulation, ch. 8.
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
    """Importance of rays of an ideal lens: origins (n, 3) in mm and unit directions (n, 3), camera frame.

    gain: as for the steps of the lens; film_area: mm².
    """
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


def point_importance(film: np.ndarray, density: np.ndarray, seen: np.ndarray, origins: np.ndarray,
                     directions: np.ndarray) -> FilmImportance:
    """Importance for a camera that sees from its origin with weight 1; density: of its directions (1 / sr)."""
    along = (origins * directions).sum(1)[:, None]
    aside = np.linalg.norm(origins - along * directions, axis=1)
    return FilmImportance(film, density, np.ones(len(film)), density, seen & (aside <= HIT), True)
