"""Parts of a solid picture: triangles with normals, and strokes.

Lengths in mm, in the camera's frame; things of the scene in the world's. The camera's frame has its origin in the
middle of the film; x points right, y up, and the camera looks along −z.
"""

from dataclasses import dataclass

import numpy as np

Rgb = tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class Part:
    """Triangles of one thing.

    kind: what it is, which decides its colour: "glass", "cut", "stop", "film", "focus", "floor", "thing" or "shining".
    points, normals (n, 3): three rows a triangle. glass: n_d and V_d of a glass. tint: of a thing's own colour, linear.
    surfaces: indices of the surfaces of the lens that bound it.
    """

    kind: str
    points: np.ndarray
    normals: np.ndarray
    glass: tuple[float, float] | None = None
    tint: Rgb | None = None
    surfaces: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class Strokes:
    """Straight pieces (n, 2, 3) of lines, all of one kind, which decides their colour and weight."""

    kind: str
    pieces: np.ndarray


def pieces_of(path: np.ndarray) -> np.ndarray:
    """The pieces (n − 1, 2, 3) of a path (n, 3)."""
    return np.stack([path[:-1], path[1:]], axis=1)


def strokes(kind: str, paths: list[np.ndarray]) -> Strokes:
    """The pieces of several paths (n, 3)."""
    return Strokes(kind, np.concatenate([pieces_of(path) for path in paths]) if paths else np.zeros((0, 2, 3)))


def grid_part(kind: str, grid: np.ndarray, **more) -> Part:
    """Triangles of a grid (rows, columns, 3) of points, smooth; cells with a point that is not finite are left out."""
    along, across = np.gradient(grid, axis=0), np.gradient(grid, axis=1)
    normals = np.cross(along, across)
    length = np.linalg.norm(normals, axis=-1, keepdims=True)
    normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 1e-12)
    corners = [(0, 0), (1, 0), (1, 1), (0, 0), (1, 1), (0, 1)]
    rows, columns = grid.shape[0] - 1, grid.shape[1] - 1

    def cells(values: np.ndarray) -> np.ndarray:
        return np.stack([values[i:i + rows, j:j + columns] for i, j in corners], axis=2)

    points, around = cells(grid), cells(normals)
    whole = np.isfinite(points).all(axis=(2, 3))
    return Part(kind, points[whole].reshape(-1, 3), around[whole].reshape(-1, 3), **more)


def flat_part(kind: str, triangles: np.ndarray, **more) -> Part:
    """Triangles (n, 3, 3), each with its own normal."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(normals, axis=-1, keepdims=True)
    normals = np.divide(normals, length, out=np.zeros_like(normals), where=length > 1e-12)
    return Part(kind, triangles.reshape(-1, 3), np.repeat(normals, 3, axis=0), **more)
