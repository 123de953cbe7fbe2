"""Photographs with a depth map: two files, or a phone's one, in JPEG or HEIC.

pillow-heif is an optional part (`pip install lensbench[heic]`), imported when the first HEIC file is read. It turns the
picture and its map upright. In a JPEG, a large map travels in extended XMP: base64 text in segments, each with its
offset. A property is an attribute or, in long hand, an element. The XML may declare no types and entities, so that
nothing in it is expanded. References: ITU-T H.265, annex G.14.2.3, depth representation information; Apple,
AVDepthData (disparities in 1/m); Google, Depthmap metadata; Adobe, XMP part 1, 7.4 and 7.9.2.2; part 3, 1.1.3.1.
"""

import base64
import binascii
import math
from pathlib import Path
from typing import Any, NamedTuple
from xml.parsers import expat

import numpy as np

import lensbench as lb
from lensbench.app.scenes.asset_files import MOST_BYTES, Textures, asset_path, image_of
from lensbench.app.scenes.sky_picture import EXR, HdrError, read_exr
from lensbench.app.scenes.table_values import Say, within
from lensbench.core.scenery.photograph import photograph_scene, reduced
from lensbench.core.text import excerpt, significant
from lensbench.lenses.file_error import open_regular
from lensbench.lenses.picture_file import MOST_PIXELS, PictureFileError, read_picture_file

UNEQUAL = 3             # levels of 255: rounding of a grey picture that is stored in colours
GAP = 0.05              # of the range of all other levels: below it, a level 0 belongs to them
ALONE = 0.1             # of the greatest level: where all others lie below, it is no distance
ENDLESS = 1e6           # programs store 1e10 m and the like where a ray meets nothing
HALF_END = 65504.0      # the greatest number of 16 bits: the same in such a file


def grey_levels(picture: Any) -> np.ndarray:
    """The levels (h, w) of a decoded picture of Pillow; SceneError for colours, whose order by distance is unknown."""
    if picture.mode in ("1", "L", "F") or picture.mode.startswith("I"):
        return np.asarray(picture)
    colours = np.asarray(picture.convert("RGB"))
    for other in (1, 2):
        check_equal(colours[..., 0], colours[..., other], UNEQUAL)
    return colours[..., 0]


def check_equal(one: np.ndarray, other: np.ndarray, tolerance: float) -> None:
    """SceneError where two channels of a depth map differ by more than the tolerance."""
    for a, b in zip(one, other, strict=True):               # row by row: the picture may be large
        if np.abs(a.astype(float) - b).max() > tolerance:
            raise lb.SceneError("its red, green and blue differ: colours have no order by distance. Save the distances "
                                "as one channel: grey of 16 bits in PNG, or OpenEXR")


def unmeasured(levels: np.ndarray, disparity: bool) -> np.ndarray:
    """Which levels (h, w) are no distance: NaN and what is not positive of floats, and 0 of integers, where all others
    lie apart from it. Not 0 of disparities: it is infinity there.
    """
    if levels.dtype.kind == "f":
        with np.errstate(invalid="ignore"):
            return ~(levels > 0.0) if not disparity else np.isnan(levels)
    zero = levels == 0
    if disparity or not zero.any() or zero.all():
        return np.zeros(levels.shape, bool)
    least, most = int(levels.min(where=~zero, initial=levels.max())), int(levels.max())
    return zero if most > least > GAP * (most - least) else np.zeros(levels.shape, bool)


def endless(levels: np.ndarray, hole: np.ndarray, alone: bool) -> np.ndarray:
    """Which levels (h, w) that are no holes stand for a ray that met nothing: floats of `ENDLESS` or `HALF_END`.

    alone: also the greatest level of more than 8 bits, where all others, of two values or more, lie far below it.
    """
    if levels.dtype.itemsize < 2:
        return np.zeros(levels.shape, bool)
    real = levels.dtype.kind == "f"
    is_endless = ~hole & ((levels >= ENDLESS) | (levels == HALF_END)) if real else np.zeros(levels.shape, bool)
    below = ~(hole | is_endless)
    if alone and below.any():
        least, most = (f(where=below, initial=levels[below][0]) for f in (levels.min, levels.max))
        top = below & (levels == most)
        second = levels.max(where=below & ~top, initial=least)
        if least < second < ALONE * most:
            is_endless |= top
    return is_endless


