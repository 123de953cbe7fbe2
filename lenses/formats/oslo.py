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

Further powers by ASP ASR n with AS1 … ASn (r², r⁴, …) or ASP ARA (r, r², …); RDX
and CVX turn the section y–z about an axis along y, to this radius or curvature. Lines or semicolons
separate commands; // begins a comment. GLA MOD name n1 n2 … has an index for each
wavelength of WV. Behind the surfaces, CFG n begins the configuration n of a zoom:
TH 4 12.5 is its gap behind surface 4 (0: the object), AP 9 6.1 its semi-diameter.
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

from lensbench.kernels.figures import significant
from lensbench.lenses import configurations, media
from lensbench.lenses.aperture import f_number_kind
from lensbench.lenses.design import Design, Row
from lensbench.lenses.encoding import (
    check_lines,
    file_curvature,
    file_number,
    first_number,
    first_word,
    is_number,
)
from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.paraxial import FAR, ray, reference_wavelength
from lensbench.lenses.rows import RowError
from lensbench.lenses.stations import with_gaps
from lensbench.optics.finding import Kind
from lensbench.optics.glass import AIR, Glass
from lensbench.optics.prescription import Lens
from lensbench.optics.system import ApertureKind, FieldKind

TERMS = {"AD": 4, "AE": 6, "AF": 8, "AG": 10}
REFUSED = {
    **dict.fromkeys(("RFL", "RFH"), "a mirror"), **dict.fromkeys(("TLA", "TLB", "TLC"), "a tilt"),
    **dict.fromkeys(("DCX", "DCY", "DCZ"), "a decentre"), "BEN": "a mirror bend", "RCO": "a return of coordinates",
    "GC": "global coordinates", "PFL": "an ideal lens", "GSP": "a grating", "DOE": "a diffractive element",
    "DFR": "a diffractive element", "DFX": "a diffractive element", "HOR": "a hologram", "EIK": "an eikonal surface",
    "LMO": "a non-sequential group or an array", "GRT": "a grating", "GDT": "a gradient index",
    "SPL": "a spline", "CCX": "a second conic", "TIR": "a total reflection", "FRN": "a Fresnel surface",
}
MOVED = ("TLA", "TLB", "TLC", "DCX", "DCY", "DCZ")
HARMLESS_AT_ZERO = (*MOVED, "GSP", "CCX")
# Labels, wavelengths, colours, tolerances, drawing and evaluation
HARMLESS = frozenset("""
    WR DES SDES NOTE SNO1 SNO2 SNO3 SNO4 SNO5 DLNR DRW APDX AMO CBK CSD AFO EVZ IMS PFM WRSP SASD
    LME
""".split())
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
    for line, words in _commands(text):
        if file.ended:
            break
        try:
            file.command(line, words)
        except RowError as error:
            raise LensFileError(path, line, f"SRF {len(file.design.rows) - 1}, {words[0]}: {error}") from None
    if not file.begun:
        raise LensFileError(path, None, "there is no command LEN NEW: this is no OSLO lens")
    if file.wavelengths != WAVELENGTHS or file.weights:
        weights = file.weights + [1.0] * len(file.wavelengths)
        file.design.state_wavelengths(list(zip(file.wavelengths, weights, strict=False)), 0)
    file.design.state_air(file.air["TEM"], file.air["PRE"])
    rows = file.design.rows
    stop = next((i for i, row in enumerate(rows) if row.is_stop), None)
    file.design.stations = file.zoom.stations(lambda i: i, stop, rows[0].thickness)
    file.design.findings += file.zoom.findings()
    _place_aperture(file.design, stop or 1)
    return file.design.lens()


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
            abs(place) < FAR for place in (distance, *(station.distance for station in design.stations))):
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
        place = ray(surfaces, 0.0, 1.0, wavelength)[0][stop] / ray(surfaces, 1.0, 0.0, wavelength)[0][stop]
        share = abs(distance / (distance + place)) if abs(distance) < FAR else 1.0
    except ArithmeticError:
        return 1.0
    return share if 0.0 < share < inf else 1.0


def _commands(text: str) -> list[tuple[int, list[str]]]:
    """The words of each command, quoted texts whole without their quotes, and its line."""
    found = []
    for line, content in enumerate(text.split("\n"), start=1):
        words: list[str] = []
        for token in re.findall(r'"(?:\\.|[^"\\])*"|//|;|(?:(?!//)[^\s;"])+|"', content):
            if token == "//":
                break
            if token == ";":
                found += [(line, words)] if words else []
                words = []
            else:
                words.append(re.sub(r"\\(.)", r"\1", token[1:-1]) if token[:1] == '"' and len(token) > 1 else token)
        found += [(line, words)] if words else []
    return [(line, [words[0].upper(), *words[1:]]) for line, words in found]


class _File:
    """State of a file being read, command by command."""

    def __init__(self, path: str):
        self.design = Design(path, [Row(None, thickness=float("inf"))])
        self.begun = self.ended = False
        self.wavelengths = list(WAVELENGTHS)
        self.weights: list[float] = []
        self.general: dict[int, str] = {}
        self.air = {"TEM": 20.0, "PRE": 1.0}        # °C, atmospheres
        self.zoom = configurations.Configurations()
        self.configuration = 0                      # the current configuration; 0: before the first CFG

    def command(self, line: int, words: list[str]) -> None:
        """Process one command. RowError: invalid, or not traced."""
        key, values, design = words[0], words[1:], self.design
        row = design.rows[-1]
        row.line = row.line or line
        if key == "LEN":
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
        elif key == "WV":
            self.wavelengths = [file_number(word, "WV") for word in values]
        elif key == "WW":
            self.weights = [file_number(word, "WW") for word in values]
        elif key in self.air:
            self.air[key] = first_number(values)
        elif key in ("SNO1", "NOTE") and values:
            design.notes = " ".join(" ".join(values).split())
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
        elif key not in HARMLESS:
            self.design.not_read(f"CFG {self.configuration} {key}", line)

    def surface(self, line: int, row: Row, key: str, values: list[str]) -> None:
        """Process a command for the current surface."""
        index = len(self.design.rows) - 1
        if key == "RD":
            row.curvature = file_curvature(first_word(values))
        elif key == "CV":
            row.curvature = first_number(values)
        elif key == "TH":
            row.thickness = first_number(values, infinite=True)
        elif key == "AP":
            size = first_number([word for word in values if word.upper() != "CHK"])
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
            kind = first_word(values).upper()
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
        elif key in ("PK", "GTO") and values:
            if values[0].upper() in ("GLA", "GL"):
                source = int(first_number(values[1:]))
                if not 0 <= source < index:
                    raise RowError(f"a pick-up from surface {source}, which does not come before")
                row.glass = self.design.rows[source].glass
            else:
                raise RowError(f"a pick-up (PK {values[0]}) is not read")
        elif key == "AY1" or (key == "APN" and first_number(values) > 0):
            self.design.found(Kind.LEFT_OUT, f"SRF {index}: special apertures are left out, the round rim taken",
                              index - 1)
        elif key in REFUSED:
            if key in HARMLESS_AT_ZERO and values and first_number(values) == 0.0:
                return
            raise RowError(f"{REFUSED[key]} is not {'read from this format' if key in MOVED else 'traced'}")
        elif key not in HARMLESS:
            self.design.not_read(key, line)

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
        if name.upper() in media.MIRROR_NAMES:
            raise RowError("a mirror is not traced")
        glass, assumed = media.named(name)
        self.design.assume_glass(assumed)
        return glass
