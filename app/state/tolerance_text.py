"""Amounts of errors of manufacture, as people read them."""

import math

from lensbench.kernels.figures import significant


def amount(kind: str, value: float) -> str:
    """An error in the unit of its kind: 0.1 %, 0.02 mm, 0.0005, 1′."""
    if kind == "radius":
        return f"± {significant(100.0 * value)} %"
    if kind == "tilt":
        return f"± {significant(60.0 * math.degrees(value), 3)}′"
    return f"± {significant(value)}" + ("" if kind == "index" else " mm")
