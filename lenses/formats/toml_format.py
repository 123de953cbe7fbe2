"""The project's own lens file: TOML with a header and one surface a row.

    format = 1
    title = "Double Gauss 50 mm f/2"
    kind = "double Gauss"
    stated_efl = 50.0
    units = "mm"
    columns = ["radius", "thickness", "n_d", "semi_diameter"]
    surfaces = [
        [29.475, 3.76,  1.67, 12.6],
        …
        [inf,    4.5,   1.0,   8.55, "stop"],
    ]

    [stop]
    blades = 9
    rotation_deg = 10.0
    roundness = 0.4

    [aspheric]
    6 = { r4 = -1.5313e-05, r6 = 9.4893e-08 }

The header, before `columns`, is described in `toml_header`. `columns` names the columns
of the rows, so that a later version can add columns. Lengths are in mm; thickness and
medium are those *after* the surface. Radius 0 or inf is a plane, V_d 0 is unknown, and
"stop" at the end of a row marks the aperture stop. Tables hold the properties that few
surfaces have, by the number of the surface from 0: `aspheric`, the coefficients of r^p
(mm^(1−p)); `radius_x`, the radius of a cylinder or toroid in the section x–z (`radius`
is that of y–z); `pose`, the decentre, tilt and roll of a tilted or decentred surface (see
`lb.SurfacePose`; angles in radians, or in degrees as tilt_x_deg); `dispersion`, the
formula of a glass; `coating`. `positions` holds the gaps of a zoom lens, or of a lens
that moves groups to focus, `system` what the lens was designed for (see `toml_tables`
for these three). `front_index` is the index of the medium in front of the lens, such as water. The table `stop`
describes an iris that is no circle: blades, their rotation in radians (`rotation_deg`:
in degrees), roundness and, of a lens that was stopped down, their reach; or it names a
picture in the stop by its path from the folder of the file, which it cannot leave:
image = "heart.png". All digits are kept: a saved lens loads equal to the last bit.
"""

import re
from collections.abc import Callable
from dataclasses import fields, replace
from math import inf, radians
from pathlib import Path
from typing import Any

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.glass import Glass
from lensbench.core.optics.lens_surface import LensError, PoseError, Surface, SurfacePose
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import excerpt
from lensbench.lenses.file_error import LensFileError, RowError, located, number
from lensbench.lenses.formats import toml_header, toml_tables
from lensbench.lenses.formats.losses import without_picture
from lensbench.lenses.formats.toml_header import digits, line_of, listed, parse, quoted
from lensbench.lenses.stop_picture import picture_beside
from lensbench.lenses.tables.rows import check_sizes, curvature, radius_text, stop_of, surface

REQUIRED = ("radius", "thickness", "n_d", "semi_diameter")
COLUMNS = ("radius", "thickness", "n_d", "V_d", "semi_diameter", "conic", "glass")
POSE = tuple(field.name for field in fields(SurfacePose))
ANGLES = ("tilt_x", "tilt_y", "roll")                   # of a pose: radians, or degrees as tilt_x_deg
STOP = ("blades", "rotation", "rotation_deg", "roundness", "reach", "image")


def read(text: str, path: str, folder: Path | None = None) -> Lens:
    """The lens of a file's text. LensFileError names `path`, the line and the mistake.

    folder: in which its picture in the stop lies; by default that of `path`.
    """
    folder = Path(path).parent if folder is None and Path(path).suffix else folder
    data = parse(text, path)
    header = toml_header.checked(data, text, path)
    columns = _columns(data.get("columns"), text, path)
    rows = data.get("surfaces")
    if not isinstance(rows, list) or not rows:
        raise LensFileError(path, line_of(text, "surfaces"), "there are no surfaces: `surfaces` must be a list of rows")
    more = _tables(data, len(rows), text, path)
    surfaces, marked = [], []
    for i, row in enumerate(rows):
        with located(path, _row_line(text, i), f"surface {i}: "):
            made, is_stop = _surface(row, columns, more.get(i, {}))
        surfaces.append(made)
        if is_stop:
            marked.append(i)
    stop_index, findings = stop_of(tuple(surfaces), marked)
    try:
        lens = Lens(tuple(surfaces), stop_index, **toml_header.fields(header), findings=(*findings, *_rules(data)))
    except LensError as error:          # a pivot that is no surface
        outside = next((i for i, surface in enumerate(surfaces) if surface.pose is not None
                        and not 0 <= i - surface.pose.pivot < len(surfaces)), None)
        raise LensFileError(path, _entry_line(text, "pose", str(outside)), str(error)) from None
    if "front_index" in header:
        with located(path, line_of(text, "front_index")):
            lens = replace(lens, front_index=header["front_index"])
    if "stop" in data:
        with located(path, line_of(text, "stop"), "stop: "):
            lens = replace(lens, **_stop(data["stop"], folder))
    name = "system"
    try:
        if name in data:
            lens = replace(lens, system=toml_tables.system_data(data[name]))
        name = "positions"
        return toml_tables.placed(lens, data[name]) if name in data else lens
    except toml_tables.TableError as error:
        line = _entry_line(text, name, error.key) if error.key else line_of(text, name)
        raise LensFileError(path, line, f"{name}: {error}") from None


