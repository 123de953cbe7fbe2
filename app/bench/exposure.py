"""Exposure of a linear picture by f-number, time and ISO, the noise of a sensor, and the exposure modes of a camera.

A rendered picture has relative weights: 1 is the light of a white wall under an even sky, whatever the
stop. The plain exposure keeps these weights. With the exposure triangle, 1 saturates the sensor at the
ISO of the settings; with automatic ISO, at the ISO that a meter chooses for f-number and time. A sensor then
records the picture with its noise. None of this restarts the render.

P, A and S are held while the window is open: they write the f-number and the time that they choose into the settings,
whose `exposing` is then "triangle". So a saved picture has the exposure that it was taken with.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.bench.camera_kinds import readings
from lensbench.app.bench.framing import scene_exposure
from lensbench.app.settings.setting import Interval
from lensbench.app.settings.settings import Settings
from lensbench.core.imaging.exposure import SATURATION
from lensbench.core.scenery.shading.participating_medium import WATER_INDEX
from lensbench.core.text import fixed, significant, true_minus


@dataclass(frozen=True)
class AppliedExposure:
    """Gain, ISO and triangle, None without an f-number; share: of its light that falls on the film (`light_share`)."""

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


def recorded(settings: Settings, exposure: AppliedExposure, lines: NDArray[np.float32], top: int = 0,
             ) -> NDArray[np.float32]:
    """Lines of a picture, the first of which is `top`, as the sensor records them with this exposure."""
    light = lines * np.float32(exposure.gain)
    if not settings.noise:
        return light
    sensor = lb.Sensor(settings.full_well, settings.quantum_efficiency, settings.read_noise, bits=settings.bits)
    return sensor.record(light, exposure.iso, SATURATION / exposure.iso, settings.seed, top)


def look(settings: Settings) -> tuple:
    """The settings that `exposed` depends on, as a key for caches."""
    if settings.exposing == "plain" and not settings.noise:
        return ()
    return (settings.exposing, settings.metering, settings.iso, settings.shutter, settings.noise, settings.full_well,
            settings.quantum_efficiency, settings.read_noise, settings.bits, settings.seed,
            light_share(settings), readings(settings).working_f_number)


def exposure_text(applied: AppliedExposure) -> str:
    """The exposure value and the exposure H, in two lines."""
    if applied.triangle is None:
        return "No f-number, no exposure value"
    exposure = applied.triangle
    return (true_minus(f"EV {fixed(exposure.ev, 1)}   at ISO 100 {fixed(exposure.ev100, 1)}\n")
            + f"H {significant(applied.share * exposure.lux_seconds, 3)} lx s = "
              f"{significant(1e3 * applied.share * exposure.joules, 3)} mJ/m²")


MODES = {                       # letter: title, tooltip
    "off": ("As it is", "The light as it is: neither stop nor time nor ISO changes how bright the picture is"),
    "P": ("Program", "The meter chooses f-number and time, half the stops each"),
    "A": ("Aperture priority", "The f-number is set, the meter chooses the time"),
    "S": ("Shutter priority", "The time is set, the meter chooses the f-number"),
    "M": ("Manual", "f-number, time and ISO are set; the meter shows how far the picture is from its choice"),
    "I": ("Auto ISO", "f-number and time are set, the meter chooses the ISO"),
}
METERED = ("P", "A", "S")
EXPOSING = {"off": "plain", "I": "automatic"}           # the others: "triangle"
TIMES = Interval(1.0 / 8000.0, 30.0)                    # s, that the meter chooses among
NARROWEST = 22.0                                        # f-number that it chooses
TOLERANCE = 1.0 / 6.0                                   # stops from the meter within which nothing changes
SPARSE = 4                                              # every so many pixels, across and down, are metered


def mode_of(settings: Settings, kept_mode: str) -> str:
    """The mode of these settings; kept_mode: the one of METERED that the window holds, or ""."""
    if settings.exposing == "plain":
        return "off"
    return "I" if settings.exposing == "automatic" else kept_mode if kept_mode in METERED else "M"


def with_mode(settings: Settings, mode: str) -> Settings:
    """The settings for a mode: the exposure that a scene states is of the plain light, no correction of a meter."""
    exposing = EXPOSING.get(mode, "triangle")
    change = (exposing == "plain") - (settings.exposing == "plain")
    exposure = settings.exposure + change * scene_exposure(settings.scene)
    return replace(settings, exposing=exposing, exposure=exposure)


def meter_stops(settings: Settings, image: NDArray[np.float32]) -> float | None:
    """Stops by which a picture (h, w, 3) is brighter than meter and exposure dial want; None without f-number."""
    if applied_exposure(replace(settings, exposing="triangle"), image[:1, :1]).triangle is None:
        return None
    gain = applied_exposure(settings, image).gain
    metered_stops = lb.metered_stops(image[::SPARSE, ::SPARSE], settings.metering)
    return math.log2(max(gain, 1e-30)) + settings.exposure - metered_stops


def metered(settings: Settings, image: NDArray[np.float32], mode: str) -> Settings:
    """The settings with the f-number and the time that the meter chooses for a linear picture (h, w, 3).

    mode: one of METERED. They stay as they are within TOLERANCE, and end at the range of the lens and of TIMES. The
    exposure dial is a correction of the meter's choice. Of a camera whose f-number cannot be set the time alone
    follows, and in the mode S nothing.
    """
    off = meter_stops(replace(settings, exposure=0.0), image)
    if off is None or abs(off) < TOLERANCE or not math.isfinite(off):
        return settings
    if not settings.has_f_number:
        if mode == "S":
            return settings
        mode = "A"
    got = readings(settings)
    f_number = settings.f_number or got.f_number or 1.0
    time_stops, f_stops = {"A": (-off, 0.0), "S": (0.0, off), "P": (-0.5 * off, 0.5 * off)}[mode]
    widest = got.widest_f_number or f_number
    narrowed = min(max(f_number * 2.0 ** (0.5 * f_stops), widest), max(NARROWEST, widest))
    if mode == "P":                                     # what the lens cannot give is left to the time
        time_stops = -off + 2.0 * math.log2(narrowed / f_number)
    time = min(max(settings.shutter * 2.0**time_stops, TIMES.low), TIMES.high) if mode != "S" else settings.shutter
    if mode != "A":
        opened = settings.has_lens and narrowed <= widest * (1.0 + 1e-6)
        settings = replace(settings, f_number=None if opened else narrowed)
    return replace(settings, shutter=time)


class Metering:
    """Meters one picture while it refines. A choice that starts the picture anew must not be taken back by its noise.

    Few samples make the highlights brighter than many: without a memory the meter would choose from one sample, then
    from many, then from one again, and the picture would never be done.
    """

    def __init__(self) -> None:
        self._samples = 0               # of the picture that the latest choice was made from

    def forget(self) -> None:
        """Another picture is taken: its first samples are good enough again."""
        self._samples = 0

    def chosen(self, settings: Settings, image: NDArray[np.float32], samples: int, mode: str) -> Settings:
        """As `metered`, of a picture (h, w, 3) with so many samples; unchanged while it has fewer than the last one."""
        if samples < self._samples:
            return settings
        chosen = metered(settings, image, mode)
        if chosen != settings:
            self._samples = samples
        return chosen
