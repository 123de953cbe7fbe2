"""Settings within the limits of lens, film and camera: the effects of another lens, scale or film.

Lengths in mm, angles in radians.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import lensbench as lb
from lensbench.app.bench.build import design
from lensbench.app.bench.camera_kinds import MAKERS, readings
from lensbench.app.bench.readouts import colours
from lensbench.app.bench.water_window import nearest_in_focus
from lensbench.app.bench.zoom import focal_length, is_engraved, zoom_of
from lensbench.app.settings.bodies import BODIES
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_angle
from lensbench.core.imaging.film import least_radius
from lensbench.core.kernels.cache import resumable
from lensbench.core.text import fixed

SMALLEST_CROP = 0.05
WIDEST_FISHEYE = math.radians(350.0)
LONGEST_SHOWN = 8192            # pixels: the smallest texture limit of graphics cards with OpenGL 3.3 in use
SMALLEST_SHOWN = 160            # pixels of the longer side of a picture that follows its window
COARSE = 0.85                   # a picture is not made coarser for less than this
ROUNDED = 0.995                 # of the narrowest field of view: what its text is rounded to may be typed
MARGIN = 1.0 + 1e-4             # of a clamped focus distance over the nearest, which is rounded


@resumable
def constrained(settings: Settings) -> Settings:
    """The settings with zoom, aperture, focus and film curvature that the camera has; errors of loading its lens."""
    if not settings.has_lens:
        return _not_nearer(settings)
    if settings.zoom and not zooms(settings):
        settings = replace(settings, zoom=0.0)
    settings = _not_tighter(settings)
    if settings.f_number is not None and settings.f_number < _widest_f_number(settings) * (1.0 - 1e-6):
        settings = replace(settings, f_number=None)
    settings = _not_nearer(settings)
    if settings.dispersion == "on" and not colours(settings).possible:
        settings = replace(settings, dispersion="auto")
    return settings


def _not_nearer(settings: Settings) -> Settings:
    """The settings focused no nearer than the camera can focus."""
    nearest = _nearest_focus(settings) * MARGIN
    return replace(settings, focus_distance=nearest) if settings.focus_distance < nearest else settings


def _not_tighter(settings: Settings) -> Settings:
    """The settings with a film curved no tighter than its size allows."""
    if settings.film_radius is None:
        return settings
    least = least_radius(settings.film.width, settings.film.height) * MARGIN
    tight = abs(settings.film_radius) < least
    return replace(settings, film_radius=math.copysign(least, settings.film_radius)) if tight else settings


def _widest_f_number(settings: Settings) -> float:
    """The f-number of the lens wide open; 0 where it has none."""
    lens = design(settings)
    f_number = lb.f_number_at_infinity(lens)
    return f_number if math.isfinite(f_number) else 0.0


def _nearest_focus(settings: Settings) -> float:
    """The nearest focus distance (mm), 0 for none; without all other read-outs, which a new picture need not await."""
    if not settings.has_lens:
        return readings(settings).nearest_focus or 0.0
    lens = design(settings)
    try:
        return nearest_in_focus(lens, settings) if 0.0 < lb.first_order(lens).efl < math.inf else 0.0
    except lb.LensError:
        return 0.0


def full_view(settings: Settings) -> tuple[float, float]:
    """Field of view along the film's shorter side, or the camera's own, and the focal length it is seen with."""
    if (view := MAKERS[settings.camera].view) is not None:
        return view(settings)
    efl = _focal_length(settings)
    return 2.0 * math.atan(0.5 * min(settings.film_width, settings.film_height) / (_index(settings) * efl)), efl


def _focal_length(settings: Settings) -> float:
    """The focal length of the lens at infinity; a usual one where there is no lens, or it has none."""
    try:
        efl = abs(focal_length(design(_unzoomed(settings)), settings.zoom))
    except (ValueError, OSError):
        return 50.0
    return efl if math.isfinite(efl) and efl else 50.0


def _index(settings: Settings) -> float:
    """The index before the lens: the focal length on the side of the scene is as many times longer."""
    try:
        return design(_unzoomed(settings)).front_index
    except (ValueError, OSError):
        return 1.0


def field_of_view(settings: Settings) -> float:
    """The field of view along the shorter side of the film in use, or the camera's own."""
    if not settings.has_lens:
        return full_view(settings)[0]
    return 2.0 * math.atan(settings.crop * math.tan(0.5 * full_view(settings)[0]))


