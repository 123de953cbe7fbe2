"""Pictures of the sky for scene files: Radiance .hdr and OpenEXR of all directions, or a plain picture.

Radiance (.hdr, .pic) has three mantissas and a common exponent, 8 bits each. A text header ends with an empty line;
then "-Y height +X width", and rows of pixels. A row begins with 2, 2 and its length in two bytes, and holds the four
components one after the other in runs; or it is plain (G. Ward, "Real pixels", Graphics Gems II, 1991).
"""

import re
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

import lensbench as lb
from lensbench.app.scenes.asset_files import BAND, MOST_BYTES, TEXTURE_TEXELS, Textures, asset_path, image_of
from lensbench.app.scenes.table_values import Say
from lensbench.core.kernels.cache import njit
from lensbench.core.text import excerpt, significant
from lensbench.lenses.file_error import open_regular
from lensbench.lenses.picture_file import MOST_PIXELS, PictureFileError, read_picture_file

LONGEST_HEADER = 1 << 16


class HdrError(ValueError):
    """A file that is no complete picture of this format; the message says why, and names no file."""


def is_hdr(head: bytes) -> bool:
    """Whether a file that begins with these bytes claims this format."""
    return head.startswith((b"#?RADIANCE", b"#?RGBE"))


def read_hdr(path: Path, most_texels: int) -> np.ndarray:
    """Linear RGB (height, width, 3), float32, from the top; HdrError if damaged, too large or in another order."""
    with open_regular(path) as file:
        data = file.read()
    if not is_hdr(data):
        raise HdrError("it does not begin with #?RADIANCE")
    end = data.find(b"\n\n", 0, LONGEST_HEADER)
    size = re.compile(rb"([-+][XY]) (\d{1,6}) ([-+][XY]) (\d{1,6})\n").match(data, end + 2) if end >= 0 else None
    if size is None:
        raise HdrError("its header has no size")
    if b"FORMAT=32-bit_rle_xyze" in data[:end]:
        raise HdrError("its colours are XYZ: write it as RGBE")
    if (size[1], size[3]) != (b"-Y", b"+X"):
        raise HdrError("its rows do not run from the top left: write it in the order -Y +X")
    height, width = int(size[2]), int(size[4])
    if height * width > most_texels:
        raise HdrError(f"it has more than {most_texels // 1_000_000} million pixels")
    pixels = np.empty((height, width, 4), np.uint8)
    if not _decode(np.frombuffer(data, np.uint8, offset=size.end()), pixels):
        raise HdrError("it breaks off or is damaged")
    del data
    light = np.empty((height, width, 3), np.float32)
    for row, colours in zip(pixels, light, strict=True):
        scale = np.ldexp(np.float32(1.0), row[:, 3:].astype(np.int32) - 136)
        colours[:] = np.where(row[:, 3:] > 0, (row[:, :3] + np.float32(0.5)) * scale, np.float32(0.0))
    return light


@njit(nogil=True, cache=True)
def _decode(data, pixels):
    """Fill pixels (h, w, 4); False if the data break off or contradict themselves."""
    height, width = pixels.shape[0], pixels.shape[1]
    position: Any = 0
    for y in range(height):
        if position + 4 > data.size:
            return False
        coded = data[position] == 2 and data[position + 1] == 2 and data[position + 2] < 128 and 8 <= width < 32768
        if not coded:
            if position + 4 * width > data.size:
                return False
            for x in range(width):
                for c in range(4):
                    pixels[y, x, c] = data[position + 4 * x + c]
                if pixels[y, x, 0] == 1 and pixels[y, x, 1] == 1 and pixels[y, x, 2] == 1:
                    return False                        # a run of the oldest form of the format
            position += 4 * width
            continue
        if (np.int64(data[position + 2]) << 8) + data[position + 3] != width:
            return False
        position += 4
        for c in range(4):
            column: Any = 0
            while column < width:
                if position >= data.size:
                    return False
                count: Any = np.int64(data[position])
                run = count > 128
                count = count - 128 if run else count
                need: Any = 2 if run else 1 + count
                if count == 0 or column + count > width or position + need > data.size:
                    return False
                for k in range(count):
                    pixels[y, column + k, c] = data[position + 1] if run else data[position + 1 + k]
                column, position = column + count, position + need
    return True


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
            return _checked(Textures(folder).read(name), name)
        channels = list(read_exr(path) if head[:4] == EXR else np.moveaxis(read_hdr(path, TEXTURE_TEXELS), -1, 0))
    except HdrError as error:
        raise lb.SceneError(f"sky {excerpt(name)} cannot be read: {error}") from error
    except (OSError, MemoryError) as error:
        raise lb.SceneError(f"sky {excerpt(name)} cannot be read: {getattr(error, 'strerror', None) or error}"
                            ) from error
    height, width = channels[0].shape
    if min(height, width) < 2:
        raise lb.SceneError(f"sky {excerpt(name)} is smaller than 2 × 2 pixels")
    if height * width > TEXTURE_TEXELS:
        raise lb.SceneError(f"sky {excerpt(name)} has {width} × {height} pixels: make it at most 8192 × 4096")
    return _checked(lb.Image(width, height, _light(channels, name, say)), name)


