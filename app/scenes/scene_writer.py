"""Scene files that the program writes: around files of the user, and as a copy of a scene with the files it names.

A scene around files of the user lies in the program's own folder (`own_scenes`) and names them by their whole paths, so
that a mesh that is exported anew is shown anew. Its name follows from its content: it never changes, and undo,
snapshots and settings keep meaning the same scene.
"""

import hashlib
import json
import re
import shutil
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import lensbench as lb
from lensbench.app.scenes.asset_files import own_scenes
from lensbench.app.scenes.mesh_file import READERS, mesh_files
from lensbench.app.scenes.scene_file import SHIPPED, find_scene
from lensbench.app.scenes.scene_values import value_table
from lensbench.app.scenes.table_values import Table
from lensbench.lenses.file_error import open_regular, replacing

NAMED = ("file", "image", "depth", "texture")       # keys whose text is the name of a file
LONGEST_STEM = 60                                   # characters of a file's name that a scene's name keeps
MOST_BYTES = 1 << 20                                # of a scene file


def toml_value(value: Any) -> str:
    """A value in TOML; a table is an inline one."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list | tuple):
        return f"[{', '.join(toml_value(item) for item in value)}]"
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{_key(key)} = {toml_value(item)}' for key, item in value.items())} }}"
    return repr(value)


def _key(key: str) -> str:
    return key if re.fullmatch("[A-Za-z0-9_-]+", key) else toml_value(key)


def scene_text(table: Table) -> str:
    """A scene file: values, then tables and lists of tables, one key a line."""
    lines = [f"{_key(key)} = {toml_value(value)}" for key, value in table.items() if not _is_table(value)]
    for key, value in table.items():
        if not _is_table(value):
            continue
        heads = [(f"[{_key(key)}]", value)] if isinstance(value, dict) else [(f"[[{_key(key)}]]", row) for row in value]
        for head, row in heads:
            lines += ["", head, *(f"{_key(name)} = {toml_value(item)}" for name, item in row.items())]
    return "\n".join(lines) + "\n"


def _is_table(value: Any) -> bool:
    return isinstance(value, dict) or isinstance(value, list) and bool(value) and all(
        isinstance(row, dict) for row in value)


def read_table(path: str | Path) -> Table:
    """The table of a scene file that has been read before; OSError or ValueError where it no longer can be."""
    with open_regular(path) as file:
        return tomllib.loads(file.read(MOST_BYTES).decode("utf-8"))


def scene_table(name: str) -> Table:
    """The table of a scene, with the whole paths of the files that it names; OSError, ValueError."""
    path = _path(name)
    if path is None:
        return value_table(find_scene(name))
    return _renamed(read_table(path), lambda text: str((path.parent / text).resolve()))


def _path(name: str) -> Path | None:
    """The file of a scene; None for one that code makes."""
    if name not in lb.SCENES:
        return Path(name)
    return shipped if (shipped := SHIPPED / f"{name}.toml").is_file() else None


def _renamed(value: Any, rename: Callable[[str], str]) -> Any:
    """A table with other names of its files."""
    if isinstance(value, dict):
        return {key: rename(item) if key in NAMED and isinstance(item, str) else _renamed(item, rename)
                for key, item in value.items()}
    return [_renamed(item, rename) for item in value] if isinstance(value, list) else value


def is_own(name: str) -> bool:
    """Whether a scene is one of the program's own folder."""
    return name.endswith(".toml") and Path(name).parent == own_scenes()


def own_scene(table: Table, stem: str) -> Path:
    """Write a scene into the program's own folder, unless it is there, and return its path; OSError, LensFileError.

    stem: of the file that it shows.
    """
    text = scene_text(table)
    plain = "".join(letter if letter.isalnum() or letter in " -_." else "-" for letter in stem)[:LONGEST_STEM]
    path = own_scenes() / f"{plain}-{hashlib.sha256(text.encode()).hexdigest()[:10]}.toml"
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path, "the scene ") as partial:
            partial.write_text(text, encoding="utf-8")
    return path


def save_scene(name: str, path: Path) -> list[str]:
    """Write a scene as a file that opens to the same one; returns the names of the files that were copied for it.

    Files in the folder of the new file or below are named as they are; others are copied into a folder next to it.
    OSError, ValueError where the scene cannot be read, or a file cannot be copied.
    """
    folder, own, copied, places = path.parent.resolve(), own_scenes(), list[str](), dict[Path, str]()

    def placed(text: str) -> str:
        asset = Path(text)
        if asset in places:
            return places[asset]
        if asset.is_relative_to(folder):
            return asset.relative_to(folder).as_posix()
        inner = Path(f"{path.stem} files")
        place = asset.relative_to(own) if asset.is_relative_to(own) else Path(asset.name)
        if (inner / place).as_posix() in places.values():          # another file of this name
            place = Path(str(len(places) + 1)) / place
        for file in (asset, *(mesh_files(asset) if asset.suffix[1:].lower() in READERS else ())):
            copy = folder / inner / place.parent / file.relative_to(asset.parent)
            copy.parent.mkdir(parents=True, exist_ok=True)
            with replacing(copy) as partial:
                shutil.copyfile(file, partial)
            copied.append(file.name)
        places[asset] = (inner / place).as_posix()
        return places[asset]

    source = _path(name)
    if source is not None and source.parent.resolve() == folder:
        text = source.read_text(encoding="utf-8")               # with its comments
    else:
        text = scene_text(_renamed(scene_table(name), placed))
    with replacing(path) as partial:
        partial.write_text(text, encoding="utf-8")
    return copied
