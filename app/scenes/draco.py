"""Triangles packed by Draco, as KHR_draco_mesh_compression holds them; read by DracoPy, an optional part."""

import struct

import numpy as np

import lensbench as lb
from lensbench.core.text import significant

FEW = 100_000                   # triangles that any data may claim
MOST_A_BYTE = 16                # triangles that a byte of longer data holds at most; more is damage, or a trap
METADATA = 0x8000


def decoded(data: bytes) -> tuple[np.ndarray, dict[int, np.ndarray]]:
    """Corners (3 n,) of the triangles, and the columns of the vertices by their Draco number; SceneError for others."""
    try:
        from DracoPy import FileTypeException, decode
    except ImportError as error:
        raise lb.SceneError("its triangles are compressed by Draco (KHR_draco_mesh_compression), which needs DracoPy: "
                            "pip install lensbench[mesh]; or save it without compression") from error
    faces, vertices = _claimed(data)
    if faces > max(FEW, MOST_A_BYTE * len(data)) or vertices > 3 * faces:
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
