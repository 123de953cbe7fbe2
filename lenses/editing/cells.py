"""Edits of single numbers of a document: radius, thickness, glass, rim, coefficients, comment, solves and pickups.

Lengths in mm. Each function returns a new document, with the solves and pickups settled.
"""

from dataclasses import replace
from math import isfinite

from lensbench.core.optics.glass import AIR, Glass, GlassError
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.prescription import (
    CURVATURE, CURVATURE_X, QUANTITIES, THICKNESS, Lens, with_surfaces, with_value_of
)
from lensbench.core.optics.zoom_positions import Positions
from lensbench.core.text import excerpt
from lensbench.lenses.editing.document import EditError, LensDocument, Pickup, Solve, words
from lensbench.lenses.editing.solves import settled
from lensbench.lenses.editing.structure import surface_at
from lensbench.lenses.file_error import RowError
from lensbench.lenses.glass import catalogue
from lensbench.lenses.tables.rows import check_sizes, curvature

LONGEST_COMMENT = 200


def with_value(document: LensDocument, surface: int, quantity: str, value: float) -> LensDocument:
    """The document with one number of a surface changed, and all that follows from it.

    quantity: one of QUANTITIES (curvatures in 1/mm, lengths in mm, coefficients in mm^(1 − p)). A gap that varies with
    zoom or focus is changed at the position of the document's lens. EditError for a number that a surface cannot have,
    one that follows from a rule, or a gap of a zoom between two stations.
    """
    if quantity not in QUANTITIES:
        raise EditError(f"quantity {excerpt(quantity)}: choose one of {', '.join(QUANTITIES)}")
    before = surface_at(document, surface)
    rule = document.rule(surface, quantity)
    if rule is not None:
        raise EditError(f"the {words(quantity)} of surface {surface} follows from a rule ({rule}): remove it first")
    if not isfinite(value):
        raise EditError(f"{words(quantity)} {value}: type a finite number")
    try:
        made = with_value_of(before, quantity, value)
        check_sizes(made)
    except (LensError, RowError, ArithmeticError) as error:
        raise EditError(f"surface {surface}: {error}") from None
    if made == before:
        return document
    lens = with_surfaces(document.lens, [(surface, made)])
    if document.lens.positions is not None:
        lens = _at_station(lens, surface, quantity, value)
    return settled(replace(document, lens=lens))


def _at_station(lens: Lens, surface: int, quantity: str, value: float) -> Lens:
    """The lens with a number of its table of positions changed too, where that number is one of the table."""
    positions = lens.positions
    assert positions is not None
    stop_varies = bool(positions.stops) and surface == lens.stop_index and quantity == "semi_diameter"
    gap_varies = quantity == THICKNESS and surface in positions.gaps
    if not (stop_varies or gap_varies):
        return lens
    i, j = station(positions)
    if stop_varies:
        grid = [list(row) for row in positions.stops]
        grid[i][j] = value
        return replace(lens, positions=replace(positions, stops=tuple(map(tuple, grid))))
    k = positions.gaps.index(surface)
    table = [[list(gaps) for gaps in row] for row in positions.thicknesses]
    table[i][j][k] = value
    return replace(lens, positions=replace(positions, thicknesses=tuple(
        tuple(tuple(gaps) for gaps in row) for row in table)))


def station(positions: Positions) -> tuple[int, int]:
    """Indices of the zoom and focus positions at which a lens stands; EditError between two of them."""
    if positions.zoom not in positions.zoom_stations or positions.close not in positions.focus_stations:
        names = "; ".join(positions.label(i) for i in range(len(positions.zoom_stations)))
        raise EditError("this gap varies with the zoom: set the zoom to one of the lens's zoom positions to edit it "
                        f"({names})")
    return positions.zoom_stations.index(positions.zoom), positions.focus_stations.index(positions.close)


def with_radius(document: LensDocument, surface: int, radius: object, section: str = "y") -> LensDocument:
    """The document with another radius (mm; 0 and inf: a plane), of the section y–z, or "x" for x–z of a toroid.

    EditError as for `with_value`, and for a text that is no number.
    """
    try:
        c = curvature(radius)
    except RowError as error:
        raise EditError(f"surface {surface}: {error}") from None
    return with_value(document, surface, CURVATURE if section == "y" else CURVATURE_X, c)


def with_glass(document: LensDocument, surface: int, glass: Glass | str) -> LensDocument:
    """The document with another medium behind a surface: a value, or a text as of `named_glass`."""
    before = surface_at(document, surface)
    made = named_glass(glass) if isinstance(glass, str) else glass
    try:
        changed = replace(before, glass=made)
        check_sizes(changed)
    except RowError as error:
        raise EditError(f"surface {surface}: {error}") from None
    return settled(replace(document, lens=with_surfaces(document.lens, [(surface, changed)])))


def named_glass(text: str) -> Glass:
    """The glass of a name, a name with its maker, a six-digit code, or n_d with V_d; "" or "air" is air.

    EditError for an unknown glass; the message names the nearest.
    """
    text = text.strip()
    if text.lower() in ("", "air"):
        return AIR
    numbers = [word for word in text.replace(";", " ").split() if word]
    try:
        figures = [float(word.replace(",", ".")) for word in numbers]
    except ValueError:
        figures = []
    try:
        if figures and (len(figures) == 2 or "." in text or "," in text) and figures[0] < 100.0:
            if len(figures) > 2:
                raise EditError(f"glass {excerpt(text)}: type a name, or n_d and V_d such as 1.5168 64.17")
            return Glass(figures[0], figures[1] if len(figures) == 2 and figures[1] else None)
        return catalogue.resolve(text).glass
    except GlassError as error:
        raise EditError(str(error)) from None


def with_comment(document: LensDocument, surface: int, comment: str) -> LensDocument:
    """The document with a comment on a surface, in one line of at most LONGEST_COMMENT characters."""
    surface_at(document, surface)
    comments = list(document.comments or ("",) * len(document.surfaces))
    comments[surface] = " ".join(comment.split())[:LONGEST_COMMENT]
    return replace(document, comments=tuple(comments))


def with_rule(document: LensDocument, rule: Solve | Pickup) -> LensDocument:
    """The document with a solve or pickup, instead of another one of the same number."""
    kept = without_rule(document, rule.surface, rule.quantity)
    if isinstance(rule, Solve):
        return settled(replace(kept, solves=(*kept.solves, rule)))
    return settled(replace(kept, pickups=(*kept.pickups, rule)))


def without_rule(document: LensDocument, surface: int, quantity: str) -> LensDocument:
    """The document with a number made independent, which keeps its value."""
    def other(rule: Solve | Pickup) -> bool:
        return (rule.surface, rule.quantity) != (surface, quantity)

    return settled(replace(document, solves=tuple(filter(other, document.solves)),
                           pickups=tuple(filter(other, document.pickups)),
                           findings=tuple(f for f in document.findings if f.surface != surface)))
