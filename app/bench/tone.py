"""From linear light to the screen: exposure, a tone curve, sRGB; and statistics of pictures.

`develop` is the numpy counterpart of `shaders/develop.frag`. The shader gets the constants of this
file from `glsl_constants`, so that both draw the same curves. Every curve keeps middle grey (0.18).

filmic    the rational curve of Hable (2010), with the gain that keeps middle grey
agx       similar to Sobotka's AgX: the channels are mixed, a sigmoid in log2 joins
          black, middle grey and white, and the mixing is undone, so that very
          bright colours turn pale
"""

import math
from dataclasses import dataclass
from math import log2

import numpy as np
from numpy.typing import NDArray

from lensbench.core.kernels.numeric import srgb

GREY = 0.18

# --- filmic: f(x) = (x (A x + C B) + D E) / (x (A x + B) + D F) − E / F
A, B, C, D, E, F = 0.15, 0.50, 0.10, 0.20, 0.02, 0.30
WHITE = 11.2                                    # light that the curve maps to 1, before the gain

# --- agx: stops around middle grey, exponent and slope of the sigmoid, and share of the channels' mean
STOPS_BELOW, STOPS_ABOVE = 10.0, 6.5
POWER, SLOPE = 1.5, 2.4
DISPLAY_GAMMA = 2.2
INSET = 0.12


def _hable(x):
    return (x * (A * x + C * B) + D * E) / (x * (A * x + B) + D * F) - E / F


def _filmic_gain() -> float:
    """The gain g with _hable(0.18 g) = 0.18 _hable(WHITE): the positive root of a quadratic."""
    y = GREY * _hable(WHITE) + E / F
    a, b, c = A * (1.0 - y), B * (C - y), D * (E - y * F)
    return float((-b + np.sqrt(b * b - 4.0 * a * c)) / (2.0 * a)) / GREY


GAIN = _filmic_gain()
PIVOT_IN = STOPS_BELOW / (STOPS_BELOW + STOPS_ABOVE)
PIVOT_OUT = GREY ** (1.0 / DISPLAY_GAMMA)


def _reach(length: float, height: float) -> float:
    """The scale of a sigmoid of this slope that reaches `height` after `length`."""
    return float((height ** -POWER - (SLOPE * length) ** -POWER) ** (-1.0 / POWER))


TOE = _reach(PIVOT_IN, PIVOT_OUT)
SHOULDER = _reach(1.0 - PIVOT_IN, 1.0 - PIVOT_OUT)


# Stops from 1, where a sensor saturates, to the light that the curve maps to white
HEADROOM = {"none": 0.0, "filmic": log2(WHITE / GAIN), "agx": STOPS_ABOVE + log2(GREY), "raw": 0.0}


def glsl_constants() -> str:
    """The constants above as GLSL, for the shader that develops the picture."""
    names = ("GREY", "A", "B", "C", "D", "E", "F", "WHITE", "GAIN", "STOPS_BELOW", "STOPS_ABOVE", "POWER", "SLOPE",
             "DISPLAY_GAMMA", "INSET", "PIVOT_IN", "PIVOT_OUT", "TOE", "SHOULDER")
    return "".join(f"const float {name} = {float(globals()[name])!r};\n" for name in names)


def _sigmoid(t):
    """Display value before the gamma, at a position from 0 to 1 in the range of stops."""
    scale = np.where(t < PIVOT_IN, TOE, SHOULDER)
    x = SLOPE * np.abs(t - PIVOT_IN) / scale
    return PIVOT_OUT + np.sign(t - PIVOT_IN) * scale * x / (1.0 + x ** POWER) ** (1.0 / POWER)


def _mixed(rgb, share: float):
    return (1.0 - share) * rgb + share * np.mean(rgb, axis=-1, keepdims=True)


def _agx(rgb):
    stops = np.log2(np.maximum(_mixed(rgb, INSET), 1e-10)) - log2(GREY)
    t = np.clip((stops + STOPS_BELOW) / (STOPS_BELOW + STOPS_ABOVE), 0.0, 1.0)
    return _mixed(np.maximum(_sigmoid(t), 0.0) ** DISPLAY_GAMMA, -INSET / (1.0 - INSET))


