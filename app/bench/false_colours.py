"""False colours of quantities that are no light: AOVs (see `lensbench.core.rendering.aovs`), depth and confidence.

Screen, PNG and PPM show the codes, from 0 to 1, without exposure and tone curve; an EXR or PFM file holds the values
of the core. Depth runs from far to near through a map of even steps of lightness, as the reciprocal of the distance:
the steps are equal in parallax, from which the depth is estimated. Uncertain pixels are dark.
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.bench.build import bench_of
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.settings.camera_facts import LENS_MODELS
from lensbench.app.settings.settings import Settings
from lensbench.core.kernels.numeric import linear
from lensbench.core.text import significant

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
