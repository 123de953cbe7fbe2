"""The project's own lens file: TOML with a header and one surface a row.

    format = 1
    title = "Double Gauss 50 mm f/2"
    kind = "double Gauss"
    stated_efl = 50.0
    units = "mm"
    columns = ["radius", "thickness", "n_d", "semi_diameter"]
    surfaces = [
        [29.475, 3.76,  1.67, 12.6],
        …
        [inf,    4.5,   1.0,   8.55, "stop"],
    ]

`columns` says what stands in each row, so that later columns break no file;
radius 0 or inf is a plane, V_d 0 is not known, and "stop" at the end of a row
marks the aperture stop. Lengths in mm, each thickness and medium *after* its
surface. Digits are kept: what is written reads back equal to the last bit.
"""

import json
import re
import tomllib
from decimal import Decimal
from math import isfinite
from typing import Any

from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.rows import RowError, number, radius_text, stop_of, surface
from lensbench.lenses.soundness import f_number, focal_length
from lensbench.prescription import Lens, Surface

FORMAT = 1
REQUIRED = ("radius", "thickness", "n_d", "semi_diameter")
COLUMNS = ("radius", "thickness", "n_d", "V_d", "semi_diameter", "glass")
TEXTS = ("title", "kind", "source", "notes")
NUMBERS = ("stated_efl", "stated_f_number", "computed_efl", "computed_f_number", "image_circle")
KEYS = ("format", "units", "year", "columns", "surfaces", *TEXTS, *NUMBERS)


def read(text: str, path: str) -> Lens:
    """The lens of a file's text; `path` is named in errors. LensFileError: the line and what is wrong in it."""
    data = parse(text, path)
    header = check_header(data, text, path)
    columns = _columns(data.get("columns"), text, path)
    rows = data.get("surfaces")
    if not isinstance(rows, list) or not rows:
        raise LensFileError(path, line_of(text, "surfaces"), "there are no surfaces: `surfaces` must be a list of rows")
    surfaces, marked = [], []
    for i, row in enumerate(rows):
        try:
            made, is_stop = _surface(row, columns)
        except RowError as error:
            raise LensFileError(path, _row_line(text, i), f"surface {i}: {error}") from None
        surfaces.append(made)
        if is_stop:
            marked.append(i)
    stop_index, findings = stop_of(tuple(surfaces), marked)
    return Lens(tuple(surfaces), stop_index, name=header.get("title", ""), kind=header.get("kind", ""),
                year=header.get("year"), source=header.get("source", ""), stated_efl=header.get("stated_efl"),
                stated_f_number=header.get("stated_f_number"), notes=header.get("notes", ""), findings=findings)


def parse(text: str, path: str) -> dict[str, Any]:
    """The keys of the file, numbers with a point as Decimal."""
    try:
        return tomllib.loads(text, parse_float=Decimal)
    except RecursionError:
        raise LensFileError(path, None, "its brackets are nested too deep") from None
    except (ValueError, ArithmeticError) as error:
        place = re.search(r"\(at line (\d+), column \d+\)", str(error))
        line = int(place[1]) if place else text.count("\n") + 1 if "end of document" in str(error) else None
        reason = re.sub(r"\s*\(at [^)]*\)", "", str(error)) or "a number that cannot be read"
        if "end of document" in str(error):
            reason = f"the file breaks off ({reason})"
        raise LensFileError(path, line, f"not valid TOML: {reason}") from None


def check_header(data: dict[str, Any], text: str, path: str) -> dict[str, Any]:
    """The header's values in their types. LensFileError: a key that is unknown or whose value cannot be."""
    header: dict[str, Any] = {}
    for key, value in data.items():
        try:
            if key not in KEYS:
                raise RowError(f"{key!r} is unknown; a lens file has {', '.join(sorted(KEYS))}")
            if key == "format" and value != FORMAT:
                raise RowError(f"format {value}: this version of lensbench reads format {FORMAT}")
            if key == "units" and value != "mm":
                raise RowError(f"units {value!r}: lengths must be in \"mm\"")
            if key in TEXTS and not isinstance(value, str):
                raise RowError(f"{key} must be a text in quotes")
            if key == "year" and type(value) is not int:
                raise RowError("year must be a whole number")
            if key in NUMBERS:
                value = number(value, key)
        except RowError as error:
            raise LensFileError(path, line_of(text, key), str(error)) from None
        header[key] = value
    return header


