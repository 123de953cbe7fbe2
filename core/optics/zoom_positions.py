"""Positions of the groups of a lens: gaps that vary with zoom and focus, as a frozen table.

Lengths in mm. Zoom positions run from wide (0) to tele (1), with the same focus positions at each, from infinity (0) to
the nearest (1). Between tabulated ones every gap follows a monotone cubic (`kernels.numeric`): smooth, exact at the
tabulated positions, and within the range of its neighbours.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite

from lensbench.core.kernels.numeric import monotone_cubic
from lensbench.core.text import significant


class PositionsError(ValueError):
    """An invalid table of positions; the message says why."""


@dataclass(frozen=True)
class Positions:
    """The gaps behind the surfaces `gaps` at every station, and the current position.

    Args:
        gaps: Indices of the surfaces whose gaps vary, rising.
        thicknesses: nested tuples of float, [zoom station][focus station][gap]. The gaps (mm).
        zoom_stations, focus_stations: Positions of the stations, rising from 0 to 1; (0.0,) for a single one.
        names: Of the zoom stations; may be empty, as may all that follow.
        focal_lengths: Stated focal lengths of the zoom stations (mm).
        f_numbers: Stated f-numbers of the zoom stations, wide open.
        distances: nested tuples of float, [zoom station][focus station]. Film → object in focus (mm); inf is allowed.
        stops: nested tuples of float, [zoom station][focus station]. Semi-diameter of the stop (mm), if it varies.
        zoom, close: The current position, each from 0 to 1.
    Raises:
        PositionsError: For tables of other sizes, stations that do not rise, or invalid numbers.
    """

    gaps: tuple[int, ...]
    thicknesses: tuple[tuple[tuple[float, ...], ...], ...]
    zoom_stations: tuple[float, ...] = (0.0,)
    focus_stations: tuple[float, ...] = (0.0,)
    names: tuple[str, ...] = ()
    focal_lengths: tuple[float, ...] = ()
    f_numbers: tuple[float, ...] = ()
    distances: tuple[tuple[float, ...], ...] = ()
    stops: tuple[tuple[float, ...], ...] = ()
    zoom: float = 0.0
    close: float = 0.0

    def __post_init__(self) -> None:
        for name, places in (("zoom_stations", self.zoom_stations), ("focus_stations", self.focus_stations)):
            rising = all(a < b for a, b in zip(places, places[1:], strict=False))
            if not (rising and places[:1] == (0.0,) and (len(places) == 1 or places[-1] == 1.0)):
                raise PositionsError(f"{name} are {_listed(places)}: they must rise from 0 to 1")
        if not self.gaps or any(a >= b for a, b in zip((-1, *self.gaps), self.gaps, strict=False)):
            raise PositionsError(f"the varying gaps are {_listed(self.gaps)}: they must be surfaces, in rising order")
        for name, row in (("names", self.names), ("focal_lengths", self.focal_lengths), ("f_numbers", self.f_numbers)):
            if row and len(row) != len(self.zoom_stations):
                raise PositionsError(f"{name} has {len(row)} values for {len(self.zoom_stations)} zoom stations")
        shape = [len(self.focus_stations)] * len(self.zoom_stations)
        for name, table in (("thicknesses", self.thicknesses), ("distances", self.distances), ("stops", self.stops)):
            if (table or name == "thicknesses") and [len(row) for row in table] != shape:
                raise PositionsError(f"{name} must have a row for each of the {len(shape)} zoom stations, with a value "
                                     f"for each of the {len(self.focus_stations)} focus stations")
        if any(len(gaps) != len(self.gaps) for row in self.thicknesses for gaps in row):
            raise PositionsError(f"every station must have {len(self.gaps)} gaps, those behind surfaces "
                                 f"{_listed(self.gaps)}")
        if not all(isfinite(gap) for row in self.thicknesses for gaps in row for gap in gaps):
            raise PositionsError("a gap is not a finite number")
        if not all(isfinite(value) for value in (*self.focal_lengths, *self.f_numbers)):
            raise PositionsError("a focal length or f-number is not a finite number")
        if not all(0.0 < stop < inf for row in self.stops for stop in row):
            raise PositionsError("a semi-diameter of the stop is not a positive number")
        if not all(distance > 0.0 for row in self.distances for distance in row):
            raise PositionsError("a distance of the object is not positive; inf is allowed")
        for name, value, ends in (("zoom", self.zoom, "wide) and 1 (tele"), ("close", self.close,
                                                                            "infinity) and 1 (nearest")):
            if not 0.0 <= value <= 1.0:
                raise PositionsError(f"{name} {significant(value)}: it must lie between 0 ({ends})")
        if (self.zoom and not self.zooms) or (self.close and not self.focuses):
            raise PositionsError("a zoom or focus position other than 0 needs more than one station")

    @property
    def zooms(self) -> bool:
        """Whether there is more than one zoom station."""
        return len(self.zoom_stations) > 1

    @property
    def focuses(self) -> bool:
        """Whether there is more than one focus station, so that groups move to focus."""
        return len(self.focus_stations) > 1

    def at(self, zoom: float, close: float) -> "Positions":
        """The same table at another position: zoom 0 (wide) to 1 (tele), close 0 (infinity) to 1 (nearest)."""
        return replace(self, zoom=zoom, close=close)

    @property
    def thickness_now(self) -> tuple[float, ...]:
        """The gaps at the current position (mm)."""
        return tuple(self._between([[gaps[k] for gaps in row] for row in self.thicknesses])
                     for k in range(len(self.gaps)))

    @property
    def stop_now(self) -> float | None:
        """Semi-diameter of the stop at the current position (mm); None if it does not vary."""
        return self._between(self.stops) if self.stops else None

    @property
    def focal_length_now(self) -> float | None:
        """Stated focal length at the current position (mm)."""
        return monotone_cubic(self.zoom_stations, self.focal_lengths, self.zoom) if self.focal_lengths else None

    @property
    def f_number_now(self) -> float | None:
        """Stated f-number, wide open, at the current position."""
        return monotone_cubic(self.zoom_stations, self.f_numbers, self.zoom) if self.f_numbers else None

    def _between(self, table: Sequence[Sequence[float]]) -> float:
        """Value at the current position of a table [zoom station][focus station]: along the zoom first."""
        along = [monotone_cubic(self.zoom_stations, column, self.zoom) for column in zip(*table, strict=True)]
        return monotone_cubic(self.focus_stations, along, self.close)

    def label(self, i: int, j: int = 0) -> str:
        """Name of zoom position i and focus position j, such as “70 mm, infinity”, “tele” or “close”."""
        words = []
        if self.zooms:
            named = self.names[i] if self.names else ""
            length = f"{significant(self.focal_lengths[i])} mm" if self.focal_lengths else ""
            between = f"zoom {significant(self.zoom_stations[i], 3)}"
            end = {0: "wide", len(self.zoom_stations) - 1: "tele"}.get(i, between)
            words.append(named or length or end)
        if self.focuses:
            between = f"close {significant(self.focus_stations[j], 3)}"
            end = {0: "infinity", len(self.focus_stations) - 1: "close"}.get(j, between)
            words.append(end)
        return ", ".join(words)

    def scaled(self, factor: float) -> "Positions":
        """The positions of a lens scaled by a factor."""
        return replace(
            self, focal_lengths=tuple(f * factor for f in self.focal_lengths),
            thicknesses=tuple(tuple(tuple(gap * factor for gap in gaps) for gaps in row) for row in self.thicknesses),
            distances=tuple(tuple(distance * factor for distance in row) for row in self.distances),
            stops=tuple(tuple(stop * factor for stop in row) for row in self.stops))

    def with_stops(self, factor: float) -> "Positions":
        """The positions with the radius of the stop multiplied by a factor at each."""
        return replace(self, stops=tuple(tuple(stop * factor for stop in row) for row in self.stops))


def _listed(values: Sequence[float]) -> str:
    """The values in a message."""
    return ", ".join(significant(value) for value in values) or "none"
