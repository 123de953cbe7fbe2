"""Optical Bench files (.txt), as the Photons to Photos site keeps its lenses: sections of tab-separated columns.

    [descriptive data]      title
    [constants]             AsphericalOddCount n, AsphericalA2: which powers the aspheric columns have
    [variable distances]    Focal Length, F-Number, Angle of View (full), Image Height (diameter of the image), Aperture
                            Diameter (stop), d0 (object), Bf (back focus) …: a column a zoom position
    [lens data]             id, radius, thickness or the name of a distance, n_d, diameter, V_d, glass, maker
    [aspherical data]       id, radius, conic, coefficients
    [notes]

Lengths in mm. A radius is a number, Infinity, CG (a cover glass: a plane) or AS,
the aperture stop; an id that ends in AS puts the stop on that surface. Aspheric
coefficients are those of even powers from r⁴, with AsphericalA2 from r²; with
AsphericalOddCount n the first n odd powers from r³ are among them (n = 1: r³ r⁴ r⁶
r⁸ …). Several columns of distances are the positions of a zoom, or of a lens that
moves groups to focus; d0 is then the distance of the object. Other rows of the section
have no positions of their own.
"""

import re
from math import inf, isinf
from typing import Any

from lensbench.core.optics.finding import Finding, Kind, Severity, note
from lensbench.core.optics.glass import AIR
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import ApertureKind, FieldKind, FieldPoint
from lensbench.core.text import excerpt, significant
from lensbench.lenses.file_error import LensFileError, RowError, located, not_understood
from lensbench.lenses.glass import media
from lensbench.lenses.tables.design import Design, Row
from lensbench.lenses.tables.rows import radius_text
from lensbench.lenses.tables.stations import MOST_STATIONS, Station, stations_of
from lensbench.lenses.tables.text import file_curvature, file_number, is_number

PLANES = ("CG", "FS", "INFINITY", "INF", "")
LONGEST = 30            # aspheric coefficients in a line
STOP = "aperture diameter"
FIELDS = {"Angle of View": FieldKind.ANGLE, "Image Height": FieldKind.REAL_IMAGE_HEIGHT}    # twice the field
FIGURES = ("focal length", "f-number", STOP, "angle of view", "image height", "magnification", "lens length", "d0",
           "bf")
CONSTANTS = ("asphericaloddcount", "asphericala2")
SAME_STOP = 0.02        # share of its diameter by which [lens data] may differ from the row of the stop


def read(text: str, path: str) -> Lens:
    """The lens of a file's text. LensFileError names `path`, the line and the mistake."""
    sections = _sections(text, path)
    if not sections.get("lens data"):
        raise LensFileError(path, None, "there is no section [lens data] with surfaces: this is no Optical Bench lens")
    design = Design(path, [Row(None, thickness=inf)])
    distances = {cells[0].strip().lower(): (line, cells[1:]) for line, cells in sections.get("variable distances", [])}
    design.name = next((cells[1].strip() for _, cells in sections.get("descriptive data", [])
                        if cells[0].strip().lower() == "title" and len(cells) > 1), "")
    design.notes = " ".join(" ".join(" ".join(cells) for _, cells in sections.get("notes", [])).split())
    design.stated_efl = _stated(distances, "focal length", path)
    design.stated_f_number = _stated(distances, "f-number", path)
    distance = _first(distances, "d0")
    if distance is not None:
        design.rows[0].thickness = _number(path, *distance, "d0", infinite=True)

    rows: dict[str, Row] = {}
    for line, cells in sections["lens data"]:
        with located(path, line, f"surface {cells[0].strip()}: "):
            row = _row(design, line, [cell.strip() for cell in cells] + [""] * 8, distances)
        design.add(row)
        rows[re.sub(r"(?i)as$", "", cells[0].strip()) or cells[0].strip()] = row
    with located(path, None):
        powers = _powers(sections)
    for line, cells in sections.get("aspherical data", []):
        name = re.sub(r"(?i)as$", "", cells[0].strip())
        if name not in rows:
            raise LensFileError(path, line, f"[aspherical data] of surface {excerpt(cells[0].strip())}, which is not "
                                            "in [lens data]")
        with located(path, line, f"surface {name}: "):
            _bend(rows[name], [cell.strip() for cell in cells], powers)
    for name, lines in sections.items():
        if name not in KNOWN:
            raise LensFileError(path, lines[0][0] - 1 if lines else None, not_understood(f"the section [{name}]"))
    for line, (name, *_) in sections.get("constants", []):
        if name.strip().lower() not in CONSTANTS:
            raise LensFileError(path, line, not_understood(f"the constant {name.strip()}"))
    design.add(Row(None))
    _size_stop(design, distances)
    _state_field(design, distances)
    gaps = {row: cells[2].strip().lower() for row, (_, cells) in enumerate(sections["lens data"], start=1)
            if len(cells) > 2 and cells[2].strip().lower() in distances}
    for line, (name, *_) in sections.get("variable distances", []):
        if name.strip().lower() not in (*FIGURES, *gaps.values()):
            raise LensFileError(path, line, not_understood(f"the distance {name.strip()}, of no surface,"))
    design.stations = _stations(distances, gaps, path)
    return design.lens()


