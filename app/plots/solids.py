"""The lens and the things of the scene as solids, and the eye of the 3-D view. Lengths in mm.

Lengths in mm, in the camera's frame; things of the scene in the world's. The camera's frame has its origin in the
middle of the film; x points right, y up, and the camera looks along −z.

The cut is the section y–z; what lies at x < 0 is taken away, so that the section's rays lie open. From there the scene
is at the left, as in the section.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.plots.section import Sketch, before_roll, elements, sag
from lensbench.app.scenes.asset_files import Stamp
from lensbench.app.scenes.scene_file import SceneFileError, cached_scene, scene_stamp
from lensbench.app.settings.settings import Settings
from lensbench.core.kernels.byte_cache import byte_cache
from lensbench.core.scenery.objects.shape import Shape, displaced

STEEPEST = math.radians(89.0)
OPENING = math.radians(28.0)    # of the shorter side of the view
NEAR, FAR = 0.02, 400.0         # of the distance: planes between which things are drawn
CLOSEST, FARTHEST = 1.0, 2e5    # mm


@dataclass(frozen=True)
class Eye:
    """Looks at `target` (mm) from a distance; yaw about the upward axis from +z, pitch above the horizon."""

    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    distance: float = 300.0
    yaw: float = math.radians(-65.0)
    pitch: float = math.radians(18.0)

    @property
    def axes(self) -> np.ndarray:
        """Rows: right, up, and from the target to the eye; unit vectors."""
        cy, sy, cp, sp = math.cos(self.yaw), math.sin(self.yaw), math.cos(self.pitch), math.sin(self.pitch)
        return np.array([[cy, 0.0, -sy], [-sy * sp, cp, -cy * sp], [sy * cp, sp, cy * cp]])

    @property
    def place(self) -> np.ndarray:
        """Where the eye is (mm)."""
        return np.asarray(self.target) + self.distance * self.axes[2]

    def clip_from_camera(self, width: float, height: float) -> np.ndarray:
        """The matrix (4, 4) from the camera's frame to OpenGL's clip space, for a view of this shape."""
        view = np.eye(4)
        view[:3, :3] = self.axes
        view[:3, 3] = -self.axes @ self.place
        slope, shorter = math.tan(0.5 * OPENING), min(width, height)
        near, far = NEAR * self.distance, FAR * self.distance
        lens = np.zeros((4, 4))
        lens[0, 0], lens[1, 1] = shorter / width / slope, shorter / height / slope
        lens[2, 2], lens[2, 3], lens[3, 2] = (far + near) / (near - far), 2.0 * far * near / (near - far), -1.0
        return lens @ view

    def turned(self, right: float, down: float) -> "Eye":
        """Turned by a drag (radians): things follow the hand."""
        pitch = min(max(self.pitch + down, -STEEPEST), STEEPEST)
        return replace(self, yaw=math.remainder(self.yaw - right, 2.0 * math.pi), pitch=pitch)

    def moved(self, right: float, up: float) -> "Eye":
        """The target moved across the view by these lengths (mm)."""
        x, y, z = (float(v) for v in np.asarray(self.target) + right * self.axes[0] + up * self.axes[1])
        return replace(self, target=(x, y, z))

    def zoomed(self, factor: float) -> "Eye":
        """Nearer for a factor above 1."""
        return replace(self, distance=min(max(self.distance / factor, CLOSEST), FARTHEST))

    def fitted(self, low: np.ndarray, high: np.ndarray, width: float, height: float) -> "Eye":
        """In the same direction, with a box between two corners (3,) in a view of this shape."""
        corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        middle = 0.5 * (np.asarray(low) + np.asarray(high))
        right, up, back = ((corners - middle) @ self.axes.T).T
        slope, shorter = math.tan(0.5 * OPENING), min(width, height)
        needed = np.maximum(np.abs(right) * shorter / width, np.abs(up) * shorter / height) / slope + back
        x, y, z = (float(v) for v in middle)
        return replace(self, target=(x, y, z), distance=min(max(1.06 * float(needed.max()), CLOSEST), FARTHEST))


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


ACROSS = 17                     # points along each side of a curved film
LENS_SOLID_AROUND = 37                     # points about the axis, from +y past +x to −y
TURNS = 0.5 * np.pi * np.linspace(1.0, -1.0, LENS_SOLID_AROUND)
LENS_SOLID_MOST_KEPT = 6 << 20             # bytes of glass: three double Gausses
RADII = np.sin(0.5 * np.pi * np.linspace(0.0, 1.0, 15))        # parts of a rim, closer towards it


def lens_parts(shown: Sketch) -> tuple[Part, ...]:
    """The glass, the stop and the film of a section; without a lens the film and an opening alone."""
    solids: list[Part] = []
    if shown.lens is not None:
        solids += _glass(shown.lens, shown.glasses, shown.film_z)
    if shown.stop_radius is not None:
        outer = max(1.12 * (shown.open_radius or shown.stop_radius), 1.08 * shown.near_stop)
        solids.append(_ring(shown.stop_z - shown.film_z, shown.stop_radius, outer))
    return tuple(solids)


@byte_cache(LENS_SOLID_MOST_KEPT, 8)
def _glass(lens: lb.Lens, glasses: tuple[lb.Glass, ...], film_z: float) -> tuple[Part, ...]:
    """Of each element the half shell and its cut face."""
    solids = []
    for element in elements(lens):
        of = glasses[element.front]
        glass = of.n_d, of.v_d if of.v_d is not None else 60.0
        front, rear = lens.surfaces[element.front], lens.surfaces[element.front + 1]
        edge = float(np.abs(element.outline[:, 1]).max())
        z = [lens.vertices[element.front] - film_z, lens.vertices[element.front + 1] - film_z]
        sheets = [_placed(_sheet(surface, vertex_z, edge), lens, i, film_z) for surface, vertex_z, i in zip(
            (front, rear), z, (element.front, element.front + 1), strict=True)]
        shell = np.concatenate([sheets[0], sheets[1][::-1]])
        both = element.front, element.front + 1
        solids.append(grid_part("glass", shell, glass=glass, surfaces=both))
        quads = np.concatenate([np.zeros((*element.strips.shape[:2], 1)), element.strips[..., ::-1]], axis=2)
        quads[..., 2] -= film_z
        triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        cut = flat_part("cut", triangles, glass=glass)
        solids.append(Part("cut", cut.points, np.tile([-1.0, 0.0, 0.0], (len(cut.points), 1)), glass, surfaces=both))
    return tuple(solids)


@lru_cache(maxsize=8)
def lens_outlines(lens: lb.Lens, film_z: float) -> Strokes:
    """The edges of the cut faces."""
    closed = [np.vstack([element.outline, element.outline[:1]]) for element in elements(lens)]
    return strokes("outline", [np.column_stack([np.zeros(len(edge)), edge[:, 1], edge[:, 0] - film_z])
                               for edge in closed])


def _sheet(surface: lb.Surface, z: float, edge: float) -> np.ndarray:
    """Half a surface (radii, AROUND, 3) from its vertex to the edge of its element, flat beyond its rim."""
    rim = min(surface.semi_diameter, edge)
    radii = np.append(rim * RADII, edge) if edge > rim else rim * RADII
    x, y = radii[:, None] * np.cos(TURNS), radii[:, None] * np.sin(TURNS)
    return np.stack([x, y, z + sag(surface, x, y)], axis=-1)


def _placed(points: np.ndarray, lens: lb.Lens, i: int, film_z: float) -> np.ndarray:
    """Points (…, 3) of surface i as if centred, camera frame, moved by its pose; the roll is in the points."""
    frame = lens.frames[i]
    if frame is None:
        return points
    return (points + [0.0, 0.0, film_z]) @ before_roll(lens, i).T + frame.shift - [0.0, 0.0, film_z]


def _ring(z: float, inner: float, outer: float) -> Part:
    """Half a flat ring."""
    radii = np.array([[inner], [outer]])
    x, y = radii * np.cos(TURNS), radii * np.sin(TURNS)
    return grid_part("stop", np.stack([x, y, np.full_like(x, z)], axis=-1))


def film_part(film: lb.Film, pose: lb.FilmPose) -> Part:
    """The film's surface."""
    shares = np.linspace(-0.5, 0.5, ACROSS if pose.is_curved else 2)
    return grid_part("film", pose.points(np.stack(np.meshgrid(shares * film.width, shares * film.height), -1)))


