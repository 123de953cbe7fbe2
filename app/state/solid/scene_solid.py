"""The things of the scene as solids, and a piece of its floor. Lengths in mm, world frame."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.state.file_cache import Stamp
from lensbench.app.state.scene_file import SceneFileError, cached_scene, scene_stamp
from lensbench.app.state.settings import Settings
from lensbench.app.state.solid.shapes import Part, Rgb, Strokes, flat_part, grid_part, pieces_of
from lensbench.kernels.byte_cache import byte_cache
from lensbench.scenery.objects import Shape, displaced

RINGS, AROUND = 13, 25          # points of a sphere from pole to pole, and about it
MOST_TRIANGLES = 20_000         # of a mesh that is drawn: of more, every second, third, …
LONGEST = 20_000.0              # mm: larger things are skies
WALL, SMALL_WALL = 0.6, 900.0   # radius of a planar thing about the camera, of its distance and in mm: it is a wall
MOST_KEPT = 12 << 20            # bytes of two scenes; a larger one is kept alone
TILE, FLOOR_TILES = 250.0, 16   # mm of a drawn tile of the floor, and how many each way


def scene_parts(settings: Settings) -> tuple[tuple[Part, ...], tuple[Strokes, ...]]:
    """The things of the scene, and lines: the edges of planar things and the tiles of the floor before the camera.

    A wall or a sky that would hide the view is left out; its edge is drawn.
    """
    stamp, pose = scene_stamp(settings.scene), settings.present_pose
    found = _things(settings.scene, settings.moment, stamp)
    if found is None:
        return (), ()
    away = np.linalg.norm(found.centres - pose[:3, 3], axis=1)
    hides = found.planar & (found.radii > WALL * away) & (found.radii > SMALL_WALL) | (found.radii > LONGEST)
    parts = tuple(part for part, hidden in zip(found.parts, hides, strict=True) if not hidden)
    if found.floor is None:
        return parts, found.edges
    ahead = pose[:3, 3] - 1500.0 * pose[:3, 2]
    at = tuple(float(TILE * round(float(place) / TILE)) for place in ahead)
    return parts, (*found.edges, _tiles(found.floor, at))


@dataclass(frozen=True, eq=False)
class _Things:
    """The objects of a scene: their solids, centres (n, 3), bounding radii (n,), which are planar, and all edges."""

    parts: tuple[Part, ...]
    centres: np.ndarray
    radii: np.ndarray
    planar: np.ndarray
    edges: tuple[Strokes, ...]
    floor: lb.Floor | None


@byte_cache(MOST_KEPT, 2)
def _things(scene: str, moment: float, stamp: tuple[Stamp, ...]) -> _Things | None:
    try:
        found = cached_scene(scene)
    except (SceneFileError, OSError):
        return None
    shapes = [displaced(shape, moment) if shape.moves else shape for shape in found.objects]
    edges = [_edge(shape) for shape in shapes if shape.family == "planar"]
    lines = (Strokes("edge", np.concatenate([pieces_of(edge) for edge in edges])),) if edges else ()
    return _Things(tuple(map(_solid, shapes)), np.array([shape.centre for shape in shapes]).reshape(-1, 3),
                   np.array([shape.bounding_radius for shape in shapes]),
                   np.array([shape.family == "planar" for shape in shapes], bool), lines, found.floor)


def _solid(shape: Shape) -> Part:
    """A shape of the world."""
    material = shape.material
    kind, brightest = ("shining" if material.shines else "thing"), max(*material.colour, 1.0)
    red, green, blue = (float(part) / brightest for part in material.colour)
    tint: Rgb = (red, green, blue)
    centre = np.asarray(shape.centre)
    if shape.family == "sphere":
        down, turn = np.linspace(0.0, np.pi, RINGS)[:, None], np.linspace(0.0, 2.0 * np.pi, AROUND)
        away = np.stack([np.sin(down) * np.cos(turn), np.cos(down) + 0.0 * turn, np.sin(down) * np.sin(turn)], -1)
        part = grid_part(kind, centre + shape.bounding_radius * away, tint=tint)
        return Part(kind, part.points, (part.points - centre) / shape.bounding_radius, None, tint)
    if shape.family != "planar":
        return flat_part(kind, shape.facets(MOST_TRIANGLES), tint=tint)
    edge = _edge(shape)[:-1]
    triangles = np.stack([np.broadcast_to(edge[0], (len(edge) - 2, 3)), edge[1:-1], edge[2:]], axis=1)
    return flat_part(kind, triangles, tint=tint)


def _edge(shape: Shape) -> np.ndarray:
    """The edge of a planar shape of the world, a closed path (n, 3)."""
    a, b = (np.asarray(half) for half in shape.half_axes)
    if shape.round:
        turn = np.linspace(0.0, 2.0 * np.pi, AROUND)[:, None]
        return np.asarray(shape.centre) + np.cos(turn) * a + np.sin(turn) * b
    signs = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]])
    return np.asarray(shape.centre) + signs @ np.stack([a, b])


@lru_cache(maxsize=4)
def _tiles(floor: lb.Floor, before: tuple[float, float, float]) -> Strokes:
    """Lines of a piece of the floor below a point before the camera."""
    normal = np.asarray(floor.normal, float) / np.linalg.norm(floor.normal)
    right = np.cross([0.0, 0.0, 1.0] if abs(normal[2]) < 0.9 else [1.0, 0.0, 0.0], normal)
    right /= np.linalg.norm(right)
    ahead = np.cross(normal, right)
    middle = np.asarray(before) - (np.asarray(before) @ normal - floor.height) * normal
    reach = TILE * FLOOR_TILES / 2
    lines = []
    for s in TILE * np.arange(-FLOOR_TILES // 2, FLOOR_TILES // 2 + 1):
        lines += [[middle + s * right - reach * ahead, middle + s * right + reach * ahead],
                  [middle + s * ahead - reach * right, middle + s * ahead + reach * right]]
    return Strokes("floor", np.array(lines))
