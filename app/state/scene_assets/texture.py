"""Textures of scene files: pictures beside the file or below its folder, as linear light."""

from pathlib import Path
from typing import Any

import numpy as np

import lensbench as lb
from lensbench.app.state.scene_assets.place import asset_path
from lensbench.kernels.quotation import excerpt
from lensbench.kernels.srgb import linear

MOST_BYTES = 512 << 20
MOST_TEXELS = 8192 * 8192               # of a picture as it is read
TEXTURE_SIDE = 8192                     # larger ones are averaged down to this
BAND = 64                               # rows that are made linear at once
FORMATS = ("PNG", "JPEG", "TIFF", "WEBP", "BMP")


def read_texture(name: str, folder: Path) -> lb.Image:
    """An image file in the folder of the scene or below it, linear, at most TEXTURE_SIDE texels long; or SceneError."""
    from PIL import Image as Picture

    path = asset_path(name, folder, "texture", MOST_BYTES)
    try:
        with Picture.open(path, formats=FORMATS) as picture:
            if picture.width * picture.height > MOST_TEXELS:
                raise lb.SceneError(f"texture {excerpt(name)} has more than {MOST_TEXELS // 1_000_000} million pixels")
            if picture.width < 2 or picture.height < 2:
                raise lb.SceneError(f"texture {excerpt(name)} is smaller than 2 × 2 pixels")
            return image_of(picture)
    except lb.SceneError:
        raise
    except (OSError, SyntaxError, ValueError, MemoryError, Picture.DecompressionBombError) as error:
        raise lb.SceneError(f"texture {excerpt(name)} is not a picture that can be read "
                            f"({', '.join(FORMATS)})") from error


def image_of(picture: Any) -> lb.Image:
    """A picture of PIL, linear, at most TEXTURE_SIDE texels long."""
    from PIL import Image as Picture

    side = max(picture.size)
    if picture.mode.startswith("I"):
        levels = np.asarray(picture)[..., None]
        deepest = 65535.0
    else:
        levels = np.asarray(picture.convert("RGB"))
        deepest = 255.0
    shrink = min(TEXTURE_SIDE / side, 1.0)
    size = tuple(max(2, round(length * shrink)) for length in levels.shape[1::-1])
    # One colour after another: of 67 million pixels each takes 270 MB as floats
    colours = np.empty((size[1], size[0], 3), np.float32)
    for c in range(3):
        light = _linear(levels[..., min(c, levels.shape[2] - 1)], deepest)
        if size != levels.shape[1::-1]:
            light = np.asarray(Picture.fromarray(light).resize(size, Picture.Resampling.BOX))
        colours[..., c] = light
    return lb.Image.of(colours)


def _linear(levels: np.ndarray, deepest: float) -> np.ndarray:
    """Linear light (h, w) in float32 of the levels of a picture, band by band."""
    light = np.empty(levels.shape, np.float32)
    for first in range(0, len(levels), BAND):
        light[first:first + BAND] = linear(np.clip(levels[first:first + BAND] / np.float32(deepest), 0.0, 1.0))
    return light
