"""What the mouse points at, and the rays of one pixel through its lens into the scene.

A panel that is drawn later in a frame, or in the next frame, reads it here. It is no part of the settings.

The rays are those of the renderer's own stages, from every part of the pupil. World frame, mm.

Lengths in mm. Rays are traced from the pixel's film point in the lens frame. The section shows the plane of the axis
and the film point: a lens of rotational symmetry is turned about its axis until the film point lies at (0, +r); the
rays of a lens with cylinders are projected onto the section y–z.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import Bench, bench_of
from lensbench.app.bench.camera_kinds import camera, readings
from lensbench.app.bench.focus_plane import film_position, seen_from
from lensbench.app.bench.ray_fans import DARK, Fan, Ray, blockers, end_text, ideal_fan, ideal_lens_fan, ray_kind
from lensbench.app.bench.water_window import port_of
from lensbench.app.plots.exit_pupil import even_points, from_film, region_of, turn
from lensbench.app.plots.section import quarter_turned
from lensbench.app.scenes.asset_files import Stamp, file_stamp
from lensbench.app.scenes.scene_file import SceneFileError, cached_scene, scene_stamp
from lensbench.app.settings.settings import Settings
from lensbench.app.settings.text_values import format_distance
from lensbench.core.kernels.block import GREEN, RED, TIME, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.scenery.objects.shape import Shape, displaced

Place = tuple[float, float]


@dataclass(frozen=True, eq=False)
class PointedRay:
    """One ray that a point of a plot belongs to.

    path (n, 3): mm, lens frame, from before the lens to the film, or to the surface that ends it. surface: the index of
    that surface, −1 for a ray that passes. end: where it ends, or comes from, in words. target (3,): the point of the
    scene that it comes from, mm in the world, or None; raster: where the picture shows that point, pixels, or None.
    """

    path: np.ndarray
    surface: int
    end: str
    target: np.ndarray | None = None
    raster: Place | None = None


@dataclass
class Pointed:
    """The pixel, the ray and the surfaces under the mouse.

    hover: raster point under the mouse in the picture. pinned: a kept pixel, as parts of the picture's width and
    height, so that it survives another size of the picture. ray, surfaces: what all panels show in this frame; the
    surfaces are indices into the lens, empty for none. A panel whose ray or surfaces lie under the mouse sets them for
    the next frame, by `point_at_ray` and `point_at_surfaces`.
    """

    hover: Place | None = None
    pinned: Place | None = None
    ray: PointedRay | None = None
    surfaces: tuple[int, ...] = ()
    _next_ray: PointedRay | None = field(default=None, repr=False)
    _next_surfaces: tuple[int, ...] = field(default=(), repr=False)

    def advance(self) -> None:
        """Begin a frame: show what the panels of the frame before have found under the mouse."""
        self.ray, self.surfaces = self._next_ray, self._next_surfaces
        self._next_ray, self._next_surfaces = None, ()

    def point_at_ray(self, ray: PointedRay) -> None:
        """A point that this ray belongs to lies under the mouse."""
        self._next_ray = ray

    def point_at_surfaces(self, surfaces: tuple[int, ...]) -> None:
        """These surfaces lie under the mouse."""
        self._next_surfaces = surfaces

    def pixel(self, pixels_x: int, pixels_y: int) -> Place | None:
        """The middle of the pixel whose rays are shown, in raster pixels: the pinned one, else that under the mouse."""
        raster = self.hover if self.pinned is None else (self.pinned[0] * pixels_x, self.pinned[1] * pixels_y)
        if raster is None:
            return None
        column, row = (min(max(int(coordinate), 0), count - 1)
                       for coordinate, count in zip(raster, (pixels_x, pixels_y), strict=True))
        return column + 0.5, row + 0.5

    def toggle_pin(self, share: Place) -> None:
        """Pin the pixel at these parts of width and height, or unpin the one that is pinned."""
        self.pinned = share if self.pinned is None else None


LIGHT = 400                     # points of the pupil, for the light: of its rim too, which a grid would miss
RIM = 10                        # points along each side of the pupil's square
SHOWN = 9                       # rays that are drawn
TOUCH = 0.5                     # mm from a surface that count as on it


@dataclass(frozen=True, eq=False)
class Beam:
    """Rays of one raster point.

    origins, directions (n, 3): of the shown rays, from left to right where they leave the camera; none where no light
    passes. ends (n,): how far each runs until it meets something, inf for the sky. light: on the film, as a part of
    that on the axis without vignetting. target (3,): what the ray through the middle of the pupil meets, or None for
    the sky; along: how far off that is (mm), inf for the sky, nan without light; ahead: the same along the camera's
    axis, from where the focus is measured. thing: the name of that object, or "".
    """

    origins: np.ndarray
    directions: np.ndarray
    ends: np.ndarray
    light: float
    target: np.ndarray | None
    along: float
    ahead: float
    thing: str


def beam(settings: Settings, raster: Place) -> Beam:
    """The rays of a raster point; ValueError or OSError where there is no camera."""
    of = settings.plain("seed", "view", "samples", "exposure", "tone", "overlay", "compare", "wipe")
    return _beam(of, raster, file_stamp(settings.lens), scene_stamp(settings.scene))


@lru_cache(maxsize=4)
def _still_camera(settings: Settings, lens: Stamp) -> lb.Camera:
    """The camera at the world's origin: its pupils are solved once for every place of it.

    A fitted polynomial is replaced by the lens that it was fitted to: to fit it would hold up the frame.
    """
    return camera(replace(settings, lens_model="trace") if settings.has_lens and settings.follows_lens else settings)


@lru_cache(maxsize=8)
def _beam(settings: Settings, raster: Place, lens: Stamp, scene: tuple[Stamp, ...]) -> Beam:
    of = _still_camera(settings.optics, lens)
    edge, inner = np.linspace(0.0, 1.0, RIM), even_points(LIGHT)
    rim = np.concatenate([np.column_stack([edge, np.full(RIM, side)][::turn]) for side in (0.0, 1.0)
                          for turn in (1, -1)])
    uv = np.concatenate([[of.pupil_centre], inner, rim])
    rays = of.generate_rays(np.tile([raster], (len(uv), 1)), uv)
    light = float(np.mean(rays.weights[1:1 + LIGHT]))
    if not rays.weights[0] > 0.0 and not light > 0.0:
        none = np.zeros((0, 3))
        return Beam(none, none, np.zeros(0), 0.0, None, math.nan, math.nan, "")

    # Choose rays from left to right; the first is the chief ray, or the first that passes in its place
    lit = np.flatnonzero(rays.weights > 0.0)
    chief = int(lit[0])
    aside = np.cross(rays.directions[chief], [0.0, 1.0, 0.0])
    order = lit[np.argsort(rays.origins[lit] @ aside, kind="stable")]
    chosen = order[np.unique(np.linspace(0, len(order) - 1, SHOWN).round().astype(int))]
    pose = settings.present_pose
    which = np.concatenate([[chief], chosen])
    origins = rays.origins[which] @ pose[:3, :3].T + pose[:3, 3]
    directions = rays.directions[which] @ pose[:3, :3].T

    # What they meet
    try:
        ends = distances(settings.scene, scene, origins, directions, settings.moment)
    except (SceneFileError, OSError):           # the render says that the scene cannot be read
        ends = np.full(len(which), math.inf)
    along = float(ends[0])
    if not math.isfinite(along):
        return Beam(origins[1:], directions[1:], ends[1:], light, None, math.inf, math.inf, "")
    target = origins[0] + along * directions[0]
    ahead = float((target - pose[:3, 3]) @ -pose[:3, 2])
    thing = thing_at(_near(settings, scene, target), target, settings.moment)
    return Beam(origins[1:], directions[1:], ends[1:], light, target, along, ahead, thing[0] if thing else "floor")


@lru_cache(maxsize=2)
def _depth(scene: str, stamp: tuple[Stamp, ...], moment: float) -> Program:
    return Program(cached_scene(scene).depth_steps(moment))


def distances(scene: str, stamp: tuple[Stamp, ...], origins: np.ndarray, directions: np.ndarray,
              moment: float) -> np.ndarray:
    """How far (n,) in mm rays (n, 3) of the world run at a time (s) until they meet the scene; inf for the sky.

    By the renderer's own stages, in float32: ten times as fast as `Scene.distance` where there are many objects.
    SceneFileError or OSError for a scene that cannot be read.
    """
    o, d = origins.T, directions.T
    values = {X: o[0], Y: o[1], Z: o[2], L: d[0], M: d[1], N: d[2], TIME: np.zeros(len(origins))}
    away, met = _depth(scene, stamp, moment).run(values, [RED, GREEN], len(origins))
    return np.where(met > 0.0, away, math.inf)


def thing_at(shapes: Iterable[Shape], point: np.ndarray, moment: float) -> tuple[str, np.ndarray] | None:
    """The shape that a world point (mm) lies on at a time (s), and the point in the frame of the shape.

    A sphere has the axes of the world, a planar shape its half-axes and normal; rotation by a spin does not count.
    """
    for thing in shapes:
        shape = displaced(thing, moment) if thing.moves else thing
        local = shape.locate(point, TOUCH)
        if local is not None:
            return shape.label, local
    return None


@lru_cache(maxsize=2)
def _balls(scene: str, stamp: tuple[Stamp, ...]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Centres (n, 3), velocities (n, 3) and bounding radii (n,) of the objects of a scene."""
    shapes = cached_scene(scene).objects
    return (np.array([shape.centre for shape in shapes]).reshape(-1, 3),
            np.array([shape.velocity for shape in shapes]).reshape(-1, 3),
            np.array([shape.bounding_radius for shape in shapes]))


