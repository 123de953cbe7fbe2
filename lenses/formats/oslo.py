"""OSLO lens files (.len): lenses of rotationally symmetric surfaces and cylinders.

    LEN NEW "A singlet" 100 3           name, focal length, number of the image surface
    EBR 10; ANG 5                       radius of the entrance beam, field angle; UNI: mm a unit
    WV 0.58756 0.48613; WW 1 1          wavelengths (µm), the primary one first, and their weights
    TH 1e20                             the object's distance
    NXT                                 the next surface
    GLA N-BK7                           glass behind it; a number: its index; AIR
    RD 50; TH 5                         radius (CV: curvature), thickness
    AP 8                                semi-diameter (AP CHK: one that blocks rays)
    AST                                 the aperture stop
    CC -1; AD 1e-6; AE 1e-9             conic; coefficients of r⁴, r⁶ (AF r⁸, AG r¹⁰)
    NXT
    …
    END 3

Instead of the value a file may have a solve: PU and PUC, the slope of the axial and of the chief ray behind
the surface; PY and PYC, their heights on the next surface; EC, the distance from the axis at which both surfaces touch.
PK picks up from an earlier surface: CV, CVM (its shape, reversed), TH, THM, LN, LNM (a length between two), AP, GLA.

Further powers by ASP ASR n with AS1 … ASn (r², r⁴, …) or ASP ARA (r, r², …); RDX
and CVX turn the section y–z about an axis along y, to this radius or curvature. Lines or semicolons
separate commands; // begins a comment. GLA MOD name n1 n2 … has an index for each
wavelength of WV. Behind the surfaces, CFG n begins the configuration n of a zoom:
TH 4 12.5 is its gap behind surface 4 (0: the object), AP 9 6.1 its semi-diameter. Behind END, the block CFG NEW … END
has TH 4 n 12.5. Other blocks there (VAR, OPE, RST) are those of an optimisation.
EBR is measured on the first surface, and so is not half of the entrance pupil for a near
object. The aperture may also be NAO or NAP, the numerical aperture of object or image,
or FNO, the f-number at work; the field OBH or GIH, the height of the object or of the
paraxial image. Mirrors, tilts, decentres, gratings and ideal lenses are refused.
Sources of the keywords: OSLO's manual, and programs that read its files.
"""

import re
from collections.abc import Sequence
from math import inf
from typing import Any

from lensbench.core.optics.finding import Kind
from lensbench.core.optics.glass import AIR, Glass
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import ApertureKind, FieldKind
from lensbench.core.text import significant
from lensbench.lenses.file_error import LensFileError, RowError, located, not_understood
from lensbench.lenses.glass import media
from lensbench.lenses.tables import stations as configurations
from lensbench.lenses.tables.aperture import f_number_kind
from lensbench.lenses.tables.design import Design, Row
from lensbench.lenses.tables.paraxial import FAR, ray, reference_wavelength
from lensbench.lenses.tables.row_solves import RowSolve, apply, beam_radius
from lensbench.lenses.tables.stations import Solve, with_gaps
from lensbench.lenses.tables.text import check_lines, file_curvature, file_number, first_number, first_word, is_number

TERMS = {"AD": 4, "AE": 6, "AF": 8, "AG": 10}
REFUSED = {
    **dict.fromkeys(("RFL", "RFH"), "a mirror"), **dict.fromkeys(("TLA", "TLB", "TLC"), "a tilt"),
    **dict.fromkeys(("DCX", "DCY", "DCZ"), "a decentre"), "BEN": "a mirror bend", "RCO": "a return of coordinates",
    "GC": "global coordinates", "PFL": "an ideal lens", "GSP": "a grating", "DOE": "a diffractive element",
    "DFR": "a diffractive element", "DFX": "a diffractive element", "HOR": "a hologram", "EIK": "an eikonal surface",
    "GRT": "a grating", "GDT": "a gradient index",
    "SPL": "a spline", "CCX": "a second conic", "TIR": "a total reflection", "FRN": "a Fresnel surface",
}
MOVED = ("TLA", "TLB", "TLC", "DCX", "DCY", "DCZ")
HARMLESS_AT_ZERO = (*MOVED, "GSP", "CCX")
# Designer, labels and notes, thermal data, checks, drawing, evaluation, and what belongs to refused features alone
HARMLESS = frozenset("""
    WR DES SDES NOT DLNR DLRS DRW APDX AMO CBK AFO EVZ WRSP SASD LME LMN LDP ELMDF1 ELMDF2 BDI BDD VX PF TCE APCK
    PFM TOX TOY TOZ DT GOR
""".split())
ELEMENTS = ("EGR", "ELE")                       # LMO: groups for drawing; others are non-sequential, or arrays
SPECIAL = re.compile(r"APN|ATP|AAC|AAN|APK|A[XY][12]|AV[XY]\d*")       # apertures that are not round
SOLVES = {"PU": ("curvature", "axial slope"), "PUC": ("curvature", "chief slope"), "PY": ("thickness", "axial height"),
          "PYC": ("thickness", "chief height"), "EC": ("thickness", "edge")}
