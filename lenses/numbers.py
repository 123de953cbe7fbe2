"""Checked numbers of lens files."""

from decimal import Decimal
from math import inf, isinf, isnan

from lensbench.kernels.quotation import cut, excerpt


class RowError(ValueError):
    """An invalid value in a row or a header; the reader adds the file and the line."""


def number(value: object, name: str, infinite: bool = False) -> float:
    """The value, a number or its text, as a float. RowError: no number, NaN, or infinite without permission."""
    if isinstance(value, bool) or not isinstance(value, int | float | str | Decimal):
        raise RowError(f"{name} is {excerpt(value)}: it must be a number")
    try:
        result = float(value)
    except OverflowError:
        result = inf
    except ValueError:
        raise RowError(f"{name} is {excerpt(value)}: it must be a number") from None
    if isnan(result) or (isinf(result) and not infinite):
        raise RowError(f"{name} is {result}: it must be a finite number")
    return result


def not_understood(what: str) -> str:
    """The reason for which a file with an unknown command or entry is refused."""
    return f"{cut(what)} is not understood, and may change the lens: if it does not, remove it"
