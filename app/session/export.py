"""Pictures on disk: PNG and PPM tone-mapped, EXR and PFM in linear light, all but PFM with their settings.

A picture is written to a temporary file next to it, and replaces the old file
when it is complete on the disk: the file is at any time either the old or the new one.

PNG is written here, chunk by chunk: Pillow has no 16-bit RGB, and one writer serves
both depths. The settings are JSON, in PNG as an iTXt chunk, in EXR as a header
attribute and in PPM as a comment, each named `lensbench`.
"""

import json
import os
import secrets
import struct
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from importlib.metadata import version
from itertools import chain
from pathlib import Path
from time import time
from typing import BinaryIO

import numpy as np

import lensbench as lb
from lensbench.app.bench import tone
from lensbench.app.bench.auto_model import record
from lensbench.app.bench.exposure import applied_exposure, recorded
from lensbench.app.bench.tone import aov_codes
from lensbench.app.session import picture_formats
from lensbench.app.session.picture_formats import SIGNATURE as EXR_SIGNATURE, HeaderError, exr_attribute, write_exr
from lensbench.app.settings.settings import CHOSEN, Settings
from lensbench.core.text import MOST_CHARACTERS, cut, escaped
from lensbench.lenses.file_error import open_regular

SUFFIXES = {".png": "tone-mapped picture, 8 or 16 bits", ".ppm": "the same, without compression",
            ".exr": "linear light, float", ".pfm": "the same, without settings"}
BITS = (8, 16)
KEY = "lensbench"                       # of the settings in a picture's metadata
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
MAX_TEXT = 1 << 20                      # bytes of settings that a picture may carry
OLDEST = 30 * 86400.0                   # seconds; a large picture may be written for days
DEVELOPED = 1 << 17                     # pixels that are tone-mapped at once


class ExportError(ValueError):
    """A picture that cannot be written, or that holds no settings; the message says what to do."""

    def __init__(self, message: str):
        super().__init__(escaped(message))              # it may repeat what is in a file


def develop(image: np.ndarray, settings: Settings) -> np.ndarray:
    """SRGB values in [0, 1] of exposed light (h, w, 3), as the window shows them without overlays; NaN is black."""
    if settings.sample_view:
        return aov_codes(image, settings)
    return tone.develop(np.nan_to_num(image, nan=0.0, posinf=1e9, neginf=0.0), settings.exposure, settings.tone,
                        settings.noise)


def save_picture(path: str | Path, image: np.ndarray, settings: Settings, bits: int = 8, text: bool = False,
                 choice: lb.Choice | None = None, described: bool = True) -> None:
    """Write a linear picture (h, w, 3): tone-mapped to .png or .ppm of 8 or 16 bits, or as floats to .exr or .pfm.

    text: a PPM with numbers as text (P3). choice: of the automatic model, recorded with the settings. described:
    whether the settings are those of the picture, and are written with it.
    ExportError for another suffix or depth, for text in another kind of file, and for errors of the disk; an older
    file is then unchanged.
    """
    save_bands(path, (image.shape[0], image.shape[1]), [image], settings, bits, text, choice, described)


def save_bands(path: str | Path, shape: tuple[int, int], bands: Iterable[np.ndarray], settings: Settings,
               bits: int = 8, text: bool = False, choice: lb.Choice | None = None, described: bool = True) -> None:
    """`save_picture` of a picture (h, w) of which only a band of lines is in memory at a time.

    bands: linear light (lines, w, 3) from the top down, written while they are made. An exposure that is metered needs
    the whole picture: it is then put together first.
    """
    path = Path(path)
    suffix = checked_place(path, text)
    if bits not in BITS:
        raise ExportError(f"{bits} bits: choose 8 or 16")
    if suffix in (".png", ".ppm") and not settings.sample_view:
        bands = _exposed(settings, shape, bands)
    note = _note(settings, choice) if described else ""
    with replacing(path) as temporary, temporary.open("wb") as file:
        if suffix == ".png":
            write_png(file, shape, bands, settings, bits, note)
        elif suffix == ".ppm":
            _write_ppm(file, shape, bands, settings, bits, text, note)
        elif suffix == ".exr":
            write_exr(file, shape, bands, {KEY: note} if note else {})
        else:
            picture_formats.write_pfm(file, shape, bands)


