"""Equal-area map from the unit square to the unit disk, for apertures and for round lights."""

import math

import numpy as np

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


@njit(inline="always")
def cosine_direction(real, u, v, nx, ny, nz):
    """Unit direction for (u, v) in [0, 1]² about a unit normal, in proportion to the cosine of the angle between both.

    Malley's method: a point of the disk, raised to the hemisphere. The axes across the normal are those of Duff et al.
    (2017), without a branch.
    """
    a, b = concentric_disk(real, u, v)
    rest = real(1) - a * a - b * b
    c = math.sqrt(rest if rest > real(0) else real(0))
    sign = real(1) if nz >= real(0) else real(-1)
    e = real(-1) / (sign + nz)
    f = nx * ny * e
    return (c * nx + a * (real(1) + sign * nx * nx * e) + b * f, c * ny + a * sign * f + b * (sign + ny * ny * e),
            c * nz - a * sign * nx - b * ny)


def unit_disk(uv) -> np.ndarray:
    """Points of the unit disk of pupil samples, by the map of every camera: (0.5, 0.5) is the centre.

    Parameters
    ----------
    uv : (n, 2) array
        Pupil samples in [0, 1]².

    Returns
    -------
    (n, 2) array
        Points x, y of the unit disk; equal areas of the square have equal areas.

    References
    ----------
    Shirley and Chiu 1997, A low distortion map between disk and square.
    """
    u, v = np.asarray(uv, float).T
    a, b = 2.0 * v - 1.0, 2.0 * u - 1.0
    steep = np.abs(b) > np.abs(a)
    far, near = np.where(steep, (b, a), (a, b))
    angle = near / np.where(far != 0.0, far, 1.0) * (math.pi / 4)
    sine, cosine = far * np.sin(angle), far * np.cos(angle)
    return np.where(steep, (sine, cosine), (cosine, sine)).T.copy()


def unit_square(points) -> np.ndarray:
    """Pupil samples of points of a round pupil: the inverse of `unit_disk`.

    Parameters
    ----------
    points : (n, 2) array
        Points x, y in radii of the pupil.

    Returns
    -------
    (n, 2) array
        Pupil samples uv: in [0, 1]² inside the unit disk, and outside that square for points outside the disk.

    References
    ----------
    Shirley and Chiu 1997, A low distortion map between disk and square.
    """
    x, y = np.asarray(points, float).T
    steep = np.abs(y) > np.abs(x)
    across, along = np.where(steep, (y, x), (x, y))
    far = np.copysign(np.hypot(x, y), across)
    near = far * np.arctan(along / np.where(across != 0.0, across, 1.0)) * (4 / math.pi)
    a, b = np.where(steep, (near, far), (far, near))
    return np.stack([0.5 * (b + 1.0), 0.5 * (a + 1.0)], 1)
