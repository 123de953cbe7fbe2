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
its name). Mirrors and gratings are refused, and tilts that do not return (`codev_surfaces`).

    EPD 10                      entrance-pupil diameter; FNO f-number of the image, NAO, NA numerical aperture of the
                                object and of the image; for a near object FNO is the f-number at work
    WL 656.3 587.6 486.1        wavelengths (nm); WTW their weights, REF the number of the primary one
    YAN 0 10 14                 fields by angle; YOB by object height, YIM and YRI by paraxial and real image height; X…
    WTF 1 1 1                   their weights
    VUY 0 0.1 0.2               share of the pupil cut off at +y; VLY at −y, VUX at +x, VLX at −x
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from decimal import Decimal
from math import isfinite

from lensbench.core.optics.finding import Kind, Severity, note
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import Aperture, ApertureKind, FieldKind, SystemData
from lensbench.lenses.file_error import LensFileError, RowError, located, not_understood
from lensbench.lenses.formats.codev_surfaces import HARMLESS, Surfaces
from lensbench.lenses.tables import stations as configurations
from lensbench.lenses.tables.aperture import f_number_kind
from lensbench.lenses.tables.design import Design
from lensbench.lenses.tables.stations import Solve
from lensbench.lenses.tables.text import (
    EXACT, check_lines, exact, file_number, first_number, first_word, is_number, plain_number
)

UNITS = {"M": 1.0, "MM": 1.0, "C": 10.0, "CM": 10.0, "I": 25.4, "IN": 25.4}
MERCURY = 760.0         # mm, of one atmosphere
ASIDE = {"AFI": "afocal image space", "TEL": "telecentric in the object's space"}


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
    assumed = note(Kind.CONVENTION, f"the file does not state whether it has radii or curvatures (RDM): read as {what}")
    return replace(lens, findings=(assumed, *lens.findings))


def _statements(text: str) -> list[tuple[int, list[str]]]:
    """The words of each command, quoted texts kept whole with their quotes, and its line."""
    statements: list[tuple[int, list[str]]] = []
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
                statements += [(start, words)] if words else []
                words = []
            else:
                words.append(token)
        if not going_on and words:
            statements.append((start, words))
            words = []
    if words:
        statements.append((start, words))
    return [(line, [words[0] if words[0][0] in "'\"" else words[0].upper(), *words[1:]]) for line, words in statements]


class _Sequence:
    """State of a file being read: its surfaces, zoom positions and system data so far."""

    def __init__(self, path: str, radii: bool):
        self.path, self.design = path, Design(path)
        self.surfaces = Surfaces(self.design, radii)
        self.zoom = configurations.Configurations()
        self.system: dict[str, list[str]] = {}
        self.air = {"TEM": 22.0, "PRE": MERCURY}         # °C, mm of mercury

    def run(self, statements: list[tuple[int, list[str]]]) -> Lens:
        """The lens after all commands."""
        for line, words in statements:
            with located(self.path, line, f"{words[0]}: "):
                self.command(line, words)
        design = self.design
        if not design.rows:
            raise LensFileError(self.path, None, "there are no surfaces (SO, S, SI): this is no CODE V lens")
        self.surfaces.complete()
        read_system(design, self.system)
        design.state_air(self.air["TEM"], self.air["PRE"] / MERCURY)
        if not any(row.is_stop for row in design.rows) and len(design.rows) > 1:
            design.rows[1].is_stop = True
            design.found(Kind.NO_STOP, "no stop is marked (STO): surface 0, as CODE V assumes",
                         severity=Severity.WARNING)
        stop = next((i for i, row in enumerate(design.rows) if row.is_stop), None)
        design.stations = self.zoom.stations(lambda index: index if index < len(design.rows) else None, stop,
                                             design.rows[0].thickness)
        design.findings += self.zoom.findings()
        if self.surfaces.image_is_solved and len(design.rows) > 2:
            self.surfaces.keep(len(design.rows) - 2, "thickness", "axial height", 0.0, "PIM")
        if design.stations and self.surfaces.image_is_solved:
            design.solves.append(Solve(len(design.rows) - 2, "image"))
            design.found(Kind.POSITION, "PIM: the back focus of each position is that of its paraxial image")
        return design.lens()

    def command(self, line: int, words: list[str]) -> None:
        """Process one command. RowError: invalid, or not traced."""
        key, values = words[0], words[1:]
        if self.surfaces.glasses.is_open:
            return self.surfaces.glasses.define(key, words, values)
        if key == "PIK":
            return self.surfaces.pick_up(values)
        if key == "ZOO":
            return self.zoomed(line, values)
        zoom_word = next((i for i, word in enumerate(values[:3]) if re.fullmatch(r"(?ai)z[1-9]\d{0,3}", word)), None)
        if zoom_word is not None:                       # of one position
            return self.one_position(line, key, values[:zoom_word], int(values[zoom_word][1:]), values[zoom_word + 1:])
        surface = re.fullmatch(r"S(O|I|\d{1,4})?", key, re.ASCII)
        if surface:
            return self.surfaces.add(line, surface[1] or "", values)
        if key == "PRV":
            self.surfaces.glasses.is_open = True
        elif key in ("TIT", "TITLE"):
            self.design.name = " ".join(values).strip("'\" ")
        elif key in SYSTEM:
            self.system_data(key, values)
        elif key in self.air:
            self.air[key] = first_number(values)
        elif key == "DIM":
            unit = (values or ["M"])[0].upper()
            if unit not in UNITS:
                raise RowError(f"{unit}: lengths must be in M (mm), C (cm) or I (inches)")
            self.design.unit = UNITS[unit]
        elif key in ASIDE:
            if (values or ["Y"])[0].upper() not in ("N", "NO"):
                self.design.found(Kind.LEFT_OUT, f"{ASIDE[key]} ({key}) is left out")
        elif self.design.rows:
            self.surfaces.command(line, key, values)
        elif key not in HARMLESS:
            raise RowError(not_understood(key))
        return None

    def system_data(self, key: str, values: list[str]) -> None:
        """Store the numbers of a command for fields, wavelengths or the aperture; F2 or W2 names the one to set."""
        qualifier = re.fullmatch(r"(?ai)[fw]([1-9]\d?)", values[0]) if values else None
        if qualifier is None:
            self.system[key] = [_plain(word, key) for word in values]
            return
        row = self.system.setdefault(key, [])
        row += ["1" if key.startswith("WT") else "0"] * (int(qualifier[1]) - len(row))
        row[int(qualifier[1]) - 1] = _plain(first_word(values[1:]), key)

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
        if key in APERTURES:
            self.zoom.put("aperture", 0, k, first_number(values))
        index = self.surfaces.qualified(where[0]) if where else len(self.design.rows) - 1
        kept = index is not None and 0 <= index < len(self.design.rows) and values and is_number(values[0])
        if key == "THI" and kept:
            self.zoom.put("gap", index or 0, k, first_number(values, infinite=True))
        elif key == "CIR" and kept and self.design.rows[index or 0].is_stop:
            self.zoom.put("stop", index or 0, k, first_number(values))
        elif key not in HARMLESS and key not in APERTURES:
            self.zoom.differs(" ".join([key, *where]), " ".join(values))
        if k == 1:
            self.command(line, [key, *where, *values])


