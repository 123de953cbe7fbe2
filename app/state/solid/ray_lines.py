"""Rays in space: the fans of the section, the beam of the pointed pixel, and one pointed ray. mm, camera frame."""

import math

import numpy as np

import lensbench as lb
from lensbench.app.state.build import setup
from lensbench.app.state.geometry.exit_pupil import from_film, region, turn
from lensbench.app.state.geometry.section import Sketch
from lensbench.app.state.pixel.beam import beam
from lensbench.app.state.pixel.lens_rays import path_of
from lensbench.app.state.pixel.pointed import Place, PointedRay
from lensbench.app.state.settings import Settings
from lensbench.app.state.solid.shapes import Strokes, strokes
from lensbench.app.state.view_camera import seen_from
from lensbench.cameras.flat_port import FlatPort

FIELDS = ("field0", "field1", "field2")
RIM = 16                        # rays along the edge of a pixel's beam
FARTHEST = 20_000.0             # mm


def fan_lines(shown: Sketch, focus_distance: float) -> tuple[Strokes, ...]:
    """The section's rays that reach the film, from where they are in focus, one of the FIELDS after the other."""
    return tuple(strokes(kind, [_extended(_in_space(ray.path, shown.film_z), focus_distance, shown.port)
                                for ray in fan.rays if ray.kind != "dead"])
                 for kind, fan in zip(FIELDS, shown.fans, strict=True))


def lost_lines(shown: Sketch, surfaces: tuple[int, ...]) -> Strokes:
    """The section's rays that one of these surfaces ends."""
    return strokes("lost", [_in_space(ray.path, shown.film_z) for fan in shown.fans for ray in fan.rays
                            if ray.kind == "dead" and ray.surface in surfaces])


def _in_space(path: np.ndarray, film_z: float) -> np.ndarray:
    """A path (n, 2) of the section as (n, 3)."""
    return np.column_stack([np.zeros(len(path)), path[:, 1], path[:, 0] - film_z])


def _extended(path: np.ndarray, focus_distance: float, port: FlatPort) -> np.ndarray:
    """A path whose first stretch runs to the plane in focus, or far before the lens."""
    path, way = _at_window(path, port)
    along = (-focus_distance - path[0, 2]) / way[2] if math.isfinite(focus_distance) and way[2] < -0.05 else FARTHEST
    return np.vstack([path[0] + min(max(along, 0.0), FARTHEST) * way, path])


def _at_window(path: np.ndarray, port: FlatPort) -> tuple[np.ndarray, np.ndarray]:
    """A path without its first stretch, up to the window where there is one, and the unit vector on towards the scene.

    Snell's law at the window, which lies across z.
    """
    way = path[0] - path[1]
    way /= np.linalg.norm(way)
    if port.index == 1.0 or not way[2] < 0.0:
        return path[1:], way
    window = path[1] + (-port.window - path[1, 2]) / way[2] * way
    x, y = way[:2] / port.index
    return np.vstack([window, path[1:]]), np.array([x, y, -math.sqrt(1.0 - x * x - y * y)])


def pixel_lines(settings: Settings, raster: Place) -> Strokes:
    """The beam of a pixel, up to what it shows; ValueError or OSError where there is no camera."""
    seen = beam(settings, raster)
    pose = settings.present_pose
    if settings.has_lens and settings.follows_lens:
        built, at = seen_from(settings, raster)
        outline = region(built.lens, built.film_distance, math.hypot(*at), math.atan2(at[1], at[0])).outline
        if not len(outline):
            return strokes("pixel", [])
        middle = outline.mean(0)
        rim = middle + 0.995 * (outline[:: max(len(outline) // RIM, 1)] - middle)
        trace = from_film(built.lens, built.film_distance, at, np.vstack([middle, rim]) @ turn(built.lens, at),
                          record=True)
        far = min(seen.along, FARTHEST) if seen.along > 0.0 else FARTHEST
        paths = []
        for i in np.flatnonzero(trace.fate == lb.Fate.PASSED):
            path = path_of(built.lens, trace, int(i)) - [0.0, 0.0, setup(settings).film_z]
            path, way = _at_window(path, built.port)
            paths.append(np.vstack([path[0] + far * way, path]))
        return strokes("pixel", paths)
    ends = seen.origins + np.minimum(seen.ends, FARTHEST)[:, None] * seen.directions
    local = [(points - pose[:3, 3]) @ pose[:3, :3] for points in (ends, seen.origins)]
    return Strokes("pixel", np.stack(local, axis=1))


def pointed_line(ray: PointedRay, film_z: float) -> Strokes:
    """One ray of a plot."""
    return strokes("pointed", [ray.path - [0.0, 0.0, film_z]])
