"""Surfaces in another order, with all that belongs to them: what the edits of `structure`, `stop` and `elements` share.

Lengths in mm; surfaces are numbered from 0.
"""

from collections.abc import Sequence
from dataclasses import replace

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.lens_surface import LensError, Surface, SurfacePose
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.surface_numbers import THICKNESS
from lensbench.lenses.editing.document import EditError, LensDocument, Places
from lensbench.lenses.editing.solves import settled


def reordered(document: LensDocument, order: Sequence[int | Surface], comments: dict[int, str] | None = None,
              settle: bool = True, gaps: dict[int, int | None] | None = None) -> LensDocument:
    """The document with its surfaces, and all that belongs to them, in another order; EditError: no lens can have it.

    order: indices of surfaces, and new ones. comments: of new surfaces, by index. settle: whether solves and pickups
    are settled. gaps: those that do not stay behind their surface, by its index before, with that of the surface which
    then has the gap; None where the gap is gone, so that its rules go too. Rules of thicknesses follow their gaps.
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

    # Rules go with their surfaces, those of thicknesses with their gaps
    behind = {old: new for old, new in {**place, **(gaps or {})}.items() if new is not None}

    def place_of(surface: int, quantity: str) -> int | None:
        return (behind if quantity == THICKNESS else place).get(surface)

    kept = [replace(s, surface=at) for s in document.solves if (at := place_of(s.surface, s.quantity)) is not None]
    solves = tuple(replace(s, surface=stop) if s.kind == "f-number" else s for s in kept
                   if not (s.kind == "edge" and s.surface == len(surfaces) - 1))
    pickups = tuple(replace(p, surface=at, source=source) for p in document.pickups
                    if (at := place_of(p.surface, p.quantity)) is not None
                    and (source := place_of(p.source, p.quantity)) is not None)
    lost = len(document.solves) + len(document.pickups) - len(solves) - len(pickups)
    if lost:
        whose = "deleted surfaces" if gaps is None else "gaps and surfaces that changed"
        findings.append(note(Kind.LEFT_OUT, f"{lost} solve{'s' if lost > 1 else ''} or pickup"
                                            f"{'s' if lost > 1 else ''} of {whose} went with them"))
    positions = lens.positions
    if positions is not None:
        positions = replace(positions, gaps=tuple(place[gap] for gap in positions.gaps))
        if positions.stops and place.get(lens.stop_index) is None:
            positions = replace(positions, stops=())
    try:
        made = replace(lens, surfaces=surfaces, stop_index=stop, positions=positions)
        places = Places(place, behind)
        changed = LensDocument(made, said, solves, pickups, tuple(findings),
                               places if document.places is None else document.places.then(places))
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


def check_fixed(lens: Lens, gaps: set[int], what: str) -> None:
    """EditError where one of the gaps varies with zoom or focus; what: that cannot be done, such as “deleted”."""
    moving = sorted(gaps & set(lens.positions.gaps)) if lens.positions is not None else []
    if moving:
        raise EditError(f"the gap behind surface {moving[0]} varies with zoom or focus: the surfaces beside it cannot "
                        f"be {what}")


def pose_behind(surface: Surface) -> SurfacePose | None:
    """The pose of the next surface in the body of a surface; None for a centred one."""
    return surface.pose and replace(surface.pose, pivot=surface.pose.pivot + 1)


def surface_at(document: LensDocument, surface: int) -> Surface:
    """A surface by its index; EditError for one that does not exist."""
    check_range(document, surface, surface)
    return document.surfaces[surface]


def check_range(document: LensDocument, first: int, last: int) -> None:
    """EditError for a range of surfaces that the document does not have."""
    if not 0 <= first <= last < len(document.surfaces):
        raise EditError(f"surfaces {first} to {last}: they are numbered from 0 to {len(document.surfaces) - 1}")
