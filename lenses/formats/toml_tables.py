"""Tables [system] and [positions], and entries of [coating], of the project's own lens file.

What the lens was designed for; all entries are optional, the kinds are the words of `ApertureKind` and `FieldKind`:

    [system]
    aperture = { kind = "entrance-pupil diameter", values = [23.8] }    # mm; a value for all zoom stations, or one each
    field_kind = "angle"                        # degrees; of heights in object or image: mm
    fields = [{ y = 0.0 }, { y = 14.0, weight = 0.5, vignetting = [0.0, 0.0, 0.1, 0.2] }]   # x too; at +x, −x, +y, −y
    wavelengths = [{ um = 0.4861 }, { um = 0.5876, weight = 2.0 }]
    primary = 1                                 # index of the primary wavelength, from 0
    object_distances = [250.0]                  # mm before the first vertex, inf by default; one, or one a zoom station

Gaps of a lens that zooms, or moves groups to focus (mm):

    [positions]
    zoom_stations = [0.0, 0.38, 1.0]            # 0 wide, 1 tele; by default even in the logarithm of the focal length
    focus_stations = [0.0, 1.0]                 # 0 infinity, 1 the nearest; by default even in 1 / distance
    focal_lengths = [71.4, 105.0, 196.0]        # as stated, one a zoom station; f_numbers and names too
    distances = [[inf, 1500.0], [inf, 1500.0], [inf, 1500.0]]   # of the object from the film
    stops = …                                   # semi-diameter of the stop at each station, where it varies
    zoom = 0.0                                  # current position; close too

    [positions.gaps]                            # behind surface 4: a row for each zoom station,
    4 = [[14.1595, 4.4399], [14.1595, 4.4399], [14.1595, 4.4399]]       # a value for each focus station

Coatings by the number of the surface. A layer is its index and its optical thickness in waves of `wavelength` (µm),
from the side of the smaller index on; "matched" suits the index to the glass:

    [coating]
    0 = "multi-layer"                   # or "single-layer", "uncoated"
    2 = { layers = [[1.38, 0.25], [2.05, 0.5], ["matched", 0.25]], wavelength = 0.55 }
    4 = { wavelengths = [0.45, 0.65], angles_deg = [0.0, 40.0], reflectances = [[0.004, 0.01], [0.003, 0.009]] }
"""

import re
from collections.abc import Callable
from dataclasses import replace
from math import degrees, radians
from typing import Any

from lensbench.core.optics.coatings import COATINGS, Coating, CoatingError, Layer
from lensbench.core.optics.finding import Kind, note
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import (
    Aperture, ApertureKind, FieldKind, FieldPoint, SystemData, SystemDataError, Wavelength
)
from lensbench.core.optics.zoom_positions import Positions, PositionsError
from lensbench.core.text import excerpt, significant
from lensbench.lenses.file_error import RowError, number
from lensbench.lenses.formats.toml_header import digits, listed, quoted
from lensbench.lenses.tables.paraxial import focal_length
from lensbench.lenses.tables.stations import focus_fractions, with_gaps, zoom_fractions

Reader = Callable[[object, str], Any]       # value and its key → the value, checked; RowError
DARK = (0.0, 0.0, 0.0, 0.0)                 # no vignetting
MATCHED = "matched"
LAYERS, SAMPLES = {"layers", "wavelength"}, {"wavelengths", "angles", "angles_deg", "reflectances"}


class TableError(ValueError):
    """An invalid table. key: the key with the mistake, None: the table as a whole."""

    def __init__(self, message: str, key: str | None = None):
        super().__init__(message)
        self.key = key


def _values(table: object, readers: dict[str, Reader], otherwise: str) -> dict[str, Any]:
    """The checked values of a table by key; otherwise: the message for what is no table."""
    if not isinstance(table, dict):
        raise TableError(otherwise)
    values = {}
    for key, value in table.items():
        if key not in readers:
            raise TableError(f"{excerpt(key)} is unknown; there are {', '.join(readers)}", key)
        try:
            values[key] = readers[key](value, key)
        except (RowError, SystemDataError) as error:
            raise TableError(str(error), key) from None
    return values


