"""Values of the tables of a scene file: each reader names the value in its SceneError, and says what to write.

A reader takes the value and its name in messages. Lengths in mm, angles in radians, speeds in mm/s, colours linear.
"""

import difflib
import math
import re
from collections.abc import Callable, Collection
from functools import partial
from typing import Any

import numpy as np

import lensbench as lb
from lensbench.core.kernels.numeric import linear
from lensbench.core.text import excerpt

UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "km": 1e6, "": 1.0}
SPEEDS = {"mm/s": 1.0, "cm/s": 10.0, "m/s": 1000.0, "km/h": 1e6 / 3600.0, "": 1.0}

Table = dict[str, Any]
Say = Callable[[str], object]           # receives a sentence on what was assumed or changed
Reader = Callable[[Any, str], Any]      # of a value and its name in messages


def within(where: str, make: Callable, *values: Any) -> Any:
    """make(*values); `where` precedes the message of its errors."""
    try:
        return make(*values)
    except lb.SceneError as error:
        raise lb.SceneError(f"{where}: {error}") from error


def only(t: Table, what: str, known: Collection[str]) -> None:
    """Refuse names that are not known; what: the table in words."""
    for name in t:
        if name not in known:
            near = difflib.get_close_matches(name, known, 1)
            raise lb.SceneError(f"{what} has no {excerpt(name)}"
                                + (f": did you mean {near[0]}?" if near else f" (known: {', '.join(known)})"))


def fields_of(t: Table, what: str, readers: dict[str, Reader], needed: tuple[str, ...] = ()) -> Table:
    """The values of a table, which may hold no other names than those of the readers."""
    only(t, what, readers)
    for name in needed:
        if name not in t:
            raise lb.SceneError(f"{name} is missing")
    return given(t, readers)


def given(t: Table, readers: dict[str, Reader]) -> Table:
    """The values of those readers whose name the table holds."""
    return {name: read(t[name], name) for name, read in readers.items() if name in t}


def as_table(value: Any, name: str) -> Table:
    """A table."""
    if not isinstance(value, dict):
        raise lb.SceneError(f"{name} must be a table")
    return value


def as_tables(t: Table, name: str) -> list[Table]:
    """The tables [[name]] of a table; an empty list where it has none."""
    value = t.get(name, [])
    if not isinstance(value, list):
        raise lb.SceneError(f"{name}: write [[{name}]], with two brackets, for every {name}")
    return [as_table(entry, name) for entry in value]


def text(value: Any, name: str) -> str:
    """Text."""
    if not isinstance(value, str):
        raise lb.SceneError(f"{name} must be text in quotation marks")
    return value


def truth(value: Any, name: str) -> bool:
    """True or false."""
    if not isinstance(value, bool):
        raise lb.SceneError(f"{name} must be true or false")
    return value


def number(value: Any, name: str) -> float:
    """A number, at most 1e9 in size."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise lb.SceneError(f"{name} must be a number, not {excerpt(value)}")
    if not abs(value) <= 1e9:
        raise lb.SceneError(f"{name} is {excerpt(value)}: it must be a finite number, at most 1e9")
    return float(value)


def angle(value: Any, name: str) -> float:
    """An angle in degrees, as radians."""
    return math.radians(number(value, name))


def length(value: Any, name: str) -> float:
    """A length (mm): a number of mm, or text with a unit."""
    return _quantity(value, name, UNITS, "a length as a number of mm, or as \"1.2 m\" (mm, cm, m, km)")


def speed(value: Any, name: str) -> float:
    """A speed (mm/s): a number of mm/s, or text with a unit."""
    return _quantity(value, name, SPEEDS, "a speed as a number of mm/s, or as \"50 km/h\" (mm/s, cm/s, m/s, km/h)")


def _quantity(value: Any, name: str, units: dict[str, float], form: str) -> float:
    """In mm or mm/s: a number, or text with a unit."""
    if not isinstance(value, str):
        return number(value, name)
    match = re.fullmatch(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?)\s*([a-z/]*)\s*", value)
    if match is None or match[2] not in units:
        raise lb.SceneError(f"{name} {excerpt(value)}: write {form}")
    return number(float(match[1]) * units[match[2]], name)


def unit(value: Any, name: str) -> float:
    """The size (mm) of a unit."""
    if not isinstance(value, str) or value not in UNITS or not value:
        raise lb.SceneError(f"{name} {excerpt(value)}: choose one of mm, cm, m, km")
    return UNITS[value]


def numbers(value: Any, name: str, count: int = 3, read: Callable[[Any, str], float] = number) -> tuple[float, ...]:
    """So many values in a list."""
    if not (isinstance(value, list) and len(value) == count):
        raise lb.SceneError(f"{name} must be a list of {count} numbers")
    return tuple(read(entry, name) for entry in value)


def colour(value: Any, name: str, most: float = 1.0) -> tuple[float, ...]:
    """Linear: three numbers, or "#rrggbb" as in sRGB."""
    if isinstance(value, str):
        if not re.fullmatch(r"#[0-9a-fA-F]{6}", value):
            raise lb.SceneError(f"{name} {excerpt(value)}: write a colour as \"#rrggbb\" or as three linear numbers")
        rgb = tuple(float(x) for x in linear(np.array([int(value[k:k + 2], 16) / 255.0 for k in (1, 3, 5)])))
    else:
        rgb = numbers(value, name)
    if min(rgb) < 0.0 or max(rgb) > most:
        raise lb.SceneError(f"{name}: its numbers must lie between 0 and 1" if most == 1.0 else
                            f"{name}: its numbers cannot be negative")
    return rgb


light: Reader = partial(colour, most=math.inf)
vector: Reader = numbers
point: Reader = partial(numbers, read=length)
MOTION = {"velocity": partial(numbers, read=speed), "spin": partial(numbers, read=angle), "pivot": point}
