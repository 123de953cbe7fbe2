"""Two pictures compared: how far they differ, in linear light, and in what their settings do."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

SHARE = 0.98                    # of the differences that lie below the scale's end
SAMPLED = 40_000                # pixels that the scale is found from


@dataclass(frozen=True)
class Difference:
    """B − A over all pixels and channels: root mean square, greatest amount, and the amount to be shown as white."""

    rms: float
    largest: float
    scale: float

    @classmethod
    def of(cls, a: NDArray[np.float32], b: NDArray[np.float32]) -> "Difference":
        """Difference of two linear pictures (h, w, 3) of equal size; it is 0 where either is not finite."""
        apart = np.abs(np.nan_to_num(b.astype(np.float32) - a, nan=0.0, posinf=0.0, neginf=0.0))
        stride = max(1, int(math.sqrt(apart.shape[0] * apart.shape[1] / SAMPLED)))
        most = float(np.quantile(apart[::stride, ::stride], SHARE))
        largest = float(apart.max())
        return cls(float(np.sqrt(np.mean(np.square(apart, dtype=np.float64)))), largest,
                   round_above(most or largest or 1.0))


def decibels(a: NDArray[np.float32], b: NDArray[np.float32]) -> float:
    """Peak signal to noise of two linear pictures of one size, clipped to [0, 1], peak 1; infinite where alike."""
    error = float(np.mean(np.square(np.clip(a, 0.0, 1.0) - np.clip(b, 0.0, 1.0), dtype=np.float64)))
    return -10.0 * math.log10(error) if error else math.inf


def round_above(value: float) -> float:
    """The least of 1, 2, 5 · 10ⁿ that is not below a positive value."""
    decade = 10.0 ** math.floor(math.log10(value))
    return next(step * decade for step in (1.0, 2.0, 5.0, 10.0) if step * decade >= value * (1.0 - 1e-12))
