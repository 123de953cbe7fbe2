"""Light fields and lumigraphs on disk: numpy's .npz, an archive of plain arrays that every scientific program reads.

Of a light field, `light` (views down, views across, 3, h, w) and `coverage` (down, across, h, w) as recorded, with
finer pixels and a margin about the picture (`LightField.wide`) or, without these, with the picture's own; `reach`,
`fill`, and with separate moments of the exposure `moments` (n, down, across, 3, h, w). Of a plenoptic camera `raw`, the
raw picture (h, w, 3), `white`, its white picture (h, w), `behind`, the number of pixels behind each microlens, and
`microlenses`, their f-number. Of a lumigraph `pictures` (down, across, 3, h, w) and `nearness` (down, across, h, w) as
recorded, `spacing` and `distance` in mm. All hold `settings`, the JSON text of exported pictures, from which the camera
is built, and are not compressed: noise does not shrink, and reading is as fast as the disk.

`checksum` is the SHA-256 of the names, lengths and CRC-32 of all other members; archives of other programs may lack it.
Everything is checked before memory is reserved: the number of members, their lengths, the header of each array and its
shape against the settings; then the content, as it is read.
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

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.light_field_query import Recording
from lensbench.app.session.export import MAX_TEXT, ExportError, replacing, settings_of
from lensbench.app.settings.settings import Settings
from lensbench.core.lightfields.capture import WIDEST, of_wide, widened
from lensbench.core.lightfields.light_field import FINER
from lensbench.core.text import MOST_CHARACTERS, cut, excerpt, significant
from lensbench.lenses.file_error import open_regular

SUFFIX = ".npz"
SETTINGS, CHECKSUM = "settings", "checksum"
TEXTS = (SETTINGS, CHECKSUM)            # members of text besides the arrays
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
    with replacing(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_STORED) as archive:
        for name, values in {**arrays, SETTINGS: text}.items():
            _write(archive, name, values)
        _write(archive, CHECKSUM, np.array(_checksum(archive.infolist())))


def load_arrays(path: Path, what: str, maker: str, names: Callable[[set[str]], set[str]],
                fits: Callable[[Mapping[str, ArrayHeader], Settings], bool], light: bool = True,
                into: Mapping[str, np.ndarray] = MappingProxyType({}),
                ) -> tuple[dict[str, np.ndarray], Settings]:
    """The arrays of a file, by name, and its settings.

    what: the kind of file, in words. maker: the command that records one. names: maps the names in the file to those
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
                known = names(set(members)) if SETTINGS in members else set()
                if not known:
                    raise ExportError(f"{path}: this is no {what}; lensbench {maker} records one")
                if strange := sorted(set(members) - known - set(TEXTS)):
                    raise DamagedError(f"it holds {excerpt(strange[0])}, which no {what} has")
                if CHECKSUM in members and _text(archive, members[CHECKSUM]) != _checksum(
                        [member for name, member in members.items() if name != CHECKSUM]):
                    raise DamagedError("its checksum is wrong")
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
        reason = cut(str(error), 2 * MOST_CHARACTERS)
        raise ExportError(f"{path}: this {what} is cut short or damaged ({reason})") from error
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
    members: dict[str, zipfile.ZipInfo] = {}
    for member in archive.infolist():
        name = member.filename.removesuffix(".npy")
        if (name == member.filename or name in members or len(members) >= MOST_MEMBERS
                or member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)):
            raise DamagedError(f"it holds {excerpt(member.filename)}")
        members[name] = member
    return members


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
        raise DamagedError(f"{excerpt(member.filename)} does not have the length that its header states")
    return header