def _list(value: object, name: str) -> list[Any]:
    if not isinstance(value, list):
        raise RowError(f"{name} must be a list in brackets")
    return value


def _numbers(value: object, name: str) -> tuple[float, ...]:
    return tuple(number(item, name, infinite=True) for item in _list(value, name))


def _texts(value: object, name: str) -> tuple[str, ...]:
    if not all(isinstance(text, str) for text in _list(value, name)):
        raise RowError(f"{name} must be a list of texts in quotes")
    return tuple(_list(value, name))


def _entry(value: object, keys: tuple[str, ...], example: str) -> dict[str, Any]:
    if not isinstance(value, dict) or not value.keys() <= set(keys):
        raise RowError(example)
    return value


# System data

def system_data(table: object) -> SystemData:
    """The system data of a table. TableError: an unknown key or an invalid value."""
    values = _values(table, SYSTEM, "it must be a table: [system]")
    try:
        return SystemData(**values)
    except SystemDataError as error:
        raise TableError(str(error)) from None


def _aperture(value: object, name: str) -> Aperture:
    entry = _entry(value, ("kind", "values"), 'an aperture is written { kind = "f-number", values = [2.0] }')
    kind = ApertureKind(_word(entry.get("kind"), tuple(ApertureKind)))
    return Aperture(kind, _numbers(entry.get("values"), "values"))


def _fields(value: object, name: str) -> tuple[FieldPoint, ...]:
    points = []
    for item in _list(value, name):
        entry = _entry(item, ("x", "y", "weight", "vignetting"), "a field point is written { x = 0.0, y = 14.0 }")
        cuts = _numbers(entry.get("vignetting", list(DARK)), "vignetting")
        if len(cuts) != 4:
            raise RowError("vignetting has four factors: at +x, −x, +y, −y")
        points.append(FieldPoint(number(entry.get("x", 0.0), "x"), number(entry.get("y", 0.0), "y"),
                                 number(entry.get("weight", 1.0), "weight"), (cuts[0], cuts[1], cuts[2], cuts[3])))
    return tuple(points)


def _wavelengths(value: object, name: str) -> tuple[Wavelength, ...]:
    made = []
    for item in _list(value, name):
        entry = _entry(item, ("um", "weight"), "a wavelength is written { um = 0.5876 }")
        made.append(Wavelength(number(entry.get("um"), "um"), number(entry.get("weight", 1.0), "weight")))
    return tuple(made)


def _primary(value: object, name: str) -> int:
    if type(value) is not int:
        raise RowError("primary must be a whole number: the index of a wavelength, from 0")
    return value


def _word(value: object, words: tuple[str, ...]) -> str:
    if not isinstance(value, str) or value not in words:
        raise RowError(f"{excerpt(value)} is none of {', '.join(map(repr, map(str, words)))}")
    return value


SYSTEM: dict[str, Reader] = {
    "aperture": _aperture, "field_kind": lambda value, name: FieldKind(_word(value, tuple(FieldKind))),
    "fields": _fields, "wavelengths": _wavelengths, "primary": _primary, "object_distances": _numbers}


def system_lines(system: SystemData) -> list[str]:
    """Lines of the table; none for a lens without system data."""
    if system == SystemData():
        return []
    written = ["[system]"]
    if system.aperture is not None:
        written.append(f"aperture = {{ kind = {quoted(str(system.aperture.kind))}, "
                       f"values = {listed(system.aperture.values)} }}")
    if system.field_kind is not FieldKind.ANGLE or system.fields:
        written.append(f"field_kind = {quoted(str(system.field_kind))}")
    if system.fields:
        written.append(f"fields = [{', '.join(map(_field_text, system.fields))}]")
    if system.wavelengths:
        waves = [f"{{ um = {digits(w.micrometres)}{'' if w.weight == 1.0 else f', weight = {digits(w.weight)}'} }}"
                 for w in system.wavelengths]
        written.append(f"wavelengths = [{', '.join(waves)}]")
    if system.primary:
        written.append(f"primary = {system.primary}")
    if system.object_distances != SystemData().object_distances:
        written.append(f"object_distances = {listed(system.object_distances)}")
    return written


