"""Depth as colours: from far to near through a map of even steps of lightness, as the reciprocal of the distance.

The steps are equal in parallax, from which the depth is estimated. Uncertain pixels are dark.
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.state.settings import Settings

# Viridis by S. van der Walt and N. Smith, in the public domain (CC0): ten of its colours, read straight between them
MAP = np.array([[int(code[i:i + 2], 16) / 255.0 for i in (0, 2, 4)] for code in (
    "440154", "482878", "3e4989", "31688e", "26828e", "1f9e89", "35b779", "6ece58", "b5de2b", "fde725")])
ENDS = (0.01, 0.99)             # quantiles of the certain pixels, at the ends of the colour map
SURE = 0.5                      # a confidence that needs no shade
SHADE = 0.3                     # factor of a colour of confidence 0


def colour(part: NDArray[np.floating]) -> NDArray[np.float32]:
    """Screen colours (…, 3) for parts from 0 (far) to 1 (near)."""
    at = np.clip(part, 0.0, 1.0) * (len(MAP) - 1)
    return np.stack([np.interp(at, np.arange(len(MAP)), MAP[:, i]) for i in range(3)], -1).astype(np.float32)


def ends(depth: lb.Depth) -> tuple[float, float]:
    """Farthest and nearest distance (mm) of the colours' ends."""
    near_by = 1.0 / depth.distance.astype(np.float64)
    sure = near_by[depth.confidence > SURE]
    low, high = np.quantile(sure if sure.size else near_by, ENDS)
    low, high = (low, high) if high > low else (0.5 * low, 2.0 * low or 1e-3)
    return (1.0 / float(low) if low > 0.0 else math.inf), 1.0 / float(high)


def depth_codes(depth: lb.Depth) -> NDArray[np.float32]:
    """(h, w, 3) codes of the screen: the distance as a colour, the darker the less it is sure."""
    far, near = (1.0 / end for end in ends(depth))
    shade = SHADE + (1.0 - SHADE) * np.minimum(depth.confidence / SURE, 1.0)
    return colour((1.0 / depth.distance - far) / (near - far)) * shade[..., None].astype(np.float32)


def confidence_codes(depth: lb.Depth) -> NDArray[np.float32]:
    """(h, w, 3) codes of the screen: black where any distance would do, white where no other would."""
    return np.repeat(depth.confidence[..., None], 3, -1)


def with_codes(settings: Settings) -> Settings:
    """Settings by which the light of codes is saved as these very codes."""
    return replace(settings.plain("exposing", "noise", "exposure"), tone="none")


def light_of(codes: NDArray[np.floating]) -> NDArray[np.float32]:
    """The linear light that, without tone and exposure, is shown as these codes."""
    from lensbench.app.state.tone import linear

    return linear(np.asarray(codes, np.float64)).astype(np.float32)


def depth_picture(depth: lb.Depth, path: Path) -> NDArray[np.float32]:
    """Picture of a depth for a file: colours, or, for .exr and .pfm, the distance in m in all three channels."""
    if path.suffix.lower() in (".exr", ".pfm"):
        return np.repeat(depth.distance[..., None] / np.float32(1000.0), 3, -1)
    return light_of(depth_codes(depth))
