"""From linear light to the screen: exposure, a tone curve, sRGB; and the curves' constants.

`develop` is the numpy counterpart of `shaders/develop.frag`. The shader gets the constants of this
file from `glsl_constants`, so that both draw the same curves. Every curve keeps middle grey (0.18).

filmic    the rational curve of Hable (2010), with the gain that keeps middle grey
agx       similar to Sobotka's AgX: the channels are mixed, a sigmoid in log2 joins
          black, middle grey and white, and the mixing is undone, so that very
          bright colours turn pale
"""

from math import log2

import numpy as np
from numpy.typing import NDArray

from lensbench.kernels.srgb import srgb

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


def _mixed(rgb, part: float):
    return (1.0 - part) * rgb + part * np.mean(rgb, axis=-1, keepdims=True)


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
