"""Picture formats: OpenEXR headers and bands, portable pixmaps; and the clipboard.

The OpenEXR library takes whole pictures only, and a header's text that is no UTF-8 is an error of Python there. A file
is a list of attributes, each a name and a type, both ended by a zero byte, a length (int32, low byte first) and the
value; an empty name ends the list. Then come a table of the positions of the chunks, and the chunks: LINES lines, of
each all of B, then all of G, then all of R. Their bytes, those at even positions first, are compressed as differences
from one to the next, and stored as they are where that is not shorter (OpenEXR file layout; `ImfZip.cpp`).

A PPM's rows run from the top; numbers of more than 8 bits have their high byte first; a comment of the header carries
the settings. A PFM's rows run from the bottom, and a negative scale means that the low byte is first.
"""

import os
import shutil
import struct
import subprocess
import sys
import zlib
from collections.abc import Iterable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from lensbench.app.scenes.sky_picture import EXR as SIGNATURE

LONGEST = 1 << 20                               # bytes of the header
MOST_ATTRIBUTES = 1000
ROWS = {0: 1, 1: 1, 2: 1, 3: 16, 4: 32, 5: 16, 6: 32, 7: 32, 8: 32, 9: 256}      # of a chunk, by compression
MOST_ROWS = 1 << 24
SCAN_LINES = 2                                  # version and flags of a file of one part, in scan lines


class HeaderError(ValueError):
    """The header is incomplete, or its parts contradict each other."""


def exr_attribute(file: BinaryIO, name: str) -> str | None:
    """Text of an attribute of the file's first part, None without it; HeaderError for a file that is cut."""
    size = file.seek(0, os.SEEK_END)
    file.seek(0)
    data = file.read(LONGEST)
    if data[:4] != SIGNATURE or len(data) < 8:
        raise HeaderError("it is too short")
    attributes, end = _attributes(data)
    if struct.unpack("<I", data[4:8])[0] & ~0x400 == SCAN_LINES:               # 0x400: long names
        _check_chunks(file, attributes, end, size)
    kind, value = attributes.get(name, ("", b""))
    if not kind:
        return None
    try:
        if kind != "string":
            raise HeaderError(f"its attribute {name} is not text")
        return value.decode("utf-8")
    except UnicodeDecodeError as error:
        raise HeaderError(f"its attribute {name} is not text") from error


def _attributes(data: bytes) -> tuple[dict[str, tuple[str, bytes]], int]:
    """Type and value of each attribute by name, and where the list ends."""
    attributes: dict[str, tuple[str, bytes]] = {}
    position = 8
    while data[position:position + 1] != b"\0":
        texts = []
        for _ in range(2):
            end = data.find(b"\0", position, position + 257)
            if end < 0:
                raise HeaderError("its list of attributes breaks off")
            texts.append(data[position:end].decode("latin-1"))
            position = end + 1
        length = struct.unpack("<i", data[position:position + 4])[0] if position + 4 <= len(data) else -1
        position += 4
        if length < 0 or position + length >= len(data) or texts[0] in attributes or len(attributes) == MOST_ATTRIBUTES:
            raise HeaderError("its list of attributes breaks off")
        attributes[texts[0]] = (texts[1], data[position:position + length])
        position += length
    return attributes, position + 1


