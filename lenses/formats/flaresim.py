"""FlareSim lens files (.lens): a header and a table of surfaces.

    # comment
    name: Triplet 50 mm f/4
    focal_length: 50.0
    surfaces:
    # radius  thickness  ior      abbe   semi_ap  coating  [type]  [radius_y]
      48.5    4.0        1.62041  60.3   20.0     1
      stop    2.0        1.00000  0.0    12.5     0
      -140.0  3.0        1.75000  35.0   18.0     1        cyl_y

Lengths in mm. Thickness and medium lie behind the surface; the last thickness is the back focus. Radius 0 or inf is a
plane, "stop" the aperture stop. The column semi_ap holds semi-diameters by its name, but diameters in the published
files that come from Optical Bench: the f-number in the name decides, else the radii, which diameters often exceed.
type: sph; cyl_x, curved in the section y–z; cyl_y, curved in x–z; toric, with the radius of x–z first and that of y–z
behind. Coatings are a number of layers, which is left out.
"""

import re
from math import inf, log

from lensbench.core.optics.finding import Kind, Severity
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant
from lensbench.lenses.file_error import LensFileError, RowError, located, not_understood
from lensbench.lenses.glass import media
from lensbench.lenses.tables.design import Design, Row
from lensbench.lenses.tables.paraxial import f_number, sag
from lensbench.lenses.tables.text import check_lines, file_curvature, file_number

TYPES = {"sph": "sph", "spherical": "sph", "cyl_x": "cyl_x", "cylinder_x": "cyl_x", "cyl_y": "cyl_y",
         "cylinder_y": "cyl_y", "toric": "toric"}
HARMLESS = ("patent", "notes", "maker", "year", "source")
F_NUMBER = re.compile(r"(?i)(?<![a-z])[ft]\s*/?\s*(\d{1,2}(?:\.\d+)?)(?![\d.]*\s*mm)")
CROSSING = 0.05         # of the rim: depth by which neighbours may overlap, since published rims are rounded
COLUMNS = ("radius", "thickness", "ior", "abbe", "semi_ap")


def read(text: str, path: str) -> Lens:
    """The lens of a file's text. LensFileError names `path`, the line and the mistake."""
    check_lines(text, path)
    design = Design(path, [Row(None, thickness=inf)])
    in_table = False
    for line, content in enumerate(text.split("\n"), start=1):
        content = content.partition("#")[0].strip()
        key, colon, rest = content.partition(":")
        with located(path, line, f"surface {len(design.rows) - 1}: " if in_table else ""):
            if in_table and content:
                design.add(_row(line, content.split()))
            elif content and colon and key.strip().lower() == "surfaces":
                in_table = True
            elif key.strip().lower() == "name":
                design.name = rest.strip()
            elif key.strip().lower() == "focal_length":
                design.stated_efl = file_number(rest.strip(), "focal_length") or None
            elif content and key.strip().lower() not in HARMLESS:
                raise RowError(not_understood(key.strip() or content))
    if not in_table:
        raise LensFileError(path, None, "there is no line “surfaces:”: this is no FlareSim lens")
    design.add(Row(None))
    _decide_rims(design)
    return design.lens()


def _decide_rims(design: Design) -> None:
    """Halve the rims where the column holds diameters, and state what decided."""
    rows = design.rows[1:-1]
    stop = next((i for i, row in enumerate(rows) if row.is_stop), None)
    stated = F_NUMBER.search(design.name)
    ratio = abs(f_number(rows, stop)) if stated and stop is not None else inf       # of semi-diameters
    severity = Severity.NOTE
    if stated and 0.0 < ratio < inf:
        halved = abs(log(2.0 * ratio / float(stated[1]))) < abs(log(ratio / float(stated[1])))
        why = f"the f-number in the name, {stated[0]}, asks for"
    elif any(abs(row.curvature) * (row.semi_diameter or 0.0) > 1.0 or _crosses(row, behind)
             for row, behind in zip(rows, rows[1:], strict=False)):
        halved, why = True, "as semi-diameters they exceed what the radii allow"
    else:
        halved, why = False, "as its name states: if they are diameters, the lens opens two stops too wide"
        severity = Severity.WARNING
    design.found(Kind.CONVENTION, f"the column semi_ap is read as {'diameters' if halved else 'semi-diameters'}: {why}",
                 severity=severity)
    for row in rows if halved else ():
        row.semi_diameter = (row.semi_diameter or 0.0) / 2.0


def _crosses(front: Row, back: Row) -> bool:
    """Whether two surfaces cross within their clear apertures."""
    rim = min(front.semi_diameter or 0.0, back.semi_diameter or 0.0)
    return front.thickness + sag(back.curvature, rim) - sag(front.curvature, rim) < -CROSSING * rim


def _row(line: int, words: list[str]) -> Row:
    """The surface of a line. RowError: invalid, or not traced."""
    if len(words) < len(COLUMNS):
        raise RowError(f"the line has {len(words)} values: a surface needs {', '.join(COLUMNS)}")
    row = Row(line, is_stop=words[0].lower() == "stop")
    row.thickness = file_number(words[1], "thickness")
    row.glass = media.model(file_number(words[2], "ior"), file_number(words[3], "abbe"))
    size = file_number(words[4], "semi_ap")
    if size <= 0.0:
        raise RowError(f"semi_ap is {significant(size)}: it must be positive")
    row.semi_diameter = size
    if len(words) > (8 if words[6:7] == ["toric"] else 7):
        raise RowError(not_understood(f"the value {words[-1]} at its end"))
    kind = TYPES.get(words[6].lower()) if len(words) > 6 else "sph"
    if kind is None:
        raise RowError(f"the type {words[6][:20]} is not traced: it must be one of sph, cyl_x, cyl_y, toric")
    c = 0.0 if row.is_stop else _curvature(words[0])
    if kind == "toric":
        if len(words) < 8:
            raise RowError("a toric surface needs the radius of the section y–z as its last value")
        row.curvature, row.curvature_x, row.toroid = _curvature(words[7]), c, "torus"
    else:
        row.curvature, row.curvature_x = {"sph": (c, None), "cyl_x": (c, 0.0), "cyl_y": (0.0, c)}[kind]
    return row


def _curvature(word: str) -> float:
    """Curvature of a radius; 0 and inf are a plane."""
    return 0.0 if re.fullmatch(r"(?i)[+-]?inf(inity)?", word) else file_curvature(word)
