"""Text of lens files: encodings, numbers, and JSON with the line of each item.

Numbers with a point are read as Decimal and written from it, so that sums and differences (places on the axis, 1 + k)
keep all digits in both directions.
"""

import codecs
import json
import re
from collections.abc import Collection
from decimal import Context, Decimal
from typing import Any

from lensbench.core.text import cut, excerpt
from lensbench.lenses.file_error import LensFileError, RowError, not_understood, number
from lensbench.lenses.tables.rows import curvature

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


BETWEEN = re.compile(r"[\s,]*")
MOST_ITEMS = 2000
EXACT = Context(prec=1200, traps=[])        # enough for the sum of the largest and the smallest float


def parse(text: str, path: str) -> dict[str, Any]:
    """The object of the file. LensFileError: not JSON, or not an object."""
    try:
        data = json.loads(text, parse_float=Decimal)
    except RecursionError:
        raise LensFileError(path, None, "its brackets are nested too deep") from None
    except json.JSONDecodeError as error:
        raise LensFileError(path, error.lineno, f"not valid JSON: {error.msg}") from None
    except ValueError as error:
        raise LensFileError(path, None, f"not valid JSON: {error}") from None
    except ArithmeticError:
        raise LensFileError(path, None, "not valid JSON: a number whose exponent cannot be read") from None
    if not isinstance(data, dict):
        raise LensFileError(path, 1, "a lens in JSON is an object in braces")
    return data


def item_lines(text: str, key: str) -> list[int]:
    """Line on which each item of the first list of this name begins."""
    start = re.search(rf'"{re.escape(key)}"\s*:\s*\[', text)
    lines: list[int] = []
    position, counted, line = (start.end() if start else len(text)), 0, 1
    while position < len(text) and len(lines) < MOST_ITEMS:
        between = BETWEEN.match(text, position)
        position = between.end() if between else position
        if text[position:position + 1] in ("]", ""):
            break
        line, counted = line + text.count("\n", counted, position), position
        lines.append(line)
        try:
            _, position = json.JSONDecoder().raw_decode(text, position)
        except (ValueError, RecursionError):
            break
    return lines


def table(data: Any, *keys: str) -> dict[str, Any]:
    """The object at a path of keys, {} if there is none; unwraps the objects of rayoptics. RowError: another type."""
    for key in ("", *keys):
        data = data.get(key) if key else data
        if data is None:
            return {}
        if not isinstance(data, dict):
            raise RowError(f"{key or 'an entry'} is {excerpt(data)}: it must be an object in braces")
        if isinstance(data.get("attributes"), dict):
            data = data["attributes"]
    return dict(data)


def items(data: Any) -> list[Any]:
    """Items of a list, also of one written by numpy; [] where there is none. RowError: another type."""
    if isinstance(data, dict) and "__ndarray__" in data:
        data = data["__ndarray__"]
    if data is not None and not isinstance(data, list):
        raise RowError(f"{excerpt(data)} must be a list in brackets")
    return data or []


def value(data: dict[str, Any], key: str, default: float | None = None, infinite: bool = False) -> float:
    """A number of an object. RowError: missing or invalid."""
    stored = data.get(key, default)
    if stored is None:
        if default is None:
            raise RowError(f"{key} is missing")
        return default
    return number(stored, key, infinite)


def text_value(data: dict[str, Any], key: str) -> str:
    """A text of an object; "" if it is missing. RowError: another type."""
    stored = data.get(key)
    if stored is not None and not isinstance(stored, str):
        raise RowError(f"{key} is {excerpt(stored)}: it must be a text in quotes")
    return stored or ""


def flag(data: dict[str, Any], key: str) -> bool:
    """A yes or no of an object; no if it is missing. RowError: another type."""
    stored = data.get(key)
    if stored is not None and not isinstance(stored, bool):
        raise RowError(f"{key} is {excerpt(stored)}: it must be true or false")
    return bool(stored)


def check_keys(data: dict[str, Any], known: Collection[str], of: str = "") -> None:
    """Raise RowError for an entry that is neither known nor empty (null, false, "", [], {}): it may change the lens."""
    for key, stored in data.items():
        if key not in known and not (stored is None or stored is False or stored == "" or stored == [] or stored == {}):
            raise RowError(not_understood(f"{cut(key)}{of}"))


def exact(number: float | Decimal) -> Decimal:
    """The number with the digits of the file."""
    return number if isinstance(number, Decimal) else Decimal(repr(number))


def exact_value(data: dict[str, Any], key: str, default: float | None = None, infinite: bool = False) -> Decimal:
    """A number of an object with all its digits. RowError: missing or invalid."""
    plain = value(data, key, default, infinite)
    stored = data.get(key)
    return stored if isinstance(stored, Decimal) else exact(plain)


def text_of(data: Any, indent: int = 0) -> str:
    """JSON text of dicts, lists and plain values; short ones on one line; a Decimal keeps its digits."""
    if isinstance(data, Decimal):
        return str(data) if data.is_finite() else f"{float(data):f}".replace("inf", "Infinity")
    if not isinstance(data, dict | list):
        return json.dumps(data)
    marks = "{}" if isinstance(data, dict) else "[]"
    if not any(isinstance(item, dict | list) and item for item in (data.values() if isinstance(data, dict) else data)):
        inner = ", ".join(_entries(data, 0))
        if len(inner) < 100:
            return f"{marks[0]}{inner}{marks[1]}"
    margin = "\n" + " " * (indent + 1)
    return f"{marks[0]}{margin}{f',{margin}'.join(_entries(data, indent + 1))}\n{' ' * indent}{marks[1]}"


def _entries(data: dict[str, Any] | list[Any], indent: int) -> list[str]:
    if isinstance(data, list):
        return [text_of(item, indent) for item in data]
    return [f"{json.dumps(key)}: {text_of(item, indent)}" for key, item in data.items()]


def coefficients(data: dict[str, Any], key: str, powers: list[int]) -> dict[int, float]:
    """Aspheric coefficients other than 0, by their powers. RowError: a power that is not traced."""
    entries = items(data.get(key))
    numbers = [number(a, f"{key}[{i}]") for i, a in enumerate(entries)]
    if any(numbers[len(powers):]):
        raise RowError(f"{key} has {len(numbers)} coefficients, of which {len(powers)} can be traced")
    result = {power: a for power, a in zip(powers, numbers, strict=False) if a}
    if 1 in result:
        raise RowError("a term in r¹ makes a cone, which is not traced")
    return result