def _near(settings: Settings, stamp: tuple[Stamp, ...], point: np.ndarray) -> list[Shape]:
    """The objects of the scene that may hold a point."""
    centres, velocities, radii = _balls(settings.scene, stamp)
    away = np.linalg.norm(centres + settings.moment * velocities - point, axis=1)
    shapes = cached_scene(settings.scene).objects
    return [shapes[i] for i in np.flatnonzero(away <= 1.01 * radii + TOUCH)]


class Landing(NamedTuple):
    """Where a ray meets the scene.

    point (3,): in the world (mm), None for the sky and for a ray that is not followed. raster: where the picture shows
    that point (pixels), or None. text: the same in words.
    """

    point: np.ndarray | None
    raster: Place | None
    text: str


def landing(settings: Settings, path: np.ndarray) -> Landing:
    """Where a ray that passes the lens comes from; path (n, 3): mm, lens frame, from before the lens to the film."""
    try:
        of = _still_camera(settings.optics, file_stamp(settings.lens))
    except (ValueError, OSError) as error:              # such as an edited lens that opens no longer as far
        return Landing(None, None, f"not followed, for there is no picture: {error}")
    pose, film_z = settings.present_pose, path[-1, 2]
    if of.has_port:
        return Landing(None, None, "not followed through the window into water")
    start, way = path[1] - [0.0, 0.0, film_z], path[0] - path[1]
    origin, direction = pose[:3, :3] @ start + pose[:3, 3], pose[:3, :3] @ (way / np.linalg.norm(way))
    try:
        stamp = scene_stamp(settings.scene)
        distance = float(distances(settings.scene, stamp, origin[None], direction[None], settings.moment)[0])
    except (SceneFileError, OSError):
        return Landing(None, None, "the scene cannot be read")
    if not math.isfinite(distance):
        return Landing(None, None, "from the sky")
    point = origin + distance * direction
    there = (point - pose[:3, 3]) @ pose[:3, :3]
    raster, visible = of.raster_from_point([there])
    thing = thing_at(_near(settings, stamp, point), point, settings.moment)
    return Landing(point, (float(raster[0][0]), float(raster[0][1])) if visible[0] else None,
                   f"from the {thing[0] if thing else 'floor'}, {format_distance(-float(there[2]))} ahead")


