"""Groups of lanes: their boxes hold their points, and their normals are the means."""

import numpy as np

from lensbench.core.kernels.block import A11, DEPTH, NX, PITCH, RED, B, L, X, lane_buffer
from lensbench.core.scenery.shading.many_lamps import (
    BOX_HALF, BOX_MIDDLE, FINE, GROUP, GROUPS, NORMAL, STEPS, group_lanes
)
from tests.core.scenery.test_scene import unit


def test_a_group_is_bounded_by_the_points_of_its_lit_lanes_and_has_the_mean_of_their_normals():
    random = np.random.default_rng(5)
    lanes, groups, many = lane_buffer(np.float64), np.empty(GROUPS * GROUP), np.empty(GROUPS, np.int32)
    row = lanes.reshape(-1, PITCH)[:, :B]
    points, ways, normals = random.normal(0.0, 90.0, (B, 3)), unit(random.normal(size=(B, 3))), unit(
        random.normal(size=(B, 3)) + (1.0, -2.0, 0.5))
    lit, depth = random.random(B) < 0.7, np.where(random.random(B) < 0.5, 300.0, 900.0)
    row[X:X + 3], row[L:L + 3], row[NX:NX + 3], row[DEPTH], row[RED] = points.T, ways.T, normals.T, depth, lit
    group_lanes(lanes, groups, many)
    ends, found = points + depth[:, None] * ways, groups.reshape(GROUPS, GROUP)
    number = row[A11].astype(int)
    np.testing.assert_array_equal(many, np.bincount(number[lit], minlength=GROUPS))
    for g in np.flatnonzero(many):
        own = lit & (number == g)
        middle, half = found[g, BOX_MIDDLE:BOX_MIDDLE + 3], found[g, BOX_HALF:BOX_HALF + 3]
        np.testing.assert_allclose(middle - half, ends[own].min(0), atol=1.0 / STEPS)
        np.testing.assert_allclose(middle + half, ends[own].max(0), atol=1.0 / STEPS)
        np.testing.assert_allclose(found[g, NORMAL:NORMAL + 3], normals[own].mean(0), atol=1.0 / FINE)
        assert np.ptp(depth[own]) == 0.0
