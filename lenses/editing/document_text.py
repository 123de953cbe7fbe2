"""Documents as text: the project's own lens file with comments, solves and pickups.

    [comments]
    3 = "cemented"

    [[solves]]
    surface = 5
    kind = "efl"
    target = 50.0

    [[pickups]]
    surface = 4
    quantity = "curvature"
    source = 1
    factor = -1.0
    offset = 0.0

A document reads back equal to the last bit. Other formats hold the lens alone.
"""

import tomllib
from pathlib import Path
from typing import Any

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.text import excerpt
from lensbench.lenses.editing.document import EditError, LensDocument, Pickup, Solve
from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.formats import toml_format
from lensbench.lenses.formats.toml_header import digits, line_of, quoted

TABLES = ("comments", "solves", "pickups")


def to_text(document: LensDocument) -> str:
    """The document as the text of a lens file (TOML)."""
    return with_edits(toml_format.write(document.lens)[0], document)


def with_edits(text: str, document: LensDocument) -> str:
    """The text of its lens with the comments, solves and pickups of a document."""
    lines = [text.rstrip("\n")]
    if document.comments:
        lines += ["", "[comments]", *(f"{i} = {quoted(text)}" for i, text in enumerate(document.comments) if text)]
    for solve in document.solves:
        lines += ["", "[[solves]]", f"surface = {solve.surface}", f"kind = {quoted(solve.kind)}",
                  f"target = {digits(solve.target)}"]
    for pickup in document.pickups:
        lines += ["", "[[pickups]]", f"surface = {pickup.surface}", f"quantity = {quoted(pickup.quantity)}",
                  f"source = {pickup.source}", f"factor = {digits(pickup.factor)}",
                  f"offset = {digits(pickup.offset)}"]
    return "\n".join([*lines, ""])


def from_text(text: str, path: str = "edited lens", folder: Path | None = None) -> LensDocument:
    """The document of a text in the project's own format, as it is: nothing is solved anew.

    folder: of a picture in the stop; None: that of `path`, if it is the path of a file. LensFileError names `path` and
    the line of a mistake.
    """
    lens = toml_format.read(text, path, folder)
    data = tomllib.loads(text) if any(table in text for table in TABLES) else {}    # a second time takes as long
    for table in TABLES:
        try:
            if table == "comments":
                comments = _comments(data.get(table, {}), len(lens.surfaces))
            elif table == "solves":
                solves = tuple(Solve(**_entry(row, {"surface": int, "kind": str, "target": float}))
                               for row in _list(data.get(table, [])))
            else:
                pickups = tuple(Pickup(**_entry(row, {"surface": int, "quantity": str, "source": int, "factor": float,
                                                      "offset": float})) for row in _list(data.get(table, [])))
        except (EditError, TypeError) as error:
            raise LensFileError(path, line_of(text, table), f"{table}: {error}") from None
    try:
        return LensDocument(lens, comments, solves, pickups)
    except EditError as error:
        raise LensFileError(path, line_of(text, "solves") or line_of(text, "pickups"), str(error)) from None


def lost_edits(document: LensDocument, why: str = "only .toml holds them") -> tuple[Finding, ...]:
    """The finding about comments, solves and pickups, which only .toml holds, or are lost for another reason."""
    what = [name for name, values in zip(TABLES, (document.comments, document.solves, document.pickups), strict=True)
            if values]
    return (note(Kind.LEFT_OUT, f"left out: {', '.join(what)}; {why}"),) if what else ()


def _comments(table: object, count: int) -> tuple[str, ...]:
    if not isinstance(table, dict) or not all(isinstance(text, str) for text in table.values()):
        raise EditError('they are written [comments], then a line `2 = "…"` for surface 2')
    made = [""] * count
    for key, text in table.items():
        if not (key.isascii() and key.isdecimal() and len(key) < 6 and int(key) < count):
            raise EditError(f"there is no surface {excerpt(key)}: they are numbered from 0 to {count - 1}")
        made[int(key)] = text
    return tuple(made) if table else ()


def _list(value: object) -> list[Any]:
    if not isinstance(value, list):
        raise EditError("each is a table of its own, with its name in double brackets")
    return value


def _entry(row: object, kinds: dict[str, type]) -> dict[str, Any]:
    """The values of one solve or pickup, checked by their kinds."""
    if not isinstance(row, dict):
        raise EditError("each is a table of its own, with its name in double brackets")
    made = {}
    for key, value in row.items():
        if key not in kinds:
            raise EditError(f"{excerpt(key)} is unknown; there are {', '.join(kinds)}")
        kind = kinds[key]
        if isinstance(value, bool) or not isinstance(value, (int, float) if kind is float else kind):
            raise EditError(f"{key} is {excerpt(value)}: it must be a {'text' if kind is str else 'number'}")
        made[key] = kind(value)
    return made