def ends_of_view(settings: Settings, keep_zoom: bool = False) -> tuple[float, float]:
    """The narrowest and the widest field of view along the shorter side that lens, zoom and crop can give."""
    narrow = wide = full_view(settings)[0]
    if not keep_zoom and _zooms_by_length(settings):
        wide, narrow = (full_view(replace(settings, zoom=end))[0] for end in (0.0, 1.0))
    return 2.0 * math.atan(SMALLEST_CROP * math.tan(0.5 * narrow)), wide


def beyond_view(settings: Settings, fov: float, keep_zoom: bool = False) -> str:
    """Why the lens cannot give a field of view (radians), with the end of its range; "" where it can."""
    narrow, wide = ends_of_view(settings, keep_zoom)
    if 0.0 < wide < fov:
        return f"this film behind this lens sees {fixed(math.degrees(wide), 1)}° along its shorter side"
    if fov < ROUNDED * narrow:
        return f"the smallest part of this film behind this lens sees {format_angle(narrow)} along its shorter side"
    return ""


def zooms(settings: Settings) -> bool:
    """Whether the camera has a lens that zooms."""
    return settings.has_lens and design(_unzoomed(settings)).zooms


def _zooms_by_length(settings: Settings) -> bool:
    """Whether the field of view can turn the zoom."""
    return zooms(settings) and is_engraved(design(_unzoomed(settings)))


def _unzoomed(settings: Settings) -> Settings:
    return replace(settings, zoom=0.0) if settings.zoom else settings


def with_field_of_view(settings: Settings, fov: float, keep_zoom: bool = False) -> Settings:
    """The settings with a field of view: the camera's own, or by the zoom and, where it ends, by a crop of the film."""
    if (with_view := MAKERS[settings.camera].with_view) is not None:
        return with_view(settings, fov)
    if not keep_zoom and _zooms_by_length(settings):
        lens = design(_unzoomed(settings))
        length = 0.5 * min(settings.film_width, settings.film_height) / (
            _index(settings) * math.tan(0.5 * min(fov, 3.0)))
        settings = replace(settings, zoom=zoom_of(lens, length), crop=1.0)
        if focal_length(lens, 0.0) <= length <= focal_length(lens, 1.0):
            return settings
    full = full_view(settings)[0]
    crop = math.tan(0.5 * fov) / math.tan(0.5 * full) if fov < full else 1.0
    return replace(settings, crop=min(max(crop, SMALLEST_CROP), 1.0))


def with_camera(settings: Settings, camera: str) -> Settings:
    """Another kind of camera, as wide open as a lens, in air if it has no window; pixels follow a changed shape."""
    changed = replace(settings, camera=camera)
    if settings.has_lens and settings.has_stop and not changed.has_lens and settings.f_number is None:
        changed = replace(changed, f_number=readings(settings).widest_f_number)     # None would be a pinhole there
    if settings.medium == "water" and not changed.kind.under_water:
        changed = replace(changed, medium="air")
    if changed.projection == "orthographic":
        changed = with_projection(changed, changed.projection)
    if changed.kind.panorama == settings.kind.panorama:
        return changed
    return with_longer_side(changed, max(settings.pixels_x, settings.pixels_y))


def with_layout(settings: Settings, layout: str) -> Settings:
    """The settings with another layout of the panorama, and pixels of its shape."""
    return with_longer_side(replace(settings, layout=layout), max(settings.pixels_x, settings.pixels_y))