def film_outline(film: lb.Film, pose: lb.FilmPose) -> np.ndarray:
    """Its edge, a closed path (n, 3)."""
    side = np.linspace(-0.5, 0.5, ACROSS if pose.is_curved else 2)[:-1]
    low = np.full_like(side, -0.5)
    x = np.concatenate([side, -low, -side, low, [-0.5]])
    y = np.concatenate([low, side, -low, -side, [-0.5]])
    return pose.points(np.column_stack([x * film.width, y * film.height]))


RINGS, SCENE_SOLID_AROUND = 13, 25          # points of a sphere from pole to pole, and about it
MOST_TRIANGLES = 20_000         # of a mesh that is drawn: of more, every second, third, …
LONGEST = 20_000.0              # mm: larger things are skies
WALL, SMALL_WALL = 0.6, 900.0   # radius of a planar thing about the camera, of its distance and in mm: it is a wall
SCENE_SOLID_MOST_KEPT = 12 << 20            # bytes of two scenes; a larger one is kept alone
TILE, FLOOR_TILES = 250.0, 16   # mm of a drawn tile of the floor, and how many each way


def scene_parts(settings: Settings) -> tuple[tuple[Part, ...], tuple[Strokes, ...]]:
    """The things of the scene, and lines: the edges of planar things and the tiles of the floor before the camera.

    A wall or a sky that would hide the view is left out; its edge is drawn.
    """
    stamp, pose = scene_stamp(settings.scene), settings.present_pose
    things = _things(settings.scene, settings.moment, stamp)
    if things is None:
        return (), ()
    away = np.linalg.norm(things.centres - pose[:3, 3], axis=1)
    hides = things.planar & (things.radii > WALL * away) & (things.radii > SMALL_WALL) | (things.radii > LONGEST)
    solids = tuple(solid for solid, hidden in zip(things.parts, hides, strict=True) if not hidden)
    if things.floor is None:
        return solids, things.edges
    ahead = pose[:3, 3] - 1500.0 * pose[:3, 2]
    tile = tuple(float(TILE * round(float(coordinate) / TILE)) for coordinate in ahead)
    return solids, (*things.edges, _tiles(things.floor, tile))