def filled(away: np.ndarray, hole: np.ndarray) -> np.ndarray:
    """Distances (h, w) whose holes take the value of the nearest neighbour in their row or column that has one."""
    away, known = away.copy(), ~hole
    while not known.all():
        nearest = np.full(away.shape, np.inf)
        values = away.copy()
        for flip, turn in ((1, False), (-1, False), (1, True), (-1, True)):
            there, has, to, best = (array.T[:, ::flip] if turn else array[:, ::flip]
                                    for array in (away, known, values, nearest))
            column = np.arange(there.shape[1])
            last = np.maximum.accumulate(np.where(has, column, -1), 1)
            closer = (last >= 0) & (column - last < best)
            to[closer] = np.take_along_axis(there, np.maximum(last, 0), 1)[closer]
            best[closer] = (column - last)[closer]
        away, known = values, np.isfinite(nearest)
    return away


EQUIVALENT, EXIF = 0xA405, 0x8769       # tags: focal length on 35 mm film, and the table where it stands
DIAGONAL = math.hypot(36.0, 24.0)


class PhonePhotograph(NamedTuple):
    """picture: linear. away (h, w): distances in mm, along the axis unless `radial`: along the ray. fov: radians across
    the picture, or None where the file does not state it.
    """

    picture: lb.Image
    away: np.ndarray
    radial: bool
    fov: float | None


def stated_fov(exif: Any, size: tuple[int, int], across: int) -> float | None:
    """Angle (radians) across a side of a picture of this size, by its focal length on 35 mm film; None without one."""
    try:
        equivalent = float(exif.get_ifd(EXIF).get(EQUIVALENT))
    except Exception:                   # none, or damaged notes: Pillow raises whatever they make Python raise
        return None
    if not 0.0 < equivalent < math.inf:
        return None
    return 2.0 * math.atan(DIAGONAL * across / math.hypot(*size) / (2.0 * equivalent))


INVERSE_DISTANCE, DISPARITY = 0, 1      # meanings of a map, by depth_representation_type
FARTHEST = 100_000.0                    # mm: where a disparity is that of infinity
SAME_SHAPE = 0.02                       # of the ratio of the sides: map and picture show the same view


def is_heic(head: bytes) -> bool:
    """Whether a file begins as those of the HEIF family."""
    return head[4:8] == b"ftyp"


def read_heic_photograph(path: Path, name: str) -> PhonePhotograph:
    """The photograph and the depth map of a HEIC file; SceneError in one line, which calls the file `name`."""
    what = f"photograph {excerpt(name)}"
    try:
        import pillow_heif
    except ImportError as error:
        raise lb.SceneError(f"{what} is a HEIC file, which needs pillow-heif: pip install lensbench[heic]") from error
    try:
        file = pillow_heif.open_heif(path)
        maps = file.info.get("depth_images")
        if not maps:
            raise lb.SceneError(f"{what} carries no depth map: take it as a portrait, or name a map as depth")
        if max(math.prod(file.size), math.prod(maps[0].size)) > MOST_PIXELS or min(*file.size, *maps[0].size) < 2:
            raise lb.SceneError(f"{what} has {file.size[0]} × {file.size[1]} pixels")
        picture, coded = file.to_pillow(), maps[0].to_pillow()
    except (OSError, ValueError, EOFError, RuntimeError, SyntaxError, MemoryError) as error:
        if isinstance(error, lb.SceneError):
            raise
        raise lb.SceneError(f"{what}: its picture or its depth map cannot be read") from error
    levels: Any = reduced(within(what, grey_levels, coded))
    shares = levels / (65535.0 if levels.dtype == np.uint16 else 255.0)
    if abs(picture.width * shares.shape[0] / (picture.height * shares.shape[1]) - 1.0) > SAME_SHAPE:
        raise lb.SceneError(f"{what}: its depth map, {shares.shape[1]} × {shares.shape[0]}, has another shape than its "
                            f"picture, {picture.width} × {picture.height}")
    away = _heic_depth_distances(maps[0].info.get("metadata") or {}, shares, what)
    fov = stated_fov(picture.getexif(), picture.size, picture.width)
    return PhonePhotograph(image_of(picture), away, False, fov)


