"""The exposure triangle and the shutter: f-number, shutter time and ISO, and the light that they give the picture.

Radiance 1 of a scene represents LUMINANCE, a white wall on an overcast day. All light counts as light of 555 nm, of
which one watt is EFFICACY lumens. On the axis a film receives E = π L sin²θ′ = π L / (4 N²), N the working f-number,
and over the time t the exposure H = E t, in lux seconds or J/m². The value 1 of a picture is the exposure that
saturates at its ISO, SATURATION / ISO lux seconds (ISO 12232). METER is the constant of meters for reflected light (ISO
2720).

Each row of the film is open for `open_time` seconds. What the shutter passes rises and falls linearly over `ramp`
seconds: a trapezoid, or a box. With a rolling shutter the rows open one after the other, the first at 0 s and the last
`readout` seconds later.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.imaging.film import Film
from lensbench.core.kernels.block import TIME, B, Step, X, Y, rows, stage
from lensbench.core.text import significant

DIRECTIONS = ("down", "up", "left", "right")        # of a rolling shutter, in the upright picture

OPEN_TIME, RAMP, DELAY, DELAY_X, DELAY_Y = range(5)   # parameters of `shutter_time` (s)


@stage
def shutter_time(lanes, p, ints, key):
    """TIME in [0, 1) becomes seconds since the shutter began to open; X, Y are raster pixels. p: OPEN_TIME … DELAY_Y.

    The inverse of the trapezoid's cumulative distribution: times are as frequent as light passes, with equal weights.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, time = row[X], row[Y], row[TIME]
    open_time, ramp, delay, delay_x, delay_y = p[OPEN_TIME], p[RAMP], p[DELAY], p[DELAY_X], p[DELAY_Y]

    # Invert the cumulative distribution: its linear part, then its parabolas
    for i in range(B):
        time[i] = time[i] * (open_time - ramp) + real(0.5) * ramp
    if ramp > real(0):
        for i in range(B):
            early = time[i] < real(0.5) * open_time
            light = (time[i] if early else open_time - time[i]) - real(0.5) * ramp  # before, or after
            edge = math.sqrt(real(2) * ramp * light)
            edge = edge if edge < ramp else light + real(0.5) * ramp
            time[i] = edge if early else open_time - edge

    # Add the delay of the line
    for i in range(B):
        time[i] += delay + x[i] * delay_x + y[i] * delay_y


def shutter_step(open_time: float, ramp: float, readout: float, direction: str, pixels_x: int, pixels_y: int) -> Step:
    """The step from TIME in [0, 1) to seconds; times in s, direction one of DIRECTIONS, pixels of the picture."""
    delay_x = {"right": 1.0, "left": -1.0}.get(direction, 0.0) * readout / pixels_x
    delay_y = {"down": 1.0, "up": -1.0}.get(direction, 0.0) * readout / pixels_y
    delay = readout if direction in ("left", "up") else 0.0
    return Step(shutter_time, np.array([open_time, ramp, delay, delay_x, delay_y]))


LUMINANCE = 1000.0              # cd/m² of radiance 1
EFFICACY = 683.0                # lm/W at 555 nm
RADIANCE = LUMINANCE / EFFICACY         # W/(m² sr) of radiance 1
METER = 12.5                    # cd s/m²: N² / t = luminance · ISO / METER
SATURATION = 78.0               # lux s, over the ISO
PHOTONS = 555e-9 / (6.62607015e-34 * 299792458.0) / EFFICACY * 1e-12   # per µm² and lux second: 4,091
GREY = 10.0 / SATURATION        # value to which a meter exposes the mean: 10 / ISO lux s
LUMA = (0.2126, 0.7152, 0.0722)
METHODS = ("mean", "highlights")
MOST_STOPS = 500        # of a change of exposure and of exposure values
CLIPPED = 0.001                 # part of the picture that clips with "highlights"


class ExposureError(ValueError):
    """An invalid exposure or sensor; the message says what to do."""


