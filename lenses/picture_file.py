"""The one place where a picture file is decoded: only the formats listed here, and only in bounded memory.

The format follows from the first bytes, whatever the name of the file says, and Pillow gets only that one: its other
readers include one that runs a program of the file (PostScript). Size and memory are checked by the header.
"""

import os
import warnings
from io import BytesIO
from typing import Any

from lensbench.core.text import significant
from lensbench.lenses.file_error import open_regular

FORMATS = ("PNG", "JPEG", "TIFF", "WEBP", "BMP")
SIGNATURES = ((b"\x89PNG\r\n\x1a\n", "PNG"), (b"\xff\xd8\xff", "JPEG"), (b"II*\0", "TIFF"), (b"MM\0*", "TIFF"),
              (b"BM", "BMP"))
MOST_PIXELS = 8192 * 8192
MOST_BYTES = 640 << 20          # of memory while a picture is decoded: ten for each of the most pixels
BITS_PER_SAMPLE = 258           # tag of TIFF
KEPT = {"1": 1, "L": 1, "P": 1, "I;16": 2, "I;16B": 2, "I;16L": 2, "I;16N": 2}      # bytes a pixel; others take 4
ORIENTATION = 0x0112            # tag of EXIF


class PictureFileError(ValueError):
    """A file that is no picture that can be read; the message says why, and names no file."""


def read_picture_file(source: str | os.PathLike[str] | bytes, most_pixels: int = MOST_PIXELS,
                      upright: bool = True, real: bool = False) -> Any:
    """The first picture of a file, or of its content, decoded: a PIL.Image.Image in the mode of the file.

    most_pixels: at most `MOST_PIXELS`. upright: turn the picture by its EXIF orientation, as viewers do. real: the
    pixels may be floating-point numbers (mode F), which have no common white. PictureFileError where the file cannot be
    opened, has another format than `FORMATS`, is damaged, has too many pixels, or needs more than `MOST_BYTES` to
    decode.
    """
    from PIL import Image

    try:
        with BytesIO(source) if isinstance(source, bytes) else open_regular(source) as file:
            kind = _kind(file.read(16))
            file.seek(0)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")         # the sizes of which Pillow warns are refused below
                picture = Image.open(file, formats=(kind,))
                _check(picture, kind, min(most_pixels, MOST_PIXELS))
                if picture.mode == "F" and not real:
                    raise PictureFileError("its pixels are floating-point numbers: save it with 8 or 16 bits")
                picture.load()
            way = _turn(picture) if upright else None
            return picture if way is None else picture.transpose(way)
    except PictureFileError:
        raise
    except Image.DecompressionBombError as error:
        raise PictureFileError(_too_many(most_pixels)) from error
    except MemoryError as error:
        raise PictureFileError("it does not fit into memory") from error
    except Exception as error:          # Pillow raises whatever a damaged file makes Python raise
        stated = isinstance(error, OSError) and error.errno is not None and error.strerror
        raise PictureFileError(stated or "it is damaged or cut short") from error


def _kind(head: bytes) -> str:
    """The format of a file with these first 16 bytes; PictureFileError for all others."""
    if head[:4] == b"RIFF" and head[8:12] == b"WEBP":
        return "WEBP"
    for signature, kind in SIGNATURES:
        if head.startswith(signature):
            return kind
    raise PictureFileError(f"it is no picture of the kinds {', '.join(FORMATS)}: save it as one of these")


def _turn(picture: Any) -> Any:
    """The transposition of Pillow that turns a picture as its EXIF orientation states; None for one that is upright."""
    from PIL import Image

    ways = Image.Transpose
    try:
        orientation = picture.getexif().get(ORIENTATION)
    except Exception:                   # damaged notes beside a whole picture
        return None
    return dict(enumerate((ways.FLIP_LEFT_RIGHT, ways.ROTATE_180, ways.FLIP_TOP_BOTTOM, ways.TRANSPOSE,
                           ways.ROTATE_270, ways.TRANSVERSE, ways.ROTATE_90), 2)).get(orientation)


def _check(picture: Any, kind: str, most_pixels: int) -> None:
    """PictureFileError for a picture, of which only the header has been read, that is too large or too small."""
    pixels = picture.width * picture.height
    if pixels > most_pixels:
        raise PictureFileError(_too_many(most_pixels))
    kept, work = KEPT.get(picture.mode, 4), 0
    if kind == "JPEG" and "progressive" in picture.info:
        work = 2 * len(picture.getbands())              # coefficients of 16 bits (libjpeg)
    elif kind == "TIFF":                                # a strip may hold all rows
        work = -(-sum(picture.tag_v2.get(BITS_PER_SAMPLE, (1,))) // 8)
    elif kind == "WEBP":
        work = 16                                       # two canvases, a copy, and the lossless decoder's own
    need = pixels * max(kept + work, 2 * kept)          # twice: beside the picture that is turned
    if need > MOST_BYTES:
        raise PictureFileError(f"it needs {significant(need / 2**20, 3)} MB to decode, at most {MOST_BYTES >> 20} MB "
                               "are allowed: make it smaller")


def _too_many(most_pixels: int) -> str:
    return f"more than {most_pixels // 1_000_000} million pixels: make it smaller"
