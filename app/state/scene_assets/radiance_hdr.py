"""Pictures in the format of Radiance (.hdr, .pic): three mantissas and a common exponent, 8 bits each.

A text header ends with an empty line; then "-Y height +X width", and rows of pixels. A row begins with 2, 2 and its
length in two bytes, and holds the four components one after the other in runs; or it is plain (G. Ward, "Real
pixels", Graphics Gems II, 1991).
"""

import re
from pathlib import Path
from typing import Any

import numpy as np

from lensbench.kernels.cache import njit
from lensbench.lenses.regular_file import open_regular

LONGEST_HEADER = 1 << 16


class HdrError(ValueError):
    """A file that is no complete picture of this format; the message says why, and names no file."""


def is_hdr(head: bytes) -> bool:
    """Whether a file that begins with these bytes claims this format."""
    return head.startswith((b"#?RADIANCE", b"#?RGBE"))


def read_hdr(path: Path, most_texels: int) -> np.ndarray:
    """Linear red, green and blue (height, width, 3), float32, the top row first.

    HdrError for a file that is damaged, has more texels than allowed, or another order of pixels.
    """
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
    at: Any = 0
    for y in range(height):
        if at + 4 > data.size:
            return False
        coded = data[at] == 2 and data[at + 1] == 2 and data[at + 2] < 128 and 8 <= width < 32768
        if not coded:
            if at + 4 * width > data.size:
                return False
            for x in range(width):
                for c in range(4):
                    pixels[y, x, c] = data[at + 4 * x + c]
                if pixels[y, x, 0] == 1 and pixels[y, x, 1] == 1 and pixels[y, x, 2] == 1:
                    return False                        # a run of the oldest form of the format
            at += 4 * width
            continue
        if (np.int64(data[at + 2]) << 8) + data[at + 3] != width:
            return False
        at += 4
        for c in range(4):
            place: Any = 0
            while place < width:
                if at >= data.size:
                    return False
                count: Any = np.int64(data[at])
                run = count > 128
                count = count - 128 if run else count
                need: Any = 2 if run else 1 + count
                if count == 0 or place + count > width or at + need > data.size:
                    return False
                for k in range(count):
                    pixels[y, place + k, c] = data[at + 1] if run else data[at + 1 + k]
                place, at = place + count, at + need
    return True