def _heic_depth_distances(meaning: dict[str, Any], shares: np.ndarray, what: str) -> np.ndarray:
    """Distances (mm) of a map whose values lie in [0, 1], 1 the nearest."""
    kind = meaning.get("representation_type")
    if kind == DISPARITY and "d_min" in meaning and "d_max" in meaning:
        low, high = float(meaning["d_min"]), float(meaning["d_max"])
    elif kind == INVERSE_DISTANCE and meaning.get("z_near") and meaning.get("z_far"):
        low, high = 1.0 / float(meaning["z_far"]), 1.0 / float(meaning["z_near"])
    else:
        raise lb.SceneError(f"{what}: its depth map does not state its distances: save it as PNG, and name it as depth "
                            "with near and far")
    if not (math.isfinite(low) and math.isfinite(high) and high > max(low, 1000.0 / FARTHEST)):
        raise lb.SceneError(f"{what}: its depth map goes from {significant(low, 3)} to {significant(high, 3)} /m")
    return 1000.0 / np.maximum(low + shares * (high - low), 1000.0 / FARTHEST)


MOST_PHONE_BYTES = 64 << 20           # of a photograph: its texts are held several times
XMP, EXTENDED = b"http://ns.adobe.com/xap/1.0/\0", b"http://ns.adobe.com/xmp/extension/\0"
SPACES = ("GDepth:", "GImage:")
ORIENTATION = 0x0112            # tag
UNREADABLE = ("of phones, JPEG files with a GDepth map and HEIC portraits are read; Apple's portraits in JPEG and "
              "Dynamic Depth are not: save the map as PNG, and name it as depth")


def carries_depth(path: Path) -> bool:
    """Whether a file is to be read as a phone's photograph with its own depth map; OSError."""
    with open_regular(path) as file:
        data = file.read(MOST_PHONE_BYTES)
    return is_heic(data[:12]) or data.startswith(b"\xff\xd8") and b"GDepth:" in data


def read_phone_photograph(name: str, folder: Path) -> PhonePhotograph:
    """A photograph of a phone with the depth map in its file, turned upright; SceneError in one line."""
    path = asset_path(name, folder, "photograph", MOST_PHONE_BYTES)
    with open_regular(path) as file:
        data = file.read()
    if is_heic(data[:12]):
        return read_heic_photograph(path, name)
    try:
        properties = _attributes(data)
        if not properties.get("GDepth:Data"):
            raise lb.SceneError(f"it carries no depth map; {UNREADABLE}")
        exif = read_picture_file(data, upright=False).getexif()
        sharp = properties.pop("GImage:Data", "")            # where there is one
        picture = read_picture_file(_decoded(sharp) if sharp else data, upright=False)
        image, size = image_of(picture), picture.size
        coded = reduced(grey_levels(read_picture_file(_decoded(properties.pop("GDepth:Data")), upright=False)))
    except (PictureFileError, expat.ExpatError, binascii.Error, lb.SceneError) as error:
        raise lb.SceneError(f"photograph {excerpt(name)}: {error}") from error
    shares = coded / (65535.0 if coded.dtype.itemsize > 1 else 255.0)
    away = _phone_depth_distances(properties, shares, name)
    turn = exif.get(ORIENTATION, 1)
    fov = stated_fov(exif, size, size[1] if turn in (5, 6, 7, 8) else size[0])
    upright = lb.Image.of(_turned(image.values, turn))
    return PhonePhotograph(upright, _turned(away, turn), properties.get("GDepth:MeasureType") == "OpticRay", fov)


def _attributes(data: bytes) -> dict[str, str]:
    """The attributes of GDepth and GImage in the XMP segments of a JPEG file; ExpatError for damaged ones."""
    plain, pieces, position = b"", list[tuple[int, bytes]](), 2
    while position + 4 <= len(data) and data[position] == 0xFF and data[position + 1] not in (0xDA, 0xD9):
        length = int.from_bytes(data[position + 2:position + 4], "big")
        body = data[position + 4:position + 2 + length]
        if data[position + 1] == 0xE1 and body.startswith(XMP):
            plain = plain or body[len(XMP):]
        elif data[position + 1] == 0xE1 and body.startswith(EXTENDED) and len(body) > len(EXTENDED) + 40:
            head = len(EXTENDED) + 32                       # behind the digest that names the packet
            pieces.append((int.from_bytes(body[head + 4:head + 8], "big"), body[head + 8:]))
        position += 2 + max(length, 2)
    extended = b"".join(piece for _, piece in sorted(pieces, key=lambda piece: piece[0]))
    return _properties(plain) | _properties(extended)