def _size_stop(design: Design, distances: dict[Any, Any]) -> None:
    """Give the stop the diameter of its row in [variable distances], at the first position."""
    stops = [i for i, row in enumerate(design.rows) if row.is_stop]
    size = _cell(distances, STOP, 0, design.path, words=True)
    if size is None:
        return
    if len(stops) != 1:
        design.found(Kind.LEFT_OUT, f"Aperture Diameter {significant(size)} mm is left out: {len(stops)} surfaces are "
                                    "marked as the stop", severity=Severity.WARNING)
        distances.pop(STOP)
        return
    if not 0.0 < size < inf:
        raise LensFileError(design.path, distances[STOP][0], f"Aperture Diameter is {significant(size)}: it must "
                                                             f"be positive")
    row = design.rows[stops[0]]
    if row.semi_diameter is not None and abs(2.0 * row.semi_diameter - size) > SAME_STOP * size:
        other = 2.0 * row.semi_diameter
        design.found(Kind.STOP_SIZE, f"the diameter of the stop in [lens data], {significant(other)} mm, differs from "
                                     f"that in its row Aperture Diameter, {significant(size)} mm, which is used",
                     stops[0] - 1, left_out=other, used=size)
    row.semi_diameter = size / 2.0


def _state_field(design: Design, distances: dict[Any, Any]) -> None:
    """The field of the first position: the angle of view, else the height of the image."""
    stated = {name: size for name in FIELDS
              if (size := _cell(distances, name.lower(), 0, design.path, words=True)) and 0.0 < size < inf}
    if not stated:
        return
    used, *others = stated
    design.state_fields(FIELDS[used], design.field_point(0.0, stated[used] / 2.0))
    for name in others:
        design.found(Kind.LEFT_OUT, f"{name} {significant(stated[name])} is left out: the field is that of {used}, "
                                    f"{significant(stated[used])}")


def _stations(distances: dict[Any, Any], names: dict[int, str], path: str) -> list[Station]:
    """Positions of the columns of [variable distances]; empty for a lens with one position.

    names: of the varying gaps, by row. Positions are the columns that have distances.
    """
    placed = {"d0", "bf", *names.values()}
    count = max((sum(1 for cell in cells if cell.strip()) for name, (_, cells) in distances.items() if name in placed),
                default=1)
    if count > MOST_STATIONS:
        raise LensFileError(path, None, f"{count} positions are too many: at most {MOST_STATIONS} are read")
    stations = []
    for k in range(count if count > 1 else 0):
        gaps = {row: _cell(distances, name, k, path) for row, name in names.items()}
        stop = _cell(distances, STOP, k, path, words=True)
        if stop is not None and not 0.0 < stop < inf:
            raise LensFileError(path, distances[STOP][0], f"Aperture Diameter is {significant(stop)}: it must "
                                                          f"be positive")
        distance = _cell(distances, "d0", k, path)
        stations.append(Station({row: gap for row, gap in gaps.items() if gap is not None and not isinf(gap)},
                                inf if distance is None else distance, None if stop is None else stop / 2.0,
                                focal_length=_cell(distances, "focal length", k, path, words=True),
                                f_number=_cell(distances, "f-number", k, path, words=True)))
    return stations


def _cell(distances: dict[Any, Any], name: str, k: int, path: str, words: bool = False) -> float | None:
    """Value at position k, the last one if the line is shorter; None for an empty cell or one of `words`."""
    line, cells = distances.get(name, (0, []))
    text = cells[min(k, len(cells) - 1)].strip() if cells else ""
    return None if not text or (words and not is_number(text)) else _number(path, line, text, name, infinite=True)


KNOWN = ("descriptive data", "constants", "variable distances", "lens data", "aspherical data", "figure", "notes")


def _sections(text: str, path: str) -> dict[str, list[tuple[int, list[str]]]]:
    """Lines of each section with their numbers, split at tabs."""
    sections: dict[str, list[tuple[int, list[str]]]] = {}
    section: list[tuple[int, list[str]]] | None = None
    for line, content in enumerate(text.split("\n"), start=1):
        heading = re.fullmatch(r"\s*\[([^\]]*)\]\s*", content)
        if heading:
            section = sections.setdefault(heading[1].strip().lower(), [])
        elif content.strip():
            if section is None:
                raise LensFileError(path, line, "a line before the first section: an Optical Bench file begins with "
                                                "[descriptive data]")
            section.append((line, content.split("\t")))
    return sections


