"""What a phone's photograph with its depth map holds, whatever the format of the file."""

import math
from typing import Any, NamedTuple

import numpy as np

import lensbench as lb

EQUIVALENT, EXIF = 0xA405, 0x8769       # tags: focal length on 35 mm film, and the table where it stands
DIAGONAL = math.hypot(36.0, 24.0)


class PhonePhotograph(NamedTuple):
    """picture: linear. away (h, w): distances in mm, along the axis unless `radial`: along the ray. fov: radians across
    the picture, or None where the file does not state it.
    """

    picture: lb.Image
    away: np.ndarray
    radial: bool
    fov: float | None


def stated_fov(exif: Any, size: tuple[int, int], across: int) -> float | None:
    """Angle (radians) across a side of a picture of this size, by its focal length on 35 mm film; None without one."""
    try:
        equivalent = float(exif.get_ifd(EXIF).get(EQUIVALENT))
    except Exception:                   # none, or damaged notes: Pillow raises whatever they make Python raise
        return None
    if not 0.0 < equivalent < math.inf:
        return None
    return 2.0 * math.atan(DIAGONAL * across / math.hypot(*size) / (2.0 * equivalent))
