"""A photograph with a depth map as a scene: every cell of the map a small luminous surface at its distance.

Cells are joined with the neighbours that lie at about their distance and cut from the others, along the rays of the
photograph. A pinhole in its place therefore sees the photograph again, without gaps; a lens, or a camera beside it,
sees its near and far things apart. What things in front hide is unknown: behind their edges the surface behind goes on
at its distance, in its colours.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.scenery.objects.material import Image, Material, Pattern
from lensbench.core.scenery.objects.mesh import Mesh
from lensbench.core.scenery.objects.surroundings import Sky
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.values import SceneError
from lensbench.core.text import significant

CELLS = 400_000         # of the depth map, at the most: larger maps are reduced
LEAST_AWAY = 1e-3       # mm
JOINED = 1.06           # greatest ratio of the distances of neighbours on one surface
BEHIND = 0.08           # of the longer side: how far the surface behind a thing goes on
MARK = (1.0, 0.0, 1.0)


def photograph_scene(photograph: ArrayLike, depth: ArrayLike, fov: float, *, fill: str = "plain",
                     name: str = "photograph") -> Scene:
    """Scene that a photograph and its depth map show.

    The camera of the photograph stands at the world's origin and looks along −z.

    Args:
        photograph: array_like, shape (h, w, 3). Linear red, green and blue, the top row first.
        depth: array_like, shape (k, m). Distances along the axis, mm, of the same view with any number of pixels; inf
            is the farthest distance of the map times four.
        fov: Angle of view across the width of the photograph, radians.
        fill: {"plain", "shown", "none"}. What things in front hide, near their edges: the surface behind in its own
            colours, the same in magenta, or nothing.
        name: Of the scene.
    Returns:
        Luminous meshes; the sky has the mean colour of the photograph, darkened.
    Raises:
        SceneError: If a shape is wrong, a distance is not positive, a colour is negative or not finite, or `fov` is out
            of range.
    """
    picture, away = np.asarray(photograph, np.float32), np.asarray(depth, np.float64)
    if picture.ndim != 3 or picture.shape[2] != 3 or min(picture.shape[:2]) < 2:
        raise SceneError(f"a photograph has the shape (h, w, 3), not {picture.shape}")
    if away.ndim != 2 or min(away.shape) < 2:
        raise SceneError(f"a depth map has the shape (h, w), not {away.shape}")
    if not (np.isfinite(picture).all() and picture.min() >= 0.0):
        raise SceneError("the photograph has values that are negative or not finite")
    if np.isnan(away).any() or not away.min() >= LEAST_AWAY:
        raise SceneError(f"the depth map has distances that are not positive, or below {significant(LEAST_AWAY)} mm")
    if not 0.0 < fov < math.pi:
        raise SceneError(f"fov {significant(fov)}: it must lie between 0 and π radians")
    if fill not in ("plain", "shown", "none"):
        raise SceneError(f"fill {fill!r}: choose one of plain, shown, none")
    known = np.isfinite(away)
    if not known.any():
        raise SceneError("the depth map has no finite distance")
    away = np.where(known, away, 4.0 * away[known].max())
    shape = picture.shape[0] / picture.shape[1]
    if not 0.9 < away.shape[0] / away.shape[1] / shape < 1.1:
        raise SceneError(f"the depth map of {away.shape[1]} × {away.shape[0]} has another shape than the photograph of "
                         f"{picture.shape[1]} × {picture.shape[0]}")
    away = reduced(away)
    half = math.tan(fov / 2.0)
    whole = Material((1.0, 1.0, 1.0), "light", pattern=Pattern("image", image=Image.of(picture)))
    corners, faces, uv = _surface(away, np.ones(away.shape, bool), half, shape)
    meshes = [Mesh.of(corners, faces, whole, uv=uv, name="photograph")]
    if fill != "none":
        behind, colours, hidden = _background(away, picture)
        if hidden.any():
            corners, faces, _ = _surface(behind, hidden, half, shape)
            tints = np.repeat(colours[hidden], 4, 0) if fill == "plain" else None
            colour = (1.0, 1.0, 1.0) if fill == "plain" else MARK
            meshes.append(Mesh.of(corners, faces, Material(colour, "light"), colours=tints, name="filled part"))
    red, green, blue = (float(x) for x in 0.25 * picture.mean((0, 1)))
    dim = (red, green, blue)
    near, far = np.percentile(away, [2.0, 98.0])
    return Scene(name, sky=Sky(dim, dim, dim), meshes=tuple(meshes),
                 depth_range=(float(0.8 * near), float(max(1.2 * far, 1.6 * near))))


def reduced(away: np.ndarray) -> np.ndarray:
    """A map (h, w) of at most CELLS: one value of each part, so that no edge gets a distance between both sides."""
    step = math.ceil(math.sqrt(away.size / CELLS))
    return away[step // 2::step, step // 2::step] if step > 1 else away


def _around(values: np.ndarray, fallback: float) -> np.ndarray:
    """Values of the four cells around each corner, (h + 1, w + 1, 4)."""
    padded = np.pad(values, 1, constant_values=fallback)
    return np.stack([padded[:-1, :-1], padded[:-1, 1:], padded[1:, :-1], padded[1:, 1:]], -1)


def _surface(away: np.ndarray, covered: np.ndarray, half: float, shape: float
             ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Corners, triangles and places in the photograph of the wanted cells; half: tangent of half the angle of view.

    A corner of a cell lies at the mean inverse distance of those cells around it that belong to the cell's surface.
    """
    rows, columns = away.shape
    line, column = np.nonzero(covered)
    near = _around(np.where(covered, 1.0 / away, 0.0), 0.0)
    own = 1.0 / away[line, column]
    x, y, inverse = [], [], []
    for down, right in ((0, 0), (0, 1), (1, 1), (1, 0)):
        others = near[line + down, column + right]
        joined = (others < own[:, None] * JOINED) & (others > own[:, None] / JOINED)
        inverse.append((others * joined).sum(1) / joined.sum(1))
        x.append((column + right) / columns)
        y.append((line + down) / rows)
    u, v, z = (np.stack(axis, 1).ravel() for axis in (x, y, inverse))
    z = 1.0 / z
    corners = np.column_stack([(2.0 * u - 1.0) * half * z, (1.0 - 2.0 * v) * half * shape * z, -z])
    first = 4 * np.arange(len(line))[:, None]
    faces = np.concatenate([first + [0, 3, 2], first + [0, 2, 1]])
    return corners, faces, np.column_stack([u, 1.0 - v])


