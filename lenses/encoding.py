"""Text and numbers of other programs' files: UTF-8, UTF-16 or Latin-1; decimal commas and Fortran exponents."""

import codecs
import re

from lensbench.kernels.quotation import excerpt
from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.rows import RowError, curvature, number

LONGEST_LINE, LONGEST_NAME = 4000, 200
INFINITE = ("inf", "infinity", "-inf", "-infinity", "1e999", "1.0e+999")
NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eEdD][+-]?\d+)?")
DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+([eEdD][+-]?\d+)?")


def decoded(data: bytes) -> str:
    """The text with plain line ends; UnicodeDecodeError if the bytes are no text in any of these encodings."""
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        text = data.decode("utf-16")
    elif data[1:2] == b"\0" != data[:1]:
        text = data.decode("utf-16-le")
    elif data[:1] == b"\0" != data[1:2]:
        text = data.decode("utf-16-be")
    else:
        try:
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = data.decode("latin-1")
    if "\0" in text:
        raise UnicodeDecodeError("utf-8", data, max(data.find(b"\0"), 0), len(data), "a NUL in a text")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def check_lines(text: str, path: str) -> None:
    """LensFileError for a line longer than any program writes: splitting it into words would take minutes."""
    for line, content in enumerate(text.split("\n"), start=1):
        if len(content) > LONGEST_LINE:
            raise LensFileError(path, line, f"the line has {len(content)} characters: at most {LONGEST_LINE} are read")


def plain_number(text: str) -> str:
    """A number of another program in Python's notation: 1,5 is 1.5 and 1D-3 is 1e-3; other text is unchanged."""
    if DECIMAL_COMMA.fullmatch(text):
        text = text.replace(",", ".")
    if NUMBER.fullmatch(text):
        text = text.replace("D", "e").replace("d", "e")
    return text


def is_number(text: str) -> bool:
    """Whether a word has the form of a number."""
    return NUMBER.fullmatch(plain_number(text)) is not None


def file_number(text: str, name: str, infinite: bool = False) -> float:
    """A number of a file. RowError with the name of the value: no number, or infinite without permission."""
    plain = plain_number(text)
    if not NUMBER.fullmatch(plain) and plain.lower() not in INFINITE:
        raise RowError(f"{name} is {excerpt(text)}: it must be a number")
    return number(plain, name, infinite=infinite)


def first_word(values: list[str]) -> str:
    """The first value of a command. RowError: there is none."""
    if not values:
        raise RowError("a value is missing")
    return values[0]


def first_number(values: list[str], infinite: bool = False) -> float:
    """The first value of a command as a number. RowError: missing or invalid."""
    return file_number(first_word(values), "the value", infinite=infinite)


def file_curvature(text: str) -> float:
    """Curvature of a radius in a file, correctly rounded from its digits; 0 and infinity are a plane."""
    file_number(text, "radius", infinite=True)
    return curvature(plain_number(text))
