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
from dataclasses import replace
from math import inf, isinf
from typing import Any

from lensbench.kernels.figures import significant
from lensbench.lenses import configurations, media
from lensbench.lenses.aperture import f_number_kind
from lensbench.lenses.design import Design, Row
from lensbench.lenses.encoding import (
    LONGEST_NAME,
    check_lines,
    file_curvature,
    file_number,
    first_number,
    first_word,
    is_number,
)
from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.paraxial import FAR, ray, reference_wavelength
from lensbench.lenses.rows import RowError, radius_text
from lensbench.lenses.stations import Station, stations_of, with_gaps
from lensbench.lenses.written_system import WrittenSystem, written_system
from lensbench.optics.finding import Finding, Kind, note
from lensbench.optics.glass import AIR, Glass
from lensbench.optics.prescription import Lens, Surface
from lensbench.optics.system import Aperture, ApertureKind, FieldKind, FieldPoint

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
    WR DES SDES NOTE SNO1 SNO2 SNO3 SNO4 SNO5 DLNR DRW APDX AMO CBK TEM PRE CSD AFO EVZ IMS PFM WRSP SASD
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
            station.aperture = (station.aperture or size) / _beam_share(
                with_gaps(surfaces, list(moved), list(moved.values())), stop - 1, station.distance, wavelength)
        pupil = size / _beam_share(surfaces, stop - 1, distance, wavelength)
        design.state_aperture(ApertureKind.PUPIL_DIAMETER, pupil)
        design.found(Kind.CONVENTION, "the entrance beam (EBR), measured on the first surface, is kept as the diameter "
                                      f"of the entrance pupil, {significant(pupil, 6)}")


def _beam_share(surfaces: Sequence[Any], stop: int, distance: float, wavelength: float) -> float:
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


def write(lens: Lens) -> tuple[str, list[Finding]]:
    """Text of a .len file, and findings about what it cannot hold, other than shapes."""
    stations, remarks = stations_of(lens)
    lens = lens.at(zoom=0.0, close=0.0)
    words = [word for word in lens.name.replace('"', " ").replace("\\", " ").split() if not is_number(word)]
    name = " ".join(words)[:LONGEST_NAME].strip()
    system = written_system(lens, stations, _holds)
    remarks += system.findings
    distance = system.data.object_distances[0]
    system = _with_beams(system, lens, stations)
    lines = ["// OSLO 6.6", f'LEN NEW "{name}" {lens.stated_efl or 100.0!r} {len(lens.surfaces) + 1}',
             *_system_lines(system, remarks), "UNI 1.0", "// SRF 0", "AIR",
             f"TH {'1.0e20' if isinf(distance) else repr(distance)}"]
    for i, s in enumerate(lens.surfaces):
        lines.append(f"NXT  // SRF {i + 1}")
        lines.append(_glass_line(s.glass, i, remarks))
        lines += _shape_lines(s)
        lines += [f"TH {s.thickness!r}", f"AP {s.semi_diameter!r}"]
        lines += ["AST"] if i == lens.stop_index else []
    lines += [f"NXT  // SRF {len(lens.surfaces) + 1}", "AIR",
              *_wavelength_lines(system, bool(lens.system.wavelengths), remarks),
              *_configuration_lines(lens, stations, system.aperture), f"END {len(lens.surfaces) + 1}", ""]
    remarks += media.left_out(lens, "kind", "year", "source", "stated_efl", "stated_f_number", "notes")
    if name != lens.name:
        remarks.append(note(Kind.TEXT, "the name is written short, without quotes and without words that are numbers, "
                                       "as OSLO needs it"))
    remarks += configurations.lost_positions(stations, lambda text: "")
    return "\n".join(lines), remarks


def _holds(kind: ApertureKind, distance: float) -> bool:
    """Whether a file states this aperture: of f-numbers the one at work."""
    return kind is f_number_kind(distance) or kind in APERTURES.values() and kind is not ApertureKind.F_NUMBER


def _with_beams(system: WrittenSystem, lens: Lens, stations: list[Station]) -> WrittenSystem:
    """The system data with twice the radius of the entrance beam in place of the diameter of the entrance pupil."""
    aperture = system.aperture
    if aperture is None or aperture.kind is not ApertureKind.PUPIL_DIAMETER:
        return system
    wavelength = reference_wavelength(lens.surfaces, system.data)
    shares = [_beam_share(with_gaps(lens.surfaces, list(s.gaps), list(s.gaps.values())), lens.stop_index, s.distance,
                          wavelength) for s in stations or [Station({}, system.data.object_distances[0])]]
    values = aperture.values if len(aperture.values) == len(shares) else aperture.values[:1] * len(shares)
    beams = tuple(value * share for value, share in zip(values, shares, strict=True))
    return replace(system, aperture=replace(aperture, values=beams if len(set(beams)) > 1 else beams[:1]))