def _text(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> str:
    """The text of a member, of at most 1 MB."""
    header = _header(archive, member)
    if header.kind[:2] != "<U" or header.shape or header.bytes > 4 * MAX_TEXT:
        raise DamagedError(f"{excerpt(member.filename)} is not text")
    with archive.open(member) as file:
        data = file.read()              # to the end, where the CRC is checked
    return data[header.begins:].decode("utf-32-le").rstrip("\0")


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo, header: ArrayHeader, light: bool,
           target: np.ndarray | None = None) -> np.ndarray:
    """The array of a member; DamagedError for other numbers than finite ones from 0 where they are of light.

    target: an array of zeros to read it into, if it is one like that; memory where it stays 0 is not touched.
    """
    if target is not None and ((target.dtype.str, target.shape) != (header.kind, header.shape) or header.transposed):
        target = None
    shape = header.shape[::-1] if header.transposed else header.shape
    values = np.empty(shape, header.kind) if target is None else target
    into = values.reshape(-1).view(np.uint8).data
    with archive.open(member) as file:
        assert isinstance(file, zipfile.ZipExtFile)
        file.read(header.begins)
        position = 0
        while position < len(into):
            block = file.read(min(BLOCK, len(into) - position))
            if not block:
                raise DamagedError(f"{excerpt(member.filename)} ends early")
            step = len(block) if target is None else len(ZEROS)
            for first in range(0, len(block), step):
                page = block[first:first + step]
                if target is None or page != ZEROS[:len(page)]:
                    into[position + first:position + first + len(page)] = page
            position += len(block)
        if file.read(1):                # at the end, where the CRC is checked
            raise DamagedError(f"{excerpt(member.filename)} is too long")
    if light and header.kind in FLOATS and values.size:
        bits, infinity = FLOATS[header.kind]
        if values.view(bits).max() >= infinity:         # nan and negative numbers have larger bits
            raise DamagedError(f"{excerpt(member.filename)} holds numbers that are negative or not finite")
    return values.T if header.transposed else values


VIEWS = {"light", "coverage", "reach"}
SENSOR = {"raw", "white", "behind", "microlenses"}
OPTIONAL = {"fill", "moments"}


def save_light_field(path: str | Path, recording: Recording) -> None:
    """Write a recording; ExportError if it cannot be written."""
    raw, field = recording.raw, recording.field
    if raw is None:
        field = field.wide or field
        moments = {} if field.moments is None else {"moments": field.moments}
        save_arrays(path, recording.settings, light=field.light, coverage=field.coverage, reach=field.reach,
                    fill=field.fill, **moments)
    else:
        save_arrays(path, recording.settings, raw=raw.picture, white=raw.white, behind=raw.camera.pixels,
                    microlenses=raw.camera.microlens_f_number)


def load_light_field(path: str | Path) -> Recording:
    """Read a file of save_light_field; ExportError if it is missing, incomplete or no light field; or lens errors."""
    data, settings = load_arrays(Path(path), "light field", "lightfield capture", _wanted, _light_field_file_fit)
    try:
        return _of_sensor(data, settings) if "raw" in data else _of_views(data, settings)
    except lb.LightFieldError as error:
        raise ExportError(f"{path}: {error}") from error


def _wanted(names: set[str]) -> set[str]:
    known = SENSOR if "raw" in names else VIEWS
    if known - names:
        return set()
    return known | (OPTIONAL & names if known is VIEWS else set())


def _light_field_file_fit(headers: Mapping[str, ArrayHeader], settings: Settings) -> bool:
    """Whether arrays of these headers are a recording by these settings."""
    picture = (settings.pixels_y, settings.pixels_x)
    if "raw" in headers:
        raw, white = headers["raw"], headers["white"]
        return (raw.kind == white.kind == "<f4" and len(raw.shape) == 3 and raw.shape[2] == 3
                and white.shape == raw.shape[:2] and raw.shape[0] % picture[0] == 0 == raw.shape[1] % picture[1]
                and raw.shape[0] // picture[0] == raw.shape[1] // picture[1]
                and headers["behind"].kind == "<i8" and not headers["behind"].shape
                and headers["microlenses"].kind == "<f8" and not headers["microlenses"].shape)
    light, coverage, moments = headers["light"], headers["coverage"], headers.get("moments")
    numbers = [header for name, header in headers.items() if name in ("reach", "fill")]
    return (light.kind in ("<f2", "<f4") and coverage.kind == light.kind and len(light.shape) == 5
            and min(light.shape[:2]) > 0 and light.shape[2] == 3
            and (light.shape[3:] == picture or _margin(light.shape, picture) is not None)
            and coverage.shape == (*light.shape[:2], *light.shape[3:])
            and all(header.kind == "<f8" and not header.shape for header in numbers)
            and (moments is None or moments.kind == light.kind and moments.shape[1:] == light.shape
                 and moments.shape[0] > 0))


