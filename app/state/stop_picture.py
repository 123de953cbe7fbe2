"""Picture files for the stop: the part of the light that passes, as linear light."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import lensbench as lb
from lensbench.app.state.file_cache import Stamp, file_stamp, keeps_last_good
from lensbench.app.state.picture.tone import linear
from lensbench.app.state.setting import SettingsError
from lensbench.kernels.quotation import excerpt

if TYPE_CHECKING:
    from lensbench.app.state.settings import Settings

SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".webp", ".bmp")
FORMATS = ("PNG", "JPEG", "TIFF", "WEBP", "BMP")
MOST_PIXELS = 4096 * 4096               # of the file; known from its header
SHARES = np.array([0.2126, 0.7152, 0.0722])     # of red, green and blue in the luminance (Rec. 709)


def stop_picture(path: str) -> lb.StopImage:
    """The picture of a file, read once for each change of it.

    SettingsError where it cannot be read, is larger than MOST_PIXELS, or passes no light.
    """
    return _read(path, file_stamp(path))


def with_readable_stop(settings: "Settings", say: Callable[[str], object]) -> "Settings":
    """The settings without a picture in the stop that cannot be read; `say` receives a sentence on it."""
    if settings.stop_image:
        try:
            stop_picture(settings.stop_image)
        except SettingsError as error:
            say(f"{error}; the stop opens without it")
            return replace(settings, stop_image="")
    return settings


@keeps_last_good(8)
def _read(path: str, _stamp: Stamp) -> lb.StopImage:
    from PIL import Image as Picture

    say = partial("picture in the stop {}: {}".format, excerpt(Path(path).name))
    try:
        with Picture.open(path, formats=FORMATS) as picture:
            if picture.width * picture.height > MOST_PIXELS:
                raise SettingsError(say(f"more than {MOST_PIXELS // 1_000_000} million pixels: make it smaller"))
            light = transmission(picture)
    except SettingsError:
        raise
    except OSError as error:
        raise SettingsError(say(error.strerror or f"it is none that can be read ({', '.join(FORMATS)})")) from error
    except (SyntaxError, ValueError, MemoryError, Picture.DecompressionBombError) as error:
        raise SettingsError(say(f"it is none that can be read ({', '.join(FORMATS)})")) from error
    try:
        return lb.StopImage.of(light)
    except lb.StopImageError as error:
        raise SettingsError(say(str(error))) from error


def transmission(picture: Any) -> np.ndarray:
    """Luminance of a picture of PIL, linear, times its opacity: white passes all light, black and clear pass none.

    (h, w) from 0 to 1, the top row first.
    """
    if picture.mode.startswith("I"):                    # 16 bits
        return np.asarray(linear(np.clip(np.asarray(picture) / 65535.0, 0.0, 1.0)), float)
    curve = np.asarray(linear(np.arange(256) / 255.0), float)
    red, green, blue, opacity = (np.asarray(band) for band in picture.convert("RGBA").split())
    light = sum(share * curve[band] for share, band in zip(SHARES, (red, green, blue), strict=True))
    return np.minimum(light, 1.0) * (opacity / 255.0)