@dataclass(frozen=True)
class Exposure:
    """f-number, shutter time and ISO.

    Args:
        f_number: The working f-number, which differs from the engraved one at close focus.
        time: Shutter time (s).
        iso: Sensitivity.
    Raises:
        ExposureError: If one of them is not positive and finite.
    """

    f_number: float
    time: float
    iso: float = 100.0

    def __post_init__(self) -> None:
        for name, value in (("f-number", self.f_number), ("shutter time", self.time), ("ISO", self.iso)):
            checked_positive(name, value)

    @property
    def ev(self) -> float:
        """Exposure value log₂(N² / t), which does not depend on the ISO."""
        return 2.0 * math.log2(self.f_number) - math.log2(self.time)

    @property
    def ev100(self) -> float:
        """Exposure value at ISO 100 for the same luminance."""
        return self.ev - math.log2(self.iso / 100.0)

    @property
    def luminance(self) -> float:
        """Luminance (cd/m²) for which a meter gives this exposure."""
        return luminance(self.ev100)

    @property
    def lux_seconds(self) -> float:
        """Exposure H on the axis (lux s) for a scene of radiance 1."""
        return LUMINANCE * math.pi / (4.0 * self.f_number**2) * self.time

    @property
    def joules(self) -> float:
        """Exposure H on the axis (J/m²) for a scene of radiance 1."""
        return self.lux_seconds / EFFICACY

    @property
    def brightness(self) -> float:
        """Factor for pictures of relative weights, by which the value 1 on the axis is saturation at this ISO."""
        return self.lux_seconds * self.iso / SATURATION

    def brighter(self, stops: float, by: str = "time") -> "Exposure":
        """The exposure for pictures brighter by so many stops, which may be negative, by a change of one quantity
        alone.

        by: "time", "iso" or "f_number". ExposureError for a number beyond MOST_STOPS, or another word.
        """
        factor = 2.0 ** _checked_stops("stops", stops)
        if by == "f_number":
            return replace(self, f_number=self.f_number / math.sqrt(factor))
        if by not in ("time", "iso"):
            raise ExposureError(f"brighter by {by!r}: choose one of time, iso, f_number")
        return replace(self, **{by: getattr(self, by) * factor})

    def at_ev100(self, ev100: float, by: str = "time") -> "Exposure":
        """The exposure with another EV100, given as ev100 in stops, by a change of one quantity: `by` as for
        `brighter`.

        ExposureError as there.
        """
        _checked_stops("EV100", ev100)
        return self.brighter(self.ev100 - ev100, by)


def luminance(ev100: float) -> float:
    """Luminance of an exposure value by the meter's constant (ISO 2720).

    Args:
        ev100: Exposure value at ISO 100.
    Returns:
        cd/m².
    Raises:
        ExposureError: A number beyond MOST_STOPS.
    """
    return METER / 100.0 * 2.0 ** _checked_stops("EV100", ev100)


def ev100(luminance: float) -> float:
    """Exposure value at ISO 100 that a meter gives for a luminance (ISO 2720).

    Args:
        luminance: cd/m².
    Returns:
        log₂(N² / t).
    Raises:
        ExposureError: If the luminance is not positive and finite.
    """
    return math.log2(checked_positive("luminance", luminance) * 100.0 / METER)


def metered_stops(image: ArrayLike, method: str = "mean") -> float:
    """Stops by which to brighten a picture for a normal exposure.

    Args:
        image: (h, w, 3) array_like. Linear picture, 1 at saturation.
        method: {"mean", "highlights"}. "mean": the logarithmic mean of the luminance becomes GREY, as in a meter;
            pixels darker than the plain mean by more than 12 stops do not count. "highlights": all but a thousandth of
            the pixels stay below 1 in every channel.
    Returns:
        Stops; 0 for a black picture.
    Raises:
        ExposureError: For another method.
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


def irradiance(image: ArrayLike, open_time: float) -> np.ndarray:
    """Irradiance E of a picture of physical weights.

    Args:
        image: (h, w, 3) array_like. Linear picture.
        open_time: Effective shutter time (s).
    Returns:
        (h, w, 3) ndarray. W/m².
    Raises:
        ExposureError: If the time is not positive and finite.
    """
    return np.asarray(image) * (RADIANCE / checked_positive("open time", open_time))


def radiant_exposure(image: ArrayLike) -> np.ndarray:
    """Radiant exposure H = ∫ E dt of a picture of physical weights.

    Args:
        image: (h, w, 3) array_like. Linear picture.
    Returns:
        (h, w, 3) ndarray. J/m².
    """
    return np.asarray(image) * RADIANCE


def pixel_energy(image: ArrayLike, film: Film) -> np.ndarray:
    """Energy ∫∫ H dA that each pixel collects, for a picture of physical weights.

    Args:
        image: (h, w, 3) array_like. Linear picture.
        film: The film, whose pixels have this size.
    Returns:
        (h, w, 3) ndarray. J.
    """
    return radiant_exposure(image) * (film.pitch * 1e-3) ** 2


def _checked_stops(name: str, value: float) -> float:
    """The value; ExposureError if it is not finite, or beyond MOST_STOPS."""
    if not abs(value) <= MOST_STOPS:
        raise ExposureError(f"{name} {significant(value)}: it must be a finite number, of up to "
                            f"{MOST_STOPS} stops")
    return value


def checked_positive(name: str, value: float) -> float:
    """The value; ExposureError if it is not positive and finite."""
    if not (math.isfinite(value) and value > 0.0):
        raise ExposureError(f"{name} {significant(value)}: it must be a positive number")
    return value
