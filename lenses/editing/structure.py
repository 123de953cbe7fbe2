"""Edits of the order of surfaces: insert, delete, split, flip, move, scale, cement, separate; the place of the stop.

Lengths in mm; surfaces are numbered from 0. Comments, solves, pickups, varying gaps and the stop go with their
surfaces; what an edit has to drop or to assume is a finding of the new document.
"""

from collections.abc import Sequence
from dataclasses import replace

from lensbench.kernels.figures import significant
from lensbench.lenses.design import MOST_SURFACES
from lensbench.lenses.editing.document import EditError, LensDocument, varies
from lensbench.lenses.editing.solves import settled
from lensbench.lenses.paraxial import ray, reference_wavelength
from lensbench.lenses.rows import RowError, check_sizes
from lensbench.optics.finding import Finding, Kind, note
from lensbench.optics.glass import AIR, Glass
from lensbench.optics.lens_surface import LensError, Surface
from lensbench.optics.prescription import Lens
from lensbench.optics.surface_pose import SurfacePose

AIR_GAP = 0.1           # mm: of a cemented surface that is separated


def inserted(document: LensDocument, place: int, surfaces: Sequence[Surface],
             comments: Sequence[str] = ()) -> LensDocument:
    """The document with surfaces before surface `place`, or behind the last one."""
    count = len(document.surfaces)
    if not 0 <= place <= count:
        raise EditError(f"place {place}: it must lie from 0 to {count}")
    if count + len(surfaces) > MOST_SURFACES:
        raise EditError(f"a lens has at most {MOST_SURFACES} surfaces")
    _check(surfaces)
    order: list[int | Surface] = [*range(place), *surfaces, *range(place, count)]
    return _reordered(document, order, dict(zip(range(place, place + len(surfaces)), comments, strict=False)))


def inserted_plane(document: LensDocument, place: int) -> LensDocument:
    """The document with a plane before surface `place`, in the medium there, which bends no ray and moves nothing."""
    count = len(document.surfaces)
    if not 0 <= place <= count:
        raise EditError(f"place {place}: it must lie from 0 to {count}")
    near = document.surfaces[min(place, count - 1)]
    medium = document.surfaces[place - 1].glass if place else _front(document.lens)
    return inserted(document, place, [Surface(0.0, 0.0, near.semi_diameter, medium)])


def deleted(document: LensDocument, surfaces: Sequence[int]) -> LensDocument:
    """The document without some surfaces, and without the gap and the medium behind each.

    The gap of a plane that bends no ray is added to the one before it, so that nothing moves. If the stop is deleted,
    the surface that takes its place is the stop.
    """
    gone, count = set(surfaces), len(document.surfaces)
    if not gone <= set(range(count)):
        raise EditError(f"there is no surface {max(gone)}: they are numbered from 0 to {count - 1}")
    if len(gone) == count:
        raise EditError("a lens keeps at least one surface")
    _fixed(document.lens, gone, "deleted")
    kept = list(document.surfaces)
    for i in sorted(gone):
        before = next((j for j in range(i - 1, -1, -1) if j not in gone), None)
        if before is not None and _bends_nothing(document.lens, i):
            if varies(document.lens, before):
                raise EditError(f"the gap before surface {i} varies with zoom or focus: the surface cannot be deleted")
            kept[before] = replace(kept[before], thickness=kept[before].thickness + kept[i].thickness)
    changed = replace(document, lens=replace(document.lens, surfaces=tuple(kept)))
    return _reordered(changed, [i for i in range(count) if i not in gone])


