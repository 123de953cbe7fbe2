"""CODE V sequence files (.seq): lenses of rotationally symmetric surfaces and cylinders.

    RDM                                 radii from here on; RDM N: curvatures
    TITLE 'A singlet'; EPD 10; DIM M    aperture, unit: M mm, C cm, I inches
    SO  0 1e14                          object: radius, thickness, glass
    S   50 5 NBK7_SCHOTT                one surface each
      STO
      CON; K -1                         conic constant; ASP: A r⁴, B r⁶, C r⁸ … too
      CIR 8                             semi-diameter
    SI  0 0

Lines or semicolons separate commands; & continues a line and ! begins a comment. A
qualifier names another surface (THI S3 2.5), or several (CIR S1..3 8). Without RDM, CODE V uses a setting of the
user: the reader tries radii and curvatures and takes the reading whose image lies at
the image surface of the file. A zoom lens has a value for each position (ZOO 3, then
ZOO THI S4 14.1 14.1 12.5; THI S4 Z2 14.1 is the value of one position, TIT Z2 'tele'
its name). Mirrors and gratings are refused, and tilts that do not return (`codev_tilts`).
"""

import re
from dataclasses import replace
from decimal import Decimal

from lensbench.kernels.figures import significant
from lensbench.kernels.quotation import excerpt
from lensbench.lenses import configurations, glass_catalogue, media
from lensbench.lenses.design import Design, Row
from lensbench.lenses.encoding import (
    check_lines,
    file_curvature,
    file_number,
    first_number,
    first_word,
    is_number,
    plain_number,
)
from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.formats import codev_system, codev_tilts
from lensbench.lenses.formats.codev_system import SYSTEM
from lensbench.lenses.rows import RowError
from lensbench.lenses.stations import Solve
from lensbench.optics.finding import Kind, Severity, note
from lensbench.optics.glass import AIR, Glass
from lensbench.optics.prescription import Lens

UNITS = {"M": 1.0, "MM": 1.0, "C": 10.0, "CM": 10.0, "I": 25.4, "IN": 25.4}
TERMS = {letter: 4 + 2 * i for i, letter in enumerate("ABCDEFGHJ")}     # A r⁴ … H r¹⁸, J r²⁰; there is no I
REFUSED = {
    "BEN": "a mirror bend", "RET": "a return of axes", **dict.fromkeys(("XOD", "YOD", "ZOD"), "a pivot of its own"),
    "GLB": "global coordinates", "DIF": "a diffraction grating or diffractive element", "GRT": "a grating",
    "GRO": "a grating", "HOE": "a hologram", "NSS": "a non-sequential group", "SPS": "a special surface",
    "SPL": "a spline", "USR": "a surface of the user", "FRN": "a Fresnel surface",
    "LMO": "an ideal lens", "MOD": "an ideal lens", "GRN": "a gradient index", "IMG": "an ideal lens",
}
# Solves and controls of an optimisation, labels, colours, and what the program is to show
HARMLESS = frozenset("""
    CCY CCX THC GLC GLN GLD KC AC BC CC DC EC FC GC HC JC ADC BDC CDC XDC YDC ZDC CUM CUF PIM PIK RFP SLB
    CLS COM INI GO LEN RDM TEM PRE THM DER CA POL MIR CIN CNS
    ASP CON SPH DDM UID CUN
""".split())
HARMLESS_ALONE = ("BEN", "RET")       # commands without a value
SIDED = {"REX": "a rectangular aperture", "REY": "a rectangular aperture", "ELX": "an elliptical aperture",
         "ELY": "an elliptical aperture", "ADX": "a decentred aperture", "ADY": "a decentred aperture"}


