"""The rings of the left column: those that the camera has, one below the other."""

import math
from dataclasses import replace

from lensbench.app.state import scales, sensor_scales, time_scales
from lensbench.app.state.build import design
from lensbench.app.state.constraints import (
    WIDEST_FISHEYE,
    constrained,
    ends_of_view,
    field_of_view,
    full_view,
    with_field_of_view,
    zooms,
)
from lensbench.app.state.figures import Readings, readings
from lensbench.app.state.settings import Settings
from lensbench.app.state.zoom import focal_length, zoom_of
from lensbench.app.widgets.dial import ring

DEFAULT = Settings()
PERSPECTIVE_FOV = (math.radians(5.0), math.radians(120.0))
NEAREST = 10.0                  # mm: of the orthographic camera's focus


def ring_count(settings: Settings) -> int:
    """How many rings `rings` draws."""
    return {"perspective": 4, "orthographic": 4, "fisheye": 2, "environment": 1, "hole": 3,
            "bare": 1, "pinhole": 4}.get(settings.model, 5)


def rings(settings: Settings) -> Settings:
    """Draw the rings of this camera; the settings as they have been turned."""
    if settings.model == "orthographic":
        settings = _orthographic(settings)
    elif settings.model == "fisheye":
        settings = _fisheye(settings)
    elif settings.model == "hole":
        settings = _hole(settings)
    elif settings.model not in ("environment", "bare"):
        settings = _of_lens(settings)
    exposure = ring("Exposure", settings.exposure, scales.exposure_scale(),
                    "Stops by which the picture is brightened; the stop itself does not change its brightness"
                    if settings.exposing == "plain" else
                    "Stops by which the picture is brightened over what f-number, time and ISO make of it")
    return replace(settings, exposure=exposure)


def _of_lens(settings: Settings) -> Settings:
    """Focus, aperture, field of view and focal length or zoom, of a lens or of the perspective camera."""
    figures = readings(settings)

    # Focus
    nearest = figures.nearest_focus if figures.nearest_focus is not None else full_view(settings)[1]
    settings = _focus(settings, figures, nearest)

    if settings.model != "pinhole":
        settings = _aperture(settings, figures.widest_f_number or 1.0)

    # Field of view and focal length
    efl, zooming = full_view(settings)[1], zooms(settings)
    if settings.model == "perspective":
        fov_scale = scales.fov_scale(*PERSPECTIVE_FOV, DEFAULT.fov)
        tip = "Field of view, along the side of the film that is chosen above"
    else:
        narrow, wide = ends_of_view(settings)
        fov_scale = scales.fov_scale(narrow, wide, wide)
        tip = "Field of view along the shorter side: turns the zoom, and beyond its longest end uses less of the film" \
            if zooming else "Field of view along the shorter side: a smaller one uses less of the film"
    fov = field_of_view(settings)
    turned = ring("Field of view", fov, fov_scale, tip)
    if turned != fov:
        settings = with_field_of_view(settings, turned)
        if settings.model == "perspective" or zooming:      # whose focal length follows
            settings = constrained(settings)
    if zooming:
        settings = _zoom(settings)
    elif settings.model != "perspective":
        designed = readings(replace(settings, focal_length=None)).efl or efl
        length = ring("Focal length", efl, _focal_lengths(designed),
                      "Focal length f: scales the whole prescription, stop and rims included")
        if length != efl:
            scaled = None if math.isclose(length, designed, rel_tol=1e-9) else length
            settings = constrained(replace(settings, focal_length=scaled))
    return settings


def _focus(settings: Settings, figures: Readings, nearest: float) -> Settings:
    zone = None
    if figures.near_limit is not None and figures.far_limit is not None:
        zone = (figures.near_limit, figures.far_limit if figures.far_limit > 0.0 else math.inf)
    distance = ring("Focus distance", settings.focus_distance,
                    scales.focus_scale(nearest * 1.0001, max(DEFAULT.focus_distance, nearest * 1.0001)),
                    "Distance from the film to what the lens would be focused on, s: the film stands there, and\n"
                    "everything is sharp" if settings.model == "pinhole" else
                    "Distance from the film to what is in focus, s; the amber zone is the depth of field", zone)
    return replace(settings, focus_distance=distance)


def _aperture(settings: Settings, widest: float) -> Settings:
    """Wide open is where the ring ends."""
    shown = settings.f_number if settings.f_number is not None else widest
    f_number = ring("Aperture", shown, scales.aperture_scale(widest, max(DEFAULT.f_number or widest, widest)),
                    "f-number N: focal length over the diameter of the entrance pupil")
    if f_number == shown:
        return settings
    opened = f_number <= widest and settings.model != "perspective"
    return replace(settings, f_number=None if opened else f_number)


def _orthographic(settings: Settings) -> Settings:
    """How much of the scene it sees, and how its rays part."""
    width = ring("Width of the scene", settings.scene_width, time_scales.width_scale(reset=DEFAULT.scene_width),
                 "How much of the scene falls on the film's width, at any distance, in metres")
    settings = _focus(replace(settings, scene_width=width), readings(settings), NEAREST)
    radius = ring("Lens radius", settings.lens_radius, time_scales.lens_radius_scale(reset=DEFAULT.lens_radius),
                  "How far the rays of a point in focus part at the camera, in mm. 0: parallel, nothing blurs")
    return replace(settings, lens_radius=radius)


def _fisheye(settings: Settings) -> Settings:
    widest = math.pi if settings.projection == "orthographic" else WIDEST_FISHEYE
    fov = ring("Field of view", settings.fisheye_fov, time_scales.fisheye_scale(widest),
               "Field of view of the image circle, which spans the side of the film that is chosen above")
    return replace(settings, fisheye_fov=fov)


def _zoom(settings: Settings) -> Settings:
    """The focal length of a zoom lens, at infinity; what the lens cannot do there gives way."""
    lens = design(replace(settings, zoom=0.0))
    assert lens.positions is not None
    engraved = tuple(sorted(focal_length(lens, place) for place in lens.positions.zoom_stations))
    length = focal_length(lens, settings.zoom)
    turned = ring("Zoom", length, scales.zoom_scale(engraved),
                  "Focal length f at infinity, to which the zoom is turned: the groups move as the lens's stations say")
    if turned == length:
        return settings
    return constrained(replace(settings, zoom=zoom_of(lens, turned)))


def _hole(settings: Settings) -> Settings:
    distances = scales.focal_length_scale(5.0, 800.0, DEFAULT.hole_distance)
    distance = ring("Film distance", settings.hole_distance, distances,
                    "From the hole to the film: the focal length of a pinhole")
    settings = replace(settings, hole_distance=distance)
    best = readings(settings.plain("hole_diameter")).entrance_pupil or 0.3
    shown = settings.hole_diameter or best
    hole = ring("Hole", shown, sensor_scales.hole_scale(best),
                "Diameter of the hole. The sharpest is 1.9 times the root of wavelength times film distance")
    return settings if hole == shown else replace(settings, hole_diameter=None if hole == best else hole)


def _focal_lengths(designed: float) -> scales.Scale:
    """A ring of two octaves and a half to either side of what the lens was designed for."""
    return scales.focal_length_scale(designed / 6.0, designed * 6.0, designed)
