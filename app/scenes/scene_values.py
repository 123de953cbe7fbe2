"""Scenes that code makes, as tables of scene files: their meshes as PLY and their pictures as OpenEXR, without loss.

These files lie in the program's own folder, in a folder each that is named by its content. Angles are in degrees, as in
scene files; the degrees of an angle are those that give its radians again.
"""

import hashlib
import math
from collections.abc import Callable
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any

import numpy as np

import lensbench as lb
from lensbench.app.scenes.asset_files import own_scenes
from lensbench.app.scenes.sky_picture import write_exr
from lensbench.app.scenes.table_values import Table
from lensbench.core.scenery.families import FAMILIES
from lensbench.lenses.file_error import replacing

ANGLES = ("angular_radius", "turn", "spin")
VERTEX = (("vertices", "x y z"), ("normals", "nx ny nz"), ("uv", "s t"),
          ("colours", "linear_red linear_green linear_blue"))


def value_table(scene: lb.Scene) -> Table:
    """The table of a scene file that shows a scene; OSError where its files cannot be written."""
    table = _fields(scene, {"notes", "framings", *(family.field for family in FAMILIES.values())})
    if scene.framings:
        table["framing"] = {name: {"centre": _plain(centre, float), "height": float(height)}
                            for name, centre, height in scene.framings}
    for shape in scene.objects:
        kind = type(shape).__name__.lower()
        row = _mesh(shape) if isinstance(shape, lb.Mesh) else _fields(shape)
        table.setdefault(kind, []).append(row)
    return table


def _fields(value: Any, without: set[str] = frozenset()) -> Table:      # type: ignore[assignment]
    """The fields of a value that differ from their defaults."""
    row: Table = {}
    for field in fields(value):
        plain = getattr(value, field.name)
        default = field.default_factory() if field.default_factory is not MISSING else field.default
        if field.name not in without and field.init and not (default is not MISSING and plain == default):
            row |= _entry(field.name, plain)
    return row


def _entry(name: str, value: Any) -> Table:
    if isinstance(value, lb.Image):
        return {"texture" if name != "sky" else "image": _picture(value)}
    if isinstance(value, lb.Material):
        return {name: _material(value)}
    if isinstance(value, lb.ImageSky):
        return {name: {**_fields(value, {"image", "up"}), "image": _picture(value.image)}}
    if hasattr(value, "__dataclass_fields__"):
        return {name: _fields(value)}
    return {name: _plain(value, _degrees if name in ANGLES else float)}


def _plain(value: Any, number: Callable[[float], float]) -> Any:
    if isinstance(value, tuple | list):
        return [_plain(item, number) for item in value]
    return value if isinstance(value, str | bool) else number(value)


def _degrees(radians: float) -> float:
    """Degrees that `math.radians` turns into these radians, or the nearest."""
    middle = math.degrees(radians)
    near = [round(middle, 10), middle, math.nextafter(middle, math.inf), math.nextafter(middle, -math.inf)]
    return min(near, key=lambda degrees: abs(math.radians(degrees) - radians))


def _material(material: lb.Material) -> Table:
    row, pattern = _fields(material, {"pattern"}), material.pattern
    if pattern is None:
        return row
    if pattern.image is not None:
        return {"colour": list(map(float, material.colour)), **row, "texture": _picture(pattern.image)}
    return {**row, "pattern": {"kind": pattern.kind, **_fields(pattern, {"kind"})}}


def _mesh(mesh: lb.Mesh) -> Table:
    """A mesh as a binary PLY file in mm."""
    names, columns = [], []
    for field, labels in VERTEX:
        if data := getattr(mesh, field):
            names += labels.split()
            columns.append(np.frombuffer(data, "<f4").reshape(-1, len(labels.split())))
    faces = np.empty(len(mesh.triangles), [("n", "u1"), ("corners", "<i4", 3)])
    faces["n"], faces["corners"] = 3, mesh.triangles
    head = "\n".join(["ply", "format binary_little_endian 1.0", f"element vertex {len(columns[0])}",
                      *(f"property float {name}" for name in names), f"element face {len(faces)}",
                      "property list uchar int vertex_indices", "end_header", ""])
    data = head.encode() + np.ascontiguousarray(np.hstack(columns), "<f4").tobytes() + faces.tobytes()
    return {"file": _written(f"{mesh.name}.ply", data, lambda path: path.write_bytes(data)), "unit": "mm",
            "material": _material(mesh.material)}


def _picture(image: lb.Image) -> str:
    """A picture as OpenEXR of 32 bits, linear."""
    return _written("picture.exr", image.data, lambda path: write_exr(path, image))


def _written(name: str, content: bytes, write: Callable[[Path], object]) -> str:
    """The path of a file of this content in the program's own folder, written unless it is there."""
    path = own_scenes() / hashlib.sha256(content).hexdigest()[:16] / name
    if not path.is_file():
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path, "a file of the scene ") as partial:
            write(partial)
    return str(path)
