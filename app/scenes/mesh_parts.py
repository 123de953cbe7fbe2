"""What the readers of mesh files share: files next to the mesh, parts of one look, polygons cut to triangles, Draco."""

import struct
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.scenes.asset_files import asset_path
from lensbench.core.kernels.numeric import linear
from lensbench.core.scenery.intersect.triangle_tree import MOST_TRIANGLES
from lensbench.core.text import excerpt, significant

MOST_BYTES = 512 << 20          # of a mesh file, and of all files that it names
MOST_REPEATED = 1_500_000       # triangles of which the file holds less than BYTES each: copies, or damage
BYTES = 6                       # the least that a triangle takes in any of the formats
MOST_EFFORT = 1 << 28           # squares of the corners of concave polygons: crossed ones take so much, 5 s in all
BLOCK = 1 << 18                 # corners that are looked at together
GREY = (0.5, 0.5, 0.5)
WHITE = (1.0, 1.0, 1.0)


class LookError(lb.SceneError):
    """A fault of the colours or pictures of a file, which do not count where the scene gives the mesh a material."""


@contextmanager
def of_looks() -> Iterator[None]:
    """Make a SceneError in this block a LookError."""
    try:
        yield
    except lb.SceneError as error:
        raise LookError(str(error)) from error


class Look(NamedTuple):
    """Linear colour, the name of the picture among those of its `MeshFile`, and the gloss of a clear coat over it."""

    colour: tuple[float, float, float] = GREY
    picture: Any = None
    coat: float | None = None               # None: without


class Piece(NamedTuple):
    """Triangles of one look, in units of the file. uv: 0, 0 is the lower left corner of the picture."""

    vertices: np.ndarray
    faces: np.ndarray
    look: Look
    normals: np.ndarray | None = None
    uv: np.ndarray | None = None
    colours: np.ndarray | None = None       # linear


class MeshFile:
    """A mesh file and what it names, which lies in the folder of the scene; SceneError where it does not.

    plain: the scene gives the mesh a material, so that pictures and colours of the file are not read.
    """

    def __init__(self, path: Path, folder: Path, plain: bool):
        self.path, self.folder, self.plain = path, folder, plain
        self.pictures: dict[Any, bytes] = {}
        self.size = path.stat().st_size         # of all files that were read
        self.triangles = 0
        self._files: dict[str, bytes] = {}

    def bytes_of(self, name: str) -> bytes:
        """The bytes of a file that the mesh names, relative to its own place."""
        if name not in self._files:
            if "://" in name:
                raise lb.SceneError(f"its file {excerpt(name)} lies on a network: save it next to the mesh, and name "
                                    "it there")
            inner = name if Path(name).is_absolute() else str(self.path.parent.relative_to(self.folder) / name)
            path = asset_path(inner, self.folder, "its file", MOST_BYTES)
            self.size += path.stat().st_size
            if self.size > MOST_BYTES:
                raise lb.SceneError(f"with the files that it names it is larger than {MOST_BYTES >> 20} MB")
            self._files[name] = path.read_bytes()
        return self._files[name]

    @property
    def names(self) -> list[str]:
        """The names of the files that were read for the mesh, relative to its own place."""
        return list(self._files)

    def count(self, triangles: int) -> None:
        """Take so many more triangles; SceneError where a small file claims many."""
        self.triangles += triangles
        if self.triangles > MOST_REPEATED and self.triangles * BYTES > self.size:
            raise lb.SceneError(f"claims more than {significant(MOST_REPEATED)} triangles, and its {self.size} bytes "
                                "hold fewer: repeat its parts less often")
        if self.triangles > MOST_TRIANGLES:
            raise lb.SceneError(f"has more than {significant(MOST_TRIANGLES)} triangles")


def coded(levels: np.ndarray) -> np.ndarray:
    """Linear colours (n, 3) of sRGB levels, as OBJ and PLY files hold them: whole numbers, or 0 to 1."""
    levels = levels[:, :3]
    most = np.iinfo(levels.dtype).max if levels.dtype.kind in "iu" else 1.0
    return linear(np.clip(levels.astype(np.float32) / np.float32(most), 0.0, 1.0)).astype(np.float32)


