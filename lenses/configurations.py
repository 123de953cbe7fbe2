"""Configurations of a lens as design programs list them: rows of values, one quantity of one surface each.

Lengths in the file's unit. A lens takes gaps, the object's distance, the stop's size and the stated aperture from
them. Of every other quantity that differs it takes the value of the first configuration, and a finding
says so.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from math import inf

from lensbench.lenses.numbers import RowError
from lensbench.lenses.paraxial import FAR
from lensbench.lenses.stations import MOST_STATIONS, Station
from lensbench.optics.finding import Finding, Kind, note
from lensbench.optics.prescription import Lens
from lensbench.optics.system import Aperture


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
        found = []
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
            found.append(station)
        return found

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
        found = [note(Kind.POSITION, f"{self.differing}: of what differs between the configurations, {taken} is taken"
                      )] if self.differing else []
        if self.count > MOST_STATIONS:
            found.append(note(Kind.POSITION, f"the first {MOST_STATIONS} of {self.count} configurations were read",
                              configurations=self.count))
        return found


def rows(lens: Lens, stations: list[Station], far: float,
         aperture: Aperture | None = None) -> list[tuple[str, int, list[float]]]:
    """Each varying quantity, "aperture", "gap" or "stop", with its surface and its values.

    Surfaces count from the object, 0. far: object distance that a format writes for infinity. aperture: with a value
    for each station, or for all.
    """
    if not stations:
        return []
    found: list[tuple[str, int, list[float]]] = []
    if aperture is not None and len(aperture.values) > 1:
        found.append(("aperture", 0, list(aperture.values)))
    found += [("gap", i + 1, [station.gaps[i] for station in stations]) for i in stations[0].gaps]
    if any(not station.is_far for station in stations):
        found.append(("gap", 0, [far if station.is_far else station.distance for station in stations]))
    stops = [station.stop for station in stations if station.stop is not None]
    return found + ([("stop", lens.stop_index + 1, stops)] if stops else [])


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