def _exposed(settings: Settings, shape: tuple[int, int], bands: Iterable[np.ndarray]) -> Iterator[np.ndarray]:
    """The bands as the sensor records them."""
    if settings.exposing == "plain" and not settings.noise:
        yield from bands
        return
    exposure, top = None, 0
    if settings.exposing == "automatic":
        image = _joined(shape, bands)
        exposure, bands = applied_exposure(settings, image), parts(image)
    for band in bands:
        exposure = exposure or applied_exposure(settings, band)       # not metered: the same for every band
        yield recorded(settings, exposure, band, top)
        top += len(band)


def _joined(shape: tuple[int, int], bands: Iterable[np.ndarray]) -> np.ndarray:
    """The whole picture."""
    image, top = np.empty((*shape, 3), np.float32), 0
    for band in bands:
        image[top:top + len(band)] = band
        top += len(band)
    return image


def read_settings(path: str | Path) -> Settings:
    """The settings of an exported picture; ExportError: there are none, newer ones, or a damaged file."""
    path = Path(path)
    text = carried_text(path)
    if text is None:
        raise ExportError(f"{path}: this picture holds no settings: it was not exported by lensbench")
    return settings_of(text, path)


def carried_text(path: Path) -> str | None:
    """The JSON of the settings that a picture carries, None where it carries none; ExportError for a damaged file."""
    try:
        with open_regular(path) as file:
            signature = file.read(len(PNG_SIGNATURE))
            if signature == PNG_SIGNATURE:
                return _png_text(file, path)
            if signature.startswith(EXR_SIGNATURE):
                return exr_attribute(file, KEY)
            if signature.startswith(picture_formats.SIGNATURES):
                file.seek(0)
                return picture_formats.read_comment(file, KEY)
            raise ExportError(f"{path}: this is neither a PNG nor an EXR nor a PPM picture")
    except HeaderError as error:
        raise ExportError(f"{path}: this EXR is cut off or damaged: {error}") from error
    except OSError as error:
        raise ExportError(f"{path}: {error.strerror}") from error
    except ValueError as error:
        if isinstance(error, ExportError):
            raise
        raise ExportError(f"{path}: not a file name") from error


def settings_of(text: str, path: Path) -> Settings:
    """The settings of a file's JSON; ExportError where they are damaged or invalid."""
    try:
        plain = json.loads(text)
    except (ValueError, RecursionError) as error:       # of JSON, of a number of 5000 digits, of nested brackets
        raise ExportError(f"{path}: its settings are damaged: {cut(str(error), 2 * MOST_CHARACTERS)}") from error
    if not isinstance(plain, dict):
        raise ExportError(f"{path}: its settings are damaged: they must be an object in braces")
    try:
        return Settings.from_dict(plain)
    except ValueError as error:
        raise ExportError(f"{path}: {error}") from error


def checked_place(path: Path, text: bool = False) -> str:
    """The suffix in lower case; ExportError for one that cannot be written."""
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        known = ", ".join(f"{suffix} ({what})" for suffix, what in SUFFIXES.items())
        raise ExportError(f"{path}: pictures are written as {known}")
    if text and suffix != ".ppm":
        raise ExportError(f"{path}: only a .ppm can be written as text")
    return suffix


@contextmanager
def replacing(path: Path, keep: bool = True) -> Iterator[Path]:
    """A temporary file next to `path`; at the end it replaces `path`, unless keep is false.

    Of two writers of one file the later one wins: each has a temporary file of its own. Those that a
    process left when it was killed are removed from the folder first.
    """
    path = path.resolve()               # a link stays, its target is replaced
    temporary = path.with_name(f".lensbench-{os.getpid()}-{secrets.token_hex(4)}.part")
    if not path.parent.is_dir():
        raise ExportError(f"{path}: there is no folder {path.parent}")
    if path.is_dir():
        raise ExportError(f"{path}: this is a folder")
    _clear(path.parent)
    try:
        yield temporary
        if keep:
            with temporary.open("r+b") as file:
                os.fsync(file.fileno())
            os.replace(temporary, path)
            _sync_folder(path.parent)
    except OSError as error:
        raise ExportError(f"{path}: {error.strerror}: nothing was written") from error
    finally:
        temporary.unlink(missing_ok=True)


def _clear(folder: Path) -> None:
    """Remove the temporary files of processes that have ended, or that are a month old: their number may come again."""
    for path in folder.glob(".lensbench-*.part"):
        with suppress(OSError, ValueError):     # another process has removed it; a name of an earlier version
            if time() - path.lstat().st_mtime > OLDEST or not runs(int(path.name.split("-")[1])):
                path.unlink()


def runs(process: int) -> bool:
    """Whether a process runs on this machine; True where the system cannot tell."""
    if os.name != "posix":
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:                             # it runs, as another user
        return True
    return True


