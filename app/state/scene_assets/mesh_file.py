"""Meshes of scene files: OBJ, PLY, glTF and GLB, read by trimesh, with base colour, normals and textures.

trimesh is an optional part (`pip install lensbench[mesh]`), because only scenes with mesh files need it; it is imported
when the first one is read. What a file names, such as a texture, is read from the folder of the scene alone.
"""

import json
import math
import struct
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.state.scene_assets.place import asset_path
from lensbench.app.state.scene_assets.texture import image_of
from lensbench.kernels.figures import significant
from lensbench.kernels.quotation import excerpt
from lensbench.kernels.srgb import linear
from lensbench.scenery.intersect.triangle_tree import MOST_TRIANGLES

MOST_BYTES = 1 << 30
MOST_BARE = 100_000         # elements that a glTF file declares without data, which are zeros: they fill any memory
FORMATS = ("obj", "ply", "gltf", "glb")
MM = {"obj": 1.0, "ply": 1.0, "gltf": 1000.0, "glb": 1000.0}       # of a unit of the file; glTF is in metres


class Pose(NamedTuple):
    """Rotation (3, 3), factor and place (mm) of the origin of a mesh file."""

    rotation: np.ndarray
    scale: float | None         # mm of a unit of the file; None: as the format says
    size: float | None          # mm of the longest side of its box, in place of a scale
    place: tuple[float, float, float]


def read_mesh(name: str, folder: Path, pose: Pose, material: lb.Material | None, smooth: bool) -> list[lb.Mesh]:
    """The meshes of a file in the folder of the scene or below it, one for each material; SceneError in one line.

    material: in place of those of the file. smooth: normals are the means of neighbouring triangles, unless the file
    has its own.
    """
    path = asset_path(name, folder, "mesh", MOST_BYTES)
    kind = path.suffix[1:].lower()
    if kind not in FORMATS:
        raise lb.SceneError(f"mesh {excerpt(name)}: choose a file of the kinds {', '.join(FORMATS)}")
    try:
        import trimesh
    except ImportError as error:
        raise lb.SceneError(f"mesh {excerpt(name)} needs trimesh: pip install lensbench[mesh]") from error
    textured = _checked_gltf(path, name, kind) if kind in ("gltf", "glb") else 0
    resolver = _Resolver(path, folder)
    load: Any = trimesh.load_scene
    try:
        with warnings.catch_warnings(), path.open("rb") as file:
            warnings.simplefilter("ignore")
            options = {"skip_materials": True} if material is not None and kind == "obj" else {}
            found = load(file, file_type=kind, resolver=resolver, process=False, **options)
            parts, count = [], 0
            for part in _parts(found):                  # a node may repeat a mesh
                parts.append(part)
                count += len(part.faces)
                if count > MOST_TRIANGLES:
                    break
            left_out = textured - sum(_picture(each) is not None for each in found.geometry.values()) if textured else 0
    except Exception as error:      # trimesh raises whatever a damaged file makes Python raise
        if resolver.refused:
            raise lb.SceneError(f"mesh {excerpt(name)}: {resolver.refused[0]}") from error
        raise lb.SceneError(f"mesh {excerpt(name)} is damaged, or no file of the kind {kind}") from error
    if resolver.refused and material is None:
        raise lb.SceneError(f"mesh {excerpt(name)}: {resolver.refused[0]}; or give the mesh a material")
    if not parts:
        raise lb.SceneError(f"mesh {excerpt(name)} has no triangles")
    if count > MOST_TRIANGLES:
        raise lb.SceneError(f"mesh {excerpt(name)} has more than {significant(MOST_TRIANGLES)} triangles")
    if left_out > 0 and material is None:
        raise lb.SceneError(f"mesh {excerpt(name)}: {left_out} of its textures cannot be read, or has no places "
                            "(TEXCOORD_0); or give the mesh a material")
    return _placed(_joined(parts), name, kind, pose, material, smooth)


class _Resolver:
    """What trimesh asks for files that a mesh names: only those in the folder of the scene."""

    def __init__(self, path: Path, folder: Path):
        self.parent, self.folder, self.file_name = path.parent, folder, path.name
        self.refused: list[str] = []

    def get(self, name: str) -> bytes:
        """The bytes of a file beside the mesh."""
        try:
            inner = self.parent.relative_to(self.folder) / name
            return asset_path(str(inner), self.folder, "its file", MOST_BYTES).read_bytes()
        except (lb.SceneError, OSError) as error:
            self.refused.append(str(error) if isinstance(error, lb.SceneError) else f"{excerpt(name)} cannot be read")
            raise

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)

    def __contains__(self, name: str) -> bool:
        return (self.parent / name).exists()

    def namespaced(self, name: str) -> "_Resolver":
        """Itself: names are relative to the file of the mesh."""
        return self

    def keys(self) -> list[str]:
        """No list of files."""
        return []


