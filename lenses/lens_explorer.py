"""Lens Explorer files (.json): a published table of surfaces with its stated figures.

    {"schema": "lens-explorer/0", "name": "…", "units": "mm", "stop_index": 4, "efl_stated": 50.0,
     "surfaces": [{"R": 29.475, "t": 3.76, "nd": 1.67, "vd": 47.1, "semi_ap": 12.6, "geometry": "sphere", "k": 0.0}, …],
     "variable": {"zoom_positions_mm": null, "close_focus_m": 0.35, "gaps": [{"surface": 7, "values": [5.0, 27.5]}]}}

Lengths in mm; R null is a plane; t and nd are those after the surface, the last t is the back focus; A holds the
aspheric coefficients by their powers. geometry: sphere, asphere, cyl_x or cyl_y, a cylinder with its power in x or
in y. The values of a varying gap are [infinity, close], or such a pair for each zoom setting. A lens of which
only the last gap varies is focused as a whole.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import inf
from typing import Any

from lensbench.lenses import media
from lensbench.lenses.design import Design, Row
from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.json_text import item_lines, items, parse, table, text_value, value
from lensbench.lenses.rows import RowError, curvature, number
from lensbench.lenses.stations import Station
from lensbench.optics.finding import Kind
from lensbench.optics.prescription import Lens

SCHEMA = "lens-explorer"
GEOMETRIES = ("sphere", "asphere", "cyl_x", "cyl_y")


def is_one(text: str) -> bool:
    """Whether a JSON text is a Lens Explorer file."""
    return f'"{SCHEMA}' in text


def read(text: str, path: str) -> Lens:
    """The lens of a file's text. LensFileError names `path`, the line and the mistake."""
    data, lines = parse(text, path), item_lines(text, "surfaces")
    design = Design(path, [Row(None, thickness=inf)], name=text_value(data, "name"))
    for i, surface in enumerate(items(data.get("surfaces"))):
        row = Row(lines[i] if i < len(lines) else None)
        try:
            _fill(row, table(surface))
        except (RowError, ArithmeticError) as error:
            raise LensFileError(path, row.line, f"surface {i}: {error}") from None
        design.add(row)
    design.add(Row(None))
    try:
        units = data.get("units", "mm")
        if not str(units).startswith("mm"):
            design.found(Kind.UNIT, f"the file's unit is {str(units)[:40]!r}: its lengths are taken as mm")
        stop = value(data, "stop_index", -1.0)
        if 0.0 <= stop < len(design.rows) - 2:
            design.rows[int(stop) + 1].is_stop = True
        design.stated_efl = value(data, "efl_stated", 0.0) or None
        design.stated_f_number = value(data, "fno_stated", 0.0) or None
        if design.stated_f_number and any(row.semi_diameter is None for row in design.rows[1:-1]):
            design.aperture = ("FNO", design.stated_f_number)
        field = value(data, "half_fov_deg", 0.0)
        design.field_of_view = ("angle", field) if field else None
        design.stations = _stations(design.rows, table(data, "variable"))
    except (RowError, ArithmeticError) as error:
        raise LensFileError(path, None, str(error)) from None
    return replace(design.lens(), kind=text_value(data, "type").replace("?", ""), source=text_value(data, "patent"))


def _fill(row: Row, data: dict[str, Any]) -> None:
    """Fill the row from a surface. RowError: invalid, or not traced."""
    c = 0.0 if data.get("R") is None else curvature(data["R"])
    kind = data.get("geometry", "sphere")
    if kind not in GEOMETRIES:
        raise RowError(f"the geometry {kind} is not traced: it must be one of {', '.join(GEOMETRIES)}")
    row.curvature, row.curvature_x = {"cyl_x": (0.0, c), "cyl_y": (c, 0.0)}.get(kind, (c, None))
    row.thickness, row.conic = value(data, "t"), value(data, "k", 0.0)
    row.semi_diameter = value(data, "semi_ap", 0.0) or None
    row.glass = media.model(value(data, "nd"), value(data, "vd", 0.0), text_value(data, "glass"))
    row.aspheric = {int(number(power, "a power in A")): number(a, f"A {power}")
                    for power, a in table(data, "A").items()}


def _stations(rows: list[Row], data: dict[str, Any]) -> list[Station]:
    """Positions of the groups: each zoom setting at infinity and close; empty if the whole lens moves."""
    gaps = [(int(value(table(gap), "surface")) + 1, items(table(gap).get("values"))) for gap in items(data.get("gaps"))]
    if not gaps or [row for row, _ in gaps] == [len(rows) - 2]:
        return []
    settings = [number(f, "zoom_positions_mm") for f in items(data.get("zoom_positions_mm"))]
    close = 1000.0 * value(data, "close_focus_m", 0.0)
    found = []
    for zoom in range(max(len(settings), 1)):
        for focus in range(2 if close > 0.0 else 1):
            station = Station({row: _gap(values, zoom if settings else None, focus) for row, values in gaps},
                              focal_length=settings[zoom] if settings else None)
            if focus:
                station.distance = close - sum(station.gaps.get(i, rows[i].thickness) for i in range(1, len(rows) - 1))
            found.append(station)
    return found


def _gap(values: Sequence[Any], zoom: int | None, focus: int) -> float:
    """One value of a varying gap; RowError if it is missing."""
    along = values if zoom is None else items(values[zoom]) if zoom < len(values) else []
    if focus >= len(along):
        raise RowError("a varying gap has too few values: [infinity, close] for each zoom setting")
    return number(along[focus], "a varying gap")
