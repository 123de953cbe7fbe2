"""From linear light to the screen: exposure, a tone curve, sRGB; statistics of pictures; and false colours.

`develop` is the numpy counterpart of `shaders/develop.frag`. The shader gets the constants of this
file from `glsl_constants`, so that both draw the same curves. Every curve keeps middle grey (0.18).

filmic    the rational curve of Hable (2010), with the gain that keeps middle grey
agx       similar to Sobotka's AgX: the channels are mixed, a sigmoid in log2 joins
          black, middle grey and white, and the mixing is undone, so that very
          bright colours turn pale

False colours show quantities that are no light: AOVs (see `lensbench.core.rendering.aovs`), depth and confidence.
Screen, PNG and PPM show the codes, from 0 to 1, without exposure and tone curve; an EXR or PFM file holds the values of
the core. Depth runs from far to near through a map of even steps of lightness, as the reciprocal of the distance: the
steps are equal in parallax, from which the depth is estimated. Uncertain pixels are dark.
"""

import math
from dataclasses import dataclass, replace
from math import log2
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.bench.build import bench_of
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.settings.camera_facts import LENS_MODELS
from lensbench.app.settings.settings import Settings
from lensbench.core.kernels.numeric import linear, srgb
from lensbench.core.text import significant

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


# False colours

NOTES = {
    "direction": "(d + 1) / 2 of the ray's direction in the world: right is red, up green, backwards blue",
    "origin": "Where the ray leaves the lens: right is red, up green; blue along the axis, one lens radius for ½",
    "time": "When the sample was taken: black at the opening of the shutter, white at its closing",
    "depth": "Nearness: white at {near} m, ½ at twice that, black for the sky",
    "weight": "Weight of the samples: white for the unvignetted axis",
    "fate": "Rays from all over the rear opening: white where they arrive, coloured by the surface that blocks them",
}

# Viridis by S. van der Walt and N. Smith, in the public domain (CC0): ten of its colours, read straight between them
MAP = np.array([[int(code[i:i + 2], 16) / 255.0 for i in (0, 2, 4)] for code in (
    "440154", "482878", "3e4989", "31688e", "26828e", "1f9e89", "35b779", "6ece58", "b5de2b", "fde725")])
ENDS = (0.01, 0.99)             # quantiles of the certain pixels, at the ends of the colour map
SURE = 0.5                      # the confidence from which on a colour is not darkened
SHADE = 0.3                     # factor of a colour of confidence 0


def aov_codes(image: NDArray[np.float32], settings: Settings) -> NDArray[np.float32]:
    """An AOV (h, w, 3) as codes in [0, 1]; nan becomes 0."""
    image = np.nan_to_num(image, nan=0.0, posinf=0.0, neginf=0.0)
    if settings.view == "origin":
        front_z, radius = _front(settings)
        image = (image - np.array([0.0, 0.0, front_z], np.float32)) / (2.0 * radius) + 0.5
    elif settings.view == "depth":
        image = image * (nearest(settings) / 1000.0)
    return np.clip(image, 0.0, 1.0)


def nearest(settings: Settings) -> float:
    """The distance (mm) that the AOV “depth” shows as white."""
    return cached_scene(settings.scene).depth_range[0]


def aov_note(settings: Settings) -> str:
    """The meaning of the colours of the AOV."""
    near = nearest(settings) / 1000.0 if settings.view == "depth" else 0.0
    return NOTES[settings.view].format(near=significant(near, 2))


def _front(settings: Settings) -> tuple[float, float]:
    """Where rays leave the camera along its z (mm), and the radius (mm) of the opening there."""
    rays_from = LENS_MODELS[settings.lens_model].rays_from if settings.has_lens else ""
    if not rays_from:
        return 0.0, 1.0
    lens_setup = bench_of(settings)
    if rays_from == "front":
        return -lens_setup.film_z, lens_setup.lens.surfaces[0].semi_diameter
    return lens_setup.first_order.entrance_pupil.z - lens_setup.film_z, lens_setup.first_order.entrance_pupil.radius


def colour(shares: NDArray[np.floating]) -> NDArray[np.float32]:
    """Screen colours (…, 3) for parts from 0 (far) to 1 (near)."""
    positions = np.clip(shares, 0.0, 1.0) * (len(MAP) - 1)
    return np.stack([np.interp(positions, np.arange(len(MAP)), MAP[:, i]) for i in range(3)], -1).astype(np.float32)


def ends(depth: lb.Depth) -> tuple[float, float]:
    """Farthest and nearest distance (mm) of the colours' ends."""
    near_by = 1.0 / depth.distance.astype(np.float64)
    sure = near_by[depth.confidence > SURE]
    low, high = np.quantile(sure if sure.size else near_by, ENDS)
    low, high = (low, high) if high > low else (0.5 * low, 2.0 * low or 1e-3)
    return (1.0 / float(low) if low > 0.0 else math.inf), 1.0 / float(high)


def depth_codes(depth: lb.Depth) -> NDArray[np.float32]:
    """(h, w, 3) codes of the screen: the distance as a colour, darker where it is less certain."""
    far, near = (1.0 / end for end in ends(depth))
    shade = SHADE + (1.0 - SHADE) * np.minimum(depth.confidence / SURE, 1.0)
    return colour((1.0 / depth.distance - far) / (near - far)) * shade[..., None].astype(np.float32)


def confidence_codes(depth: lb.Depth) -> NDArray[np.float32]:
    """(h, w, 3) codes of the screen: black where any distance is possible, white for a certain one."""
    return np.repeat(depth.confidence[..., None], 3, -1)


def with_codes(settings: Settings) -> Settings:
    """Settings that save light as it is, without exposure and tone curve, so that codes stay the same."""
    return replace(settings.plain("exposing", "noise", "exposure"), tone="none")


def light_of(codes: NDArray[np.floating]) -> NDArray[np.float32]:
    """The linear light that, without tone and exposure, is shown as these codes."""
    return linear(np.asarray(codes, np.float64)).astype(np.float32)


def depth_picture(depth: lb.Depth, path: Path) -> NDArray[np.float32]:
    """Picture of a depth for a file: colours, or, for .exr and .pfm, the distance in m in all three channels."""
    if path.suffix.lower() in (".exr", ".pfm"):
        return np.repeat(depth.distance[..., None] / np.float32(1000.0), 3, -1)
    return light_of(depth_codes(depth))