def _rules(data: dict[str, Any]) -> list[Finding]:
    """A note for each solve and pickup: `lenses.load_document` keeps them, a lens has their numbers alone."""
    tables = [(name, data.get(f"{name}s")) for name in ("solve", "pickup")]
    rows = [(name, row) for name, table in tables if isinstance(table, list) for row in table if isinstance(row, dict)]
    return [note(Kind.RULE, f"a {name} sets its {excerpt(row.get('kind', row.get('quantity')))}", row["surface"])
            for name, row in rows if isinstance(row.get("surface"), int)]


def _row_line(text: str, row: int) -> int | None:
    """Line of a row, in a file with one surface a row."""
    first = line_of(text, "surfaces")
    if first is None:
        return None
    lines = text.split("\n")[first:]
    starts = [first + 1 + i for i, line in enumerate(lines) if re.match(r"\s*[^\s#\]]", line)]
    return starts[row] if row < len(starts) else first


def _columns(columns: object, text: str, path: str) -> tuple[str, ...]:
    line = line_of(text, "columns")
    if not isinstance(columns, list) or not all(isinstance(name, str) for name in columns):
        raise LensFileError(path, line, f"`columns` must name the columns of `surfaces`: {', '.join(COLUMNS)}")
    for name in columns:
        if name not in COLUMNS:
            raise LensFileError(path, line, f"column {excerpt(name)} is unknown; the columns are {', '.join(COLUMNS)}")
    for name in REQUIRED:
        if columns.count(name) != 1:
            raise LensFileError(path, line, f"there must be one column {excerpt(name)}")
    return tuple(columns)


def _tables(data: dict[str, Any], count: int, text: str, path: str) -> dict[int, dict[str, Any]]:
    """Values of the tables behind the rows, by surface number and table name."""
    more: dict[int, dict[str, Any]] = {}
    for name in ENTRIES:
        table = data.get(name, {})
        if not isinstance(table, dict):
            raise LensFileError(path, line_of(text, name),
                                f"{name} must be a table: [{name}], then a line `2 = …` for surface 2")
        for key, value in table.items():
            try:
                if not (re.fullmatch("[0-9]{1,9}", key) and int(key) < count):
                    raise RowError(f"there is no surface {excerpt(key)}: they are numbered from 0 to {count - 1}")
                if int(key) in more and name in more[int(key)]:
                    raise RowError(f"surface {int(key)} is listed twice")
                more.setdefault(int(key), {})[name] = ENTRIES[name](value)
            except RowError as error:
                raise LensFileError(path, _entry_line(text, name, key), f"{name}: {error}") from None
    return more


def _stop(table: object, folder: Path | None) -> dict[str, Any]:
    """Blades, rotation and roundness, or a picture in this folder, from the table of the stop."""
    if not isinstance(table, dict) or not table.keys() <= set(STOP):
        raise RowError(f"it must be a table [stop] of {', '.join(STOP)}")
    if "rotation" in table and "rotation_deg" in table:
        raise RowError("give the rotation in radians or in degrees, not both")
    image = picture_beside(folder, table["image"]) if "image" in table else None
    values = {name: number(value, name) for name, value in table.items() if name != "image"}
    turn = radians(values["rotation_deg"]) if "rotation_deg" in values else values.get("rotation", 0.0)
    return {"blades": values.get("blades", 0), "blade_rotation": turn, "roundness": values.get("roundness", 0.0),
            "blade_reach": values.get("reach", inf), "stop_image": image}