def _check_chunks(file: BinaryIO, attributes: dict[str, tuple[str, bytes]], start: int, size: int) -> None:
    """HeaderError if a chunk of rows is not in the file."""
    window, compression = attributes.get("dataWindow", ("", b""))[1], attributes.get("compression", ("", b""))[1]
    if len(window) != 16 or len(compression) != 1 or compression[0] not in ROWS:
        raise HeaderError("it states no window, or an unknown compression")
    x_min, y_min, x_max, y_max = struct.unpack("<4i", window)
    rows = y_max - y_min + 1
    chunks = -(-rows // ROWS[compression[0]])
    if x_max < x_min or not 1 <= rows <= MOST_ROWS or start + 8 * chunks > size:
        raise HeaderError("it is shorter than its window")
    file.seek(start)
    positions = np.frombuffer(file.read(8 * chunks), "<u8")
    if positions.min() < start + 8 * chunks or positions.max() > size - 8:
        raise HeaderError("rows are missing")
    for position in (int(positions.min()), int(positions.max())):
        file.seek(position)
        y, length = struct.unpack("<ii", file.read(8))
        if not y_min <= y <= y_max or length < 0 or position + 8 + length > size:
            raise HeaderError("rows are missing")


ZIP, FLOAT, DOWNWARDS = 3, 2, 0         # codes of the compression, of float32, of the order of the lines
LINES = ROWS[ZIP]
AT_ONCE = 8 * LINES                     # lines that are compressed before they are written
LEVEL = 2                               # of zlib: higher ones gain half a percent on noise


def write_exr(file: BinaryIO, shape: tuple[int, int], bands: Iterable[np.ndarray], texts: Mapping[str, str]) -> None:
    """Write linear bands (lines, w, 3) of a picture (h, w), multiples of LINES from the top, and texts by name."""
    file.write(_header(shape, texts))
    table, positions, y = file.tell(), [], 0
    file.write(bytes(8 * -(-shape[0] // LINES)))
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for block in (band[top:top + AT_ONCE] for band in bands for top in range(0, len(band), AT_ONCE)):
            for data in pool.map(_packed, (block[first:first + LINES] for first in range(0, len(block), LINES))):
                positions.append(file.tell())
                file.write(struct.pack("<ii", y, len(data)) + data)
                y += LINES
    file.seek(table)
    file.write(np.array(positions, "<u8").tobytes())


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


SIGNATURES = (b"P3", b"P6")
NUMBERS_PER_LINE = 9            # of at most five digits: lines of a text PPM have at most 70 characters
MAX_COMMENT = 1 << 20           # bytes of a line in a header


def write_ppm(file: BinaryIO, bands: Iterable[NDArray[np.unsignedinteger]], size: tuple[int, int], deepest: int,
              comment: str, text: bool = False) -> None:
    """Write a picture (across, down) from bands (rows, across, 3) of codes to `deepest`; as text: P3, else P6."""
    kind = "P3" if text else "P6"
    file.write(f"{kind}\n# {comment}\n{size[0]} {size[1]}\n{deepest}\n".encode("ascii"))
    for codes in bands:
        if text:
            words = [str(code) for code in codes.ravel().tolist()]
            lines = (" ".join(words[i:i + NUMBERS_PER_LINE]) for i in range(0, len(words), NUMBERS_PER_LINE))
            file.write(("\n".join(lines) + "\n").encode("ascii"))
        else:
            file.write(np.ascontiguousarray(codes, ">u1" if deepest < 256 else ">u2").tobytes())


def write_pfm(file: BinaryIO, shape: tuple[int, int], bands: Iterable[NDArray[np.floating]]) -> None:
    """Write linear light in float32: a picture (h, w) as bands (lines, w, 3) from the top down, each to its place."""
    height, width = shape
    file.write(f"PF\n{width} {height}\n-1.0\n".encode("ascii"))
    start, below = file.tell(), height
    for band in bands:
        below -= len(band)
        file.seek(start + 12 * width * below)
        file.write(np.ascontiguousarray(band[::-1], "<f4").data)


def read_comment(file: BinaryIO, key: str) -> str | None:
    """Text after `key` in the comments of a PPM's header; None if there is no such comment."""
    file.readline(MAX_COMMENT)
    while (line := file.readline(MAX_COMMENT)).startswith(b"#"):
        name, _, rest = line[1:].strip().partition(b" ")
        if name == key.encode("ascii"):
            return rest.decode("ascii", "replace")
    return None


SECONDS = 5.0


class ClipboardError(ValueError):
    """No picture can be copied; the message says what to do."""


def command(path: Path) -> tuple[list[str], bool]:
    """The program that copies a PNG, with its arguments; and whether it reads the picture from its standard input."""
    if sys.platform == "darwin":
        text = str(path).replace("\\", "\\\\").replace('"', '\\"')
        return ["osascript", "-e", f'set the clipboard to (read (POSIX file "{text}") as «class PNGf»)'], False
    if sys.platform == "win32":
        text = str(path).replace("'", "''")
        return ["powershell", "-NoProfile", "-Sta", "-Command",
                "Add-Type -AssemblyName System.Windows.Forms, System.Drawing; [Windows.Forms.Clipboard]::SetImage("
                f"[Drawing.Image]::FromFile('{text}'))"], False
    if os.environ.get("WAYLAND_DISPLAY") and shutil.which("wl-copy"):
        return ["wl-copy", "--type", "image/png"], True
    if os.environ.get("DISPLAY") and shutil.which("xclip"):
        return ["xclip", "-selection", "clipboard", "-t", "image/png", "-i"], True
    raise ClipboardError("a picture is copied by wl-copy (Wayland) or xclip (X11): install one of them, or save it")


def copy_picture(path: Path) -> None:
    """Put a PNG file on the clipboard; ClipboardError if it cannot be."""
    program, piped = command(path)
    try:
        with path.open("rb") as file:
            subprocess.run(program, stdin=file if piped else subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL, check=True, timeout=SECONDS)
    except (OSError, subprocess.SubprocessError) as error:
        raise ClipboardError(f"{program[0]} could not copy the picture: {error}") from error