def with_projection(settings: Settings, projection: str) -> Settings:
    """The settings with another projection of the ideal fisheye, and no wider view than it has."""
    widest = math.pi if projection == "orthographic" else WIDEST_FISHEYE
    return replace(settings, projection=projection, fisheye_fov=min(settings.fisheye_fov, widest))


def with_film(settings: Settings, width: float, height: float) -> Settings:
    """The settings with another film, of no named body, square pixels, and as many along the longer side."""
    longer = max(settings.pixels_x, settings.pixels_y)
    return with_longer_side(replace(settings, film_width=width, film_height=height, body=""), longer)


def with_body(settings: Settings, name: str, change: Callable[[Settings, float, float], Settings] = with_film
              ) -> Settings:
    """The settings with the sensor of a camera body by name; "" for none. change: `with_film` or an equivalent one."""
    return replace(change(settings, *BODIES[name].size), body=name) if name else replace(settings, body="")


def with_equivalent_film(settings: Settings, width: float, height: float) -> Settings:
    """The settings with another film, and the focal length and f-number that keep field of view and depth of field.

    The aperture is as wide as the lens opens at most. A tilted or shifted film keeps what it shows and its plane of
    sharp focus: what is `ratio` times as large as before lies ratio² times as deep behind the lens.
    """
    ratio = math.hypot(width, height) / math.hypot(settings.film_width, settings.film_height)
    got = readings(replace(settings, zoom=0.0))
    changed = with_film(settings, width, height)
    f_number = settings.f_number if settings.f_number is not None else got.f_number
    if f_number is not None and settings.kind.f_number:
        changed = replace(changed, f_number=f_number * ratio)
    changed = replace(changed, **{name: getattr(settings, name) * ratio for name in settings.kind.film_lengths})
    if settings.has_lens and got.efl is not None:
        tilt, swing = (math.atan(ratio * math.tan(angle)) for angle in (settings.tilt, settings.swing))
        changed = replace(changed, focal_length=got.efl * ratio, rise=settings.rise * ratio,
                          shift=settings.shift * ratio, tilt=tilt, swing=swing)
    return constrained(changed)


def showable(settings: Settings) -> Settings:
    """The settings with no more pixels along a side than every graphics card can hold, in the same shape."""
    longer = max(settings.pixels_x, settings.pixels_y)
    if longer <= LONGEST_SHOWN:
        return settings
    across, down = (max(1, round(pixels * LONGEST_SHOWN / longer)) for pixels in (settings.pixels_x, settings.pixels_y))
    return replace(settings, pixels_x=across, pixels_y=down)


def longer_side_within(settings: Settings, room: tuple[float, float]) -> int:
    """Pixels along the longer side of a picture that just fits into a room of so many pixels across and down."""
    width, height = settings.picture_shape
    scale = min(room[0] / width, room[1] / height)
    return min(max(int(scale * max(width, height)), SMALLEST_SHOWN), LONGEST_SHOWN)


def coarser(settings: Settings, pixels: float) -> Settings:
    """The settings with about so many pixels in all, if they have notably more; at least SMALLEST_SHOWN in a row."""
    scale = math.sqrt(max(pixels, 1.0) / (settings.pixels_x * settings.pixels_y))
    if scale > COARSE:
        return settings
    longer = max(settings.pixels_x, settings.pixels_y)
    return with_longer_side(settings, max(int(scale * longer), min(SMALLEST_SHOWN, longer)))


def with_longer_side(settings: Settings, pixels: int) -> Settings:
    """The settings with so many square pixels along the longer side of the film, or of the panorama's layout."""
    width, height = settings.picture_shape
    across, down = (max(1, round(pixels * side / max(width, height))) for side in (width, height))
    return replace(settings, pixels_x=across, pixels_y=down)