def _properties(packet: bytes) -> dict[str, str]:
    """The texts of the properties of GDepth and GImage in a packet of XMP, by name; ExpatError where it is damaged."""
    properties: dict[str, list[str]] = {}
    inside: list[str] = []                              # elements from the root to the current one

    def start(name: str, attributes: dict[str, str]) -> None:
        inside.append(name)
        properties.update({key: [value] for key, value in attributes.items() if key.startswith(SPACES)})
        if name.startswith(SPACES):
            properties[name] = []

    def add(text: str) -> None:
        if inside and inside[-1].startswith(SPACES):
            properties[inside[-1]].append(text)

    def refuse(*_: Any) -> None:
        raise lb.SceneError("its XMP declares types of its own: it is not read")

    parser = expat.ParserCreate()
    parser.buffer_text = True
    parser.StartElementHandler, parser.EndElementHandler = start, lambda name: inside.pop()
    parser.CharacterDataHandler, parser.StartDoctypeDeclHandler = add, refuse
    if packet.strip(b" \0\t\r\n"):
        parser.Parse(packet.rstrip(b"\0"), True)
    return {name: "".join(texts).strip() for name, texts in properties.items()}


def _decoded(text: str) -> bytes:
    """The bytes of base64 text; binascii.Error where it is none."""
    return base64.b64decode("".join(text.split()), validate=True)


def _phone_depth_distances(properties: dict[str, str], shares: np.ndarray, name: str) -> np.ndarray:
    """Distances (mm) of a map whose values lie in [0, 1], 0 the nearest."""
    form, unit = properties.get("GDepth:Format", ""), properties.get("GDepth:Units", "m")
    try:
        near, far = (float(properties[f"GDepth:{which}"]) * {"m": 1000.0, "mm": 1.0}[unit] for which in ("Near", "Far"))
    except (KeyError, ValueError) as error:
        raise lb.SceneError(f"photograph {excerpt(name)}: its depth map has no Near and Far in m or mm") from error
    if not 0.0 < near < far < math.inf:
        raise lb.SceneError(f"photograph {excerpt(name)}: its depth map goes from {significant(near)} mm to "
                            f"{significant(far)} mm")
    if form == "RangeInverse":
        return far * near / (far - shares * (far - near))
    if form == "RangeLinear":
        return near + shares * (far - near)
    raise lb.SceneError(f"photograph {excerpt(name)}: its depth map has the format {excerpt(form)}, "
                        "neither RangeInverse nor RangeLinear")


def _turned(rows: np.ndarray, orientation: int) -> np.ndarray:
    """A picture (h, w, …), turned upright by its EXIF orientation."""
    if orientation in (5, 6, 7, 8):
        rows = rows.swapaxes(0, 1)
    if orientation in (2, 3, 6, 7):
        rows = rows[:, ::-1]
    return rows[::-1] if orientation in (3, 4, 7, 8) else rows


MOST_AWAY = 1e8 / 4.0       # mm: a mesh reaches 100 km, and what has no end lies four times behind all others
MEANINGS = ("distance", "disparity")


def read_photograph(image: str, depth: str, folder: Path, fov: float, meaning: str, near: float | None,
                    far: float | None, fill: str, holes: bool, say: Say) -> lb.Scene:
    """The scene of a photograph and its depth map, in the folder of the scene file; SceneError in one line.

    meaning: "distance", the map grows with the distance, or "disparity", with its inverse, as phones store it. near,
    far (mm): the least and the greatest distance of the map; None: an EXR map in metres. fov: radians, across. holes:
    whether pixels without a distance are looked for. say receives a sentence for each kind that was replaced.
    """
    if meaning not in MEANINGS:
        raise lb.SceneError(f"depth_is {excerpt(meaning)}: choose one of {', '.join(MEANINGS)}")
    levels = _levels(depth, folder)
    metric = near is None or far is None
    if metric and (meaning == "disparity" or levels.dtype.kind != "f"):
        raise lb.SceneError("near and far are missing: the distances of the least and greatest distance of the map")
    if near is not None and far is not None and not 0.0 < near < far:
        raise lb.SceneError("near must be positive and less than far")
    if far is not None and far > MOST_AWAY:
        raise lb.SceneError(f"far is {significant(far / 1e6)} km: write at most {significant(MOST_AWAY / 1e6)} km, at "
                            "which all that lies behind looks the same")
    name = f"depth map {excerpt(depth)}"
    away = within(name, _depth_map_distances, levels, meaning, None if metric else (near, far), holes,
                  lambda text: say(f"{name}: {text}"))
    return photograph_scene(Textures(folder).read(image).values, away, fov, fill=fill, name=Path(image).stem)


