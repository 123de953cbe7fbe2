"""Arrays with settings in .npz, as used by the files of light fields and of lumigraphs.

An archive of npy members, as `np.savez` writes it, and a member `checksum`: the SHA-256 of the names, lengths and
CRC-32 of all others. Everything is checked before memory is reserved: the number of members, their
lengths, the header of each array and its shape beside the settings; then the content, as it is read. Archives of
other programs may lack a `checksum`; their members are checked by their own CRC-32 alone.
"""

import hashlib
import json
import math
import os
import re
import struct
import zipfile
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import BinaryIO, NamedTuple

import numpy as np

from lensbench.app.files.export import MAX_TEXT, ExportError, replacing, settings_of
from lensbench.app.state.settings import Settings
from lensbench.kernels.figures import significant
from lensbench.kernels.quotation import MOST, cut, excerpt
from lensbench.lenses.regular_file import open_regular

SUFFIX = ".npz"
SETTINGS, CHECKSUM = "settings", "checksum"
TEXTS = (SETTINGS, CHECKSUM)            # members of text beside the arrays
MOST_MEMBERS = 32
LARGEST = 1_000_000_000                 # bytes of arrays that a file shorter than that may expand to
BLOCK = 1 << 22                         # bytes that are read at once
ZEROS = bytes(1 << 12)                  # a page of memory
FLOATS = {"<f2": (np.uint16, 0x7C00), "<f4": (np.uint32, 0x7F800000), "<f8": (np.uint64, 0x7FF0000000000000)}
NPY = b"\x93NUMPY\x01\x00"
HEADER = re.compile(r"\{'descr': '([<|][a-zA-Z]\d{1,8})', 'fortran_order': (True|False), "
                    r"'shape': \(((?:\d{1,9}, ?)*\d{0,9})\), ?\} *\n")


class ArrayHeader(NamedTuple):
    """What the header of an npy member says of its array."""

    kind: str                           # such as "<f2"
    shape: tuple[int, ...]
    transposed: bool                    # whether the first index runs fastest
    begins: int                         # bytes of the header

    @property
    def bytes(self) -> int:
        """Size of the array."""
        size = 4 if self.kind[1] == "U" else 1
        return math.prod(self.shape) * int(self.kind[2:]) * size


class DamagedError(ValueError):
    """Content that this program has not written."""


def checked_suffix(path: str | Path) -> Path:
    """The path; ExportError if its suffix is not .npz."""
    path = Path(path)
    if path.suffix.lower() != SUFFIX:
        raise ExportError(f"{path}: light fields are written as {SUFFIX}")
    return path


def save_arrays(path: str | Path, settings: Settings, **arrays) -> None:
    """Write arrays and numbers with the settings; ExportError if they cannot be written."""
    path = checked_suffix(path)
    text = np.array(json.dumps(settings.to_dict(), allow_nan=False))
    with replacing(path) as part, zipfile.ZipFile(part, "w", zipfile.ZIP_STORED) as archive:
        for name, values in {**arrays, SETTINGS: text}.items():
            _write(archive, name, values)
        _write(archive, CHECKSUM, np.array(_checksum(archive.infolist())))


def load_arrays(path: Path, what: str, maker: str, wanted: Callable[[set[str]], set[str]],
                fits: Callable[[Mapping[str, ArrayHeader], Settings], bool], light: bool = True,
                into: Mapping[str, np.ndarray] = MappingProxyType({}),
                ) -> tuple[dict[str, np.ndarray], Settings]:
    """The arrays of a file, by name, and its settings.

    what: the kind of file, in words. maker: the command that records one. wanted: maps the names in the file to those
    that such a file holds; to none for another kind of file. fits: whether arrays of these headers are those of the
    settings. light: whether the numbers must be finite
    and not negative. into: arrays of zeros by name, which take the values of those of their kind and shape; on an error
    they hold anything. ExportError if the file is missing, of another kind, incomplete, damaged, too large, or has
    invalid settings.
    """
    try:
        with open_regular(path) as file:
            if not _is_archive(file):
                raise ExportError(f"{path}: this is no {what}, or one that was cut short")
            with zipfile.ZipFile(file) as archive:
                members = _members(archive)
                known = wanted(set(members)) if SETTINGS in members else set()
                if not known:
                    raise ExportError(f"{path}: this is no {what}; lensbench {maker} records one")
                if strange := sorted(set(members) - known - set(TEXTS)):
                    raise DamagedError(f"it holds {excerpt(strange[0])}, which no {what} has")
                if CHECKSUM in members and _text(archive, members[CHECKSUM]) != _checksum(
                        [member for name, member in members.items() if name != CHECKSUM]):
                    raise DamagedError("its checksum is another one")
                settings = settings_of(_text(archive, members[SETTINGS]), path)
                headers = {name: _header(archive, members[name]) for name in known}
                if not fits(headers, settings):
                    raise ExportError(f"{path}: the arrays of this {what} are not those of its settings")
                size = sum(header.bytes for header in headers.values())
                if size > max(LARGEST, os.fstat(file.fileno()).st_size):
                    raise ExportError(f"{path}: its arrays take {significant(size / 1e9, 3)} GB, more than the file: "
                                      f"at most {significant(LARGEST / 1e9)} GB are unpacked")
                return {name: _array(archive, members[name], headers[name], light, into.get(name)) for name in known
                        }, settings
    except ExportError:
        raise
    except OSError as error:
        raise ExportError(f"{path}: {error.strerror or error}") from error
    except (ValueError, EOFError, zipfile.BadZipFile, KeyError, NotImplementedError, RuntimeError, zlib.error,
            struct.error) as error:
        raise ExportError(f"{path}: this {what} is cut short or damaged ({cut(str(error), 2 * MOST)})") from error
    except MemoryError as error:
        raise ExportError(f"{path}: this {what} does not fit into memory") from error


