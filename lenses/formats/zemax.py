"""Zemax lens files (.zmx): sequential lenses of rotationally symmetric surfaces, cylinders and toroids.

    UNIT MM X W X CM MR CPMM
    ENPD 10
    SURF 1
      STOP
      TYPE EVENASPH
      CURV 0.05
      PARM 2 1.2E-5             coefficient of r⁴ (PARM 1: of r²)
      DISZ 3.5                  to the next surface
      GLAS N-BK7 0 0 1.5168 64.17
      CONI -1
      DIAM 8                    a radius, in spite of its name

Surface 0 is the object, the last one the image. The flag behind a glass is 0 for a
catalogue glass (the numbers that follow are then meaningless), 1 for a model of n_d
and V_d, 2 for a pick-up of another surface's glass. The surfaces are followed by
MNUM configurations:

    THIC 4 2 12.5 0 0 0 1 1 1 0 0 "" 0      the gap behind surface 4 in configuration 2

SDIA is a semi-diameter, LTTL a name. Mirrors, gratings, every surface that is
neither a body of revolution nor a toroid, and coordinate breaks (COORDBRK) that
do not return before the image are refused.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf, radians

from lensbench.core.optics.finding import Kind, Severity
from lensbench.core.optics.glass import Glass
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant
from lensbench.lenses.file_error import LensFileError, RowError, located, not_understood
from lensbench.lenses.formats import zemax_system
from lensbench.lenses.formats.zemax_system import number_in
from lensbench.lenses.glass import media
from lensbench.lenses.tables import stations as configurations
from lensbench.lenses.tables.axes import Break, intrinsic
from lensbench.lenses.tables.design import Design, Row
from lensbench.lenses.tables.row_solves import RowSolve
from lensbench.lenses.tables.stations import Solve
from lensbench.lenses.tables.text import file_curvature, file_number

UNITS = {"MM": 1.0, "CM": 10.0, "IN": 25.4, "METER": 1000.0, "M": 1000.0}
SURFACES = ("STANDARD", "EVENASPH", "ODDASPHE", "XASPHERE", "XODDASPH", "TOROIDAL", "BICONICX")
REFUSED = {"COORDBRK": "a coordinate break of object or image", "DGRATING": "a diffraction grating",
           "PARAXIAL": "an ideal lens without surfaces", "NONSEQCO": "a non-sequential group",
           "QED_TYPE": "a Q-type asphere", "BINARY_2": "a diffractive surface", "GRADIUM": "a gradient index",
           "TILTSURF": "a tilted surface", "FZERNSAG": "a Zernike surface", "SZERNSAG": "a Zernike surface"}
LEFTOVERS = {(0.0, 0.0), (1.0, 0.0), (1.5, 40.0), (1.55, 55.0)}     # meaningless beside a catalogue name
GLASS_COMMENT = "glass "                             # before the name of a model glass, which Zemax has none for
APERTURES = {
    "SQAP": "a rectangular aperture", "ELAP": "an elliptical aperture", "OBSC": "a central obscuration",
    "SQOB": "a rectangular obscuration", "ELOB": "an elliptical obscuration", "SPID": "a spider",
    **dict.fromkeys(("UDAP", "UDAD", "USAP"), "an aperture of free form"), "OBDC": "an aperture's decentre",
    "CLAP": "a central obscuration"}
# Of a quantity: keyword, rule, places of its value, source and factor among the words
SOLVES = {"MAZH": ("thickness", "axial height", 0, None, None), "CHZH": ("thickness", "chief height", 0, None, None),
          "MAZA": ("curvature", "axial slope", 0, None, None), "CHZA": ("curvature", "chief slope", 0, None, None),
          "PZUP": ("thickness", "pickup", 2, 0, 1), "CPUP": ("curvature", "pickup", 2, 0, 1),
          "CNUP": ("conic", "pickup", 2, 0, 1), "TOLE": ("thickness", "sum", 1, 0, None),
          "TCOM": ("thickness", "pair", 1, 0, None), "PPAR": ("curvature", "parameter", None, None, None),
          "PKUP": ("curvature", "other", None, None, None), "EDGE": ("thickness", "other", None, None, None)}
FREE = ("0", "1")                       # flags behind CURV: fixed, variable
READ = ("SURF", "TYPE", "CURV", "DISZ", "CONI", "STOP", "DIAM", "GLAS", "SCBD", "COAT", *APERTURES, *SOLVES)
# Comments and labels, drawing, mechanical rims, physical optics, scatter, coatings of mirrors, thermal data, variables
HARMLESS = frozenset("""
    COMM HIDE MIRR POPS FIMP SLAB SSID MEMA OEMA FLAP SCOL OPDX RSCE GLCZ TCED TCMM VDSZ VPAR VCON VCUR VDIA VGLA
