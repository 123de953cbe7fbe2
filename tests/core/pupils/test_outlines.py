"""Outlines of regions: points spaced evenly along them, sectors of equal area, and the hull around pieces."""

import math

import numpy as np
import pytest

from lensbench.core.pupils.irregular_regions import _upper_hull
from lensbench.core.pupils.outline_solver import _even_directions
from lensbench.core.pupils.radial_sampler import equal_areas


def ellipse(points, begin=0.0):
    turn = begin + 2.0 * math.pi * np.arange(points) / points
    return np.stack([3.0 * np.cos(turn), np.sin(turn)], 1)


@pytest.mark.parametrize("begin", [0.0, 0.4, -2.9])
def test_directions_are_even_along_the_outline_wherever_its_corners_begin(begin):
    line = ellipse(400, begin)
    angles, sizes = _even_directions(np.stack([line, np.zeros_like(line)]), 24)
    assert angles[0, 0] == 0.0 and (np.diff(angles[0]) > 0.0).all() and angles[0, -1] < 2.0 * math.pi
    points = sizes[0, :, None] * np.stack([np.cos(angles[0]), np.sin(angles[0])], 1)
    assert np.hypot(points[:, 0] / 3.0, points[:, 1]) == pytest.approx(1.0, abs=0.01)
    gaps = np.linalg.norm(np.roll(points, -1, 0) - points, axis=1)
    assert gaps == pytest.approx(gaps.mean(), rel=0.06)         # chords beside arcs, and 128 directions
    assert not angles[1].any() and not sizes[1].any()           # an empty region


def test_sectors_between_corners_have_equal_areas():
    line = ellipse(300)
    corners, = equal_areas(np.concatenate([line, line[:1]])[None], 12)
    areas = corners[:-1, 0] * corners[1:, 1] - corners[1:, 0] * corners[:-1, 1]
    assert corners[0] == pytest.approx(line[0]) and corners[-1] == pytest.approx(line[0])
    assert (corners[:, 0] / 3.0) ** 2 + corners[:, 1] ** 2 == pytest.approx(1.0, abs=1e-3)
    assert areas == pytest.approx(areas.mean(), rel=1e-3)
    assert not equal_areas(np.zeros((1, 5, 2)), 12).any()


def test_the_hull_holds_all_points_and_turns_one_way():
    points = np.random.default_rng(2).normal(size=(300, 2)) * [2.0, 1.0]
    points[:, 1] = np.abs(points[:, 1])
    hull = _upper_hull(points)
    sides = np.diff(hull, axis=0)
    assert (sides[:-1, 0] * sides[1:, 1] - sides[:-1, 1] * sides[1:, 0] >= 0.0).all()
    for corner, side in zip(hull, sides, strict=False):
        away = points - corner
        assert (side[0] * away[:, 1] - side[1] * away[:, 0] >= -1e-12).all()
    assert hull[0] == pytest.approx([points[:, 0].max(), 0.0]) and hull[-1] == pytest.approx([points[:, 0].min(), 0.0])
