"""The exposure triangle: f-number, shutter time and ISO, and how much light they leave for the picture.

A scene's radiance 1 stands for LUMINANCE, a white wall on an overcast day; in watts all light
counts as that of 555 nm, of which one makes EFFICACY lumens. On the axis of a lens a film gets
E = π L sin²θ′ = π L / (4 N²) with N the working f-number, and over the time t the exposure
H = E t: lux seconds, or J/m². A picture's value 1 is the exposure that saturates at its ISO,
SATURATION / ISO lux seconds (ISO 12232, the saturation-based speed); METER is the constant of
meters of reflected light (ISO 2720), by which EV100 names a luminance.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from lensbench.imaging.film import Film

LUMINANCE = 1000.0              # cd/m² of radiance 1
EFFICACY = 683.0                # lm/W at 555 nm
RADIANCE = LUMINANCE / EFFICACY         # W/(m² sr) of radiance 1
METER = 12.5                    # cd s/m²: N² / t = luminance · ISO / METER
SATURATION = 78.0               # lux s, over the ISO
PHOTONS = 555e-9 / (6.62607015e-34 * 299792458.0) / EFFICACY * 1e-12   # to a µm² in a lux second: 4,091
GREY = 10.0 / SATURATION        # what a meter makes of the mean: 10 / ISO lux s
LUMA = (0.2126, 0.7152, 0.0722)
METHODS = ("mean", "highlights")
CLIPPED = 0.001                 # part of the picture that "highlights" lets clip


class ExposureError(ValueError):
    """An exposure or a sensor that cannot be; the message says what to do."""


@dataclass(frozen=True)
class Exposure:
    """f-number (the working one, where focus is near), shutter time (s), ISO; ExposureError where one cannot be."""

    f_number: float
    time: float
    iso: float = 100.0

    def __post_init__(self):
        for name, value in (("f-number", self.f_number), ("shutter time", self.time), ("ISO", self.iso)):
            checked_positive(name, value)

    @property
    def ev(self) -> float:
        """log₂(N² / t), whatever the ISO."""
        return math.log2(self.f_number**2 / self.time)

    @property
    def ev100(self) -> float:
        """The EV at ISO 100 that lets the same luminance come out the same."""
        return self.ev - math.log2(self.iso / 100.0)

    @property
    def luminance(self) -> float:
        """cd/m² that a meter would give this exposure for."""
        return luminance(self.ev100)

    @property
    def lux_seconds(self) -> float:
        """On the axis, of a scene of radiance 1."""
        return LUMINANCE * math.pi / (4.0 * self.f_number**2) * self.time

    @property
    def joules(self) -> float:
        """J/m² on the axis, of a scene of radiance 1."""
        return self.lux_seconds / EFFICACY

    @property
    def brightness(self) -> float:
        """What a picture of relative weights is multiplied by: its axis then is 1 where it saturates at this ISO."""
        return self.lux_seconds * self.iso / SATURATION

    def brighter(self, stops: float, by: str = "time") -> "Exposure":
        """The exposure that makes pictures brighter by so many stops, by its "time", "iso" or "f_number" alone."""
        if not math.isfinite(stops):
            raise ExposureError(f"{stops} stops: it must be a finite number")
        factor = 2.0**stops
        if by == "f_number":
            return replace(self, f_number=self.f_number / math.sqrt(factor))
        if by not in ("time", "iso"):
            raise ExposureError(f"brighter by {by!r}: choose one of time, iso, f_number")
        return replace(self, **{by: getattr(self, by) * factor})

    def at_ev100(self, ev100: float, by: str = "time") -> "Exposure":
        """The exposure of this EV100, by changing its "time", "iso" or "f_number" alone."""
        return self.brighter(self.ev100 - ev100, by)


def luminance(ev100: float) -> float:
    """cd/m² that an EV at ISO 100 is metered for."""
    return METER / 100.0 * 2.0**ev100


def ev100(luminance: float) -> float:
    """The EV at ISO 100 that a meter gives for a luminance (cd/m²)."""
    return math.log2(checked_positive("luminance", luminance) * 100.0 / METER)


def metered_stops(image, method: str = "mean") -> float:
    """By how many stops to brighten a picture (h, w, 3), linear, 1 where it saturates, for a normal exposure.

    "mean": the mean of the logarithm of its luminance becomes GREY, as meters have it; what is darker than the
    plain mean by more than 12 stops does not count. "highlights": all but a thousandth of the pixels stay below 1
    in every channel. 0 where the picture is black.
    """
    if method not in METHODS:
        raise ExposureError(f"metering {method!r}: choose one of {', '.join(METHODS)}")
    pixels = np.asarray(image, np.float32).reshape(-1, 3)
    if method == "highlights":
        peak = pixels.max(1)
        level = float(np.partition(peak, -1 - int(CLIPPED * len(peak)))[-1 - int(CLIPPED * len(peak))])
        return -math.log2(level) if math.isfinite(level) and level > 0.0 else 0.0
    luma = pixels @ np.array(LUMA, np.float32)
    luma = luma[np.isfinite(luma) & (luma > 0.0)]
    if not luma.size:
        return 0.0
    luma = luma[luma >= luma.mean(dtype=np.float64) * 2.0**-12]
    return math.log2(GREY) - float(np.log2(luma).mean(dtype=np.float64))


def irradiance(image, open_time: float) -> np.ndarray:
    """E in W/m² of a picture (h, w, 3) of physical weights that was exposed for this effective time (s)."""
    return np.asarray(image) * (RADIANCE / checked_positive("open time", open_time))


def radiant_exposure(image) -> np.ndarray:
    """H in J/m² of a picture (h, w, 3) of physical weights: ∫ E dt."""
    return np.asarray(image) * RADIANCE


def pixel_energy(image, film: Film) -> np.ndarray:
    """J that each pixel of the film collects, of a picture (h, w, 3) of physical weights: ∫∫ H dA."""
    return radiant_exposure(image) * (film.pitch * 1e-3) ** 2


def checked_positive(name: str, value: float) -> float:
    """The value; ExposureError where it is no positive finite number."""
    if not (math.isfinite(value) and value > 0.0):
        raise ExposureError(f"{name} {value:g}: it must be a positive number")
    return value
