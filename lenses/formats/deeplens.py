"""DeepLens files (.json): surfaces with their curvature, rim and the media on both sides.

    {"info": "…", "foclen": 50.0, "fnum": 1.8, "r_sensor": 21.6, "d_sensor": 80.0, "sensor_size": [36.0, 24.0],
     "surfaces": [{"type": "Spheric", "r": 16.5, "c": 0.0284, "roc": 35.2, "d": 0.0, "d_next": 1.57,
                   "mat1": "air", "mat2": "1.51633/64.1"},
                  {"type": "Aperture", "r": 8.7, "d": 30.99, "d_next": 3.4}, …]}

Lengths in mm. r is the rim, roc the radius, or c its reciprocal; mat2 is the medium behind: a name, or n_d/V_d. d_next
is the gap behind, else it follows from the places d and from d_sensor. An Aspheric has the conic k and ai, the
coefficients of r², r⁴, r⁶ …, from r⁴ where use_ai2 is false; ai2, ai4 … repeat them. Names in brackets repeat others.
"""

import re
from dataclasses import replace
from math import inf
from typing import Any

from lensbench.core.optics.finding import Kind, Severity
from lensbench.core.optics.glass import AIR, Glass
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import cut
from lensbench.lenses.file_error import RowError, located, number
from lensbench.lenses.glass import media
from lensbench.lenses.tables.design import Design, Row
from lensbench.lenses.tables.rows import curvature
from lensbench.lenses.tables.text import check_keys, flag, item_lines, items, parse, table, text_value, value

READ = frozenset({"info", "foclen", "fnum", "d_sensor", "sensor_size", "surfaces"})
READ_OF_SURFACES = frozenset({"type", "r", "c", "roc", "d", "d_next", "mat1", "mat2", "k", "ai", "use_ai2",
                              "is_square"})
# Half the diagonal of the sensor, rim of the last surface, pixels; numbers, sides of squares, a flag of wave optics
HARMLESS = frozenset({"r_sensor", "r_last", "sensor_res"})
HARMLESS_OF_SURFACES = frozenset({"idx", "l", "diffraction"})
UNMOVED = {"pos_xy": [0, 0], "vec_local": [0, 0, 1]}       # decentre and direction of a surface on the axis
TERM = re.compile(r"ai([1-9]\d?)")                         # a coefficient by its power, which repeats the list ai
AIRS = ("air", "vacuum", "occluder")
STOPS, SHAPES = ("Aperture", "Stop"), ("Spheric", "Aspheric", "Plane")
MODEL = re.compile(r"([\d.]+)/([\d.]+)")


def is_one(text: str) -> bool:
    """Whether a JSON text is a DeepLens file."""
    return '"d_sensor"' in text or '"mat2"' in text


def read(text: str, path: str) -> Lens:
    """The lens of a file's text. LensFileError names `path`, the line and the mistake."""
    data, lines = parse(text, path), item_lines(text, "surfaces")
    with located(path, None):
        if data.get("DOE"):
            raise RowError("a diffractive element (DOE) is not traced")
        check_keys(data, READ | HARMLESS | {key for key in data if key[:1] == "("})
    surfaces = [table(surface) for surface in items(data.get("surfaces"))]
    design = Design(path, [Row(None, thickness=inf)], name=text_value(data, "info"))
    for i, surface in enumerate(surfaces):
        with design.row(i, lines) as row:
            _fill(design, row, surface, i)
            if "d_next" in surface:
                row.thickness = value(surface, "d_next")
            else:
                behind = value(surfaces[i + 1], "d") if i + 1 < len(surfaces) else value(data, "d_sensor")
                row.thickness = behind - value(surface, "d")
    design.add(Row(None))
    before = text_value(surfaces[0], "mat1") if surfaces else ""
    if before and before.lower() not in AIRS:
        design.found(Kind.LEFT_OUT, f"the medium {cut(before)} in front of the lens (mat1) is left out, air is assumed",
                     0, severity=Severity.WARNING)
    with located(path, None):
        design.stated_efl = value(data, "foclen", 0.0) or None
        design.stated_f_number = value(data, "fnum", 0.0) or None
        sides = [number(side, "sensor_size") for side in items(data.get("sensor_size"))]
        return replace(design.lens(), film_size=(sides[0], sides[1]) if len(sides) == 2 else None)


def _fill(design: Design, row: Row, data: dict[str, Any], index: int) -> None:
    """Fill the row from a surface. RowError: invalid, or not traced."""
    kind = text_value(data, "type")
    if kind not in (*STOPS, *SHAPES):
        raise RowError(f"the type {kind[:30] or 'is missing, or'} is not traced: it must be one of "
                       f"{', '.join((*STOPS, *SHAPES))}")
    check_keys(data, READ_OF_SURFACES | HARMLESS_OF_SURFACES | {
        key for key, entry in data.items() if key[:1] == "(" or TERM.fullmatch(key) or UNMOVED.get(key) == entry})
    row.is_stop = kind in STOPS
    row.semi_diameter = value(data, "r")
    if flag(data, "is_square"):
        design.found(Kind.LEFT_OUT, f"surface {index}: its square edge is left out, a circle is used", index)
    row.glass = _medium(design, data) if "mat2" in data or not row.is_stop else design.rows[-1].glass
    if kind in ("Spheric", "Aspheric"):
        row.curvature = curvature(data["roc"]) if data.get("roc") is not None else value(data, "c")
    if kind == "Aspheric":
        row.conic = value(data, "k", 0.0)
        first = 4 if "use_ai2" in data and not flag(data, "use_ai2") else 2
        terms = {first + 2 * i: number(a, f"ai[{i}]") for i, a in enumerate(items(data.get("ai")))} or {
            int(entry[1]): number(a, key) for key, a in data.items() if (entry := TERM.fullmatch(key))}
        row.aspheric = {power: a for power, a in terms.items() if a}
        if max(row.aspheric, default=0) > 20:
            raise RowError(f"a term in r^{max(row.aspheric)} is not traced: powers go to 20")


def _medium(design: Design, data: dict[str, Any]) -> Glass:
    """The medium behind a surface."""
    name = text_value(data, "mat2")
    if not name:
        raise RowError("mat2, the medium behind it, is missing")
    if numbers := MODEL.fullmatch(name):
        return media.model(number(numbers[1], "n_d"), number(numbers[2], "V_d"))
    if name.lower() in AIRS:
        return AIR
    return media.glass_in(design, name)
