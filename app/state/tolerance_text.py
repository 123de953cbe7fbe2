"""Errors of manufacture, as people read them."""

import math

from lensbench.kernels.figures import significant

KIND_SIGNS = {"radius": "R", "thickness": "t", "index": "n", "decentre": "d", "tilt": "a"}


def amount(kind: str, value: float) -> str:
    """An error in the unit of its kind: 0.1 %, 0.02 mm, 0.0005, 1′."""
    if kind == "radius":
        return f"± {significant(100.0 * value)} %"
    if kind == "tilt":
        return f"± {significant(60.0 * math.degrees(value), 3)}′"
    return f"± {significant(value)}" + ("" if kind == "index" else " mm")


def error_name(kind: str, surface: int) -> str:
    """What an error is of: "radius of surface 3", "index behind surface 0", "tilt of element at 2"."""
    if kind == "index":
        return f"index behind surface {surface}"
    return f"{kind} of {'surface' if kind in ('radius', 'thickness') else 'element at'} {surface}"
