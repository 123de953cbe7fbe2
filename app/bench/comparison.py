"""Two settings compared: dials that the reference takes from the current settings, and differences of numbers.

What B takes with another lens or another camera is its own: A keeps its lens, and the film, focus and place that
belong to it.
"""

import math
import re
from dataclasses import replace

from lensbench.app.bench.constraints import constrained
from lensbench.app.settings.settings import Settings, differences
from lensbench.core.text import fixed, true_minus

FIGURE = re.compile(r"(?P<sign>f/|T |ø )?(?P<value>[+−-]?\d+(?:\.\d+)?)(?P<unit>°)?")
STOPS = ("f/", "T ")            # signs of figures whose difference is counted in stops
DIGITS = 3                      # of a number next to one with decimals: 2 is 2.00 there, without its zeros


def difference(a: str, b: str) -> str:
    """B less A of two numbers as texts, else ""; f-numbers and T-stops in stops, positive where B is brighter."""
    first, second = FIGURE.fullmatch(a), FIGURE.fullmatch(b)
    if first is None or second is None or a == b or first["sign"] != second["sign"] or first["unit"] != second["unit"]:
        return ""
    one, other = (float(number["value"].replace("−", "-")) for number in (first, second))
    if first["sign"] in STOPS:
        return true_minus(f"{fixed(2.0 * math.log2(one / other), 1, signed=True)} EV") if one > 0.0 < other else ""
    decimals = min(_decimals(number["value"]) for number in (first, second)) if "." in a + b else 0
    return true_minus(fixed(other - one, decimals, signed=True)) + (first["unit"] or "")


def _decimals(value: str) -> int:
    """Digits behind the point, those of DIGITS in all for a number without a point."""
    whole, point, behind = value.lstrip("+-−").partition(".")
    return len(behind) if point else max(DIGITS - len(whole), 0)


OWN = ("lens", "edited", "camera", "lens_model", "degree", "focal_length")        # a change of these leaves A as it is
NEVER = ("compare", "wipe", "overlay", "limit")                         # these are of the window, not of a picture


def followed(a: Settings, before: Settings, after: Settings) -> Settings:
    """A after B has changed from `before` to `after`, within the range of A's own lens.

    A lens that opens less far opens as far as it can, and one that focuses less near focuses as near as it can. Where A
    cannot take a change at all, it stays as it was.
    """
    changed = {name: value for name, value in differences(after, before).items() if name not in NEVER}
    if not changed or any(name in changed for name in OWN):
        return a
    try:
        return constrained(replace(a, **changed).checked())
    except (ValueError, OSError):
        return a