""".split())
# Versions and authors, glass and coating files, ray aiming, polarisation, reference of the OPD, non-sequential
# settings, language, margins of rims, thermal scaling, stock numbers
HARMLESS_HEADER = frozenset("""
    VERS AUTH NAME NOTE LANG PFIL GFAC GSTD NSCD COFN RAIM PUSH SDMA OMMA ROPD HYPR PICB POLS GLRS DBDT EERA IWDP LUID
    STUD TOL DMFS
""".split())
HEADER = frozenset("MODE UNIT GCAT PWAV WAVM WAVL WAVN WWGT WWGN FTYP AFOC ENVD VANN ZVAN".split())
FIRST = {"THIC": "DISZ", "CRVT": "CURV", "CONN": "CONI", "SDIA": "DIAM"}    # of the first configuration
# Quantities of configurations that change no surface: fields, wavelengths, weights, air
ASIDE = frozenset("WAVE WLWT PRWV XFIE YFIE FLWT FLTP FVDX FVDY FVCX FVCY FVAN TEMP PRES CWGT".split())
OPERAND = re.compile(r"[A-Z][A-Z0-9_]{3}( +-?[\d.]+([eE][+-]?\d+)?){7,}\s*")       # of the merit function
PARAMETERS = {"EVENASPH": range(1, 9), "ODDASPHE": range(1, 9), "TOROIDAL": range(1, 9), "BICONICX": range(1, 3)}
Values = dict[tuple[str, int], float]       # of PARM and XDAT, by their numbers
EVEN_POWERS = range(2, 17, 2)
ODD_POWERS = range(1, 9)
Entry = tuple[int, list[str]]                # line and words of a keyword


@dataclass
class _Block:
    """Keywords of a SURF block with their lines and words, and words of its PARM and XDAT by their numbers."""

    path: str
    index: int
    entries: dict[str, Entry]
    numbered: dict[tuple[str, int], tuple[int, str]] = field(default_factory=dict)

    def words(self, key: str) -> list[str]:
        """Those of a keyword; none where it is missing."""
        return self.entries.get(key, (0, []))[1]

    def value(self, key: str, column: int = 0, infinite: bool = False) -> float:
        """The number at this index among the words of a keyword. LensFileError: missing or invalid."""
        line, words = self.entries[key]
        return number_in(self.path, line, key, words, column, infinite)

    def parameter(self, n: int) -> float:
        """PARM n; 0 where it is missing."""
        line, word = self.numbered.get(("PARM", n), (0, "0"))
        return number_in(self.path, line, "PARM", [word], 0)

    @property
    def gap(self) -> float:
        """The distance behind a coordinate break."""
        return self.value("DISZ") if "DISZ" in self.entries else 0.0

    @property
    def kind(self) -> str:
        """Its TYPE; "" where it is missing."""
        return "".join(self.words("TYPE")[:1]).upper()


@dataclass
class _File:
    """A file as it is written: header, blocks of surfaces, notes and configurations."""

    path: str
    header: dict[str, Entry] = field(default_factory=dict)
    blocks: list[_Block] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    listed: configurations.Configurations = field(default_factory=configurations.Configurations)


def read(text: str, path: str) -> Lens:
    """The lens of a file's text. LensFileError names `path`, the line, the keyword and the mistake."""
    file, design = _scanned(text, path), Design(path)
    _read_header(design, file)
    row_of = _add_rows(design, file)
    listed, blocks = file.listed, file.blocks
    first = listed.first("aperture", 0)
    if first is not None and design.system.aperture is not None:
        design.state_aperture(design.system.aperture.kind, first)
    stop = next((block.index for block in blocks if "STOP" in block.entries), None)
    design.stations = listed.stations(row_of.get, stop, design.rows[0].thickness)
    if design.stations:
        for block in blocks[:-1]:
            design.solves += _solves(design, block, row_of, block.index == len(blocks) - 2)
    with located(path, None):
        listed.check(ASIDE | FIRST.keys())
    design.findings += listed.findings()
    for block in blocks[:-1]:
        _keep_solves(design, block, blocks, row_of)
    if listed.current != 1:                 # their thicknesses are those of another configuration
        design.checked = [solve for solve in design.checked if solve.quantity != "thickness"]
    return design.lens()


