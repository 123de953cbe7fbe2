"""Moving the camera by hand: orbit, pan and dolly about what is in focus. Lengths in mm, angles in radians."""

import math
from dataclasses import replace

import numpy as np

from lensbench.app.settings import Settings

STEEPEST = math.radians(85.0)
FARTHEST = 5000.0               # mm: a pivot farther away would make every movement too large
NEAREST = 50.0


def pivot_distance(settings: Settings) -> float:
    """How far before the camera the point lies that an orbit turns about: what is in focus, within reason."""
    return min(max(settings.focus_distance, NEAREST), FARTHEST)


def orbited(settings: Settings, left: float, up: float) -> Settings:
    """Turned about the pivot: the scene seems to turn by these angles, to the right and downwards where positive."""
    distance = pivot_distance(settings)
    frame = settings.world_from_camera
    pivot = frame[:3, 3] - distance * frame[:3, 2]
    pitch = min(max(settings.pitch - up, -STEEPEST), STEEPEST)
    turned = replace(settings, yaw=math.remainder(settings.yaw - left, 2.0 * math.pi), pitch=pitch)
    return _moved(turned, pivot + distance * turned.world_from_camera[:3, 2])


def panned(settings: Settings, right: float, up: float) -> Settings:
    """Moved across the view by these lengths."""
    frame = settings.world_from_camera
    return _moved(settings, frame[:3, 3] + right * frame[:3, 0] + up * frame[:3, 1])


def dollied(settings: Settings, forward: float) -> Settings:
    """Moved along the view by a length."""
    frame = settings.world_from_camera
    return _moved(settings, frame[:3, 3] - forward * frame[:3, 2])


def _moved(settings: Settings, position: np.ndarray) -> Settings:
    x, y, z = (float(value) for value in position)
    return replace(settings, position=(x, y, z))
