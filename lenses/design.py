"""Lens data of a design program's file, from the object to the image, and the lens between them.

Lengths are in the unit of the file until `lens` converts them to mm. Thickness and medium of a row lie behind its
surface. The first row is the object and the last one the image; neither is part of the lens. The object distance
becomes a finding, and the gap before the image is the back focus.

If a file has no rim for a surface, the paraxial marginal and chief rays of its aperture and field give an estimate:
|y| + |ȳ|, and |y| at the stop. The findings of the lens report the estimate.
"""

from dataclasses import dataclass, field, replace
from math import asin, inf, isfinite, isinf, radians, tan

from lensbench.lenses import toroids
from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.paraxial import focal_length, ray
from lensbench.lenses.rows import RowError, check_sizes, stop_of
from lensbench.lenses.stations import Solve, Station, solved, with_stations
from lensbench.optics.finding import Finding, Kind, Severity
from lensbench.optics.glass import AIR, Glass
from lensbench.optics.prescription import Lens, LensError, Surface

FAR = 1e8               # file units: an object beyond it is at infinity
STEEPEST_FIELD = 60.0   # degrees: a steeper paraxial chief ray is meaningless
MOST_SURFACES = 1000
MOST_UNKNOWN = 12       # keywords that are listed as not read
FULLEST = 0.98          # share of a hemisphere that an estimated rim covers at most


@dataclass
class Row:
    """One surface of a design file, in the file's unit; semi_diameter None: not in the file."""

    line: int | None
    curvature: float = 0.0
    thickness: float = 0.0
    semi_diameter: float | None = None
    glass: Glass = AIR
    conic: float = 0.0
    aspheric: dict[int, float] = field(default_factory=dict)
    curvature_x: float | None = None
    toroid: str = "biconic"     # kind, if both sections are curved: see `toroids`
    is_stop: bool = False

    @property
    def vertex_curvature(self) -> float:
        """Curvature at the vertex, with that of an r² term."""
        return self.curvature + 2.0 * self.aspheric.get(2, 0.0)