def _checked_gltf(path: Path, name: str, kind: str) -> int:
    """How many parts of a glTF file have a texture, which trimesh leaves out without a word if it cannot be read.

    SceneError for a file whose nodes contain each other or that is cut short; trimesh would not end.
    """
    data = path.read_bytes()
    try:
        if kind == "glb":
            magic, _, length, size, chunk = struct.unpack("<4sIII4s", data[:20])
            if magic != b"glTF" or chunk != b"JSON" or length > len(data):
                raise ValueError("cut short")
            data = data[20:20 + size]
        tree = json.loads(data.decode("utf-8"))
        materials, meshes = tree.get("materials", []), tree.get("meshes", [])
        used = [materials[part["material"]] for mesh in meshes for part in mesh["primitives"] if "material" in part]
        textured = sum("baseColorTexture" in each.get("pbrMetallicRoughness", {}) for each in used)
        bare = max((each["count"] for each in tree.get("accessors", []) if "bufferView" not in each), default=0)
        below = [list(node.get("children", ())) for node in tree.get("nodes", [])]
        parents = [0] * len(below)
        for children in below:
            for child in children:
                parents[child] += 1
    except (ValueError, AttributeError, TypeError, LookupError, struct.error, RecursionError) as error:
        raise lb.SceneError(f"mesh {excerpt(name)} is damaged, or no file of the kind {kind}") from error
    if bare > MOST_BARE:
        raise lb.SceneError(f"mesh {excerpt(name)}: the file declares {significant(bare)} elements without data")
    # Remove nodes without parents until none is left; nodes that remain contain each other
    free = [k for k, count in enumerate(parents) if count == 0]
    seen = 0
    while free:
        seen += 1
        for child in below[free.pop()]:
            parents[child] -= 1
            if parents[child] == 0:
                free.append(child)
    if seen < len(below):
        raise lb.SceneError(f"mesh {excerpt(name)}: a node of the file contains itself")
    return textured


class _Part(NamedTuple):
    """Triangles of one material, in units of the file."""

    vertices: np.ndarray
    faces: np.ndarray
    normals: np.ndarray | None
    uv: np.ndarray | None
    colours: np.ndarray | None
    colour: tuple[float, float, float]
    image: lb.Image | None


def _parts(found: Any) -> Iterator[_Part]:
    """Every mesh of a trimesh scene, where its node stands."""
    images: dict[int, lb.Image] = {}
    for node in found.graph.nodes_geometry:
        transform, key = found.graph[node]
        geometry = found.geometry[key]
        faces = getattr(geometry, "faces", None)
        if faces is None or not len(faces):
            continue
        matrix = np.asarray(transform, float)
        vertices = np.asarray(geometry.vertices, float) @ matrix[:3, :3].T + matrix[:3, 3]
        faces = np.asarray(faces, np.int64)
        if np.linalg.det(matrix[:3, :3]) < 0.0:
            faces = faces[:, ::-1]
        normals = geometry._cache.cache.get("vertex_normals") if hasattr(geometry, "_cache") else None
        if normals is not None and len(normals) == len(vertices):
            normals = np.asarray(normals, float) @ np.linalg.inv(matrix[:3, :3])
        else:
            normals = None
        yield _Part(vertices, faces, normals, *_look(geometry, images))


def _look(geometry: Any, images: dict[int, lb.Image]) -> tuple[Any, Any, tuple[float, float, float], lb.Image | None]:
    """Places in the image, colours of vertices, colour and image of a mesh. images: those read before, by identity."""
    visual = geometry.visual
    if visual.kind == "vertex":
        return None, linear(np.asarray(visual.vertex_colors, float)[:, :3] / 255.0), (1.0, 1.0, 1.0), None
    material = getattr(visual, "material", None)
    if material is None:
        return None, None, (0.5, 0.5, 0.5), None
    picture = _picture(geometry)
    factor = getattr(material, "baseColorFactor", None)
    if factor is not None:                              # linear, as glTF has it; trimesh keeps 8 bits
        colour = np.asarray(factor, float)[:3] / (255.0 if np.asarray(factor).dtype.kind in "iu" else 1.0)
    elif getattr(material, "diffuse", None) is not None and picture is None:
        colour = linear(np.asarray(material.diffuse, float)[:3] / 255.0)
    else:
        colour = np.ones(3)
    red, green, blue = np.clip(colour, 0.0, 1.0)
    if picture is None:
        return None, None, (float(red), float(green), float(blue)), None
    if id(picture) not in images:
        images[id(picture)] = image_of(picture)
    return np.asarray(visual.uv, float), None, (float(red), float(green), float(blue)), images[id(picture)]