DELETED = {"CSD": "curvature", "TSD": "thickness"}          # solves
FIXED = {"RDF": "RD", "CVF": "CV", "THF": "TH", "APF": "AP", "GLF": "GLA", "AIF": "AIR"}      # the same, not variable
BLOCKS = ("VAR", "OPE", "RST", "TOL")           # behind END: variables, error function, ray sets, tolerances
BEHIND = frozenset("DLTOL CFWT CFAC".split())   # single commands there
APERTURES = {"EBR": ApertureKind.PUPIL_DIAMETER, "NAO": ApertureKind.OBJECT_NA, "NAP": ApertureKind.IMAGE_NA,
             "FNO": ApertureKind.F_NUMBER}
FIELDS = {"ANG": FieldKind.ANGLE, "OBH": FieldKind.OBJECT_HEIGHT, "GIH": FieldKind.IMAGE_HEIGHT}
POWERS = {"ASR": 2, "ARA": 1}           # kinds of ASP: r^(2i), r^i
LEAST_ABBE = 5.0                        # a smaller number behind an index is another index
WAVELENGTHS = [0.58756, 0.48613, 0.65627]


def read(text: str, path: str) -> Lens:
    """The lens of a file's text. LensFileError names `path`, the line, the keyword and the mistake."""
    check_lines(text, path)
    file = _File(path)
    commands = _commands(text)
    if not any(words[0] == "LEN" for _, words in commands):
        raise LensFileError(path, None, "there is no command LEN NEW: this is no OSLO lens")
    for line, words in commands:
        with located(path, line, f"SRF {len(file.design.rows) - 1}, {words[0]}: "):
            if file.ended:
                file.behind(words)
            else:
                file.command(line, words)
    if file.wavelengths != WAVELENGTHS or file.weights:
        weights = file.weights + [1.0] * len(file.wavelengths)
        file.design.state_wavelengths(list(zip(file.wavelengths, weights, strict=False)), 0)
    file.design.state_air(file.air["TEM"], file.air["PRE"])
    rows = file.design.rows
    if file.image not in (None, 0, len(rows) - 1):
        raise LensFileError(path, None, f"the image surface (IMS) is {file.image}, and not the last one: surfaces "
                                        "behind the image are not read")
    stop = next((i for i, row in enumerate(rows) if row.is_stop), None)
    with located(path, None, "a solve is not solved: "):
        _solve(file, stop or 1)
    file.design.stations = file.zoom.stations(lambda i: i, stop, rows[0].thickness)
    file.design.findings += file.zoom.findings()
    _place_aperture(file.design, stop or 1)
    return file.design.lens()


def _solve(file: "_File", stop: int) -> None:
    """Give the rows the values of their solves; one that ends at the paraxial image holds in each configuration."""
    design, last = file.design, len(file.design.rows) - 2
    if not file.solves:
        return
    if any(not 0 < solve.row <= last for solve in file.solves):
        raise RowError(f"{file.solves[-1].name} of the object or of the image")
    if file.zoom.count > 1:
        others = [solve for solve in file.solves if (solve.row, solve.rule, solve.value) != (last, "axial height", 0.0)]
        if others:
            raise RowError(f"SRF {others[0].row}, {others[0].name}: with configurations only PY 0 of the last gap is")
        design.solves.append(Solve(last, "image"))
    wavelength = reference_wavelength(design.rows[1:-1], design.system)
    beam = beam_radius(design.system, design.rows[0].thickness)
    if beam is None and all(solve.value == 0.0 for solve in file.solves if solve.rule.startswith("axial")):
        beam = 1.0                              # any ray on the axis has height 0 where one has
    apply(design.rows, file.solves, design.system, stop, beam, wavelength)


