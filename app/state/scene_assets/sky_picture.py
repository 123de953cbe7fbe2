"""Pictures of the sky for scene files: Radiance .hdr and OpenEXR of all directions, or a plain picture."""

from io import BytesIO
from pathlib import Path

import numpy as np

import lensbench as lb
from lensbench.app.state.scene_assets.place import asset_path
from lensbench.app.state.scene_assets.radiance_hdr import HdrError, is_hdr, read_hdr
from lensbench.app.state.scene_assets.table_values import Say
from lensbench.app.state.scene_assets.texture import BAND, MOST_BYTES, TEXTURE_TEXELS, read_texture
from lensbench.kernels.figures import significant
from lensbench.kernels.quotation import excerpt
from lensbench.lenses.picture_file import MOST_PIXELS
from lensbench.lenses.regular_file import open_regular

MOST_SAMPLES = 4 * TEXTURE_TEXELS       # numbers in an OpenEXR file: red, green, blue, alpha of the largest sky
EXR = b"\x76\x2f\x31\x01"
CHANNELS = (("R", "G", "B"), ("Y", "Y", "Y"))


def read_sky(name: str, folder: Path, say: Say) -> lb.Image:
    """The picture of a sky in the folder of the scene or below it, linear; SceneError in one line.

    Pixels that are negative (a filter or a lossy compression rings there) or not finite are replaced, and `say`
    receives how many.
    """
    path = asset_path(name, folder, "sky", MOST_BYTES)
    try:
        with open_regular(path) as file:
            head = file.read(16)
        if head[:4] != EXR and not is_hdr(head):
            return _checked(read_texture(name, folder), name)
        parts = list(read_exr(path) if head[:4] == EXR else np.moveaxis(read_hdr(path, TEXTURE_TEXELS), -1, 0))
    except HdrError as error:
        raise lb.SceneError(f"sky {excerpt(name)} cannot be read: {error}") from error
    except (OSError, MemoryError) as error:
        raise lb.SceneError(f"sky {excerpt(name)} cannot be read: {getattr(error, 'strerror', None) or error}"
                            ) from error
    height, width = parts[0].shape
    if min(height, width) < 2:
        raise lb.SceneError(f"sky {excerpt(name)} is smaller than 2 × 2 pixels")
    if height * width > TEXTURE_TEXELS:
        raise lb.SceneError(f"sky {excerpt(name)} has {width} × {height} pixels: make it at most 8192 × 4096")
    return _checked(lb.Image(width, height, _light(parts, name, say)), name)


def _light(parts: list[np.ndarray], name: str, say: Say) -> bytes:
    """The radiance of three channels (h, w), interleaved, float32, none negative and all finite."""
    most = max(float(part.max(where=np.isfinite(part), initial=0.0)) for part in parts)
    if not most > 0.0:
        raise lb.SceneError(f"sky {excerpt(name)} has no pixel that is positive and finite")
    data, negative, endless = BytesIO(), 0, 0       # the bytes are given without a copy
    rows, columns = parts[0].shape
    for first in range(0, rows, BAND):
        band = np.stack([part[first:first + BAND] for part in parts], -1).astype(np.float32)
        negative += int((np.isfinite(band) & (band < 0.0)).any(-1).sum())
        endless += int((~np.isfinite(band)).any(-1).sum())
        data.write(np.clip(np.nan_to_num(band, nan=0.0, posinf=most, neginf=0.0), 0.0, most).data)
    for count, what in ((negative, "negative and count as 0"),
                        (endless, "not finite and count as 0, or, if infinite, as the brightest of the others")):
        if count:
            say(f"sky {excerpt(name)}: {count} pixels ({significant(100.0 * count / (rows * columns), 2)} %) are "
                f"{what}")
    return data.getvalue()


def _checked(image: lb.Image, name: str) -> lb.Image:
    if not 1.5 <= image.width / image.height <= 2.5:
        raise lb.SceneError(f"sky {excerpt(name)} of {image.width} × {image.height} pixels is no picture of all "
                            "directions: it must be twice as wide as high")
    return image


def read_exr(path: Path, channels: tuple[tuple[str, ...], ...] = CHANNELS) -> tuple[np.ndarray, ...]:
    """The first of these sets of channels that an OpenEXR file has, each (h, w); HdrError where it has none.

    All channels of a file are decoded together, so that their sizes are bounded together.
    """
    import OpenEXR

    try:
        with OpenEXR.File(str(path), header_only=True) as file:         # before its pixels take memory
            samples, most = 0, 0
            for part in file.parts:
                low, high = (np.asarray(corner, np.int64) for corner in part.header["dataWindow"])
                most = max(most, int(np.prod(high - low + 1)))
                samples += int(np.prod(high - low + 1)) * len(part.header["channels"])
        if most > MOST_PIXELS:
            raise HdrError(f"it has more than {MOST_PIXELS // 1_000_000} million pixels")
        if samples > MOST_SAMPLES:
            raise HdrError(f"its channels hold {samples // 1_000_000} million numbers: at most "
                           f"{MOST_SAMPLES // 1_000_000} million are read; make it smaller, or leave channels out")
        with OpenEXR.File(str(path), separate_channels=True) as file:
            found = {key: np.asarray(channel.pixels) for key, channel in file.channels().items()}
    except HdrError:
        raise
    except Exception as error:      # the library raises its own kinds and Python's
        raise HdrError("it is no whole OpenEXR file") from error
    for names in channels:
        if all(key in found for key in names):
            parts = tuple(found[key] for key in names)
            if len({part.shape for part in parts}) > 1 or parts[0].ndim != 2:
                raise HdrError("its channels differ in size")
            return parts
    sets = [", ".join(dict.fromkeys(names)) for names in channels]
    raise HdrError(f"it has the channels {excerpt(', '.join(found))}, and neither {' nor '.join(sets)}: rename them")