def _of_views(data: dict[str, np.ndarray], settings: Settings) -> Recording:
    """The recording of these arrays; LightFieldError for numbers out of range."""
    reach, fill = float(data["reach"]), float(data.get("fill", 1.0))         # older files have no `fill`
    if not 0.0 < reach < 100.0 or fill > 1.0:
        raise lb.LightFieldError(f"reach {significant(reach)} and fill {significant(fill)}: this recording is damaged")
    of = camera(settings)
    margin = _margin(data["light"].shape, (settings.pixels_y, settings.pixels_x))
    field = lb.LightField(of if margin is None else widened(of, margin), reach, data["light"], data["coverage"], fill,
                          moments=data.get("moments"))
    return Recording(field if margin is None else of_wide(of, field), settings)


def _margin(shape: tuple[int, ...], picture: tuple[int, int]) -> tuple[int, int] | None:
    """Pixels across and down by which views of this shape surround a picture (h, w); None for other pixels."""
    (down, y), (across, x) = (divmod(size - FINER * inner, 2 * FINER)
                              for size, inner in zip(shape[3:], picture, strict=True))
    most = [size // WIDEST for size in picture]
    return (across, down) if x == y == 0 and 0 <= down <= most[0] and 0 <= across <= most[1] else None


def _of_sensor(data: dict[str, np.ndarray], settings: Settings) -> Recording:
    """The recording of these arrays; LightFieldError for numbers out of range."""
    raw, behind = data["raw"], int(data["behind"])
    if behind * settings.pixels_y != raw.shape[0]:
        raise lb.LightFieldError(f"{behind} pixels behind each microlens: this picture has others")
    plenoptic = lb.PlenopticCamera(camera(settings), behind, float(data["microlenses"]))
    picture = lb.RawPicture(plenoptic, raw, data["white"])
    return Recording(picture.decoded(), settings, picture)


ARRAYS = ("pictures", "nearness", "spacing", "distance")


def save_lumigraph(path: str | Path, lumigraph: lb.Lumigraph, settings: Settings) -> None:
    """Write a lumigraph and the settings of its capture; ExportError if they cannot be written."""
    save_arrays(path, settings, pictures=lumigraph.pictures, nearness=lumigraph.nearness, spacing=lumigraph.spacing,
                distance=lumigraph.distance)


def load_lumigraph(path: str | Path) -> tuple[lb.Lumigraph, Settings]:
    """Read a file of save_lumigraph. ExportError: missing, no lumigraph, incomplete; and errors of its lens file."""
    data, settings = load_arrays(Path(path), "lumigraph", "lightfield array",
                                  lambda names: set() if set(ARRAYS) - names else set(ARRAYS), _lumigraph_file_fit)
    pictures, nearness, spacing, distance = (data[name] for name in ARRAYS)
    if not min(float(spacing), float(distance)) > 0.0:
        raise ExportError(f"{path}: this lumigraph is damaged: its distances must be positive")
    middle = lb.lumigraph_pinhole(camera(settings))
    texels = np.empty((*nearness.shape, 4), np.float16)
    texels[..., :3], texels[..., 3] = np.moveaxis(pictures, 2, -1), nearness
    return lb.Lumigraph(middle, float(spacing), float(distance), texels), settings


def _lumigraph_file_fit(headers: Mapping[str, ArrayHeader], settings: Settings) -> bool:
    """Whether arrays of these headers are a lumigraph by these settings."""
    pictures, nearness = headers["pictures"], headers["nearness"]
    picture = (settings.pixels_y, settings.pixels_x)
    return (pictures.kind == nearness.kind == "<f2" and len(pictures.shape) == 5 and min(pictures.shape[:2]) > 0
            and pictures.shape[2:] == (3, *picture) and nearness.shape == (*pictures.shape[:2], *picture)
            and all(headers[name].kind == "<f8" and not headers[name].shape for name in ("spacing", "distance")))