def _place_aperture(design: Design, stop: int) -> None:
    """Give the aperture of the rows, and of each configuration, the kind and the size that its object asks for.

    stop: row of the stop, the first surface by default.
    """
    aperture, surfaces = design.system.aperture, design.rows[1:-1]
    if aperture is None or len(design.rows) < 3 or stop > len(surfaces):
        return
    distance, size = design.rows[0].thickness, aperture.values[0]
    if aperture.kind is ApertureKind.F_NUMBER:
        design.state_aperture(f_number_kind(distance), size)
    elif aperture.kind is ApertureKind.PUPIL_DIAMETER and any(
            abs(length) < FAR for length in (distance, *(station.distance for station in design.stations))):
        wavelength = reference_wavelength(surfaces, design.system)
        for station in design.stations:
            moved = {row - 1: gap for row, gap in station.gaps.items() if 0 < row <= len(surfaces)}
            station.aperture = (station.aperture or size) / beam_share(
                with_gaps(surfaces, list(moved), list(moved.values())), stop - 1, station.distance, wavelength)
        pupil = size / beam_share(surfaces, stop - 1, distance, wavelength)
        design.state_aperture(ApertureKind.PUPIL_DIAMETER, pupil)
        design.found(Kind.CONVENTION, "the entrance beam (EBR), measured on the first surface, is kept as the diameter "
                                      f"of the entrance pupil, {significant(pupil, 6)}")


def beam_share(surfaces: Sequence[Any], stop: int, distance: float, wavelength: float) -> float:
    """Height of the axial ray at the first surface over its height in the entrance pupil; 1 where there is none."""
    try:
        pupil = ray(surfaces, 0.0, 1.0, wavelength)[0][stop] / ray(surfaces, 1.0, 0.0, wavelength)[0][stop]
        share = abs(distance / (distance + pupil)) if abs(distance) < FAR else 1.0
    except ArithmeticError:
        return 1.0
    return share if 0.0 < share < inf else 1.0


def _commands(text: str) -> list[tuple[int, list[str]]]:
    """The words of each command, quoted texts whole without their quotes, and its line."""
    commands = []
    for line, content in enumerate(text.split("\n"), start=1):
        words: list[str] = []
        for token in re.findall(r'"(?:\\.|[^"\\])*"|//|;|(?:(?!//)[^\s;"])+|"', content):
            if token == "//":
                break
            if token == ";":
                commands += [(line, words)] if words else []
                words = []
            else:
                words.append(re.sub(r"\\(.)", r"\1", token[1:-1]) if token[:1] == '"' and len(token) > 1 else token)
        commands += [(line, words)] if words else []
    return [(line, [words[0].upper(), *words[1:]]) for line, words in commands]