@dataclass(frozen=True, eq=False)
class _Things:
    """The objects of a scene: their solids, centres (n, 3), bounding radii (n,), which are planar, and all edges."""

    parts: tuple[Part, ...]
    centres: np.ndarray
    radii: np.ndarray
    planar: np.ndarray
    edges: tuple[Strokes, ...]
    floor: lb.Floor | None


@byte_cache(SCENE_SOLID_MOST_KEPT, 2)
def _things(scene: str, moment: float, stamp: tuple[Stamp, ...]) -> _Things | None:
    try:
        opened = cached_scene(scene)
    except (SceneFileError, OSError):
        return None
    shapes = [displaced(shape, moment) if shape.moves else shape for shape in opened.objects]
    edges = [_edge(shape) for shape in shapes if shape.family == "planar"]
    lines = (Strokes("edge", np.concatenate([pieces_of(edge) for edge in edges])),) if edges else ()
    return _Things(tuple(map(_solid, shapes)), np.array([shape.centre for shape in shapes]).reshape(-1, 3),
                   np.array([shape.bounding_radius for shape in shapes]),
                   np.array([shape.family == "planar" for shape in shapes], bool), lines, opened.floor)


def _solid(shape: Shape) -> Part:
    """A shape of the world."""
    material = shape.material
    kind, brightest = ("shining" if material.shines else "thing"), max(*material.colour, 1.0)
    red, green, blue = (float(solid) / brightest for solid in material.colour)
    tint: Rgb = (red, green, blue)
    centre = np.asarray(shape.centre)
    if shape.family == "sphere":
        down, turn = np.linspace(0.0, np.pi, RINGS)[:, None], np.linspace(0.0, 2.0 * np.pi, SCENE_SOLID_AROUND)
        away = np.stack([np.sin(down) * np.cos(turn), np.cos(down) + 0.0 * turn, np.sin(down) * np.sin(turn)], -1)
        solid = grid_part(kind, centre + shape.bounding_radius * away, tint=tint)
        return Part(kind, solid.points, (solid.points - centre) / shape.bounding_radius, None, tint)
    if shape.family != "planar":
        return flat_part(kind, shape.facets(MOST_TRIANGLES), tint=tint)
    edge = _edge(shape)[:-1]
    triangles = np.stack([np.broadcast_to(edge[0], (len(edge) - 2, 3)), edge[1:-1], edge[2:]], axis=1)
    return flat_part(kind, triangles, tint=tint)


def _edge(shape: Shape) -> np.ndarray:
    """The edge of a planar shape of the world, a closed path (n, 3)."""
    a, b = (np.asarray(half) for half in shape.half_axes)
    if shape.round:
        turn = np.linspace(0.0, 2.0 * np.pi, SCENE_SOLID_AROUND)[:, None]
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
