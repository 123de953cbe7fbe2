"""Camera kinds: the maker of each, its read-outs and its field of view.

A new kind of camera is one row of MAKERS here and one of `camera_facts`. A maker turns Settings into a camera of the
core; a read-out function into Readings. Lengths in mm.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import design, lens_camera, place_and_shutter, stop_picture
from lensbench.app.bench.readouts import Readings, airy_diameter, angles, blur_limit, lens_readings
from lensbench.app.bench.water_window import port_of
from lensbench.app.settings.camera_facts import LENS_MODELS
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings
from lensbench.core.text import significant


def _stop(settings: Settings) -> dict[str, Any]:
    """The shape of the stop, as cameras without a lens take it: corners of blades lie on the circle of its radius."""
    if settings.stop_image:
        return {"stop_image": stop_picture(settings.stop_image)}
    return {"blades": settings.blades or 0, "blade_rotation": settings.blade_rotation,
            "roundness": settings.roundness}


def seen_angles(camera: lb.Camera) -> np.ndarray:
    """Twice the angle from the axis (radians) of rays at a side, at the top and at a corner of the film; nan: dark."""
    film = camera.film
    edges = [[0.0, film.pixels_y / 2.0], [film.pixels_x / 2.0, 0.0], [0.0, 0.0]]
    rays = camera.with_open_stop.generate_rays(edges, np.full((3, 2), 0.5))
    return np.where(rays.weights > 0.0, 2.0 * np.arccos(np.clip(-rays.directions[:, 2], -1.0, 1.0)), math.nan)


# Perspective


def perspective(settings: Settings) -> lb.PerspectiveCamera:
    """An ideal thin lens; SettingsError where it is focused nearer than twice its focal length."""
    focal_length = perspective_focal_length(settings)
    shape, radius = _stop(settings), 0.0
    if settings.f_number is not None:       # that of a circle of as much area
        iris = lb.Iris(shape.get("blades", 0), shape.get("blade_rotation", 0.0), shape.get("roundness", 0.0),
                       shape.get("stop_image"))
        radius = focal_length / settings.f_number / 2.0 / iris.equivalent_radius
    port = port_of(settings)
    focus = port.apparent(settings.focus_distance)
    if radius > 0.0 and focus < 2.0 * focal_length:
        nearest = port.true(2.0 * focal_length)
        raise SettingsError(f"focus at {significant(settings.focus_distance / 1000.0, 6)} m: the nearest distance of "
                            f"this camera is {significant(math.ceil(nearest) / 1000.0)} m, "
                            + ("twice its focal length" if port.index == 1.0 else "which it sees at twice its focal "
                               "length through the window"))
    return lb.PerspectiveCamera(settings.film, fov=settings.fov, fov_axis=settings.fov_axis, lens_radius=radius,
                                focus_distance=focus, **shape, **place_and_shutter(settings))


def perspective_focal_length(settings: Settings) -> float:
    """The focal length (mm) of the perspective camera, which follows from its field of view and its film."""
    return lb.PerspectiveCamera(settings.film, fov=settings.fov, fov_axis=settings.fov_axis).film_distance


@lru_cache(maxsize=64)
def perspective_readings(settings: Settings) -> Readings:
    """The read-outs of an ideal thin lens of the focal length that the field of view implies."""
    film, limit, port = settings.film, blur_limit(settings), port_of(settings)
    efl = perspective_focal_length(settings)
    plain = replace(angles(film, efl, port=port), efl=efl, limit=limit)
    if settings.f_number is None:
        return plain
    plain = replace(plain, f_number=settings.f_number, entrance_pupil=efl / settings.f_number,
                    hyperfocal=port.true(efl**2 / (settings.f_number * limit)), nearest_focus=port.true(2.0 * efl),
                    working_f_number=settings.f_number, airy=airy_diameter(settings.f_number))
    focus = port.apparent(settings.focus_distance)
    try:
        perspective(settings)                           # refuses what is too near
        near, far = lb.depth_of_field(*focused_lens(settings), focus, limit)
    except (lb.LensError, lb.CameraError, SettingsError) as error:
        return replace(plain, reason=str(error))
    return replace(plain, near_limit=port.true(near), far_limit=port.true(far), magnification=efl / focus)


def focused_lens(settings: Settings) -> tuple[float, float]:
    """Focal length (mm) and f-number of the ideal lens in focus: its film stays where it is, and its power rises."""
    efl = perspective_focal_length(settings)
    focused = 1.0 / (1.0 / efl + 1.0 / port_of(settings).apparent(settings.focus_distance))
    return focused, (settings.f_number or math.inf) * focused / efl


# Orthographic


def orthographic(settings: Settings) -> lb.OrthographicCamera:
    """Parallel rays, or cones of them about parallel axes."""
    return lb.OrthographicCamera(settings.film, settings.scene_width * settings.crop, settings.lens_radius,
                                 port_of(settings).apparent(settings.focus_distance), **_stop(settings),
                                 **place_and_shutter(settings))


def orthographic_readings(settings: Settings) -> Readings:
    """The magnification, the same at every distance."""
    return Readings(magnification=settings.film_width / settings.scene_width, limit=blur_limit(settings),
                    reason="An orthographic camera sees along parallel rays: it has neither a focal length nor a "
                           "field of view")


# Fisheye


def fisheye(settings: Settings) -> lb.FisheyeCamera:
    """A camera that maps angles from the axis to lengths on the film by a projection."""
    return lb.FisheyeCamera(settings.film, settings.fisheye_fov, settings.projection, settings.fov_axis,
                            **place_and_shutter(settings))


@lru_cache(maxsize=64)
def fisheye_readings(settings: Settings) -> Readings:
    """Twice the angle from the axis of rays at the film's sides and corner, within the image circle."""
    of = fisheye(settings)
    full = seen_angles(of)
    across, down, diagonal = (float(angle) for angle in np.where(np.isnan(full), settings.fisheye_fov, full))
    return Readings(efl=of.focal_length, limit=blur_limit(settings), fov_horizontal=across, fov_vertical=down,
                    fov_diagonal=diagonal, reason="An ideal fisheye sees from a point: it has no lens to focus")


