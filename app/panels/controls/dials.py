"""The dials of the left column: those that `camera_kinds` lists for the camera, and the exposure."""

import math
from collections.abc import Callable
from dataclasses import replace

from imgui_bundle import imgui

from lensbench.app.bench.build import design
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.constraints import (
    WIDEST_FISHEYE, constrained, ends_of_view, field_of_view, full_view, with_field_of_view, zooms
)
from lensbench.app.bench.framing import scene_exposure
from lensbench.app.bench.lens_choice import APERTURE, FOCUS, LOCKS
from lensbench.app.bench.readouts import SOFT
from lensbench.app.bench.zoom import engraved_zoom, focal_length, is_engraved
from lensbench.app.drawing import theme
from lensbench.app.drawing.controls import padlock
from lensbench.app.drawing.dial import dial
from lensbench.app.plots.blur import focus_words, sharp_range
from lensbench.app.settings import dial_scales
from lensbench.app.settings.dial_scales import Scale
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_length
from lensbench.core.text import true_minus

DEFAULT = Settings()
TITLES = {FOCUS: "Focus distance", APERTURE: "Aperture"}        # of the dials with a padlock
PERSPECTIVE_FOV = (math.radians(5.0), math.radians(120.0))
NEAREST = 10.0                  # mm: focus distance of a camera without a nearest focus
VIEWS = ("crop or zoom", "focal length", "perspective view")      # dials of the field of view
OCTAVES = 6.0                   # factor of the focal length to either side of the design


def dial_names(settings: Settings) -> tuple[str, ...]:
    """Names of the dials of this camera, without the exposure."""
    return tuple(name for name in settings.kind.dials if name != "aperture" or settings.has_stop)


def dial_count(settings: Settings) -> int:
    """Number of dials that `dials` draws."""
    return len(dial_names(settings)) + 1


def dials(settings: Settings, locked: set[str], sized: Callable[[Settings, Settings], Settings]) -> Settings:
    """Draw the dials of this camera; return the changed settings.

    locked: what another lens leaves as it is; a click on a padlock changes this set. sized: of the settings before and
    after another field of view, those whose subject keeps its size where this is locked.
    """
    for name in dial_names(settings):
        corner, before = imgui.get_cursor_screen_pos(), settings
        settings = DIALS[name](settings)
        if name in VIEWS:
            settings = sized(before, settings)
        if name in LOCKS and settings.has_lens:
            title = imgui.calc_text_size(TITLES[name]).x
            padlock(name, locked, imgui.ImVec2(corner.x + title + theme.em(0.45), corner.y))
        if name == FOCUS:
            _note_range(settings, corner)
    exposure = dial("Exposure", settings.exposure, dial_scales.exposure_scale(
        scene_exposure(settings.scene) if settings.exposing == "plain" else 0.0),
                    "Stops by which the picture is brightened; the aperture itself does not change its brightness"
                    if settings.exposing == "plain" else
                    "Stops by which the picture is brightened over the exposure by f-number, time and ISO")
    return replace(settings, exposure=exposure)


def turned(settings: Settings, name: str, steps: int) -> Settings:
    """The settings with a dial so many steps further to the right; ValueError where the camera has no such dial.

    name: "focus", "aperture" or "exposure".
    """
    if name == "exposure":
        return replace(settings, exposure=dial_scales.exposure_scale().stepped(settings.exposure, steps))
    if name not in dial_names(settings) or settings.has_lens and readings(settings).nearest_focus is None:
        raise ValueError(f"This camera has no {name} to turn")
    if name == FOCUS:
        return replace(settings, focus_distance=_focus_ring(settings).stepped(settings.focus_distance, steps))
    shown, scale = _aperture_ring(settings)
    return _with_aperture(settings, scale.stepped(shown, steps))


def _focus_ring(settings: Settings) -> Scale:
    nearest = readings(settings).nearest_focus
    if nearest is None or not math.isfinite(nearest):       # an edited lens may focus on nothing
        nearest = full_view(settings)[1] if settings.has_lens or settings.kind.has_view else NEAREST
    return dial_scales.focus_scale(nearest * 1.0001, max(DEFAULT.focus_distance, nearest * 1.0001))


