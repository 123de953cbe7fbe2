"""A lens from a table of text, as copied from a patent, a book or a spreadsheet.

One surface a line. Cells are separated by tabs, semicolons, bars, blanks, or commas where numbers have points. Columns
are recognised by a line of headings (in English, German, French or Japanese patents' letters: r, d, nd, νd), by marks
such as r1 = 22.01 d1 = 3.26, or without either by their order: number, radius, thickness, n_d, V_d, semi-diameter.
Numbers have decimal points or commas, and true minus signs. Lengths in mm; thickness and medium lie behind a surface.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import inf, isinf

from lensbench.core.optics.finding import Finding, Kind, Severity, note
from lensbench.core.optics.glass import AIR
from lensbench.core.optics.system import Aperture, ApertureKind, SystemData
from lensbench.core.text import excerpt, significant
from lensbench.lenses.editing.document import EditError, LensDocument
from lensbench.lenses.file_error import LensFileError, RowError, number
from lensbench.lenses.glass import media
from lensbench.lenses.tables.aperture import estimate_rims
from lensbench.lenses.tables.design import MOST_SURFACES, Design, Row
from lensbench.lenses.tables.paraxial import focal_length
from lensbench.lenses.tables.rows import curvature
from lensbench.lenses.tables.text import plain_number

LONGEST_TEXT = 1_000_000    # characters that are read
USUAL_APERTURE = 4.0        # f-number for rims where a table has none
SURFACE, RADIUS, THICKNESS, INDEX, ABBE, GLASS, SEMI, DIAMETER, CONIC, COMMENT = (
    "number", "radius", "thickness", "n_d", "V_d", "glass", "semi-diameter", "diameter", "conic", "comment")
HEADINGS = (
    (SEMI, r"semi.?(diameter|aperture|dia)?\.?|sd|clear semi.*|h|rim|halbmesser|demi.*"),
    (DIAMETER, r"(clear |effective |free |full )?(diam(eter|\.)?|dia\.?|aperture|ap\.?)|ø|⌀|φ|durchmesser|diam[eè]tre"),
    (RADIUS, r"r(ad(ius|ii|\.)?)?( of curvature)?|(krümmungs)?radius|rayon( de courbure)?|y radius|curvature radius"),
    (THICKNESS, r"d|t|thick(ness|n\.)?|(axial |lens )?dist(ance|\.)?|spacing|separation|gap|dicke|abstand|[eé]paisseur|"
                r"(surface )?(interval|spacing|distance)|thickness or .*"),
    (INDEX, r"n ?_?d?|n ?\(?d\)?|(refractive )?ind(ex|ices)( nd)?|refractive index.*|brechzahl|indice|nd|ne"),
    (ABBE, r"[νvnu]{1,2} ?_?d?|v ?\(?d\)?|abbe.*|vd|ve|dispersion"),
    (CONIC, r"k|κ|conic( constant)?|cc|konisch.*"),
    (GLASS, r"glass( type| name)?|mat(erial|\.)?|medium|glas|verre|glass code"),
    (COMMENT, r"comment|remark|note|type|label|name"),
    (SURFACE, r"#|n[o°r]\.?|s(urf(ace|\.)?)?( ?(no|number|nr|#)\.?)?|fläche|i|surf:type|number"),
)
TERM = re.compile(r"A_?\d{1,2}|α_?\d{0,2}|r\^\d{1,2}")          # a heading of aspheric coefficients
ORDER = (RADIUS, THICKNESS, INDEX, ABBE, SEMI)
STOPS = {"stop", "sto", "as", "a.s.", "aperture stop", "aperture", "(stop)", "diaphragm", "blende", "diaphragme", "s"}
PLANES = {"inf", "infinity", "∞", "plano", "plane", "flat", "plan", "-", "–", "—", "inf.", "infinite", "1e+18", "1e18",
          "1.0e+18", "unendlich", "infini"}
ENDS = {"obj", "object", "object plane", "ima", "img", "image", "image plane", "objekt", "bild"}
MARKED = re.compile(r"(?<![A-Za-zνφ])([rRdDnNνvVtT])\s*_?d?\s*(\d+)\s*=\s*([-+−]?\s*(?:\d[\d.,]*(?:[eE][-+]?\d+)?|∞|"
                    r"[Ii]nf\w*))")
MARKS = {"r": RADIUS, "d": THICKNESS, "t": THICKNESS, "n": INDEX, "v": ABBE, "ν": ABBE}


@dataclass
class _Line:
    """Cells of one surface by column, the number of its line from 1, and whether the stop is marked."""

    line: int
    cells: dict[str, str] = field(default_factory=dict)
    is_stop: bool = False


def pasted(text: str, f_number: float | None = None) -> LensDocument:
    """The lens of a pasted table; its findings state what was assumed: columns, clear apertures, glasses, the stop.

    Empty lines are skipped, and the rows of an object and an image. f_number: for clear apertures that the table does
    not have, f/4 by default. EditError names the line and the column of a cell that cannot be read, or why the text
    holds no lens.
    """
    if len(text) > LONGEST_TEXT:
        raise EditError(f"the text has {len(text)} characters: a table of at most {LONGEST_TEXT} is read")
    lines = [(i, line) for i, line in enumerate(re.split(r"\r\n|\r|\n", text), start=1) if line.strip()]
    if len(lines) > MOST_SURFACES + 10:
        raise EditError(f"the table has {len(lines)} rows: a lens has at most {MOST_SURFACES} surfaces")
    if not lines:
        raise EditError("there is no table: copy one surface a line, with radius, thickness, n_d and V_d")
    marked = [(i, MARKED.findall(line)) for i, line in lines]
    if sum(len(marks) > 1 for _, marks in marked) > 1:
        return _document(_of_marks(marked), f_number)
    rows, guessed, remarks = _of_columns(lines)
    made = _document(rows, f_number)
    if not guessed:
        return replace(made, findings=(*remarks, *made.findings))
    named = ", ".join(name or "not read" for name in guessed)
    return replace(made, findings=(note(Kind.CONVENTION, f"the table has no headings: its columns are assumed to be "
                                                         f"{named}"), *made.findings))


def _of_marks(marked: Sequence[tuple[int, list[tuple[str, str, str]]]]) -> list[_Line]:
    """Rows of a table such as r1 = 22.01 d1 = 3.26 n1 = 1.62 ν1 = 60.3; n and ν belong to their row."""
    rows: dict[int, _Line] = {}
    for line, marks in marked:
        own = next((int(digits) for letter, digits, _ in marks if letter.lower() == "r"), None)
        for letter, digits, value in marks:
            column = MARKS[letter.lower()]
            surface = own if own is not None and column in (INDEX, ABBE) else int(digits)
            row = rows.setdefault(surface, _Line(line))
            if column in row.cells:
                raise EditError(f"line {line}: {letter}{digits} is given twice")
            row.cells[column] = value.replace(" ", "").rstrip(".,")
    return [rows[i] for i in sorted(rows)]


def _of_columns(lines: Sequence[tuple[int, str]]) -> tuple[list[_Line], list[str], list[Finding]]:
    """Rows of a table in columns; the columns where they are guessed, without headings; remarks about headings."""
    table = _split(lines)
    columns: list[str] = []
    guessed: list[str] = []
    remarks: list[Finding] = []
    start = 0
    for k, (line, cells) in enumerate(table[:4]):
        headings = _headings(cells)
        if headings.count(RADIUS) == 1 and (THICKNESS in headings):
            columns, start = headings, k + 1
            remarks = _heading_remarks(line, cells, headings)
            break
    body = table[start:]
    if not columns:
        body = [(line, cells) for line, cells in body if sum(map(_is_number, cells)) >= 1]
        columns = guessed = _guessed([cells for _, cells in body])
    return [made for line, cells in body if (made := _row(line, cells, columns)) is not None], guessed, remarks


def _split(lines: Sequence[tuple[int, str]]) -> list[tuple[int, list[str]]]:
    """The cells of each line."""
    whole = "\n".join(line for _, line in lines)
    if "\t" in whole:
        pattern = r"\t"
    elif ";" in whole:
        pattern = r";"
    elif "|" in whole:
        pattern = r"\|"
        lines = [(i, line.strip().strip("|")) for i, line in lines if not re.fullmatch(r"[\s|:+-]+", line)]
    elif re.search(r"\d\.\d", whole) and re.search(r",", whole):
        pattern = r","
    elif re.search(r"\S {2,}\S", whole):
        pattern = r"\s{2,}|(?<=\d)\s+(?=[-+−\d.])"
    else:
        pattern = r"\s+"
    blank = pattern.startswith(r"\s")
    return [(i, [cell.strip().strip('"') for cell in re.split(pattern, line.strip() if blank else line)])
            for i, line in lines]


def _headings(cells: Sequence[str]) -> list[str]:
    """The column of each heading; "" for one that is not known."""
    columns = []
    for cell in cells:
        word = re.sub(r"[\[(].*?[\])]|\bmm\b|[₀-₉_]", "", cell).strip(" :.*").lower() or cell.strip().lower()
        word = {"ν": "v", "νd": "vd", "ν d": "vd"}.get(word, word)
        name = next((name for name, pattern in HEADINGS if re.fullmatch(pattern, word)), "")
        columns.append("" if name and name in columns else name)
    return columns


def _heading_remarks(line: int, cells: Sequence[str], columns: Sequence[str]) -> list[Finding]:
    """What is assumed of headings, and those that are not read; EditError: a unit other than mm, aspheric terms."""
    for cell in cells:
        if re.search(r"[\[(]\s*(in|inch(es)?|″|cm|m)\.?\s*[\])]", cell.lower()):
            raise EditError(f"line {line}: the heading {excerpt(cell)} has another unit than mm: convert the lengths "
                            "first")
    remarks = []
    e_line = [cell for cell, name in zip(cells, columns, strict=True)
              if name in (INDEX, ABBE) and re.fullmatch(r"[nvν]\W?_?e\W?", cell.strip().lower())]
    if e_line:
        remarks.append(Finding(Kind.GLASS, None, f"the numbers of {' and '.join(map(excerpt, e_line))}, of the e line, "
                                                 "are used as n_d and V_d", severity=Severity.WARNING))
    unread = [cell for cell, name in zip(cells, columns, strict=True) if cell and not name]
    terms = [cell for cell in unread if TERM.fullmatch(cell.strip())]
    if terms:
        raise EditError(f"line {line}: {excerpt(terms[0])} seems to be a column of aspheric terms, which are not read: "
                        "paste the table without them, and enter them afterwards")
    if unread:
        remarks.append(Finding(Kind.NOT_READ, None, f"not read: the column{'s' if len(unread) > 1 else ''} "
                                                    f"{', '.join(map(excerpt, unread))}", severity=Severity.WARNING))
    return remarks


def _guessed(rows: Sequence[Sequence[str]]) -> list[str]:
    """Columns of a table without headings: by their order, and what their numbers can mean."""
    width = max((len(cells) for cells in rows), default=0)
    if width < 2:
        raise EditError("no columns are recognised: a surface needs a radius and a thickness at least")
    longest = [cells for cells in rows if len(cells) == width]
    counts = [_whole(cells[0]) for cells in rows if cells]
    numbers = [count for count in counts if count is not None]
    numbered = len(numbers) >= len(counts) - 1 > 0 and numbers == sorted(set(numbers)) and numbers[-1] <= len(rows) + 1
    names = [SURFACE] if numbered else []
    order = list(ORDER)
    for k in range(len(names), width):
        column = [cells[k] for cells in longest if cells[k]]
        words = [text for text in column if not _is_number(text) and text.lower() not in PLANES | STOPS]
        if words and len(words) * 2 >= len(column) and k > len(names) - 1 and RADIUS in names:
            names.append(GLASS if GLASS not in names else COMMENT)
            order = [column for column in order if column not in (INDEX, ABBE)]
        else:
            names.append(order.pop(0) if order else "")
    # Index or rim: an index lies from 1 to 5, an Abbe number from 8 to 110
    if INDEX in names and not any(1.2 < value < 5.0 for cells in longest
                                  if (value := _value(cells[names.index(INDEX)])) is not None):
        names[names.index(INDEX)] = SEMI
        names = [name if i <= names.index(SEMI) or name != SEMI else "" for i, name in enumerate(names)]
        names = ["" if name == ABBE else name for name in names]
    return names


def _row(line: int, cells: Sequence[str], columns: Sequence[str]) -> _Line | None:
    """The cells of a line by column; None for the object, the image and an empty row."""
    cells = list(cells)
    lower = [cell.lower().strip(" *†") for cell in cells]
    if any(cell in ENDS for cell in lower):
        return None
    is_stop = any(cell in STOPS or re.fullmatch(r"\d+\s*\(?(stop|sto|as)\)?", cell) for cell in lower)
    # Blanks separate cells: a row in air has neither index nor Abbe number nor glass
    media_columns = [name for name in columns if name in (INDEX, ABBE, GLASS)]
    if len(cells) == len(columns) - len(media_columns) and len(cells) < len(columns) and media_columns:
        kept = [name for name in columns if name not in media_columns]
    else:
        kept = list(columns)
    made = _Line(line, {name: cell for name, cell in zip(kept, cells, strict=False) if name and cell}, is_stop)
    if is_stop and RADIUS in made.cells and made.cells[RADIUS].lower() in STOPS:
        made.cells[RADIUS] = "inf"
    for name, cell in list(made.cells.items()):
        if cell.lower().strip(" *†") in STOPS and name not in (COMMENT, SURFACE):
            del made.cells[name]
    return made if made.cells.keys() - {SURFACE} else None


def _document(rows: Sequence[_Line], f_number: float | None) -> LensDocument:
    """The document of the rows."""
    if not any(_plain(row.cells.get(RADIUS, "")) is not None for row in rows):
        raise EditError("no column of radii is recognised: copy the table with its headings, such as r, d, nd, νd")
    design = Design("pasted table", [Row(None, thickness=inf)])
    for row in rows:
        design.add(_surface(row, design))
    design.rows.append(Row(None))
    body = design.rows[1:-1]
    missing = [i for i, row in enumerate(body) if row.semi_diameter is None]
    if missing and len(missing) == len(body):
        _estimate(design, body, f_number)
    try:
        lens = design.lens()
    except LensFileError as error:
        raise EditError(error.reason if error.line is None else f"line {error.line}: {error.reason}") from None
    return LensDocument(lens, tuple(row.cells.get(COMMENT, "") for row in rows), findings=lens.findings)


def _estimate(design: Design, body: list[Row], f_number: float | None) -> None:
    """Rims of a table that has none, from an f-number."""
    assumed = f_number or USUAL_APERTURE
    efl = focal_length(body)
    if isinf(efl):
        raise EditError("the table has no diameters, and the lens is afocal: nothing states how wide it is")
    system = SystemData(aperture=Aperture(ApertureKind.F_NUMBER, (assumed,)))
    stop = next((i for i, row in enumerate(body) if row.is_stop), 0)
    if not estimate_rims(body, stop, any(row.is_stop for row in body), system, inf, design.system.primary_wavelength):
        raise EditError("the table has no diameters, and no ray passes from which to estimate them")
    for row in body:
        row.semi_diameter = (row.semi_diameter or 0.0) * 1.1
    design.findings.append(Finding(Kind.RIM, None, "the table has no diameters: semi-diameters are estimated for an "
                                                   f"axial beam of f/{significant(assumed)}, and a tenth more",
                                   severity=Severity.WARNING))


def _surface(row: _Line, design: Design) -> Row:
    """The row of a surface; EditError names the cell that cannot be read."""
    cells = row.cells

    def read(name: str, default: float) -> float:
        if name not in cells:
            return default
        plain = _plain(cells[name])
        try:
            if plain is None:
                raise RowError("")
            return number(plain, name, infinite=name == THICKNESS)
        except RowError:
            raise EditError(f"line {row.line}, column “{name}”: {excerpt(cells[name])} is no number") from None

    made = Row(row.line, is_stop=row.is_stop)
    if RADIUS in cells and cells[RADIUS].lower().strip() not in PLANES:
        plain = _plain(cells[RADIUS])
        try:
            made.curvature = curvature(plain if plain is not None else cells[RADIUS])
        except RowError as error:
            raise EditError(f"line {row.line}, column “{RADIUS}”: {excerpt(cells[RADIUS])}: {error}") from None
    made.thickness = 0.0 if cells.get(THICKNESS, "").lower() in PLANES else read(THICKNESS, 0.0)
    n_d = 1.0 if cells.get(INDEX, "").lower() in PLANES | {"air"} else read(INDEX, 1.0)
    v_d = 0.0 if cells.get(ABBE, "").lower() in PLANES else read(ABBE, 0.0)
    name = cells.get(GLASS, "")
    try:
        if INDEX in cells and n_d != 1.0:
            made.glass = media.stated(name, n_d, v_d)
        elif name and name.lower() not in PLANES | {"air", "luft"}:
            made.glass = media.glass_in(design, name)
        else:
            made.glass = AIR
    except RowError as error:
        raise EditError(f"line {row.line}, column “{GLASS if name and INDEX not in cells else INDEX}”: "
                        f"{error}") from None
    if SEMI in cells or DIAMETER in cells:
        rim = read(SEMI, 0.0) if SEMI in cells else 0.5 * read(DIAMETER, 0.0)
        if rim < 0.0:
            raise EditError(f"line {row.line}, column “{SEMI}”: {significant(rim)} mm must be positive")
        made.semi_diameter = rim or None
    made.conic = read(CONIC, 0.0)
    return made


def _plain(text: str) -> str | None:
    """A number in Python's notation; None for other text. A mark of an asphere or a footnote is left out."""
    word = text.strip().strip("*†‡ ").replace("−", "-").replace("–", "-").replace("\u00a0", "").replace(" ", "")
    if word.lower().strip("+-") in PLANES:
        return "inf"
    if re.fullmatch(r"[-+]?\d{1,3}(,\d{3})+\.\d+", word):
        word = word.replace(",", "")
    elif re.fullmatch(r"[-+]?\d{1,3}(\.\d{3})+,\d+", word):
        word = word.replace(".", "")
    word = plain_number(word)
    return word if re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", word, re.IGNORECASE) else None


def _value(text: str) -> float | None:
    plain = _plain(text)
    return None if plain is None else float(plain)


def _whole(text: str) -> int | None:
    """The number of a surface: 3, 3*, S3."""
    match = re.fullmatch(r"[sS]?(\d{1,4})\s*[*†]?(\s*\(?(stop|sto|as)\)?)?", text.strip(), re.IGNORECASE)
    return int(match[1]) if match else None


def _is_number(text: str) -> bool:
    return _plain(text) is not None
