"""Numerical helpers: roots, quadrature, monotone interpolation, rotations and the sRGB curve.

The curve passes through every value and has a continuous slope. Between two values it rises or falls as they do, so
that it never overshoots; between equal values it is flat. Two values alone are joined by a straight line. Source of the
slopes: Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300.
"""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from functools import cache
from math import sqrt

import numpy as np

from lensbench.core.kernels.cache import njit

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


@cache
def gauss_rule(points: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights (points,) of Gauss's quadrature rule from 0 to 1."""
    nodes, weights = np.polynomial.legendre.leggauss(points)
    return 0.5 * (nodes + 1.0), 0.5 * weights


def monotone_cubic(xs: Sequence[float], ys: Sequence[float], x: float) -> float:
    """The curve through the points (xs, ys) at x, xs[0] ≤ x ≤ xs[-1]; xs rise strictly."""
    if x in xs:
        return ys[xs.index(x)]
    i = min(max(bisect_right(xs, x) - 1, 0), len(xs) - 2)
    width, rise = xs[i + 1] - xs[i], ys[i + 1] - ys[i]
    t = (x - xs[i]) / width
    start, end = (_slope(xs, ys, k) * width for k in (i, i + 1))
    return ys[i] + t * t * (3.0 - 2.0 * t) * rise + t * (1.0 - t) * ((1.0 - t) * start - t * end)


def _slope(xs: Sequence[float], ys: Sequence[float], i: int) -> float:
    """Slope of the curve at xs[i]."""
    last = len(xs) - 1
    if last == 1:
        return (ys[1] - ys[0]) / (xs[1] - xs[0])
    if 0 < i < last:
        before, after = _chord(xs, ys, i - 1), _chord(xs, ys, i)
        if before * after <= 0.0:
            return 0.0
        left, right = xs[i] - xs[i - 1], xs[i + 1] - xs[i]
        share = (left + 2.0 * right) / (3.0 * (left + right))
        return before * after / (share * after + (1.0 - share) * before)

    # At an end: the slope of the parabola through three points, limited so that the curve stays monotone
    near, far = (0, 1) if i == 0 else (last - 1, last - 2)
    chord, next_chord = _chord(xs, ys, near), _chord(xs, ys, far)
    width, next_width = xs[near + 1] - xs[near], xs[far + 1] - xs[far]
    slope = ((2.0 * width + next_width) * chord - width * next_chord) / (width + next_width)
    if slope * chord <= 0.0:
        return 0.0
    if chord * next_chord <= 0.0 and abs(slope) > 3.0 * abs(chord):
        return 3.0 * chord
    return slope


def _chord(xs: Sequence[float], ys: Sequence[float], i: int) -> float:
    """Slope of the straight line from point i to point i + 1."""
    return (ys[i + 1] - ys[i]) / (xs[i + 1] - xs[i])


# Taylor coefficients of sine and cosine: the error at π/2 is below 2e-17, and below 7e-9 with the first seven
_SINE = tuple((-1.0) ** k / math.factorial(2 * k + 1) for k in range(11))
_COSINE = tuple((-1.0) ** k / math.factorial(2 * k) for k in range(11))


def rotation_matrix(about_x: float, about_y: float) -> np.ndarray:
    """R_y(about_y) · R_x(about_x), (3, 3): right-handed, by radians, about the fixed axes x, then y."""
    ca, sa, cb, sb = math.cos(about_x), math.sin(about_x), math.cos(about_y), math.sin(about_y)
    return np.array([[cb, sb * sa, sb * ca], [0.0, ca, -sa], [-sb, cb * sa, cb * ca]])


def rotation_about_z(angle: float) -> np.ndarray:
    """R_z(angle), (3, 3): right-handed, by radians, about the axis z: it takes +x towards +y."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@njit(inline="always")
def sine_versine(real, turns):
    """Sine and versine 1 − cos α of α = 2π · turns, in numbers of the type `real`.

    Both follow without a branch from the half angle, reduced to ±π/2; the versine has no cancellation.
    """
    half = (turns - np.floor(turns + real(0.5))) * real(math.pi)
    s = half * half
    double = real(1) + real(1e-9) > real(1)             # known at compile time; float32 needs fewer terms
    last = 10 if double else 6
    sine, cosine = real(_SINE[last]), real(_COSINE[last])
    for k in range(last - 1, -1, -1):
        sine, cosine = sine * s + real(_SINE[k]), cosine * s + real(_COSINE[k])
    sine *= half
    return real(2) * sine * cosine, real(2) * sine * sine


def srgb(linear):
    """The sRGB transfer function, IEC 61966-2-1, of values in [0, 1]."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 0.0031308) ** (1.0 / 2.4) - 0.055)


def linear(codes):
    """Linear light of sRGB values in [0, 1]: the inverse of `srgb`."""
    return np.where(codes <= 0.04045, codes / 12.92, ((np.maximum(codes, 0.04045) + 0.055) / 1.055) ** 2.4)
