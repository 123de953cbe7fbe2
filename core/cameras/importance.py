"""What a camera would send into the scene if it shone: its importance, and how likely it is to choose a ray.

The film's mean reading of a radiance L is ∫∫ W L cos θ dω dA over all rays that leave the camera, θ from its
axis. With the densities, per area and per solid angle, in which generate_rays chooses its rays for raster points
and places in the pupil that are drawn evenly, W cos θ is their product times the weight of the ray. (Veach 1997,
ch. 8; pbrt, third edition, ch. 16, where every weight is 1.)
"""

from typing import NamedTuple

import numpy as np

from lensbench.cameras.ideal_lens import Gaussian

HIT = 1e-6              # how near to its one point (mm) or its one direction (radians) a ray must be


class Importance(NamedTuple):
    """Of n rays that leave a camera. All is 0 for a ray that no film point sends, and its raster point is NaN.

    we: 1 / (mm² sr), with physical weights times seconds; of a camera that sees from a point 1 / sr (of a panorama or
    an ideal fisheye, which has no axis to measure θ from, for θ = 0), and of one with parallel rays alone 1 / mm².
    position_pdf: 1 / mm², of where the ray crosses the entrance pupil, or, where that lies at infinity, the plane in
    focus; 1 where there is one choice. direction_pdf: 1 / sr, of its direction there; 1 where there is one choice.
    Of a bare sensor and a real lens both are those of the ray as it leaves the film, from which its place and
    direction in the scene follow: W is the same before and behind a lens, and cos θ dω dA too.
    """

    we: np.ndarray              # (n,)
    position_pdf: np.ndarray    # (n,)
    direction_pdf: np.ndarray   # (n,)
    raster: np.ndarray          # (n, 2) pixels
    visible: np.ndarray         # (n,) bool: whether it is a ray of this camera


class FilmImportance(NamedTuple):
    """The same by film points: (n, 2) mm, W, both densities, and whether the ray passes the camera."""

    film: np.ndarray
    we: np.ndarray
    position_pdf: np.ndarray
    direction_pdf: np.ndarray
    passes: np.ndarray
    is_point: bool = False      # whether W is of no area, for all rays cross one point


def gaussian_importance(lens: Gaussian, gain: float, film_area: float, origins: np.ndarray,
                directions: np.ndarray) -> FilmImportance:
    """Of rays of the camera's frame, (n, 3) mm and (n, 3) unit. gain: as of the lens's steps; film_area: mm²."""
    is_point = lens.is_hole and lens.slope_film != 0.0
    cosine = -directions[:, 2]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        slope = directions[:, :2] / cosine[:, None]
        crossing = origins[:, :2] + (origins[:, 2] - lens.z)[:, None] * slope
        one, per_slope = np.ones(len(cosine)), 1.0 / cosine**3          # sr in a unit of slope²
        a = np.zeros_like(slope)
        if is_point:
            film, place, way = slope / lens.slope_film, one, per_slope / (film_area * lens.slope_film**2)
            passes = np.hypot(crossing[:, 0], crossing[:, 1]) <= HIT
        elif lens.is_hole:
            film, place, way = crossing / lens.origin_film, one / (film_area * lens.origin_film**2), one
            passes = np.hypot(slope[:, 0], slope[:, 1]) <= HIT
        else:
            both = lens.origin_film * lens.slope_pupil - lens.origin_pupil * lens.slope_film
            film = (lens.slope_pupil * crossing - lens.origin_pupil * slope) / both
            a = (lens.origin_film * slope - lens.slope_film * crossing) / both
            passes = lens.iris.contains(a[:, 0], a[:, 1])
            if lens.slope_film != 0.0:
                place = one / (lens.iris.area * (both / lens.slope_film) ** 2)
                way = per_slope / (film_area * lens.slope_film**2)
            else:
                place = one / (film_area * lens.origin_film**2)
                way = per_slope / (lens.iris.area * lens.slope_pupil**2)
        approach = lens.approach_film * film + lens.approach_pupil * a
        weight = gain / (1.0 + (approach**2).sum(1)) ** 2
        return FilmImportance(film, weight * place * way / cosine, place, way, passes & (cosine > 0.0),
                              is_point)


def point_importance(film: np.ndarray, density: np.ndarray, seen: np.ndarray, origins: np.ndarray,
             directions: np.ndarray) -> FilmImportance:
    """Of a camera that sees from its origin with weight 1; density: of the directions of its samples, 1 / sr."""
    along = (origins * directions).sum(1)[:, None]
    aside = np.linalg.norm(origins - along * directions, axis=1)
    return FilmImportance(film, density, np.ones(len(film)), density, seen & (aside <= HIT), True)
