"""Scenes of users, from a TOML file: docs/scenes.md shows one.

Lengths are mm, or text with a unit ("1.2 m"); angles are degrees; colours are linear numbers, or "#rrggbb" as in sRGB;
speeds are mm/s, or text ("50 km/h"); rotations are degrees a second. A texture, mesh or sky is a file next to or
below the scene file, never elsewhere.
"""

import difflib
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import lensbench as lb
from lensbench.app.scenes.asset_files import Stamp, Textures, file_stamp, keeps_last_good
from lensbench.app.scenes.mesh_file import MM, Pose, read_mesh, rotation
from lensbench.app.scenes.photograph import own_depth_scene, read_photograph
from lensbench.app.scenes.sky_picture import read_sky, read_texture
from lensbench.app.scenes.table_values import (
    MOTION, Reader, Say, Table, angle, as_table, as_tables, colour, fields_of, given, length, light, number, numbers,
    only, point, text, truth, unit, vector, within
)
from lensbench.core.scenery.families import by_field
from lensbench.core.scenery.intersect.triangle_tree import MOST_TRIANGLES
from lensbench.core.scenery.scene import Framing
from lensbench.core.text import LONGEST_PATH, cut, escaped, excerpt, significant
from lensbench.lenses.file_error import open_regular

MOST_BYTES = 1 << 20                    # of a scene file
MOST_OBJECTS = 2000
SHIPPED = Path(__file__).parent / "shipped"


class SceneFileError(ValueError):
    """A scene file that cannot be read: where, and what to do about it."""

    def __init__(self, path: str | Path, reason: str):
        self.path, self.reason = Path(path), escaped(reason)
        super().__init__(f"{cut(escaped(str(path)), LONGEST_PATH)}: {self.reason}")


def find_scene(name_or_path: str) -> lb.Scene:
    """A built-in scene by its name, or else the scene of a file; SceneFileError where there is neither."""
    if name_or_path in lb.SCENES:
        return lb.builtin_scene(name_or_path)
    if not name_or_path.endswith(".toml") and not _exists(name_or_path):
        near = difflib.get_close_matches(name_or_path, lb.SCENES, 1)
        raise SceneFileError(name_or_path, "no built-in scene has this name, and no file"
                             + (f"; did you mean {near[0]}?" if near else "; lensbench scenes lists the names"))
    return load_scene(name_or_path)


def _exists(path: str) -> bool:
    try:
        return Path(path).exists()
    except (OSError, ValueError):               # a name too long, or with a NUL in it
        return False


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


def scene_files(name_or_path: str) -> tuple[Path, ...]:
    """The scene file and the files that it names; none for a built-in scene."""
    if name_or_path in lb.SCENES:
        return ()
    return Path(name_or_path), *_textures(name_or_path, file_stamp(name_or_path))


@lru_cache(maxsize=4)
def _textures(path: str, stamp: Stamp) -> tuple[Path, ...]:
    """The files that a scene file names, as far as it can be read."""
    try:
        with open_regular(path) as file:
            table = tomllib.loads(file.read(MOST_BYTES).decode("utf-8"))
    except (OSError, ValueError, RecursionError):
        return ()
    return tuple(dict.fromkeys(Path(path).parent / name for name in _texture_names(table)))


def _texture_names(value: Any) -> Iterator[str]:
    if isinstance(value, dict):
        yield from (value[key] for key in ("texture", "image", "file", "depth") if isinstance(value.get(key), str))
    for item in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from _texture_names(item)


def shipped_scene(name: str) -> lb.Scene:
    """A scene that lensbench ships as a file, by its name."""
    return load_scene(SHIPPED / f"{name}.toml")


