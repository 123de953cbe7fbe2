"""Text: numbers with units as people read them, and foreign text in messages.

People read these texts; files and JSON have numbers of their own. A figure from 10⁻⁶ to 10⁷ has no power of ten, zero
has no sign, and a value that does not exist is a word.

Files, names of files and arguments may hold line ends, terminal escapes, marks that reverse the direction of writing,
and values of any length. A message that repeats them must stay one readable line.
"""

from functools import lru_cache
from math import isinf, isnan
from typing import Any
from unicodedata import category

LEAST, MOST_DIGITS = 1e-6, 1e7         # of figures without a power of ten
UNDEFINED, INFINITE = "nan", "∞"
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


@lru_cache(maxsize=4096)            # the window formats the same figures in every frame
def significant(value: float, digits: int = 6, signed: bool = False) -> str:
    """A number with at most `digits` significant digits: 0.0213, 2.5, 4900, 1.5×10⁻⁸.

    Args:
        value: Any number, in the unit that the text after it names; inf is "∞", nan is "nan".
        digits: Significant digits, at least 1; zeros at the end of decimals are left out.
        signed: Whether a positive number has a plus sign.
    Returns:
        The text, with a hyphen as its minus sign.
    """
    value = float(value)
    word = _word(value, signed)
    if word:
        return word
    mantissa, _, exponent = f"{abs(value):.{digits - 1}e}".partition("e")
    power = int(exponent)
    sign = "-" if value < 0.0 else "+" if signed else ""
    if value == 0.0:
        return "0"
    if not LEAST <= abs(value) < MOST_DIGITS:
        return f"{sign}{_bare(mantissa)}×10{str(power).translate(RAISED)}"
    rounded = float(f"{mantissa}e{power}")
    return sign + _bare(f"{rounded:.{max(digits - 1 - power, 0)}f}")


def fixed(value: float, decimals: int, signed: bool = False, grouped: bool = False) -> str:
    """A number with so many decimals, as in a column: 0.000, 12.50, 1,250.0.

    Args:
        value: Any number; inf is "∞", nan is "nan".
        decimals: Digits behind the point.
        signed: Whether a number that is not rounded to zero has a plus sign.
        grouped: Whether commas separate the thousands.
    Returns:
        The text, with a hyphen as its minus sign; a number that rounds to zero has no sign.
    """
    value = float(value)
    word = _word(value, signed)
    if word:
        return word
    text = f"{abs(value):{',' if grouped else ''}.{decimals}f}"
    if not text.strip("0."):
        return text
    return ("-" if value < 0.0 else "+" if signed else "") + text


def f_number_text(value: float | None, decimals: int | None = None, sign: str = "f/") -> str:
    """An f-number as engraved on lenses: f/0.95, f/2, f/2.8, f/11; "none" where there is none.

    Args:
        value: The f-number; inf is "f/∞"; None, nan, 0 and a negative number are none.
        decimals: Digits behind the point; None for those of an engraving.
        sign: Before the number: "T/" for a T-number.
    Returns:
        The text.
    """
    if value is None or isnan(value) or value <= 0.0:
        return "none"
    if decimals is not None and value >= 10.0**-decimals:
        return sign + fixed(value, decimals)
    if value < 0.095:
        return sign + significant(value, 2)
    return sign + fixed(value, 2 if value < 0.995 else 1 if value < 9.95 else 0).removesuffix(".0")


def true_minus(text: str) -> str:
    """The text with a minus sign instead of each hyphen, for drawn figures."""
    return text.replace("-", "−")


def _word(value: float, signed: bool) -> str:
    """What is written for a value that is no finite number; "" for others."""
    if isnan(value):
        return UNDEFINED
    return ("-" if value < 0.0 else "+" if signed else "") + INFINITE if isinf(value) else ""


def _bare(text: str) -> str:
    """Decimals without zeros at their end."""
    return text.rstrip("0").rstrip(".") if "." in text else text


MOST_CHARACTERS = 60                                       # characters of a value in a message
LONGEST_PATH = 300                              # characters of a path there
HIDDEN = {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"}     # categories of characters that no one sees or that move others


def escaped(text: str) -> str:
    r"""The text with every control character, line end, direction mark and lone surrogate as its escape: \n, \x1b."""
    if text.isprintable():
        return text
    return "".join(_escape(character) if category(character) in HIDDEN else character for character in text)


def cut(text: str, most: int = MOST_CHARACTERS) -> str:
    """The text in at most `most` characters; a longer one loses its middle for an ellipsis."""
    if len(text) <= most:
        return text
    return f"{text[:most - 1 - most // 4]}…{text[len(text) - most // 4:]}"


def excerpt(value: Any, most: int = MOST_CHARACTERS) -> str:
    """A value as `repr` writes it, in at most `most` characters: 'wide', [1, 2], 'aaaaaaaa…aaa'."""
    if isinstance(value, str):                  # of a long text no repr of the whole is made
        value = cut(value, most - 2)
    elif isinstance(value, int) and value.bit_length() > 4 * most:
        return f"a whole number of {value.bit_length()} bits"           # repr refuses one of 4300 digits
    try:
        return cut(repr(value).replace("\\u2026", "…"), most)
    except (ValueError, RecursionError):        # such a number inside a list, or brackets nested too deep
        return f"a value of type {type(value).__name__}"


def _escape(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")
