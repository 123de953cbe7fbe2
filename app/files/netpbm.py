"""Portable pixmaps: PPM as numbers in text (P3) or in bytes (P6), and PFM, its sister of floats.

A PPM's rows run from the top; numbers of more than 8 bits have their high byte first. A PFM's
rows run from the bottom; a negative scale means that the low byte is first. The header
of a PPM may have comments, one of which carries the settings; that of a PFM has none.
"""

from collections.abc import Iterable
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

SIGNATURES = (b"P3", b"P6")
NUMBERS_PER_LINE = 9            # of at most five digits: lines of a text PPM have at most 70 characters
MAX_COMMENT = 1 << 20           # bytes of a line in a header


def write_ppm(file: BinaryIO, bands: Iterable[NDArray[np.unsignedinteger]], size: tuple[int, int], deepest: int,
              comment: str, text: bool = False) -> None:
    """Write a picture of `size` (across, down) from its bands of rows, (rows, across, 3) codes from 0 to `deepest`.

    text: as P3, for people and simple programs; otherwise P6. The comment is one line of ASCII.
    """
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
