"""Smooth curves through tabulated values that never swing beyond them.

A cubic between neighbours, with the slopes of Fritsch and Butland: the curve and
its slope are continuous, it meets every tabulated value exactly, and between two
of them it rises or falls as they do (it is flat where they are alike, and turns
only at a tabulated value). Two values are joined by a straight line.
Source: Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5 (1984) 300.
"""

from bisect import bisect_right
from collections.abc import Sequence


def monotone_cubic(places: Sequence[float], values: Sequence[float], x: float) -> float:
    """The curve through (places, values) at x; places rise, and x lies between the first and the last."""
    if x in places:
        return values[places.index(x)]
    i = min(max(bisect_right(places, x) - 1, 0), len(places) - 2)
    width, rise = places[i + 1] - places[i], values[i + 1] - values[i]
    t = (x - places[i]) / width
    start, end = (_slope(places, values, k) * width for k in (i, i + 1))
    return values[i] + t * t * (3.0 - 2.0 * t) * rise + t * (1.0 - t) * ((1.0 - t) * start - t * end)


def _slope(places: Sequence[float], values: Sequence[float], i: int) -> float:
    """Of the curve at its i-th place."""
    last = len(places) - 1
    if last == 1:
        return (values[1] - values[0]) / (places[1] - places[0])
    if 0 < i < last:
        before, after = _chord(places, values, i - 1), _chord(places, values, i)
        if before * after <= 0.0:
            return 0.0
        left, right = places[i] - places[i - 1], places[i + 1] - places[i]
        share = (left + 2.0 * right) / (3.0 * (left + right))
        return before * after / (share * after + (1.0 - share) * before)

    # At an end: of the parabola through three points, as far as it keeps the curve within them
    near, far = (0, 1) if i == 0 else (last - 1, last - 2)
    chord, next_chord = _chord(places, values, near), _chord(places, values, far)
    width, next_width = places[near + 1] - places[near], places[far + 1] - places[far]
    slope = ((2.0 * width + next_width) * chord - width * next_chord) / (width + next_width)
    if slope * chord <= 0.0:
        return 0.0
    if chord * next_chord <= 0.0 and abs(slope) > 3.0 * abs(chord):
        return 3.0 * chord
    return slope


def _chord(places: Sequence[float], values: Sequence[float], i: int) -> float:
    return (values[i + 1] - values[i]) / (places[i + 1] - places[i])
