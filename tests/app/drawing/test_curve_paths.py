"""Curves in pixels: what may be left out of them."""

import numpy as np

from lensbench.app.drawing.plot_axes import simplified


def test_a_simplified_curve_has_few_points_and_lies_within_a_quarter_of_a_pixel():
    x = np.linspace(0.0, 300.0, 401)
    points = np.stack([x, 80.0 * np.sin(x / 60.0)], axis=1)
    few = simplified(points)
    assert len(few) < 100
    assert np.abs(np.interp(x, *few.T) - points[:, 1]).max() < 0.25
    np.testing.assert_array_equal(few[[0, -1]], points[[0, -1]])


def test_a_simplified_curve_keeps_its_gap():
    points = np.stack([np.arange(100.0), np.zeros(100)], axis=1)
    points[40:43] = np.nan
    few = simplified(points)
    assert np.isnan(few).any() and len(few) < 20
    gap = np.flatnonzero(np.isnan(few[:, 0]))
    assert few[gap[0] - 1, 0] == 39.0 and few[gap[-1] + 1, 0] == 43.0
