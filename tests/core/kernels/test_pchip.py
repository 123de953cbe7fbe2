"""The curve between tabulated values: exact there, smooth, and never beyond its neighbours."""

from math import inf

import pytest
from hypothesis import given, strategies as st

from lensbench.core.kernels.numeric import monotone_cubic
from tests.core.oracles import LAW


@st.composite
def tables(draw):
    count = draw(st.integers(2, 6))
    steps = draw(st.lists(st.floats(0.05, 1.0), min_size=count - 1, max_size=count - 1))
    places = [0.0]
    for step in steps:
        places.append(places[-1] + step)
    values = draw(st.lists(st.floats(-50.0, 50.0), min_size=count, max_size=count))
    return places, values


@LAW
@given(tables())
def test_the_curve_meets_every_value_to_the_last_bit(table):
    places, values = table
    assert [monotone_cubic(places, values, x) for x in places] == values


@LAW
@given(tables(), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_between_two_values_it_runs_from_one_to_the_other_without_turning(table, t, s):
    places, values = table
    low, high = sorted((t, s))
    for i, (a, b) in enumerate(zip(values, values[1:], strict=False)):
        width = places[i + 1] - places[i]
        first, second = (monotone_cubic(places, values, places[i] + u * width) for u in (low, high))
        rounding = 1e-13 * max(abs(a), abs(b))
        assert min(a, b) - rounding <= first <= max(a, b) + rounding
        assert (second - first) * (b - a) >= -rounding * abs(b - a)


@LAW
@given(tables())
def test_its_slope_is_the_same_on_both_sides_of_a_value(table):
    places, values = table
    steepest = max(abs((b - a) / (y - x)) for a, b, x, y in zip(values, values[1:], places, places[1:], strict=False))
    h = 1e-6
    for x, value in list(zip(places, values, strict=True))[1:-1]:
        before = (value - monotone_cubic(places, values, x - h)) / h
        after = (monotone_cubic(places, values, x + h) - value) / h
        # a third of the second derivative, 6 × the steepest chord over a width of 0.05, times h; and rounding
        assert abs(after - before) <= 1e-3 * steepest + 1e-7


@LAW
@given(st.floats(-10.0, 10.0), st.floats(-10.0, 10.0), st.floats(0.0, 2.0))
def test_values_on_a_line_give_the_line(start, slope, x):
    places = [0.0, 0.5, 0.7, 2.0]
    line = [start + slope * place for place in places]
    assert monotone_cubic(places, line, x) == pytest.approx(start + slope * x, abs=1e-13)
    assert monotone_cubic([0.0, 2.0], [start, start + 2.0 * slope], x) == pytest.approx(start + slope * x, abs=1e-13)


def test_of_the_slopes_at_an_even_table_each_is_the_harmonic_mean_of_its_chords():
    places, values = [0.0, 1.0, 2.0], [0.0, 1.0, 4.0]
    h = 1e-6
    slope = (monotone_cubic(places, values, 1.0 + h) - monotone_cubic(places, values, 1.0 - h)) / (2.0 * h)
    assert slope == pytest.approx(2.0 * 1.0 * 3.0 / (1.0 + 3.0), rel=1e-5)
    assert monotone_cubic(places, [2.0, 2.0, 5.0], 0.6) == 2.0         # flat stays flat
    assert monotone_cubic([0.0, 1.0], [3.0, inf], 0.0) == 3.0
