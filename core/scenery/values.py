"""Checks and vectors that all scene objects share."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.text import significant

Triple = tuple[float, float, float]
FRAMING_NAMES = ("close", "head", "head-and-shoulders", "half-figure", "full-figure", "subject", "whole-scene")


class SceneError(ValueError):
    """An invalid scene; the message says how to correct it."""


def check(value: Any, positive: Sequence[str] = ()) -> None:
    """Refuse numbers that are not finite, and named lengths that are not positive."""
    for f in fields(value):
        numbers = getattr(value, f.name)
        for x in numbers if isinstance(numbers, tuple) else (numbers,):
            if isinstance(x, float | int) and not math.isfinite(x):
                raise SceneError(f"{f.name} of a {type(value).__name__.lower()} is {x}: it must be a finite number")
        if f.name in positive and not numbers > 0:
            raise SceneError(f"{f.name} of a {type(value).__name__.lower()} is {significant(numbers)}: it must "
                             f"be positive")


def unit(v: ArrayLike) -> np.ndarray:
    """The vector scaled to length 1."""
    v = np.asarray(v, np.float64)
    return v / math.sqrt(v @ v)


def cross(a: Iterable[float], b: Iterable[float]) -> np.ndarray:
    """Cross product of two vectors, without the overhead of numpy's for arrays of them."""
    (x, y, z), (u, v, w) = a, b
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def triple(v: np.ndarray | Sequence[float]) -> Triple:
    """Three numbers of an array as a tuple of floats."""
    return (float(v[0]), float(v[1]), float(v[2]))


def across(direction: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Two unit axes (right, up) perpendicular to a direction.

    right × up points along the direction; right is horizontal (y = 0) unless the direction is nearly vertical.
    """
    axis = unit(direction)
    right = unit(cross((0.0, 1.0, 0.0) if abs(axis[1]) < 0.999 else (0.0, 0.0, -1.0), axis))
    return right, cross(axis, right)