def _terms(value: object) -> tuple[tuple[int, float], ...]:
    """Aspheric terms from { r4 = …, r6 = … }."""
    if not isinstance(value, dict):
        raise RowError("the terms of a surface are written { r4 = 1.5e-5, r6 = -2e-8 }")
    terms = []
    for name, coefficient in value.items():
        if not re.fullmatch("r[0-9]{1,3}", name):
            raise RowError(f"{excerpt(name)} is no power of r: a term is written r4 = 1.5e-5")
        terms.append((int(name[1:]), number(coefficient, f"the coefficient of {name}")))
    return tuple(terms)


def _dispersion(value: object) -> dict[str, Any]:
    """Formula, coefficients and range of a glass from { formula = "…", coefficients = […], wavelengths = […] }."""
    if not isinstance(value, dict) or not value.keys() <= {"formula", "coefficients", "wavelengths"}:
        raise RowError('a glass is written { formula = "sellmeier", coefficients = […], wavelengths = [0.36, 2.3] }')
    formula, ends = value.get("formula", "model"), value.get("wavelengths")
    if not isinstance(formula, str):
        raise RowError("the formula of a glass must be a text in quotes")
    if ends is not None and not (isinstance(ends, list) and len(ends) == 2):
        raise RowError("wavelengths must be the two ends of a range in µm")
    return {"formula": formula, "coefficients": _numbers(value.get("coefficients", [])),
            "wavelengths": None if ends is None else _numbers(ends)}


def _numbers(value: object) -> Any:
    """A list of numbers, or of lists of them, as tuples."""
    if isinstance(value, list):
        return tuple(_numbers(item) for item in value)
    return number(value, "a coefficient")


def _pose(value: object) -> SurfacePose:
    """The pose of a surface from { decentre_y = 0.5, tilt_x_deg = 2.0, pivot = 1 }."""
    if not isinstance(value, dict) or not value.keys() <= {*POSE, *(f"{name}_deg" for name in ANGLES)}:
        raise RowError(f"a pose is written {{ decentre_y = 0.5, tilt_x_deg = 2.0 }}, of {', '.join(POSE)}; angles "
                       f"in degrees are {', '.join(f'{name}_deg' for name in ANGLES)}")
    numbers: dict[str, Any] = {name: number(component, name) for name, component in value.items()}
    for name in ANGLES:
        if f"{name}_deg" in numbers:
            if name in numbers:
                raise RowError(f"give {name} in radians or in degrees, not both")
            numbers[name] = radians(numbers.pop(f"{name}_deg"))
    try:
        return SurfacePose(**numbers)
    except PoseError as error:
        raise RowError(str(error)) from None


# The reader of an entry of each table behind the rows
ENTRIES: dict[str, Callable[[object], Any]] = {"aspheric": _terms, "radius_x": curvature, "pose": _pose,
                                                   "dispersion": _dispersion, "coating": toml_tables.coating}


def _entry_line(text: str, table: str, key: str) -> int | None:
    """Line of the entry of a surface in a table."""
    first = line_of(text, table)
    if first is None:
        return None
    for i, line in enumerate(text.split("\n")[first - 1:]):
        if re.match(rf"""\s*(\[?{table}\.)?["']?{re.escape(key)}["']?\s*[=\].]""", line):
            return first + i
    return first


def _surface(row: object, columns: tuple[str, ...], more: dict[str, Any]) -> tuple[Surface, bool]:
    """The surface of a row and of its table entries, and whether it is marked as the stop."""
    if not isinstance(row, list):
        raise RowError("a row must be a list in brackets")
    is_stop = len(row) == len(columns) + 1 and row[-1] == "stop"
    if len(row) - is_stop != len(columns):
        raise RowError(f"the row has {len(row)} values, but there are {len(columns)} columns: {', '.join(columns)}")
    values = dict(zip(columns, row, strict=False))
    glass = values.get("glass", "")
    if not isinstance(glass, str):
        raise RowError("the name of a glass must be a text in quotes")
    made = surface(values["radius"], values["thickness"], values["n_d"], values["semi_diameter"],
                   values.get("V_d"), glass)
    try:
        if "dispersion" in more:
            made = replace(made, glass=Glass(made.glass.n_d, made.glass.v_d, glass, **more["dispersion"]))
        made = replace(made, conic=number(values.get("conic", 0.0), "conic"), aspheric=more.get("aspheric", ()),
                       curvature_x=more.get("radius_x"), coating=more.get("coating"),
                       pose=more.get("pose"))
        check_sizes(made)
    except ValueError as error:
        raise RowError(str(error)) from None
    return made, is_stop


