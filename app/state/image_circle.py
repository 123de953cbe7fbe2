"""The image circle of the lens on the film. Lengths in mm."""

from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.state.build import setup
from lensbench.app.state.ray_fans import lit_radius
from lensbench.app.state.settings import Settings
from lensbench.pupils.image_circle import edge_of_light
from lensbench.pupils.ray_aiming import Aim

NARROW = 0.97                   # of the film's diagonal: a smaller image circle is reported


def lit(settings: Settings) -> float:
    """Radius (mm) to which light reaches the film: to its corner for a camera without a lens."""
    corner = 0.5 * settings.film.diagonal
    if not settings.has_lens:
        return corner
    try:
        return lit_radius(setup(settings))
    except (ValueError, OSError):
        return corner


def dark_corners(settings: Settings) -> str:
    """Reason for dark corners, or ""; an ideal lens lights any film."""
    if not settings.follows_lens:
        return ""
    reach, diagonal = 2.0 * lit(settings), settings.film.diagonal
    share = _towards_the_corner(settings)
    if share is not None:
        return f"Light ends at {100.0 * share:.0f} % of the film's diagonal" if share < NARROW else ""
    if reach >= NARROW * diagonal:
        return ""
    return f"Image circle ø {reach:.1f} mm, film diagonal {diagonal:.1f} mm"


def _towards_the_corner(settings: Settings) -> float | None:
    """Part of the way to the film's corner that light reaches, for a lens without rotational symmetry; else None."""
    try:
        lens_setup = setup(settings)
    except (ValueError, OSError):
        return None
    if lens_setup.lens.is_rotationally_symmetric:
        return None
    return _end(lens_setup.lens, lens_setup.film_distance, lens_setup.film.width, lens_setup.film.height)


@lru_cache(maxsize=16)
def _end(lens: lb.Lens, film_distance: float, width: float, height: float) -> float:
    return float(edge_of_light(Aim(lens, film_distance), np.array([[0.5 * width, 0.5 * height]]), 1.0)[0][0])
