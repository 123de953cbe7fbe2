"""JSON of other programs: values by path, and the line on which each item of a list begins.

Numbers with a point are read as Decimal and written from it, so that sums and differences (places on the axis, 1 + k)
keep all digits in both directions.
"""

import json
import re
from collections.abc import Collection
from decimal import Context, Decimal
from typing import Any

from lensbench.kernels.quotation import cut, excerpt
from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.numbers import RowError, not_understood, number

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
    found = re.search(rf'"{re.escape(key)}"\s*:\s*\[', text)
    lines: list[int] = []
    place, counted, line = (found.end() if found else len(text)), 0, 1
    while place < len(text) and len(lines) < MOST_ITEMS:
        between = BETWEEN.match(text, place)
        place = between.end() if between else place
        if text[place:place + 1] in ("]", ""):
            break
        line, counted = line + text.count("\n", counted, place), place
        lines.append(line)
        try:
            _, place = json.JSONDecoder().raw_decode(text, place)
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
    found = data.get(key, default)
    if found is None:
        if default is None:
            raise RowError(f"{key} is missing")
        return default
    return number(found, key, infinite)


def text_value(data: dict[str, Any], key: str) -> str:
    """A text of an object; "" if it is missing. RowError: another type."""
    found = data.get(key)
    if found is not None and not isinstance(found, str):
        raise RowError(f"{key} is {excerpt(found)}: it must be a text in quotes")
    return found or ""


def flag(data: dict[str, Any], key: str) -> bool:
    """A yes or no of an object; no if it is missing. RowError: another type."""
    found = data.get(key)
    if found is not None and not isinstance(found, bool):
        raise RowError(f"{key} is {excerpt(found)}: it must be true or false")
    return bool(found)


def check_keys(data: dict[str, Any], known: Collection[str], of: str = "") -> None:
    """Raise RowError for an entry that is neither known nor empty (null, false, "", [], {}): it may change the lens."""
    for key, found in data.items():
        if key not in known and not (found is None or found is False or found == "" or found == [] or found == {}):
            raise RowError(not_understood(f"{cut(key)}{of}"))


def exact(number: float | Decimal) -> Decimal:
    """The number with the digits of the file."""
    return number if isinstance(number, Decimal) else Decimal(repr(number))


def exact_value(data: dict[str, Any], key: str, default: float | None = None, infinite: bool = False) -> Decimal:
    """A number of an object with all its digits. RowError: missing or invalid."""
    plain = value(data, key, default, infinite)
    found = data.get(key)
    return found if isinstance(found, Decimal) else exact(plain)


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
    found = items(data.get(key))
    numbers = [number(a, f"{key}[{i}]") for i, a in enumerate(found)]
    if any(numbers[len(powers):]):
        raise RowError(f"{key} has {len(numbers)} coefficients, of which {len(powers)} can be traced")
    result = {power: a for power, a in zip(powers, numbers, strict=False) if a}
    if 1 in result:
        raise RowError("a term in r¹ makes a cone, which is not traced")
    return result