def _focus(settings: Settings) -> Settings:
    figures = readings(settings)
    zone = None
    if figures.near_limit is not None and figures.far_limit is not None:
        zone = (figures.near_limit, figures.far_limit if figures.far_limit > 0.0 else math.inf)
    distance = dial(TITLES[FOCUS], settings.focus_distance, _focus_ring(settings),
                    f"Distance s from {settings.kind.measured_from} to the plane in focus; the amber zone is the "
                    f"depth of field\n{focus_words(settings)}" + (SOFT if figures.soft else "")
                    if settings.focuses else
                    "Distance s from the film to the plane that the lens would focus on: it sets the film distance,\n"
                    "and everything is sharp", zone)
    return replace(settings, focus_distance=distance)


def _note_range(settings: Settings, corner: imgui.ImVec2) -> None:
    """What is sharp, in small print between the dial's title and its value, where there is room."""
    right = corner.x + imgui.get_content_region_avail().x - theme.em(0.7) - imgui.calc_text_size(
        dial_scales.focus_scale(NEAREST, DEFAULT.focus_distance).format(settings.focus_distance)).x
    left = corner.x + imgui.calc_text_size(TITLES[FOCUS]).x + theme.em(1.9)
    down = imgui.get_text_line_height()
    theme.small()
    limits = sharp_range(settings)
    for text in filter(None, (f"sharp {limits}" if limits else "", limits)):
        extent = imgui.calc_text_size(text)
        if extent.x <= right - left:
            imgui.get_window_draw_list().add_text(imgui.ImVec2(right - extent.x, corner.y + down - extent.y),
                                                  theme.packed(theme.colours().amber_text), text)
            break
    imgui.pop_font()


def _throws_none(settings: Settings, title: str) -> bool:
    """Whether the lens throws no image: then a line takes the place of a dial, which would have no true value."""
    if not settings.has_lens or readings(settings).nearest_focus is not None:
        return False
    right = imgui.get_cursor_pos_x() + imgui.get_content_region_avail().x
    imgui.text_disabled(title)
    imgui.set_item_tooltip("The lens forms no image")
    imgui.same_line(right - imgui.calc_text_size("–").x)
    imgui.text_disabled("–")
    return True


def _aperture_ring(settings: Settings) -> tuple[float, Scale]:
    """The f-number that the dial shows, and its scale."""
    widest = readings(settings).widest_f_number or 1.0
    shown = settings.f_number if settings.f_number is not None else widest
    scale = dial_scales.aperture_scale(widest, max(DEFAULT.f_number or widest, widest))
    if settings.f_number is None and not settings.has_lens:         # no lens that could be wide open
        scale = dial_scales.pinhole_scale(widest)
        shown = scale.high
    return shown, scale


def _aperture(settings: Settings) -> Settings:
    """The f-number of a lens or of an ideal lens."""
    if _throws_none(settings, TITLES[APERTURE]):
        return settings
    shown, scale = _aperture_ring(settings)
    f_number = dial(TITLES[APERTURE], shown, scale,
                    "f-number N: focal length over the diameter of the entrance pupil")
    return settings if f_number == shown else _with_aperture(settings, f_number)


def _with_aperture(settings: Settings, f_number: float) -> Settings:
    """The settings with another f-number; at the widest of a lens it becomes None, wide open."""
    opened = settings.has_lens and f_number <= (readings(settings).widest_f_number or 1.0)
    return replace(settings, f_number=None if opened else f_number)


def _lens_view(settings: Settings) -> Settings:
    """The field of view of a lens, by zoom and by crop."""
    if _throws_none(settings, "Field of view"):
        return settings
    narrow, wide = ends_of_view(settings)
    zooming = zooms(settings)
    tip = ("Field of view along the shorter side: turns the zoom, and beyond its longest end uses less of the film"
           if zooming else "Field of view along the shorter side: a smaller one uses less of the film") \
        + "\nOf a lens without distortion and without a window into water; the read-outs have that of its rays"
    fov = field_of_view(settings)
    fov_set = dial("Field of view", fov, dial_scales.fov_scale(narrow, wide, wide), tip)
    if fov_set == fov:
        return settings
    settings = with_field_of_view(settings, fov_set)
    return constrained(settings) if zooming else settings       # of another focal length


