"""Surfaces of a CODE V sequence file (.seq): S lines, and the commands for a surface or a range of surfaces.

Decentres and tilts of CODE V surfaces.

XDE, YDE and ZDE are lengths of the file; ADE and BDE turn about x and y, left-handed, and CDE about z, right-handed, in
degrees. The decentre comes first, then ADE, BDE and CDE, each about an axis that the ones before have turned.

Media of a CODE V sequence file (.seq): glasses of catalogues, codes, indices, and private glasses.

    PRV                         private glasses until END
    PWL 656.3 587.6 486.1       wavelengths (nm)
    'MYGLASS' 1.51 1.52 1.53    index at each of them
    END

Private glasses that are given by a formula are not read.
"""

import re
from dataclasses import dataclass, field
from decimal import Decimal
from math import radians

from lensbench.core.optics.finding import Kind
from lensbench.core.optics.glass import AIR, Glass
from lensbench.core.text import excerpt, significant
from lensbench.lenses.file_error import LensFileError, RowError, not_understood
from lensbench.lenses.glass import catalogue, media
from lensbench.lenses.tables.axes import Break, intrinsic
from lensbench.lenses.tables.design import Design, Row
from lensbench.lenses.tables.row_solves import RowSolve
from lensbench.lenses.tables.text import file_curvature, file_number, first_number, first_word, is_number, plain_number

KEYS = ("XDE", "YDE", "ZDE", "ADE", "BDE", "CDE")
KINDS = ("DAR", "REV")      # of this surface alone; undone behind it. Without: for all surfaces from here on


@dataclass
class Tilt:
    """The commands of a surface. line: of the first one."""

    line: int
    values: dict[str, float] = field(default_factory=dict)
    kind: str = ""


def place(design: Design, index: int, tilt: Tilt) -> None:
    """Give a row of the design its decentre and tilt; LensFileError for object and image."""
    x, y, z, a, b, c = (tilt.values.get(key, 0.0) for key in KEYS)
    if not any((x, y, z, a, b, c)):
        return
    if index in (0, len(design.rows) - 1):
        raise LensFileError(design.path, tilt.line, f"S{index}: a tilt or decentre of the object or of the image is "
                                                    "not traced")
    row, axes = design.rows[index], intrinsic(-radians(a), -radians(b), radians(c))
    if tilt.kind == "DAR":
        row.aside = Break((x, y, z), axes, line=tilt.line)
    elif tilt.kind == "REV":
        row.behind = Break((-x, -y, -z), axes.T, True, line=tilt.line)
    else:
        row.breaks.append(Break((x, y, z), axes, line=tilt.line))


class Glasses:
    """The private glasses so far, and the media that the names in a file mean."""

    def __init__(self, design: Design):
        self.design = design
        self.is_open = False                    # whether a definition (PRV) has not ended yet
        self.wavelengths: list[float] = []      # µm
        self.private: dict[str, Glass] = {}

    def define(self, key: str, words: list[str], values: list[str]) -> None:
        """Process a line between PRV and END: the wavelengths (nm), or the indices of a glass at them."""
        if key == "END":
            self.is_open = False
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
            self.private[name.upper()] = media.tabulated(name, points)

    def medium(self, words: list[str]) -> Glass:
        """Medium after the current surface. RowError: a mirror, or a glass in no catalogue."""
        name = words[0].strip("'\"") if words else ""
        if name.upper() in media.MIRROR_NAMES:
            raise RowError(f"S{len(self.design.rows) - 1} is a mirror ({name.upper()}): only lenses are traced")
        if name.upper() in self.private:
            return self.private[name.upper()]
        coded = media.code(name) if name else AIR
        if coded is not None:
            return coded
        if is_number(name):
            return media.model(file_number(name, "index"), 0.0)
        glass, _, maker = (name, "", "") if catalogue.makers(name) else name.partition("_")
        return media.glass_in(self.design, glass, maker or None)


def _micrometres(word: str) -> float:
    """Wavelength in µm from the digits of one in nm; 0, which no glass has, for one near 0."""
    return float(Decimal(plain_number(word)).scaleb(-3)) if file_number(word, "PWL") else 0.0


