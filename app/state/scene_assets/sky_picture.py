"""Pictures of the sky for scene files: Radiance .hdr and OpenEXR of all directions, or a plain picture."""

from pathlib import Path

import numpy as np

import lensbench as lb
from lensbench.app.state.scene_assets.place import asset_path
from lensbench.app.state.scene_assets.radiance_hdr import HdrError, is_hdr, read_hdr
from lensbench.app.state.scene_assets.texture import read_texture
from lensbench.kernels.quotation import excerpt

MOST_BYTES = 512 << 20
MOST_TEXELS = 8192 * 8192
EXR = b"\x76\x2f\x31\x01"
CHANNELS = (("R", "G", "B"), ("Y", "Y", "Y"))


def read_sky(name: str, folder: Path) -> lb.Image:
    """The picture of a sky in the folder of the scene or below it, linear; SceneError in one line."""
    path = asset_path(name, folder, "sky", MOST_BYTES)
    with path.open("rb") as file:
        head = file.read(16)
    if head[:4] != EXR and not is_hdr(head):
        return _checked(read_texture(name, folder), name)
    try:
        values = read_exr(path) if head[:4] == EXR else read_hdr(path, MOST_TEXELS)
    except HdrError as error:
        raise lb.SceneError(f"sky {excerpt(name)} cannot be read: {error}") from error
    except (OSError, MemoryError) as error:
        raise lb.SceneError(f"sky {excerpt(name)} cannot be read") from error
    if not (np.isfinite(values).all() and values.min(initial=0.0) >= 0.0):
        raise lb.SceneError(f"sky {excerpt(name)} has pixels that are negative or not finite")
    if min(values.shape[:2]) < 2:
        raise lb.SceneError(f"sky {excerpt(name)} is smaller than 2 × 2 pixels")
    return _checked(lb.Image.of(values), name)


def _checked(image: lb.Image, name: str) -> lb.Image:
    if not 1.5 <= image.width / image.height <= 2.5:
        raise lb.SceneError(f"sky {excerpt(name)} of {image.width} × {image.height} pixels is no picture of all "
                            "directions: it must be twice as wide as high")
    return image


def read_exr(path: Path, channels: tuple[tuple[str, ...], ...] = CHANNELS) -> np.ndarray:
    """The first of these sets of channels that an OpenEXR file has, (h, w, n), float32; HdrError where it has none."""
    import OpenEXR

    try:
        with OpenEXR.File(str(path), header_only=True) as file:         # before its pixels take memory
            low, high = (np.asarray(corner, np.int64) for corner in file.header()["dataWindow"])
        if np.prod(high - low + 1) > MOST_TEXELS:
            raise HdrError(f"it has more than {MOST_TEXELS // 1_000_000} million pixels")
        with OpenEXR.File(str(path), separate_channels=True) as file:
            found = {key: np.asarray(channel.pixels) for key, channel in file.channels().items()}
    except HdrError:
        raise
    except Exception as error:      # the library raises its own kinds and Python's
        raise HdrError("it is no whole OpenEXR file") from error
    for names in channels:
        if all(key in found for key in names):
            parts = [found[key] for key in names]
            if len({part.shape for part in parts}) > 1 or parts[0].ndim != 2:
                raise HdrError("its channels differ in size")
            return np.stack(parts, -1).astype(np.float32)
    sets = [", ".join(dict.fromkeys(names)) for names in channels]
    raise HdrError(f"it has neither channels {' nor '.join(sets)}")