def _plain(word: str, key: str) -> str:
    """A number in Python's notation, with the digits of the file. RowError: no number."""
    file_number(word, key)
    return plain_number(word)


APERTURES = {"EPD": ApertureKind.PUPIL_DIAMETER, "FNO": ApertureKind.F_NUMBER, "NAO": ApertureKind.OBJECT_NA,
             "NA": ApertureKind.IMAGE_NA}
FIELDS = {"AN": FieldKind.ANGLE, "OB": FieldKind.OBJECT_HEIGHT, "IM": FieldKind.IMAGE_HEIGHT,
          "RI": FieldKind.REAL_IMAGE_HEIGHT}
VIGNETTING = ("VUX", "VLX", "VUY", "VLY")
SYSTEM = frozenset((*APERTURES, *(axis + name for axis in "XY" for name in FIELDS), *VIGNETTING, "WL", "WTW", "REF",
                    "WTF"))


def read_system(design: Design, values: Mapping[str, Sequence[str]]) -> None:
    """Give the design, whose rows are complete, the system data of a file: numbers in text, by command."""
    for key, kind in APERTURES.items():
        if values.get(key):
            design.state_aperture(f_number_kind(design.rows[0].thickness) if key == "FNO" else kind,
                                  float(values[key][0]))
    lengths = [float(Decimal(word).scaleb(-3, EXACT)) for word in values.get("WL", ())]
    weights = [float(word) for word in values.get("WTW", ())]
    reference = float((values.get("REF") or ["1"])[0])
    if lengths:
        design.state_wavelengths([(w, weights[i] if i < len(weights) else 1.0) for i, w in enumerate(lengths)],
                                 int(max(min(reference, 1e6), 0.0)) - 1)
    name = next((name for name in FIELDS if values.get(f"X{name}") or values.get(f"Y{name}")), None)
    if name is None:
        return
    columns = [[float(word) for word in values.get(key, ())] for key in (f"X{name}", f"Y{name}", "WTF", *VIGNETTING)]
    points = []
    for i in range(max(len(columns[0]), len(columns[1]))):
        x, y, weight, *cuts = [column[i] if i < len(column) else float(k == 2) for k, column in enumerate(columns)]
        points += design.field_point(x, y, weight, (cuts[0], cuts[1], cuts[2], cuts[3]))
    design.state_fields(FIELDS[name], points)


def aperture_key(kind: ApertureKind) -> str:
    """Command of an aperture."""
    if kind is ApertureKind.WORKING_F_NUMBER:
        return "FNO"
    return next(key for key, own in APERTURES.items() if own is kind)


def system_lines(system: SystemData, aperture: Aperture | None) -> list[str]:
    """Lines of the system data; the aperture is of a kind that the format holds, its first value is written."""
    waves = [str(EXACT.normalize(exact(w.micrometres).scaleb(3, EXACT))) for w in system.wavelengths]
    written = [f"WL {' '.join(waves)}", f"WTW {' '.join(repr(w.weight) for w in system.wavelengths)}",
               f"REF {system.primary + 1}"]
    if aperture is not None and isfinite(aperture.values[0]):
        written.append(f"{aperture_key(aperture.kind)} {aperture.values[0]!r}")
    name = next(name for name, kind in FIELDS.items() if kind is system.field_kind)
    columns = {f"X{name}": [p.x for p in system.fields], f"Y{name}": [p.y for p in system.fields],
               "WTF": [p.weight for p in system.fields]}
    if any(any(point.vignetting) for point in system.fields):
        columns |= {key: [point.vignetting[i] for point in system.fields] for i, key in enumerate(VIGNETTING)}
    return written + [" ".join([key, *map(repr, column)]) for key, column in columns.items()]