TERMS = {letter: 4 + 2 * i for i, letter in enumerate("ABCDEFGHJ")}     # A r⁴ … H r¹⁸, J r²⁰; there is no I
REFUSED = {
    "BEN": "a mirror bend", "RET": "a return of axes", **dict.fromkeys(("XOD", "YOD", "ZOD"), "a pivot of its own"),
    "GLB": "global coordinates", "DIF": "a diffraction grating or diffractive element", "GRT": "a grating",
    "GRO": "a grating", "HOE": "a hologram", "NSS": "a non-sequential group", "SPS": "a special surface",
    "SPL": "a spline", "USR": "a surface of the user", "FRN": "a Fresnel surface",
    "LMO": "an ideal lens", "MOD": "an ideal lens", "GRN": "a gradient index", "IMG": "an ideal lens",
    "MFL": "an ideal lens",
}
# Controls of an optimisation; labels, colours, what the program is to show; substrates of mirrors, Fresnel bases;
# kinds of surfaces that their coefficients tell; tolerances
HARMLESS = frozenset("""
    CCY CCX THC GLC GLN GLD KC AC BC CC DC EC FC GC HC JC ADC BDC CDC XDC YDC ZDC CIN CNS CUN
    SLB CLS COM INI GO END LEN RDM CA CWL WID POL DDM UID DER MIR CUM THM CUF RFP ASP CON SPH
    DLF DLS DLR DLC DLT DLN DLV DLA DLB DLG DLM DLX DLY DLZ DLP DLQ DLK DLH TRX TRY TRZ TIL BTX BTY BTI TIR DIS DSX DSY
    DSZ ROL IRR HOM CYD CYN INV
""".split())
COATINGS = ("MLT", "COA")
SOLVES = {"HMY": "axial height", "HCY": "chief height", "UMY": "axial slope", "UCY": "chief slope"}
QUANTITIES = {"RDY": "curvature", "CUY": "curvature", "THI": "thickness", "K": "conic"}     # of solves and pickups
REFRACTED = ("REFR", "REFRACT")
HARMLESS_ALONE = ("BEN", "RET")       # commands without a value
SIDED = {"REX": "a rectangular aperture", "REY": "a rectangular aperture", "ELX": "an elliptical aperture",
         "ELY": "an elliptical aperture", "ADX": "a decentred aperture", "ADY": "a decentred aperture"}


