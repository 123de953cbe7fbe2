"""The header of an OpenEXR file: one of its texts, and whether the file is whole.

Read here and not by the library: a text that is no UTF-8 is an error of Python there, and a stranger's file meets no
code but this. A header is a list of attributes, each a name and a type, both ended by a zero byte, a length (int32, low
byte first) and the value; an empty name ends the list. Behind it stands a table of the places of the chunks of rows
(technical introduction to OpenEXR, "OpenEXR file layout").
"""

import os
import struct
from typing import BinaryIO

import numpy as np

SIGNATURE = b"\x76\x2f\x31\x01"
LONGEST = 1 << 20                               # bytes of the header
MOST_ATTRIBUTES = 1000
ROWS = {0: 1, 1: 1, 2: 1, 3: 16, 4: 32, 5: 16, 6: 32, 7: 32, 8: 32, 9: 256}      # of a chunk, by compression
MOST_ROWS = 1 << 24
SCAN_LINES = 2                                  # version and flags of a file of one part, in scan lines


class HeaderError(ValueError):
    """The header is incomplete, or its parts contradict each other."""


def exr_attribute(file: BinaryIO, name: str) -> str | None:
    """The text of an attribute, None where there is no such; HeaderError if the file is not whole.

    file: at any place. Of a file in tiles or of several parts only the header of the first part is read.
    """
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
            raise HeaderError(f"its attribute {name} is no text")
        return value.decode("utf-8")
    except UnicodeDecodeError as error:
        raise HeaderError(f"its attribute {name} is no text") from error


def _attributes(data: bytes) -> tuple[dict[str, tuple[str, bytes]], int]:
    """Type and value of each attribute by name, and where the list ends."""
    found: dict[str, tuple[str, bytes]] = {}
    at = 8
    while data[at:at + 1] != b"\0":
        texts = []
        for _ in range(2):
            end = data.find(b"\0", at, at + 257)
            if end < 0:
                raise HeaderError("its list of attributes breaks off")
            texts.append(data[at:end].decode("latin-1"))
            at = end + 1
        length = struct.unpack("<i", data[at:at + 4])[0] if at + 4 <= len(data) else -1
        at += 4
        if length < 0 or at + length >= len(data) or texts[0] in found or len(found) == MOST_ATTRIBUTES:
            raise HeaderError("its list of attributes breaks off")
        found[texts[0]] = (texts[1], data[at:at + length])
        at += length
    return found, at + 1


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
    places = np.frombuffer(file.read(8 * chunks), "<u8")
    if places.min() < start + 8 * chunks or places.max() > size - 8:
        raise HeaderError("rows are missing")
    for place in (int(places.min()), int(places.max())):
        file.seek(place)
        y, length = struct.unpack("<ii", file.read(8))
        if not y_min <= y <= y_max or length < 0 or place + 8 + length > size:
            raise HeaderError("rows are missing")