def _scanned(text: str, path: str) -> _File:
    """The file, keyword by keyword. LensFileError: no surfaces, or a keyword of the header that is not known."""
    file, in_table = _File(path), True
    header, blocks = file.header, file.blocks
    indented = re.search(r"(?m)^\s+CURV\b", text) is not None
    for line, content in enumerate(text.split("\n"), start=1):
        key, rest = (*content.split(None, 1), "", "")[:2]
        key, words = key.upper(), rest.split()
        if key == "SURF":
            blocks.append(_Block(path, len(blocks), {"SURF": (line, words)}))
        elif blocks and key == "MNUM":
            in_table = False
            file.listed.count = int(number_in(path, line, key, words, 0))
            file.listed.current = int(number_in(path, line, key, words, 1)) if len(words) > 1 else 1
        elif blocks and not in_table:
            _configure(file, line, key, words)
        elif blocks and (key in ("TOL", "BLNK") or (indented and OPERAND.fullmatch(content))):
            continue                                # tolerances, the merit function
        elif key == "NOTE":
            file.notes.append(rest.partition(" ")[2].strip())
        elif blocks and key in ("PARM", "XDAT"):
            index = number_in(path, line, key, words, 0)
            if len(words) > 1 and index == int(index):
                blocks[-1].numbered[key, int(index)] = (line, words[1])
        elif blocks and key:
            blocks[-1].entries.setdefault(key, (line, words))
        elif key == "WAVM" and words:
            header.setdefault(f"WAVM {words[0]}", (line, words))
        elif key:
            header.setdefault(key, (line, words if key != "NAME" else [rest]))
    if not blocks:
        raise LensFileError(path, None, "there are no surfaces (SURF): this is no Zemax lens")
    for key, (line, _) in header.items():
        if key.split()[0] not in HARMLESS_HEADER | HEADER | zemax_system.KEYS:
            raise LensFileError(path, line, not_understood(key))
    return file


def _add_rows(design: Design, file: _File) -> dict[int, int]:
    """Add the rows of the surfaces, and return them by the numbers of their blocks; coordinate breaks have none."""
    catalogues = [name.upper() for name in file.header.get("GCAT", (0, []))[1]]
    row_of: dict[int, int] = {}
    breaks: list[Break] = []                            # before the next surface
    last = len(file.blocks) - 1
    for block in file.blocks:
        i, is_break = block.index, block.kind == "COORDBRK" and 0 < block.index < last
        if is_break and ("gap", i) not in file.listed.values and not any(block.parameter(n) for n in range(1, 6)):
            design.rows[-1].thickness += block.gap
            design.found(Kind.LEFT_OUT, f"SURF {i}: a coordinate break that neither tilts nor moves anything is left "
                                        "out")
        elif is_break:
            breaks.append(_break(block))
            if "STOP" in block.entries:
                design.found(Kind.STOP, f"SURF {i}: the stop is marked on a coordinate break, which is no surface of "
                                        "the lens", severity=Severity.WARNING)
        elif block.kind == "PARAXIAL" and 1 < i == last - 1 and "STOP" not in block.entries \
                and design.rows[-1].glass.n_d == 1.0:
            row_of[i] = len(design.rows)
            design.rows[-1].thickness = inf
            design.found(Kind.LEFT_OUT, f"SURF {i}: the ideal lens (TYPE PARAXIAL) between the lens and its image is "
                                        "left out")
        else:
            row_of[i] = len(design.rows)
            design.add(_row(design, block, i == last, catalogues))
            design.rows[-1].breaks, breaks = breaks, []
    return row_of


