"""The table [positions] of the project's own lens file: gaps of a lens that zooms, or moves groups to focus.

    [positions]
    zoom_stations = [0.0, 0.38, 1.0]            # 0 wide, 1 tele
    focus_stations = [0.0, 1.0]                 # 0 infinity, 1 the nearest
    focal_lengths = [71.4, 105.0, 196.0]        # as stated, one a zoom station; f_numbers and names too
    distances = [[inf, 1500.0], [inf, 1500.0], [inf, 1500.0]]   # of the object from the film

    [positions.gaps]                            # behind surface 4: a row for each zoom station,
    4 = [[14.1595, 4.4399], [14.1595, 4.4399], [14.1595, 4.4399]]       # a value for each focus station

Lengths in mm. `stops`, if the size of the stop varies, has its semi-diameter at each
station. `zoom` and `close` are the present position, 0 by default: wide, and focused
at infinity. Without zoom_stations the stations are even in the logarithm of the focal
length; without focus_stations, even in the reciprocal of the distance.
"""

import re
from dataclasses import replace
from typing import Any

from lensbench.core.optics.finding import Kind, note
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.zoom_positions import Positions, PositionsError
from lensbench.core.text import excerpt, significant
from lensbench.lenses.file_error import RowError, number
from lensbench.lenses.formats.toml_header import digits, listed, quoted
from lensbench.lenses.tables.paraxial import focal_length
from lensbench.lenses.tables.stations import focus_fractions, with_gaps, zoom_fractions

STATIONS = ("zoom_stations", "focus_stations")
ROWS = (*STATIONS, "focal_lengths", "f_numbers")
GRIDS = ("distances", "stops")
KEYS = ("names", *ROWS, *GRIDS, "zoom", "close", "gaps")


class TableError(ValueError):
    """An invalid table of positions. key: the key with the mistake, None: the table as a whole."""

    def __init__(self, message: str, key: str | None = None):
        super().__init__(message)
        self.key = key


def placed(lens: Lens, table: object) -> Lens:
    """The lens of the file's rows with the positions of its table, at the position that the table states."""
    if not isinstance(table, dict):
        raise TableError("they must be a table: [positions], with [positions.gaps]")
    for key in table:
        if key not in KEYS:
            raise TableError(f"{excerpt(key)} is unknown; there are {', '.join(KEYS)}", key)
    gaps = table.get("gaps")
    if not isinstance(gaps, dict) or not gaps:
        raise TableError("the varying gaps are missing: [positions.gaps], then a line `4 = [[14.1, 4.4], …]` for the "
                         "one behind surface 4", "gaps" if "gaps" in table else None)
    columns: dict[int, list[list[float]]] = {}
    for key, grid in gaps.items():
        if not (re.fullmatch("[0-9]{1,9}", key) and int(key) < len(lens.surfaces)):
            raise TableError(f"there is no surface {excerpt(key)}: they are numbered from 0 to "
                             f"{len(lens.surfaces) - 1}", key)
        if int(key) in columns:
            raise TableError(f"surface {int(key)} is listed twice", key)
        columns[int(key)] = _grid(grid, key)
    order = sorted(columns)
    shape = [len(row) for row in columns[order[0]]]
    for i in order:
        if [len(row) for row in columns[i]] != shape:
            raise TableError(f"the gap behind surface {i} has another number of stations than that behind {order[0]}",
                             str(i))
    thicknesses = tuple(tuple(zip(*row, strict=True)) for row in zip(*(columns[i] for i in order), strict=True))

    values: dict[str, Any] = {key: tuple(_row(table[key], key)) for key in ROWS if key in table}
    values |= {key: tuple(map(tuple, _grid(table[key], key, infinite=True))) for key in GRIDS if key in table}
    values |= {key: _number(table[key], key) for key in ("zoom", "close") if key in table}
    if "names" in table:
        if not (isinstance(table["names"], list) and all(isinstance(name, str) for name in table["names"])):
            raise TableError("names must be a list of texts in quotes", "names")
        values["names"] = tuple(table["names"])
    if "zoom_stations" not in values:
        values["zoom_stations"] = zoom_fractions([focal_length(with_gaps(lens.surfaces, order, row[0]))
                                               for row in thicknesses])
    if "focus_stations" not in values:
        distances = values.get("distances") or [[0.0] * shape[0]]
        values["focus_stations"] = focus_fractions(distances[0])
    try:
        positions = Positions(tuple(order), thicknesses, **values)
        moved = Lens(lens.surfaces, lens.stop_index, positions=positions).at()
    except (PositionsError, LensError) as error:
        raise TableError(str(error)) from None
    return _at_stated_position(lens, moved)


def _at_stated_position(lens: Lens, moved: Lens) -> Lens:
    """The lens at its stated position, with a finding if the rows have other gaps."""
    positions = moved.positions
    assert positions is not None
    off = [i for i in positions.gaps if lens.surfaces[i].thickness != moved.surfaces[i].thickness]
    findings = [note(Kind.POSITION, f"surface {i}: the thickness of its row, {significant(lens.surfaces[i].thickness)} "
                                    f"mm, is not that of its position, {significant(moved.surfaces[i].thickness)} mm, "
                                    f"which is taken", i)
                for i in off]
    return replace(lens, positions=positions, findings=(*lens.findings, *findings)).at()


def _number(value: object, key: str, infinite: bool = False) -> float:
    try:
        return number(value, key, infinite)
    except RowError as error:
        raise TableError(str(error), key) from None


def _row(value: object, key: str, infinite: bool = False) -> list[float]:
    if not isinstance(value, list) or not value:
        raise TableError(f"{key} must be a list of numbers", key)
    return [_number(item, key, infinite) for item in value]


def _grid(value: object, key: str, infinite: bool = False) -> list[list[float]]:
    """A row for each zoom station, with a number for each focus station."""
    if not isinstance(value, list) or not value:
        raise TableError(f"{key} must be a list of rows: one for each zoom station, with a number for each focus "
                         "station", key)
    return [_row(row, key, infinite) for row in value]


def lines(positions: Positions) -> list[str]:
    """Lines of the table in a file."""
    written = ["[positions]"]
    if positions.names:
        written.append(f"names = [{', '.join(map(quoted, positions.names))}]")
    written += [f"{key} = {listed(getattr(positions, key))}" for key in (*ROWS, *GRIDS)
                if getattr(positions, key) and (getattr(positions, key) != (0.0,) or key not in STATIONS)]
    written += [f"{key} = {digits(getattr(positions, key))}" for key in ("zoom", "close") if getattr(positions, key)]
    written += ["", "[positions.gaps]"]
    for k, i in enumerate(positions.gaps):
        grid = tuple(tuple(gaps[k] for gaps in row) for row in positions.thicknesses)
        written.append(f"{i} = {listed(grid)}")
    return written
