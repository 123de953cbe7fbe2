"""The exposure modes of a camera: which of f-number, time and ISO are set, and which follow the meter.

P, A and S are held while the window is open: they write the f-number and the time that they choose into the settings,
whose `exposing` is then "triangle". So a saved picture has the exposure that it was taken with.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.state.camera_kinds import readings
from lensbench.app.state.picture.exposure import applied_exposure
from lensbench.app.state.setting import Interval
from lensbench.app.state.settings import Settings

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


def mode_of(settings: Settings, held: str) -> str:
    """The mode of these settings; held: the one of METERED that the window holds, or ""."""
    if settings.exposing == "plain":
        return "off"
    return "I" if settings.exposing == "automatic" else held if held in METERED else "M"


def with_mode(settings: Settings, mode: str) -> Settings:
    """The settings for a mode."""
    return replace(settings, exposing=EXPOSING.get(mode, "triangle"))


def meter_stops(settings: Settings, image: NDArray[np.float32]) -> float | None:
    """Stops by which a linear picture (h, w, 3) is brighter than its meter would have it; None without an f-number.

    The exposure dial counts.
    """
    if applied_exposure(replace(settings, exposing="triangle"), image[:1, :1]).triangle is None:
        return None
    gain = applied_exposure(settings, image).gain
    wanted = lb.metered_stops(image[::SPARSE, ::SPARSE], settings.metering)
    return math.log2(max(gain, 1e-30)) + settings.exposure - wanted


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
        found = metered(settings, image, mode)
        if found != settings:
            self._samples = samples
        return found
