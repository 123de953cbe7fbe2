"""The document of an edited lens: its prescription, comments, and the numbers that follow from others.

Lengths in mm, in the lens frame; surfaces are numbered from 0. A document is a frozen value: every edit returns a new
one. The lens of a document may be one that cannot be built; `faults` names the surface. As text it is the project's own
lens file with comments, solves and pickups, which reads back equal to the last bit; other formats hold the lens alone.

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
"""

import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.optics.prescription import CURVATURE, POSE, QUANTITIES, SEMI_DIAMETER, THICKNESS, WORDS, Lens
from lensbench.core.text import excerpt, significant
from lensbench.lenses.file_error import LensFileError
from lensbench.lenses.formats import toml_format
from lensbench.lenses.formats.toml_header import digits, line_of, quoted

# What a solve keeps, and the quantity of a surface that it adjusts for that
SOLVES = {"image": THICKNESS, "edge": THICKNESS, "efl": CURVATURE, "marginal slope": CURVATURE,
          "f-number": SEMI_DIAMETER}
TARGETS = {"image": "the gap ends at the paraxial image", "edge": "edge thickness (mm)", "efl": "focal length (mm)",
           "marginal slope": "slope of the paraxial marginal ray behind the surface", "f-number": "f-number"}


class EditError(ValueError):
    """An edit that the document does not allow; the message says why, and what to do."""


@dataclass(frozen=True)
class Solve:
    """A number that follows from a target; EditError for an unknown kind, or a target that no lens meets.

    kind: "image" (thickness: the gap ends `target` mm before the paraxial image), "edge" (thickness: that at the edge,
    mm), "efl" (curvature: focal length, mm), "marginal slope" (curvature: slope of the paraxial marginal ray behind the
    surface), "f-number" (semi-diameter of the stop).
    """

    surface: int
    kind: str
    target: float = 0.0

    def __post_init__(self) -> None:
        if self.kind not in SOLVES:
            raise EditError(f"solve {self.kind!r}: choose one of {', '.join(SOLVES)}")
        if not abs(self.target) < 1e9:
            raise EditError(f"target {self.target} of a solve: it must be a finite number")
        if (self.kind == "efl" and self.target == 0.0) or (self.kind == "f-number" and self.target <= 0.0):
            raise EditError(f"{TARGETS[self.kind]} {significant(self.target)}: it must not be 0" if self.kind == "efl"
                            else f"f-number {significant(self.target)}: it must be positive")

    @property
    def quantity(self) -> str:
        """The quantity that is adjusted, one of QUANTITIES."""
        return SOLVES[self.kind]

    def __str__(self) -> str:
        if self.kind == "image" and not self.target:
            return TARGETS["image"]
        return f"{TARGETS[self.kind]} {significant(self.target)}"


@dataclass(frozen=True)
class Pickup:
    """A number that is a multiple of the same quantity of another surface, plus an offset.

    offset: in the unit of the quantity (1/mm for a curvature). EditError for an unknown quantity, a source that is the
    surface itself, or numbers that are not finite.
    """

    surface: int
    quantity: str
    source: int
    factor: float = 1.0
    offset: float = 0.0

    def __post_init__(self) -> None:
        if self.quantity not in QUANTITIES:
            raise EditError(f"quantity {self.quantity!r}: choose one of {', '.join(QUANTITIES)}")
        if self.surface == self.source:
            raise EditError(f"surface {self.surface}: a number cannot follow itself")
        if not (abs(self.factor) < 1e9 and abs(self.offset) < 1e9):
            raise EditError("factor and offset of a pickup must be finite numbers")

    def __str__(self) -> str:
        factor = "" if self.factor == 1.0 else f"{significant(self.factor)} × "
        offset = "" if self.offset == 0.0 else f" {'+' if self.offset > 0.0 else '-'} {significant(abs(self.offset))}"
        return f"{factor}that of surface {self.source}{offset}"


class Places(NamedTuple):
    """Surface indices before an edit → after it; those that are gone are left out.

    gaps: the same of the gaps, by the surface before each.
    """

    surfaces: dict[int, int]
    gaps: dict[int, int]

    def of(self, surface: int, quantity: str) -> int | None:
        """The surface that now has a number of a surface before the edit; None where it is gone."""
        return (self.gaps if quantity == THICKNESS else self.surfaces).get(surface)

    def then(self, later: "Places") -> "Places":
        """The indices after another edit, which followed."""
        return Places(*({old: after[new] for old, new in before.items() if new in after}
                        for before, after in zip(self, later, strict=True)))

    def undone(self) -> "Places":
        """The indices after the undo of the edit."""
        return Places(*({new: old for old, new in numbers.items()} for numbers in self))


