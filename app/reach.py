"""Settings that the lens can do: what is kept and what gives way when the lens, its scale or the film changes.

Lengths in mm, angles in radians.
"""

import math
from dataclasses import replace

from lensbench.app.readings import readings
from lensbench.app.settings import Settings

SMALLEST_CROP = 0.05
LONGEST_SHOWN = 8192            # pixels: what the smallest texture limit of OpenGL 3.3 cards in use allows
MARGIN = 1.0 + 1e-4             # by which a clamped focus distance stays off the nearest, which is rounded


def within_reach(settings: Settings) -> Settings:
    """With an aperture that the lens can open to and a distance that it can focus on; the rest is kept.

    Raises what loading the lens raises where there is none.
    """
    from lensbench.app.settings import design

    if settings.model == "perspective":
        nearest = readings(settings).nearest_focus or 0.0
        return replace(settings, focus_distance=max(settings.focus_distance, nearest * MARGIN))
    design(settings)
    wide = readings(replace(settings, f_number=None))
    if settings.f_number is not None and wide.widest_f_number is not None \
            and settings.f_number < wide.widest_f_number * (1.0 - 1e-6):
        settings = replace(settings, f_number=None)
    nearest = readings(settings).nearest_focus or 0.0
    if settings.focus_distance < nearest * MARGIN:
        settings = replace(settings, focus_distance=nearest * MARGIN)
    return settings


def full_view(settings: Settings) -> tuple[float, float]:
    """The field of view of the whole film along its shorter side, and the focal length that it is seen with."""
    shorter = min(settings.film_width, settings.film_height)
    if settings.model == "perspective":
        return settings.fov, 0.5 * shorter * settings.crop / math.tan(0.5 * settings.fov)
    efl = abs(readings(settings).efl or 50.0)
    return 2.0 * math.atan(0.5 * shorter / efl), efl


def field_of_view(settings: Settings) -> float:
    """The field of view along the shorter side of the film that is used."""
    if settings.model == "perspective":
        return settings.fov
    return 2.0 * math.atan(settings.crop * math.tan(0.5 * full_view(settings)[0]))


def with_field_of_view(settings: Settings, fov: float) -> Settings:
    """A crop of the film that sees this much, or the perspective camera's own field of view."""
    if settings.model == "perspective":
        return replace(settings, fov=fov)
    crop = math.tan(0.5 * fov) / math.tan(0.5 * full_view(settings)[0])
    return replace(settings, crop=min(max(crop, SMALLEST_CROP), 1.0))


def with_film(settings: Settings, width: float, height: float) -> Settings:
    """Another film, with pixels that stay square and as many along the longer side."""
    longer = max(settings.pixels_x, settings.pixels_y)
    return with_longer_side(replace(settings, film_width=width, film_height=height), longer)


def showable(settings: Settings) -> Settings:
    """With no more pixels along a side than every graphics card can hold; a picture of such pixels keeps its shape."""
    longer = max(settings.pixels_x, settings.pixels_y)
    if longer <= LONGEST_SHOWN:
        return settings
    across, down = (max(1, round(pixels * LONGEST_SHOWN / longer)) for pixels in (settings.pixels_x, settings.pixels_y))
    return replace(settings, pixels_x=across, pixels_y=down)


def with_longer_side(settings: Settings, pixels: int) -> Settings:
    """So many square pixels along the film's longer side."""
    width, height = settings.film_width, settings.film_height
    across, down = (max(1, round(pixels * side / max(width, height))) for side in (width, height))
    return replace(settings, pixels_x=across, pixels_y=down)
