"""Named places in the parameters of a stage, the same for the function that packs them and the stage that reads them.

    CENTRE, RADIUS, COLOUR, BALL = offsets(3, 1, 3)

    def ball_parameters(ball):
        return pack(BALL, {CENTRE: ball.centre, RADIUS: ball.radius, COLOUR: ball.colour})

    @stage
    def balls(lanes, p, ints, key):
        cx, cy, cz = vector(p, CENTRE)

The offsets are module-level integers, which the compiler knows: a name costs nothing at run time.

Parameters are float32, which holds integers exactly up to 2²⁴ only: counts, indices and kinds travel beside them in
an array of integers (`Packed`).
"""

from collections.abc import Mapping
from itertools import accumulate
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lensbench.kernels.cache import njit


class Packed(NamedTuple):
    """Parameters and integers of a stage, or of a part of one."""

    parameters: np.ndarray
    integers: ArrayLike = ()


def join(*parts: Packed) -> Packed:
    """The parameters of all parts, one after the other, and their integers."""
    return Packed(np.concatenate([np.zeros(0), *(part.parameters for part in parts)]),
                  np.concatenate([np.zeros(0, np.int64), *(np.asarray(part.integers, np.int64) for part in parts)]))


def offsets(*widths: int) -> tuple[int, ...]:
    """First indices of consecutive fields of these widths, then the total width."""
    return tuple(accumulate((0, *widths)))


def pack(size: int, fields: Mapping[int, ArrayLike]) -> np.ndarray:
    """Array of `size` numbers with each field at its offset, the rest 0."""
    packed = np.zeros(size)
    for offset, values in fields.items():
        if isinstance(values, float | int):             # most are: ten times as fast as an array of one
            packed[offset] = values
            continue
        numbers = np.atleast_1d(values)
        packed[offset:offset + numbers.size] = numbers
    return packed


@njit(inline="always")
def vector(p, k):
    """Three consecutive numbers."""
    return p[k], p[k + 1], p[k + 2]