def _background(away: np.ndarray, picture: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Distances and colours of what things hide, and the cells near their edges behind which it goes on.

    Farther distances spread from cell to cell into the things in front; so do the colours there.
    """
    rows, columns = away.shape
    line = ((np.arange(rows) + 0.5) * picture.shape[0] / rows).astype(int)
    column = ((np.arange(columns) + 0.5) * picture.shape[1] / columns).astype(int)
    behind, colours = away.copy(), picture[line][:, column].astype(np.float64)
    for _ in range(math.ceil(BEHIND * max(rows, columns))):
        padded = np.pad(behind, 1, mode="edge")
        tints = np.pad(colours, ((1, 1), (1, 1), (0, 0)), mode="edge")
        total, count, tint = np.zeros(away.shape), np.zeros(away.shape), np.zeros(colours.shape)
        for down, right in ((0, 1), (2, 1), (1, 0), (1, 2)):
            there = padded[down:down + rows, right:right + columns]
            farther = there > behind * JOINED
            total += np.where(farther, there, 0.0)
            count += farther
            tint += farther[..., None] * tints[down:down + rows, right:right + columns]
        spread = count > 0.0
        if not spread.any():
            break
        behind = np.where(spread, total / np.maximum(count, 1.0), behind)
        colours = np.where(spread[..., None], tint / np.maximum(count, 1.0)[..., None], colours)
    return behind, colours, behind > away * JOINED
