"""System data in words, and as a writer of lens files states them.

A design program needs an aperture, a field and a wavelength. Where the lens states none, a writer takes the diameter of
the entrance pupil that the stop gives, the paraxial image heights 0, 0.7 and 1 of its film's half-diagonal (of a lens
without a film or a focal length a point on the axis), and the lines F, d and C.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from math import hypot, isinf

from lensbench.core.optics.finding import Finding, Kind, Severity, note
from lensbench.core.optics.glass import C_LINE, D_LINE, F_LINE
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import LENGTHS, Aperture, ApertureKind, FieldKind, FieldPoint, SystemData, Wavelength
from lensbench.core.text import significant
from lensbench.lenses.tables.aperture import SAME, f_number_kind, pupil_diameter, stop_radius
from lensbench.lenses.tables.paraxial import ray, reference_wavelength
from lensbench.lenses.tables.stations import Station, one_if_equal, placed

MOST = 7                # numbers of a row; of more, the ends are given


def system_rows(system: SystemData) -> list[tuple[str, str]]:
    """Labels and texts of the stated aperture, fields, wavelengths and finite object distance of a lens in mm."""
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


AXIS = (FieldPoint(0.0, 0.0),)
PARTS = (0.0, 0.7, 1.0)                   # of the film's half-diagonal
LEAST_PUPIL, MOST_PUPIL = 1e-12, 1e12     # mm: a larger one is that of a telecentric lens, but for rounding
LINES = (Wavelength(F_LINE), Wavelength(D_LINE), Wavelength(C_LINE))
Holds = Callable[[ApertureKind, float], bool]       # kind of aperture, object distance → whether the format states it


@dataclass(frozen=True)
class WrittenSystem:
    """System data with at least one field and one wavelength; apertures: one value, or one a configuration.

    aperture is None if the stop has no entrance pupil and the format no other way to state its size.
    """

    data: SystemData
    aperture: Aperture | None
    findings: tuple[Finding, ...]


def with_working_f_number(kinds: Iterable[ApertureKind]) -> Holds:
    """What a format holds that states apertures of these kinds, and of f-numbers the one at work."""
    others = frozenset(kinds) - {ApertureKind.F_NUMBER}

    def holds(kind: ApertureKind, distance: float) -> bool:
        return kind is f_number_kind(distance) or kind in others

    return holds


def written_system(lens: Lens, stations: Sequence[Station], holds: Holds) -> WrittenSystem:
    """System data of a lens (mm) for a format, at the position or in the configurations in which it is written.

    holds: whether the format states a kind of aperture for an object at a distance (mm). Findings state where the
    aperture is written in another way than the lens has it.
    """
    data = lens.system
    if not data.wavelengths:
        data = replace(data, wavelengths=LINES, primary=1)
    findings: list[Finding] = []
    if not data.fields:
        data = _with_fields(lens, data, findings)
    wavelength = reference_wavelength(lens.surfaces, data)
    positions, stated = lens.positions, data.aperture
    zooms = 1 if positions is None else len(positions.zoom_stations)
    now = 0
    if positions is not None and not stations:
        now = positions.zoom_stations.index(positions.zoom) if positions.zoom in positions.zoom_stations else -1
    cases = [(placed(lens.surfaces, station), station.stop or lens.stop.semi_diameter, station.distance)
             for station in stations or [Station({}, data.object_distances[max(now, 0) % len(data.object_distances)])]]
    data = replace(data, object_distances=(cases[0][2],))
    if stated is not None:
        values = stated.values if len(stated.values) == zooms else stated.values[:1] * zooms
        asked = [values[(now if not stations else k) % zooms] for k in range(len(cases))]
        is_held = all(holds(stated.kind, distance) for _, _, distance in cases)
        if now >= 0 and is_held and all(_agrees(case, lens.stop_index, stated.kind, value, wavelength)
                                        for case, value in zip(cases, asked, strict=True)):
            return WrittenSystem(data, replace(stated, values=one_if_equal(asked)), tuple(findings))
    diameters = [pupil_diameter(surfaces, lens.stop_index, radius, wavelength) for surfaces, radius, _ in cases]
    has_pupil = all(LEAST_PUPIL < diameter < MOST_PUPIL for diameter in diameters)
    if stated is not None:
        why = "it cannot be stated here" if not is_held else "the stop has another size"
        instead = f"entrance-pupil diameter {significant(diameters[0], 6)} mm" if has_pupil else "size of the stop"
        findings.append(note(Kind.STOP, f"the {stated.kind} {significant(stated.values[0], 6)} is left out, as {why}: "
                                        f"the {instead} is written"))
    if has_pupil:
        return WrittenSystem(data, Aperture(ApertureKind.PUPIL_DIAMETER, one_if_equal(diameters)), tuple(findings))
    if holds(ApertureKind.STOP_SIZE, cases[0][2]):
        return WrittenSystem(data, Aperture(ApertureKind.STOP_SIZE, (0.0,)), tuple(findings))
    findings = [finding for finding in findings if finding.kind is not Kind.STOP]
    findings.append(Finding(Kind.STOP, lens.stop_index, "its entrance pupil lies at infinity: no aperture is written",
                            severity=Severity.WARNING))
    return WrittenSystem(data, None, tuple(findings))


def _with_fields(lens: Lens, data: SystemData, findings: list[Finding]) -> SystemData:
    """The system data with fields; a finding about those of the film is added to `findings`."""
    _, slope = ray(lens.surfaces, wavelength=reference_wavelength(lens.surfaces, data), front_index=lens.front_index)
    if lens.film_size is None or not slope:
        return replace(data, fields=AXIS)
    half = 0.5 * hypot(*lens.film_size)
    findings.append(note(Kind.ASSUMED, "the lens states no fields: the image heights 0, 0.7 and 1 of its film's "
                                       f"half-diagonal, {significant(half, 4)} mm, are written", radius=half))
    return replace(data, field_kind=FieldKind.IMAGE_HEIGHT,
                   fields=tuple(FieldPoint(0.0, share * half) for share in PARTS))


def _agrees(case: tuple[Sequence[Surface], float, float], stop: int, kind: ApertureKind, value: float,
            wavelength: float) -> bool:
    """Whether the stop of a configuration is the one that an aperture asks for."""
    surfaces, radius, distance = case
    if kind is ApertureKind.STOP_SIZE and not value:
        return True
    asked = stop_radius(surfaces, stop, kind, value, distance, wavelength)
    return asked is not None and abs(asked - radius) <= SAME * radius
