"""How much of the film the lens lights: lengths in mm."""

from lensbench.app.readings import setup
from lensbench.app.section_fans import lit_radius
from lensbench.app.settings import REAL, Settings

NARROW = 0.97                   # of the film's diagonal: an image circle below it is spoken of


def lit(settings: Settings) -> float:
    """How far off the axis light reaches the film: to its corner, where no lens says otherwise."""
    corner = 0.5 * settings.film.diagonal
    if settings.lensless:
        return corner
    try:
        return lit_radius(setup(settings))
    except (ValueError, OSError):
        return corner


def dark_corners(settings: Settings) -> str:
    """Why the picture has dark corners, if it has; an ideal lens lights any film."""
    reach, diagonal = 2.0 * lit(settings), settings.film.diagonal
    if settings.model not in REAL or reach >= NARROW * diagonal:
        return ""
    return f"Image circle ø {reach:.1f} mm, film diagonal {diagonal:.1f} mm"
