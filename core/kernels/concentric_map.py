"""Equal-area map from the unit square to the unit disk, for apertures and for round lights."""

import math

from lensbench.kernels.cache import njit


@njit(inline="always")
def concentric_disk(real, u, v):
    """Point (x, y) of the unit disk for (u, v) in [0, 1]², by Shirley and Chiu's concentric map (1997).

    real: type of the numbers. Equal areas stay equal. No branch: the angle within an octant is at most
    π/4, where short polynomials give sine and cosine to 2e-9 and 3e-8.
    """
    a, b = real(2) * u - real(1), real(2) * v - real(1)
    steep = abs(b) > abs(a)
    far, near = (b, a) if steep else (a, b)
    safe = far if far != real(0) else real(1)
    t = near / safe * real(math.pi / 4)
    s = t * t
    sine = t * (real(1) + s * (real(-1 / 6) + s * (real(1 / 120) + s * (real(-1 / 5040) + s * real(1 / 362880)))))
    cosine = real(1) + s * (real(-1 / 2) + s * (real(1 / 24) + s * (real(-1 / 720) + s * real(1 / 40320))))
    x, y = (sine, cosine) if steep else (cosine, sine)
    return far * x, far * y
