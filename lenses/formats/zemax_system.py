"""System data in the header of a Zemax file (.zmx): aperture, fields with vignetting, wavelengths.

ENPD 10                     entrance-pupil diameter; FNUM n 0 (1: paraxial working) f-number; OBNA n 0 (1: half of
the object's cone, degrees) numerical aperture of the object; FLOA: by the stop's size
FTYP 0 0 3 3                fields by 0 angle, 1 object height, 2 paraxial and 3 real image height; telecentric;
number of fields, of wavelengths
XFLN 0 0 0                  fields; YFLN too, FWGN their weights
VCYN 0 0.1 0.2              compression of the pupil along y, VDYN its decentre, VCXN and VDXN along x
WAVM 1 0.4861327 1          wavelength (µm) and weight; WAVL and WWGT in older files
PWAV 2                      the primary wavelength
ENVD 20 1 0                 °C, atmospheres; 1: indices are those of this air
"""

from collections.abc import Sequence
from decimal import Decimal
from math import radians, sin

from lensbench.core.optics.finding import Kind, Severity
from lensbench.core.optics.system import Aperture, ApertureKind, FieldKind, SystemData
from lensbench.core.text import significant
from lensbench.lenses.file_error import RowError, located
from lensbench.lenses.tables.design import Design
from lensbench.lenses.tables.text import EXACT, exact, file_number, plain_number

FIELD_KINDS = (FieldKind.ANGLE, FieldKind.OBJECT_HEIGHT, FieldKind.IMAGE_HEIGHT, FieldKind.REAL_IMAGE_HEIGHT)
APERTURES = {"ENPD": (ApertureKind.PUPIL_DIAMETER,), "FNUM": (ApertureKind.F_NUMBER, ApertureKind.WORKING_F_NUMBER),
             "OBNA": (ApertureKind.OBJECT_NA,), "FLOA": (ApertureKind.STOP_SIZE,)}     # without and with the flag 1
HELD = frozenset(kind for kinds in APERTURES.values() for kind in kinds)
VIGNETTING = ("VCXN", "VDXN", "VCYN", "VDYN")
# Of the fields: first the present keyword, then those of older files
FIELD_KEYS = {"x": ("XFLN", "XFLD"), "y": ("YFLN", "YFLD"), "weight": ("FWGN", "FWGT"),
              **{key: (key, f"Z{key[:3]}") for key in VIGNETTING}}
KEYS = frozenset((*APERTURES, *(key for keys in FIELD_KEYS.values() for key in keys)))
Header = dict[str, tuple[int, list[str]]]


def number_in(path: str, line: int | None, key: str, words: Sequence[str], column: int,
              infinite: bool = False) -> float:
    """Number of a keyword at this index of its words. LensFileError: missing or invalid."""
    with located(path, line):
        if column >= len(words):
            raise RowError(f"{key} needs a value")
        return file_number(words[column], key, infinite=infinite)


def read(design: Design, header: Header) -> None:
    """Give the design the system data of a header: words by keyword, each with its line."""
    for key in APERTURES:
        if key in header and (header[key][1] or key == "FLOA"):
            _read_aperture(design, key, *header[key])
    type_line, kinds = header.get("FTYP", (None, []))
    codes = [int(min(abs(number_in(design.path, type_line, "FTYP", kinds, i)), 1e6)) for i in range(len(kinds[:4]))]
    _read_fields(design, header, codes)
    _read_wavelengths(design, header, codes[3] if len(codes) > 3 else None)
    if header.get("AFOC", (0, ["0"]))[1][:1] != ["0"]:
        design.found(Kind.LEFT_OUT, "afocal image space (AFOC) is left out")
    line, air = header.get("ENVD", (None, []))
    if len(air) > 2 and number_in(design.path, line, "ENVD", air, 2):
        design.state_air(*(number_in(design.path, line, "ENVD", air, i) for i in (0, 1)))


def _read_aperture(design: Design, key: str, line: int, words: list[str]) -> None:
    kinds = APERTURES[key]
    value = number_in(design.path, line, key, words, 0) if key != "FLOA" else 0.0
    is_flagged = len(words) > 1 and words[1] == "1"
    if key == "OBNA" and is_flagged:
        design.found(Kind.CONVENTION, f"the half angle of the object's cone, {significant(value)}°, is kept "
                                      f"as its sine")
        value = sin(radians(value))
    design.state_aperture(kinds[-1] if is_flagged else kinds[0], value)