class _File:
    """State of a file being read, command by command."""

    def __init__(self, path: str):
        self.design = Design(path, [Row(None, thickness=float("inf"))])
        self.begun = self.ended = False
        self.wavelengths = list(WAVELENGTHS)
        self.weights: list[float] = []
        self.general: dict[int, str] = {}
        self.solves: list[RowSolve] = []
        self.block = ""                             # behind END
        self.air = {"TEM": 20.0, "PRE": 1.0}        # °C, atmospheres
        self.zoom = configurations.Configurations()
        self.image: int | None = None               # IMS, the image surface
        self.configuration = 0                      # the current configuration; 0: before the first CFG

    def command(self, line: int, words: list[str]) -> None:
        """Process one command. RowError: invalid, or not traced."""
        key, values, design = FIXED.get(words[0], words[0]), words[1:], self.design
        row = design.rows[-1]
        row.line = row.line or line
        if key == "LEN":
            if self.begun or first_word(values).upper() != "NEW":
                raise RowError("a second lens, or a change of one, is not read")
            self.begun = True
            design.name = next((word for word in values[1:] if not is_number(word)), "")
        elif key == "CFG":
            self.configuration = int(first_number(values))
            self.zoom.count = max(self.zoom.count, self.configuration)
        elif self.configuration and key != "END":
            self.configured(key, line, values)
        elif key == "NXT":
            design.add(Row(line))
        elif key == "END":
            self.ended = True
        elif key == "UNI":
            design.unit = first_number(values)
            if not 0.0 < design.unit <= 1e6:
                raise RowError(f"the unit is {significant(design.unit)} mm: it must be positive, and at most 1e6 mm")
        elif key in APERTURES:
            design.state_aperture(APERTURES[key], first_number(values) * (2.0 if key == "EBR" else 1.0))
        elif key in FIELDS:
            design.state_fields(FIELDS[key], design.field_point(0.0, first_number(values)))
        elif re.fullmatch(r"W[VW]\d{0,2}", key):
            self.spectrum(key, [file_number(word, key) for word in values])
        elif key in self.air:
            self.air[key] = first_number(values)
        elif key in ("SNO1", "NOTE"):
            design.notes = " ".join(" ".join(values).split())
        elif key == "IMS":
            self.image = int(first_number(values))
        elif key == "AP" and len(design.rows) == 1:
            return                                  # the object's
        else:
            self.surface(line, row, key, values)

    def configured(self, key: str, line: int, values: list[str]) -> None:
        """Store a quantity of a surface in the current configuration."""
        rows = self.design.rows
        index = int(first_number(values[:1])) if key in ("TH", "AP") else -1
        if key in APERTURES:
            self.zoom.put("aperture", 0, self.configuration, first_number(values) * (2.0 if key == "EBR" else 1.0))
        elif key == "TH" and len(values) > 1 and 0 <= index < len(rows):
            self.zoom.put("gap", index, self.configuration, first_number(values[1:], infinite=True))
        elif key == "AP" and len(values) > 1 and 0 <= index < len(rows) and rows[index].is_stop:
            self.zoom.put("stop", index, self.configuration, first_number(values[1:]))
        elif key == "AP" or re.fullmatch(r"W[VW]\d{0,2}", key):
            self.zoom.differs(f"{key} {index}" if key == "AP" else key, " ".join(values))
            self.zoom.differs(f"{key} {index}" if key == "AP" else key, "")
        elif key not in HARMLESS:
            raise RowError(not_understood(f"CFG {self.configuration} {key}"))

    def behind(self, words: list[str]) -> None:
        """Process a command behind the surfaces. RowError: one that may change the lens."""
        key, values = words[0], words[1:]
        if key == "END":
            self.block = ""
        elif self.block == "CFG" and key not in BEHIND:
            if key != "TH" or len(values) != 3:
                raise RowError(not_understood(f"CFG {key}"))
            index, self.configuration = int(first_number(values)), int(first_number(values[1:]))
            if not 0 <= index < len(self.design.rows):
                raise RowError(f"there is no surface {index}")
            self.zoom.count = max(self.zoom.count, self.configuration)
            self.zoom.values.setdefault(("gap", index), {}).setdefault(1, self.design.rows[index].thickness)
            self.zoom.put("gap", index, self.configuration, first_number(values[2:], infinite=True))
        elif not self.block and values and values[0].upper() == "NEW" and key in ("CFG", *BLOCKS):
            self.block = key
            if key == "RST":
                self.design.found(Kind.LEFT_OUT, "field points and ray sets (RST) are left out: the field is the "
                                                 "largest")
        elif self.block not in BLOCKS and key not in BEHIND:
            raise RowError(not_understood(key))

    def spectrum(self, key: str, numbers: list[float]) -> None:
        """Store wavelengths (WV) or weights (WW): all, or the one with the number in the keyword."""
        stored = self.wavelengths if key.startswith("WV") else self.weights
        index = int(key[2:] or 0) - 1
        if index < 0:
            stored[:] = numbers
        elif len(numbers) != 1 or index > max(len(self.wavelengths), len(stored)):
            raise RowError("one value is needed, of a wavelength that exists or is the next one")
        else:
            stored += [1.0] * (index + 1 - len(stored))
            stored[index] = numbers[0]

    def unsolve(self, index: int, quantity: str) -> None:
        """A value replaces the solve of a quantity."""
        self.solves = [solve for solve in self.solves if (solve.row, solve.quantity) != (index, quantity)]

    def pick_up(self, row: Row, index: int, values: list[str]) -> None:
        """Process PK: a quantity of an earlier surface; a negative number counts back from this one."""
        kind, numbers = first_word(values).upper(), [file_number(word, "PK") for word in values[1:]]
        if not numbers:
            raise RowError("a pick-up needs the number of an earlier surface")
        source = int(numbers[0]) + (index if numbers[0] < 0 else 0)
        if not 0 <= source < index:
            raise RowError(f"a pick-up from surface {source}, which does not come before")
        other, sign = self.design.rows[source], -1.0 if kind.endswith("M") else 1.0
        if kind in ("GLA", "GL"):
            row.glass = other.glass
        elif kind == "AP":
            row.semi_diameter = other.semi_diameter
        elif kind in ("CV", "CVM"):
            row.conic, row.aspheric = other.conic, {power: sign * a for power, a in other.aspheric.items()}
            row.curvature_x = None if other.curvature_x is None else sign * other.curvature_x
            row.toroid = other.toroid
            self.solve(RowSolve(index, "curvature", "pickup", sum(numbers[1:2]), f"PK {kind}", source, sign))
        elif kind in ("TH", "THM"):
            self.solve(RowSolve(index, "thickness", "pickup", sum(numbers[1:2]), f"PK {kind}", source, sign))
        elif kind in ("LN", "LNM") and len(numbers) > 1:
            end = (int(numbers[1]) + (index if numbers[1] < 0 else 0)) or index
            if not source < end <= index:
                raise RowError(f"a length from surface {source} to {end} is not one before this surface")
            self.solve(RowSolve(index, "thickness", "pickup", sum(numbers[2:3]), f"PK {kind}", source, sign, end))
        else:
            raise RowError(f"a pick-up (PK {kind[:20]}) is not read")

    def solve(self, solve: RowSolve) -> None:
        """Store a solve, which replaces another one of the same quantity."""
        self.unsolve(solve.row, solve.quantity)
        self.solves.append(solve)

    def surface(self, line: int, row: Row, key: str, values: list[str]) -> None:
        """Process a command for the current surface."""
        index = len(self.design.rows) - 1
        if key in ("RD", "CV"):
            row.curvature = first_number(values) if key == "CV" else file_curvature(first_word(values))
            self.unsolve(index, "curvature")
        elif key == "TH":
            row.thickness = first_number(values, infinite=True)
            self.unsolve(index, "thickness")
        elif key == "AP":
            size = first_number([word for word in values if word.upper() not in ("CHK", "UNC")])
            if size < 0.0:
                raise RowError(f"semi-diameter is {significant(size)}: it must be positive")
            row.semi_diameter = size or None
        elif key == "AST":
            row.is_stop = True
        elif key == "CC":
            row.conic = first_number(values)
        elif key in ("CVX", "RDX"):
            row.curvature_x = first_number(values) if key == "CVX" else file_curvature(first_word(values))
            row.toroid = "torus"
        elif key in TERMS:
            self.term(row, TERMS[key], first_number(values))
        elif key == "ASP":
            kind = first_word(values).upper().replace("1", "ASR")
            if kind in ("0", "ADO"):            # the terms AD to AG alone
                return
            if kind not in POWERS:
                raise RowError(f"an asphere of the kind {kind} is not traced, only {' and '.join(POWERS)}")
            self.general[index] = kind
        elif re.fullmatch(r"AS\d+", key):
            if index not in self.general:
                raise RowError("the kind of asphere (ASP) is missing before it")
            self.term(row, POWERS[self.general[index]] * int(key[2:6]), first_number(values))
        elif key == "AIR":
            row.glass = AIR
        elif key in ("GLA", "GL"):
            row.glass = self.glass(values)
        elif key == "PK":
            self.pick_up(row, index, values)
        elif key in SOLVES:
            quantity, rule = SOLVES[key]
            self.solve(RowSolve(index, quantity, rule, first_number(values), key))
        elif key in DELETED:
            self.unsolve(index, DELETED[key])
        elif SPECIAL.fullmatch(key):
            if key != "APN" or first_number(values) > 0:
                self.design.found(Kind.LEFT_OUT, f"SRF {index}: special apertures are left out, circles are used",
                                  index - 1)
        elif key == "LMO" and first_word(values).upper() not in ELEMENTS:
            raise RowError("a non-sequential group or an array is not traced")
        elif key in REFUSED:
            if key in HARMLESS_AT_ZERO and values and first_number(values) == 0.0:
                return
            raise RowError(f"{REFUSED[key]} is not {'read from this format' if key in MOVED else 'traced'}")
        elif key not in HARMLESS and key != "LMO" and not re.fullmatch(r"SNO\d+", key):
            raise RowError(not_understood(key))

    def term(self, row: Row, power: int, a: float) -> None:
        """Add an aspheric coefficient."""
        if a == 0.0:
            return
        if not 2 <= power <= 20:
            raise RowError(f"a term in r^{power} is not traced: powers go from 2 to 20")
        row.aspheric[power] = a

    def glass(self, values: list[str]) -> Glass:
        """Medium of GLA: a catalogue glass, an index, or MOD with a name and indices."""
        name = first_word(values)
        if name.upper() == "MOD":
            words = values[1:]
            label = words.pop(0) if words and not is_number(words[0]) else ""
            indices = [file_number(word, "index") for word in words]
            if len(indices) == 2 and indices[1] > LEAST_ABBE:       # n_d and V_d
                return media.stated(label, indices[0], indices[1])
            points = sorted(dict(zip(self.wavelengths, indices, strict=False)).items())
            if len(points) == 1:
                return media.model(points[0][1], 0.0, label)
            return media.tabulated(label, points)
        if is_number(name):
            if len(values) > 1 and all(is_number(word) for word in values):
                return self.glass(["MOD", *values])
            return media.code(name) or media.model(file_number(name, "index"), 0.0)
        return media.glass_in(self.design, name)