def _break(block: _Block) -> Break:
    """A coordinate break: decentres x, y (PARM 1, 2), tilts about x, y, z (3 to 5, degrees), and their order (6)."""
    x, y, *tilts, order = map(block.parameter, range(1, 7))
    a, b, c = map(radians, tilts)
    turned = intrinsic(a, b, c) if order == 0.0 else intrinsic(0.0, 0.0, c) @ intrinsic(0.0, b) @ intrinsic(a, 0.0)
    return Break((x, y, 0.0), turned, order != 0.0, block.gap, block.entries["SURF"][0], block.index)


def _solves(design: Design, block: _Block, row_of: dict[int, int], is_last: bool) -> list[Solve]:
    """The solve of the gap behind a surface, as a list of none or one.

    TCOM i total (with the gap behind i), TOLE i total (with all gaps from i on), or MAZH 0 of the last gap (height of
    the marginal ray on the image).
    """
    row = row_of.get(block.index)
    if row is None:
        return []
    if is_last and "MAZH" in block.entries and block.value("MAZH") == 0.0:
        design.found(Kind.POSITION, "MAZH: the back focus of each position is that of its paraxial image")
        return [Solve(row, "image")]
    for key, kind in (("TCOM", "pair"), ("TOLE", "sum")):
        if key in block.entries:
            start = row_of.get(int(block.value(key)))
            if start is not None:
                return [Solve(row, kind, start, block.value(key, 1))]
    return []


def _keep_solves(design: Design, block: _Block, blocks: list[_Block], row_of: dict[int, int]) -> None:
    """Keep the solves and pickups of a surface, whose values the file states, for a check."""
    row = row_of.get(block.index)
    if not row:
        return
    words = block.words("CURV")
    if len(words) > 1 and words[1] not in FREE:
        rules = {"2": ("axial slope", 2, None, None), "3": ("chief slope", 2, None, None), "4": ("pickup", 4, 2, 3)}
        rule, *columns = rules.get(words[1], ("other", None, None, None))
        _keep(design, row, "curvature", rule, "CURV", block.entries["CURV"], columns, row_of)
    for key, (quantity, rule, *columns) in SOLVES.items():
        if key in block.entries:
            zone = len(block.words(key)) > 1 and key == "MAZH" and block.value(key, 1)      # of a real ray
            _keep(design, row, quantity, "other" if zone else rule, key, block.entries[key], columns, row_of)
    words = block.words("GLAS")
    if words[1:2] == ["2"] and len(words) > 2:
        source = int(min(abs(block.value("GLAS", 2)), 1e6))
        other = (blocks[source].words("GLAS") or ["air"]) if source < len(blocks) else ["no surface"]
        if other[:1] != words[:1]:
            design.found(Kind.UNSOLVED, f"SURF {block.index}: its glass {words[0]} is picked up from surface {source}, "
                                        f"which has {other[0]}: {words[0]} is read", severity=Severity.WARNING)


def _keep(design: Design, row: int, quantity: str, rule: str, key: str, entry: tuple[int | None, list[str]],
          columns: Sequence[int | None], row_of: dict[int, int]) -> None:
    """Keep one solve; columns: of its value, source and factor among the words."""
    line, words = entry

    def at(column: int | None, default: float) -> float:
        return default if column is None or column >= len(words) else number_in(design.path, line, key, words, column)

    source = row_of.get(int(min(max(at(columns[1], 0.0), -1.0), 1e6))) if columns[1] is not None else 0
    design.checked.append(RowSolve(row, quantity, rule if source is not None else "other", at(columns[0], 0.0), key,
                                   source or 0, at(columns[2], 1.0)))


def _read_header(design: Design, file: _File) -> None:
    """Name, notes, unit, aperture, fields and wavelengths."""
    path, header = file.path, file.header
    design.name = header.get("NAME", (0, [""]))[1][0].strip().strip('"')
    design.notes = " ".join(" ".join(file.notes).split())
    if "MODE" in header and header["MODE"][1][:1] not in (["SEQ"], []):
        raise LensFileError(path, header["MODE"][0], f"MODE {header['MODE'][1][0]}: only sequential lenses are read")
    line, words = header.get("UNIT", (None, ["MM"]))
    unit = (words or ["MM"])[0].upper()
    if unit not in UNITS:
        raise LensFileError(path, line, f"UNIT {unit}: lengths must be in {', '.join(UNITS)}")
    design.unit = UNITS[unit]
    zemax_system.read(design, header)


