"""Lens data of a design program's file, from the object to the image, and the lens between them.

Lengths are in the unit of the file until `lens` converts them to mm. Thickness and medium of a row lie behind its
surface. The first row is the object and the last one the image; neither is part of the lens. The object distance
is kept in `Lens.system`, and the gap before the image is the back focus.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from math import inf, isclose, isfinite, isinf

from lensbench.core.optics.finding import Finding, Kind, Severity
from lensbench.core.optics.glass import AIR, Glass
from lensbench.core.optics.lens_surface import LensError, PoseError, Surface, SurfacePose
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import (
    LENGTHS, Aperture, ApertureKind, FieldKind, FieldPoint, SystemData, SystemDataError, Wavelength
)
from lensbench.core.text import significant
from lensbench.lenses.file_error import LensFileError, RowError, located
from lensbench.lenses.tables.aperture import axial_ray, estimate_rims, with_stated_aperture
from lensbench.lenses.tables.axes import START, AxesError, Break, alike, in_one_line
from lensbench.lenses.tables.paraxial import FAR, focal_length, reference_wavelength
from lensbench.lenses.tables.row_solves import RowSolve, doubts
from lensbench.lenses.tables.rows import check_sizes, stop_of, toroid_finding
from lensbench.lenses.tables.stations import Solve, Station, solved, with_stations

MOST_SURFACES = 1000
CATALOGUE_AIR = (15.0, 25.0), (0.9, 1.1)        # °C and atmospheres: the index of air changes by less than 4e-5


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
    breaks: list[Break] = field(default_factory=list)       # of the axis before the surface, which later ones keep
    aside: Break | None = None                              # of this surface alone
    behind: Break | None = None                             # at its vertex, for the later ones
    pose: SurfacePose | None = None                         # what follows from them

    @property
    def vertex_curvature(self) -> float:
        """Curvature at the vertex, with that of an r² term."""
        return self.curvature + 2.0 * self.aspheric.get(2, 0.0)


@dataclass
class Design:
    """Rows of a file, its system data and texts, and the assumptions made so far.

    system: in the file's unit, without the object distance, which is the thickness of the first row; its aperture is
    that of the first configuration. stations: the configurations of a file with several, gaps by row number. solves:
    gaps that follow from others, by row number.
    """

    path: str
    rows: list[Row] = field(default_factory=list)
    unit: float = 1.0                       # mm
    name: str = ""
    notes: str = ""
    stated_efl: float | None = None
    stated_f_number: float | None = None
    system: SystemData = SystemData()
    stations: list[Station] = field(default_factory=list)
    solves: list[Solve] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)
    checked: list[RowSolve] = field(default_factory=list)       # solves whose values the file states

    def found(self, kind: Kind, message: str, surface: int | None = None,
              severity: Severity = Severity.NOTE, **figures: float) -> None:
        """Store a finding once. surface: of the lens, from 0."""
        finding = Finding(kind, surface, message, severity=severity, figures=figures)
        if finding not in self.findings:
            self.findings.append(finding)

    def state_aperture(self, kind: ApertureKind, value: float) -> None:
        """Store the stated aperture; one that is none becomes a finding."""
        try:
            self.system = replace(self.system, aperture=Aperture(kind, (value,)))
        except SystemDataError as error:
            self.found(Kind.LEFT_OUT, f"{error}: {significant(value)} is left out", severity=Severity.WARNING)

    def state_fields(self, kind: FieldKind, points: Sequence[FieldPoint]) -> None:
        """Store the field points."""
        self.system = replace(self.system, field_kind=kind, fields=tuple(points))

    def field_point(self, x: float, y: float, weight: float = 1.0,
                    vignetting: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)) -> list[FieldPoint]:
        """The field point in a list; an empty one, with a finding, if its numbers are not valid."""
        try:
            return [FieldPoint(x, y, weight, vignetting)]
        except SystemDataError as error:
            self.found(Kind.LEFT_OUT, f"{error}: the point is left out", severity=Severity.WARNING)
            return []

    def state_wavelengths(self, pairs: Sequence[tuple[float, float]], primary: int) -> None:
        """Store wavelengths (µm) with their weights, and the index of the primary one."""
        made, primary_index = [], 0
        for i, (micrometres, weight) in enumerate(pairs):
            try:
                made.append(Wavelength(micrometres, weight))
                primary_index = len(made) - 1 if i == primary else primary_index
            except SystemDataError as error:
                self.found(Kind.LEFT_OUT, f"{error}: it is left out", severity=Severity.WARNING)
        if pairs and not 0 <= primary < len(pairs):
            self.found(Kind.LEFT_OUT, f"wavelength {primary + 1} is the primary one, but there are {len(pairs)}: the "
                                      "first is used instead", severity=Severity.WARNING)
        self.system = replace(self.system, wavelengths=tuple(made), primary=primary_index)

    def state_air(self, celsius: float, atmospheres: float) -> None:
        """Store a finding where the air of a file is not that of the catalogues: their indices are kept."""
        if not all(low <= value <= high for value, (low, high) in zip((celsius, atmospheres), CATALOGUE_AIR,
                                                                      strict=True)):
            self.found(Kind.LEFT_OUT, f"designed for {significant(celsius)} °C and {significant(atmospheres)} "
                                      "atmospheres: indices stay those of the catalogues, for 20 °C and 1",
                       severity=Severity.WARNING, celsius=celsius, atmospheres=atmospheres)

    @contextmanager
    def row(self, i: int, lines: Sequence[int]) -> Iterator[Row]:
        """A row to be filled, then added, of item i of a list whose items begin on these lines of the file.

        A RowError becomes a LensFileError that names the item as a surface.
        """
        row = Row(lines[i] if i < len(lines) else None)
        with located(self.path, row.line, f"surface {i}: "):
            yield row
        self.add(row)

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
        self._straighten()
        self._flatten_ends()
        stop = next((i for i, row in enumerate(self.rows[:-1]) if row.is_stop and i), 1)
        self.findings += doubts(self.rows, self.checked, self.system, stop,
                                reference_wavelength(self.rows[1:-1], self.system))
        covered = self._lay_cover_glass()
        surfaces = self.rows[1:-1]
        self._check_conjugates(surfaces, covered)
        marked = [i for i, row in enumerate(surfaces) if row.is_stop]
        if not marked and (self.rows[0].is_stop or self.rows[-1].is_stop):
            self.found(Kind.STOP, "the stop is marked on the object or the image, which are no part of the lens")
        if not marked and any(row.semi_diameter is None for row in surfaces):
            marked = [0]
            self.found(Kind.NO_STOP, "no stop is marked, and not every semi-diameter is known: surface 0 is assumed to "
                                     "be the stop", severity=Severity.WARNING)
        wavelength = self._wavelength(surfaces)
        self._estimate_rims(surfaces, marked, wavelength)
        for i, row in enumerate(surfaces):
            if row.glass.n_d == 1.0 and row.glass.name:
                self.found(Kind.GLASS, f"{row.glass.name} is read as air, of index 1", i)

        # In mm
        made: list[Surface] = []
        for row in surfaces:
            try:
                surface = Surface(row.thickness, row.semi_diameter or 0.0, row.glass, row.conic,
                                  tuple(row.aspheric.items()), row.curvature_x, curvature=row.curvature, pose=row.pose)
                made.append(surface.scaled(self.unit) if self.unit != 1.0 else surface)
                check_sizes(made[-1])
                finding = toroid_finding(row.toroid, made[-1], len(made) - 1)
                if finding:
                    self.findings.append(finding)
            except (LensError, PoseError, RowError, ArithmeticError) as error:
                raise self.refuse(row, f"surface {surfaces.index(row)}: {error}") from None
        if self.unit != 1.0:
            self.found(Kind.UNIT, f"lengths were converted to mm: one unit of the file is {significant(self.unit)} mm",
                       unit=self.unit)
        try:
            stop_index, assumed = stop_of(tuple(made), marked)
            scaled_efl = None if self.stated_efl is None else self.stated_efl * self.unit
            lens = Lens(tuple(made), stop_index, name=self.name, notes=self.notes, stated_efl=scaled_efl,
                        stated_f_number=self.stated_f_number, system=self._system_in_mm())
            stations = [self._in_mm(station, covered) for station in self.stations]
            stations = solved(lens, stations, self._solves(len(made), covered), wavelength)
            lens, stations, sized = with_stated_aperture(lens, stations, wavelength)
            lens, arranged = with_stations(lens, stations)
            return replace(lens, findings=tuple(dict.fromkeys([*self.findings, *sized, *arranged, *assumed])))
        except (LensError, SystemDataError, ArithmeticError) as error:
            raise self.refuse(None, str(error)) from None

    def _flatten_ends(self) -> None:
        """Findings about an image surface, or one of a near object, that is curved: both are planes here."""
        for row, what in ((self.rows[0], "object"), (self.rows[-1], "image")):
            if row.curvature != 0.0 and (what == "image" or abs(row.thickness) < FAR):
                radius = self.unit / row.curvature
                self.found(Kind.SHAPE, f"the {what} surface is curved, with a radius of {significant(radius)} mm: a "
                                       "plane is used instead", severity=Severity.WARNING, radius=radius)

    def _straighten(self) -> None:
        """Give the surfaces of a broken axis their poses along one line; LensFileError where none has their place."""
        if not any(row.breaks or row.aside or row.behind for row in self.rows):
            return
        lead, thicknesses, poses, line = self._in_one_line(Station())
        self.checked = [solve for solve in self.checked if solve.quantity != "thickness"]
        followed, rounding = {solve.surface for solve in self.solves}, 1e-9 * sum(map(abs, thicknesses[:-1]))
        if any(solve.kind != "image" for solve in self.solves):
            self.found(Kind.POSITION, "gaps that follow from others are those of the first position: the axis breaks",
                       severity=Severity.WARNING)
            self.solves = [solve for solve in self.solves if solve.kind == "image"]
        for k, station in enumerate(self.stations, start=1):
            lead_here, gaps, others = self._in_one_line(station)[:3]
            if not alike(poses, others):
                raise LensFileError(self.path, line, f"position {k} has other tilts or decentres than the first: a "
                                                     "lens has the same in all positions")
            gaps = [gap if not isclose(gap, kept, abs_tol=rounding) else kept
                    for gap, kept in zip(gaps, thicknesses, strict=True)]
            station.gaps = {row: gap for row, gap in enumerate(gaps, start=1) if row in station.gaps or (
                row not in followed and gap != thicknesses[row - 1])}
            station.distance += lead_here
        self.rows[0].thickness += lead
        for row, gap, pose in zip(self.rows[1:-1], thicknesses, poses, strict=True):
            row.thickness, row.pose = gap, pose

    def _in_one_line(self, station: Station) -> tuple[float, list[float], list[SurfacePose | None], int | None]:
        """Z of the first vertex on the axis, thicknesses and poses in a position, and the line of the last break."""
        frame, frames, lines = START, [], []            # of the last break up to each surface
        line = None
        for i, row in enumerate(self.rows[1:], start=1):
            for step in row.breaks:
                line, way = step.line, station.ways.get(step.number, step.distance)
                frame = frame.broken(replace(step, distance=way))
            line = line if row.aside is None else row.aside.line
            frames.append(frame if row.aside is None else frame.broken(row.aside))
            lines.append(line)
            if row.behind is not None:
                frame, line = frame.broken(row.behind), row.behind.line
            way = station.gaps.get(i, row.thickness)
            frame = frame.along(way if isfinite(way) else 0.0)
        try:
            lead, gaps, poses = in_one_line(frames[:-1], frames[-1],
                                            [row.curvature_x is None for row in self.rows[1:-1]])
        except AxesError as error:
            raise LensFileError(self.path, lines[error.index], str(error)) from None
        return lead, [gap if isfinite(row.thickness) else row.thickness
                      for row, gap in zip(self.rows[1:-1], gaps, strict=True)], poses, lines[-1]

    def _wavelength(self, surfaces: list[Row]) -> float:
        """Wavelength (µm) of the paraxial rays: the primary one if all glasses are known there."""
        wavelength, primary = reference_wavelength(surfaces, self.system), self.system.primary_wavelength
        if wavelength != primary:
            self.found(Kind.GLASS, f"a glass is not known at the primary wavelength, {significant(primary)} µm: "
                                   "first-order data are those of the d line",
                       severity=Severity.WARNING, primary=primary)
        return wavelength

    def _system_in_mm(self) -> SystemData:
        """The system data in mm, with the distance of the object."""
        distance = self.rows[0].thickness
        return replace(self.system, object_distances=(inf if abs(distance) >= FAR else distance,)).scaled(self.unit)

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
        aperture = station.aperture
        if aperture is not None and self.system.aperture and self.system.aperture.kind in LENGTHS:
            aperture *= self.unit
        return replace(station, gaps=gaps, distance=distance, stop=None if stop is None else stop * self.unit,
                       focal_length=None if length is None else length * self.unit,
                       aperture=aperture)

    def misfit(self) -> float:
        """Distance between the paraxial and the stored image, in focal lengths; larger for impossible surfaces."""
        surfaces = self.rows[1:-1]
        try:
            heights, _, slope = axial_ray(surfaces, self.rows[0].thickness or inf)
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
        what = source.glass.name or f"a medium of index {significant(source.glass.n_d)}"
        if not 0.0 < source.thickness < FAR:
            raise self.refuse(source, f"the object lies in {what} at no finite distance: a lens must have air in "
                                      "front of it")
        size = source.semi_diameter or 0.0
        if self.system.field_kind is FieldKind.OBJECT_HEIGHT:
            size = max(size, self.system.largest_field)
        cover = Row(source.line, thickness=source.thickness, glass=source.glass, semi_diameter=size or None)
        self.findings = [f if f.surface is None else replace(f, surface=f.surface + 1) for f in self.findings]
        self.found(Kind.NEAR_OBJECT, f"designed for an object that lies in {what}, "
                                     f"{significant(source.thickness * self.unit)} mm before the first surface of the "
                                     "file: a plane that touches the object is added as surface 0; the stored back "
                                     "focus is that of the object's image", 0, distance=source.thickness * self.unit)
        source.glass, source.thickness = AIR, 0.0
        self.rows.insert(1, cover)
        return True

    def _check_conjugates(self, surfaces: list[Row], covered: bool) -> None:
        """Check object and image: their distances, and the media in front of the lens and behind it."""
        distance = self.rows[0].thickness
        if abs(distance) < FAR and not covered:
            self.found(Kind.NEAR_OBJECT, f"designed for an object {significant(distance * self.unit)} mm before the "
                                         "first surface; the stored back focus is that of its image",
                       distance=distance * self.unit)
        for row in surfaces[:-1]:
            if isinf(row.thickness):
                raise self.refuse(row, "a gap within the lens is infinite")
        last = surfaces[-1]
        if isinf(last.thickness) or abs(last.thickness) > FAR:
            last.thickness = 0.0
            self.found(Kind.IMAGE, "its image lies at infinity: no back focus is stored")
        if last.glass.n_d != 1.0:
            self.found(Kind.IMAGE, f"the image lies in {last.glass.name or 'a medium'} of index "
                                   f"{significant(last.glass.n_d)}",
                       index=last.glass.n_d)

    def _estimate_rims(self, surfaces: list[Row], marked: list[int], wavelength: float) -> None:
        """Estimate missing rims; LensFileError if nothing says how large they are."""
        unknown = [i for i, row in enumerate(surfaces) if row.semi_diameter is None]
        if not unknown:
            return
        stop = marked[0] if marked else 0
        if not estimate_rims(surfaces, stop, bool(marked), self.system, self.rows[0].thickness, wavelength):
            raise self.refuse(surfaces[unknown[0]], "semi-diameters are missing, and so is an aperture to estimate "
                                                    "them from")
        which = "any surface" if len(unknown) == len(surfaces) else \
            f"surface{'s' if len(unknown) > 1 else ''} {_listed(unknown)}"
        kind = self.system.aperture.kind if self.system.aperture else "other semi-diameters"
        self.found(Kind.RIM, f"the file has no semi-diameter for {which}: estimated from the paraxial marginal and "
                             f"chief rays ({kind}{'' if self.system.largest_field else ', no field is stated'})",
                   unknown[0] if len(unknown) == 1 else None)


def _listed(numbers: list[int]) -> str:
    """“0, 2–5, 7”."""
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ", ".join(str(run[0]) if len(run) == 1 else f"{run[0]}–{run[-1]}" for run in runs)