@dataclass
class Design:
    """Rows of a file, its aperture, field and texts, and the assumptions made so far.

    aperture: ("EPD" diameter | "FNO" number | "NA" of the object | "stop" radius, value). field_of_view: ("angle"
    degrees | "object" | "image" height, value). stations: the configurations of a file with several, gaps by row
    number. solves: gaps that follow from others, by row number.
    """

    path: str
    rows: list[Row] = field(default_factory=list)
    unit: float = 1.0                       # mm
    name: str = ""
    notes: str = ""
    stated_efl: float | None = None
    stated_f_number: float | None = None
    aperture: tuple[str, float] | None = None
    field_of_view: tuple[str, float] | None = None
    stations: list[Station] = field(default_factory=list)
    solves: list[Solve] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)
    unknown: dict[str, int] = field(default_factory=dict)      # keywords that were not read, and their first lines

    def found(self, kind: Kind, message: str, surface: int | None = None,
              severity: Severity = Severity.NOTE, **figures: float) -> None:
        """Store a finding once. surface: of the lens, from 0."""
        finding = Finding(kind, surface, message, severity=severity, figures=figures)
        if finding not in self.findings:
            self.findings.append(finding)

    def assume_glass(self, assumed: str) -> None:
        """Store what `media.named` assumed about a glass; "" is nothing."""
        if assumed:
            self.found(Kind.GLASS, assumed)

    def not_read(self, keyword: str, line: int) -> None:
        """Store a keyword unknown to the reader, with its first line."""
        if len(self.unknown) <= MOST_UNKNOWN:
            self.unknown.setdefault(keyword[:20], line)

    def add(self, row: Row) -> None:
        """Append a row; LensFileError if there are too many."""
        if len(self.rows) > MOST_SURFACES:
            raise self.refuse(row, f"a lens has at most {MOST_SURFACES} surfaces")
        self.rows.append(row)

    def refuse(self, row: Row | None, reason: str) -> LensFileError:
        """The error for a row."""
        return LensFileError(self.path, row.line if row else None, reason)

    def lens(self) -> Lens:
        """The lens between object and image, in mm; LensFileError if there is none."""
        if len(self.rows) < 3:
            raise self.refuse(None, "there is no lens: a design needs an object, at least one surface and an image")
        covered = self._lay_cover_glass()
        surfaces = self.rows[1:-1]
        self._check_conjugates(surfaces, covered)
        marked = [i for i, row in enumerate(surfaces) if row.is_stop]
        if not marked and (self.rows[0].is_stop or self.rows[-1].is_stop):
            self.found(Kind.STOP, "the stop is marked on the object or the image, which are no part of the lens")
        if not marked and any(row.semi_diameter is None for row in surfaces):
            marked = [0]
            self.found(Kind.NO_STOP, "no stop is marked, and not every rim is known: surface 0 is taken as the stop",
                       severity=Severity.WARNING)
        self._estimate_rims(surfaces, marked)
        self._check_stop(surfaces, marked)
        for i, row in enumerate(surfaces):
            if row.glass.n_d == 1.0 and row.glass.name:
                self.found(Kind.GLASS, f"{row.glass.name} is taken as air, of index 1", i)

        # In mm
        made: list[Surface] = []
        for row in surfaces:
            try:
                surface = Surface(row.curvature, row.thickness, row.semi_diameter or 0.0, row.glass, row.conic,
                                  tuple(row.aspheric.items()), row.curvature_x)
                made.append(surface.scaled(self.unit) if self.unit != 1.0 else surface)
                check_sizes(made[-1])
                finding = toroids.finding(row.toroid, made[-1], len(made) - 1)
                if finding:
                    self.findings.append(finding)
            except (LensError, RowError, ArithmeticError) as error:
                raise self.refuse(row, f"surface {surfaces.index(row)}: {error}") from None
        if self.unit != 1.0:
            self.found(Kind.UNIT, f"lengths were converted to mm: one unit of the file is {self.unit:g} mm",
                       unit=self.unit)
        if self.unknown:
            keywords = [f"{key} (line {line})" for key, line in self.unknown.items()]
            self.found(Kind.NOT_READ, f"not read: {', '.join(keywords[:MOST_UNKNOWN])}"
                                      f"{' …' if len(keywords) > MOST_UNKNOWN else ''}")
        try:
            stop_index, assumed = stop_of(tuple(made), marked)
            scaled_efl = None if self.stated_efl is None else self.stated_efl * self.unit
            lens = Lens(tuple(made), stop_index, name=self.name, notes=self.notes, stated_efl=scaled_efl,
                        stated_f_number=self.stated_f_number)
            stations = [self._in_mm(station, covered) for station in self.stations]
            lens, arranged = with_stations(lens, solved(lens, stations, self._solves(len(made), covered)))
            return replace(lens, findings=(*self.findings, *arranged, *assumed))
        except (LensError, ArithmeticError) as error:
            raise self.refuse(None, str(error)) from None

    def _solves(self, count: int, covered: bool) -> list[Solve]:
        """Solves by surfaces of the lens, in mm, without those of gaps outside the lens."""
        shift = covered - 1
        moved = [replace(s, surface=s.surface + shift, start=s.start + shift, total=s.total * self.unit)
                 for s in self.solves]
        return [s for s in moved if 0 <= s.surface < count and (s.kind == "image" or 0 <= s.start < s.surface)]

    def _in_mm(self, station: Station, covered: bool) -> Station:
        """A configuration by surfaces of the lens, in mm."""
        stop, length, last = station.stop, station.focal_length, len(self.rows) - 2
        gaps = {row - 1 + covered: gap * self.unit for row, gap in station.gaps.items() if 0 < row + covered <= last}
        if covered:                                 # the object's distance is a gap of the lens
            gaps[0], distance = station.distance * self.unit, 0.0
        else:
            distance = inf if station.is_far else station.distance * self.unit
        return replace(station, gaps=gaps, distance=distance, stop=None if stop is None else stop * self.unit,
                       focal_length=None if length is None else length * self.unit)

    def misfit(self) -> float:
        """Distance between the paraxial and the stored image, in focal lengths; larger for impossible surfaces."""
        surfaces, distance = self.rows[1:-1], self.rows[0].thickness
        start_slope = 0.0 if abs(distance) >= FAR or distance == 0.0 else 1.0 / distance
        try:
            heights, slope = ray(surfaces, 1.0, start_slope)
            before = -1.0 / slope if slope else inf
            image = (heights[-1] * before - surfaces[-1].thickness) / focal_length(surfaces)
        except ArithmeticError:
            image = inf
        crossed = sum(abs(row.curvature) * (row.semi_diameter or 0.0) > 1.0 for row in surfaces)
        folded = sum(row.glass.n_d > 1.0 and row.thickness * abs(row.curvature) > 2.5 for row in surfaces)
        return (min(abs(image), 50.0) if isfinite(image) else 100.0) + 10.0 * (crossed + folded)

    def _lay_cover_glass(self) -> bool:
        """Add a plane in front for an object within a medium, at the object: a lens file has air in front."""
        source = self.rows[0]
        if source.glass.n_d == 1.0:
            return False
        what = source.glass.name or f"a medium of index {source.glass.n_d:g}"
        if not 0.0 < source.thickness < FAR:
            raise self.refuse(source, f"the object lies in {what} at no finite distance: a lens must have air in "
                                      "front of it")
        size = source.semi_diameter or 0.0
        if self.field_of_view and self.field_of_view[0] == "object":
            size = max(size, abs(self.field_of_view[1]))
        cover = Row(source.line, thickness=source.thickness, glass=source.glass, semi_diameter=size or None)
        self.findings = [f if f.surface is None else replace(f, surface=f.surface + 1) for f in self.findings]
        self.found(Kind.NEAR_OBJECT, f"designed for an object that lies in {what}, {source.thickness * self.unit:g} mm "
                   "before the first surface of the file: a plane that touches the object is added as surface 0; the "
                   "stored back focus is that of the object's image", 0, distance=source.thickness * self.unit)
        source.glass, source.thickness = AIR, 0.0
        self.rows.insert(1, cover)
        return True

    def _check_conjugates(self, surfaces: list[Row], covered: bool) -> None:
        """Check object and image: their distances, and the media in front of the lens and behind it."""
        distance = self.rows[0].thickness
        if abs(distance) < FAR and not covered:
            self.found(Kind.NEAR_OBJECT, f"designed for an object {distance * self.unit:g} mm before the first "
                       "surface; the stored back focus is that of its image", distance=distance * self.unit)
        for row in surfaces[:-1]:
            if isinf(row.thickness):
                raise self.refuse(row, "a gap within the lens is infinite")
        last = surfaces[-1]
        if isinf(last.thickness) or abs(last.thickness) > FAR:
            last.thickness = 0.0
            self.found(Kind.IMAGE, "its image lies at infinity: no back focus is stored")
        if last.glass.n_d != 1.0:
            self.found(Kind.IMAGE, f"the image lies in {last.glass.name or 'a medium'} of index {last.glass.n_d:g}",
                       index=last.glass.n_d)

    def _estimate_rims(self, surfaces: list[Row], marked: list[int]) -> None:
        """Estimate missing rims from the paraxial marginal and chief rays."""
        unknown = [i for i, row in enumerate(surfaces) if row.semi_diameter is None]
        if not unknown:
            return
        try:
            marginal, chief = self._heights(surfaces, marked[0] if marked else 0)
        except (ArithmeticError, ValueError):
            marginal, chief = [], []
        if not marginal:
            raise self.refuse(surfaces[unknown[0]], "surface rims are missing, and so is an aperture to estimate "
                                                    "them from")
        for i in unknown:
            y = abs(marginal[i]) + (0.0 if marked and i == marked[0] else abs(chief[i]))
            row = surfaces[i]
            bend = (1.0 + row.conic) * row.curvature * row.curvature
            if bend > 0.0:
                y = min(y, FULLEST / bend ** 0.5)
            row.semi_diameter = y if isfinite(y) and y > 1e-9 else max(map(abs, marginal))
        which = "every surface" if len(unknown) == len(surfaces) else \
            f"surface{'s' if len(unknown) > 1 else ''} {_listed(unknown)}"
        kind = self.aperture[0] if self.aperture else "other rims"
        self.found(Kind.RIM, f"the file has no rim for {which}: estimated from the paraxial marginal and chief rays "
                             f"({kind}{'' if self.field_of_view else ', no field is stated'})",
                   unknown[0] if len(unknown) == 1 else None)

    def _check_stop(self, surfaces: list[Row], marked: list[int]) -> None:
        """Report a stop rim that differs from the one of the stated aperture."""
        kind, value = self.aperture or ("", 0.0)
        if len(marked) != 1 or kind not in ("EPD", "FNO", "NA") or not value > 0.0:
            return
        try:
            marginal, _ = self._heights(surfaces, marked[0])
            asked, rim = abs(marginal[marked[0]]), surfaces[marked[0]].semi_diameter or 0.0
        except (ArithmeticError, ValueError, IndexError):
            return
        if abs(asked - rim) > 0.02 * rim:
            self.found(Kind.RIM, f"the stop's semi-diameter, {rim * self.unit:.4g} mm, was kept: the stated aperture, "
                                 f"{kind} {value:g}, asks for {asked * self.unit:.4g} mm", marked[0],
                       kept=rim * self.unit, asked=asked * self.unit)

    def _heights(self, surfaces: list[Row], stop: int) -> tuple[list[float], list[float]]:
        """Heights of the marginal and the chief ray at the surfaces; empty lists if the aperture is unknown."""
        distance = self.rows[0].thickness
        at_infinity = abs(distance) >= FAR
        first, efl = ray(surfaces)[0], focal_length(surfaces)
        tilted, _ = ray(surfaces, 0.0, 1.0)
        share = -tilted[stop] / first[stop] if first[stop] else 0.0
        through_stop = [b + share * a for a, b in zip(first, tilted, strict=True)]      # slope 1 in front of the lens

        # The marginal ray, scaled to the aperture
        if at_infinity:
            unit = first
        else:
            unit = [a + b / distance for a, b in zip(first, tilted, strict=True)] if distance else tilted
        kind, value = self.aperture or ("", 0.0)
        if kind == "FNO" and isfinite(efl) and value > 0.0:
            kind, value = "EPD", abs(efl) / value
        if kind == "EPD" and value > 0.0:
            pupil = 1.0 if at_infinity else 1.0 + share / distance if distance else share
            scale = value / 2.0 / abs(pupil) if pupil else 0.0
        elif kind == "NA" and not at_infinity and 0.0 < value < 1.0:
            scale = tan(asin(value)) * abs(distance or 1.0)
        elif surfaces[stop].semi_diameter is not None and unit[stop]:
            scale = (surfaces[stop].semi_diameter or 0.0) / abs(unit[stop])
        else:
            rims = [row.semi_diameter / abs(y) for row, y in zip(surfaces, unit, strict=True)
                    if row.semi_diameter is not None and y]
            scale = min(rims, default=0.0)
        if not (0.0 < scale < inf):
            return [], []
        marginal = [scale * y for y in unit]

        # The chief ray, scaled to the field
        kind, value = self.field_of_view or ("", 0.0)
        slope = 0.0
        if kind == "angle":
            slope = tan(radians(min(abs(value), STEEPEST_FIELD)))
        elif kind == "object" and not at_infinity and distance + share:
            slope = abs(value) / abs(distance + share)
        elif kind == "image" and at_infinity and isfinite(efl) and efl:
            slope = abs(value / efl)
        return marginal, [slope * y for y in through_stop]


def _listed(numbers: list[int]) -> str:
    """“0, 2–5, 7”."""
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ", ".join(str(run[0]) if len(run) == 1 else f"{run[0]}–{run[-1]}" for run in runs)