class Surfaces:
    """The surfaces so far, of which the last is the current one.

    radii: whether the first number of an S line is a radius; else it is a curvature.
    """

    def __init__(self, design: Design, radii: bool):
        self.design, self.radii = design, radii
        self.glasses = Glasses(design)
        self.edges: dict[int, float] = {}
        self.biconic: set[int] = set()
        self.tilts: dict[int, Tilt] = {}
        self.image_is_solved = False            # PIM: the last thickness puts the image plane at the paraxial image

    def complete(self) -> None:
        """Apply what later commands may still have changed: edges and tilts. LensFileError: a surface not traced."""
        design = self.design
        defocus = design.unit * design.rows[-1].thickness
        if defocus:
            design.found(Kind.LEFT_OUT, f"the thickness of the image surface, a defocus of {significant(defocus)} mm, "
                                        "is left out: the film stands where the lens is focused")
        for index, row in enumerate(design.rows):
            if row.semi_diameter is None and index in self.edges:
                row.semi_diameter = self.edges[index]
            if index in self.biconic and (row.conic or row.aspheric):
                raise LensFileError(design.path, row.line, f"S{index} is curved in two sections and has a conic or "
                                                           "aspheric terms: not traced")
        for index, tilt in self.tilts.items():
            place(design, index, tilt)

    def qualified(self, word: str) -> int | None:
        """Surface that a qualifier names (S3, SO object, SI image, SS stop); None if it names none."""
        named = re.fullmatch(r"(?ai)s(o|i|s|\d{1,4})", word)
        if named is None:
            return None
        rows, where = self.design.rows, named[1].upper()
        stop = next((i for i, row in enumerate(rows) if row.is_stop), 1)
        return {"O": 0, "I": len(rows) - 1, "S": stop}.get(where, int(where) if where.isdigit() else 0)

    def add(self, line: int, label: str, values: list[str]) -> None:
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
            row.glass = self.glasses.medium(values[2:])
        for word in values[3:]:
            self.refracts(word)

    def refracts(self, word: str) -> None:
        """Raise RowError unless a mode of refraction is the usual one."""
        if word.upper() not in REFRACTED:
            raise RowError(f"S{len(self.design.rows) - 1}: {excerpt(word)} is no refraction: only lenses are traced")

    def pick_up(self, words: list[str]) -> None:
        """Process PIK: quantity, surface, quantity, surface, factor and offset; keep it for a check."""
        words = [word for word in words if not re.fullmatch(r"(?ai)z\d+", word)]
        numbers = [file_number(word, "PIK") for word in words[4:]]
        row, source = (self.qualified(word) for word in (words[1:2] + words[3:4] + ["", ""])[:2])
        if row is None or source is None or max(row, source) >= len(self.design.rows):
            raise RowError(not_understood(f"PIK {' '.join(words)}"))
        quantity, factor, offset = QUANTITIES.get(words[0].upper(), ""), *(numbers + [1.0, 0.0][len(numbers):])[:2]
        is_radius = words[0].upper() == "RDY"
        known = quantity and words[0].upper() == words[2].upper() and (not is_radius or factor and not offset)
        self.keep(row, quantity or "thickness", "pickup" if known else "other", offset, f"PIK {words[0]}", source,
                  1.0 / factor if known and is_radius else factor)

    def keep(self, row: int, quantity: str, rule: str, value: float, name: str, source: int = 0,
             factor: float = 1.0) -> None:
        """Keep a solve, whose value the file states, for a check."""
        if row:
            self.design.checked.append(RowSolve(row, quantity, rule, value, name, source, factor))

    def command(self, line: int, key: str, values: list[str]) -> None:
        """Process a command for the current surface, or for the surface of its qualifier."""
        rows = self.design.rows
        index = len(rows) - 1
        span = re.fullmatch(r"(?a)([A-Za-z0-9]+)\.\.([A-Za-z0-9]+)", values[0]) if values else None
        if span is not None:
            first, last = (self.qualified(word if word[0] in "sS" else f"S{word}") for word in span.groups())
            if first is None or last is None or first > last:
                raise RowError(f"{excerpt(values[0])} is no range of surfaces, such as S1..3")
            for i in range(first, last + 1):
                self.command(line, key, [f"S{i}", *values[1:]])
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
        if key in ("RDY", "CUY", "THI") and values and values[0][:1].isalpha() and values[0].upper() != "INFINITY":
            number = file_number(values[1], key) if len(values) > 1 and is_number(values[1]) else 0.0
            rule = SOLVES.get(values[0].upper(), "other")       # the S line has the value
            self.keep(index, QUANTITIES[key], rule, number, f"{key} {values[0]}")
        elif key == "RDY":
            row.curvature = file_curvature(first_word(values))
        elif key == "CUY":
            row.curvature = first_number(values)
        elif key == "THI":
            row.thickness = first_number(values, infinite=True)
        elif key == "GLA":
            row.glass = self.glasses.medium(values)
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
        elif key in KEYS:
            self.tilts.setdefault(index, Tilt(line)).values[key] = first_number(values)
        elif key in KINDS:
            self.tilts.setdefault(index, Tilt(line)).kind = key
        elif key in REFUSED:
            self.refuse_unless_zero(index, key, values)
        elif key in SIDED:
            self.design.found(Kind.LEFT_OUT, f"S{index}: {SIDED[key]} ({key}) is left out", index - 1)
        elif key in ("KX", "KY", "AR", "BR", "AP", "BP") and any(map(is_number, values)) and first_number(values):
            raise RowError(f"S{index} has a biconic asphere, which is not traced")
        elif key in COATINGS:
            self.design.found(Kind.LEFT_OUT, f"coatings ({key}) are left out")
        elif key == "RMD":
            self.refracts(first_word(values))
        elif key not in HARMLESS and key not in ("KX", "KY", "AR", "BR", "AP", "BP"):
            raise RowError(not_understood(key))

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
            raise RowError(f"{excerpt(qualifier)} is not read: an aperture is CLR, EDG, OBS or HOL")
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

    def bend(self, word: str) -> float:
        """Curvature of the first value of an S line."""
        return file_curvature(word) if self.radii else file_number(word, "curvature")
