"""Settings that the lens can do: what is kept and what gives way when the lens, its scale or the film changes.

Lengths in mm, angles in radians.
"""

import math
from dataclasses import replace

from lensbench.app.state.build import design, perspective_focal_length
from lensbench.app.state.figures import colours, readings
from lensbench.app.state.settings import REAL, SHAPES, Settings
from lensbench.app.state.zoom import focal_length, zoom_of

SMALLEST_CROP = 0.05
OPENING = (*REAL, "thick", "thin", "pinhole", "perspective")       # cameras with an f-number of their own
WIDEST_FISHEYE = math.radians(350.0)
LONGEST_SHOWN = 8192            # pixels: what the smallest texture limit of OpenGL 3.3 cards in use allows
MARGIN = 1.0 + 1e-4             # by which a clamped focus distance stays off the nearest, which is rounded


def constrained(settings: Settings) -> Settings:
    """With a zoom, an aperture and a distance that the lens has; the rest is kept.

    Raises what loading the lens raises where there is none.
    """
    if settings.model == "perspective":
        nearest = readings(settings).nearest_focus or 0.0
        return replace(settings, focus_distance=max(settings.focus_distance, nearest * MARGIN))
    if settings.lensless:
        return settings
    if settings.zoom and not zooms(settings):
        settings = replace(settings, zoom=0.0)
    design(settings)
    wide = readings(replace(settings, f_number=None))
    if settings.f_number is not None and wide.widest_f_number is not None \
            and settings.f_number < wide.widest_f_number * (1.0 - 1e-6):
        settings = replace(settings, f_number=None)
    nearest = readings(settings).nearest_focus or 0.0
    if settings.focus_distance < nearest * MARGIN:
        settings = replace(settings, focus_distance=nearest * MARGIN)
    if settings.dispersion == "on" and not colours(settings).possible:
        settings = replace(settings, dispersion="auto")
    return settings


def full_view(settings: Settings) -> tuple[float, float]:
    """The field of view of the whole film along its shorter side, and the focal length that it is seen with.

    Of an ideal camera: its own, along its own axis.
    """
    shorter = min(settings.film_width, settings.film_height)
    if settings.model == "perspective":
        return settings.fov, perspective_focal_length(settings)
    if settings.model == "fisheye":
        return settings.fisheye_fov, readings(settings).efl or 50.0
    if settings.model == "hole":
        return 2.0 * math.atan(0.5 * shorter * settings.crop / settings.hole_distance), settings.hole_distance
    efl = _focal_length(settings)
    return 2.0 * math.atan(0.5 * shorter / efl), efl


def _focal_length(settings: Settings) -> float:
    """Of the lens at infinity; of one that is not there or has none, a usual one."""
    try:
        efl = abs(focal_length(design(replace(settings, zoom=0.0)), settings.zoom))
    except (ValueError, OSError):
        return 50.0
    return efl if math.isfinite(efl) and efl else 50.0


def field_of_view(settings: Settings) -> float:
    """The field of view along the shorter side of the film that is used, or an ideal camera's own."""
    if settings.lensless:
        return full_view(settings)[0]
    return 2.0 * math.atan(settings.crop * math.tan(0.5 * full_view(settings)[0]))


def ends_of_view(settings: Settings) -> tuple[float, float]:
    """The narrowest and the widest field of view along the shorter side that lens, zoom and crop can give."""
    narrow = wide = full_view(settings)[0]
    if zooms(settings):
        wide, narrow = (full_view(replace(settings, zoom=end))[0] for end in (0.0, 1.0))
    return 2.0 * math.atan(SMALLEST_CROP * math.tan(0.5 * narrow)), wide


def zooms(settings: Settings) -> bool:
    """Whether the camera has a lens that zooms."""
    return not settings.lensless and design(replace(settings, zoom=0.0)).zooms


