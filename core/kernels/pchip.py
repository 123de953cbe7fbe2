"""Monotone cubic interpolation of tabulated values.

The curve passes through every value and has a continuous slope. Between two values it
rises or falls as they do, so that it never overshoots; between equal values it is flat.
Two values alone are joined by a straight line.
Source of the slopes: Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300.
"""

from bisect import bisect_right
from collections.abc import Sequence


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