def split(document: LensDocument, surface: int, share: float = 0.5) -> LensDocument:
    """The document with the gap behind a surface divided by a plane, at a share of its thickness from 0 to 1."""
    if not 0.0 <= share <= 1.0:
        raise EditError(f"share {significant(share)}: it must lie from 0 to 1")
    front = _get(document, surface)
    _fixed(document.lens, {surface}, "split")
    first = replace(front, thickness=front.thickness * share)
    rest = front.thickness - first.thickness
    behind = document.surfaces[min(surface + 1, len(document.surfaces) - 1)]
    plane = Surface(0.0, rest, max(front.semi_diameter, behind.semi_diameter), front.glass, pose=_behind(front))
    changed = replace(document, lens=_with(document.lens, surface, first))
    return inserted(changed, surface + 1, [plane])


def flipped(document: LensDocument, first: int, last: int) -> LensDocument:
    """The document with the surfaces from `first` to `last` turned round, in the same place along the axis."""
    _range(document, first, last)
    before = document.surfaces[first - 1].glass if first else _front(document.lens)
    after = document.surfaces[last].glass
    if before != after:
        raise EditError(f"surfaces {first} to {last} have {_named(before)} in front of them and {_named(after)} behind "
                        "them: only a group between equal media can be turned round")
    _fixed(document.lens, set(range(first, last)), "turned round")
    group = [_pivot_within(document.surfaces[i], i, first, last) for i in range(first, last + 1)]
    gaps = [(s.thickness, s.glass) for s in group[:-1]][::-1] + [(group[-1].thickness, group[-1].glass)]
    turned = [surface.reversed(*gap) for surface, gap in zip(reversed(group), gaps, strict=True)]
    surfaces = (*document.surfaces[:first], *turned, *document.surfaces[last + 1:])
    order: list[int | Surface] = [*range(first), *range(last, first - 1, -1), *range(last + 1, len(surfaces))]
    moved = _reordered(document, order, settle=False)
    positions = document.lens.positions                 # gaps stay in place: only those inside would move
    return settled(replace(moved, lens=replace(moved.lens, surfaces=surfaces, positions=positions)))


def _pivot_within(surface: Surface, i: int, first: int, last: int) -> Surface:
    """Surface i, pivoting about one of those that are turned round; EditError for a tilt about another."""
    pose = surface.pose
    if pose is None or first <= i - pose.pivot <= last:
        return surface
    if pose.tilt_x or pose.tilt_y:
        raise EditError(f"surface {i} is tilted about the vertex of surface {i - pose.pivot}: turn both round, or "
                        "neither")
    return replace(surface, pose=replace(pose, pivot=0))


def moved(document: LensDocument, first: int, last: int, place: int) -> LensDocument:
    """The document with the surfaces from `first` to `last`, with their gaps, before surface `place` of the present."""
    _range(document, first, last)
    count = len(document.surfaces)
    if not 0 <= place <= count:
        raise EditError(f"place {place}: it must lie from 0 to {count}")
    if first <= place <= last + 1:
        return document
    _fixed(document.lens, set(range(count)), "moved")
    rest = [i for i in range(count) if not first <= i <= last]
    at = len([i for i in rest if i < place])
    return _reordered(document, [*rest[:at], *range(first, last + 1), *rest[at:]])


def scaled(document: LensDocument, factor: float) -> LensDocument:
    """The document scaled as a whole, with the lengths of its solves."""
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


def cemented(document: LensDocument, surface: int) -> LensDocument:
    """The document with the air gap behind a surface closed: the next surface is taken away.

    The curvature of the cemented surface is that of the first; the second element keeps its thickness.
    """
    front = _get(document, surface)
    if surface + 1 >= len(document.surfaces) or front.glass.n_d > 1.0:
        raise EditError(f"behind surface {surface} there is no air gap between two elements")
    back = document.surfaces[surface + 1]
    if surface == 0 or document.surfaces[surface - 1].glass.n_d == 1.0 or back.glass.n_d == 1.0:
        raise EditError(f"the gap behind surface {surface} does not lie between two elements: only glass is cemented")
    _fixed(document.lens, {surface, surface + 1}, "cemented")
    joined = replace(front, thickness=back.thickness, glass=back.glass,
                     semi_diameter=max(front.semi_diameter, back.semi_diameter))
    changed = replace(document, lens=_with(document.lens, surface, joined))
    count = len(document.surfaces)
    if document.lens.stop_index == surface + 1:
        changed = with_stop(changed, surface)
    found = [] if front.curvature == back.curvature else [note(
        Kind.SHAPE, f"the curvatures of surfaces {surface} and {surface + 1} differed: the cemented surface has that "
                    f"of surface {surface}", surface)]
    made = _reordered(changed, [i for i in range(count) if i != surface + 1])
    return replace(made, findings=(*made.findings, *found))