def read(text: str, path: str) -> Lens:
    """The lens of a file's text. LensFileError names `path`, the line, the command and the mistake."""
    check_lines(text, path)
    statements = _statements(text)
    told = next((words[1:2] for _, words in statements if words[0] in ("RDM", "RDY_MODE")), None)
    if told is not None:
        return _Sequence(path, radii=told[:1] not in (["N"], ["n"])).run(statements)

    # The mode is not stated: use the reading whose image lies where the file places it
    readings: list[tuple[float, bool, Lens]] = []
    errors = []
    for radii in (True, False):
        try:
            sequence = _Sequence(path, radii)
            lens = sequence.run(statements)
            readings.append((sequence.design.misfit(), radii, lens))
        except LensFileError as error:
            errors.append(error)
    if not readings:
        raise errors[0]
    _, radii, lens = min(readings, key=lambda reading: reading[0])
    what = "radii" if radii else "curvatures"
    assumed = note(Kind.CONVENTION, f"the file does not say whether it gives radii or curvatures (RDM): read as {what}")
    return replace(lens, findings=(assumed, *lens.findings))


def _statements(text: str) -> list[tuple[int, list[str]]]:
    """The words of each command, quoted texts kept whole with their quotes, and its line."""
    found: list[tuple[int, list[str]]] = []
    words: list[str] = []
    start, going_on = 1, False
    for line, content in enumerate(text.split("\n"), start=1):
        if not going_on:
            start, words = line, []
        going_on = False
        for token in re.findall(r"'[^'\n]*'|\"[^\"\n]*\"|[^\s;!&'\"]+|[;!&]|['\"]", content):
            if token == "!":
                break
            if token == "&":
                going_on = True
                break
            if token == ";":
                found += [(start, words)] if words else []
                words = []
            else:
                words.append(token)
        if not going_on and words:
            found.append((start, words))
            words = []
    if words:
        found.append((start, words))
    return [(line, [words[0] if words[0][0] in "'\"" else words[0].upper(), *words[1:]]) for line, words in found]