def _configure(file: _File, line: int, key: str, words: list[str]) -> None:
    """Process a line of the configurations; values of the first one replace those of the current one."""
    if len(words) < 3 or not words[0].isdecimal() or not words[1].isdecimal() or len(words[0] + words[1]) > 12:
        return
    index, number, listed = int(words[0]), int(words[1]), file.listed
    block = file.blocks[index] if index < len(file.blocks) else None
    if key == "LTTL":
        quoted = re.match(r'"([^"]*)"', " ".join(words[2:]))
        listed.names[number] = quoted[1] if quoted else words[2]
        return
    if key == "APER":
        listed.put("aperture", 0, number, number_in(file.path, line, key, words, 2))
        return
    if key not in FIRST:
        if key != "MOFF":
            listed.differs(f"{key} {index}", words[2])
        return
    if key == "THIC" and index < len(file.blocks) - 1:
        listed.put("gap", index, number, number_in(file.path, line, key, words, 2, infinite=index == 0))
    elif key == "SDIA" and block is not None and "STOP" in block.entries:
        listed.put("stop", index, number, number_in(file.path, line, key, words, 2))
    elif key != "THIC":
        listed.differs(f"{key} {index}", words[2])
    if number == 1 and block is not None:
        block.entries[FIRST[key]] = (line, words[2:3])


def _row(design: Design, block: _Block, is_image: bool, catalogues: list[str]) -> Row:
    """The row of one SURF block. catalogues: of glasses, in the order of the file."""
    path, index, entries = design.path, block.index, block.entries
    line = entries["SURF"][0]
    row = Row(line)
    kind_line, kind = entries.get("TYPE", (line, []))[0], block.kind or "STANDARD"
    if kind not in SURFACES and not (is_image and kind != "COORDBRK"):
        raise LensFileError(path, kind_line, f"SURF {index} is TYPE {kind}: "
                                             f"{REFUSED.get(kind, 'a kind of surface that')} is not traced")
    row.curvature, row.thickness, row.conic = (
        block.value(key, infinite=key == "DISZ") if block.words(key) else 0.0 for key in ("CURV", "DISZ", "CONI"))
    row.is_stop = "STOP" in entries
    for key, column in (("DIAM", 0), ("CLAP", 1)):
        if len(block.words(key)) > column and (size := block.value(key, column)) > 0.0:
            row.semi_diameter = size
    if "COAT" in entries:
        design.found(Kind.LEFT_OUT, "coatings (COAT) are left out")
    for key, what in APERTURES.items():
        if key in entries and not is_image and (key != "CLAP" or block.words(key) and block.value(key) > 0.0):
            design.found(Kind.LEFT_OUT, f"SURF {index}: {what} ({key}) is left out, its circle is used",
                         len(design.rows) - 1)
    if any(block.value("SCBD", column) for column in range(3, len(block.words("SCBD")))):
        raise LensFileError(path, entries["SCBD"][0], f"SURF {index}: a tilt or decentre among the properties of a "
                                                      "surface (SCBD) is not read: give it as coordinate breaks")
    for key in entries:
        if key not in READ and key not in HARMLESS:
            raise LensFileError(path, entries[key][0], f"SURF {index}: {not_understood(key)}")
    if not is_image:
        with located(path, kind_line, f"SURF {index}, TYPE {kind}: "):
            _shape(design, row, kind, block.numbered)
        if block.words("GLAS"):
            row.glass = _glass(design, block, catalogues)
    return row