def write(lens: Lens) -> tuple[str, list[Finding]]:
    """Text of a lens file, and findings about what it cannot hold: a picture in the stop without a name for its file.

    `with_picture_beside` gives it one.
    """
    lines = toml_header.lines(lens)

    # The columns that some surface fills, aligned as in a printed table
    columns = {
        "radius": [radius_text(s.curvature) for s in lens.surfaces],
        "thickness": [digits(s.thickness) for s in lens.surfaces],
        "n_d": [digits(s.glass.n_d) for s in lens.surfaces],
        "V_d": [digits(s.glass.v_d) if s.glass.v_d else "0" for s in lens.surfaces],
        "semi_diameter": [digits(s.semi_diameter) for s in lens.surfaces],
        "conic": [digits(s.conic) if s.conic else "0" for s in lens.surfaces],
        "glass": [quoted(s.glass.name) for s in lens.surfaces],
    }
    if all(text == "0" for text in columns["conic"]):
        del columns["conic"]
    if all(text == "0" for text in columns["V_d"]):
        del columns["V_d"]
    if all(text == '""' for text in columns["glass"]):
        del columns["glass"]
    lines.append(f"columns = [{', '.join(map(quoted, columns))}]")
    lines.append("surfaces = [")
    widths = [max(map(len, column)) for column in columns.values()]
    for i, row in enumerate(zip(*columns.values(), strict=True)):
        cells = ", ".join(text.rjust(width) for text, width in zip(row, widths, strict=True))
        mark = ', "stop"' if i == lens.stop_index else ""
        lines.append(f"    [{cells}{mark}],")
    lines.append("]")
    pictured = lens.stop_image is not None and lens.stop_image.name != ""
    if pictured and lens.stop_image is not None:
        lines += ["", "[stop]", f"image = {quoted(lens.stop_image.name)}"]
    elif lens.blades or lens.blade_rotation or lens.roundness or lens.blade_reach < inf:
        lines += ["", "[stop]", f"blades = {lens.blades}", f"rotation = {digits(lens.blade_rotation)}",
                  f"roundness = {digits(lens.roundness)}"]
        if lens.blade_reach < inf:
            lines.append(f"reach = {digits(lens.blade_reach)}")
    for table, entries in _entries(lens).items():
        if entries:
            lines += ["", f"[{table}]", *(f"{i} = {entry}" for i, entry in entries.items())]
    if system := toml_tables.system_lines(lens.system):
        lines += ["", *system]
    if lens.positions is not None:
        lines += ["", *toml_tables.position_lines(lens.positions)]
    return "\n".join([*lines, ""]), [] if pictured or lens.stop_image is None else [without_picture(lens)]


def _entries(lens: Lens) -> dict[str, dict[int, str]]:
    """Entries of the tables behind the rows, by surface number."""
    tables: dict[str, dict[int, str]] = {name: {} for name in ENTRIES}
    for i, s in enumerate(lens.surfaces):
        glass = s.glass
        if s.aspheric:
            tables["aspheric"][i] = f"{{ {', '.join(f'r{power} = {digits(a)}' for power, a in s.aspheric)} }}"
        if s.curvature_x is not None:
            tables["radius_x"][i] = radius_text(s.curvature_x)
        if s.coating is not None:
            tables["coating"][i] = toml_tables.coating_entry(s.coating)
        if s.pose is not None:
            numbers = {name: getattr(s.pose, name) for name in POSE}
            tables["pose"][i] = f"{{ {', '.join(f'{k} = {digits(v)}' for k, v in numbers.items() if v)} }}"
        if glass != Glass(glass.n_d, glass.v_d, glass.name):
            ends = "" if glass.wavelengths is None else f", wavelengths = {listed(glass.wavelengths)}"
            tables["dispersion"][i] = (f"{{ formula = {quoted(glass.formula)}, "
                                       f"coefficients = {listed(glass.coefficients)}{ends} }}")
    return tables