def develop(image: NDArray[np.floating], exposure: float, tone: str, sensor: bool = False) -> NDArray[np.float64]:
    """A linear picture (..., 3) as sRGB values in [0, 1]; exposure in stops, tone a key of settings.TONES.

    The tone "raw" is for values that are already screen codes. sensor: the picture is that of a sensor that saturates
    at 1: values above middle grey are brightened so that 1 becomes white.
    """
    if tone == "raw":
        return np.clip(np.asarray(image, np.float64), 0.0, 1.0)
    rgb = np.maximum(np.asarray(image, np.float64), 0.0)
    if sensor:
        rgb = rgb * 2.0 ** (HEADROOM[tone] * np.clip((rgb - GREY) / (1.0 - GREY), 0.0, 1.0) ** 3)
    rgb = rgb * 2.0 ** exposure
    rgb = np.minimum(rgb, 1e9)
    if tone == "filmic":
        rgb = _hable(GAIN * np.minimum(rgb, WHITE / GAIN)) / _hable(WHITE)
    elif tone == "agx":
        rgb = _agx(rgb)
    return srgb(np.clip(rgb, 0.0, 1.0))


BINS = 64
TONES_SAMPLED = 20_000          # pixels of a histogram: its shape needs no more, and a frame has no time for all
SHARE = 0.98                    # of the differences that lie below the end of their scale
DIFFERENCES_SAMPLED = 40_000    # pixels from which that scale is found


def histogram(image: NDArray[np.float32], exposure: float, curve: str, sensor: bool = False) -> NDArray[np.float64]:
    """Shares (4, BINS) of the pixels of a linear picture (h, w, 3): red, green, blue and luminance; see `tone.develop`.

    Each row is divided by its greatest inner bin, so that a clipped end does not flatten the rest; at most 1.
    """
    stride = max(1, int(np.sqrt(image.shape[0] * image.shape[1] / TONES_SAMPLED)))
    sampled = np.nan_to_num(image[stride // 2::stride, stride // 2::stride].reshape(-1, 3), nan=0.0, posinf=1e9)
    shown = develop(sampled, exposure, curve, sensor)
    channels = [*shown.T, shown @ (0.2126, 0.7152, 0.0722)]
    counts = np.array([np.histogram(channel, BINS, (0.0, 1.0))[0] for channel in channels], np.float64)
    top = np.maximum(counts[:, 1:-1].max(), 1.0)
    return np.minimum(counts / top, 1.0)


@dataclass(frozen=True)
class Difference:
    """B − A over all pixels and channels: root mean square, greatest amount, and the amount to be shown as white."""

    rms: float
    largest: float
    scale: float

    @classmethod
    def of(cls, a: NDArray[np.float32], b: NDArray[np.float32]) -> "Difference":
        """Difference of two linear pictures (h, w, 3) of equal size; it is 0 where either is not finite."""
        apart = np.abs(np.nan_to_num(b.astype(np.float32) - a, nan=0.0, posinf=0.0, neginf=0.0))
        stride = max(1, int(math.sqrt(apart.shape[0] * apart.shape[1] / DIFFERENCES_SAMPLED)))
        most = float(np.quantile(apart[::stride, ::stride], SHARE))
        largest = float(apart.max())
        return cls(float(np.sqrt(np.mean(np.square(apart, dtype=np.float64)))), largest,
                   round_above(most or largest or 1.0))


def decibels(a: NDArray[np.float32], b: NDArray[np.float32]) -> float:
    """Peak signal to noise of two linear pictures of one size, clipped to [0, 1], peak 1; infinite where equal."""
    error = float(np.mean(np.square(np.clip(a, 0.0, 1.0) - np.clip(b, 0.0, 1.0), dtype=np.float64)))
    return -10.0 * math.log10(error) if error else math.inf


def round_above(value: float, slack: float = 1e-12) -> float:
    """The least of 1, 2, 5 · 10ⁿ that is not below a positive value by more than this share of it."""
    decade = 10.0 ** math.floor(math.log10(value))
    return next(step * decade for step in (1.0, 2.0, 5.0, 10.0) if step * decade >= value * (1.0 - slack))