def distinct(*columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where each different row of whole numbers first stands, and which of them every row is."""
    key = columns[0]
    for more in columns[1:]:            # one after another: a product of three lengths is beyond 64 bits
        _, key = np.unique(key * (int(more.max(initial=0)) + 2) + more + 1, return_inverse=True)
    _, first, which = np.unique(key, return_index=True, return_inverse=True)
    return first, which


def compact(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rows that triangles (m, 3) use, and the triangles as places among them."""
    rows, faces_of_rows = np.unique(faces, return_inverse=True)
    return rows, faces_of_rows.reshape(-1, 3)


def of_strip(corners: np.ndarray) -> np.ndarray:
    """Triangles (m, 3) of the corners of a strip, all turned the same way."""
    k = np.arange(max(len(corners) - 2, 0))
    return np.stack([corners[k], corners[k + 1 + k % 2], corners[k + 2 - k % 2]], 1)


def cut_to_triangles(points: np.ndarray, corners: np.ndarray, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (m, 3) of polygons, as places in `corners`, and the polygon of each. Polygons with inward corners too.

    points: (n, 3). corners: all corners of all polygons, as rows of points. lengths: corners of each polygon.
    """
    starts = np.cumsum(lengths) - lengths
    triangles_found, owners, effort = [np.empty((0, 3), np.int64)], [np.empty(0, np.int64)], 0
    for count in np.unique(lengths[lengths > 2]):
        same = np.flatnonzero(lengths == count)
        for first in range(0, len(same), step := max(BLOCK // int(count), 1)):
            which = same[first:first + step]
            positions = starts[which][:, None] + np.arange(count)
            inward = _inward(points[corners[positions]]) if count > 3 else np.zeros((len(which), 1), bool)
            if count == 4:              # a quad is cut from its inward corner
                positions = starts[which][:, None] + (np.arange(4) + np.argmax(inward, 1)[:, None]) % 4
            elif (concave := inward.any(1)).any():
                effort += int(concave.sum()) * max(int(count), 32) ** 2
                if effort > MOST_EFFORT:
                    raise lb.SceneError("too many or too long polygons with inward corners: save it as triangles")
                for row in np.flatnonzero(concave):
                    triangles_found.append(starts[which[row]] + _cut(points[corners[positions[row]]]))
                    owners.append(np.full(len(triangles_found[-1]), which[row]))
                which, positions = which[~concave], positions[~concave]
            triangles_found += [positions[:, [0, k, k + 1]] for k in range(1, count - 1)]
            owners += [which] * (int(count) - 2)
    triangles, owner = np.concatenate(triangles_found), np.concatenate(owners)
    if (np.diff(owner) < 0).any():
        order = np.argsort(owner, kind="stable")
        triangles, owner = triangles[order], owner[order]
    return triangles, owner


def _inward(polygons: np.ndarray) -> np.ndarray:
    """Which corners (n, k) of polygons (n, k, 3) turn against the others."""
    edges = np.roll(polygons, -1, 1) - polygons
    turns = np.cross(np.roll(edges, 1, 1), edges)
    normal = _normals(polygons)
    against = np.einsum("nkj,nj->nk", turns, normal)
    return against < -1e-9 * np.abs(against).max(1, keepdims=True)


def _normals(polygons: np.ndarray) -> np.ndarray:
    """Twice the area vector (n, 3) of each polygon, by Newell's method."""
    local = polygons - polygons[:, :1]
    return np.cross(local, np.roll(local, -1, 1)).sum(1)


def _cut(polygon: np.ndarray) -> np.ndarray:
    """Triangles (m, 3) of one polygon (k, 3), by ear clipping in the plane across its normal."""
    try:
        from mapbox_earcut import triangulate_float64
    except ImportError as error:
        raise lb.SceneError("a polygon with inward corners needs mapbox_earcut: pip install lensbench[mesh]") from error
    if not np.isfinite(polygon).all():
        raise lb.SceneError("a vertex is not finite")
    normal = _normals(polygon[None])[0]
    flat = np.delete(polygon - polygon[0], np.argmax(np.abs(normal)), 1)
    corners = triangulate_float64(np.ascontiguousarray(flat), np.array([len(polygon)], np.uint32))
    triangles = corners.astype(np.int64).reshape(-1, 3)
    return triangles if (_normals(polygon[triangles]).sum(0) @ normal) >= 0.0 else triangles[:, ::-1]


# Triangles packed by Draco, as KHR_draco_mesh_compression holds them; read by DracoPy, an optional part

FEW_TRIANGLES = 100_000         # that any data may claim
MOST_A_BYTE = 16                # triangles that a byte of longer data holds at most; more is damage, or a trap
METADATA = 0x8000               # a flag


def draco_decoded(data: bytes) -> tuple[np.ndarray, dict[int, np.ndarray]]:
    """Corners (3 n,) of the triangles, and the columns of the vertices by their Draco number; SceneError for others."""
    try:
        from DracoPy import FileTypeException, decode
    except ImportError as error:
        raise lb.SceneError("its triangles are compressed by Draco (KHR_draco_mesh_compression), which needs DracoPy: "
                            "pip install lensbench[mesh]; or save it without compression") from error
    faces, vertices = _claimed(data)
    if faces > max(FEW_TRIANGLES, MOST_A_BYTE * len(data)) or vertices > 3 * faces:
        raise lb.SceneError(f"its Draco data claim {significant(faces)} triangles and {significant(vertices)} vertices")
    try:
        mesh = decode(data)
        return np.asarray(mesh.faces).reshape(-1).astype(np.int64), {
            column["unique_id"]: np.asarray(column["data"]).reshape(-1, column["num_components"])
            for column in mesh.attributes}
    except (FileTypeException, ValueError, AttributeError, LookupError, RuntimeError, MemoryError) as error:
        raise lb.SceneError("its Draco data are damaged") from error


def _claimed(data: bytes) -> tuple[int, int]:
    """The numbers of triangles and vertices that the data state; the decoder takes memory for them at once."""
    try:
        magic, major, minor, kind, method, flags = struct.unpack("<5s4BH", data[:11])
        if magic != b"DRACO" or kind != 1 or method > 1 or (major, minor) < (2, 2) or flags & METADATA:
            raise lb.SceneError("its Draco data are no triangles of the version 2.2 without metadata: save it again")
        start, numbers = 12 if method else 11, []
        for _ in range(2):
            number, shift = 0, 0
            while data[start] & 0x80:
                number |= (data[start] & 0x7F) << shift
                start, shift = start + 1, shift + 7
            numbers.append(number | data[start] << shift)
            start += 1
    except (struct.error, IndexError) as error:
        raise lb.SceneError("its Draco data are cut short") from error
    return (numbers[1], numbers[0]) if method else (numbers[0], numbers[1])