COUNT = 9                       # rays that reach the scene
DEAD_EACH_SIDE = 3
INSIDE = 1.0 - 1e-5             # of the way to the outline, whose chords and bisections err by a part of this


def film_place(settings: Settings, raster: Place) -> Place:
    """The film point (x, y) in mm of a raster point, lens frame: upside down on the film."""
    return film_position(settings, raster)[:2]


def pixel_fan(settings: Settings, raster: Place, above: bool = False) -> Fan:
    """The rays of a raster point in the section; ValueError or OSError for a camera without any lens.

    above: in the section x–z of a lens without rotational symmetry.
    """
    film_xy = film_place(settings, raster)
    if settings.kind.ideal_lens:
        return _perspective_fan(settings.optics, math.hypot(*film_xy))
    if not settings.has_lens:
        raise ValueError(f"{settings.camera_title}: no lens to draw the rays in")
    built, _ = seen_from(settings, raster)
    if not settings.follows_lens:
        return ideal_lens_fan(built.lens, built.film_distance, "pixel", math.hypot(*film_xy),
                              COUNT if settings.has_stop else 1)
    if above:
        return _traced_fan(quarter_turned(built.lens), built.film_distance, (-film_xy[1], film_xy[0]))
    return _traced_fan(built.lens, built.film_distance, film_xy)


