"""Where a function of one number is zero, and where it is least."""

from collections.abc import Callable
from math import sqrt


def find_root(function: Callable[[float], float], low: float, high: float, small: float = 0.0) -> float:
    """Root of a rising function within a bracket, to the rounding of its values: false position, Illinois form.

    small: a value of the function that is rounding.
    """
    at_low, at_high = function(low), function(high)
    side, tolerance = 0, 1e-15 * high
    x = low
    for _ in range(60):
        x = min(high, max(low, high - at_high * (high - low) / (at_high - at_low)))     # rounding may lead out
        value = function(x)
        if abs(value) <= max(tolerance, small) or high - low <= tolerance:
            break
        if value > 0.0:
            high, at_high = x, value
            at_low, side = (0.5 * at_low if side > 0 else at_low), 1
        else:
            low, at_low = x, value
            at_high, side = (0.5 * at_high if side < 0 else at_high), -1
    return x


def find_minimum(function: Callable[[float], float], low: float, high: float) -> float:
    """Place of the least value of a function with one valley, by golden section."""
    golden = 0.5 * (sqrt(5.0) - 1.0)
    for _ in range(48):                                 # to 1e-10 of the interval; the value is flat there
        left, right = high - golden * (high - low), low + golden * (high - low)
        if function(left) < function(right):
            high = right
        else:
            low = left
    return 0.5 * (low + high)