def line_of(text: str, key: str) -> int | None:
    """The line on which a key of the header stands."""
    found = re.search(rf"(?m)^\s*\[*\s*[\"']?{re.escape(key)}\b", text)
    return text.count("\n", 0, found.end()) + 1 if found else None


def _row_line(text: str, row: int) -> int | None:
    """The line of a row, in a file that has one surface a row."""
    first = line_of(text, "surfaces")
    if first is None:
        return None
    lines = text.split("\n")[first:]
    starts = [first + 1 + i for i, line in enumerate(lines) if re.match(r"\s*[^\s#\]]", line)]
    return starts[row] if row < len(starts) else first


def _columns(columns: object, text: str, path: str) -> tuple[str, ...]:
    line = line_of(text, "columns")
    if not isinstance(columns, list) or not all(isinstance(name, str) for name in columns):
        raise LensFileError(path, line, f"`columns` must name the columns of `surfaces`: {', '.join(COLUMNS)}")
    for name in columns:
        if name not in COLUMNS:
            raise LensFileError(path, line, f"column {name!r} is unknown; the columns are {', '.join(COLUMNS)}")
    for name in REQUIRED:
        if columns.count(name) != 1:
            raise LensFileError(path, line, f"there must be one column {name!r}")
    return tuple(columns)


def _surface(row: object, columns: tuple[str, ...]) -> tuple[Surface, bool]:
    """The surface of a row, and whether it is marked as the stop."""
    if not isinstance(row, list):
        raise RowError("a row must be a list in brackets")
    is_stop = len(row) == len(columns) + 1 and row[-1] == "stop"
    if len(row) - is_stop != len(columns):
        raise RowError(f"the row has {len(row)} values, but there are {len(columns)} columns: {', '.join(columns)}")
    values = dict(zip(columns, row, strict=False))
    glass = values.get("glass", "")
    if not isinstance(glass, str):
        raise RowError("the name of a glass must be a text in quotes")
    made = surface(values["radius"], values["thickness"], values["n_d"], values["semi_diameter"],
                   values.get("V_d"), glass)
    return made, is_stop


def write(lens: Lens) -> tuple[str, tuple[str, ...]]:
    """The text of a lens file, and what it could not hold (nothing)."""
    lines = [f"format = {FORMAT}", f"title = {_quoted(lens.name)}", f"kind = {_quoted(lens.kind)}"]
    if lens.year is not None:
        lines.append(f"year = {lens.year}")
    lines.append(f"source = {_quoted(lens.source)}")
    if lens.stated_efl is not None:
        lines.append(f"stated_efl = {_digits(lens.stated_efl)}")
    if lens.stated_f_number is not None:
        lines.append(f"stated_f_number = {_digits(lens.stated_f_number)}")
    for key, value in (("computed_efl", focal_length(lens.surfaces)),
                       ("computed_f_number", f_number(lens.surfaces, lens.stop_index))):
        if isfinite(value):
            lines.append(f"{key} = {_digits(float(f'{value:.6g}'))}")
    if lens.notes:
        lines.append(f"notes = {_quoted(lens.notes)}")
    lines.append('units = "mm"')

    # The columns that some surface fills, aligned as in a printed table
    columns = {
        "radius": [radius_text(s.curvature) for s in lens.surfaces],
        "thickness": [_digits(s.thickness) for s in lens.surfaces],
        "n_d": [_digits(s.glass.n_d) for s in lens.surfaces],
        "V_d": [_digits(s.glass.v_d) if s.glass.v_d else "0" for s in lens.surfaces],
        "semi_diameter": [_digits(s.semi_diameter) for s in lens.surfaces],
        "glass": [_quoted(s.glass.name) for s in lens.surfaces],
    }
    if all(text == "0" for text in columns["V_d"]):
        del columns["V_d"]
    if all(text == '""' for text in columns["glass"]):
        del columns["glass"]
    lines.append(f"columns = [{', '.join(map(_quoted, columns))}]")
    lines.append("surfaces = [")
    widths = [max(map(len, column)) for column in columns.values()]
    for i, row in enumerate(zip(*columns.values(), strict=True)):
        cells = ", ".join(text.rjust(width) for text, width in zip(row, widths, strict=True))
        mark = ', "stop"' if i == lens.stop_index else ""
        lines.append(f"    [{cells}{mark}],")
    return "\n".join([*lines, "]", ""]), ()


def _digits(value: float) -> str:
    return repr(float(value))


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
