"""Edits of the list of surfaces: insert, delete, split, move, scale.

Lengths in mm; surfaces are numbered from 0. Comments, solves, pickups, varying gaps and the stop go with their
surfaces; what an edit has to drop or to assume is a finding of the new document.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.lens_surface import LensError, Surface
from lensbench.core.optics.prescription import Lens, medium_before, refracts
from lensbench.core.optics.surface_numbers import THICKNESS, with_surfaces
from lensbench.core.text import significant
from lensbench.lenses.editing.document import EditError, LensDocument, Solve, varies
from lensbench.lenses.editing.order import check_fixed, check_range, pose_behind, reordered, surface_at
from lensbench.lenses.editing.solves import settled, solution
from lensbench.lenses.file_error import RowError
from lensbench.lenses.tables.design import MOST_SURFACES
from lensbench.lenses.tables.rows import check_sizes

IN_FOCUS = 0.05         # of the back focus: how far a film is set from the paraxial image to balance aberrations
SAME = 1e-9             # relative: rounding


def inserted(document: LensDocument, place: int, surfaces: Sequence[Surface], comments: Sequence[str] = (),
             gaps: dict[int, int | None] | None = None) -> LensDocument:
    """The document with surfaces before surface `place`, or behind the last one.

    comments: of the first of them. gaps: as for `reordered`, those that the new surfaces take over. EditError for
    another place, invalid sizes or too many surfaces.
    """
    count = len(document.surfaces)
    if not 0 <= place <= count:
        raise EditError(f"place {place}: it must lie from 0 to {count}")
    if count + len(surfaces) > MOST_SURFACES:
        raise EditError(f"a lens has at most {MOST_SURFACES} surfaces")
    _check(surfaces)
    order: list[int | Surface] = [*range(place), *surfaces, *range(place, count)]
    return reordered(document, order, dict(zip(range(place, place + len(surfaces)), comments, strict=False)),
                     gaps=gaps)


def inserted_plane(document: LensDocument, place: int) -> LensDocument:
    """The document with a plane before surface `place`, in the medium there: it bends no ray and moves nothing."""
    count = len(document.surfaces)
    if not 0 <= place <= count:
        raise EditError(f"place {place}: it must lie from 0 to {count}")
    near = document.surfaces[min(place, count - 1)]
    medium = medium_before(document.lens, place)
    return inserted(document, place, [Surface(0.0, near.semi_diameter, medium, curvature=0.0)],
                    gaps={place - 1: None} if _ends_at_rim(document, place - 1) else None)


def deleted(document: LensDocument, surfaces: Sequence[int]) -> LensDocument:
    """The document without some surfaces, and without the gap and the medium behind each.

    The gap of a plane that bends no ray is added to the one before it, for the first surface to the distance of the
    object of the design, so that nothing moves. If the stop is deleted, the surface that takes its place is the stop.
    EditError for a surface that does not exist, for all surfaces, or where a gap next to one varies with zoom or focus.
    """
    gone, count = set(surfaces), len(document.surfaces)
    if not gone <= set(range(count)):
        raise EditError(f"there is no surface {max(gone)}: they are numbered from 0 to {count - 1}")
    if len(gone) == count:
        raise EditError("a lens keeps at least one surface")
    check_fixed(document.lens, gone, "deleted")
    kept, grown, lead = list(document.surfaces), dict[int, int | None](), 0.0
    for i in sorted(gone):
        before = next((j for j in range(i - 1, -1, -1) if j not in gone), None)
        if refracts(document.lens, i):
            continue
        if before is None:
            lead += kept[i].thickness
        else:
            if kept[i].thickness and varies(document.lens, before):
                raise EditError(f"the gap before surface {i} varies with zoom or focus: the surface cannot be deleted")
            kept[before] = replace(kept[before], thickness=kept[before].thickness + kept[i].thickness)
            if kept[i].thickness or _ends_at_rim(document, before):
                grown[before] = None
    system = document.lens.system
    system = replace(system, object_distances=tuple(distance + lead for distance in system.object_distances))
    changed = replace(document, lens=replace(document.lens, surfaces=tuple(kept), system=system))
    return reordered(changed, [i for i in range(count) if i not in gone], gaps=grown or None)


def split(document: LensDocument, surface: int, share: float = 0.5) -> LensDocument:
    """The document with the gap behind a surface divided by a plane, behind this share of it. EditError: not 0 to 1."""
    if not 0.0 <= share <= 1.0:
        raise EditError(f"share {significant(share)}: it must lie from 0 to 1")
    front = surface_at(document, surface)
    check_fixed(document.lens, {surface}, "split")
    first = replace(front, thickness=front.thickness * share)
    rest = front.thickness - first.thickness
    behind = document.surfaces[min(surface + 1, len(document.surfaces) - 1)]
    plane = Surface(rest, max(front.semi_diameter, behind.semi_diameter), front.glass, curvature=0.0,
                    pose=pose_behind(front))
    changed = replace(document, lens=with_surfaces(document.lens, [(surface, first)]))
    # What ends at the image still does so; all other rules are of a gap that is two gaps now
    rule = document.rule(surface, THICKNESS)
    ends_at_image = isinstance(rule, Solve) and rule.kind == "image"
    return inserted(changed, surface + 1, [plane], gaps={surface: surface + 1 if ends_at_image else None})


def moved(document: LensDocument, first: int, last: int, place: int) -> LensDocument:
    """The document with a group of surfaces, and the gaps behind them, before surface `place`. EditError: gaps vary."""
    check_range(document, first, last)
    count = len(document.surfaces)
    if not 0 <= place <= count:
        raise EditError(f"place {place}: it must lie from 0 to {count}")
    if first <= place <= last + 1:
        return document
    check_fixed(document.lens, set(range(count)), "moved")
    rest = [i for i in range(count) if not first <= i <= last]
    at = len([i for i in rest if i < place])
    return reordered(document, [*rest[:at], *range(first, last + 1), *rest[at:]])


def scaled(document: LensDocument, factor: float) -> LensDocument:
    """The document scaled as a whole, with the lengths of its rules. EditError: sizes that no lens may have."""
    try:
        lens = document.lens.scaled(factor)
        for surface in lens.surfaces:
            check_sizes(surface)
    except (LensError, RowError) as error:
        raise EditError(str(error)) from None
    solves = tuple(replace(s, target=s.target * factor) if s.kind in ("image", "edge", "efl") else s
                   for s in document.solves)
    pickups = tuple(replace(p, offset=p.offset * _unit(p.quantity, factor)) for p in document.pickups)
    return settled(replace(document, lens=lens, solves=solves, pickups=pickups))


def kept_in_focus(before: Lens, document: LensDocument) -> tuple[LensDocument, tuple[Finding, ...]]:
    """The document with its last gap as far from the paraxial image as that of the lens before its edits.

    A camera focuses every lens, so that the gap is not seen to go out of focus; another program that reads the lens
    uses it as it is. The document itself, without a finding, where the gap varies, follows from a rule, was edited or
    was out of focus before.
    """
    lens, last = document.lens, len(document.surfaces) - 1
    gap = before.surfaces[-1].thickness
    if gap == 0.0 or lens.surfaces[-1].thickness != gap or varies(lens, last) or document.rule(last, THICKNESS):
        return document, ()
    try:
        was, now = (solution(each, Solve(len(each.surfaces) - 1, "image")) for each in (before, lens))
    except ArithmeticError:             # an afocal lens
        return document, ()
    moved = gap + now - was
    if not (isfinite(moved) and moved > 0.0 and abs(gap - was) <= IN_FOCUS * abs(was) and abs(now - was) > SAME * gap):
        return document, ()
    said = note(Kind.BACK_FOCUS, f"the last gap is {significant(moved, 6)} mm in place of {significant(gap, 6)} mm: it "
                                 "follows the paraxial image, which the edits moved", last, before=gap, after=moved)
    return replace(document, lens=with_surfaces(lens, [(last, replace(lens.surfaces[-1], thickness=moved))])), (said,)


def _ends_at_rim(document: LensDocument, surface: int) -> bool:
    """Whether the gap behind a surface follows from an edge thickness, and so from the next surface."""
    rule = document.rule(surface, THICKNESS)
    return isinstance(rule, Solve) and rule.kind == "edge"


def _check(surfaces: Sequence[Surface]) -> None:
    for surface in surfaces:
        try:
            check_sizes(surface)
        except RowError as error:
            raise EditError(str(error)) from None


def _unit(quantity: str, factor: float) -> float:
    """By what a number of a quantity grows with the lens."""
    if quantity in ("thickness", "semi_diameter"):
        return factor
    if quantity in ("curvature", "curvature_x"):
        return 1.0 / factor
    return 1.0 if quantity == "conic" else factor ** (1 - int(quantity[1:]))
