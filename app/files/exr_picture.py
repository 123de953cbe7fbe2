"""OpenEXR pictures, written band by band: scan lines of linear RGB in float32, compressed by zip.

The library takes whole pictures only. A file is a header of attributes (`exr_header`), a table of the places of its
chunks, and the chunks: LINES lines, of each line all of B, then all of G, then all of R. The bytes of a chunk, those at
even places first, are compressed as differences from one to the next, and stored as they are where that is not shorter
(OpenEXR file layout; `ImfZip.cpp`).
"""

import os
import struct
import zlib
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import BinaryIO

import numpy as np

from lensbench.app.files.exr_header import ROWS, SCAN_LINES, SIGNATURE

ZIP, FLOAT, DOWNWARDS = 3, 2, 0         # codes of the compression, of float32, of the order of the lines
LINES = ROWS[ZIP]
AT_ONCE = 8 * LINES                     # lines that are compressed before they are written
LEVEL = 2                               # of zlib: higher ones gain half a percent on noise


def write_exr(file: BinaryIO, shape: tuple[int, int], bands: Iterable[np.ndarray], texts: Mapping[str, str]) -> None:
    """Write linear light: a picture (h, w) as bands (lines, w, 3) from the top down, with texts by name.

    Every band but the last has a multiple of LINES lines.
    """
    file.write(_header(shape, texts))
    table, places, y = file.tell(), [], 0
    file.write(bytes(8 * -(-shape[0] // LINES)))
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for part in (band[top:top + AT_ONCE] for band in bands for top in range(0, len(band), AT_ONCE)):
            for data in pool.map(_packed, (part[first:first + LINES] for first in range(0, len(part), LINES))):
                places.append(file.tell())
                file.write(struct.pack("<ii", y, len(data)) + data)
                y += LINES
    file.seek(table)
    file.write(np.array(places, "<u8").tobytes())


def _header(shape: tuple[int, int], texts: Mapping[str, str]) -> bytes:
    height, width = shape
    channels = b"".join(name + struct.pack("<iiii", FLOAT, 0, 1, 1) for name in (b"B\0", b"G\0", b"R\0")) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    attributes = [("channels", "chlist", channels), ("compression", "compression", bytes([ZIP])),
                  ("dataWindow", "box2i", window), ("displayWindow", "box2i", window),
                  ("lineOrder", "lineOrder", bytes([DOWNWARDS])), ("pixelAspectRatio", "float", struct.pack("<f", 1.0)),
                  ("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0)),
                  ("screenWindowWidth", "float", struct.pack("<f", 1.0)),
                  *((name, "string", text.encode()) for name, text in texts.items())]
    return b"".join([SIGNATURE, struct.pack("<i", SCAN_LINES),
                     *(f"{name}\0{kind}\0".encode() + struct.pack("<i", len(value)) + value
                       for name, kind, value in attributes), b"\0"])


def _packed(lines: np.ndarray) -> bytes:
    """The data of a chunk."""
    plain = np.ascontiguousarray(lines[..., ::-1].transpose(0, 2, 1), "<f4").reshape(-1).view(np.uint8)
    sorted_bytes = np.concatenate([plain[::2], plain[1::2]])
    sorted_bytes[1:] -= sorted_bytes[:-1] - np.uint8(128)
    packed = zlib.compress(sorted_bytes.data, LEVEL)
    return packed if len(packed) < plain.size else plain.tobytes()
