"""Roots and minima of functions of one number."""

from collections.abc import Callable
from math import sqrt

_ITERATIONS = 60                # of false position; about ten suffice for a smooth function
_SECTIONS = 48                  # of the golden section: to 1e-10 of the interval; a minimum is flat there


def find_root(function: Callable[[float], float], low: float, high: float, small: float = 0.0) -> float:
    """Root of a rising function in [low, high], by false position in its Illinois form.

    The function is ≤ 0 at `low` and ≥ 0 at `high`. small: a value of the function that counts as 0,
    such as its rounding error. The search ends where |value| or the bracket is at most 1e-15 · high.
    """
    at_low, at_high = function(low), function(high)
    side, tolerance = 0, 1e-15 * high
    x = low
    for _ in range(_ITERATIONS):
        x = min(high, max(low, high - at_high * (high - low) / (at_high - at_low)))     # rounding may lead out
        value = function(x)
        if abs(value) <= max(tolerance, small) or high - low <= tolerance:
            break

        # An end that stays for two steps has its value halved, so that the bracket closes from both sides
        if value > 0.0:
            high, at_high = x, value
            at_low, side = (0.5 * at_low if side > 0 else at_low), 1
        else:
            low, at_low = x, value
            at_high, side = (0.5 * at_high if side < 0 else at_high), -1
    return x


def find_minimum(function: Callable[[float], float], low: float, high: float) -> float:
    """Place of the minimum of a function with one valley in [low, high], by golden section."""
    golden = 0.5 * (sqrt(5.0) - 1.0)
    for _ in range(_SECTIONS):
        left, right = high - golden * (high - low), low + golden * (high - low)
        if function(left) < function(right):
            high = right
        else:
            low = left
    return 0.5 * (low + high)