def air_spaced(document: LensDocument, surface: int, gap: float = AIR_GAP) -> LensDocument:
    """The document with a cemented surface separated into two of its shape, `gap` mm apart."""
    front = _get(document, surface)
    if surface == 0 or document.surfaces[surface - 1].glass.n_d == 1.0 or front.glass.n_d == 1.0:
        raise EditError(f"surface {surface} is not cemented: there is no glass on both of its sides")
    _fixed(document.lens, {surface}, "separated")
    rear = replace(front, pose=_behind(front))
    changed = replace(document, lens=_with(document.lens, surface, replace(front, thickness=gap, glass=AIR)))
    return inserted(changed, surface + 1, [rear])


def _behind(surface: Surface) -> SurfacePose | None:
    """The pose of the next surface in the body that a surface belongs to."""
    return surface.pose and replace(surface.pose, pivot=surface.pose.pivot + 1)


def with_stop(document: LensDocument, surface: int) -> LensDocument:
    """The document with another surface as the stop; its rim then limits the light."""
    _get(document, surface)
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
    """The document with a plane stop in the gap behind a surface, `distance` mm behind its vertex.

    The new stop passes the paraxial beam that the one before passed, so that the f-number stays. A former stop that is
    a plane and bends no ray is taken away.
    """
    front = _get(document, surface)
    if not 0.0 <= distance <= front.thickness:
        raise EditError(f"distance {significant(distance)} mm: the gap behind surface {surface} is "
                        f"{significant(front.thickness)} mm long")
    lens = document.lens
    heights, _ = ray(lens.surfaces, wavelength=reference_wavelength(lens.surfaces, lens.system))
    old = lens.stop_index
    beam = lens.stop.semi_diameter / abs(heights[old]) if heights[old] else 0.0
    share = distance / front.thickness if front.thickness else 0.0
    behind = heights[surface + 1] if surface + 1 < len(heights) else heights[surface]
    radius = beam * abs(heights[surface] + share * (behind - heights[surface]))
    if not radius > 0.0:
        raise EditError("a stop here would pass no light: the paraxial beam crosses the axis")
    made = split(document, surface, share)
    made = replace(made, lens=_with(made.lens, surface + 1, replace(made.surfaces[surface + 1], semi_diameter=radius)))
    made = with_stop(made, surface + 1)
    old += old > surface
    return deleted(made, [old]) if _bends_nothing(made.lens, old) and made.surfaces[old].curvature == 0.0 else made


def element_at(lens: Lens, surface: int) -> tuple[int, int]:
    """First and last surface of the element, or cemented group, that a surface belongs to; itself for neither."""
    first = last = surface
    while first > 0 and lens.surfaces[first - 1].glass.n_d > 1.0:
        first -= 1
    while last + 1 < len(lens.surfaces) and lens.surfaces[last].glass.n_d > 1.0:
        last += 1
    return first, last


