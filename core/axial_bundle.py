"""The real rays of a point on the axis: how wide a bundle every rim lets pass, and where it goes.

Lengths in mm, lens frame. A point on the axis is named by its nearness, 1/mm: one
over its distance before the first vertex (or behind the last, for light that runs
back), 0 at infinity. A bundle is known by the heights of its rays on the plane of
the vertex that it meets first. Rotational symmetry is assumed: of a lens with a cylinder or
toroid these are the rays of the section y–z.
"""

from functools import lru_cache
from math import sqrt

import numpy as np
from numba import njit

from lensbench.tracing import PASSED, trace_ray

ZONES = 24                      # over the pupil's area: the rms needs 8, the widest ray of a spot within 1 % these
WITHIN_THE_RIM = 1.0 - 1e-12    # of the marginal height: the outermost ray, safe from the rounding of the search
_SCAN = 24                      # steps outwards to the first ray that fails: a ring of light beyond it is no part
_HALVINGS = 46                  # of one such step, to the rounding of the height


@lru_cache
def zone_rule() -> tuple[np.ndarray, np.ndarray]:
    """Heights (relative to the marginal one) and weights (sum 1) of Gauss's rule over the area of the pupil."""
    nodes, weights = np.polynomial.legendre.leggauss(ZONES)
    return np.sqrt(0.5 * (nodes + 1.0)), 0.5 * weights


@njit(cache=True, nogil=True, error_model="numpy")
def trace_axial(table, height, nearness, forward):
    """A meridional ray through `height` on the plane of the vertex met first → (height, slope dy/dz, fate).

    The height is that on the plane of the vertex met last. The ray starts on the
    first plane, so that a far point costs no accuracy.
    """
    last = table.shape[0] - 1
    scale = 1.0 / sqrt(1.0 + (height * nearness) ** 2)
    way = scale if forward else -scale
    start, end = (table[0, 1], table[last, 1]) if forward else (table[last, 1], table[0, 1])
    _, y, z, _, dy, dz, fate, _ = trace_ray(
        table, True, 0.0, height, start, 0.0, height * nearness * scale, way, None, 0, 0)
    slope = dy / dz
    return y + (end - z) * slope, slope, fate


@njit(cache=True, nogil=True, error_model="numpy")
def marginal_height(table, nearness, forward):
    """Height (mm) of the outermost ray that passes every rim, on the plane of the vertex met first; 0 if none does."""
    rim = 2.0 * sqrt(table[0, 2] if forward else table[table.shape[0] - 1, 2])
    inside, outside = 0.0, 0.0
    for step in range(1, _SCAN + 1):
        outside = rim * step / _SCAN
        if trace_axial(table, outside, nearness, forward)[2] != PASSED:
            break
        inside = outside
    for _ in range(_HALVINGS):
        middle = 0.5 * (inside + outside)
        if trace_axial(table, middle, nearness, forward)[2] == PASSED:
            inside = middle
        else:
            outside = middle
    return inside


@njit(cache=True, nogil=True, error_model="numpy")
def trace_bundles(table, nearness, zones, heights, slopes):
    """Forward bundles of n axis points into heights, slopes (n, zones) on the plane of the last vertex.

    zones (k,) are heights relative to the marginal ray, at most 1.
    """
    for i in range(nearness.shape[0]):
        margin = marginal_height(table, nearness[i], True)
        for j in range(zones.shape[0]):
            heights[i, j], slopes[i, j], _ = trace_axial(table, zones[j] * margin, nearness[i], True)
