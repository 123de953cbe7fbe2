"""Camera kinds: the maker of each, its read-outs and its field of view.

A new kind of camera is one row here and one of `camera_facts`. Makers and read-outs longer than a line are in
`ideal_cameras`.
"""

from collections.abc import Callable
from dataclasses import dataclass

import lensbench as lb
from lensbench.app.state import ideal_cameras as ideal
from lensbench.app.state.build import design, lens_camera
from lensbench.app.state.camera_facts import LENS_MODELS
from lensbench.app.state.figures import Readings, lens_readings
from lensbench.app.state.settings import Settings


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
    "perspective": CameraMaker(ideal.perspective, ideal.perspective_readings, ideal.perspective_view,
                               ideal.perspective_with_view),
    "orthographic": CameraMaker(ideal.orthographic, ideal.orthographic_readings),
    "fisheye": CameraMaker(ideal.fisheye, ideal.fisheye_readings, ideal.fisheye_view, ideal.fisheye_with_view),
    "environment": CameraMaker(ideal.environment, ideal.environment_readings),
    "finite-pinhole": CameraMaker(ideal.finite_pinhole, ideal.finite_pinhole_readings, ideal.finite_pinhole_view,
                                  ideal.finite_pinhole_with_view),
    "bare-sensor": CameraMaker(ideal.bare_sensor, ideal.bare_sensor_readings),
}


def camera(settings: Settings) -> lb.Camera:
    """The camera of these settings.

    SettingsError, LensError or CameraError for impossible settings, such as a focus nearer than the nearest.
    """
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
    return f"Of a lens with rotational symmetry alone: this one has {asymmetry}" if asymmetry else ""
