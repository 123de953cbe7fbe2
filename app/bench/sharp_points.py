"""*Make these sharp*: the tilt and swing of the film, and the focus, for which picked points of the scene are sharp.

Lengths in mm. By traced beams of the points' images, as a click focuses; of two points the film turns as little as may
be, and with the focus alone where that is enough.
"""

import math
from dataclasses import replace

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import bench_of
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.focus_plane import Place, depth_nearness
from lensbench.app.bench.readouts import blur_limit
from lensbench.app.bench.water_window import port_index
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.setting_table import STEEPEST
from lensbench.app.settings.settings import Settings
from lensbench.core.text import fixed

FARTHEST = 1e7                  # mm: the sky
ROUNDS, STEPS = 5, 12           # of the points' images, which move as the film turns; of Newton's method for each
DIFFERENCE = 0.02               # mm of the film's edge or of the focus, for derivatives
LONGEST = 4.0                   # mm, of a step
EASE = 10.0                     # the focus moves so much more readily than the film turns
ENOUGH = 1e-3                   # of the blur that counts as sharp
STILL = 0.3                     # pixels: the images of the points do not move any more


def picked_point(settings: Settings, share: Place, depth: float) -> tuple[float, float, float]:
    """The point of the world (mm) that a part of the picture shows `depth` mm before the film."""
    made, film = camera(settings), settings.film
    ray = made.generate_rays([[share[0] * film.pixels_x, share[1] * film.pixels_y]], [made.pupil_centre])
    camera_from_world = np.linalg.inv(settings.present_pose)
    start, way = (camera_from_world @ np.append(values[0], end) for values, end in (
        (ray.origins, 1.0), (ray.directions, 0.0)))
    length = (min(depth, FARTHEST) + start[2]) / -way[2]
    x, y, z = (float(value) for value in ray.origins[0] + length * ray.directions[0])
    return x, y, z


def made_sharp(settings: Settings, points: np.ndarray) -> tuple[Settings, np.ndarray]:
    """The settings with tilt, swing and focus for which points of the world (n, 3), mm, are sharp.

    Also where the picture shows them then: parts (n, 2) of its width and height. SettingsError where the film cannot
    turn so far or no turn makes them sharp, LensError or CameraError where the film has no room.
    """
    if not (settings.has_lens and settings.focuses):
        raise SettingsError("Make these sharp: only a film behind a lens can be tilted; choose a camera with a lens")
    if port_index(settings) != 1.0:
        raise SettingsError("Make these sharp: not through a window into water; choose air, or immerse the lens")
    bench, size = bench_of(settings), np.array([settings.film.pixels_x, settings.film.pixels_y])
    depths = -(np.linalg.inv(settings.present_pose) @ np.column_stack([points, np.ones(len(points))]).T)[2]
    half, efl = 0.5 * settings.film.diagonal, bench.at_infinity.efl
    limit = bench.f_number * blur_limit(settings)               # mm along the axis
    nearest = 1.0 / (lb.nearest_focus(bench.lens) * (1.0 + 1e-6))
    method = bench.focusing.method

    def turned(values: np.ndarray) -> Settings:
        """The settings for lengths (mm): those by which tilt and swing move the film's edge, and of the focus."""
        nearness = min(max(values[2] * EASE / efl**2, 0.0), nearest)
        return replace(settings, tilt=float(values[0] / half), swing=float(values[1] / half), focus_position=method,
                       focus_distance=float(1.0 / nearness) if nearness > 0.0 else math.inf)

    def errors(values: np.ndarray) -> np.ndarray:
        """How far (n,), mm, the images lie from the film, about."""
        away = efl**2 * (depth_nearness(turned(values), images) - 1.0 / depths)
        if not np.isfinite(away).all():
            raise SettingsError("Make these sharp: no light reaches one of these points of the film; stop down, or "
                                "choose points nearer to the middle")
        return away

    values = np.array([settings.tilt * half, settings.swing * half, efl**2 / settings.focus_distance / EASE])
    images, _ = camera(settings).raster_from_point(points)
    for _ in range(ROUNDS):
        for _ in range(STEPS):
            off = errors(values)
            if np.abs(off).max() < ENOUGH * limit:
                break
            slopes = np.stack([(errors(values + step) - off) / DIFFERENCE for step in DIFFERENCE * np.eye(3)], 1)
            change = -np.linalg.lstsq(slopes, off, rcond=1e-4)[0]
            values = values + change * min(1.0, LONGEST / max(np.abs(change).max(), 1e-12))
            if np.abs(values[:2]).max() > half * STEEPEST:
                raise SettingsError("These points cannot be made sharp together: the film would have to tilt by more "
                                    f"than {fixed(math.degrees(STEEPEST), 0)}°. Choose points that lie farther apart "
                                    "in the picture, or less in depth")
        before, (images, _) = images, camera(turned(values)).raster_from_point(points)
        if np.abs(images - before).max() < STILL:
            break
    blur = 1000.0 * float(np.abs(errors(values)).max()) / bench.f_number
    if blur > 1000.0 * blur_limit(settings):
        raise SettingsError(f"These points cannot be made sharp together: a blur of {fixed(blur, 0)} µm stays. Choose "
                            "points that are not in one line of the picture, or stop down")
    return replace(turned(values), focus_position=settings.focus_position), images / size
