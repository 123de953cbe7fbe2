"""Rays in the world, checked shutter samples, and the error of a camera with invalid settings."""

from typing import NamedTuple

import numpy as np


class CameraError(ValueError):
    """Invalid settings of a camera; the message says what to change."""


class Rays(NamedTuple):
    """Rays of a camera in the world frame.

    A ray that the camera blocks has weight 0; its other numbers have no meaning.

    Args:
        origins: (n, 3) array. Points on the rays (mm), world.
        directions: (n, 3) array. Unit directions, world.
        weights: (n,) array. Weights by which the radiance of each ray enters its pixel; see `Camera.weights`.
        times: (n,) array. Times (s) on the clock of `Camera.shutter_open`.
    """

    origins: np.ndarray
    directions: np.ndarray
    weights: np.ndarray
    times: np.ndarray


def checked_times(time) -> np.ndarray:
    """Shutter samples as an array; CameraError where they do not lie in [0, 1]."""
    times = np.asarray(time, float)
    if not ((times >= 0.0) & (times <= 1.0)).all():
        raise CameraError("times must lie between 0 and 1, parts of what the shutter lets through")
    return times
