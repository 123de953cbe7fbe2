"""The scene from above: its objects, the field of view of the camera, and the depth of field.

Points are (right, ahead) in metres: x and −z of the world. The depth of field lies between two planes across the axis
of the camera; the field of view is bounded by the outermost rays of the middle row of the picture. Both are projected
from space, for a pitched camera as well.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera, readings
from lensbench.app.bench.focus_plane import leans, sharp_focus
from lensbench.app.scenes.asset_files import Stamp, file_stamp
from lensbench.app.scenes.scene_file import SceneFileError, cached_scene, scene_stamp
from lensbench.app.settings.settings import Settings
from lensbench.core.scenery.objects.shape import displaced

AWAY = 1e7                      # mm along a ray, for infinitely far
ACROSS = 65                     # rays of the middle row of the picture
POINTS = 48                     # on a circle
Points = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Plan:
    """Points (…, 2) in metres; None for parts that the camera does not have."""

    place: Points                               # (2,) of the camera
    ahead: Points                               # (2,) its direction; shorter than 1 where it is pitched
    view: Points | None                         # (2, 2, 2): its left and right ray: origins, and points far along
    focus: Points | None                        # (2, 2) where the plane in focus crosses them
    band: Points | None                         # (4, 2) corners of the depth of field
    ends: tuple[Points, Points] | None          # the camera's position at its two keyframes
    distance: float                             # focus distance, mm


@dataclass(frozen=True, eq=False)
class Thing:
    """An outline (n, 2) in metres, seen from above, and whether it shines."""

    outline: Points
    shines: bool


def plan(settings: Settings) -> Plan:
    """The plan of these settings; a ValueError or OSError where there is no camera."""
    return _plan(settings.plain("seed", "view", "samples", "exposure", "tone", "overlay", "compare", "wipe"),
                 file_stamp(settings.lens))


@lru_cache(maxsize=4)
def _plan(settings: Settings, lens: Stamp) -> Plan:       # the stamp is part of the key: an edited file is another lens
    frame, got = settings.present_pose, readings(settings)
    origin, forward = frame[:3, 3], -frame[:3, 2]
    rays = _outermost(camera(settings)) if settings.kind.bounded else None
    focus = band = None
    opened = settings.lens_radius > 0.0 if settings.kind.lens_radius else got.f_number is not None
    if rays is not None and settings.focuses and opened:
        tilted = sharp_focus(settings) if leans(settings) else None
        focus = _cut(rays, origin, forward, settings.focus_distance)
        if tilted is not None:
            focus, band = _tilted(rays, frame, tilted)
        elif got.near_limit is not None and got.far_limit is not None:
            near, far = (_cut(rays, origin, forward, limit) for limit in (
                got.near_limit, got.far_limit if got.far_limit > 0.0 else math.inf))
            band = np.array([near[0], near[1], far[1], far[0]])
    ends = None
    if settings.end_position is not None:
        ends = above(np.array(settings.position)), above(np.array(settings.end_position))
    view = None if rays is None else np.stack([above(rays[0]), above(rays[0] + AWAY * rays[1])], 1)
    return Plan(above(origin), above(1000.0 * forward), view, focus, band, ends, settings.focus_distance)


def _outermost(of: lb.Camera) -> tuple[Points, Points] | None:
    """Origins and directions (2, 3) of the rays farthest left and right on the picture's middle line that see light."""
    film = of.film
    x = np.linspace(0.0, film.pixels_x, ACROSS)
    raster = np.column_stack([x, np.full(ACROSS, film.pixels_y / 2.0)])
    rays = of.with_open_stop.generate_rays(raster, np.tile(of.pupil_centre, (ACROSS, 1)))
    lit = np.flatnonzero(rays.weights > 0.0)
    if not lit.size:
        return None
    return rays.origins[lit[[0, -1]]], rays.directions[lit[[0, -1]]]


def _cut(rays: tuple[Points, Points], origin: Points, forward: Points, distance: float) -> Points:
    """Points (2, 2), from above, at which two rays meet the plane `distance` (mm) ahead; far off for a miss."""
    starts, directions = rays
    with np.errstate(divide="ignore", invalid="ignore"):
        return _along(rays, (distance - (starts - origin) @ forward) / (directions @ forward))


def _along(rays: tuple[Points, Points], t: Points) -> Points:
    """Points (2, 2), from above, at t (mm) along two rays; far off behind their origins and beyond AWAY."""
    return above(rays[0] + np.where((t > 0.0) & (t < AWAY), t, AWAY)[:, None] * rays[1])


def _tilted(rays: tuple[Points, Points], frame: Points, sharp: "lb.analysis.SharpFocus") -> tuple[
        Points | None, Points | None]:
    """Where the plane of sharp focus of a tilted film crosses two rays, and the corners of its wedge; None: nowhere."""
    starts, directions = ((rays[0] - frame[:3, 3]) @ frame[:3, :3], rays[1] @ frame[:3, :3])

    def cut(plane: "lb.analysis.focus_wedge.Plane | None", beyond: bool) -> Points | None:
        if plane is None:
            t = np.full(2, AWAY)
        else:
            with np.errstate(divide="ignore", invalid="ignore"):
                t = -plane.distance(starts) / (directions @ plane.normal)
        if not beyond and not ((t > 0.0) & (t < AWAY)).all():
            return None
        return _along(rays, t)

    focus = None if sharp.plane is None else cut(sharp.plane, False)
    near, far = cut(sharp.near, True), cut(sharp.far, True)
    band = None if near is None or far is None or focus is None else np.array([near[0], near[1], far[1], far[0]])
    return focus, band


def above(points: Points) -> Points:
    """World points (…, 3) in mm as (…, 2) in metres, seen from above."""
    return np.stack([points[..., 0], -points[..., 2]], -1) / 1000.0


def things(scene: str, moment: float) -> tuple[Thing, ...]:
    """The objects of a scene at a time (s), the highest last; none where the scene cannot be read."""
    return _things(scene, moment, scene_stamp(scene))


@lru_cache(maxsize=4)
def _things(scene: str, moment: float, stamp: tuple[Stamp, ...]) -> tuple[Thing, ...]:
    try:
        objects = cached_scene(scene).objects
    except (SceneFileError, OSError):
        return ()
    outlines = []
    for shape in sorted(objects, key=lambda shape: shape.centre[1]):
        moved = displaced(shape, moment) if shape.moves else shape
        outlines.append(Thing(above(moved.outline(POINTS)), moved.material.shines))
    return tuple(outlines)


def extent(shown: Plan, around: tuple[Thing, ...], depth: float) -> tuple[float, float, float, float]:
    """x0, x1, y0, y1 (m) around the camera, a near focus, and the objects within `depth` mm of the camera."""
    reach = depth / 1000.0
    points = [shown.place]
    for thing in around:
        middle = thing.outline.mean(0)
        if np.hypot(*(middle - shown.place)) < reach and np.ptp(thing.outline, axis=0).max() < reach:
            points += [thing.outline.min(0), thing.outline.max(0)]
    if shown.focus is not None and np.abs(shown.focus - shown.place).max() < 2.0 * reach:
        points += list(shown.focus)
    if shown.ends is not None:
        points += list(shown.ends)
    low, high = np.min(points, 0), np.max(points, 0)
    middle, half = 0.5 * (low + high), np.maximum(0.54 * (high - low), 0.25)
    return (float(middle[0] - half[0]), float(middle[0] + half[0]), float(middle[1] - half[1]),
            float(middle[1] + half[1]))
