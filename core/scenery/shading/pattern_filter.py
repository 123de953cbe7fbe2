"""Patterns averaged over the footprint of a pixel.

The footprint of a ray on a surface is a box along the axes of the pattern; along each axis it is as wide as a square
pixel, rotated in any way, spreads there (the same variance). At zero width a pattern has its value at the point.
"""

import math

import numpy as np

from lensbench.core.kernels.cache import njit

THIN = 1e-4             # of a pattern's period: narrower footprints see sharp lines, the limit of float32


@njit(inline="always")
def footprint_stretch(real, along, steep):
    """Width of a footprint along an axis of the surface over its width across the ray.

    along: cosine between ray and axis; steep: 1 / cosine between ray and normal.
    """
    slope = along * steep
    return math.sqrt(real(1) + slope * slope)


@njit(inline="always")
def filtered_contrast(real, off, width):
    """Mean over a box of a square wave of ±1 with edges at the integers, times its sign at the middle of the box.

    off: distance to the nearest edge; width: of the box; both in half-waves. Exact for widths below 2, the full
    wave; the lobes beyond, at most a third and of the opposite sign, are dropped.
    """
    inverse = real(1) / (width + real(1e-20))
    left, level = real(2) * off * inverse, real(2) * inverse - real(1)
    level = level if level < real(1) else real(1)
    level = level if level > real(0) else real(0)
    return left if left < level else level


@njit(inline="always")
def parity(real, k):
    """0 for an even whole number, 1/2 for an odd one."""
    return k * real(0.5) - np.floor(k * real(0.5))


@njit(inline="always")
def checker_contrast(real, a, b, wide_a, wide_b):
    """Contrast of a checker of unit fields at a, b, averaged over a box wide_a × wide_b: 1 sharp, 0 uniform."""
    return (filtered_contrast(real, abs(a - np.floor(a + real(0.5))), wide_a)
            * filtered_contrast(real, abs(b - np.floor(b + real(0.5))), wide_b))


@njit(inline="always")
def line_coverage(real, position, line, width):
    """Part of a box that lines about all integers cover; place, line and box width in periods of the lines."""
    off, half, reach = position - _nearest(real, position), real(0.5) * line, real(0.5) * width
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
    """Nearest integer."""
    return np.floor(x + real(0.5))
