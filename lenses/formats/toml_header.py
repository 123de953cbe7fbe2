"""Header of the project's own lens file: what is known of a lens beside its surfaces.

    format = 1
    title = "CARL ZEISS SONNAR T* 150mm f/4"
    kind = "Sonnar"
    maker = "Carl Zeiss"
    designer = "…"
    year = 1957
    patent = "US 2,831,395"
    source = "…"
    film_size = [56.0, 56.0]        # width and height (mm) of the film or sensor that it was made for
    estimates = "all rims"          # what of the prescription is not published
    stated_efl = 150.0
    stated_f_number = 4.0
    computed_efl = 150.02           # the `computed_` figures and `counts` are for lists, and not read into the lens
    computed_f_number = 4.003
    counts = { surfaces = 10, elements = 5, groups = 3, aspheres = 0, focus_groups = 0 }
    units = "mm"

Every key but `format` may be left out. This module imports no tracer, so that a list of headers is quick.

Numbers, texts and lists in TOML; a float has enough digits to read back equal.
"""

import json
import re
import tomllib
from collections.abc import Mapping
from dataclasses import asdict
from decimal import Decimal
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

from lensbench.core.text import excerpt
from lensbench.lenses.file_error import LensFileError, RowError, number

if TYPE_CHECKING:
    from lensbench.core.optics.prescription import Lens


def listed(values: Any) -> str:
    """A TOML list of numbers, or of tuples of numbers."""
    return f"[{', '.join(listed(v) if isinstance(v, tuple) else digits(v) for v in values)}]"


def digits(value: float) -> str:
    """A number with all its digits."""
    return repr(float(value))


def quoted(text: str) -> str:
    """A text in quotes."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


FORMAT = 1
FIELDS = {"title": "name", "kind": "kind", "maker": "maker", "designer": "designer", "year": "year",
          "patent": "patent", "source": "source", "film_size": "film_size", "estimates": "estimates",
          "stated_efl": "stated_efl", "stated_f_number": "stated_f_number", "notes": "notes"}    # of `Lens`, by key
ALWAYS = ("title", "kind", "source")        # written even where empty
TEXTS = ("title", "kind", "source", "notes", "maker", "designer", "patent", "estimates")
NUMBERS = ("stated_efl", "stated_f_number", "computed_efl", "computed_tele_efl", "computed_f_number", "image_circle",
           "front_index")
COUNTS = ("surfaces", "elements", "groups", "aspheres", "focus_groups")
REST = ("columns", "surfaces", "stop", "system", "positions", "aspheric", "radius_x", "pose", "dispersion",
        "coating", "comments", "solves", "pickups")
KEYS = ("format", "units", "year", "film_size", "counts", *REST, *TEXTS, *NUMBERS)


def parse(text: str, path: str) -> dict[str, Any]:
    """Keys of the file; numbers with a point as Decimal."""
    try:
        return tomllib.loads(text, parse_float=Decimal)
    except RecursionError:
        raise LensFileError(path, None, "its brackets are nested too deep") from None
    except (ValueError, ArithmeticError) as error:
        match = re.search(r"\(at line (\d+), column \d+\)", str(error))
        line = int(match[1]) if match else text.count("\n") + 1 if "end of document" in str(error) else None
        reason = re.sub(r"\s*\(at [^)]*\)", "", str(error)) or "a number that cannot be read"
        if "end of document" in str(error):
            reason = f"the file breaks off ({reason})"
        raise LensFileError(path, line, f"not valid TOML: {reason}") from None


def of_file(text: str, path: str) -> dict[str, Any]:
    """The checked header of a file's text, without a look at its surfaces; LensFileError for a mistake in it."""
    head = text.partition("\ncolumns")[0]
    return checked(parse(head, path), head, path)


def checked(data: dict[str, Any], text: str, path: str) -> dict[str, Any]:
    """Check the types of the header's values. LensFileError: an unknown key or an invalid value."""
    header: dict[str, Any] = {}
    for key, value in data.items():
        try:
            if key not in KEYS:
                raise RowError(f"{excerpt(key)} is unknown; a lens file has {', '.join(sorted(KEYS))}")
            if key == "format" and value != FORMAT:
                raise RowError(f"format {value}: this version of lensbench reads format {FORMAT}")
            if key == "units" and value != "mm":
                raise RowError(f"units {excerpt(value)}: lengths must be in \"mm\"")
            if key in TEXTS and not isinstance(value, str):
                raise RowError(f"{key} must be a text in quotes")
            if key == "year" and type(value) is not int:
                raise RowError("year must be a whole number")
            if key in NUMBERS:
                value = number(value, key)
            elif key == "film_size":
                value = _film_size(value)
            elif key == "counts":
                _check_counts(value)
        except RowError as error:
            raise LensFileError(path, line_of(text, key), str(error)) from None
        header[key] = value
    return header


def _film_size(value: object) -> tuple[float, float]:
    if not (isinstance(value, list) and len(value) == 2):
        raise RowError("film_size must be a width and a height in mm: [36.0, 24.0]")
    width, height = (number(side, "film_size") for side in value)
    if not (width > 0.0 and height > 0.0):
        raise RowError("film_size: width and height must be positive")
    return width, height


def _check_counts(value: object) -> None:
    if not (isinstance(value, dict) and value.keys() <= set(COUNTS)
            and all(type(count) is int and count >= 0 for count in value.values())):
        raise RowError(f"counts must be a table of whole numbers: {', '.join(COUNTS)}")


def fields(header: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of `Lens` from a checked header, without those of the tables."""
    return {name: header[key] for key, name in FIELDS.items() if key in header}


def line_of(text: str, key: str) -> int | None:
    """Line of a key of the header."""
    match = re.search(rf"(?m)^\s*\[*\s*[\"']?{re.escape(key)}\b", text)
    return text.count("\n", 0, match.end()) + 1 if match else None


def lines(lens: "Lens") -> list[str]:
    """Lines of the header of a lens."""
    from lensbench.lenses.tables.counts import counts
    from lensbench.lenses.tables.paraxial import f_number, focal_length

    written = [f"format = {FORMAT}"]
    for key, name in FIELDS.items():
        value = getattr(lens, name)
        if (value is not None and value != "") or key in ALWAYS:
            written.append(f"{key} = {_text(value)}")
    notes = written.pop() if lens.notes else None
    wavelength = lens.reference_wavelength
    n = lens.front_index
    tele = focal_length(lens.at(zoom=1.0).surfaces, wavelength, n) if lens.zooms else inf
    for key, value in (("computed_efl", focal_length(lens.surfaces, wavelength, n)), ("computed_tele_efl", tele),
                       ("computed_f_number", f_number(lens.with_round_stop.surfaces, lens.stop_index, wavelength, n))):
        if isfinite(value):
            written.append(f"{key} = {digits(float(f'{value:.6g}'))}")
    written.append(f"counts = {{ {', '.join(f'{key} = {count}' for key, count in asdict(counts(lens)).items())} }}")
    if lens.front_index != 1.0:
        written.append(f"front_index = {digits(lens.front_index)}")
    if notes:
        written.append(notes)
    return [*written, 'units = "mm"']


def _text(value: Any) -> str:
    """A value of the header in TOML."""
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, tuple):
        return listed(value)
    return str(value) if isinstance(value, int) else digits(value)
