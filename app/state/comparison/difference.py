"""The difference of two figures as they are written: with the digits of the less precise one."""

import math
import re

from lensbench.kernels.figures import fixed, true_minus

FIGURE = re.compile(r"(?P<sign>f/|T |ø )?(?P<value>[+−-]?\d+(?:\.\d+)?)(?P<unit>°)?")
STOPS = ("f/", "T ")            # signs of figures whose difference is counted in stops
DIGITS = 3                      # of a figure beside one with decimals: 2 is 2.00 there, without its zeros


def difference(a: str, b: str) -> str:
    """B less A of two texts of one figure; "" where one is no single number, or where both read alike.

    Of f-numbers and T-stops the difference is that of the light in stops, positive where B is brighter.
    """
    first, second = FIGURE.fullmatch(a), FIGURE.fullmatch(b)
    if first is None or second is None or a == b or first["sign"] != second["sign"] or first["unit"] != second["unit"]:
        return ""
    one, other = (float(found["value"].replace("−", "-")) for found in (first, second))
    if first["sign"] in STOPS:
        return true_minus(f"{fixed(2.0 * math.log2(one / other), 1, signed=True)} EV") if one > 0.0 < other else ""
    decimals = min(_decimals(found["value"]) for found in (first, second)) if "." in a + b else 0
    return true_minus(fixed(other - one, decimals, signed=True)) + (first["unit"] or "")


def _decimals(value: str) -> int:
    """Digits behind the point, those of DIGITS in all for a number without a point."""
    whole, point, behind = value.lstrip("+-−").partition(".")
    return len(behind) if point else max(DIGITS - len(whole), 0)
