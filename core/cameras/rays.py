"""What a camera gives, and what it is asked for: rays, times, and the error of a camera that cannot be."""

from typing import NamedTuple

import numpy as np


class CameraError(ValueError):
    """A camera that cannot be; the message says what to do."""


class Rays(NamedTuple):
    """Rays in the world frame (mm); what a camera blocks has weight 0 and numbers without meaning."""

    origins: np.ndarray         # (n, 3)
    directions: np.ndarray      # (n, 3) unit
    weights: np.ndarray         # (n,)
    times: np.ndarray           # (n,) seconds


def checked_times(time) -> np.ndarray:
    """Parts of what the shutter lets through; CameraError where they are not in [0, 1]."""
    times = np.asarray(time, float)
    if not ((times >= 0.0) & (times <= 1.0)).all():
        raise CameraError("times must lie between 0 and 1, parts of what the shutter lets through")
    return times
