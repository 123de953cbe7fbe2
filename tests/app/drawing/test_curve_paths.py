"""Curves in pixels: their stretches between columns, and what may be left out of them."""

import numpy as np
from hypothesis import given, strategies as st

from lensbench.app.drawing.plot_axes import Paths, simplified

column = st.floats(-20.0, 120.0)


@given(column, column, st.integers(0, 2**32 - 1))
def test_stretches_of_curves_enclose_every_point_between_two_columns_and_no_more(a, b, seed):
    rng = np.random.default_rng(seed)
    x, y = np.sort(rng.uniform(0.0, 100.0, 12)), rng.uniform(-50.0, 50.0, (3, 12))
    left, right = min(a, b), max(a, b)
    found = Paths(np.stack([np.broadcast_to(x, y.shape), y], axis=-1)).heights(left, right)
    columns = np.concatenate([np.linspace(left, right, 50), x[(x > left) & (x < right)]])
    for curve, (low, high) in zip(y, found, strict=True):
        rows = np.interp(columns, x, curve)
        np.testing.assert_allclose((low, high), (rows.min(), rows.max()), rtol=0.0, atol=1e-9)


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
