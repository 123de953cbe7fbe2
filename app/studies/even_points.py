"""Evenly spread points in the unit square, for measurements without sampling noise."""

import numpy as np

GOLDEN = 0.6180339887498949             # the golden ratio less 1


def even_points(count: int) -> np.ndarray:
    """Points (count, 2) in [0, 1)²: the first coordinate in equal steps, the second in steps of the golden ratio."""
    k = np.arange(count)
    return np.column_stack([(k + 0.5) / count, k * GOLDEN % 1.0])