def _joined(parts: list[_Part]) -> list[_Part]:
    """One part for all of one look: a file may have a node for each screw."""
    alike: dict[tuple, list[_Part]] = {}
    for part in parts:
        given = tuple(each is None for each in (part.normals, part.uv, part.colours))
        alike.setdefault((part.colour, id(part.image), given), []).append(part)

    def stacked(arrays: list) -> np.ndarray | None:
        return None if arrays[0] is None else np.concatenate(arrays)

    found = []
    for (colour, _, _), same in alike.items():
        starts = np.cumsum([0, *(len(part.vertices) for part in same)])
        found.append(_Part(
            np.concatenate([part.vertices for part in same]),
            np.concatenate([part.faces + start for part, start in zip(same, starts, strict=False)]),
            stacked([part.normals for part in same]), stacked([part.uv for part in same]),
            stacked([part.colours for part in same]), colour, same[0].image))
    return found


def _picture(geometry: Any) -> Any:
    """The picture of base colour of a mesh whose vertices have places in it, as trimesh holds it; None without."""
    material, uv = getattr(geometry.visual, "material", None), getattr(geometry.visual, "uv", None)
    if uv is None or len(uv) != len(geometry.vertices):
        return None
    return getattr(material, "baseColorTexture", None) or getattr(material, "image", None)


def _placed(parts: list[_Part], name: str, kind: str, pose: Pose, material: lb.Material | None,
            smooth: bool) -> list[lb.Mesh]:
    """The parts in the world, in mm."""
    points = np.concatenate([part.vertices for part in parts])
    if not np.isfinite(points).all():
        raise lb.SceneError(f"mesh {excerpt(name)} has a vertex that is not finite")
    scale = MM[kind] if pose.scale is None else pose.scale
    if pose.size is not None:
        longest = float(np.ptp(points, 0).max())
        if not longest > 0.0:
            raise lb.SceneError(f"mesh {excerpt(name)} has no size that a factor could change")
        scale = pose.size / longest
    found = []
    for part in parts:
        vertices = scale * part.vertices @ pose.rotation.T + np.asarray(pose.place)
        normals = part.normals @ pose.rotation.T if part.normals is not None else None
        if normals is None and smooth:
            normals = _smoothed(vertices, part.faces)
        own = material
        if own is None:
            pattern = None if part.image is None else lb.Pattern("image", image=part.image)
            own = lb.Material(part.colour, pattern=pattern)
        try:
            found.append(lb.Mesh.of(vertices, part.faces, own, normals=normals, uv=part.uv,
                                    colours=None if material is not None else part.colours, name=Path(name).stem))
        except lb.SceneError as error:
            if len(parts) == 1 or "area" not in str(error):
                raise lb.SceneError(f"mesh {excerpt(name)}: {error}") from error
    if not found:
        raise lb.SceneError(f"mesh {excerpt(name)}: no triangle of it has an area")
    return found


def _smoothed(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Normals (n, 3): sums over the triangles around each place, weighted by their areas."""
    _, places = np.unique(np.round(vertices, 4), axis=0, return_inverse=True)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    sums = np.zeros((places.max() + 1, 3))
    for k in range(3):
        for axis in range(3):
            sums[:, axis] += np.bincount(places[faces[:, k]], normal[:, axis], len(sums))
    return sums[places]


def rotation(about_x: float, about_y: float, about_z: float) -> np.ndarray:
    """Rotation (3, 3) about the axes of the world, x first, then y, then z; radians."""
    turned = np.eye(3)
    for angle, (j, k) in ((about_x, (1, 2)), (about_y, (2, 0)), (about_z, (0, 1))):
        step = np.eye(3)
        step[j, j] = step[k, k] = math.cos(angle)
        step[k, j] = math.sin(angle)
        step[j, k] = -step[k, j]
        turned = step @ turned
    return turned