def _depth_map_distances(levels: np.ndarray, meaning: str, ends: tuple[float, float] | None, holes: bool, say: Say
               ) -> np.ndarray:
    """Distances (mm) of the levels of a map, reduced. ends: the least and the greatest of them; None: levels in m."""
    disparity = meaning == "disparity"
    hole = unmeasured(levels, disparity) if holes or levels.dtype.kind == "f" else np.zeros(levels.shape, bool)
    doubtful = ends is not None or levels.max(where=~hole, initial=0) > MOST_AWAY / 1000.0
    beyond = np.zeros(levels.shape, bool) if disparity else endless(levels, hole, holes and bool(doubtful))
    known = ~(hole | beyond)
    if not known.any():
        raise lb.SceneError("none of its pixels holds a distance")
    low, high = (float(f(where=known, initial=levels[known][0])) for f in (levels.min, levels.max))
    shares = [100.0 * float(heights.mean()) for heights in (hole, beyond)]
    levels, hole, beyond = reduced(levels), reduced(hole), reduced(beyond)
    if ends is None and high * 1000.0 > MOST_AWAY:
        raise lb.SceneError(f"it reaches {significant(high / 1000.0)} km as metres, more than "
                            f"{significant(MOST_AWAY / 1e6)} km: give near and far, its least and greatest distance")
    if ends is None:
        away = levels.astype(np.float64) * 1000.0
    elif not (math.isfinite(high) and high > low):
        raise lb.SceneError("it has one value only")
    else:
        near, far = ends
        heights = np.clip((levels.astype(np.float64) - low) / (high - low), 0.0, 1.0)
        away = 1.0 / (1.0 / far + heights * (1.0 / near - 1.0 / far)) if disparity else near + heights * (far - near)
    if shares[0]:
        say(f"{significant(shares[0], 2)} % of the pixels hold no distance (0, negative or NaN) and take the one of a "
            "neighbour; if 0 is a distance, write holes = false")
    if shares[1]:
        say(f"{significant(shares[1], 2)} % of the pixels have the level of what has no end, far above all others, and "
            "are laid behind them")
    return filled(np.where(beyond, np.inf, away), hole)


def own_depth_scene(image: str, folder: Path, fov: float | None, fill: str) -> lb.Scene:
    """The scene of a phone's photograph with its own map; fov: radians across, None: as it states. SceneError."""
    photograph = read_phone_photograph(image, folder)
    fov = fov or photograph.fov
    if fov is None:
        raise lb.SceneError(f"photograph {excerpt(image)} does not state its focal length on 35 mm film: give fov, the "
                            "angle across it")
    away = photograph.away
    if photograph.radial and 0.0 < fov < math.pi:            # along the ray, not along the axis
        rows, columns = away.shape
        half = math.tan(fov / 2.0)
        x, y = ((2.0 * np.arange(n) + 1.0) / n - 1.0 for n in (columns, rows))
        away = away / np.sqrt(1.0 + (half * x) ** 2 + ((half * rows / columns) * y[:, None]) ** 2)
    return photograph_scene(photograph.picture.values, away, fov, fill=fill, name=Path(image).stem)


def _levels(name: str, folder: Path) -> np.ndarray:
    """The numbers (h, w) of a depth map; SceneError where they cannot be read, or are colours."""
    path = asset_path(name, folder, "depth map", MOST_BYTES)
    try:
        with open_regular(path) as file:
            is_exr = file.read(4) == EXR
        if not is_exr:
            return grey_levels(read_picture_file(path, real=True))
        channels = read_exr(path, (("Z",), ("Y",), ("R", "G", "B"), ("R",)))
        for other in channels[1:]:
            check_equal(channels[0], other, 0.0)
        return channels[0]
    except (HdrError, PictureFileError, lb.SceneError, OSError, MemoryError) as error:
        raise lb.SceneError(f"depth map {excerpt(name)}: {getattr(error, 'strerror', None) or error}") from error