def _perspective_fan(settings: Settings, radius: float) -> Fan:
    got = readings(settings)
    if got.efl is None:
        raise ValueError(got.reason)
    opening = 0.0 if settings.f_number is None else 0.5 * (got.entrance_pupil or 0.0)
    focus = port_of(settings).apparent(settings.focus_distance)
    return ideal_fan("pixel", radius, 1.0 / (1.0 / got.efl + 1.0 / focus), 0.0, 0.0, got.efl, 0.0,
                     opening, COUNT if opening else 1, -8.0 * got.efl)


@lru_cache(maxsize=8)
def _traced_fan(lens: lb.Lens, film_distance: float, film_xy: Place) -> Fan:
    radius = math.hypot(*film_xy) if lens.is_rotationally_symmetric else film_xy[1]
    pupil = region_of(lens, film_distance, film_xy)
    if pupil.area <= 0.0:
        return Fan("pixel", radius, (), DARK)
    back = turn(lens, film_xy)

    # Along a line upward through the middle of the region, from one side of its outline to the other
    middle = pupil.outline.mean(0)
    x, y = pupil.outline.T
    after_x, after_y = np.roll(x, -1), np.roll(y, -1)
    cut = (x < middle[0]) != (after_x < middle[0])
    share = (middle[0] - x[cut]) / (after_x[cut] - x[cut])
    heights = y[cut] + share * (after_y[cut] - y[cut]) - middle[1]
    low, high = INSIDE * float(heights.min()), INSIDE * float(heights.max())

    def rear(offsets: np.ndarray) -> np.ndarray:
        """Points on the plane of the last vertex, lens frame, at these heights (mm) from the middle."""
        return (middle + np.column_stack([np.zeros_like(offsets), offsets])) @ back

    step = (high - low) / (COUNT - 1)
    dead = [end + sign * k * step for end, sign in ((low, -1.0), (high, 1.0)) for k in range(1, DEAD_EACH_SIDE + 1)]
    offsets = np.concatenate([np.linspace(low, high, COUNT), dead])
    trace = from_film(lens, film_distance, film_xy, rear(offsets), record=True)
    ended = blockers(lens, trace, forward=False)
    assert trace.paths is not None
    far = _upright(trace.points + beginning_before(lens, film_distance) * trace.directions, back)
    paths, rays = _upright(trace.paths, back), []
    for i, passes in enumerate(trace.fate == lb.Fate.PASSED):
        path = np.concatenate([far[i:i + 1], paths[i, ::-1]]) if passes else paths[i, np.isfinite(paths[i, :, 0])]
        if passes:
            rays.append(Ray.passing(path, ray_kind(i, COUNT)))
        else:
            rays.append(Ray(path, "dead", end_text(lens, lb.Fate(int(trace.fate[i])), int(ended[i])), int(ended[i])))
    return Fan("pixel", radius, tuple(rays))


