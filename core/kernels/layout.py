"""Named places in the parameters of a stage, the same for the function that packs them and the stage that reads them.

    CENTRE, RADIUS, COLOUR, BALL = offsets(3, 1, 3)

    def ball_parameters(ball):
        return pack(BALL, {CENTRE: ball.centre, RADIUS: ball.radius, COLOUR: ball.colour})

    @stage
    def balls(lanes, p, ints, key):
        cx, cy, cz = vector(p, CENTRE)

The offsets are module-level integers, which the compiler knows: a name costs nothing at run time.

Parameters are float32, which holds integers exactly up to 2²⁴ only. A larger count travels as two digits to the base
4096 (`digits`, `integer`), exactly up to 2³⁶.
"""

from collections.abc import Mapping
from itertools import accumulate

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

BASE = 4096


def offsets(*widths: int) -> tuple[int, ...]:
    """First indices of consecutive fields of these widths, then the total width."""
    return tuple(accumulate((0, *widths)))


def pack(size: int, fields: Mapping[int, ArrayLike]) -> np.ndarray:
    """Array of `size` numbers with each field at its offset, the rest 0."""
    packed = np.zeros(size)
    for offset, values in fields.items():
        numbers = np.atleast_1d(values)
        packed[offset:offset + numbers.size] = numbers
    return packed


def digits(number: int) -> tuple[int, int]:
    """High and low digit of a count, to the base 4096."""
    return divmod(number, BASE)


@njit(inline="always")
def integer(p, k):
    """The count whose two digits are p[k] and p[k + 1]."""
    return int(p[k]) * BASE + int(p[k + 1])


@njit(inline="always")
def vector(p, k):
    """Three consecutive numbers."""
    return p[k], p[k + 1], p[k + 2]
