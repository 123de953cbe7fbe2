"""Levels of depth maps: one number a pixel, and the pixels that hold no distance."""

from typing import Any

import numpy as np

import lensbench as lb

UNEQUAL = 3             # levels of 255: rounding of a grey picture that is stored in colours
GAP = 0.05              # of the range of all other levels: below it, a level 0 belongs to them
ALONE = 0.1             # of the greatest level: where all others lie below, it is no distance
ENDLESS = 1e6           # programs store 1e10 m and the like where a ray meets nothing
HALF_END = 65504.0      # the greatest number of 16 bits: the same in such a file


def grey_levels(picture: Any) -> np.ndarray:
    """The levels (h, w) of a decoded picture of Pillow; SceneError for colours, whose order by distance is unknown."""
    if picture.mode in ("1", "L", "F") or picture.mode.startswith("I"):
        return np.asarray(picture)
    colours = np.asarray(picture.convert("RGB"))
    for other in (1, 2):
        check_equal(colours[..., 0], colours[..., other], UNEQUAL)
    return colours[..., 0]


def check_equal(one: np.ndarray, other: np.ndarray, tolerance: float) -> None:
    """SceneError where two channels of a depth map differ by more than the tolerance."""
    for a, b in zip(one, other, strict=True):               # row by row: the picture may be large
        if np.abs(a.astype(float) - b).max() > tolerance:
            raise lb.SceneError("its red, green and blue differ: colours have no order by distance. Save the distances "
                                "as one channel: grey of 16 bits in PNG, or OpenEXR")


def unmeasured(levels: np.ndarray, disparity: bool) -> np.ndarray:
    """Which levels (h, w) are no distance: NaN and what is not positive of floats, and 0 of integers, where all others
    lie apart from it. Not 0 of disparities: it is infinity there.
    """
    if levels.dtype.kind == "f":
        with np.errstate(invalid="ignore"):
            return ~(levels > 0.0) if not disparity else np.isnan(levels)
    zero = levels == 0
    if disparity or not zero.any() or zero.all():
        return np.zeros(levels.shape, bool)
    least, most = int(levels.min(where=~zero, initial=levels.max())), int(levels.max())
    return zero if most > least > GAP * (most - least) else np.zeros(levels.shape, bool)


def endless(levels: np.ndarray, hole: np.ndarray, alone: bool) -> np.ndarray:
    """Which levels (h, w) that are no holes stand for a ray that met nothing: floats of `ENDLESS` or `HALF_END`.

    alone: also the greatest level of more than 8 bits, where all others, of two values or more, lie far below it.
    """
    if levels.dtype.itemsize < 2:
        return np.zeros(levels.shape, bool)
    real = levels.dtype.kind == "f"
    found = ~hole & ((levels >= ENDLESS) | (levels == HALF_END)) if real else np.zeros(levels.shape, bool)
    below = ~(hole | found)
    if alone and below.any():
        least, most = (f(where=below, initial=levels[below][0]) for f in (levels.min, levels.max))
        top = below & (levels == most)
        second = levels.max(where=below & ~top, initial=least)
        if least < second < ALONE * most:
            found |= top
    return found


def filled(away: np.ndarray, hole: np.ndarray) -> np.ndarray:
    """Distances (h, w) whose holes take the value of the nearest neighbour in their row or column that has one."""
    away, known = away.copy(), ~hole
    while not known.all():
        nearest = np.full(away.shape, np.inf)
        values = away.copy()
        for flip, turn in ((1, False), (-1, False), (1, True), (-1, True)):
            there, has, to, best = (each.T[:, ::flip] if turn else each[:, ::flip]
                                    for each in (away, known, values, nearest))
            column = np.arange(there.shape[1])
            last = np.maximum.accumulate(np.where(has, column, -1), 1)
            closer = (last >= 0) & (column - last < best)
            to[closer] = np.take_along_axis(there, np.maximum(last, 0), 1)[closer]
            best[closer] = (column - last)[closer]
        away, known = values, np.isfinite(nearest)
    return away
