"""Scenes of one's own, from a TOML file: docs/scenes.md shows one.

Lengths are mm, or text with a unit ("1.2 m"); angles are degrees; colours are
linear numbers, or "#rrggbb" as in sRGB; speeds mm/s, or text ("50 km/h"), and turning degrees a
second. A texture is a file beside or below the
scene file, never elsewhere.
"""

import difflib
import math
import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

import lensbench as lb
from lensbench.app.state.file_cache import Stamp, file_stamp, keeps_last_good
from lensbench.app.state.tone import linear
from lensbench.scenery.objects import by_family

MOST_BYTES = 1 << 20                    # of a scene file
MOST_TEXTURE_BYTES = 64 << 20
MOST_TEXELS = 40_000_000                # of a texture as it is read
TEXTURE_SIDE = 1024                     # larger ones are averaged down to this
MOST_OBJECTS = 2000
UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "km": 1e6, "": 1.0}
SPEEDS = {"mm/s": 1.0, "cm/s": 10.0, "m/s": 1000.0, "km/h": 1e6 / 3600.0, "": 1.0}
MOTION = ("velocity", "spin", "pivot")
FORMATS = ("PNG", "JPEG", "TIFF", "WEBP", "BMP")

Table = dict[str, Any]


class SceneFileError(ValueError):
    """A scene file that cannot be read: where, and what to do about it."""

    def __init__(self, path: str | Path, reason: str):
        super().__init__(f"{path}: {reason}")
        self.path, self.reason = Path(path), reason


class _ContentError(Exception):
    """Fault in the content of a scene file; the caller adds the path."""


def find_scene(name_or_path: str) -> lb.Scene:
    """A built-in scene by its name, or else the scene of a file; SceneFileError where there is neither."""
    if name_or_path in lb.SCENES:
        return lb.builtin_scene(name_or_path)
    if not name_or_path.endswith(".toml") and not Path(name_or_path).exists():
        near = difflib.get_close_matches(name_or_path, lb.SCENES, 1)
        raise SceneFileError(name_or_path, "no built-in scene has this name, and no file"
                             + (f"; did you mean {near[0]}?" if near else f": choose one of {', '.join(lb.SCENES)}"))
    return load_scene(name_or_path)


def cached_scene(name_or_path: str) -> lb.Scene:
    """As find_scene, for callers in every frame: a file is read again only when it or a texture of it has changed."""
    return _cached(name_or_path, scene_stamp(name_or_path))


@keeps_last_good(4)
def _cached(name_or_path: str, stamp: tuple[Stamp, ...]) -> lb.Scene:
    return find_scene(name_or_path)


def scene_stamp(name_or_path: str) -> tuple[Stamp, ...]:
    """The stamps of a scene file and of its textures; none for a built-in scene, which no file replaces."""
    if name_or_path in lb.SCENES:
        return ()
    own = file_stamp(name_or_path)
    return own, *map(file_stamp, _textures(name_or_path, own) if any(own) else ())


@lru_cache(maxsize=4)
def _textures(path: str, stamp: Stamp) -> tuple[Path, ...]:
    """The texture files that a scene file names, as far as it can be read."""
    try:
        table = tomllib.loads(Path(path).read_bytes()[:MOST_BYTES].decode("utf-8"))
    except (OSError, ValueError, RecursionError):
        return ()
    found: list[Path] = []

    def collect(value: Any) -> None:
        if isinstance(value, dict):
            if isinstance(name := value.get("texture"), str):
                found.append(Path(path).parent / name)
            for part in value.values():
                collect(part)
        elif isinstance(value, list):
            for part in value:
                collect(part)

    collect(table)
    return tuple(dict.fromkeys(found))