def _first(distances: dict[Any, Any], name: str) -> tuple[int, str] | None:
    """Line and text of a distance at the first position."""
    line, cells = distances.get(name.lower(), (0, []))
    return (line, cells[0].strip()) if cells and cells[0].strip() else None


def _stated(distances: dict[Any, Any], name: str, path: str) -> float | None:
    entry = _first(distances, name)
    return _number(path, *entry, name) if entry and is_number(entry[1]) else None


def _number(path: str, line: int, text: str, name: str, infinite: bool = False) -> float:
    with located(path, line):
        return file_number(text, name, infinite)


def _row(design: Design, line: int, cells: list[str], distances: dict[Any, Any]) -> Row:
    """The surface of a line of [lens data]."""
    name, radius, thickness, n_d, diameter, v_d, glass, maker = cells[:8]
    if beyond := next(filter(None, cells[8:]), ""):
        raise RowError(not_understood(f"the value {beyond} in a ninth column"))
    row = Row(line, is_stop=radius.upper() == "AS" or name.upper().endswith("AS"))
    if radius.upper() not in (*PLANES, "AS"):
        row.curvature = file_curvature(radius)
    if is_number(thickness) or thickness.lower().lstrip("+-").startswith("inf"):
        row.thickness = file_number(thickness, "thickness", infinite=True)
    else:
        entry = _first(distances, thickness)
        if entry is not None:
            row.thickness = _number(design.path, *entry, thickness, infinite=True)
        elif thickness.lower() != "bf":
            raise RowError(f"thickness {excerpt(thickness)} is neither a number nor one of the [variable distances]")
        if thickness.lower() == "bf" and isinf(row.thickness):
            row.thickness = 0.0
    if diameter:
        entry = _first(distances, diameter)
        size = file_number(diameter, "diameter") if entry is None else _number(design.path, *entry, diameter)
        if size < 0.0:
            raise RowError(f"diameter is {significant(size)}: it must be positive")
        row.semi_diameter = size / 2.0 or None
    if n_d:
        row.glass = media.stated(glass, file_number(n_d, "index n_d"),
                                 file_number(v_d, "Abbe number V_d") if v_d else 0.0, maker or None)
    elif glass:
        row.glass = media.glass_in(design, glass, maker or None)
    return row


def _powers(sections: dict[Any, Any]) -> list[int]:
    """The powers of r of the aspheric columns."""
    constants = {cells[0].strip().lower(): (cells + [""])[1].strip() for _, cells in sections.get("constants", [])}
    count = constants.get("asphericaloddcount", "0")
    odd = int(max(min(file_number(count, "AsphericalOddCount"), LONGEST), 0)) if is_number(count) else LONGEST
    if odd:
        between = [3 + i for i in range(2 * odd)]
        return (between + list(range(between[-1] + 2, between[-1] + 2 * LONGEST, 2)))[:LONGEST]
    first = 2 if "asphericala2" in constants else 4
    return list(range(first, first + 2 * LONGEST, 2))


def _bend(row: Row, cells: list[str], powers: list[int]) -> None:
    """Give a surface the radius, conic and coefficients of its line in [aspherical data]."""
    if len(cells) > 1 and cells[1].upper() not in (*PLANES, "AS"):
        row.curvature = file_curvature(cells[1])
    if len(cells) > 2 and cells[2]:
        row.conic = file_number(cells[2], "conic")
    if len(cells) - 3 > len(powers):
        raise RowError(f"{len(cells) - 3} aspheric coefficients are too many")
    for power, cell in zip(powers, cells[3:], strict=False):
        a = file_number(cell, f"the coefficient of r^{power}") if cell else 0.0
        if a:
            row.aspheric[power] = a
    if max(row.aspheric, default=0) > 20:
        raise RowError(f"a term in r^{max(row.aspheric)} is not traced: powers go to 20")


