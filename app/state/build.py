"""The lens and the camera that follow from the settings. Lengths in mm, angles in radians."""

import math
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import lensbench as lb
from lensbench import lenses
from lensbench.app.state.focusing import focusing
from lensbench.app.state.settings import Settings, SettingsError
from lensbench.scenery.shading.participating_medium import WATER_INDEX


@lru_cache(maxsize=64)
def _load(lens: str, stamp: float) -> lb.Lens:
    return lenses.load(lens).at(zoom=0.0, close=0.0)


def design(settings: Settings) -> lb.Lens:
    """The lens wide open, scaled to the focal length that is set (of a zoom its shortest), then zoomed.

    LensError where it is to zoom and cannot.
    """
    path = Path(settings.lens)
    lens = _load(settings.lens, path.stat().st_mtime if path.is_file() else 0.0)
    if settings.blades is not None:
        lens = replace(lens, blades=settings.blades, blade_rotation=settings.blade_rotation,
                       roundness=settings.roundness)
    if settings.medium == "water" and settings.wet:
        lens = replace(lens, front_index=WATER_INDEX)
    if settings.focal_length is not None:
        lens = lens.scaled(settings.focal_length / lb.first_order(lens).efl)
    return lens.at(zoom=settings.zoom)


def camera(settings: Settings) -> lb.Camera:
    """The camera of these settings: a LensCamera, or where no prescription is used, one of the ideal cameras.

    SettingsError where a perspective camera is focused nearer than magnification 1, as FocusError for a lens.
    """
    film = settings.film
    ramp = settings.shutter_ramp * settings.shutter
    common: dict[str, Any] = {
        "world_from_camera": settings.placement, "shutter_open": settings.moment,
        "shutter_close": settings.moment + settings.shutter, "shutter_ramp": ramp,
        "readout": settings.readout, "readout_direction": settings.readout_direction, "medium": medium(settings)}
    stop: dict[str, Any] = {"blades": settings.blades or 0, "blade_rotation": settings.blade_rotation,
                            "roundness": settings.roundness}
    if settings.model == "perspective":
        focal_length = perspective_focal_length(settings)
        radius = 0.0 if settings.f_number is None else focal_length / settings.f_number / 2.0
        if radius > 0.0 and settings.focus_distance < 2.0 * focal_length:
            raise SettingsError(f"focus at {settings.focus_distance / 1000.0:.6g} m: the nearest distance of this "
                                f"camera is {math.ceil(2.0 * focal_length) / 1000.0:g} m, twice its focal length")
        return lb.PerspectiveCamera(film, fov=settings.fov, fov_axis=settings.fov_axis, lens_radius=radius,
                                    focus_distance=settings.focus_distance, **stop, **common)
    if settings.model == "orthographic":
        return lb.OrthographicCamera(film, settings.scene_width * settings.crop, settings.lens_radius,
                                     settings.focus_distance, **stop, **common)
    if settings.model == "hole":
        return lb.PinholeCamera(film, settings.hole_distance, hole_diameter(settings) / 2.0, **common)
    if settings.model == "bare":
        return lb.BareSensor(film, **common)
    if settings.model == "fisheye":
        return lb.FisheyeCamera(film, settings.fisheye_fov, settings.projection, settings.fov_axis, **common)
    if settings.model == "environment":
        return lb.EnvironmentCamera(film, settings.layout, **common)
    lens = design(settings)
    return lb.LensCamera(lens, film, focus_distance=settings.focus_distance, f_number=settings.f_number,
                         model=settings.model, degree=settings.degree,
                         dispersion={"auto": None, "on": True, "off": False}[settings.dispersion],
                         focus_method=focusing(stopped(lens, settings), settings).method, **common)


def stopped(lens: lb.Lens, settings: Settings) -> lb.Lens:
    """The lens closed to the f-number that is set; as it is where it cannot open so far."""
    try:
        return lens if settings.f_number is None else lb.stopped_down(lens, settings.f_number)
    except lb.LensError:
        return lens


def medium(settings: Settings) -> lb.Medium | None:
    """What lies before the camera; None for clear air."""
    if settings.medium == "air":
        return None
    kind = lb.Medium.water if settings.medium == "water" else lb.Medium.fog
    return kind(settings.visibility, (settings.fog_light,) * 3)


def perspective_focal_length(settings: Settings) -> float:
    """Of the perspective camera, mm: what its field of view makes of its film."""
    return lb.PerspectiveCamera(settings.film, fov=settings.fov, fov_axis=settings.fov_axis).film_distance


def hole_diameter(settings: Settings) -> float:
    """Of the pinhole of finite size, mm: as it is set, or the sharpest for what is far away."""
    return settings.hole_diameter or lb.best_pinhole(settings.hole_distance)