class _Sequence:
    """State of a file being read: the current surface, and the private glasses so far."""

    def __init__(self, path: str, radii: bool):
        self.design = Design(path)
        self.path, self.radii = path, radii
        self.glasses: dict[str, Glass] = {}
        self.wavelengths: list[float] = []
        self.private = False
        self.edges: dict[int, float] = {}
        self.biconic: set[int] = set()
        self.tilts: dict[int, codev_tilts.Tilt] = {}
        self.zoom = configurations.Configurations()
        self.image_is_solved = False
        self.system: dict[str, list[str]] = {}

    def run(self, statements: list[tuple[int, list[str]]]) -> Lens:
        """The lens after all commands."""
        for line, words in statements:
            try:
                self.command(line, words)
            except RowError as error:
                raise LensFileError(self.path, line, f"{words[0]}: {error}") from None
        design = self.design
        if not design.rows:
            raise LensFileError(self.path, None, "there are no surfaces (SO, S, SI): this is no CODE V lens")
        for index, row in enumerate(design.rows):
            if row.semi_diameter is None and index in self.edges:
                row.semi_diameter = self.edges[index]
            if index in self.biconic and (row.conic or row.aspheric):
                raise LensFileError(self.path, row.line, f"S{index} is curved in two sections and has a conic or "
                                                         "aspheric terms: not traced")
        for index, tilt in self.tilts.items():
            codev_tilts.place(design, index, tilt)
        codev_system.read(design, self.system)
        if not any(row.is_stop for row in design.rows) and len(design.rows) > 1:
            design.rows[1].is_stop = True
            design.found(Kind.NO_STOP, "no stop is marked (STO): surface 0, as CODE V takes it",
                         severity=Severity.WARNING)
        stop = next((i for i, row in enumerate(design.rows) if row.is_stop), None)
        design.stations = self.zoom.stations(lambda index: index if index < len(design.rows) else None, stop,
                                             design.rows[0].thickness)
        design.findings += self.zoom.findings()
        if design.stations and self.image_is_solved:
            design.solves.append(Solve(len(design.rows) - 2, "image"))
            design.found(Kind.POSITION, "PIM: the back focus of each position is that of its paraxial image")
        return design.lens()

    def command(self, line: int, words: list[str]) -> None:
        """Process one command. RowError: invalid, or not traced."""
        key, values = words[0], words[1:]
        if self.private:
            return self.glass_definition(key, words, values)
        if key == "ZOO":
            return self.zoomed(line, values)
        place = next((i for i, word in enumerate(values[:3]) if re.fullmatch(r"(?ai)z[1-9]\d{0,3}", word)), None)
        if place is not None:                       # of one position
            return self.one_position(line, key, values[:place], int(values[place][1:]), values[place + 1:])
        surface = re.fullmatch(r"S(O|I|\d{1,4})?", key, re.ASCII)
        if surface:
            return self.surface(line, surface[1] or "", values)
        if key == "PRV":
            self.private = True
        elif key in ("TIT", "TITLE"):
            self.design.name = " ".join(values).strip("'\" ")
        elif key in SYSTEM:
            self.system_data(key, values)
        elif key == "DIM":
            unit = (values or ["M"])[0].upper()
            if unit not in UNITS:
                raise RowError(f"{unit}: lengths must be in M (mm), C (cm) or I (inches)")
            self.design.unit = UNITS[unit]
        elif self.design.rows:
            self.surface_command(line, key, values)
        return None

    def system_data(self, key: str, values: list[str]) -> None:
        """Store the numbers of a command for fields, wavelengths or the aperture; F2 or W2 names the one to set."""
        place = re.fullmatch(r"(?ai)[fw]([1-9]\d?)", values[0]) if values else None
        if place is None:
            self.system[key] = [_plain(word, key) for word in values]
            return
        row = self.system.setdefault(key, [])
        row += ["1" if key.startswith("WT") else "0"] * (int(place[1]) - len(row))
        row[int(place[1]) - 1] = _plain(first_word(values[1:]), key)

    def zoomed(self, line: int, values: list[str]) -> None:
        """Process ZOO: the number of positions, or the values of a quantity at each position."""
        if values and is_number(values[0]):
            self.zoom.count = int(first_number(values))
            return
        if not values or values[0].upper() in ("TIT", *HARMLESS):
            return
        qualified = 1 + sum(re.fullmatch(r"(?ai)[sfw](\d{1,4}|o|i|s)", word) is not None for word in values[1:2])
        for k, value in enumerate(values[qualified:], start=1):
            self.one_position(line, values[0].upper(), values[1:qualified], k, [value])

    def one_position(self, line: int, key: str, where: list[str], k: int, values: list[str]) -> None:
        """Store a quantity at position k; the value of the first position applies to the lens."""
        if key in ("TIT", "TITLE"):
            self.zoom.names[k] = " ".join(values).strip("'\" ")
            return
        if key in codev_system.APERTURES:
            self.zoom.put("aperture", 0, k, first_number(values))
        index = self.qualified(where[0]) if where else len(self.design.rows) - 1
        kept = index is not None and 0 <= index < len(self.design.rows) and values and is_number(values[0])
        if key == "THI" and kept:
            self.zoom.put("gap", index or 0, k, first_number(values, infinite=True))
        elif key == "CIR" and kept and self.design.rows[index or 0].is_stop:
            self.zoom.put("stop", index or 0, k, first_number(values))
        elif key not in HARMLESS and key not in codev_system.APERTURES:
            self.zoom.differs(" ".join([key, *where]), " ".join(values))
        if k == 1:
            self.command(line, [key, *where, *values])

    def qualified(self, word: str) -> int | None:
        """Surface that a qualifier names (S3, SO object, SI image, SS stop); None if it names none."""
        named = re.fullmatch(r"(?ai)s(o|i|s|\d{1,4})", word)
        if named is None:
            return None
        rows, where = self.design.rows, named[1].upper()
        stop = next((i for i, row in enumerate(rows) if row.is_stop), 1)
        return {"O": 0, "I": len(rows) - 1, "S": stop}.get(where, int(where) if where.isdigit() else 0)

    def surface(self, line: int, label: str, values: list[str]) -> None:
        """Process S radius thickness glass: the next surface, or the named one."""
        self.design.add(Row(line))
        row = self.design.rows[-1]
        if label.isdigit() and int(label) != len(self.design.rows) - 1:
            raise RowError(f"S{label} is out of order: the next surface is S{len(self.design.rows) - 1}")
        if values:
            row.curvature = self.bend(values[0])
        if len(values) > 1:
            row.thickness = file_number(values[1], "thickness", infinite=True)
        if len(values) > 2:
            self.set_glass(row, values[2:])

    def surface_command(self, line: int, key: str, values: list[str]) -> None:
        """Process a command for the current surface, or for the surface of its qualifier."""
        rows = self.design.rows
        index = len(rows) - 1
        span = re.fullmatch(r"(?a)([A-Za-z0-9]+)\.\.([A-Za-z0-9]+)", values[0]) if values else None
        if span is not None:
            first, last = (self.qualified(word if word[0] in "sS" else f"S{word}") for word in span.groups())
            if first is None or last is None or first > last:
                raise RowError(f"{excerpt(values[0])} is no range of surfaces, such as S1..3")
            for each in range(first, last + 1):
                self.surface_command(line, key, [f"S{each}", *values[1:]])
            return
        if values:
            named = self.qualified(values[0])
            if named is not None:
                index, values = named, values[1:]
        if not 0 <= index < len(rows):
            if key not in HARMLESS:
                raise RowError(f"there is no surface {index}")
            return
        row = rows[index]
        if key == "RDY":
            row.curvature = file_curvature(first_word(values))
        elif key == "CUY":
            row.curvature = first_number(values)
        elif key == "THI":
            if values and values[0].upper() not in ("HMY", "PUY", "UMY"):       # solves: the S line has the value
                row.thickness = first_number(values, infinite=True)
        elif key == "GLA":
            self.set_glass(row, values)
        elif key in ("STO", "STOP"):
            for other in rows:
                other.is_stop = False
            row.is_stop = True
        elif key == "K":
            row.conic = first_number(values)
        elif key in TERMS:
            row.aspheric[TERMS[key]] = first_number(values)
            if row.aspheric[TERMS[key]] == 0.0:
                del row.aspheric[TERMS[key]]
        elif key in ("CYL", "YTO", "XTO", "AAS"):
            self.biconic.add(index)
            row.curvature_x = row.curvature_x or 0.0 if key != "AAS" else row.curvature
            row.toroid = {"YTO": "torus", "XTO": "torus about x"}.get(key, "biconic")
        elif key in ("CUX", "RDX"):
            word = first_word(values)
            row.curvature_x = file_number(word, key) if key == "CUX" else file_curvature(word)
            self.biconic.add(index)
        elif key == "CIR":
            self.rim(index, row, values)
        elif key == "PIM":
            self.image_is_solved = True
        elif key in codev_tilts.KEYS:
            self.tilts.setdefault(index, codev_tilts.Tilt(line)).values[key] = first_number(values)
        elif key in codev_tilts.KINDS:
            self.tilts.setdefault(index, codev_tilts.Tilt(line)).kind = key
        elif key in REFUSED:
            self.refuse_unless_zero(index, key, values)
        elif key in SIDED:
            self.design.found(Kind.LEFT_OUT, f"S{index}: {SIDED[key]} ({key}) is left out", index - 1)
        elif key in ("KX", "KY", "AR", "BR", "AP", "BP") and any(map(is_number, values)) and first_number(values):
            raise RowError(f"S{index} has a biconic asphere, which is not traced")
        elif key not in HARMLESS and key not in ("KX", "KY", "AR", "BR", "AP", "BP"):
            self.design.not_read(key, line)

    def refuse_unless_zero(self, index: int, key: str, values: list[str]) -> None:
        """Raise RowError for a feature that is not traced, unless its value is 0."""
        if key not in HARMLESS_ALONE and values and all(is_number(word) for word in values) \
                and not any(file_number(word, key) for word in values):
            return
        raise RowError(f"S{index} has {REFUSED[key]}, which is not traced")

    def rim(self, index: int, row: Row, values: list[str]) -> None:
        """Process CIR [CLR|EDG|OBS|HOL] semi-diameter."""
        qualifier = next((word.upper() for word in values if not is_number(word) and word[0] not in "'\"Ll"), "")
        if qualifier not in ("", "CLR", "EDG", "OBS", "HOL"):
            raise RowError(f"{excerpt(qualifier)} is not read: a rim is CLR, EDG, OBS or HOL")
        sizes = [file_number(word, "CIR") for word in values if is_number(word)]
        if not sizes:
            raise RowError("a semi-diameter is missing")
        if qualifier == "OBS":
            self.design.found(Kind.LEFT_OUT, f"S{index}: a central obscuration (CIR OBS) is left out", index - 1)
        elif qualifier == "HOL":
            self.design.found(Kind.LEFT_OUT, f"S{index}: a central hole (CIR HOL) is left out", index - 1)
        elif sizes[0] <= 0.0:
            raise RowError(f"semi-diameter is {significant(sizes[0])}: it must be positive")
        elif qualifier == "EDG":
            self.edges[index] = sizes[0]
        else:
            row.semi_diameter = sizes[0]

    def set_glass(self, row: Row, words: list[str]) -> None:
        """Set the medium after a surface."""
        name = words[0].strip("'\"") if words else ""
        if name.upper() in media.MIRROR_NAMES:
            raise RowError(f"S{len(self.design.rows) - 1} is a mirror ({name.upper()}): only lenses are traced")
        if name.upper() in self.glasses:
            row.glass = self.glasses[name.upper()]
            return
        coded = media.code(name) if name else AIR
        if coded is not None:
            row.glass = coded
            return
        if is_number(name):
            row.glass = media.model(file_number(name, "index"), 0.0)
            return
        glass, _, maker = (name, "", "") if glass_catalogue.makers(name) else name.partition("_")
        row.glass, assumed = media.named(glass, maker or None)
        self.design.assume_glass(assumed)

    def glass_definition(self, key: str, words: list[str], values: list[str]) -> None:
        """Process a line between PRV and END: wavelengths (nm) with indices of a glass, or a Laurent series."""
        if key == "END":
            self.private = False
        elif key == "PWL":
            self.wavelengths = [_micrometres(word) for word in values]
        elif values and media.code(words[0].strip("'\"")) is None:     # a code says n_d and V_d itself
            name = words[0].strip("'\"")
            kind = values[0].upper()
            if kind in ("LAU", "GMS", "GML", "HAR", "CAU", "SEL") or not is_number(values[0]):
                self.design.found(Kind.GLASS, f"the private glass {name} is given by a formula ({kind}), which is not "
                                              "read")
                return
            indices = [file_number(word, "index") for word in values]
            points = sorted({w: n for w, n in zip(self.wavelengths, indices, strict=False) if w > 0.0}.items())
            self.glasses[name.upper()] = media.tabulated(name, points)

    def bend(self, word: str) -> float:
        """Curvature of the first value of an S line."""
        return file_curvature(word) if self.radii else file_number(word, "curvature")


def _plain(word: str, key: str) -> str:
    """A number in Python's notation, with the digits of the file. RowError: no number."""
    file_number(word, key)
    return plain_number(word)


def _micrometres(word: str) -> float:
    """Wavelength in µm from the digits of one in nm; 0, which no glass has, for one near 0."""
    return float(Decimal(plain_number(word)).scaleb(-3)) if file_number(word, "PWL") else 0.0
