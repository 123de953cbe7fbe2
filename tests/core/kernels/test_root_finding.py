"""Roots and minima against closed forms."""

from math import exp, log, pi, sin, sqrt

import pytest
from hypothesis import given, strategies as st

from lensbench.core.kernels.numeric import find_minimum, find_root

RISING = (
    ("cubic", lambda x: x**3 - 2.0, 0.0, 3.0, 2.0 ** (1.0 / 3.0)),
    ("exponential", lambda x: exp(x) - 5.0, 0.0, 4.0, log(5.0)),
    ("steep and flat", lambda x: (10.0 * x) ** 9 - 1.0, 0.0, 1.0, 0.1),
    ("Kepler's equation, e = 1/2", lambda x: x - 0.5 * sin(x) - (1.2 - 0.5 * sin(1.2)), 0.0, pi, 1.2),
)


@pytest.mark.parametrize(("function", "low", "high", "root"), [case[1:] for case in RISING],
                         ids=[case[0] for case in RISING])
def test_a_root_lies_where_the_function_changes_its_sign(function, low, high, root):
    x = find_root(function, low, high)
    assert x == pytest.approx(root, rel=1e-7)
    assert function(x * (1.0 - 1e-12)) <= 0.0 <= function(x * (1.0 + 1e-12))        # to rounding, without a closed form


@given(st.floats(-1e3, 1e3), st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))
def test_the_root_of_a_straight_line_is_found_at_once(root, slope, before):
    calls = []

    def line(x):
        calls.append(x)
        return slope * (x - root)

    x = find_root(line, root - before, root + 2.0 * before, small=1e-9 * slope)
    assert x == pytest.approx(root, abs=1e-8)
    assert len(calls) <= 4              # both ends, the root, and once more for rounding


@pytest.mark.parametrize("at", ["low", "high"])
def test_a_root_at_an_end_of_the_bracket_is_found(at):
    low, high = (1.0, 2.0) if at == "low" else (0.0, 1.0)
    assert find_root(lambda x: x * x - 1.0, low, high) == pytest.approx(1.0, abs=1e-15)


def test_a_value_that_counts_as_rounding_ends_the_search():
    calls = []

    def cube(x):
        calls.append(x)
        return x**3 - 2.0

    assert abs(cube(find_root(cube, 0.0, 3.0, small=0.01))) <= 0.01
    rough = len(calls)
    find_root(cube, 0.0, 3.0)
    assert rough < len(calls) - rough


@given(st.floats(-10.0, 10.0), st.floats(0.1, 10.0))
def test_the_minimum_of_a_parabola_lies_at_its_vertex(vertex, width):
    low, high = vertex - width, vertex + 1.7 * width
    x = find_minimum(lambda x: (x - vertex) ** 2, low, high)
    assert x == pytest.approx(vertex, abs=1e-7 * width + 2e-8)      # its values tell x to the root of the rounding


def test_the_minimum_of_a_sum_of_conjugates_lies_at_twice_the_focal_length():
    f = 50.0                            # x + image distance of a thin lens, 4 f at x = 2 f
    x = find_minimum(lambda x: x + f * x / (x - f), 1.01 * f, 10.0 * f)
    assert x == pytest.approx(2.0 * f, rel=1e-6)
    assert find_minimum(lambda x: -sqrt(x), 0.0, 1.0) == pytest.approx(1.0, abs=1e-9)      # at an end of the interval