def _write(archive: zipfile.ZipFile, name: str, values: object) -> None:
    with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
        np.lib.format.write_array(member, np.asarray(values, order="C"), version=(1, 0), allow_pickle=False)


def _checksum(members: list[zipfile.ZipInfo]) -> str:
    lines = sorted(f"{member.filename} {member.file_size} {member.CRC}\n" for member in members)
    return hashlib.sha256("".join(lines).encode()).hexdigest()


def _is_archive(file: BinaryIO) -> bool:
    """Whether a file ends as a zip archive of a few members; zipfile would read a directory of any length."""
    size = file.seek(0, os.SEEK_END)
    file.seek(max(size - (1 << 16) - 22, 0))
    tail = file.read()
    end = tail.rfind(b"PK\x05\x06")
    if end < 0 or len(tail) < end + 22:
        return False
    count, length = struct.unpack("<HI", tail[end + 10:end + 16])
    if end >= 20 and tail[end - 20:end - 16] == b"PK\x06\x07":          # zip64: the counts of the record before it
        if end < 76 or tail[end - 76:end - 72] != b"PK\x06\x06":
            return False
        count, length = struct.unpack("<QQ", tail[end - 44:end - 28])
    return count <= MOST_MEMBERS and length <= 1 << 16


def _members(archive: zipfile.ZipFile) -> dict[str, zipfile.ZipInfo]:
    """The npy members of an archive by name; DamagedError where one occurs twice, or is no npy."""
    found: dict[str, zipfile.ZipInfo] = {}
    for member in archive.infolist():
        name = member.filename.removesuffix(".npy")
        if (name == member.filename or name in found or len(found) >= MOST_MEMBERS
                or member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)):
            raise DamagedError(f"it holds {excerpt(member.filename)}")
        found[name] = member
    return found


def _header(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> ArrayHeader:
    """The header of a member; DamagedError where it is none, or its array has not the length of the member."""
    with archive.open(member) as file:
        start = file.read(len(NPY) + 2)
        length = struct.unpack("<H", start[-2:])[0] if start[:-2] == NPY else 0
        match = HEADER.fullmatch(file.read(length).decode("latin-1"))
    if match is None:
        raise DamagedError(f"the header of {excerpt(member.filename)}")
    kind, order, shape = match.groups()
    header = ArrayHeader(kind, tuple(int(side) for side in re.findall(r"\d+", shape)), order == "True",
                         len(start) + length)
    if header.begins + header.bytes != member.file_size:
        raise DamagedError(f"{excerpt(member.filename)} has not the length that its header gives")
    return header


def _text(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> str:
    """The text of a member, of at most 1 MB."""
    header = _header(archive, member)
    if header.kind[:2] != "<U" or header.shape or header.bytes > 4 * MAX_TEXT:
        raise DamagedError(f"{excerpt(member.filename)} is no text")
    with archive.open(member) as file:
        data = file.read()              # to the end, where the CRC is checked
    return data[header.begins:].decode("utf-32-le").rstrip("\0")


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo, header: ArrayHeader, light: bool,
           place: np.ndarray | None = None) -> np.ndarray:
    """The array of a member; DamagedError for other numbers than finite ones from 0 where they are of light.

    place: an array of zeros to read it into, if it is one like that; memory where it stays 0 is not touched.
    """
    if place is not None and ((place.dtype.str, place.shape) != (header.kind, header.shape) or header.transposed):
        place = None
    shape = header.shape[::-1] if header.transposed else header.shape
    values = np.empty(shape, header.kind) if place is None else place
    into = values.reshape(-1).view(np.uint8).data
    with archive.open(member) as file:
        assert isinstance(file, zipfile.ZipExtFile)
        file.read(header.begins)
        at = 0
        while at < len(into):
            part = file.read(min(BLOCK, len(into) - at))
            if not part:
                raise DamagedError(f"{excerpt(member.filename)} ends early")
            step = len(part) if place is None else len(ZEROS)
            for first in range(0, len(part), step):
                page = part[first:first + step]
                if place is None or page != ZEROS[:len(page)]:
                    into[at + first:at + first + len(page)] = page
            at += len(part)
        if file.read(1):                # at the end, where the CRC is checked
            raise DamagedError(f"{excerpt(member.filename)} is too long")
    if light and header.kind in FLOATS and values.size:
        bits, infinity = FLOATS[header.kind]
        if values.view(bits).max() >= infinity:         # nan and negative numbers have larger bits
            raise DamagedError(f"{excerpt(member.filename)} holds numbers that are negative or not finite")
    return values.T if header.transposed else values
