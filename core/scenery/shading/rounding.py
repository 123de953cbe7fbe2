"""Rounding of a point where a ray meets a surface: next rays start that far from the surface, or ignore it so near."""

from lensbench.kernels.cache import njit


@njit(inline="always")
def rounded_length(hx, hy, hz, depth):
    """Length (mm) of which the point hx, hy, hz, met by a ray at the distance `depth`, is off by a part in 10⁷.

    Its coordinates are rounded, and so was the way to it: near the origin of the world, seen from afar, they are small
    and the way is long.
    """
    own = abs(hx) + abs(hy) + abs(hz)
    return own if own > depth else depth
