"""Textures of scene files: pictures beside the file or below its folder, as linear light."""

from pathlib import Path

import numpy as np

import lensbench as lb
from lensbench.app.state.tone import linear

MOST_BYTES = 64 << 20
MOST_TEXELS = 40_000_000                # of a picture as it is read
TEXTURE_SIDE = 1024                     # larger ones are averaged down to this
FORMATS = ("PNG", "JPEG", "TIFF", "WEBP", "BMP")


def read_texture(name: str, folder: Path) -> lb.Image:
    """An image file in the folder of the scene or below it, linear, at most TEXTURE_SIDE texels long; or SceneError."""
    from PIL import Image as Picture

    if Path(name).is_absolute() or "\0" in name:
        raise lb.SceneError(f"texture {name!r}: name it relative to the scene file")
    try:
        path = (folder / name).resolve(strict=True)
    except (OSError, RuntimeError) as error:
        raise lb.SceneError(f"texture {name!r}: there is no such file") from error
    if not path.is_relative_to(folder):
        raise lb.SceneError(f"texture {name!r} lies outside the folder of the scene: put it beside the file or below")
    if not path.is_file():
        raise lb.SceneError(f"texture {name!r} is not a file")
    if path.stat().st_size > MOST_BYTES:
        raise lb.SceneError(f"texture {name!r} is larger than {MOST_BYTES >> 20} MB")
    try:
        with Picture.open(path, formats=FORMATS) as picture:
            if picture.width * picture.height > MOST_TEXELS:
                raise lb.SceneError(f"texture {name!r} has more than {MOST_TEXELS // 1_000_000} million pixels")
            if picture.width < 2 or picture.height < 2:
                raise lb.SceneError(f"texture {name!r} is smaller than 2 × 2 pixels")
            if picture.mode.startswith("I"):
                values = np.asarray(picture, np.float32)[..., None].repeat(3, 2) / 65535.0
            else:
                values = np.asarray(picture.convert("RGB"), np.float32) / 255.0
    except lb.SceneError:
        raise
    except (OSError, SyntaxError, ValueError, Picture.DecompressionBombError) as error:
        raise lb.SceneError(f"texture {name!r} is not a picture that can be read ({', '.join(FORMATS)})") from error
    light = linear(values)
    shrink = TEXTURE_SIDE / max(light.shape[:2])
    if shrink < 1.0:
        size = tuple(max(2, round(side * shrink)) for side in (light.shape[1], light.shape[0]))
        bands = [Picture.fromarray(np.ascontiguousarray(light[..., c])).resize(size, Picture.Resampling.BOX)
                 for c in range(3)]
        light = np.stack([np.asarray(band) for band in bands], -1)
    return lb.Image.of(light)
