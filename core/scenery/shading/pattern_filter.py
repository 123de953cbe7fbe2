"""Patterns as the whole of a pixel sees them: what they are on average over the footprint of a ray on a surface.

The footprint is a box along the axes of the pattern: as wide along each of them as a square pixel,
however it is turned, spreads along it (the same variance). With no width a pattern is what it is at the point.
"""

import math

import numpy as np
from numba import njit

THIN = 1e-4             # of a pattern's period: lines are sharp where a footprint is narrower, as far as single tells


@njit(inline="always")
def footprint_stretch(real, along, steep):
    """How much wider than across the ray a footprint is along an axis of the surface.

    along: cosine between ray and axis; steep: 1 / cosine between ray and normal.
    """
    slope = along * steep
    return math.sqrt(real(1) + slope * slope)


@njit(inline="always")
def filtered_contrast(real, off, width):
    """How much is left of a square wave of ±1 between whole numbers, with what sign it has at the point.

    off: to the nearest edge, width: of the box, in the length of a half-wave. Exact below a width of 2, the whole
    wave; the lobes beyond it, at most a third and of the wrong sign, are left out.
    """
    inverse = real(1) / (width + real(1e-20))
    left, level = real(2) * off * inverse, real(2) * inverse - real(1)
    level = level if level < real(1) else real(1)
    level = level if level > real(0) else real(0)
    return left if left < level else level


@njit(inline="always")
def line_coverage(real, place, line, width):
    """What part of a box is covered by lines about all whole numbers, `line` wide; all in the lines' period."""
    off, half, reach = place - _nearest(real, place), real(0.5) * line, real(0.5) * width
    high, low = off + reach, off - reach
    above, below = _nearest(real, high), _nearest(real, low)
    high, low = high - above, low - below
    high = high if high < half else half
    high = high if high > -half else -half
    low = low if low < half else half
    low = low if low > -half else -half
    covered = ((above - below) * line + high - low) / (width + real(1e-20))
    sharp = real(1) if abs(off) <= half else real(0)
    return sharp if width < real(THIN) else covered


@njit(inline="always")
def _nearest(real, x):
    """Whole number."""
    return np.floor(x + real(0.5))
