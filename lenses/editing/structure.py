"""Edits of the list of surfaces: insert, delete, split, move, scale, and where the stop is.

Lengths in mm; surfaces are numbered from 0. Comments, solves, pickups, varying gaps and the stop go with their
surfaces; what an edit has to drop or to assume is a finding of the new document.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.lens_surface import LensError, Surface, SurfacePose
from lensbench.core.optics.prescription import THICKNESS, Lens, medium_before, refracts, with_surfaces
from lensbench.core.text import significant
from lensbench.lenses.editing.document import EditError, LensDocument, Places, Solve, varies
from lensbench.lenses.editing.solves import settled, solution
from lensbench.lenses.file_error import RowError
from lensbench.lenses.tables.design import MOST_SURFACES
from lensbench.lenses.tables.paraxial import ray
from lensbench.lenses.tables.rows import check_sizes

IN_FOCUS = 0.05         # of the back focus: how far a film is set from the paraxial image to balance aberrations
SAME = 1e-9             # relative: rounding


def reordered(document: LensDocument, order: Sequence[int | Surface], comments: dict[int, str] | None = None,
              settle: bool = True, gaps: dict[int, int | None] | None = None) -> LensDocument:
    """The document with its surfaces, and all that belongs to them, in another order; EditError: no lens can have it.

    order: indices of surfaces, and new ones. comments: of new surfaces, by index. settle: whether solves and pickups
    are settled. gaps: those that do not stay behind their surface, by its index before, with that of the surface which
    then has the gap; None where the gap is gone, so that its rules go too. Rules of thicknesses follow their gaps.
    """
    lens, findings = document.lens, list(document.findings)
    index_of = {old: new for new, old in enumerate(order) if isinstance(old, int)}
    surfaces = tuple(_pivoted(lens, item, new, index_of, findings) if isinstance(item, int) else item
                     for new, item in enumerate(order))
    said = tuple((comments or {}).get(new, "") if not isinstance(item, int) else document.comment(item)
                 for new, item in enumerate(order))

    # The stop: itself, or the nearest surface behind it that is left, else the last
    stop = index_of.get(lens.stop_index)
    if stop is None:
        later = [index_of[old] for old in sorted(index_of) if old > lens.stop_index]
        stop = later[0] if later else len(surfaces) - 1
        findings.append(Finding(Kind.MOVED_STOP, stop, f"the stop was deleted: surface {stop} is the stop now"))

    # Rules go with their surfaces, those of thicknesses with their gaps
    behind = {old: new for old, new in {**index_of, **(gaps or {})}.items() if new is not None}

    def place_of(surface: int, quantity: str) -> int | None:
        return (behind if quantity == THICKNESS else index_of).get(surface)

    kept = [replace(s, surface=index) for s in document.solves
            if (index := place_of(s.surface, s.quantity)) is not None]
    solves = tuple(replace(s, surface=stop) if s.kind == "f-number" else s for s in kept
                   if not (s.kind == "edge" and s.surface == len(surfaces) - 1))
    pickups = tuple(replace(p, surface=index, source=source) for p in document.pickups
                    if (index := place_of(p.surface, p.quantity)) is not None
                    and (source := place_of(p.source, p.quantity)) is not None)
    lost = len(document.solves) + len(document.pickups) - len(solves) - len(pickups)
    if lost:
        whose = "deleted surfaces" if gaps is None else "gaps and surfaces that changed"
        findings.append(note(Kind.LEFT_OUT, f"{lost} solve{'s' if lost > 1 else ''} or pickup"
                                            f"{'s' if lost > 1 else ''} of {whose} went with them"))
    positions = lens.positions
    if positions is not None:
        positions = replace(positions, gaps=tuple(index_of[gap] for gap in positions.gaps))
        if positions.stops and index_of.get(lens.stop_index) is None:
            positions = replace(positions, stops=())
    try:
        made = replace(lens, surfaces=surfaces, stop_index=stop, positions=positions)
        moves = Places(index_of, behind)
        changed = LensDocument(made, said, solves, pickups, tuple(findings),
                               moves if document.places is None else document.places.then(moves))
    except (LensError, ValueError) as error:
        raise EditError(str(error)) from None
    return settled(changed) if settle else changed


def _pivoted(lens: Lens, old: int, new: int, index_of: dict[int, int], findings: list[Finding]) -> Surface:
    """A surface at its new index, posed about the same pivot, or its own vertex where that is deleted."""
    surface = lens.surfaces[old]
    if surface.pose is None:
        return surface
    pivot = index_of.get(old - surface.pose.pivot)
    if pivot is None:
        findings.append(note(Kind.LEFT_OUT, f"surface {new} pivots about its own vertex: the surface about whose "
                                            "vertex it was tilted is deleted", new))
    return replace(surface, pose=replace(surface.pose, pivot=0 if pivot is None else new - pivot))


def check_fixed(lens: Lens, gaps: set[int], what: str) -> None:
    """EditError where one of the gaps varies with zoom or focus; what: that cannot be done, such as “deleted”."""
    moving = sorted(gaps & set(lens.positions.gaps)) if lens.positions is not None else []
    if moving:
        raise EditError(f"the gap behind surface {moving[0]} varies with zoom or focus: the surfaces next to it cannot "
                        f"be {what}")


def pose_behind(surface: Surface) -> SurfacePose | None:
    """The pose of the next surface in the body of a surface; None for a centred one."""
    return surface.pose and replace(surface.pose, pivot=surface.pose.pivot + 1)


def surface_at(document: LensDocument, surface: int) -> Surface:
    """A surface by its index; EditError for one that does not exist."""
    if not 0 <= surface < len(document.surfaces):
        raise EditError(f"there is no surface {surface}: they are numbered from 0 to {len(document.surfaces) - 1}")
    return document.surfaces[surface]


def check_range(document: LensDocument, first: int, last: int) -> None:
    """EditError for a range of surfaces that the document does not have."""
    if not 0 <= first <= last < len(document.surfaces):
        raise EditError(f"surfaces {first} to {last}: they are numbered from 0 to {len(document.surfaces) - 1}")


def inserted(document: LensDocument, index: int, surfaces: Sequence[Surface], comments: Sequence[str] = (),
             gaps: dict[int, int | None] | None = None) -> LensDocument:
    """The document with surfaces before surface `index`, or behind the last one.

    comments: of the first of them. gaps: as for `reordered`, those that the new surfaces take over. EditError for
    another index, invalid sizes or too many surfaces.
    """
    count = len(document.surfaces)
    if not 0 <= index <= count:
        raise EditError(f"surface index {index}: it must lie from 0 to {count}")
    if count + len(surfaces) > MOST_SURFACES:
        raise EditError(f"a lens has at most {MOST_SURFACES} surfaces")
    _check(surfaces)
    order: list[int | Surface] = [*range(index), *surfaces, *range(index, count)]
    return reordered(document, order, dict(zip(range(index, index + len(surfaces)), comments, strict=False)),
                     gaps=gaps)


def inserted_plane(document: LensDocument, index: int) -> LensDocument:
    """The document with a plane before surface `index`, in the medium there: it bends no ray and moves nothing."""
    count = len(document.surfaces)
    if not 0 <= index <= count:
        raise EditError(f"surface index {index}: it must lie from 0 to {count}")
    near = document.surfaces[min(index, count - 1)]
    medium = medium_before(document.lens, index)
    return inserted(document, index, [Surface(0.0, near.semi_diameter, medium, curvature=0.0)],
                    gaps={index - 1: None} if _ends_at_rim(document, index - 1) else None)


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


def moved(document: LensDocument, first: int, last: int, index: int) -> LensDocument:
    """The document with a group of surfaces, and the gaps behind them, before surface `index`. EditError: gaps vary."""
    check_range(document, first, last)
    count = len(document.surfaces)
    if not 0 <= index <= count:
        raise EditError(f"surface index {index}: it must lie from 0 to {count}")
    if first <= index <= last + 1:
        return document
    check_fixed(document.lens, set(range(count)), "moved")
    rest = [i for i in range(count) if not first <= i <= last]
    k = len([i for i in rest if i < index])
    return reordered(document, [*rest[:k], *range(first, last + 1), *rest[k:]])


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
        was, now = (solution(variant, Solve(len(variant.surfaces) - 1, "image")) for variant in (before, lens))
    except ArithmeticError:             # an afocal lens
        return document, ()
    moved = gap + now - was
    if not (isfinite(moved) and moved > 0.0 and abs(gap - was) <= IN_FOCUS * abs(was) and abs(now - was) > SAME * gap):
        return document, ()
    said = note(Kind.BACK_FOCUS, f"the last gap is {significant(moved, 6)} mm instead of {significant(gap, 6)} mm: it "
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


def with_stop(document: LensDocument, surface: int) -> LensDocument:
    """The document with another surface as the stop, whose clear aperture then limits the light."""
    surface_at(document, surface)
    if surface == document.lens.stop_index:
        return document
    lens, lost = document.lens, []
    if lens.positions is not None and lens.positions.stops:
        lens = replace(lens, positions=replace(lens.positions, stops=()))
        lost.append(note(Kind.POSITION, "the sizes of the stop at the zoom positions are left out: they belong to the "
                                        "stop before", surface))
    kept = tuple(s for s in document.solves if s.kind != "f-number")
    solves = (*kept, *(replace(s, surface=surface) for s in document.solves if s.kind == "f-number"))
    return settled(replace(document, lens=replace(lens, stop_index=surface), solves=solves,
                           findings=(*document.findings, *lost)))


def with_stop_in_gap(document: LensDocument, surface: int, distance: float) -> LensDocument:
    """The document with a plane stop in the gap behind a surface, `distance` mm from its vertex.

    The new stop passes the paraxial beam that the one before passed, so that the f-number stays. A former stop that is
    a plane and bends no ray is taken away. EditError for a distance beyond the gap, or where the beam crosses the axis.
    """
    front = surface_at(document, surface)
    if not 0.0 <= distance <= front.thickness:
        raise EditError(f"distance {significant(distance)} mm: the gap behind surface {surface} is "
                        f"{significant(front.thickness)} mm long")
    lens = document.lens
    heights, _ = ray(lens.surfaces, wavelength=lens.reference_wavelength,
                     front_index=lens.front_index)
    old = lens.stop_index
    beam = lens.stop.semi_diameter / abs(heights[old]) if heights[old] else 0.0
    share = distance / front.thickness if front.thickness else 0.0
    behind = heights[surface + 1] if surface + 1 < len(heights) else heights[surface]
    radius = beam * abs(heights[surface] + share * (behind - heights[surface]))
    if not radius > 0.0:
        raise EditError("a stop here would pass no light: the paraxial beam crosses the axis")
    made = split(document, surface, share)
    plane = replace(made.surfaces[surface + 1], semi_diameter=radius)
    made = replace(made, lens=with_surfaces(made.lens, [(surface + 1, plane)]))
    made = with_stop(made, surface + 1)
    old += old > surface
    return made if refracts(made.lens, old) or made.surfaces[old].curvature != 0.0 else deleted(made, [old])
