"""Arithmetic with sixty digits: the reference of the stability sweeps.

Arrays of `decimal` numbers, on which numpy's arithmetic works, within `exactly()`.
"""

from contextlib import AbstractContextManager
from decimal import Context, Decimal, localcontext

import numpy as np
from numpy.typing import ArrayLike

DIGITS = 60


def exactly() -> AbstractContextManager:
    """Context in which this thread computes with DIGITS digits."""
    return localcontext(Context(prec=DIGITS))


def exact(values: ArrayLike) -> np.ndarray:
    """The floats as exact decimal numbers."""
    return np.vectorize(lambda value: Decimal(float(value)), otypes=[object])(np.asarray(values))


def root(values: np.ndarray) -> np.ndarray:
    """Square roots; NaN for negative values."""
    return np.frompyfunc(lambda value: value.sqrt() if value >= 0 else Decimal("NaN"), 1, 1)(values)


def floats(values: np.ndarray) -> np.ndarray:
    """The nearest double-precision numbers."""
    return np.asarray(values, dtype=np.float64)


def distance(points: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Distances (n,) from points (n, 3), floats, to exact points; NaN where either is not finite."""
    known = np.isfinite(points).all(-1)
    away = exact(np.where(known[..., None], points, 0.0)) - truth
    return np.where(known, floats(root((away * away).sum(-1))), np.nan)


PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459230781640628620899862803482534211706798")


def sine_cosine(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sine and cosine of exact angles (radians) of up to a few turns.

    Taylor series of an eighth of the angle, doubled three times.
    """
    x = angles / 8
    sine, cosine, term = x * 0, x * 0, x * 0 + 1
    for k in range(0, 60, 2):
        cosine, term = cosine + term, term * x / (k + 1)
        sine, term = sine + term, -term * x / (k + 2)
    for _ in range(3):
        sine, cosine = 2 * sine * cosine, 1 - 2 * sine * sine
    return sine, cosine