def _reordered(document: LensDocument, order: Sequence[int | Surface], comments: dict[int, str] | None = None,
               settle: bool = True) -> LensDocument:
    """The document with its surfaces, and all that belongs to them, in another order.

    order: a surface of the document by its number, or a new one. comments: of new surfaces, by their place.
    """
    lens, findings = document.lens, list(document.findings)
    place = {old: new for new, old in enumerate(order) if isinstance(old, int)}
    surfaces = tuple(_pivoted(lens, each, new, place, findings) if isinstance(each, int) else each
                     for new, each in enumerate(order))
    said = tuple((comments or {}).get(new, "") if not isinstance(each, int) else document.comment(each)
                 for new, each in enumerate(order))

    # The stop: itself, or the nearest surface behind it that is left, else the last
    stop = place.get(lens.stop_index)
    if stop is None:
        later = [place[old] for old in sorted(place) if old > lens.stop_index]
        stop = later[0] if later else len(surfaces) - 1
        findings.append(Finding(Kind.MOVED_STOP, stop, f"the stop was deleted: surface {stop} is the stop now"))

    solves = tuple(replace(s, surface=place[s.surface]) for s in document.solves if s.surface in place)
    solves = tuple(replace(s, surface=stop) if s.kind == "f-number" else s for s in solves
                   if not (s.kind == "edge" and s.surface == len(surfaces) - 1))
    pickups = tuple(replace(p, surface=place[p.surface], source=place[p.source]) for p in document.pickups
                    if p.surface in place and p.source in place)
    lost = len(document.solves) + len(document.pickups) - len(solves) - len(pickups)
    if lost:
        findings.append(note(Kind.LEFT_OUT, f"{lost} solve{'s' if lost > 1 else ''} or pickup"
                                            f"{'s' if lost > 1 else ''} of deleted surfaces went with them"))
    positions = lens.positions
    if positions is not None:
        positions = replace(positions, gaps=tuple(place[gap] for gap in positions.gaps))
        if positions.stops and place.get(lens.stop_index) is None:
            positions = replace(positions, stops=())
    try:
        made = replace(lens, surfaces=surfaces, stop_index=stop, positions=positions)
        changed = LensDocument(made, said, solves, pickups, tuple(findings))
    except (LensError, ValueError) as error:
        raise EditError(str(error)) from None
    return settled(changed) if settle else changed


def _pivoted(lens: Lens, old: int, new: int, place: dict[int, int], findings: list[Finding]) -> Surface:
    """A surface in its new place, out of line about the same pivot, or about its own vertex where that is deleted."""
    surface = lens.surfaces[old]
    if surface.pose is None:
        return surface
    pivot = place.get(old - surface.pose.pivot)
    if pivot is None:
        findings.append(note(Kind.LEFT_OUT, f"surface {new} pivots about its own vertex: the surface about whose "
                                            "vertex it was tilted is deleted", new))
    return replace(surface, pose=replace(surface.pose, pivot=0 if pivot is None else new - pivot))


def _fixed(lens: Lens, gaps: set[int], what: str) -> None:
    """EditError where one of these gaps varies."""
    moving = sorted(gaps & set(lens.positions.gaps)) if lens.positions is not None else []
    if moving:
        raise EditError(f"the gap behind surface {moving[0]} varies with zoom or focus: the surfaces beside it cannot "
                        f"be {what}")


def _bends_nothing(lens: Lens, surface: int) -> bool:
    """Whether a surface has the same medium on both sides."""
    before = lens.surfaces[surface - 1].glass if surface else _front(lens)
    return before == lens.surfaces[surface].glass


def _front(lens: Lens) -> Glass:
    return AIR if lens.front_index == 1.0 else Glass(lens.front_index)


def _named(glass: Glass) -> str:
    return "air" if glass.n_d == 1.0 else glass.name or f"glass of index {significant(glass.n_d)}"


def _with(lens: Lens, surface: int, made: Surface) -> Lens:
    surfaces = list(lens.surfaces)
    surfaces[surface] = made
    return replace(lens, surfaces=tuple(surfaces))


def _get(document: LensDocument, surface: int) -> Surface:
    _range(document, surface, surface)
    return document.surfaces[surface]


def _range(document: LensDocument, first: int, last: int) -> None:
    if not 0 <= first <= last < len(document.surfaces):
        raise EditError(f"surfaces {first} to {last}: they are numbered from 0 to {len(document.surfaces) - 1}")


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

