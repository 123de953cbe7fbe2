"""Turning by an angle that differs from lane to lane: for cameras and things that turn while the shutter is open."""

import math

import numpy as np
from numba import njit

# Taylor's coefficients of sine and cosine; what is left out at π/2 is below 2e-17, and 7e-9 after the first seven
_SINE = tuple((-1.0) ** k / math.factorial(2 * k + 1) for k in range(11))
_COSINE = tuple((-1.0) ** k / math.factorial(2 * k) for k in range(11))


@njit(inline="always")
def sine_versine(real, turns):
    """The sine and the versine 1 − cos α of α = 2π · turns, in numbers of the type `real`.

    No branch, any number of turns: both have the period of a turn and follow from
    the half angle within ±π/2, 1 − cos α without cancellation.
    """
    half = (turns - np.floor(turns + real(0.5))) * real(math.pi)
    s = half * half
    double = real(1) + real(1e-9) > real(1)             # known when compiling: single precision needs fewer terms
    last = 10 if double else 6
    sine, cosine = real(_SINE[last]), real(_COSINE[last])
    for k in range(last - 1, -1, -1):
        sine, cosine = sine * s + real(_SINE[k]), cosine * s + real(_COSINE[k])
    sine *= half
    return real(2) * sine * cosine, real(2) * sine * sine
