"""Pictures as arrays that a notebook shows, and how they are developed and saved."""

import io
import os
from pathlib import Path
from typing import Any

import numpy as np

from lensbench.app.bench import tone as tones
from lensbench.app.session.export import ExportError, save_picture, write_png
from lensbench.app.settings.setting_table import TONES
from lensbench.app.settings.settings import Settings

LINEAR_SUFFIXES = (".exr", ".pfm")
DEVELOPED = "raw"               # tone of values that are screen codes


class Picture(np.ndarray):
    """Picture that a notebook shows as it looks on the screen; an array like any other.

    Args:
        values: (h, w, 3) array. Red, green and blue. The picture is a view of it, not a copy.
        tone: Tone curve with which it is shown: "filmic" for linear light; "raw" for a picture that is developed. It
            stays as the attribute `tone`.
    """

    tone: str

    def __new__(cls, values: Any, tone: str = Settings.tone) -> "Picture":
        """Picture of an array, of which it takes no copy."""
        picture = np.asarray(values).view(cls)
        picture.tone = tone
        return picture

    def __array_finalize__(self, other: Any) -> None:
        self.tone = getattr(other, "tone", Settings.tone)

    def __array_wrap__(self, values, context=None, return_scalar: bool = False):
        """Results that are no pictures, such as a mean, as plain numbers and arrays."""
        if return_scalar or values.ndim == 0:
            return values[()]
        return super().__array_wrap__(values, context) if values.shape == self.shape else values.view(np.ndarray)

    @property
    def is_shown(self) -> bool:
        """Whether the array has the shape of a picture: a part of one, such as a channel, is shown as numbers."""
        return self.ndim == 3 and self.shape[2] == 3 and min(self.shape[:2]) > 0

    def _repr_png_(self) -> bytes | None:
        return png(self, 0.0, self.tone) if self.is_shown else None


def develop(image, exposure: float = 0.0, tone: str = "filmic") -> Picture:
    """Developed picture: exposure, a tone curve and sRGB, as in the window.

    Args:
        image: (h, w, 3) array. Linear light, as `render` returns it. NaN becomes black.
        exposure: Stops; +1 doubles the light.
        tone: "none", "filmic" or "agx".
    Returns:
        (h, w, 3) sRGB values in [0, 1], float64.
    Raises:
        ValueError: For an array of another shape, an exposure that is not finite or an unknown tone curve.
    """
    return Picture(_developed(checked(image), exposure, tone), DEVELOPED)


def save(image, path: str | os.PathLike[str], exposure: float = 0.0, tone: str = "filmic", bits: int = 8) -> None:
    """Write a picture to a file; an older file is replaced when the new one is complete.

    Args:
        image: (h, w, 3) array. Linear light, as `render` returns it, or what `develop` returns.
        path: ".png" and ".ppm" hold the developed picture, ".exr" and ".pfm" linear light.
        exposure: Stops; for developed pictures only.
        tone: "none", "filmic" or "agx"; for developed pictures only.
        bits: 8 or 16, of a PNG or PPM.
    Raises:
        ExportError: For another suffix or depth, errors of the disk, and a developed picture in a format of linear
            light.
        ValueError: As `develop`.
    """
    picture, path = checked(image), Path(path)
    linear = path.suffix.lower() in LINEAR_SUFFIXES
    if getattr(image, "tone", "") == DEVELOPED:
        if linear:
            raise ExportError(f"{path}: this picture is developed, and {path.suffix} holds linear light: save the "
                              "picture that was rendered")
        if exposure != 0.0:
            raise ValueError("this picture is developed: give the exposure to develop, or save the rendered picture")
        return save_picture(path, picture, _settings(0.0, DEVELOPED), bits, described=False)
    if linear and (exposure != 0.0 or tone != "filmic"):
        raise ValueError(f"{path}: linear light is written as it is, without exposure and tone curve: leave them out")
    save_picture(path, picture, _settings(exposure, tone), bits, described=False)


def png(image, exposure: float = 0.0, tone: str = "filmic") -> bytes:
    """PNG of 8 bits of a picture (h, w, 3); tone "raw" for one that is developed."""
    file, picture = io.BytesIO(), checked(image)
    write_png(file, (picture.shape[0], picture.shape[1]), [picture], _settings(exposure, tone))
    return file.getvalue()


def checked(image) -> np.ndarray:
    """The picture as a plain array of floats; ValueError where it is no picture."""
    array = np.asarray(image)
    if array.ndim != 3 or array.shape[2] != 3 or not min(array.shape):
        raise ValueError(f"an array of the shape {array.shape} is not a picture: it must be (height, width, 3)")
    if array.dtype.kind != "f":
        raise ValueError(f"a picture of {array.dtype}: it must hold linear light as floats, with 1 as white")
    return array


def _developed(image: np.ndarray, exposure: float, tone: str) -> np.ndarray:
    settings = _settings(exposure, tone)
    return tones.develop(np.nan_to_num(image, nan=0.0, posinf=1e9, neginf=0.0), settings.exposure, settings.tone)


def _settings(exposure: float, tone: str) -> Settings:
    """Settings with this exposure (stops) and tone curve; ValueError for invalid ones."""
    if tone == DEVELOPED:
        return Settings(tone=DEVELOPED)
    if tone not in TONES:
        raise ValueError(f"tone curve {tone!r}: choose one of {', '.join(TONES)}")
    return Settings(exposure=float(exposure), tone=tone).checked()
