"""System data in words: rows for `lensbench info` and the lens card."""

from collections.abc import Sequence
from math import isinf

from lensbench.kernels.figures import significant
from lensbench.optics.system import LENGTHS, ApertureKind, FieldKind, FieldPoint, SystemData

MOST = 7                # numbers of a row; of more, the ends are given


def system_rows(system: SystemData) -> list[tuple[str, str]]:
    """Labels and texts of the stated aperture, fields, wavelengths and object distance.

    Parameters
    ----------
    system : SystemData
        Of a lens in mm.

    Returns
    -------
    list of tuple of str
        A row for each part that is stated; an object at infinity has none.
    """
    rows = []
    if system.aperture is not None:
        kind, values = system.aperture.kind, system.aperture.values
        size = f"{_several(values)}{' mm' if kind in LENGTHS else ''}"
        rows.append(("Designed aperture", "that of the stop" if kind is ApertureKind.STOP_SIZE and not any(values)
                     else f"{kind} {size}"))
    if system.fields:
        rows.append(("Designed fields", _fields(system)))
    if system.wavelengths:
        waves = [1000.0 * wave.micrometres for wave in system.wavelengths]
        primary = f", the primary one {significant(waves[system.primary])} nm" if len(waves) > 1 else ""
        rows.append(("Designed wavelengths", f"{_several(waves)} nm{primary}"
                                             f"{_weights([wave.weight for wave in system.wavelengths])}"))
    if not all(map(isinf, system.object_distances)):
        rows.append(("Designed object", f"{_several(system.object_distances)} mm before the first vertex"))
    return rows


def _fields(system: SystemData) -> str:
    """The kind of the fields, their places, weights, and whether they are vignetted."""
    fields = system.fields
    unit = "°" if system.field_kind is FieldKind.ANGLE else " mm"
    words = f"{system.field_kind} {_places(fields)}{unit}{_weights([point.weight for point in fields])}"
    return words + (", with vignetting factors" if any(any(point.vignetting) for point in fields) else "")


def _places(fields: Sequence[FieldPoint]) -> str:
    if not any(point.x for point in fields):
        return _several([point.y for point in fields])
    if len(fields) > MOST:
        return f"of {len(fields)} points"
    return ", ".join(f"({significant(point.x)}, {significant(point.y)})" for point in fields)


def _weights(weights: Sequence[float]) -> str:
    """Weights that differ; "" for equal ones."""
    return f", weights {_several(weights)}" if len(set(weights)) > 1 and len(weights) <= MOST else ""


def _several(values: Sequence[float]) -> str:
    """Numbers in a row; of many, how many there are and their ends."""
    if len(values) > MOST:
        return f"{len(values)} from {significant(min(values))} to {significant(max(values))}"
    return ", ".join(significant(value) for value in values)
