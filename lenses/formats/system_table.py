"""The table [system] of the project's own lens file: what the lens was designed for.

    [system]
    aperture = { kind = "entrance-pupil diameter", values = [23.8] }    # mm; a value for all zoom stations, or one each
    field_kind = "angle"                        # degrees; of heights in object or image: mm
    fields = [{ y = 0.0 }, { y = 14.0, weight = 0.5, vignetting = [0.0, 0.0, 0.1, 0.2] }]   # x too; at +x, −x, +y, −y
    wavelengths = [{ um = 0.4861 }, { um = 0.5876, weight = 2.0 }]
    primary = 1                                 # index of the primary wavelength, from 0
    object_distances = [250.0]                  # mm before the first vertex, inf by default; one, or one a zoom station

All entries are optional. The kinds are the words of `ApertureKind` and `FieldKind`.
"""

from typing import Any

from lensbench.core.optics.system import (
    Aperture, ApertureKind, FieldKind, FieldPoint, SystemData, SystemDataError, Wavelength
)
from lensbench.core.text import excerpt
from lensbench.lenses.file_error import RowError, number
from lensbench.lenses.formats.position_table import TableError
from lensbench.lenses.formats.toml_header import digits, listed, quoted

KEYS = ("aperture", "field_kind", "fields", "wavelengths", "primary", "object_distances")
DARK = (0.0, 0.0, 0.0, 0.0)         # no vignetting


def read(table: object) -> SystemData:
    """The system data of a table. TableError: an unknown key or an invalid value."""
    if not isinstance(table, dict):
        raise TableError("it must be a table: [system]")
    for key in table:
        if key not in KEYS:
            raise TableError(f"{excerpt(key)} is unknown; there are {', '.join(KEYS)}", key)
    values: dict[str, Any] = {}
    for key, value in table.items():
        try:
            values[key] = READERS[key](value)
        except (RowError, SystemDataError) as error:
            raise TableError(str(error), key) from None
    try:
        return SystemData(**values)
    except SystemDataError as error:
        raise TableError(str(error)) from None


def _aperture(value: object) -> Aperture:
    entry = _entry(value, ("kind", "values"), 'an aperture is written { kind = "f-number", values = [2.0] }')
    return Aperture(ApertureKind(_word(entry.get("kind"), tuple(ApertureKind))), _numbers(entry.get("values")))


def _fields(value: object) -> tuple[FieldPoint, ...]:
    points = []
    for item in _list(value):
        entry = _entry(item, ("x", "y", "weight", "vignetting"), "a field point is written { x = 0.0, y = 14.0 }")
        cuts = _numbers(entry.get("vignetting", list(DARK)))
        if len(cuts) != 4:
            raise RowError("vignetting has four factors: at +x, −x, +y, −y")
        points.append(FieldPoint(number(entry.get("x", 0.0), "x"), number(entry.get("y", 0.0), "y"),
                                 number(entry.get("weight", 1.0), "weight"), (cuts[0], cuts[1], cuts[2], cuts[3])))
    return tuple(points)


def _wavelengths(value: object) -> tuple[Wavelength, ...]:
    made = []
    for item in _list(value):
        entry = _entry(item, ("um", "weight"), "a wavelength is written { um = 0.5876 }")
        made.append(Wavelength(number(entry.get("um"), "um"), number(entry.get("weight", 1.0), "weight")))
    return tuple(made)


def _primary(value: object) -> int:
    if type(value) is not int:
        raise RowError("primary must be a whole number: the index of a wavelength, from 0")
    return value


def _entry(value: object, keys: tuple[str, ...], example: str) -> dict[str, Any]:
    if not isinstance(value, dict) or not value.keys() <= set(keys):
        raise RowError(example)
    return value


def _list(value: object) -> list[Any]:
    if not isinstance(value, list):
        raise RowError("it must be a list in brackets")
    return value


def _numbers(value: object) -> tuple[float, ...]:
    return tuple(number(item, "a value", infinite=True) for item in _list(value))


def _word(value: object, words: tuple[str, ...]) -> str:
    if not isinstance(value, str) or value not in words:
        raise RowError(f"{excerpt(value)} is none of {', '.join(map(repr, map(str, words)))}")
    return value


READERS = {"aperture": _aperture, "field_kind": lambda value: FieldKind(_word(value, tuple(FieldKind))),
           "fields": _fields, "wavelengths": _wavelengths, "primary": _primary, "object_distances": _numbers}


def lines(system: SystemData) -> list[str]:
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
    parts = [f"x = {digits(point.x)}"] if point.x else []
    parts.append(f"y = {digits(point.y)}")
    parts += [f"weight = {digits(point.weight)}"] if point.weight != 1.0 else []
    parts += [f"vignetting = {listed(point.vignetting)}"] if point.vignetting != DARK else []
    return f"{{ {', '.join(parts)} }}"