def _shape(design: Design, row: Row, kind: str, numbered: dict[tuple[str, int], tuple[int, str]]) -> None:
    """Aspheric terms and the second curvature of a surface, from its PARM and XDAT. RowError: not traced."""
    values = {}
    for (key, index), (line, word) in numbered.items():
        with located(design.path, line):
            values[key, index] = file_number(word, f"{key} {index}")
    if kind in ("EVENASPH", "ODDASPHE"):
        for index, power in enumerate(EVEN_POWERS if kind == "EVENASPH" else ODD_POWERS, start=1):
            row.aspheric[power] = values.get(("PARM", index), 0.0)
    elif kind in ("XASPHERE", "XODDASPH"):
        step = 2 if kind == "XASPHERE" else 1
        values = _extra_data(design, kind, step, values)
        radius = values.get(("XDAT", 2), 1.0)
        if radius <= 0.0:
            raise RowError(f"XDAT 2, the radius of normalisation, is {significant(radius)}: it must be positive")
        terms = int(min(values.get(("XDAT", 1), 0.0), 300.0))
        for index in range(1, terms + 1):
            row.aspheric[step * index] = values.get(("XDAT", index + 2), 0.0) / radius ** (step * index)
    elif kind == "TOROIDAL":
        row.conic = row.conic if row.curvature else 0.0
        if any(values.get(("PARM", index)) for index in range(2, 9)) or values.get(("XDAT", 1)) or row.conic:
            raise RowError("a toroid with a conic or aspheric terms is not traced")
        row.curvature_x = file_curvature(numbered.get(("PARM", 1), (0, "0"))[1])
        row.toroid = "torus"
    elif kind == "BICONICX":
        if row.conic or values.get(("PARM", 2)):
            raise RowError("a biconic surface with conics is not traced")
        row.curvature_x = file_curvature(numbered.get(("PARM", 1), (0, "0"))[1])
    for (key, index), value in values.items():
        if key == "PARM" and value and kind in PARAMETERS and index not in PARAMETERS[kind]:
            raise RowError(not_understood(f"PARM {index}"))
    row.aspheric = {power: a for power, a in row.aspheric.items() if a}
    if 1 in row.aspheric:
        raise RowError("a term in r¹ makes a cone, which is not traced")
    if max(row.aspheric, default=0) > 20:
        raise RowError(f"a term in r^{max(row.aspheric)} is not traced: powers go to 20")


def _extra_data(design: Design, kind: str, step: int, values: Values) -> Values:
    """The XDAT of an extended asphere; of a file without, its PARM: XDAT n is PARM n + 12 in newer files.

    Where only the first twelve are given, they are read as those of the plain asphere. RowError: both PARM and XDAT.
    """
    parameters = {index: value for (key, index), value in values.items() if key == "PARM" and value}
    if not parameters:
        return values
    index = len(design.rows) - 1
    if any(key == "XDAT" for key, _ in values):
        raise RowError(not_understood(f"PARM {min(parameters)} together with XDAT"))
    if min(parameters) > 12:
        design.found(Kind.CONVENTION, f"surface {index}: {kind} has its coefficients as PARM 13, 14 …, which are read "
                                      "as XDAT 1, 2 …", index)
        return {("XDAT", number - 12): value for number, value in parameters.items()}
    design.found(Kind.CONVENTION, f"surface {index}: {kind} has no XDAT: its PARM n is read as the coefficient of r^"
                                  f"{'2n' if step == 2 else 'n'}", index, severity=Severity.WARNING)
    return {("XDAT", 1): float(max(parameters)),
            **{("XDAT", number + 2): value for number, value in parameters.items()}}


def _glass(design: Design, block: _Block, catalogues: list[str]) -> Glass:
    """The medium of a GLAS line, from the first catalogue that has it; the surface's comment may name a model glass."""
    index, (line, words), comment = block.index, block.entries["GLAS"], " ".join(block.words("COMM"))
    name, flag = words[0], words[1] if len(words) > 1 else "0"
    if name.upper() == "MIRROR":
        raise LensFileError(design.path, line, f"SURF {index} is a mirror (GLAS MIRROR): only lenses are traced")
    n_d, v_d = (block.value("GLAS", column) if len(words) > column else 0.0 for column in (3, 4))
    shown = "" if name.startswith("___") else name
    if not shown and comment.startswith(GLASS_COMMENT):
        shown = comment.removeprefix(GLASS_COMMENT)
    with located(design.path, line, f"SURF {index}, GLAS: "):
        if flag not in ("0", "1", "2", "3"):            # catalogue, model, pick-up, substitute
            raise RowError(not_understood(f"the flag {flag} of a glass"))
        if flag == "1" or not shown:
            if deviation := block.value("GLAS", 5) if len(words) > 5 else 0.0:
                design.found(Kind.GLASS, f"SURF {index}: the deviation of its model glass from the normal line of "
                                         f"partial dispersion, {significant(deviation)}, is left out",
                             len(design.rows) - 1, deviation=deviation)
            return media.stated(shown, n_d, v_d)
        spare = None if (n_d, v_d) in LEFTOVERS else (n_d, v_d)
        return media.glass_in(design, name, media.maker_among(name, catalogues), spare)