def _perspective_view(settings: Settings) -> Settings:
    fov_set = dial("Field of view", settings.fov, dial_scales.fov_scale(*PERSPECTIVE_FOV, DEFAULT.fov),
                  "Field of view, along the side of the film that is chosen above")
    return settings if fov_set == settings.fov else constrained(with_field_of_view(settings, fov_set))


def _fisheye_view(settings: Settings) -> Settings:
    widest = math.pi if settings.projection == "orthographic" else WIDEST_FISHEYE
    fov = dial("Field of view", settings.fisheye_fov, dial_scales.fisheye_scale(widest),
               "Field of view of the image circle, which spans the side of the film that is chosen above")
    return replace(settings, fisheye_fov=fov)


def _focal_length(settings: Settings) -> Settings:
    """The focal length of a lens: its zoom, or the scale of the whole prescription."""
    if zooms(settings):
        return _zoom(settings)
    efl = full_view(settings)[1]
    designed = readings(replace(settings, focal_length=None)).efl or efl
    if designed <= 0.0:                                     # an edited lens may diverge
        imgui.text_disabled(f"Focal length  {true_minus(format_length(designed))}")
        imgui.set_item_tooltip("The lens diverges: it forms no image, and cannot be scaled to a focal length")
        return settings
    if _throws_none(settings, "Focal length"):
        return settings
    length = dial("Focal length", efl, dial_scales.focal_length_scale(designed / OCTAVES, designed * OCTAVES, designed),
                  "Focal length f: scales the whole prescription, with stop and clear apertures")
    if length == efl:
        return settings
    scaled = None if math.isclose(length, designed, rel_tol=1e-9) else length
    return constrained(replace(settings, focal_length=scaled))


def _scene_width(settings: Settings) -> Settings:
    width = dial("Width of the scene", settings.scene_width, dial_scales.width_scale(reset=DEFAULT.scene_width),
                 "Width of the scene that falls on the film's width, at any distance, in metres")
    return replace(settings, scene_width=width)


def _lens_radius(settings: Settings) -> Settings:
    radius = dial("Lens radius", settings.lens_radius, dial_scales.lens_radius_scale(reset=DEFAULT.lens_radius),
                  "Radius of the opening that the rays of a point in focus pass, in mm. 0: parallel, nothing blurs")
    return replace(settings, lens_radius=radius)


def _film_distance(settings: Settings) -> Settings:
    distances = dial_scales.focal_length_scale(5.0, 800.0, DEFAULT.hole_distance)
    distance = dial("Film distance", settings.hole_distance, distances,
                    "Distance from the hole to the film: the focal length of a pinhole")
    return replace(settings, hole_distance=distance)


def _hole(settings: Settings) -> Settings:
    best = readings(settings.plain("hole_diameter")).entrance_pupil or 0.3
    shown = settings.hole_diameter or best
    hole = dial("Hole", shown, dial_scales.hole_scale(best),
                "Diameter of the hole. The sharpest is 1.9 times the root of wavelength times film distance")
    return settings if hole == shown else replace(settings, hole_diameter=None if hole == best else hole)


def _zoom(settings: Settings) -> Settings:
    """The focal length of a zoom lens, at infinity."""
    lens = design(replace(settings, zoom=0.0))
    assert lens.positions is not None
    if not is_engraved(lens):
        zoom = dial("Zoom", settings.zoom, dial_scales.part_scale(1.0),
                    "Position of the groups along their travel: the focal length of this lens does not grow along it")
        return settings if zoom == settings.zoom else constrained(replace(settings, zoom=zoom))
    engraved = tuple(sorted(focal_length(lens, position) for position in lens.positions.zoom_stations))
    length = focal_length(lens, settings.zoom)
    turned = dial("Zoom", length, dial_scales.zoom_scale(engraved),
                  "Focal length f at infinity: the groups move along the zoom positions of the lens")
    if turned == length:
        return settings
    return constrained(replace(settings, zoom=engraved_zoom(lens, turned)))


DIALS: dict[str, Callable[[Settings], Settings]] = {
    "focus": _focus, "aperture": _aperture, "crop or zoom": _lens_view, "perspective view": _perspective_view,
    "fisheye view": _fisheye_view, "focal length": _focal_length, "scene width": _scene_width,
    "lens radius": _lens_radius, "film distance": _film_distance, "hole": _hole}
