"""Rotations: the matrix of two tilts, and sine and versine of an angle that differs from lane to lane."""

import math

import numpy as np

from lensbench.kernels.cache import njit

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
