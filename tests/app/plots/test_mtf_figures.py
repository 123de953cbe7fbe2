"""The MTF map: its lines of best focus follow one maximum, and do not jump to another."""

from dataclasses import replace

import numpy as np

from lensbench.app.bench.lens_choice import with_lens
from lensbench.app.plots.plot import Curve
from lensbench.app.plots.point_plots import mtf_map_figure, of_one_maximum
from lensbench.app.plots.query import query
from lensbench.app.settings.settings import Settings

SHIFTS = np.linspace(-1.0, 1.0, 201)
HEIGHTS = np.linspace(0.0, 20.0, 11)


def hill(at, height):
    return height * np.exp(-((SHIFTS - at) / 0.15) ** 2)


def test_a_line_ends_where_another_maximum_becomes_the_highest():
    values = np.array([np.maximum(hill(-0.4, 0.8 - 0.02 * h), hill(0.4, 0.4 + 0.02 * h)) for h in HEIGHTS])
    best = SHIFTS[values.argmax(1)]
    x, y = of_one_maximum(best, HEIGHTS, SHIFTS, values)
    assert np.isnan(x).sum() == 1
    np.testing.assert_array_equal(np.isnan(x), np.isnan(y))
    assert (np.diff(x)[np.isfinite(np.diff(x))] == 0.0).all()


def test_a_line_follows_a_maximum_that_moves_and_keeps_the_gaps_of_unknown_fields():
    values = np.array([hill(0.03 * h - 0.3, 0.7) for h in HEIGHTS])
    best = SHIFTS[values.argmax(1)]
    best[4] = np.nan
    x, y = of_one_maximum(best, HEIGHTS, SHIFTS, values)
    np.testing.assert_array_equal(x, best)
    np.testing.assert_array_equal(y, HEIGHTS)


def test_the_map_of_a_lens_with_two_foci_has_a_gap_between_them():
    settings = replace(with_lens(Settings(), "pestrekov-100-f27"), focus_position="real")
    plot = mtf_map_figure(query(settings), 24).rows[0][0]
    line = next(layer for layer in plot.layers if isinstance(layer, Curve) and layer.name == "best sagittal")
    steps = np.abs(np.diff(line.x))
    assert np.nanmax(steps) < 0.1 * (plot.x.high - plot.x.low)