def read_texture(name: str, textures: Textures) -> lb.Image:
    """A texture of a scene, linear: OpenEXR, or a picture as `Textures` reads it; SceneError in one line."""
    def decoded(path: Path) -> lb.Image:
        try:
            with open_regular(path) as file:
                is_exr = file.read(4) == EXR
        except OSError as error:
            raise PictureFileError(error.strerror or str(error)) from error
        if not is_exr:
            return image_of(read_picture_file(path))
        try:
            light = np.stack(read_exr(path), -1).astype(np.float32)
        except (HdrError, MemoryError) as error:
            raise PictureFileError(str(error) or "it does not fit into memory") from error
        if not (np.isfinite(light).all() and light.min() >= 0.0):
            raise PictureFileError("it has pixels that are negative or not finite")
        return lb.Image.of(light)

    return textures.read(name, decoded)


def _light(channels: list[np.ndarray], name: str, say: Say) -> bytes:
    """The radiance of three channels (h, w), interleaved, float32, none negative and all finite."""
    most = max(float(channel.max(where=np.isfinite(channel), initial=0.0)) for channel in channels)
    if not most > 0.0:
        raise lb.SceneError(f"sky {excerpt(name)} has no pixel that is positive and finite")
    data, negative, endless = BytesIO(), 0, 0       # the bytes are given without a copy
    rows, columns = channels[0].shape
    for first in range(0, rows, BAND):
        band = np.stack([channel[first:first + BAND] for channel in channels], -1).astype(np.float32)
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
    """The first of these sets of channels that a file has, each (h, w), decoded together; HdrError without one."""
    import OpenEXR

    try:
        with OpenEXR.File(str(path), header_only=True) as file:         # before its pixels take memory
            samples, most = 0, 0
            for part_of_file in file.parts:
                low, high = (np.asarray(corner, np.int64) for corner in part_of_file.header["dataWindow"])
                most = max(most, int(np.prod(high - low + 1)))
                samples += int(np.prod(high - low + 1)) * len(part_of_file.header["channels"])
        if most > MOST_PIXELS:
            raise HdrError(f"it has more than {MOST_PIXELS // 1_000_000} million pixels")
        if samples > MOST_SAMPLES:
            raise HdrError(f"its channels hold {samples // 1_000_000} million numbers: at most "
                           f"{MOST_SAMPLES // 1_000_000} million are read; make it smaller, or leave channels out")
        with OpenEXR.File(str(path), separate_channels=True) as file:
            pixels = {key: np.asarray(channel.pixels) for key, channel in file.channels().items()}
    except HdrError:
        raise
    except Exception as error:      # the library raises its own kinds and Python's
        raise HdrError("it is not a complete OpenEXR file") from error
    for names in channels:
        if all(key in pixels for key in names):
            arrays = tuple(pixels[key] for key in names)
            if len({part_of_file.shape for part_of_file in arrays}) > 1 or arrays[0].ndim != 2:
                raise HdrError("its channels differ in size")
            return arrays
    sets = [", ".join(dict.fromkeys(names)) for names in channels]
    raise HdrError(f"it has the channels {excerpt(', '.join(pixels))}, and neither {' nor '.join(sets)}: rename them")


def write_exr(path: Path, image: lb.Image) -> None:
    """Write an image as OpenEXR of 32 bits."""
    import OpenEXR

    channels = {name: image.values[..., k].copy() for k, name in enumerate("RGB")}
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, channels).write(str(path))