def _system_lines(system: WrittenSystem, remarks: list[Finding]) -> list[str]:
    """Lines of the aperture and the largest field; what is lost is added to `remarks`."""
    lines = [_aperture_line(system.aperture.kind, system.aperture.values[0])] if system.aperture else []
    data = system.data
    key = next((key for key, kind in FIELDS.items() if kind is data.field_kind), None)
    if key is None:
        remarks.append(note(Kind.LEFT_OUT, f"left out of its system data: the fields by {data.field_kind}"))
        return lines
    if data.fields != (FieldPoint(0.0, data.fields[0].y),):
        remarks.append(note(Kind.LEFT_OUT, "of its fields the largest alone is written, as if it lay along y, without "
                                           "weight and vignetting"))
        return [*lines, f"{key} {data.largest_field!r}"]
    return [*lines, f"{key} {data.fields[0].y!r}"]


def _aperture_line(kind: ApertureKind, value: float) -> str:
    """Line of an aperture; EBR is a radius."""
    key = next((key for key, own in APERTURES.items() if own is kind), "FNO")
    return f"{key} {value / 2.0 if key == 'EBR' else value!r}"


def _wavelength_lines(system: WrittenSystem, is_stated: bool, remarks: list[Finding]) -> list[str]:
    """Lines of the wavelengths, the primary one first; a finding about another order is added to `remarks`."""
    waves = list(system.data.wavelengths)
    waves.insert(0, waves.pop(system.data.primary))
    if is_stated and system.data.primary:
        remarks.append(note(Kind.TEXT, "its wavelengths are written in another order: the primary one first"))
    return [f"WV {' '.join(repr(wave.micrometres) for wave in waves)}",
            f"WW {' '.join(repr(wave.weight) for wave in waves)}"]


def _configuration_lines(lens: Lens, stations: list[Station], aperture: Aperture | None) -> list[str]:
    """Lines of the differences in the configurations from the second on."""
    rows = configurations.rows(lens, stations, 1e20, aperture)
    lines = []
    for k in range(1, len(stations)):
        lines.append(f"CFG {k + 1}")
        for quantity, i, values in rows:
            if quantity == "aperture" and aperture is not None:
                lines.append(_aperture_line(aperture.kind, values[k]))
            else:
                lines.append(f"{'AP' if quantity == 'stop' else 'TH'} {i} {values[k]!r}")
    return lines


def _glass_line(glass: Glass, i: int, remarks: list[Finding]) -> str:
    """Line of the medium behind surface i; findings about its losses are added to `remarks`."""
    remarks += media.glass_loss(glass, i)
    if glass.n_d == 1.0:
        return "AIR"
    if media.is_known(glass):
        return f"GLA {glass.name}"
    label = re.sub(r'[\s";/]+', "_", glass.name.strip())[:LONGEST_NAME]
    if is_number(label or "G") or label != glass.name:
        remarks.append(note(Kind.GLASS, f"the glass {glass.name!r} is written as G{label}", i))
        label = f"G{label}"
    if glass.v_d and glass.v_d <= LEAST_ABBE:
        remarks.append(note(Kind.GLASS, f"surface {i}: an Abbe number of {significant(glass.v_d)} is left out, it "
                                        f"would be read "
                                        "as an index", i, v_d=glass.v_d))
    dispersion = f" {glass.v_d!r}" if glass.v_d and glass.v_d > LEAST_ABBE else ""
    return f"GLA MOD {label} {glass.n_d!r}{dispersion}"


def _shape_lines(s: Surface) -> list[str]:
    """The lines of curvature, conic and aspheric terms of a surface."""
    lines = [f"RD {radius_text(s.curvature)}"] if s.curvature else []
    lines += [f"CVX {s.curvature_x!r}"] if s.curvature_x is not None else []
    lines += [f"CC {s.conic!r}"] if s.conic else []
    terms = dict(s.aspheric)
    if set(terms) <= set(TERMS.values()):
        return lines + [f"{key} {terms[power]!r}" for key, power in TERMS.items() if power in terms]
    kind = "ARA" if any(power % 2 for power in terms) else "ASR"
    lines.append(f"ASP {kind} {max(terms) // POWERS[kind]}")
    return lines + [f"AS{power // POWERS[kind]} {a!r}" for power, a in terms.items()]