def _field_text(point: FieldPoint) -> str:
    entries = [f"x = {digits(point.x)}"] if point.x else []
    entries.append(f"y = {digits(point.y)}")
    entries += [f"weight = {digits(point.weight)}"] if point.weight != 1.0 else []
    entries += [f"vignetting = {listed(point.vignetting)}"] if point.vignetting != DARK else []
    return f"{{ {', '.join(entries)} }}"


# Zoom and focus positions

def _row(value: object, name: str) -> tuple[float, ...]:
    if not value:
        raise RowError(f"{name} must be a list of numbers")
    return tuple(number(item, name) for item in _list(value, name))


def _grid(value: object, name: str, infinite: bool = True) -> tuple[tuple[float, ...], ...]:
    """A row for each zoom station, with a number for each focus station."""
    if not isinstance(value, list) or not value or not all(isinstance(row, list) and row for row in value):
        raise RowError(f"{name} must be a list of rows: one for each zoom position, with a number for each focus "
                       "station")
    return tuple(tuple(number(item, name, infinite) for item in row) for row in value)


STATIONS = ("zoom_stations", "focus_stations")
POSITIONS: dict[str, Reader] = {
    "names": _texts, **dict.fromkeys((*STATIONS, "focal_lengths", "f_numbers"), _row),
    **dict.fromkeys(("distances", "stops"), _grid), **dict.fromkeys(("zoom", "close"), number),
    "gaps": lambda value, name: value}


def placed(lens: Lens, table: object) -> Lens:
    """The lens of the file's rows with the positions of its table, at the position that the table states."""
    values = _values(table, POSITIONS, "they must be a table: [positions], with [positions.gaps]")
    columns = _gaps(values.pop("gaps", None), len(lens.surfaces))
    order = sorted(columns)
    thicknesses = tuple(tuple(zip(*row, strict=True)) for row in zip(*(columns[i] for i in order), strict=True))
    values.setdefault("zoom_stations", zoom_fractions([focal_length(with_gaps(lens.surfaces, order, row[0]))
                                                       for row in thicknesses]))
    values.setdefault("focus_stations", focus_fractions((values.get("distances") or [[0.0] * len(thicknesses[0])])[0]))
    try:
        positions = Positions(tuple(order), thicknesses, **values)
        moved = Lens(lens.surfaces, lens.stop_index, positions=positions).at()
    except (PositionsError, LensError) as error:
        raise TableError(str(error)) from None
    off = [(i, lens.surfaces[i].thickness, moved.surfaces[i].thickness) for i in order]
    findings = [note(Kind.POSITION, f"surface {i}: the thickness of its row, {significant(row)} mm, is not that of its "
                                    f"position, {significant(there)} mm, which is used", i)
                for i, row, there in off if row != there]
    return replace(lens, positions=moved.positions, findings=(*lens.findings, *findings)).at()


def _gaps(gaps: object, count: int) -> dict[int, tuple[tuple[float, ...], ...]]:
    """The varying gaps, by the number of the surface before them."""
    if not isinstance(gaps, dict) or not gaps:
        raise TableError("the varying gaps are missing: [positions.gaps], then a line `4 = [[14.1, 4.4], …]` for the "
                         "one behind surface 4", None if gaps is None else "gaps")
    columns: dict[int, tuple[tuple[float, ...], ...]] = {}
    for key, grid in gaps.items():
        if not (re.fullmatch("[0-9]{1,9}", key) and int(key) < count):
            raise TableError(f"there is no surface {excerpt(key)}: they are numbered from 0 to {count - 1}", key)
        if int(key) in columns:
            raise TableError(f"surface {int(key)} is listed twice", key)
        try:
            columns[int(key)] = _grid(grid, key, infinite=False)
        except RowError as error:
            raise TableError(str(error), key) from None
    first = min(columns)
    for i, grid in sorted(columns.items()):
        if list(map(len, grid)) != list(map(len, columns[first])):
            raise TableError(f"the gap behind surface {i} has another number of positions than that behind {first}",
                             str(i))
    return columns