def write(lens: Lens) -> tuple[str, list[Finding]]:
    """Text of a .txt file, and findings about what it cannot hold, other than shapes."""
    remarks: list[Finding] = []
    used = {power for s in lens.surfaces for power, _ in s.aspheric}
    constants, powers = [], list(range(4, 21, 2))
    if any(power % 2 for power in used):
        highest = max(power for power in used if power % 2)
        constants = [f"AsphericalOddCount\t{(highest - 1) // 2}"]
        powers = [*range(3, highest + 2), *range(highest + 3, 21, 2)]
    elif 2 in used:
        constants, powers = ["AsphericalA2"], list(range(2, 21, 2))
    title = " ".join(lens.name.split())
    stations, left = stations_of(lens)
    lens = lens.at(zoom=0.0, close=0.0)
    last = len(lens.surfaces) - 1
    varying = {i: f"d{i + 1}" for i in (lens.positions.gaps if lens.positions else ()) if i != last}
    lines = ["[descriptive data]", f"title\t{title}", "[constants]", *constants, "[variable distances]",
             *_distance_lines(lens, stations, varying), "[lens data]"]
    bent = []
    for i, s in enumerate(lens.surfaces):
        glass = s.glass
        before = lens.surfaces[i - 1].glass if i else AIR
        radius = "Infinity" if s.curvature == 0.0 else radius_text(s.curvature)
        name = str(i + 1)
        if i == lens.stop_index:
            plain = s.curvature == 0.0 and glass.n_d == before.n_d == 1.0
            radius, name = ("AS", name) if plain else (radius, f"{name}AS")
        gap = "Bf" if i == last else varying.get(i, repr(s.thickness))
        cells = [name, radius, gap, repr(glass.n_d) if glass.n_d != 1.0 else "", repr(2.0 * s.semi_diameter),
                 repr(glass.v_d) if glass.n_d != 1.0 and glass.v_d else "", ""]
        if glass.n_d != 1.0 and glass.name:
            cells[6] = " ".join(glass.name.split())
        lines.append("\t".join(cells))
        remarks += media.glass_loss(glass, i)
        terms = dict(s.aspheric)
        lost = [f"r^{p}" for p in terms if p not in powers]
        if lost:
            remarks.append(Finding(Kind.SHAPE, i, f"surface {i}: its aspheric terms in {', '.join(lost)} cannot be "
                                                  "written with odd ones, and this is another lens"))
        if terms or s.conic:
            written = [p for p in powers if p <= max(terms, default=0)]
            bent.append("\t".join([str(i + 1), "Infinity" if s.curvature == 0.0 else radius_text(s.curvature),
                                   repr(s.conic), *(repr(terms.get(p, 0.0)) for p in written)]))
    lines += ["[aspherical data]", *bent] if bent else []
    notes = " ".join(lens.notes.split())
    lines += ["[notes]", notes] if notes else []
    remarks += left + _lost_fields(lens)
    if any(station.name for station in stations):
        remarks.append(note(Kind.POSITION, "left out: the names of its positions"))
    if title != lens.name or notes != lens.notes:
        remarks.append(note(Kind.TEXT, "name and notes are written in one line each"))
    return "\n".join([*lines, ""]), remarks


def _f_number(lens: Lens) -> float | None:
    """The stated f-number, else that of the stated aperture."""
    aperture = lens.system.aperture
    if lens.stated_f_number is None and aperture is not None and aperture.kind is ApertureKind.F_NUMBER:
        return aperture.values[0]
    return lens.stated_f_number


def _field_row(lens: Lens) -> str:
    """The row of [variable distances] for the fields of a lens; "" if none can hold them."""
    rows = (name for name, kind in FIELDS.items() if kind is lens.system.field_kind)
    return next(rows, "") if lens.system.largest_field else ""


def _lost_fields(lens: Lens) -> list[Finding]:
    """What is lost of the fields: the file holds the largest one, along y."""
    fields, kind = lens.system.fields, lens.system.field_kind
    if not fields:
        return []
    if not _field_row(lens):
        return [note(Kind.LEFT_OUT, f"left out of its system data: the fields by {kind}")]
    if fields == (FieldPoint(0.0, lens.system.largest_field),):
        return []
    return [note(Kind.LEFT_OUT, "of its fields the largest alone is written, as if it lay along y, without weight and "
                                "vignetting")]


def _distance_lines(lens: Lens, stations: list[Station], varying: dict[int, str]) -> list[str]:
    """Rows of [variable distances]: a column for each position, one for a lens without positions."""
    last = len(lens.surfaces) - 1
    stations = stations or [Station({}, lens.system.object_distances[0])]
    if stations[0].focal_length is None:
        stations[0].focal_length = lens.stated_efl
    if stations[0].f_number is None:
        stations[0].f_number = _f_number(lens)
    name = _field_row(lens)
    rows: dict[str, list[float | None]] = {
        "Focal Length": [station.focal_length for station in stations],
        "F-Number": [station.f_number for station in stations],
        **({name: [2.0 * lens.system.largest_field]} if name else {}),
        **({"Aperture Diameter": [2.0 * (station.stop or lens.stop.semi_diameter) for station in stations]}
           if any(station.stop is not None for station in stations) else {}),
        "d0": [station.distance for station in stations],
        **{name: [station.gaps[i] for station in stations] for i, name in varying.items()},
        "Bf": [station.gaps.get(last, lens.surfaces[last].thickness) for station in stations]}
    return ["\t".join([name, *("None" if v is None else "Infinity" if isinf(v) else repr(v) for v in values)])
            for name, values in rows.items()]