def check_writable(path: Path) -> None:
    """ExportError if a file cannot be written; for a check before long work."""
    with replacing(path, keep=False) as temporary:
        temporary.touch()


def _sync_folder(folder: Path) -> None:
    """Write the new name to the disk too, if the system can."""
    if os.name == "posix":
        handle = os.open(folder, os.O_RDONLY)
        with suppress(OSError):         # some network folders cannot
            os.fsync(handle)
        os.close(handle)


def _note(settings: Settings, choice: lb.Choice | None) -> str:
    """The settings as JSON, with the choice of the automatic model."""
    chosen = {} if choice is None else {CHOSEN: record(choice)}
    return json.dumps({**settings.to_dict(), **chosen}, ensure_ascii=True, allow_nan=False)


def parts(image: np.ndarray) -> Iterator[np.ndarray]:
    """Views of some lines of a picture (h, w, 3) at a time, so few that their development takes little memory."""
    lines = max(DEVELOPED // image.shape[1], 1)
    return (image[first:first + lines] for first in range(0, len(image), lines))


def _codes(bands: Iterable[np.ndarray], settings: Settings, deepest: int) -> Iterator[np.ndarray]:
    """The developed picture in bands of rows, as whole numbers from 0 to `deepest`."""
    kind = np.uint8 if deepest < 256 else np.uint16
    for lines in chain.from_iterable(map(parts, bands)):
        yield np.rint(develop(lines, settings) * deepest).astype(kind)


def _write_ppm(file: BinaryIO, shape: tuple[int, int], bands: Iterable[np.ndarray], settings: Settings, bits: int,
               text: bool, note: str) -> None:
    deepest = 2**bits - 1
    picture_formats.write_ppm(file, _codes(bands, settings, deepest), (shape[1], shape[0]), deepest,
                     f"{KEY} {note}" if note else "made by lensbench", text)


def write_png(file: BinaryIO, shape: tuple[int, int], bands: Iterable[np.ndarray], settings: Settings, bits: int = 8,
              note: str = "") -> None:
    """PNG (ISO/IEC 15948): RGB, sRGB, every row filtered as its difference from the row above.

    shape: (h, w). bands: linear light (lines, w, 3), exposed, or the screen codes of the tone "raw". note: the settings
    as JSON, or nothing.
    """
    height, width = shape
    packer = zlib.compressobj(6)
    above = np.zeros((1, 3 * width * bits // 8), np.uint8)
    file.write(PNG_SIGNATURE)
    _write_chunk(file, b"IHDR", struct.pack(">IIBBBBB", width, height, bits, 2, 0, 0, 0))
    _write_chunk(file, b"sRGB", b"\0")
    _write_chunk(file, b"tEXt", b"Software\0lensbench " + version("lensbench").encode("latin-1"))
    if note:
        _write_chunk(file, b"iTXt", KEY.encode() + b"\0\0\0\0\0" + note.encode())
    for codes in _codes(bands, settings, 2**bits - 1):
        rows = codes.astype(f">u{bits // 8}").view(np.uint8).reshape(len(codes), -1)
        lines = np.empty((len(rows), rows.shape[1] + 1), np.uint8)
        lines[:, 0] = 2             # the filter "Up"
        lines[:, 1:] = rows - np.concatenate([above, rows[:-1]])
        above = rows[-1:]
        _write_chunk(file, b"IDAT", packer.compress(lines.tobytes()))
    _write_chunk(file, b"IDAT", packer.flush())
    _write_chunk(file, b"IEND", b"")


def _write_chunk(file: BinaryIO, kind: bytes, data: bytes) -> None:
    file.write(struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))


def _png_text(file: BinaryIO, path: Path) -> str | None:
    """The text under our key, after all chunks to the last were found in place; None where it is missing."""
    size, text = os.fstat(file.fileno()).st_size, None
    while True:
        head = file.read(8)
        end = file.tell() + 4 + (struct.unpack(">I", head[:4])[0] if len(head) == 8 else 0)
        if len(head) < 8 or end > size:
            raise ExportError(f"{path}: this PNG is cut off: export it again")
        kind, length = head[4:], end - 4 - file.tell()
        if kind == b"IEND":
            return text
        if kind == b"iTXt" and length <= MAX_TEXT:
            data = file.read(length)
            if data.startswith(KEY.encode() + b"\0"):
                if zlib.crc32(kind + data) != struct.unpack(">I", file.read(4))[0]:
                    raise ExportError(f"{path}: the settings in this PNG are damaged")
                text = data[len(KEY) + 5:].decode("utf-8", "replace")
        file.seek(end)
