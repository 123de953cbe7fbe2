"""Maps on the screen: every cell has whole pixels, and lies where its samples do."""

import numpy as np
import pytest

from lensbench.app.panels.analysis.layers import FEW, on_pixels
from lensbench.app.state.analysis.figure import Map
from lensbench.app.widgets.plot_axes import PlotMap


def shown(width, height):
    return PlotMap(10.3, 5.6, 10.3 + width, 5.6 + height, 0.0, 4.0, -3.0, 1.0, False)


@pytest.mark.parametrize("size", [(241.0, 243.7), (300.2, 120.9), (37.4, 37.4), (1500.0, 801.3)])
def test_cells_have_whole_pixels_and_the_shades_of_their_places(size):
    plot = shown(*size)
    rows, columns = np.meshgrid(np.arange(48.0), np.arange(40.0), indexing="ij")
    ramp = Map("", (rows + 2.0 * columns) / 125.0, (1.02, 1.98), (-0.48, 0.48))
    values, lower, upper = on_pixels(ramp, plot)
    (left, bottom), (right, top) = plot.pixels([lower[0], upper[0]], [lower[1], upper[1]])
    for low, high, count in ((left, right, values.shape[1]), (top, bottom, values.shape[0])):
        cell = (high - low) / count
        assert cell == pytest.approx(round(cell), abs=1e-6) and low == pytest.approx(round(low), abs=1e-6)
    # Linear in the place, so that interpolation is exact, but for half a sample at the edges; means of steps are not
    exact = 1e-9 if values.shape[0] >= 48 and values.shape[1] >= 40 else 2.0 / 125.0
    x = lower[0] + (np.arange(values.shape[1]) + 0.5) / values.shape[1] * (upper[0] - lower[0])
    y = upper[1] - (np.arange(values.shape[0]) + 0.5) / values.shape[0] * (upper[1] - lower[1])
    column = np.clip((x - 1.02) / 0.96 * 40.0 - 0.5, 0.0, 39.0)
    row = np.clip((y + 0.48) / 0.96 * 48.0 - 0.5, 0.0, 47.0)
    np.testing.assert_allclose(values, (row[:, None] + 2.0 * column) / 125.0, atol=exact)


def test_more_samples_than_pixels_are_averaged():
    rows, columns = np.meshgrid(np.arange(160), np.arange(160), indexing="ij")
    board = Map("", ((rows + columns) % 2).astype(float), (0.0, 4.0), (-3.0, 1.0))
    plot = PlotMap(10.0, 5.0, 50.0, 45.0, 0.0, 4.0, -3.0, 1.0, False)               # four samples a pixel
    values, *_ = on_pixels(board, plot)
    assert values.shape == (40, 40)
    np.testing.assert_allclose(values, 0.5, atol=1e-9)
    left = Map("", (columns < 80).astype(float), (0.0, 4.0), (-3.0, 1.0))
    np.testing.assert_allclose(on_pixels(left, plot)[0].mean(0), np.repeat([1.0, 0.0], 20), atol=1e-9)


def test_maps_with_many_samples_or_with_gaps_keep_their_samples():
    fine = Map("", np.random.default_rng(1).random((FEW + 1, 8)), (0.0, 1.0), (0.0, 1.0))
    with_gap = Map("", np.array([[0.1, 0.2], [np.nan, 0.4]]), (0.0, 1.0), (0.0, 1.0))
    for each in (fine, with_gap):
        values, lower, upper = on_pixels(each, shown(2000.0, 1000.0))
        np.testing.assert_array_equal(values, each.shades[::-1])
        assert (lower, upper) == ((0.0, 0.0), (1.0, 1.0))
