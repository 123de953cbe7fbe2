"""Maps on the screen: shades at their places, means where samples are finer than pixels, colours, textures let go."""

import numpy as np
import pytest

from lensbench.app.drawing.plot_axes import PlotMap
from lensbench.app.drawing.plot_layers import on_pixels, picture
from lensbench.app.plots.plot import Map

WIDE, HIGH = 40, 48             # samples of the map


def shown(width, height):
    return PlotMap(10.3, 5.6, 10.3 + width, 5.6 + height, 0.0, 4.0, -3.0, 1.0, False)


@pytest.mark.parametrize("size", [(241.0, 243.7), (300.2, 120.9), (37.4, 37.4), (150.0, 801.3)])
def test_shades_lie_at_their_places_and_means_have_whole_pixels(size):
    plot = shown(*size)
    rows, columns = np.meshgrid(np.arange(HIGH, dtype=float), np.arange(WIDE, dtype=float), indexing="ij")
    ramp = Map("", (rows + 2.0 * columns) / 125.0, (1.02, 1.98), (-0.48, 0.48))
    values, lower, upper = on_pixels(ramp, plot)
    (left, bottom), (right, top) = plot.pixels([lower[0], upper[0]], [lower[1], upper[1]])
    across = plot.pixels([1.02, 1.98], [-0.48, 0.48])
    for low, high, count, samples, length in (
            (left, right, values.shape[1], WIDE, across[1, 0] - across[0, 0]),
            (top, bottom, values.shape[0], HIGH, across[0, 1] - across[1, 1])):
        if samples > length:
            assert (high - low) / count == pytest.approx(1.0, abs=1e-9) and low == pytest.approx(round(low), abs=1e-6)
        else:
            assert count == samples and high - low == pytest.approx(length, abs=1e-9)
    x = lower[0] + (np.arange(values.shape[1]) + 0.5) / values.shape[1] * (upper[0] - lower[0])
    y = upper[1] - (np.arange(values.shape[0]) + 0.5) / values.shape[0] * (upper[1] - lower[1])
    column = np.clip((x - 1.02) / 0.96 * WIDE - 0.5, 0.0, WIDE - 1.0)
    row = np.clip((y + 0.48) / 0.96 * HIGH - 0.5, 0.0, HIGH - 1.0)
    # The samples themselves; means of steps are not linear, and at the edges those of a part of a pixel
    close = 1e-9 if values.shape == (HIGH, WIDE) else 2.0 / 125.0
    np.testing.assert_allclose(values, (row[:, None] + 2.0 * column) / 125.0, atol=close)


def test_more_samples_than_pixels_are_averaged():
    rows, columns = np.meshgrid(np.arange(160), np.arange(160), indexing="ij")
    board = Map("", ((rows + columns) % 2).astype(float), (0.0, 4.0), (-3.0, 1.0))
    plot = PlotMap(10.0, 5.0, 50.0, 45.0, 0.0, 4.0, -3.0, 1.0, False)               # four samples a pixel
    values, *_ = on_pixels(board, plot)
    assert values.shape == (40, 40)
    np.testing.assert_allclose(values, 0.5, atol=1e-9)
    left = Map("", (columns < 80).astype(float), (0.0, 4.0), (-3.0, 1.0))
    np.testing.assert_allclose(on_pixels(left, plot)[0].mean(0), np.repeat([1.0, 0.0], 20), atol=1e-9)
    random = np.random.default_rng(1).random(100)                                   # 2.5 samples a pixel
    uneven = Map("", np.tile(random, (4, 1)), (0.0, 4.0), (-3.0, 1.0))
    np.testing.assert_allclose(on_pixels(uneven, plot)[0][0], random.repeat(2).reshape(40, 5).mean(1), atol=1e-12)


def test_a_map_with_gaps_keeps_its_samples_and_shows_the_ground_there():
    with_gap = Map("", np.array([[0.0, 1.0], [np.nan, 0.5]]), (0.0, 1.0), (0.0, 1.0))
    values, lower, upper = on_pixels(with_gap, shown(2.0, 1.0))
    np.testing.assert_array_equal(values, with_gap.shades[::-1])
    assert (lower, upper) == ((0.0, 0.0), (1.0, 1.0))
    for dark in (True, False):
        ground = (0.11, 0.12, 0.13, 1.0)
        (unknown, middle), (black, white) = picture(values, dark, ground).astype(int).tolist()
        assert unknown == [28, 31, 33, 255]
        assert sum(black) < sum(middle) < sum(white) and middle[2] > middle[0]