def path_of(lens: lb.Lens, trace: lb.Trace, i: int) -> np.ndarray:
    """Path (n, 3) of ray i of a recorded trace from the film, lens frame.

    A ray that passes runs from far before the lens to the film, one that is lost from the film to where it ends.
    """
    assert trace.paths is not None
    path = trace.paths[i][np.isfinite(trace.paths[i][:, 0])]
    if trace.fate[i] != lb.Fate.PASSED:
        return path
    beginning = beginning_before(lens, path[0, 2] - lens.length)
    return np.vstack([trace.points[i] + beginning * trace.directions[i], path[::-1]])


def path_before_lens(lens: lb.Lens, film_distance: float, point: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Where a ray towards the film begins far before the lens (3,), from a point of it and its direction there."""
    return np.asarray(point - beginning_before(lens, film_distance) * direction)


def beginning_before(lens: lb.Lens, film_distance: float) -> float:
    """How far before the lens (mm) its rays begin."""
    return 4.0 * (lens.length + film_distance) + 20.0 * lens.surfaces[0].semi_diameter


def _upright(points: np.ndarray, back: np.ndarray) -> np.ndarray:
    """Points (..., 3) of the lens frame as (z, y) of the section."""
    return np.stack([points[..., 2], points[..., :2] @ back[1]], axis=-1)


def in_section(settings: Settings, raster: Place | None, ray: PointedRay, above: bool = False) -> np.ndarray:
    """The path (n, 2) of a pointed ray as (z, y) of the section, in which the film point of the pixel is upright.

    above: as (z, x), of a lens without rotational symmetry.
    """
    lens = bench_of(settings).lens
    back = np.eye(2) if raster is None else turn(lens, film_place(settings, raster))
    if above and not lens.is_rotationally_symmetric:
        back = back[::-1]
    return _upright(ray.path, back)


def rear_place(settings: Settings, raster: Place | None, ray: PointedRay) -> np.ndarray | None:
    """Where a pointed ray that passes crosses the plane of the last vertex: upright (2,) in mm; None for a lost ray."""
    if ray.surface >= 0:
        return None
    lens, (last, film) = bench_of(settings).lens, ray.path[-2:]
    crossed = last + (lens.length - last[2]) / (film[2] - last[2]) * (film - last)
    back = np.eye(2) if raster is None else turn(lens, film_place(settings, raster))
    return crossed[:2] @ back.T


def ray_through(settings: Settings, film_xy: Place, rear_xy: Place, bench: Bench | None = None) -> PointedRay:
    """The ray from a film point (mm) through a point of the plane of the last vertex (mm), both in the lens frame.

    bench: the lens with the film distance of this point, for a tilted or decentred film.
    """
    built = bench_of(settings) if bench is None else bench
    trace = from_film(built.lens, built.film_distance, film_xy, np.array([rear_xy]), record=True)
    surface = int(blockers(built.lens, trace, forward=False)[0])
    path = path_of(built.lens, trace, 0)
    if surface >= 0:
        return PointedRay(path, surface, end_text(built.lens, lb.Fate(int(trace.fate[0])), surface))
    landed = landing(settings, path)
    return PointedRay(path, surface, landed.text, landed.point, landed.raster)
