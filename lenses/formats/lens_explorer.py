"""Lens Explorer files (.json): a published table of surfaces with its stated figures.

    {"schema": "lens-explorer/0", "name": "…", "units": "mm", "stop_index": 4, "efl_stated": 50.0,
     "source": {"maker": "…", "designer": "…", "patent": "US …", "example": "Example 1", "year": 1960},
     "format": "135-full-frame", "aperture_blades": 9, "semi_diameters": "estimated",
     "surfaces": [{"R": 29.475, "t": 3.76, "nd": 1.67, "vd": 47.1, "semi_ap": 12.6, "geometry": "sphere", "k": 0.0}, …],
     "variable": {"zoom_positions_mm": null, "close_focus_m": 0.35, "f_numbers": [3.5, 4.5],
                  "gaps": [{"surface": 7, "values": [5.0, 27.5]}]}}

Lengths in mm; R null is a plane; t and nd are those after the surface, the last t is the back focus; A holds the
aspheric coefficients by their powers. geometry: sphere, asphere, cyl_x or cyl_y, a cylinder with its power in x or
in y. The values of a varying gap are [infinity, close], or such a pair for each zoom setting; f_numbers has one number
a setting. A lens of which only the last gap varies is focused as a whole. format is the film that the lens was made
for, by name or as [width, height]. semi_diameters says which rims are published.
"""

import re
from collections.abc import Sequence
from dataclasses import replace
from math import inf
from typing import Any

from lensbench.core.optics.finding import Kind
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import ApertureKind, FieldKind
from lensbench.core.text import excerpt, significant
from lensbench.lenses.file_error import RowError, located, number
from lensbench.lenses.glass import media
from lensbench.lenses.tables.design import Design, Row
from lensbench.lenses.tables.rows import curvature
from lensbench.lenses.tables.stations import Station
from lensbench.lenses.tables.text import check_keys, item_lines, items, parse, table, text_value, value

SCHEMA = "lens-explorer"
READ = frozenset({"name", "units", "stop_index", "efl_stated", "fno_stated", "half_fov_deg", "variable", "source",
                  "patent", "year", "type", "projection", "aperture_blades", "format", "semi_diameters", "surfaces"})
READ_OF_SURFACES = frozenset({"R", "t", "nd", "vd", "glass", "geometry", "semi_ap", "k", "A"})
READ_OF_GAPS = frozenset({"zoom_positions_mm", "close_focus_m", "f_numbers", "gaps"})
# Identity, conventions, figures and verdicts of a check
HARMLESS = frozenset({"schema", "id", "conventions", "check", "quality", "quality_notes", "efl_checked", "bfd_checked"})
HARMLESS_OF_SURFACES = frozenset({"label", "stop"})         # stop_index says which surface
GEOMETRIES = ("sphere", "asphere", "cyl_x", "cyl_y")
FEWEST_BLADES = 3                           # of an iris that lensbench draws
FILM_SIZES = {                              # mm, by the names of the files
    "135-full-frame": (36.0, 24.0), "aps-c": (23.5, 15.6), "four-thirds": (17.3, 13.0), "110": (17.0, 13.0),
    "1-inch-type": (13.2, 8.8), "1/1.7-inch-type": (7.6, 5.7), "44x33": (43.8, 32.9), "645": (56.0, 41.5),
    "6x6": (56.0, 56.0), "6x7": (70.0, 56.0), "6x9": (84.0, 56.0), "4x5": (127.0, 101.6), "5x7": (177.8, 127.0),
    "8x10": (254.0, 203.2)}
ESTIMATED_RIMS = {"estimated": "all rims", "published in part": "some rims"}
PATENT = re.compile(r"[A-Z]{2}[ -]?[A-Z]{0,2}[ -]?\d")       # "US 2,645,156", "JP H10-206729 A"


def is_one(text: str) -> bool:
    """Whether a JSON text is a Lens Explorer file."""
    return f'"{SCHEMA}' in text


