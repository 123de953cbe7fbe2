"""Points spread evenly over the unit square, for measurements that are to have no noise."""

import numpy as np

GOLDEN = 0.6180339887498949             # the golden ratio less 1


def even_points(count: int) -> np.ndarray:
    """(count, 2) points: the first coordinate in even steps, the second in steps of the golden ratio."""
    k = np.arange(count)
    return np.column_stack([(k + 0.5) / count, k * GOLDEN % 1.0])