def load_scene(path: str | Path) -> lb.Scene:
    """Read a scene file (TOML, at most 1 MB); SceneFileError describes the fault in one line."""
    path = Path(path)
    if path.exists() and not path.is_file():
        raise SceneFileError(path, "is not a file")
    try:
        with path.open("rb") as file:
            raw = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise SceneFileError(path, f"cannot be read: {error.strerror or error}") from error
    if len(raw) > MOST_BYTES:
        raise SceneFileError(path, "is larger than 1 MB: that is no scene file")
    try:
        table = tomllib.loads(raw.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise SceneFileError(path, "is not text: a scene file is TOML") from error
    except (ValueError, RecursionError) as error:
        raise SceneFileError(path, f"is not TOML: {error}") from error
    try:
        return _scene(table, path)
    except (_ContentError, lb.SceneError) as error:
        raise SceneFileError(path, str(error)) from error


# The whole

def _scene(table: Table, path: Path) -> lb.Scene:
    _only(table, "the file", ("name", "ambient", "enclosed", "depth_range", "material", *_SURROUNDINGS, *_SHAPES))
    folder = path.resolve().parent
    materials = {name: _within(f"material {name}", _material, _table(value, f"material {name}"), folder)
                 for name, value in _table(table.get("material", {}), "material").items()}
    lists = {kind: _tables(table, kind) for kind in _SHAPES}
    if sum(map(len, lists.values())) > MOST_OBJECTS:
        raise _ContentError(f"has more than {MOST_OBJECTS} objects")
    if not any(lists.values()) and "floor" not in table:
        known = ", ".join(f"[[{kind}]]" for kind in _SHAPES)
        raise _ContentError(f"shows nothing: give it a [floor] or one of {known}")

    shapes = [_within(f"{kind} {k + 1}", _SHAPES[kind], value, folder, materials)
              for kind, entries in lists.items() for k, value in enumerate(entries)]
    spheres, planar = by_family(shapes)
    values: Table = {"spheres": tuple(spheres), "plates": tuple(planar)}
    for kind, read in _SURROUNDINGS.items():
        if kind in table:
            values[kind] = _within(kind, read, _table(table[kind], kind))
    if "ambient" in table:
        values["ambient"] = _colour(table, "ambient", most=math.inf)
    if "depth_range" in table:
        near, far = _numbers(table, "depth_range", 2, _length)
        if not 0.0 < near < far:
            raise _ContentError("depth_range: the first distance must be positive and less than the second")
        values["depth_range"] = (near, far)
    return lb.Scene(_text(table, "name", path.stem), enclosed=_truth(table, "enclosed"), **values)


def _sky(t: Table) -> lb.Sky:
    _only(t, "sky", ("zenith", "horizon", "ground", "up"))
    values: Table = {name: _colour(t, name, most=math.inf) for name in ("zenith", "horizon", "ground") if name in t}
    return lb.Sky(**values, **_vector(t, "up"))


def _sun(t: Table) -> lb.Sun:
    _only(t, "sun", ("direction", "colour", "angular_radius"))
    values: Table = {"colour": _colour(t, "colour", most=math.inf)} if "colour" in t else {}
    if "angular_radius" in t:
        values["angular_radius"] = math.radians(_number(t["angular_radius"], "angular_radius"))
    return lb.Sun(**_vector(t, "direction", needed=True), **values)


def _floor(t: Table) -> lb.Floor:
    _only(t, "floor", ("height", "tile", "light", "dark", "gloss", "normal", "turn", "offset"))
    values: Table = {name: _length(t[name], name) for name in ("height", "tile") if name in t}
    values |= {name: _colour(t, name) for name in ("light", "dark") if name in t}
    if "gloss" in t:
        values["gloss"] = _number(t["gloss"], "gloss")
    if "turn" in t:
        values["turn"] = math.radians(_number(t["turn"], "turn"))
    if "offset" in t:
        values["offset"] = _numbers(t, "offset", 2, _number)
    return lb.Floor(**values, **_vector(t, "normal"))


# Objects

def _sphere(t: Table, folder: Path, materials: dict[str, lb.Material]) -> lb.Sphere:
    _only(t, "a sphere", ("centre", "radius", "material", *MOTION))
    return lb.Sphere(_point(t, "centre"), _length(_needed(t, "radius"), "radius"), _of(t, folder, materials),
                     **_motion(t))


def _rectangle(t: Table, folder: Path, materials: dict[str, lb.Material]) -> lb.Rectangle:
    material = _of(t, folder, materials)
    if "target" in t:
        _only(t, "a rectangle with a target", ("centre", "target", "width", "height", "material", *MOTION))
        width, height = (_length(_needed(t, name), name) for name in ("width", "height"))
        if not (width > 0.0 and height > 0.0):
            raise _ContentError("width and height must be positive")
        if _point(t, "centre") == _point(t, "target"):
            raise _ContentError("the target lies in the centre of the rectangle")
        return replace(lb.Rectangle.facing(_point(t, "centre"), _point(t, "target"), width, height, material),
                       **_motion(t))
    _only(t, "a rectangle", ("centre", "right", "up", "material", *MOTION))
    return lb.Rectangle(_point(t, "centre"), _point(t, "right"), _point(t, "up"), material, **_motion(t))


def _disk(t: Table, folder: Path, materials: dict[str, lb.Material]) -> lb.Disk:
    _only(t, "a disk", ("centre", "normal", "radius", "material", *MOTION))
    return lb.Disk(_point(t, "centre"), _vector(t, "normal", needed=True)["normal"],
                   _length(_needed(t, "radius"), "radius"), _of(t, folder, materials), **_motion(t))


# What a scene file may hold: the reader of each table. A new shape is one row
_SURROUNDINGS: dict[str, Callable[[Table], Any]] = {"sky": _sky, "sun": _sun, "floor": _floor}
_SHAPES: dict[str, Callable[..., Any]] = {"sphere": _sphere, "rectangle": _rectangle, "disk": _disk}


def _motion(t: Table) -> Table:
    """The given ones of velocity, spin and pivot."""
    values: Table = {}
    if "velocity" in t:
        values["velocity"] = _numbers(t, "velocity", 3, _speed)
    if "spin" in t:
        values["spin"] = tuple(math.radians(rate) for rate in _numbers(t, "spin", 3, _number))
    if "pivot" in t:
        values["pivot"] = _point(t, "pivot")
    return values


def _of(t: Table, folder: Path, materials: dict[str, lb.Material]) -> lb.Material:
    """The material of an object: the name of one, or a table; matte grey where none is given."""
    value = t.get("material", {})
    if not isinstance(value, str):
        return _material(_table(value, "material"), folder)
    if value not in materials:
        raise _ContentError(f"material {value!r} is not in the file: write a table [material.{value}]")
    return materials[value]


def _material(t: Table, folder: Path) -> lb.Material:
    _only(t, "a material", ("kind", "colour", "gloss", "pattern", "texture"))
    kind = _text(t, "kind", "matte")
    shines = kind in ("light", "lamp")
    values: Table = {"kind": kind}
    if "texture" in t:
        if "pattern" in t:
            raise _ContentError("a material has a pattern or a texture, not both")
        values["pattern"] = lb.Pattern("image", image=_texture(_text(t, "texture"), folder))
        values["colour"] = (1.0, 1.0, 1.0)
    if "colour" in t:
        values["colour"] = _colour(t, "colour", most=math.inf if shines else 1.0)
    if "gloss" in t:
        values["gloss"] = _number(t["gloss"], "gloss")
    if "pattern" in t:
        values["pattern"] = _pattern(_table(t["pattern"], "pattern"), math.inf if shines else 1.0)
    return lb.Material(**values)


def _pattern(t: Table, most: float) -> lb.Pattern:
    _only(t, "a pattern", ("kind", "colour", "columns", "rows", "line"))
    kind = _text(t, "kind")
    if kind == "image":
        raise _ContentError('an image is given as texture = "file.png"')
    values: Table = {name: _number(t[name], name) for name in ("columns", "rows") if name in t}
    if "line" in t:
        values["line"] = _length(t["line"], "line")
    if "colour" in t:
        values["colour"] = _colour(t, "colour", most=most)
    return lb.Pattern(kind, **values)


def _texture(name: str, folder: Path) -> lb.Image:
    """An image file in the folder of the scene or below it, linear, at most TEXTURE_SIDE texels long."""
    from PIL import Image as Picture

    if Path(name).is_absolute() or "\0" in name:
        raise _ContentError(f"texture {name!r}: name it relative to the scene file")
    try:
        path = (folder / name).resolve(strict=True)
    except (OSError, RuntimeError) as error:
        raise _ContentError(f"texture {name!r}: there is no such file") from error
    if not path.is_relative_to(folder):
        raise _ContentError(f"texture {name!r} lies outside the folder of the scene: put it beside the file or below")
    if not path.is_file():
        raise _ContentError(f"texture {name!r} is not a file")
    if path.stat().st_size > MOST_TEXTURE_BYTES:
        raise _ContentError(f"texture {name!r} is larger than {MOST_TEXTURE_BYTES >> 20} MB")
    try:
        with Picture.open(path, formats=FORMATS) as picture:
            if picture.width * picture.height > MOST_TEXELS:
                raise _ContentError(f"texture {name!r} has more than {MOST_TEXELS // 1_000_000} million pixels")
            if picture.width < 2 or picture.height < 2:
                raise _ContentError(f"texture {name!r} is smaller than 2 × 2 pixels")
            if picture.mode.startswith("I"):
                values = np.asarray(picture, np.float32)[..., None].repeat(3, 2) / 65535.0
            else:
                values = np.asarray(picture.convert("RGB"), np.float32) / 255.0
    except (OSError, SyntaxError, ValueError, Picture.DecompressionBombError) as error:
        raise _ContentError(f"texture {name!r} is not a picture that can be read ({', '.join(FORMATS)})") from error
    light = linear(values)
    shrink = TEXTURE_SIDE / max(light.shape[:2])
    if shrink < 1.0:
        size = tuple(max(2, round(side * shrink)) for side in (light.shape[1], light.shape[0]))
        bands = [Picture.fromarray(np.ascontiguousarray(light[..., c])).resize(size, Picture.Resampling.BOX)
                 for c in range(3)]
        light = np.stack([np.asarray(band) for band in bands], -1)
    return lb.Image.of(light)


# Values, each with an error that names it

def _within(where: str, make: Callable, *values: Any) -> Any:
    """make(*values); `where` precedes the message of its errors."""
    try:
        return make(*values)
    except (_ContentError, lb.SceneError) as error:
        raise _ContentError(f"{where}: {error}") from error


def _only(t: Table, what: str, known: tuple[str, ...]) -> None:
    for name in t:
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            raise _ContentError(f"{what} has no {name!r}"
                         + (f": did you mean {near[0]}?" if near else f" (known: {', '.join(known)})"))


def _needed(t: Table, name: str) -> Any:
    if name not in t:
        raise _ContentError(f"{name} is missing")
    return t[name]


def _table(value: Any, name: str) -> Table:
    if not isinstance(value, dict):
        raise _ContentError(f"{name} must be a table")
    return value


def _tables(t: Table, name: str) -> list[Table]:
    value = t.get(name, [])
    if not isinstance(value, list):
        raise _ContentError(f"{name}: write [[{name}]], with two brackets, for every {name}")
    return [_table(entry, name) for entry in value]


def _text(t: Table, name: str, default: str | None = None) -> str:
    value = t.get(name, default) if default is not None else _needed(t, name)
    if not isinstance(value, str):
        raise _ContentError(f"{name} must be text in quotation marks")
    return value


def _truth(t: Table, name: str) -> bool:
    value = t.get(name, False)
    if not isinstance(value, bool):
        raise _ContentError(f"{name} must be true or false")
    return value


def _number(value: Any, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise _ContentError(f"{name} must be a number, not {value!r}")
    if not abs(value) <= 1e9:
        raise _ContentError(f"{name} is {value}: it must be a finite number, at most 1e9")
    return float(value)


def _length(value: Any, name: str) -> float:
    """In mm: a number, or text with a unit."""
    return _quantity(value, name, UNITS, "a length as a number of mm, or as \"1.2 m\" (mm, cm, m, km)")


def _speed(value: Any, name: str) -> float:
    """In mm/s: a number, or text with a unit."""
    return _quantity(value, name, SPEEDS, "a speed as a number of mm/s, or as \"50 km/h\" (mm/s, cm/s, m/s, km/h)")


def _quantity(value: Any, name: str, units: dict[str, float], form: str) -> float:
    if not isinstance(value, str):
        return _number(value, name)
    match = re.fullmatch(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?)\s*([a-z/]*)\s*", value)
    if match is None or match[2] not in units:
        raise _ContentError(f"{name} {value!r}: write {form}")
    return _number(float(match[1]) * units[match[2]], name)


def _numbers(t: Table, name: str, count: int, read: Callable[[Any, str], float]) -> tuple[float, ...]:
    value = _needed(t, name)
    if not (isinstance(value, list) and len(value) == count):
        raise _ContentError(f"{name} must be a list of {count} numbers")
    return tuple(read(entry, name) for entry in value)


def _point(t: Table, name: str) -> tuple[float, float, float]:
    x, y, z = _numbers(t, name, 3, _length)
    return x, y, z


def _vector(t: Table, name: str, needed: bool = False) -> Table:
    """{name: direction}, or nothing where it is not given."""
    if name not in t and not needed:
        return {}
    x, y, z = _numbers(t, name, 3, _number)
    return {name: (x, y, z)}


def _colour(t: Table, name: str, most: float = 1.0) -> tuple[float, float, float]:
    """Linear: three numbers, or "#rrggbb" as in sRGB."""
    value = t[name]
    if isinstance(value, str):
        if not re.fullmatch(r"#[0-9a-fA-F]{6}", value):
            raise _ContentError(f"{name} {value!r}: write a colour as \"#rrggbb\" or as three linear numbers")
        r, g, b = (float(x) for x in linear(np.array([int(value[k:k + 2], 16) / 255.0 for k in (1, 3, 5)])))
    else:
        r, g, b = _numbers(t, name, 3, _number)
    if min(r, g, b) < 0.0 or max(r, g, b) > most:
        raise _ContentError(f"{name}: its numbers must lie between 0 and 1" if most == 1.0 else
                     f"{name}: its numbers cannot be negative")
    return r, g, b
