"""Meshes of scene files: OBJ, PLY, glTF and GLB, with base colour, normals and pictures.

What a mesh file names is read from the folder of the scene alone. Its pictures are decoded by `texture`, by their own
first bytes, whatever the file calls them; they are not turned by EXIF: their coordinates count the texels as stored.
"""

import math
import struct
from pathlib import Path
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.scenes.asset_files import TEXTURE_TEXELS, asset_path, image_of
from lensbench.app.scenes.gltf_file import read_gltf
from lensbench.app.scenes.mesh_parts import MOST_BYTES, LookError, MeshFile, Piece, distinct
from lensbench.app.scenes.obj_file import read_obj
from lensbench.app.scenes.ply_file import read_ply
from lensbench.core.text import excerpt, significant
from lensbench.lenses.picture_file import PictureFileError, read_picture_file

READERS = {"obj": read_obj, "ply": read_ply, "gltf": read_gltf, "glb": read_gltf}
MM = {"obj": 1.0, "ply": 1.0, "gltf": 1000.0, "glb": 1000.0}       # of a unit of the file; glTF is in metres
MOST_LOOKS = 2000               # colours and pictures: each is a mesh of its own
MOST_TEXELS = TEXTURE_TEXELS    # of all pictures of a file together
DAMAGE = (ValueError, TypeError, LookupError, AttributeError, ArithmeticError, MemoryError, struct.error,
          RecursionError)


class Pose(NamedTuple):
    """Rotation (3, 3), factor and position (mm) of the origin of a mesh file; or a height and where its foot stands."""

    rotation: np.ndarray
    scale: float | None         # mm of a unit of the file; None: as the format says
    size: float | None          # mm of the longest side of its box, instead of a scale
    position: tuple[float, float, float]
    height: float | None = None             # mm of its box along y, once rotated, instead of a scale
    foot: tuple[float, float, float] | None = None      # where the middle of the lowest side of that box stands, mm


def read_mesh(name: str, folder: Path, pose: Pose, material: lb.Material | None, smooth: bool) -> list[lb.Mesh]:
    """The meshes of a file in the folder of the scene or below it, one for each look; SceneError in one line.

    material: instead of those of the file. smooth: normals are the means of neighbouring triangles, unless the file
    has its own.
    """
    path = asset_path(name, folder, "mesh", MOST_BYTES)
    kind = path.suffix[1:].lower()
    if kind not in READERS:
        raise lb.SceneError(f"mesh {excerpt(name)}: choose a file of the kinds {', '.join(READERS)}")
    bound = folder if path.is_relative_to(folder) else path.parent      # of what the mesh itself names
    file = MeshFile(path, bound, plain=material is not None)
    try:
        with np.errstate(all="ignore"):             # what is not finite is refused below
            pieces = _joined([piece for piece in READERS[kind](file) if len(piece.faces)])
            if not pieces:
                raise lb.SceneError("has no triangles")
            return _placed(pieces, _pictures(pieces, file), MM[kind], name, pose, material, smooth)
    except lb.SceneError as error:
        advice = "; or give the mesh a material" if isinstance(error, LookError) else ""
        raise lb.SceneError(f"mesh {excerpt(name)}: {error}{advice}") from error
    except DAMAGE as error:
        raise lb.SceneError(f"mesh {excerpt(name)} is damaged, or no file of the kind {kind}") from error


def mesh_files(path: Path) -> list[Path]:
    """The files that a mesh file names, below its own folder; SceneError."""
    file = MeshFile(path, path.parent, plain=False)
    list(READERS[path.suffix[1:].lower()](file))
    return [path.parent / name for name in file.names]


