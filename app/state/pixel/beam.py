"""The cone of rays of one pixel in the world, and what it meets there: for every kind of camera.

The rays are those of the renderer's own stages, from every part of the pupil. World frame, mm.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.state.camera_kinds import camera
from lensbench.app.state.file_cache import Stamp, file_stamp
from lensbench.app.state.pixel.pointed import Place
from lensbench.app.state.scene_file import SceneFileError, cached_scene, scene_stamp
from lensbench.app.state.settings import Settings
from lensbench.app.state.text_values import format_distance
from lensbench.kernels.block import GREEN, RED, TIME, L, M, N, X, Y, Z
from lensbench.kernels.program import Program
from lensbench.scenery.objects import Shape, displaced

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
    edge, k = np.linspace(0.0, 1.0, RIM), np.arange(1, LIGHT + 1)
    inner = np.column_stack([k * 0.7548776662466927, k * 0.5698402909980532]) % 1.0     # Roberts 2018
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
    found = thing_at(_near(settings, scene, target), target, settings.moment)
    return Beam(origins[1:], directions[1:], ends[1:], light, target, along, ahead, found[0] if found else "floor")


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
    given = {X: o[0], Y: o[1], Z: o[2], L: d[0], M: d[1], N: d[2], TIME: np.zeros(len(origins))}
    away, met = _depth(scene, stamp, moment).run(given, [RED, GREEN], len(origins))
    return np.where(met > 0.0, away, math.inf)


def thing_at(shapes: Iterable[Shape], point: np.ndarray, moment: float) -> tuple[str, np.ndarray] | None:
    """The shape that a world point (mm) lies on at a time (s), and the point in the frame of the shape.

    A sphere has the axes of the world, a planar shape its half-axes and normal; rotation by a spin does not count.
    """
    for thing in shapes:
        here = displaced(thing, moment) if thing.moves else thing
        found = here.locate(point, TOUCH)
        if found is not None:
            return here.label, found
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
    found = thing_at(_near(settings, stamp, point), point, settings.moment)
    return Landing(point, (float(raster[0][0]), float(raster[0][1])) if visible[0] else None,
                   f"from the {found[0] if found else 'floor'}, {format_distance(-float(there[2]))} ahead")
