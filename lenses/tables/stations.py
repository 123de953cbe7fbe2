"""Zoom and focus positions: conversion between the list of configurations of a lens file and a table.

Lengths in mm; those of `Configurations` in the file's unit. Design programs number their configurations, and list one
quantity of one surface a row. A zoom is such a list, and so is a lens that focuses by moving groups, whose close
positions have a near object. A list of both has either all zoom settings at infinity first, then all at each nearer
distance, or all distances of each zoom setting in turn. Gaps, the object's distance, the stop's size and the stated
aperture are read from it; every other quantity that differs has the value of the first configuration, with a finding.
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from math import inf, isclose, isfinite, log, nextafter
from typing import Any

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import Aperture, SystemData
from lensbench.core.optics.zoom_positions import Positions, PositionsError
from lensbench.lenses.file_error import RowError
from lensbench.lenses.tables.paraxial import FAR, focal_length, image_distance, object_distance

MOST_STATIONS = 200     # configurations read from a file
SAME = 1e-6             # share of a gap: the solve of another program differs from ours by less


@dataclass
class Station:
    """One configuration: gaps by surface, object distance before the first vertex, and stated figures.

    aperture: value of the lens's stated aperture in this configuration; None: that of the lens. ways: along the axes
    behind the coordinate breaks of a file, by their numbers.
    """

    gaps: dict[int, float] = field(default_factory=dict)
    distance: float = inf
    stop: float | None = None
    focal_length: float | None = None
    f_number: float | None = None
    name: str = ""
    aperture: float | None = None
    ways: dict[int, float] = field(default_factory=dict)

    @property
    def is_far(self) -> bool:
        """Whether its object is at infinity."""
        return abs(self.distance) >= FAR


@dataclass(frozen=True)
class Solve:
    """A gap behind `surface` that follows from the others in every configuration.

    kind "image": it ends at the paraxial image. "sum": it and the gaps from `start` on add up to `total` (mm). "pair":
    it and the gap behind `start` alone do.
    """

    surface: int
    kind: str
    start: int = 0
    total: float = 0.0


def solved(lens: Lens, stations: list[Station], solves: Sequence[Solve],
           wavelength: float = D_LINE) -> list[Station]:
    """Configurations with the gaps that their file leaves to solves, by rays of a wavelength (µm).

    A gap stays if a configuration states it, if no ray finds it, and in the first configuration if the file agrees
    within SAME.
    """
    solved_stations = []
    for station in stations:
        gaps = [station.gaps.get(i, surface.thickness) for i, surface in enumerate(lens.surfaces)]
        known = dict(station.gaps)
        for solve in sorted(solves, key=lambda solve: solve.surface):
            i, first = solve.surface, solve.start
            if solve.kind == "image":
                gap = image_distance(with_gaps(lens.surfaces, range(len(gaps)), gaps), station.distance, wavelength)
            else:
                gap = solve.total - (sum(gaps[first:i]) if solve.kind == "sum" else gaps[first])
            if i in station.gaps or not isfinite(gap):
                continue
            kept = lens.surfaces[i].thickness
            gaps[i] = known[i] = kept if station is stations[0] and abs(gap - kept) <= SAME * abs(kept) else gap
        solved_stations.append(replace(station, gaps=known))
    return solved_stations


def zoom_fractions(focal_lengths: Sequence[float]) -> tuple[float, ...]:
    """Zoom stations from 0 to 1: evenly spaced in the logarithm of the focal length, if that rises."""
    if len(focal_lengths) == 1:
        return (0.0,)
    rising = all(0.0 < a < b < inf for a, b in zip(focal_lengths, focal_lengths[1:], strict=False))
    if not rising:
        return _even(len(focal_lengths))
    span = log(focal_lengths[-1] / focal_lengths[0])
    return (0.0, *(log(f / focal_lengths[0]) / span for f in focal_lengths[1:-1]), 1.0)


def focus_fractions(distances: Sequence[float]) -> tuple[float, ...]:
    """Focus stations from 0 to 1: evenly spaced in the reciprocal of the distance, if that rises."""
    if len(distances) == 1:
        return (0.0,)
    near = [1.0 / distance if distance else inf for distance in distances]
    if near[0] != 0.0 or near[-1] == inf or any(not a < b for a, b in zip(near, near[1:], strict=False)):
        return _even(len(distances))
    return (0.0, *(nearness / near[-1] for nearness in near[1:-1]), 1.0)


def _even(count: int) -> tuple[float, ...]:
    return tuple(i / (count - 1) for i in range(count)) if count > 1 else (0.0,)


def with_gaps(surfaces: Sequence[Any], gaps: Sequence[int], thicknesses: Sequence[float]) -> list[Any]:
    """The surfaces of a lens, or rows of a file, with other gaps."""
    moved = list(surfaces)
    for i, thickness in zip(gaps, thicknesses, strict=True):
        moved[i] = replace(moved[i], thickness=thickness)
    return moved


def placed(surfaces: Sequence[Any], station: Station) -> list[Any]:
    """The surfaces of a lens, or rows of a file, with the gaps of a configuration."""
    return with_gaps(surfaces, list(station.gaps), list(station.gaps.values()))


def with_stations(lens: Lens, stations: list[Station]) -> tuple[Lens, list[Finding]]:
    """The lens with the positions of a file's configurations, at the first position; and findings.

    Zoom settings are sorted from wide to tele, distances from infinity to the nearest.
    """
    varying = sorted({i for station in stations for i in station.gaps if any(
        other.gaps.get(i, lens.surfaces[i].thickness) != station.gaps[i] for other in stations)})
    stops = {station.stop for station in stations}
    if len(stations) < 2 or not (varying or len(stops) > 1):
        alike = len({station.distance for station in stations}) < 2
        return lens, [] if alike else [note(Kind.POSITION, "its configurations differ in the object distance alone: "
                                                           "that of the first is kept")]
    findings = []
    gaps = tuple(varying) or (len(lens.surfaces) - 1,)

    def row(station: Station) -> tuple[float, ...]:
        return tuple(station.gaps.get(i, lens.surfaces[i].thickness) for i in gaps)

    grid = _grid(stations)
    if grid is None:
        far = [station for station in stations if station.is_far]
        findings.append(note(Kind.POSITION, f"{len(stations)} positions of {len(far)} zoom settings form no table of "
                                            "zoom by distance: only those at infinity are kept"))
        grid = [[station] for station in far or stations[:1]]
    lengths = [focal_length(with_gaps(lens.surfaces, gaps, row(first))) for first, *_ in grid]
    order = sorted(range(len(grid)), key=lengths.__getitem__)
    if order != list(range(len(grid))) and len({*lengths}) == len(grid) and min(lengths) > 0.0:
        findings.append(note(Kind.POSITION, "the positions were put in order, from wide to tele"))
        grid, lengths = [grid[i] for i in order], [lengths[i] for i in order]
    firsts = [stations_of_one[0] for stations_of_one in grid]

    def stated(name: str) -> tuple[float, ...]:
        values = [getattr(station, name) for station in firsts]
        return tuple(values) if len(grid) > 1 and None not in values else ()

    distances = tuple(tuple(_from_film(lens, gaps, station) for station in along) for along in grid)
    try:
        positions = Positions(
            gaps, tuple(tuple(row(station) for station in along) for along in grid),
            zoom_fractions(lengths), focus_fractions(distances[0]), zoom_names(firsts),
            stated("focal_length"), stated("f_number"),
            distances if len(grid[0]) > 1 else (),
            tuple(tuple(station.stop or lens.stop.semi_diameter for station in along) for along in grid)
            if len(stops) > 1 else ())
    except PositionsError as error:
        return lens, [*findings, note(Kind.POSITION, f"its positions are left out: {error}")]
    system, told = _system_of(lens.system, grid)
    findings += told
    if len(grid) == len(grid[0]) == 1:
        return replace(lens, system=system), findings
    return replace(lens, positions=positions, system=system).at(zoom=0.0, close=0.0), findings


def _system_of(system: SystemData, grid: list[list[Station]]) -> tuple[SystemData, list[Finding]]:
    """System data with an aperture and an object distance for each zoom setting, where they vary."""
    findings = []
    aperture = system.aperture
    if aperture is not None and any(station.aperture is not None for along in grid for station in along):
        rows = [[aperture.values[0] if s.aperture is None else s.aperture for s in along] for along in grid]
        if any(len(set(row)) > 1 for row in rows):
            findings.append(note(Kind.POSITION, f"the stated {aperture.kind} differs between infinity and near: kept "
                                                "is that at infinity, and the stop of each position"))
        aperture = replace(aperture, values=one_if_equal([row[0] for row in rows]))
    distances = one_if_equal([inf if along[0].is_far else along[0].distance for along in grid])
    return replace(system, aperture=aperture, object_distances=distances), findings


def one_if_equal(values: Sequence[float]) -> tuple[float, ...]:
    """The values of all zoom settings, or one if all are the same."""
    return (values[0],) if len(set(values)) == 1 else tuple(values)


def zoom_names(stations: list[Station]) -> tuple[str, ...]:
    """Names of the zoom stations, if they have any."""
    names = tuple(station.name for station in stations)
    return names if len(stations) > 1 and any(names) else ()


def _grid(stations: list[Station]) -> list[list[Station]] | None:
    """Stations by zoom setting and distance, each from infinity to the nearest; None if they form no table."""
    far = [i for i, station in enumerate(stations) if station.is_far]
    if not far or len(far) == len(stations):
        same = len({station.distance for station in stations}) == 1
        if far or same:
            return [[station] for station in stations]
        return [sorted(stations, key=lambda station: -station.distance)]
    settings, rest = len(far), len(stations) % len(far)
    if rest:
        return None
    per_setting = len(stations) // settings
    if far == list(range(settings)):
        grid = [stations[i::settings] for i in range(settings)]
    elif far == list(range(0, len(stations), per_setting)):
        grid = [stations[i:i + per_setting] for i in range(0, len(stations), per_setting)]
    else:
        return None
    return [[along[0], *sorted(along[1:], key=lambda station: -station.distance)] for along in grid]


def _track(lens: Lens, gaps: Sequence[int], thicknesses: Sequence[float]) -> float:
    """First vertex → film with these gaps."""
    return sum(float(surface.thickness) for surface in with_gaps(lens.surfaces, gaps, thicknesses))


def _from_film(lens: Lens, gaps: Sequence[int], station: Station) -> float:
    """Object distance from the film."""
    if station.is_far:
        return inf
    return station.distance + _track(lens, gaps, [station.gaps.get(i, lens.surfaces[i].thickness) for i in gaps])


def stations_of(lens: Lens) -> tuple[list[Station], list[Finding]]:
    """Configurations of a lens with positions, all zoom settings at infinity first; and findings.

    A close position without a stated distance has the distance of the object of its paraxial image.
    """
    positions = lens.positions
    if positions is None:
        return [], []
    stations: list[Station] = []
    remarks: list[Finding] = []
    objects = lens.system.object_distances
    for j in range(len(positions.focus_stations)):
        for i in range(len(positions.zoom_stations)):
            gaps = positions.thicknesses[i][j]
            if positions.distances:
                distance = _before(positions.distances[i][j], _track(lens, positions.gaps, gaps))
                if j == 0 and isclose(distance, objects[i % len(objects)], rel_tol=SAME):
                    distance = objects[i % len(objects)]
            elif j == 0:
                distance = objects[i % len(objects)]
            else:
                distance = object_distance(with_gaps(lens.surfaces, positions.gaps, gaps))
                remarks.append(note(Kind.POSITION, "the distances of the close positions are not stated: their "
                                                   "paraxial ones were written"))
            stations.append(Station(
                dict(zip(positions.gaps, gaps, strict=True)), distance,
                positions.stops[i][j] if positions.stops else None,
                positions.focal_lengths[i] if positions.focal_lengths else None,
                positions.f_numbers[i] if positions.f_numbers else None,
                positions.names[i] if positions.names else ""))
    if positions.zoom or positions.close:
        remarks.append(note(Kind.POSITION, "the lens is written in its first position, wide and at infinity"))
    lengths = [focal_length(with_gaps(lens.surfaces, positions.gaps, row[0])) for row in positions.thicknesses]
    firsts = positions.distances[0] if positions.distances else positions.focus_stations
    if positions.zoom_stations != zoom_fractions(lengths) or (
            positions.distances and positions.focus_stations != focus_fractions(firsts)):
        remarks.append(note(Kind.POSITION, "the places of its zoom positions between 0 and 1 are left out: a reader "
                                           "finds them by focal length and distance"))
    return stations, list(dict.fromkeys(remarks))


def at_one_position(lens: Lens) -> Lens:
    """The lens in its present position, without the others; its system data are those of the zoom station there.

    Between two stations no aperture is stated: the stop says it.
    """
    positions, system = lens.positions, lens.system
    if positions is None:
        return lens
    index = positions.zoom_stations.index(positions.zoom) if positions.zoom in positions.zoom_stations else None
    aperture, objects = system.aperture, system.object_distances
    if aperture is not None and len(aperture.values) > 1:
        aperture = None if index is None else replace(aperture, values=(aperture.values[index % len(aperture.values)],))
    return replace(lens, positions=None, system=replace(system, aperture=aperture,
                                                        object_distances=(objects[(index or 0) % len(objects)],)))


def _before(distance: float, track: float) -> float:
    """Distance before the first vertex that, added to the track, is exactly this distance from the film."""
    before = distance - track
    for _ in range(4):
        if before + track == distance:
            break
        before = nextafter(before, inf if before + track < distance else -inf)
    return before


@dataclass
class Configurations:
    """Number of configurations, and values by quantity and surface, then by configuration from 1."""

    count: int = 1
    values: dict[tuple[str, int], dict[int, float]] = field(default_factory=dict)
    other: dict[str, set[str]] = field(default_factory=dict)        # quantities that are not read, with their values
    names: dict[int, str] = field(default_factory=dict)
    current: int = 1                        # the configuration whose values stand in the table of surfaces

    def put(self, quantity: str, surface: int, configuration: int, value: float) -> None:
        """Store a quantity of a surface in a configuration; further configurations are left out."""
        if 1 <= configuration <= MOST_STATIONS:
            self.values.setdefault((quantity, surface), {})[configuration] = value

    def differs(self, what: str, value: str) -> None:
        """Store a value of a quantity that a lens has only once."""
        self.other.setdefault(what, set()).add(value)

    def first(self, quantity: str, surface: int) -> float | None:
        """Value in the first configuration, or None."""
        return self.values.get((quantity, surface), {}).get(1)

    def stations(self, row_of: Callable[[int], int | None], stop: int | None, distance: float) -> list[Station]:
        """The configurations, with gaps by the row of their surface, or by the coordinate break; empty if there is one.

        distance: of the object, if it is the same in all.
        """
        stations = []
        for k in range(1, min(self.count, MOST_STATIONS) + 1 if self.count > 1 else 1):
            station = Station(distance=inf if abs(distance) >= FAR else distance, name=self.names.get(k, ""))
            for (quantity, surface), by_number in self.values.items():
                value = by_number.get(k, by_number.get(1))
                if quantity == "aperture":
                    station.aperture = value
                    continue
                row = row_of(surface)
                if value is None:
                    continue
                if row is None:                         # a coordinate break
                    if quantity == "gap":
                        station.ways[surface] = value
                elif quantity == "gap" and surface == 0:
                    station.distance = inf if abs(value) >= FAR else value
                elif quantity == "gap":
                    station.gaps[row] = value
                elif quantity == "stop" and surface == stop:
                    station.stop = value
            stations.append(station)
        return stations

    @property
    def differing(self) -> str:
        """Names of the quantities that differ between configurations and are not kept."""
        return ", ".join(sorted(what for what, values in self.other.items() if len(values) > 1))

    def check(self, harmless: Collection[str] = ()) -> None:
        """Raise RowError where the table of surfaces has such quantities from another configuration than the first.

        harmless: first words of those that change no surface.
        """
        differing = [what for what, values in self.other.items()
                     if len(values) > 1 and what.partition(" ")[0] not in harmless]
        if differing and self.current != 1:
            raise RowError(f"the table of surfaces is that of configuration {self.current}, and {', '.join(differing)} "
                           "differ in the first: save the file in its first configuration")

    def findings(self) -> list[Finding]:
        """Findings about quantities that differ between configurations and are not kept."""
        taken = "that of the first" if self.current == 1 else f"that of configuration {self.current}"
        findings = [note(Kind.POSITION, f"{self.differing}: of what differs between the configurations, {taken} is used"
                         )] if self.differing else []
        if self.count > MOST_STATIONS:
            findings.append(note(Kind.POSITION, f"the first {MOST_STATIONS} of {self.count} configurations were read",
                                 configurations=self.count))
        return findings


def rows(lens: Lens, stations: list[Station], far: float,
         aperture: Aperture | None = None) -> list[tuple[str, int, list[float]]]:
    """Each varying quantity, "aperture", "gap" or "stop", with its surface and its values.

    Surfaces count from the object, 0. far: object distance that a format writes for infinity. aperture: with a value
    for each station, or for all.
    """
    if not stations:
        return []
    rows: list[tuple[str, int, list[float]]] = []
    if aperture is not None and len(aperture.values) > 1:
        rows.append(("aperture", 0, list(aperture.values)))
    rows += [("gap", i + 1, [station.gaps[i] for station in stations]) for i in stations[0].gaps]
    if any(not station.is_far for station in stations):
        rows.append(("gap", 0, [far if station.is_far else station.distance for station in stations]))
    stops = [station.stop for station in stations if station.stop is not None]
    return rows + ([("stop", lens.stop_index + 1, stops)] if stops else [])


def lost_positions(stations: list[Station], plain: Callable[[str], str]) -> list[Finding]:
    """Findings about positions, for a format that holds only gaps, the stop and names.

    plain: the form in which a name is written, "" if the format has no names.
    """
    remarks = []
    if any(station.name and not plain(station.name) for station in stations):
        remarks.append(note(Kind.POSITION, "left out: the names of its positions"))
    elif any(station.name != plain(station.name) for station in stations):
        remarks.append(note(Kind.TEXT, "the names of its positions are written in one short line, without quotes"))
    if any(not (station.focal_length is None and station.f_number is None) for station in stations):
        remarks.append(note(Kind.POSITION, "left out: the stated focal lengths and f-numbers of its positions"))
    return remarks
