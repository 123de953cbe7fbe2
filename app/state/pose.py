"""Moving the camera by hand: orbit, pan and dolly about the point in focus. Lengths in mm, angles in radians."""

import math
from dataclasses import replace

import numpy as np

from lensbench.app.state.settings import Settings

STEEPEST = math.radians(85.0)
FARTHEST = 5000.0               # mm: a farther pivot would make every movement too large
NEAREST = 50.0


def pivot_distance(settings: Settings) -> float:
    """Distance (mm) from the camera to the pivot of an orbit: the focus distance, within limits."""
    return min(max(settings.focus_distance, NEAREST), FARTHEST)


def orbited(settings: Settings, left: float, up: float) -> Settings:
    """The camera turned about the pivot: the scene seems to turn by these angles (radians), right and down positive."""
    settings = at_keyframe(settings)
    distance, late = pivot_distance(settings), _late(settings)
    frame, yaw, pitch = _pose(settings)
    pivot = frame[:3, 3] - distance * frame[:3, 2]
    pitch = min(max(pitch - up, -STEEPEST), STEEPEST)
    yaw = math.remainder(yaw - left, 2.0 * math.pi)
    turned = replace(settings, end_yaw=yaw, end_pitch=pitch) if late else replace(settings, yaw=yaw, pitch=pitch)
    return _moved(turned, pivot + distance * _pose(turned)[0][:3, 2])


def panned(settings: Settings, right: float, up: float) -> Settings:
    """The camera moved across the view by these lengths (mm)."""
    settings = at_keyframe(settings)
    frame = _pose(settings)[0]
    return _moved(settings, frame[:3, 3] + right * frame[:3, 0] + up * frame[:3, 1])


def dollied(settings: Settings, forward: float) -> Settings:
    """The camera moved along the view by a length (mm)."""
    settings = at_keyframe(settings)
    frame = _pose(settings)[0]
    return _moved(settings, frame[:3, 3] - forward * frame[:3, 2])


def at_home(settings: Settings) -> Settings:
    """The camera at its default position and direction, without keyframes; lens, film and focus are kept."""
    home = Settings()
    return replace(settings, position=home.position, yaw=home.yaw, pitch=home.pitch, end_position=home.end_position,
                   end_yaw=home.end_yaw, end_pitch=home.end_pitch, moment=home.moment)


def at_keyframe(settings: Settings) -> Settings:
    """The moment at the nearer of two keyframes: the mouse moves the camera only there."""
    if not settings.keyframed:
        return settings
    return replace(settings, moment=settings.duration if _late(settings) else 0.0)


def _late(settings: Settings) -> bool:
    """Whether the second keyframe is the nearer one in time."""
    return settings.keyframed and settings.moment > 0.5 * settings.duration


def _pose(settings: Settings) -> tuple[np.ndarray, float, float]:
    """Pose (4, 4), yaw and pitch (radians) of the nearer keyframe."""
    if settings.end_position is None or not _late(settings):
        return settings.world_from_camera, settings.yaw, settings.pitch
    end = replace(settings, position=settings.end_position, yaw=settings.end_yaw, pitch=settings.end_pitch)
    return end.world_from_camera, end.yaw, end.pitch


def _moved(settings: Settings, position: np.ndarray) -> Settings:
    x, y, z = (float(value) for value in position)
    return replace(settings, end_position=(x, y, z)) if _late(settings) else replace(settings, position=(x, y, z))