@dataclass(frozen=True)
class LensDocument:
    """A lens that is edited: its prescription, a comment for each surface (or none at all), solves and pickups.

    lens: at the positions of its first zoom and focus station. findings: solves that have no solution, and what the
    latest edit assumed; places: where the latest edit has renumbered surfaces; comparisons ignore both. EditError for a
    rule of a surface that the lens does not have, two rules for one number, or pickups in a circle.
    """

    lens: Lens
    comments: tuple[str, ...] = ()
    solves: tuple[Solve, ...] = ()
    pickups: tuple[Pickup, ...] = ()
    findings: tuple[Finding, ...] = field(default=(), compare=False)
    places: Places | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        count = len(self.lens.surfaces)
        if self.comments and len(self.comments) != count:
            raise EditError(f"{len(self.comments)} comments for {count} surfaces")
        if self.comments and not any(self.comments):
            object.__setattr__(self, "comments", ())
        for rule in self.rules:
            sources = (rule.surface, rule.source) if isinstance(rule, Pickup) else (rule.surface,)
            if not all(0 <= i < count for i in sources):
                raise EditError(f"a solve or pickup names surface {max(sources)}: they are numbered from 0 to "
                                f"{count - 1}")
            if isinstance(rule, Solve) and rule.kind == "edge" and rule.surface == count - 1:
                raise EditError("behind the last surface there is no edge")
            if isinstance(rule, Solve) and rule.kind == "f-number" and rule.surface != self.lens.stop_index:
                raise EditError(f"surface {rule.surface} is not the stop: only the stop's semi-diameter follows from "
                                "the f-number")
            if rule.quantity == THICKNESS and varies(self.lens, rule.surface):
                raise EditError(f"the gap behind surface {rule.surface} varies with zoom or focus: it cannot follow "
                                "from others")
            if rule.quantity == SEMI_DIAMETER and rule.surface == self.lens.stop_index \
                    and self.lens.positions is not None and self.lens.positions.stops:
                raise EditError("the stop varies with zoom or focus: its semi-diameter cannot follow from others")
        cells = [(rule.surface, rule.quantity) for rule in self.rules]
        twice = next((cell for cell in cells if cells.count(cell) > 1), None)
        if twice is not None:
            raise EditError(f"the {words(twice[1])} of surface {twice[0]} follows from two rules: remove one first")
        follows = {(p.surface, p.quantity): (p.source, p.quantity) for p in self.pickups}
        for start in follows:
            cell, steps = start, 0
            while cell in follows and steps <= len(follows):
                cell, steps = follows[cell], steps + 1
            if cell in follows:
                raise EditError(f"the {words(start[1])} of surface {start[0]} would follow itself, in a circle")
        object.__setattr__(self, "solves", tuple(sorted(self.solves, key=lambda s: (s.surface, s.kind))))
        object.__setattr__(self, "pickups", tuple(sorted(self.pickups, key=lambda p: (p.surface, p.quantity))))

    @property
    def surfaces(self) -> tuple[Surface, ...]:
        """Those of the lens."""
        return self.lens.surfaces

    @property
    def rules(self) -> list[Solve | Pickup]:
        """Solves and pickups."""
        return [*self.solves, *self.pickups]

    def comment(self, surface: int) -> str:
        """The comment on a surface; "" for none."""
        return self.comments[surface] if self.comments else ""

    def rule(self, surface: int, quantity: str) -> Solve | Pickup | None:
        """What a number follows from; None for an independent one."""
        return next((rule for rule in self.rules if (rule.surface, rule.quantity) == (surface, quantity)),
                    None)


def words(quantity: str) -> str:
    """A quantity in words, such as "radius" or "coefficient of r⁴"."""
    raised = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
    return WORDS.get(quantity) or POSE.get(quantity) or f"coefficient of r{quantity[1:].translate(raised)}"


def varies(lens: Lens, surface: int) -> bool:
    """Whether the gap behind a surface varies with zoom or focus."""
    return lens.positions is not None and surface in lens.positions.gaps


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
