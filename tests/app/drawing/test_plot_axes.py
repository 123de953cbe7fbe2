"""The map from plot coordinates to pixels on linear, logarithmic and mixed axes, and their ticks."""

import numpy as np
import pytest

from lensbench.app.drawing.plot_axes import PlotMap, linear_ticks, log_ticks


def test_a_logarithmic_and_a_linear_axis_each_have_their_own_scale():
    plot = PlotMap(0.0, 0.0, 100.0, 100.0, 0.0, 2.0, -1.0, 1.0, True, False)        # x from 1 to 100, y from −1 to 1
    assert plot.pixels([1.0, 10.0, 100.0], [-1.0, 0.0, 0.5]).tolist() == [[0.0, 100.0], [50.0, 50.0], [100.0, 25.0]]
    both = PlotMap(0.0, 0.0, 100.0, 100.0, 0.0, 2.0, 0.0, 2.0, True)
    assert both.pixels([10.0], [10.0]).tolist() == [[50.0, 50.0]]


@pytest.mark.parametrize(("low", "high", "pixels", "expected"), [
    (-150.0, 150.0, 60.0, ["−100", "0", "100"]), (0.0, 21.6, 250.0, ["0", "5", "10", "15", "20"]),
    (-0.1, 0.1, 40.0, ["−0.1", "0", "0.1"])])
def test_ticks_are_round_numbers_within_the_axis_that_do_not_touch(low, high, pixels, expected):
    values, labels = linear_ticks(low, high, pixels, 17.0 if low < 0.0 else 42.0)
    assert labels == expected and min(values) >= low and max(values) <= high


def test_an_axis_that_counts_has_ticks_at_whole_numbers_alone():
    assert linear_ticks(3.3, 22.7, 900.0, 20.0, 30)[1] == [str(k) for k in range(4, 23)]
    assert linear_ticks(4.2, 5.9, 900.0, 20.0, 30)[1] == ["5"]          # zoomed in
    assert linear_ticks(-0.6, 12.2, 900.0, 20.0, 10)[1][-1] == "10"     # the last one, though the axis is longer
    assert "4.5" in linear_ticks(4.2, 5.9, 900.0, 20.0)[1]


@pytest.mark.parametrize("pixels", [30.0, 80.0, 200.0, 900.0])
def test_ticks_of_many_decades_do_not_touch(pixels):
    """In a low panel each decade had its figure, one over the other."""
    low, high, room = 1e-5, 1e4, 20.0
    values, labels = log_ticks(low, high, pixels, room)
    places = pixels * np.log10(np.array(values) / low) / np.log10(high / low)
    assert (np.diff(places) >= 0.9 * room).all() and len(values) == len(labels)
    assert ((places >= 0.0) & (places <= pixels)).any()


@pytest.mark.parametrize("span", [(-0.15, 0.15), (-0.7, 0.7), (1.21, 1.29), (400.0, 700.0)])
def test_a_narrow_axis_has_two_figures(span):
    """Of −0.15 to 0.15 mm the only figure was the 0, which tells no scale."""
    values, _ = linear_ticks(*span, 72.0, 44.0)
    assert sum(span[0] <= value <= span[1] for value in values) >= 2


@pytest.mark.parametrize("span", [(0.1, 20.0), (0.1, 70.0), (1.4, 7.9)])
def test_a_low_logarithmic_axis_has_two_figures(span):
    values, _ = log_ticks(*span, 30.0, 18.0)
    assert sum(span[0] <= value <= span[1] for value in values) >= 2


@pytest.mark.parametrize("pixels", [-20.0, 1.0, 3.0, 400.0])
def test_a_logarithmic_axis_of_any_length_has_numbers(pixels):
    values, labels = log_ticks(1e-15, 1e3, pixels, 45.0)
    assert len(values) == len(labels) > 0 and np.isfinite(values).all()


def test_a_falling_axis_has_its_highest_value_at_the_left():
    plot = PlotMap(0.0, 0.0, 100.0, 100.0, 2.0, 0.0, 0.0, 1.0, True, False)        # x from 100 down to 1
    assert plot.pixels([100.0, 10.0, 1.0], [0.0] * 3)[:, 0].tolist() == [0.0, 50.0, 100.0]
    assert plot.x_at(50.0) == pytest.approx(10.0)