def with_field_of_view(settings: Settings, fov: float, keep_zoom: bool = False) -> Settings:
    """A crop of the film that sees this much, or an ideal camera's own field of view.

    A lens that zooms does so first, and only what lies beyond its longest end is cropped.
    """
    if settings.model == "perspective":
        return replace(settings, fov=fov)
    if settings.model == "fisheye":
        return replace(settings, fisheye_fov=fov)
    if settings.model == "hole":
        shorter = min(settings.film.width, settings.film.height)
        return replace(settings, hole_distance=0.5 * shorter / math.tan(0.5 * fov))
    if zooms(settings) and not keep_zoom:
        lens = design(replace(settings, zoom=0.0))
        wanted = 0.5 * min(settings.film_width, settings.film_height) / math.tan(0.5 * min(fov, 3.0))
        settings = replace(settings, zoom=zoom_of(lens, wanted), crop=1.0)
        if focal_length(lens, 0.0) <= wanted <= focal_length(lens, 1.0):
            return settings
    crop = math.tan(0.5 * fov) / math.tan(0.5 * full_view(settings)[0])
    return replace(settings, crop=min(max(crop, SMALLEST_CROP), 1.0))


def with_model(settings: Settings, model: str) -> Settings:
    """Another camera. A panorama has pixels of its layout's shape, the others of the film's; no window holds it dry."""
    turned = replace(settings, model=model)
    if model == "environment" and settings.medium == "water":
        turned = replace(turned, medium="air")
    if model == "fisheye" and settings.projection == "orthographic":
        turned = replace(turned, fisheye_fov=min(turned.fisheye_fov, math.pi))
    if "environment" not in (model, settings.model) or model == settings.model:
        return turned
    return with_longer_side(turned, max(settings.pixels_x, settings.pixels_y))


def with_layout(settings: Settings, layout: str) -> Settings:
    """Another layout of the panorama, with its shape."""
    return with_longer_side(replace(settings, layout=layout), max(settings.pixels_x, settings.pixels_y))


def with_projection(settings: Settings, projection: str) -> Settings:
    """Another projection of the ideal fisheye, which sees no more than it can."""
    widest = math.pi if projection == "orthographic" else WIDEST_FISHEYE
    return replace(settings, projection=projection, fisheye_fov=min(settings.fisheye_fov, widest))


def with_film(settings: Settings, width: float, height: float) -> Settings:
    """Another film, with pixels that stay square and as many along the longer side."""
    longer = max(settings.pixels_x, settings.pixels_y)
    return with_longer_side(replace(settings, film_width=width, film_height=height), longer)


def with_equivalent_film(settings: Settings, width: float, height: float) -> Settings:
    """Another film, with the focal length and the f-number that keep the field of view and the depth of field.

    As far as the lens can open: else as wide as it goes.
    """
    ratio = math.hypot(width, height) / math.hypot(settings.film_width, settings.film_height)
    got = readings(replace(settings, zoom=0.0))
    changed = with_film(settings, width, height)
    f_number = settings.f_number if settings.f_number is not None else got.f_number
    if f_number is not None and settings.model in OPENING:
        changed = replace(changed, f_number=f_number * ratio)
    if settings.model == "hole":
        return replace(changed, hole_distance=settings.hole_distance * ratio)
    if not settings.lensless and got.efl is not None:
        changed = replace(changed, focal_length=got.efl * ratio)
    return constrained(changed)


def showable(settings: Settings) -> Settings:
    """With no more pixels along a side than every graphics card can hold; a picture of such pixels keeps its shape."""
    longer = max(settings.pixels_x, settings.pixels_y)
    if longer <= LONGEST_SHOWN:
        return settings
    across, down = (max(1, round(pixels * LONGEST_SHOWN / longer)) for pixels in (settings.pixels_x, settings.pixels_y))
    return replace(settings, pixels_x=across, pixels_y=down)


def with_longer_side(settings: Settings, pixels: int) -> Settings:
    """So many square pixels along the longer side of the film, or of the panorama's layout."""
    width, height = settings.film_width, settings.film_height
    if settings.model == "environment":
        width, height = SHAPES[settings.layout]
    across, down = (max(1, round(pixels * side / max(width, height))) for side in (width, height))
    return replace(settings, pixels_x=across, pixels_y=down)