def read(text: str, path: str) -> Lens:
    """The lens of a file's text. LensFileError names `path`, the line and the mistake."""
    data, lines = parse(text, path), item_lines(text, "surfaces")
    design = Design(path, [Row(None, thickness=inf)], name=text_value(data, "name"))
    with located(path, None):
        check_keys(data, READ | HARMLESS)
        check_keys(table(data, "variable"), READ_OF_GAPS | {"pair_order"}, " of the varying gaps")
    for i, surface in enumerate(items(data.get("surfaces"))):
        with design.row(i, lines) as row:
            _fill(row, table(surface))
    design.add(Row(None))
    with located(path, None):
        units = data.get("units", "mm")
        if not str(units).startswith("mm"):
            design.found(Kind.UNIT, f"the file's unit is {excerpt(units)}: its lengths are assumed to be in mm")
        stop = value(data, "stop_index", -1.0)
        if 0.0 <= stop < len(design.rows) - 2:
            design.rows[int(stop) + 1].is_stop = True
        design.stated_efl = value(data, "efl_stated", 0.0) or None
        design.stated_f_number = value(data, "fno_stated", 0.0) or None
        if design.stated_f_number and any(row.semi_diameter is None for row in design.rows[1:-1]) and not any(
                row.is_stop and row.semi_diameter for row in design.rows):      # a nominal figure; rims are exact
            design.state_aperture(ApertureKind.F_NUMBER, design.stated_f_number)
        field = value(data, "half_fov_deg", 0.0)
        if field:
            design.state_fields(FieldKind.ANGLE, design.field_point(0.0, field))
        design.stations = _stations(design.rows, table(data, "variable"))
        about = _provenance(data, design)
        return replace(design.lens(), **about)


def _provenance(data: dict[str, Any], design: Design) -> dict[str, Any]:
    """Fields of `Lens` that say where the lens comes from and what it was made for. RowError: an invalid value."""
    source = table(data, "source")
    patent = text_value(data, "patent") or text_value(source, "patent")
    example = text_value(source, "example")
    year = value(data, "year", value(source, "year", 0.0))
    estimates = [ESTIMATED_RIMS.get(text_value(data, "semi_diameters"), "")]
    if note := text_value(source, "year_note"):
        estimates.append(f"the year ({note})")
    projection = data.get("projection") or "rectilinear"
    if projection != "rectilinear":
        name = projection.get("kind") if isinstance(projection, dict) else projection
        design.found(Kind.LEFT_OUT, f"its stated projection, {str(name)[:40]}, is left out: the rays give it")
    blades = value(data, "aperture_blades", 0.0)
    if 0.0 < blades < FEWEST_BLADES:
        design.found(Kind.LEFT_OUT, f"a stop of {significant(blades)} blades cannot be drawn: a circle is used instead")
        blades = 0.0
    return {
        "kind": text_value(data, "type").replace("?", ""), "source": ", ".join(filter(None, (patent, example))),
        "year": int(year) or None, "maker": text_value(source, "maker") or text_value(source, "assignee"),
        "designer": text_value(source, "designer"), "patent": patent if PATENT.match(patent) else "",
        "film_size": _film_size(data.get("format"), design), "estimates": ", ".join(filter(None, estimates)),
        "blades": blades}


def _film_size(film: Any, design: Design) -> tuple[float, float] | None:
    """Width and height (mm) of the film that the lens was made for; None if it is not stated or unknown."""
    if isinstance(film, list):
        if len(film) != 2:
            raise RowError("the format must be a name, or a width and a height in mm")
        return number(film[0], "the format's width"), number(film[1], "the format's height")
    size = FILM_SIZES.get(str(film).lower())
    if size is None and film is not None:
        known = ", ".join(FILM_SIZES)
        design.found(Kind.LEFT_OUT, f"its film format {excerpt(film)} is unknown and left out; known are {known}")
    return size


def _fill(row: Row, data: dict[str, Any]) -> None:
    """Fill the row from a surface. RowError: invalid, or not traced."""
    check_keys(data, READ_OF_SURFACES | HARMLESS_OF_SURFACES)
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
    f_numbers = [number(f, "f_numbers") for f in items(data.get("f_numbers"))]
    if f_numbers and len(f_numbers) != max(len(settings), 1):
        raise RowError(f"f_numbers has {len(f_numbers)} values for {max(len(settings), 1)} zoom settings")
    close = 1000.0 * value(data, "close_focus_m", 0.0)
    stations = []
    for zoom in range(max(len(settings), 1)):
        for focus in range(2 if close > 0.0 else 1):
            station = Station({row: _gap(values, zoom if settings else None, focus) for row, values in gaps},
                              focal_length=settings[zoom] if settings else None,
                              f_number=f_numbers[zoom] if f_numbers else None)
            if focus:
                station.distance = close - sum(station.gaps.get(i, rows[i].thickness) for i in range(1, len(rows) - 1))
            stations.append(station)
    return stations


def _gap(values: Sequence[Any], zoom: int | None, focus: int) -> float:
    """One value of a varying gap; RowError if it is missing."""
    along = values if zoom is None else items(values[zoom]) if zoom < len(values) else []
    if focus >= len(along):
        raise RowError("a varying gap has too few values: [infinity, close] for each zoom setting")
    return number(along[focus], "a varying gap")
