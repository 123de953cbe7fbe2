"""Foreign text in messages: on one line, without control characters, and cut where it is long.

Files, names of files and arguments may hold line ends, terminal escapes, marks that reverse the direction of writing,
and values of any length. A message that repeats them must stay one readable line.
"""

from typing import Any
from unicodedata import category

MOST = 60                                       # characters of a value in a message
LONGEST_PATH = 300                              # characters of a path there
HIDDEN = {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"}     # categories of characters that no one sees or that move others


def escaped(text: str) -> str:
    r"""The text with every control character, line end, direction mark and lone surrogate as its escape: \n, \x1b."""
    if text.isprintable():
        return text
    return "".join(_escape(character) if category(character) in HIDDEN else character for character in text)


def cut(text: str, most: int = MOST) -> str:
    """The text in at most `most` characters; a longer one loses its middle for an ellipsis."""
    if len(text) <= most:
        return text
    return f"{text[:most - 1 - most // 4]}…{text[len(text) - most // 4:]}"


def excerpt(value: Any, most: int = MOST) -> str:
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