def _joined(pieces: list[Piece]) -> list[Piece]:
    """One part for all of one look: a file may have a node for each screw."""
    by_look: dict[tuple, list[Piece]] = {}
    for piece in pieces:
        missing = tuple(values is None for values in (piece.normals, piece.uv, piece.colours))
        by_look.setdefault((piece.look, missing), []).append(piece)
    if len(by_look) > MOST_LOOKS:
        raise lb.SceneError(f"has {significant(len(by_look))} materials: at most {significant(MOST_LOOKS)} are read")

    def stacked(same: list[Piece], column: str) -> np.ndarray | None:
        arrays = [getattr(piece, column) for piece in same]
        return arrays[0] if len(same) == 1 or arrays[0] is None else np.concatenate(arrays)

    joined = []
    for (look, _), same in by_look.items():
        starts = np.cumsum([0, *(len(piece.vertices) for piece in same[:-1])])
        for k, start in enumerate(starts):
            same[k] = same[k]._replace(faces=(same[k].faces + start).astype(np.int32))
        vertices, faces, normals, uv, colours = (stacked(same, name) for name in (
            "vertices", "faces", "normals", "uv", "colours"))
        assert vertices is not None and faces is not None
        joined.append(Piece(vertices, faces, look, normals, uv, colours))
    return joined


def _pictures(pieces: list[Piece], file: MeshFile) -> dict:
    """The images of the parts by the names of their looks, of MOST_TEXELS in all."""
    names = [*dict.fromkeys(piece.look.picture for piece in pieces if piece.look.picture is not None)]
    images = {}
    for name in names:
        try:
            picture = read_picture_file(file.pictures.pop(name), upright=False)
        except PictureFileError as error:
            raise LookError(f"texture {excerpt(name)}: {error}") from error
        images[name] = image_of(picture, MOST_TEXELS // len(names))
    return images


def _placed(pieces: list[Piece], images: dict, mm: float, name: str, pose: Pose, material: lb.Material | None,
            smooth: bool) -> list[lb.Mesh]:
    """The parts in the world, in mm. mm: of a unit of the format."""
    lows, highs = zip(*((piece.vertices.min(0), piece.vertices.max(0)) for piece in pieces), strict=True)
    low, high = np.min(lows, 0), np.max(highs, 0)
    if not (np.isfinite(low).all() and np.isfinite(high).all()):
        raise lb.SceneError("a vertex is not finite")
    scale = mm if pose.scale is None else pose.scale
    if pose.size is not None:
        longest = float((high - low).max())
        if not longest > 0.0:
            raise lb.SceneError("has no size that a factor could change")
        scale = pose.size / longest
    position = np.asarray(pose.position)
    if pose.height is not None or pose.foot is not None:
        lows, highs = zip(*((turned.min(0), turned.max(0)) for turned in (
            piece.vertices @ pose.rotation.T for piece in pieces)), strict=True)
        low, high = np.min(lows, 0), np.max(highs, 0)
        if pose.height is not None:
            if not high[1] > low[1]:
                raise lb.SceneError("has no height that a factor could change")
            scale = pose.height / float(high[1] - low[1])
        if pose.foot is not None:
            position = pose.foot - scale * np.array([0.5 * (low[0] + high[0]), low[1], 0.5 * (low[2] + high[2])])
    meshes = []
    for piece in pieces:
        vertices = scale * piece.vertices @ pose.rotation.T + position
        normals = piece.normals @ pose.rotation.T if piece.normals is not None else None
        if normals is None and smooth:
            normals = _smoothed(vertices, piece.faces)
        image = images.get(piece.look.picture)
        pattern = None if image is None else lb.Pattern("image", image=image)
        kind, gloss = ("matte", 1.0) if piece.look.coat is None else ("coat", piece.look.coat)
        own = material or lb.Material(piece.look.colour, kind, gloss, pattern)
        try:
            meshes.append(lb.Mesh.of(vertices, piece.faces, own, normals=normals,
                                    uv=piece.uv if own.pattern is not None else None, colours=piece.colours,
                                    name=Path(name).stem))
        except lb.SceneError as error:
            if "area" not in str(error):
                raise
    if not meshes:
        raise lb.SceneError("none of its triangles has an area")
    return meshes


def _smoothed(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Normals (n, 3): sums over the triangles around each place, weighted by their areas."""
    _, positions = distinct(*np.round((vertices - vertices.min(0)) * 1e4).astype(np.int64).T)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    sums = np.zeros((positions.max() + 1, 3))
    for k in range(3):
        for axis in range(3):
            sums[:, axis] += np.bincount(positions[faces[:, k]], normal[:, axis], len(sums))
    return sums[positions]


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
