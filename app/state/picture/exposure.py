"""Exposure of a linear picture by f-number, time and ISO, and the noise of a sensor.

A rendered picture has relative weights: 1 is the light of a white wall under an even sky, whatever the
stop. The plain exposure keeps these weights. With the exposure triangle, 1 saturates the sensor at the
ISO of the settings; with automatic ISO, at the ISO that a meter chooses for f-number and time. A sensor then
records the picture with its noise. None of this restarts the render.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.state.camera_kinds import readings
from lensbench.app.state.settings import Settings
from lensbench.imaging.exposure import SATURATION
from lensbench.kernels.figures import fixed, significant, true_minus
from lensbench.scenery.shading.participating_medium import WATER_INDEX


@dataclass(frozen=True)
class AppliedExposure:
    """The gain of the light, the ISO, and the exposure triangle; None for a camera without an f-number.

    share: of the triangle's light that falls on the film; see `light_share`.
    """

    gain: float
    iso: float
    triangle: lb.Exposure | None
    share: float = 1.0


def has_triangle(settings: Settings) -> bool:
    """Whether the camera has an f-number, without which there is no exposure triangle."""
    return _f_number(settings) is not None


def _f_number(settings: Settings) -> float | None:
    """The f-number that exposes: the working one where it is known."""
    got = readings(settings)
    return got.working_f_number or got.f_number


def light_share(settings: Settings) -> float:
    """Light that falls on the film over that of f-number and time, as pictures of physical weights have it.

    A shutter with ramps passes the light of its effective time, and radiance falls by the squared index when light
    leaves water for air, before the lens or in it.
    """
    index = WATER_INDEX if settings.medium == "water" else 1.0
    return (1.0 - settings.shutter_ramp) / index**2


def applied_exposure(settings: Settings, image: NDArray[np.float32]) -> AppliedExposure:
    """The exposure of a linear picture (h, w, 3) of these settings."""
    f_number = _f_number(settings)
    triangle = None if f_number is None else lb.Exposure(f_number, settings.shutter, settings.iso)
    share = light_share(settings)
    if settings.exposing == "automatic":
        gain = 2.0 ** lb.metered_stops(image, settings.metering)
        if triangle is None:
            return AppliedExposure(gain, settings.iso, None)
        iso = settings.iso * gain / (triangle.brightness * share)
        return AppliedExposure(gain, iso, lb.Exposure(triangle.f_number, triangle.time, iso), share)
    if settings.exposing == "triangle" and triangle is not None:
        return AppliedExposure(triangle.brightness * share, settings.iso, triangle, share)
    return AppliedExposure(1.0, settings.iso, triangle, share)


def exposed(settings: Settings, image: NDArray[np.float32]) -> NDArray[np.float32]:
    """The exposed picture as the sensor records it; the picture itself if neither changes it."""
    if settings.exposing == "plain" and not settings.noise:
        return image
    return recorded(settings, applied_exposure(settings, image), image)


def recorded(settings: Settings, found: AppliedExposure, lines: NDArray[np.float32], top: int = 0,
             ) -> NDArray[np.float32]:
    """Lines of a picture, the first of which is `top`, as the sensor records them with this exposure."""
    light = lines * np.float32(found.gain)
    if not settings.noise:
        return light
    sensor = lb.Sensor(settings.full_well, settings.quantum_efficiency, settings.read_noise, bits=settings.bits)
    return sensor.record(light, found.iso, SATURATION / found.iso, settings.seed, top)


def look(settings: Settings) -> tuple:
    """The settings that `exposed` depends on, as a key for caches."""
    if settings.exposing == "plain" and not settings.noise:
        return ()
    return (settings.exposing, settings.metering, settings.iso, settings.shutter, settings.noise, settings.full_well,
            settings.quantum_efficiency, settings.read_noise, settings.bits, settings.seed,
            light_share(settings), readings(settings).working_f_number)


def exposure_text(found: AppliedExposure) -> str:
    """The exposure value and the exposure H, in two lines."""
    if found.triangle is None:
        return "No f-number, no exposure value"
    exposure = found.triangle
    return (true_minus(f"EV {fixed(exposure.ev, 1)}   at ISO 100 {fixed(exposure.ev100, 1)}\n")
            + f"H {significant(found.share * exposure.lux_seconds, 3)} lx s = "
              f"{significant(1e3 * found.share * exposure.joules, 3)} mJ/m²")