def position_lines(positions: Positions) -> list[str]:
    """Lines of the table in a file."""
    written = ["[positions]"]
    for key, reader in POSITIONS.items():
        value = None if key == "gaps" else getattr(positions, key)
        if value and not (key in STATIONS and value == (0.0,)):
            written.append(f"{key} = " + (f"[{', '.join(map(quoted, value))}]" if reader is _texts
                                          else digits(value) if reader is number else listed(value)))
    written += ["", "[positions.gaps]"]
    for k, i in enumerate(positions.gaps):
        grid = tuple(tuple(gaps[k] for gaps in row) for row in positions.thicknesses)
        written.append(f"{i} = {listed(grid)}")
    return written


# Coatings

def coating(value: object) -> Coating:
    """A coating from its entry; RowError: what is wrong."""
    if isinstance(value, str):
        if value not in COATINGS:
            raise RowError(f"{excerpt(value)} is no coating: it is one of {', '.join(COATINGS)}, or layers, or a table")
        return COATINGS[value]
    if not isinstance(value, dict) or not (value.keys() <= LAYERS or value.keys() <= SAMPLES) or not value:
        raise RowError("a coating is a name, or { layers = [[1.38, 0.25]], wavelength = 0.55 }, or { wavelengths = "
                       "[…], angles_deg = […], reflectances = [[…], …] }")
    try:
        if value.keys() <= LAYERS:
            made = Coating(tuple(map(_layer, _list(value.get("layers", []), "layers"))))
            return Coating(made.layers, number(value["wavelength"], "wavelength")) if "wavelength" in value else made
        if "angles" in value and "angles_deg" in value:
            raise RowError("give the angles in radians or in degrees, not both")
        angles = _finite(value["angles"], "angles") if "angles" in value else tuple(
            map(radians, _finite(value.get("angles_deg", [0.0]), "angles_deg")))
        return Coating(wavelengths=_finite(value.get("wavelengths"), "wavelengths"), angles=angles,
                       reflectances=tuple(_finite(row, "reflectances")
                                          for row in _list(value.get("reflectances"), "reflectances")))
    except CoatingError as error:
        raise RowError(str(error).removeprefix("coating: ")) from None


def _finite(value: object, name: str) -> tuple[float, ...]:
    return tuple(number(item, name) for item in _list(value, name))


def _layer(value: object) -> Layer:
    if not isinstance(value, list) or len(value) != 2:
        raise RowError("a layer is its index and its thickness in waves: [1.38, 0.25]")
    return Layer(None if value[0] == MATCHED else number(value[0], "index"), number(value[1], "thickness"))


def coating_entry(coating: Coating) -> str:
    """The entry of a coating, that reads back equal."""
    for name, known in COATINGS.items():
        if coating == known:
            return quoted(name)
    if coating.wavelengths:
        rows = ", ".join(map(listed, coating.reflectances))
        exact = all(radians(degrees(angle)) == angle for angle in coating.angles)
        angles = (f"angles_deg = {listed(map(degrees, coating.angles))}" if exact else
                  f"angles = {listed(coating.angles)}")
        return f"{{ wavelengths = {listed(coating.wavelengths)}, {angles}, reflectances = [{rows}] }}"
    layers = ", ".join(f"[{quoted(MATCHED) if index is None else digits(index)}, {digits(waves)}]"
                       for index, waves in coating.layers)
    return f"{{ layers = [{layers}], wavelength = {digits(coating.wavelength)} }}"