def load_scene(path: str | Path) -> lb.Scene:
    """Read a scene file (TOML, at most 1 MB); SceneFileError describes the fault in one line."""
    path = Path(path)
    try:
        with open_regular(path) as file:
            raw = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise SceneFileError(path, f"cannot be read: {error.strerror or error}") from error
    if len(raw) > MOST_BYTES:
        raise SceneFileError(path, "is larger than 1 MB: not a scene file")
    try:
        table = tomllib.loads(raw.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise SceneFileError(path, "is not text: a scene file is TOML") from error
    except (ValueError, RecursionError) as error:
        raise SceneFileError(path, f"is not TOML: {error}") from error
    try:
        return _scene(table, path)
    except lb.SceneError as error:
        raise SceneFileError(path, str(error)) from error


# The whole

def _scene(table: Table, path: Path) -> lb.Scene:
    textures, notes = Textures(path.resolve().parent), list[str]()
    names = ("name", "ambient", "enclosed", "depth_range", "diffuse_bounce", "subject", "framing", "exposure",
             "summary", "material", "mesh", "photograph", *_SURROUNDINGS, *_SHAPES)
    for name, what in (("surfaces", "a lens file"), ("version", "a settings file")):
        if name in table:
            raise lb.SceneError(f"this is {what}: a scene file is TOML that holds {', '.join(names)}")
    only(table, "a scene file", names)
    materials = {name: within(f"material {cut(name)}", _material, as_table(value, f"material {cut(name)}"), textures)
                 for name, value in as_table(table.get("material", {}), "material").items()}
    if "photograph" in table:
        scene = within("photograph", _photograph, {"name": path.stem, **table}, textures.folder, notes.append)
        return replace(scene, notes=tuple(notes))
    lists = {kind: as_tables(table, kind) for kind in _SHAPES}
    if sum(map(len, lists.values())) + len(as_tables(table, "mesh")) > MOST_OBJECTS:
        raise lb.SceneError(f"has more than {MOST_OBJECTS} objects")
    if not (any(lists.values()) or table.get("mesh") or "floor" in table or "sky" in table):
        known = ", ".join(f"[[{kind}]]" for kind in (*_SHAPES, "mesh"))
        raise lb.SceneError(f"shows nothing: give it a [floor], a [sky] or one of {known}")

    def material(value: Any, name: str) -> lb.Material:
        """The material of an object: the name of one, or a table."""
        if not isinstance(value, str):
            return _material(value, textures)
        if value not in materials:
            raise lb.SceneError(f"material {excerpt(value)} is not in the file: write a table [material.{cut(value)}]")
        return materials[value]

    meshes: list[lb.Mesh] = []
    for k, value in enumerate(as_tables(table, "mesh")):
        meshes += within(f"mesh {k + 1}", _mesh, value, material, textures.folder)
        images = {id(mesh.material.pattern.image): mesh.material.pattern.image for mesh in meshes
                  if mesh.material.pattern is not None and mesh.material.pattern.image is not None}
        if len(meshes) > MOST_OBJECTS:
            raise lb.SceneError(f"the materials of its meshes make more than {MOST_OBJECTS} objects")
        if sum(mesh.triangle_count for mesh in meshes) > MOST_TRIANGLES:
            raise lb.SceneError(f"its meshes have more than {significant(MOST_TRIANGLES)} triangles together")
        textures.check(images.values())
    shapes = [within(f"{kind} {k + 1}", _SHAPES[kind], value, {"material": material, "name": text, **MOTION})
              for kind, entries in lists.items() for k, value in enumerate(entries)]
    values = {kind: within(kind, read, as_table(table[kind], kind), textures, notes.append)
              for kind, read in _SURROUNDINGS.items() if kind in table}
    values |= given(table, {"name": text, "ambient": light, "enclosed": truth, "depth_range": _depth_range,
                            "diffuse_bounce": truth, "subject": _subject, "exposure": number,
                            "summary": text})
    values["framings"] = tuple(within(f"framing {cut(name)}", _framing, as_table(value, name), name)
                               for name, value in as_table(table.get("framing", {}), "framing").items())
    return lb.Scene(**{"name": path.stem, **by_field([*shapes, *meshes]), **values}, notes=tuple(notes))


def _depth_range(value: Any, name: str) -> tuple[float, ...]:
    near, far = numbers(value, name, 2, length)
    if not 0.0 < near < far:
        raise lb.SceneError("depth_range: the first distance must be positive and less than the second")
    return near, far


def _subject(value: Any, name: str) -> tuple[float, ...]:
    if not (isinstance(value, list) and len(value) == 2):
        raise lb.SceneError(f"{name}: write its distance and its height, such as {name} = [\"1.5 m\", \"60 cm\"]")
    return numbers(value, name, 2, length)


def _framing(t: Table, name: str) -> Framing:
    return Framing(name, **fields_of(t, "a framing", {"centre": point, "height": length}, ("centre", "height")))


def _sky(t: Table, textures: Textures, say: Say) -> lb.Sky | lb.ImageSky:
    if "image" not in t:
        return lb.Sky(**fields_of(t, "sky", {"zenith": light, "horizon": light, "ground": light, "up": vector}))

    def picture(value: Any, name: str) -> lb.Image:
        return read_sky(text(value, name), textures.folder, say)

    return lb.ImageSky(**fields_of(t, "a sky with an image", {"image": picture, "turn": angle, "brightness": number}))


def _sun(t: Table, textures: Textures, say: Say) -> lb.Sun:
    return lb.Sun(**fields_of(t, "sun", {"direction": vector, "colour": light, "angular_radius": angle},
                              ("direction",)))


def _floor(t: Table, textures: Textures, say: Say) -> lb.Floor:
    def picture(value: Any, name: str) -> lb.Image:
        return read_texture(text(value, name), textures)

    values = fields_of(t, "floor", {
        "texture": picture, "height": length, "tile": length, "light": colour, "dark": colour,
        "gloss": number, "normal": vector, "turn": angle, "offset": partial(numbers, count=2)})
    if "texture" in values:
        if unused := [key for key in ("light", "dark") if key in values]:
            raise lb.SceneError(f"{unused[0]}: a floor has a texture or two colours, not both")
        values["image"] = values.pop("texture")
    return lb.Floor(**values)


# Objects. `common` has the readers of material and motion

def _sphere(t: Table, common: dict[str, Reader]) -> lb.Sphere:
    return lb.Sphere(**fields_of(t, "a sphere", {"centre": point, "radius": length, **common}, ("centre", "radius")))


def _rectangle(t: Table, common: dict[str, Reader]) -> lb.Rectangle:
    if "target" not in t:
        return lb.Rectangle(**fields_of(t, "a rectangle", {"centre": point, "right": point, "up": point, **common},
                                         ("centre", "right", "up")))
    sides = ("centre", "target", "width", "height")
    values = fields_of(t, "a rectangle with a target", {
        "centre": point, "target": point, "width": length, "height": length, **common}, sides)
    centre, target, width, height = (values.pop(name) for name in sides)
    if not (width > 0.0 and height > 0.0):
        raise lb.SceneError("width and height must be positive")
    if centre == target:
        raise lb.SceneError("the target lies in the centre of the rectangle")
    facing = lb.Rectangle.facing(centre, target, width, height, values.pop("material", lb.Material()))
    return replace(facing, **values)


def _disk(t: Table, common: dict[str, Reader]) -> lb.Disk:
    return lb.Disk(**fields_of(t, "a disk", {"centre": point, "normal": vector, "radius": length, **common},
                               ("centre", "normal", "radius")))


def _mesh(t: Table, material: Reader, folder: Path) -> list[lb.Mesh]:
    values = fields_of(t, "a mesh", {"file": text, "position": point, "rotation": partial(numbers, read=angle),
                                      "scale": number, "unit": unit, "size": length, "height": length,
                                      "foot": point, "smooth": truth, "material": material}, ("file",))
    if sum(bool(names & set(values)) for names in ({"size"}, {"height"}, {"scale", "unit"})) > 1:
        raise lb.SceneError("a mesh has a size, a height, or a unit and a scale: choose one")
    if "foot" in values and "position" in values:
        raise lb.SceneError("a mesh has the position of its origin or of its foot, not both")
    for name in ("size", "height", "scale"):
        if name in values and not values[name] > 0.0:
            raise lb.SceneError(f"{name} must be positive")
    scale = None
    if "unit" in values:
        scale = values["unit"] * values.get("scale", 1.0)
    elif "scale" in values:
        scale = values["scale"] * MM.get(Path(values["file"]).suffix[1:].lower(), 1.0)
    pose = Pose(rotation(*values.get("rotation", (0.0, 0.0, 0.0))), scale, values.get("size"),
                values.get("position", (0.0, 0.0, 0.0)), values.get("height"), values.get("foot"))
    return read_mesh(values["file"], folder, pose, values.get("material"), values.get("smooth", False))


def _photograph(table: Table, folder: Path, say: Say) -> lb.Scene:
    """The scene of a photograph, which has no other objects."""
    others = sorted(set(table) - {"photograph", "name", "depth_range"})
    if others:
        raise lb.SceneError(f"a scene of a photograph has no {excerpt(others[0])}")
    entry: Table = {"fill": "plain"}
    entry |= fields_of(as_table(table["photograph"], "photograph"), "a photograph", {
        "image": text, "depth": text, "fov": angle, "depth_is": text, "near": length, "far": length,
        "fill": text, "holes": truth}, ("image",))
    if "depth" not in entry:
        unused = [name for name in ("depth_is", "near", "far", "holes") if name in entry]
        if unused:
            raise lb.SceneError(f"{unused[0]} belongs to a depth map of its own: name it as depth")
        scene = own_depth_scene(entry["image"], folder, entry.get("fov"), entry["fill"])
    elif "fov" not in entry:
        raise lb.SceneError("a photograph with a depth map of its own needs fov, the angle across it")
    else:
        scene = read_photograph(entry["image"], entry["depth"], folder, entry["fov"],
                                entry.get("depth_is", "distance"), entry.get("near"), entry.get("far"), entry["fill"],
                                entry.get("holes", True), say)
    return replace(scene, **given(table, {"name": text, "depth_range": _depth_range}))


# The reader of each table that a scene file may hold. A new shape is one row
_SURROUNDINGS: dict[str, Callable[[Table, Textures, Say], Any]] = {"sky": _sky, "sun": _sun, "floor": _floor}
_SHAPES: dict[str, Callable[..., Any]] = {"sphere": _sphere, "rectangle": _rectangle, "disk": _disk}


def _material(value: Any, textures: Textures) -> lb.Material:
    t = as_table(value, "material")
    shade = light if t.get("kind") in ("light", "lamp") else colour

    def texture(value: Any, name: str) -> lb.Pattern:
        return lb.Pattern("image", image=read_texture(text(value, name), textures))

    values = fields_of(t, "a material", {"kind": text, "texture": texture, "colour": shade, "gloss": number,
                                        "pattern": partial(_pattern, shade=shade)})
    if "texture" not in values:
        return lb.Material(**values)
    if "pattern" in values:
        raise lb.SceneError("a material has a pattern or a texture, not both")
    return lb.Material(**{"pattern": values.pop("texture"), "colour": (1.0, 1.0, 1.0), **values})


def _pattern(value: Any, name: str, shade: Reader) -> lb.Pattern:
    values = fields_of(as_table(value, name), "a pattern", {
        "kind": text, "colour": shade, "columns": number, "rows": number, "line": length}, ("kind",))
    if values["kind"] == "image":
        raise lb.SceneError('an image is given as texture = "file.png"')
    return lb.Pattern(**values)