# Panorama


def environment(settings: Settings) -> lb.EnvironmentCamera:
    """Every direction from one point, in one picture."""
    return lb.EnvironmentCamera(settings.film, settings.layout, **place_and_shutter(settings))


def environment_readings(settings: Settings) -> Readings:
    """The whole sphere."""
    return Readings(fov_horizontal=2.0 * math.pi, fov_vertical=math.pi,
                    reason="A panorama sees in every direction from a point: nothing is out of focus")


# Pinhole of finite size


def finite_pinhole(settings: Settings) -> lb.PinholeCamera:
    """A round hole before a film."""
    return lb.PinholeCamera(settings.film, settings.hole_distance, hole_diameter(settings) / 2.0,
                            **place_and_shutter(settings))


def hole_diameter(settings: Settings) -> float:
    """The diameter of the hole (mm): as it is set, or the sharpest for distant objects."""
    return settings.hole_diameter or lb.best_pinhole(settings.hole_distance)


@lru_cache(maxsize=64)
def finite_pinhole_readings(settings: Settings) -> Readings:
    """The read-outs of a hole: the blur of hole and diffraction is nearly the same at every distance."""
    film, of = settings.film, finite_pinhole(settings)
    return replace(angles(film, of.distance, port=port_of(settings)), efl=of.distance, limit=blur_limit(settings),
                   f_number=of.f_number,
                   working_f_number=of.f_number, film_distance=of.distance, entrance_pupil=2.0 * of.radius,
                   airy=of.diffraction())


def finite_pinhole_view(settings: Settings) -> tuple[float, float]:
    """The field of view along the shorter side of the film in use, and the distance from hole to film."""
    shorter = min(settings.film_width, settings.film_height)
    return 2.0 * math.atan(0.5 * shorter * settings.crop / settings.hole_distance), settings.hole_distance


# Bare sensor


def bare_sensor(settings: Settings) -> lb.BareSensor:
    """A film without a lens."""
    return lb.BareSensor(settings.film, **place_and_shutter(settings))


def bare_sensor_readings(settings: Settings) -> Readings:
    """The reason why there are no read-outs."""
    return Readings(limit=blur_limit(settings),
                    reason="Without a lens each point of the film gets light from the whole scene: no picture forms")


@dataclass(frozen=True)
class CameraMaker:
    """How a kind of camera is made and read.

    view: its field of view (radians) and the focal length (mm) that this is seen with. with_view: settings with another
    field of view. Both are None for a kind without a field of view of its own.
    """

    camera: Callable[[Settings], lb.Camera]
    readings: Callable[[Settings], Readings]
    view: Callable[[Settings], tuple[float, float]] | None = None
    with_view: Callable[[Settings, float], Settings] | None = None


MAKERS = {
    "lens": CameraMaker(lens_camera, lens_readings),
    "perspective": CameraMaker(
        perspective, perspective_readings, lambda settings: (settings.fov, perspective_focal_length(settings)),
        lambda settings, fov: replace(settings, fov=fov)),
    "orthographic": CameraMaker(orthographic, orthographic_readings),
    "fisheye": CameraMaker(
        fisheye, fisheye_readings, lambda settings: (settings.fisheye_fov, fisheye(settings).focal_length),
        lambda settings, fov: replace(settings, fisheye_fov=fov)),
    "environment": CameraMaker(environment, environment_readings),
    "finite-pinhole": CameraMaker(
        finite_pinhole, finite_pinhole_readings, finite_pinhole_view,
        lambda settings, fov: replace(settings, hole_distance=0.5 * min(
            settings.film.width, settings.film.height) / math.tan(0.5 * fov))),
    "bare-sensor": CameraMaker(bare_sensor, bare_sensor_readings),
}


def camera(settings: Settings) -> lb.Camera:
    """The camera of these settings; SettingsError, LensError or CameraError where they are impossible."""
    return MAKERS[settings.camera].camera(settings)


def readings(settings: Settings) -> Readings:
    """All read-outs of these settings; for invalid settings the reason, never an exception."""
    try:
        return MAKERS[settings.camera].readings(settings.optics)
    except (ValueError, OSError) as error:
        return Readings(reason=str(error))


def unfit(settings: Settings, model: str) -> str:
    """Why the lens of these settings cannot have this model, a key of LENS_MODELS, in a sentence; "" where it can."""
    if LENS_MODELS[model].any_lens:
        return ""
    try:
        asymmetry = design(settings).asymmetry
    except (ValueError, OSError):                   # the worker reports it
        return ""
    return f"Needs a rotationally symmetric lens; this one has {asymmetry}" if asymmetry else ""