def _read_fields(design: Design, header: Header, codes: list[int]) -> None:
    if len(codes) > 1 and codes[1]:
        design.found(Kind.LEFT_OUT, "telecentric in the object's space (FTYP): left out")
    kind = codes[0] if codes else 0
    columns = {key: _numbers(design.path, header, *named) for key, named in FIELD_KEYS.items()}
    if any(_numbers(design.path, header, "VANN", "ZVAN")):
        design.found(Kind.LEFT_OUT, "the rotation of vignetted pupils (VANN) is left out", severity=Severity.WARNING)
    count = max(len(columns["x"]), len(columns["y"]))
    if not count:
        return
    if kind >= len(FIELD_KINDS):
        design.found(Kind.LEFT_OUT, f"fields of the type {kind} (FTYP) are left out")
        return
    if len(codes) > 2 and codes[2]:
        count = min(count, codes[2])
    points = []
    for i in range(count):
        row = {key: column[i] if i < len(column) else Decimal(key == "weight") for key, column in columns.items()}
        cuts = [float(cut) for c, d in (("VCXN", "VDXN"), ("VCYN", "VDYN"))
                for cut in (EXACT.subtract(row[c], row[d]), EXACT.add(row[c], row[d]))]
        points += design.field_point(float(row["x"]), float(row["y"]), float(row["weight"]),
                                     (cuts[0], cuts[1], cuts[2], cuts[3]))
    design.state_fields(FIELD_KINDS[kind], points)


def _read_wavelengths(design: Design, header: Header, count: int | None) -> None:
    values = [float(w) for w in _numbers(design.path, header, "WAVL", "WAVN")]
    weights = [float(w) for w in _numbers(design.path, header, "WWGT", "WWGN")]
    pairs = [(w, weights[i] if i < len(weights) else 1.0) for i, w in enumerate(values)]
    listed = sorted((int(key[5:]), column) for key, column in header.items()
                    if key.startswith("WAVM ") and key[5:].isdecimal() and len(key) < 12)
    if listed:
        pairs = [(number_in(design.path, line, "WAVM", words, 1),
                  number_in(design.path, line, "WAVM", words, 2) if len(words) > 2 else 1.0)
                 for _, (line, words) in listed]
    line, words = header.get("PWAV", (None, ["1"]))
    primary = number_in(design.path, line, "PWAV", words, 0)
    if pairs:
        design.state_wavelengths(pairs[:count] if count else pairs, int(max(min(primary, 1e6), 0.0)) - 1)


def _numbers(path: str, header: Header, *keys: str) -> list[Decimal]:
    """Numbers of the first of these keywords in the header, with the digits of the file."""
    for key in keys:
        if key in header:
            line, words = header[key]
            for i in range(len(words)):
                number_in(path, line, key, words, i)
            return [Decimal(plain_number(word)) for word in words]
    return []


def lines(system: SystemData, aperture: Aperture) -> list[str]:
    """Header lines of the system data.

    aperture: of a kind in HELD; its first value is written.
    """
    key = next(key for key, kinds in APERTURES.items() if aperture.kind in kinds)
    flag = APERTURES[key].index(aperture.kind)
    written = [key if key == "FLOA" else f"{key} {aperture.values[0]!r}{f' {flag}' if key != 'ENPD' else ''}"]
    fields = system.fields
    columns = {"XFLN": [point.x for point in fields], "YFLN": [point.y for point in fields],
               "FWGN": [point.weight for point in fields]}
    written.append(f"FTYP {FIELD_KINDS.index(system.field_kind)} 0 {len(fields)} {len(system.wavelengths)} 0 0 0")
    written += [" ".join([key, *map(repr, column)]) for key, column in columns.items()]
    halves: dict[str, list[str]] = {}
    for point in fields:
        for axis, (plus, minus) in (("X", point.vignetting[:2]), ("Y", point.vignetting[2:])):
            for key, odd in ((f"VD{axis}N", EXACT.minus(exact(plus))), (f"VC{axis}N", exact(plus))):
                half = EXACT.multiply(EXACT.add(odd, exact(minus)), Decimal("0.5"))
                halves.setdefault(key, []).append(str(half.normalize(EXACT)))
    if any(any(point.vignetting) for point in fields):
        written += [" ".join([key, *halves[key]]) for key in ("VDXN", "VDYN", "VCXN", "VCYN")]
    written += [f"WAVM {i} {w.micrometres!r} {w.weight!r}" for i, w in enumerate(system.wavelengths, start=1)]
    return [*written, f"PWAV {system.primary + 1}"]
