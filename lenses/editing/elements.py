"""Edits of elements and groups, and of the lens as a whole: reverse, cement, separate, decentre and tilt.

Lengths in mm, angles in radians; surfaces are numbered from 0.
"""

from collections.abc import Sequence
from dataclasses import replace

from lensbench.core.optics.finding import Kind, note
from lensbench.core.optics.glass import AIR, Glass
from lensbench.core.optics.lens_surface import LensError, PoseError, Surface, SurfacePose
from lensbench.core.optics.prescription import CONIC, POSE, SEMI_DIAMETER, THICKNESS, Lens, medium_before, with_surfaces
from lensbench.core.optics.system import SystemData
from lensbench.core.text import significant
from lensbench.lenses.editing.document import EditError, LensDocument, Pickup, words
from lensbench.lenses.editing.solves import settled
from lensbench.lenses.editing.structure import (
    check_fixed, check_range, inserted, pose_behind, reordered, surface_at, with_stop
)
from lensbench.lenses.tables.axes import body

AIR_GAP = 0.1           # mm: of a cemented surface that is separated


def element_at(lens: Lens, surface: int) -> tuple[int, int]:
    """First and last surface of the element or cemented group of a surface; twice itself where there is none."""
    first = last = surface
    while first > 0 and lens.surfaces[first - 1].glass.n_d > 1.0:
        first -= 1
    while last + 1 < len(lens.surfaces) and lens.surfaces[last].glass.n_d > 1.0:
        last += 1
    return first, last


def flipped(document: LensDocument, first: int, last: int) -> LensDocument:
    """The document with a group of surfaces reversed, between the same two vertices.

    EditError for a group between two different media, with gaps that vary, or with a tilt about a surface outside.
    """
    check_range(document, first, last)
    before = medium_before(document.lens, first)
    after = document.surfaces[last].glass
    if before != after:
        raise EditError(f"surfaces {first} to {last} have {_named(before)} in front of them and {_named(after)} behind "
                        "them: only a group between equal media can be reversed")
    check_fixed(document.lens, set(range(first, last)), "reversed")
    group = [_pivot_within(document.surfaces[i], i, first, last) for i in range(first, last + 1)]
    turned = reversed_surfaces(group, group[-1].thickness, group[-1].glass)
    surfaces = (*document.surfaces[:first], *turned, *document.surfaces[last + 1:])
    order: list[int | Surface] = [*range(first), *range(last, first - 1, -1), *range(last + 1, len(surfaces))]
    behind: dict[int, int | None] = {last: last, **{i: first + last - 1 - i for i in range(first, last)}}
    moved = reordered(document, order, settle=False, gaps=behind)
    positions = document.lens.positions                 # gaps stay in place: only those inside would move
    lens = moved.lens.iris_turned if first <= document.lens.stop_index <= last else moved.lens
    return settled(replace(moved, lens=replace(lens, surfaces=surfaces, positions=positions),
                           pickups=tuple(_turned(pickup, first, last) for pickup in moved.pickups)))


def _turned(pickup: Pickup, first: int, last: int) -> Pickup:
    """A pickup that gives the same shapes as before surfaces `first` to `last` were reversed."""
    if pickup.quantity in (THICKNESS, SEMI_DIAMETER, CONIC):
        return pickup
    sign = -1.0 if first <= pickup.surface <= last else 1.0
    source_sign = -1.0 if first <= pickup.source <= last else 1.0
    return replace(pickup, factor=sign * source_sign * pickup.factor, offset=sign * pickup.offset or 0.0)


def _pivot_within(surface: Surface, i: int, first: int, last: int) -> Surface:
    """Surface i, pivoting about one of those that are reversed; EditError for a tilt about another."""
    pose = surface.pose
    if pose is None or first <= i - pose.pivot <= last:
        return surface
    if pose.tilt_x or pose.tilt_y:
        raise EditError(f"surface {i} is tilted about the vertex of surface {i - pose.pivot}: turn both round, or "
                        "neither")
    return replace(surface, pose=replace(pose, pivot=0))


def cemented(document: LensDocument, surface: int) -> LensDocument:
    """The document with the air gap behind a surface closed: the next surface is taken away.

    The shape of the cemented surface is that of the first; the second element keeps its thickness. EditError for a gap
    that does not lie between two elements, or that varies with zoom or focus.
    """
    front = surface_at(document, surface)
    if surface + 1 >= len(document.surfaces) or front.glass.n_d > 1.0:
        raise EditError(f"behind surface {surface} there is no air gap between two elements")
    back = document.surfaces[surface + 1]
    if surface == 0 or document.surfaces[surface - 1].glass.n_d == 1.0 or back.glass.n_d == 1.0:
        raise EditError(f"the gap behind surface {surface} does not lie between two elements: only glass is cemented")
    check_fixed(document.lens, {surface, surface + 1}, "cemented")
    joined = replace(front, thickness=back.thickness, glass=back.glass,
                     semi_diameter=max(front.semi_diameter, back.semi_diameter))
    changed = replace(document, lens=with_surfaces(document.lens, [(surface, joined)]))
    count = len(document.surfaces)
    if document.lens.stop_index == surface + 1:
        changed = with_stop(changed, surface)
    same = replace(back, thickness=front.thickness, glass=front.glass, semi_diameter=front.semi_diameter,
                   coating=front.coating, pose=front.pose) == front
    what = "curvatures" if front.curvature != back.curvature else "aspheric terms, conics or sections x–z"
    remarks = [] if same else [note(
        Kind.SHAPE, f"the {what} of surfaces {surface} and {surface + 1} differed: the cemented surface has "
                    f"{'that' if what == 'curvatures' else 'those'} of surface {surface}", surface)]
    made = reordered(changed, [i for i in range(count) if i != surface + 1],
                     gaps={surface: None, surface + 1: surface})
    return replace(made, findings=(*made.findings, *remarks))


def air_spaced(document: LensDocument, surface: int, gap: float = AIR_GAP) -> LensDocument:
    """The document with a cemented surface separated into two of its shape, with a gap (mm) of air between them.

    EditError for a surface without glass on both sides, or a gap that varies with zoom or focus.
    """
    front = surface_at(document, surface)
    if surface == 0 or document.surfaces[surface - 1].glass.n_d == 1.0 or front.glass.n_d == 1.0:
        raise EditError(f"surface {surface} is not cemented: there is no glass on both of its sides")
    check_fixed(document.lens, {surface}, "separated")
    rear = replace(front, pose=pose_behind(front))
    front = replace(front, thickness=gap, glass=AIR)
    changed = replace(document, lens=with_surfaces(document.lens, [(surface, front)]))
    return inserted(changed, surface + 1, [rear], gaps={surface: surface + 1})


def _named(glass: Glass) -> str:
    return "air" if glass.n_d == 1.0 else glass.name or f"glass of index {significant(glass.n_d)}"


def with_pose(document: LensDocument, first: int, last: int, quantity: str, value: float) -> LensDocument:
    """The document with one number of the pose of the surfaces from `first` to `last` changed.

    They are one body from now on, which pivots about the vertex of surface `first` and has the other numbers of that
    surface. quantity: one of POSE (mm, radians), as of `lb.SurfacePose`; a pose whose numbers are all 0 is none.
    EditError for another quantity or range, and a number that no pose has.
    """
    if quantity not in POSE:
        raise EditError(f"quantity {quantity!r}: choose one of {', '.join(POSE)}")
    if not 0 <= first <= last < len(document.surfaces):
        raise EditError(f"surfaces {first} to {last}: they are numbered from 0 to {len(document.surfaces) - 1}")
    try:
        before = document.surfaces[first].pose or SurfacePose()
        numbers = {name: getattr(before, name) for name in POSE} | {quantity: value}
        made = [(i, replace(document.surfaces[i], pose=SurfacePose(**numbers, pivot=i - first)))
                for i in range(first, last + 1)]
        changed = replace(document, lens=with_surfaces(document.lens, made))
    except (PoseError, LensError) as error:
        raise EditError(f"surface {first}: {words(quantity)}: {error}") from None
    return document if changed.lens == document.lens else settled(changed)


def body_at(lens: Lens, surface: int) -> tuple[int, int]:
    """First and last surface of the body of a decentred or tilted surface, else of its element."""
    return body(lens, surface) or element_at(lens, surface)


def reversed_surfaces(surfaces: Sequence[Surface], thickness: float = 0.0, glass: Glass = AIR) -> tuple[Surface, ...]:
    """Surfaces reversed as one body, in reverse order; thickness and glass: of the gap behind the last of them."""
    gaps = [(s.thickness, s.glass) for s in surfaces[:-1]][::-1] + [(thickness, glass)]
    return tuple(surface.reversed(*gap) for surface, gap in zip(reversed(surfaces), gaps, strict=True))


def reversed_lens(lens: Lens) -> Lens:
    """The lens turned by half a turn about y: surfaces in reverse order, curvatures and aspheric terms negated.

    Its back focus is unknown (0). Only the present zoom and focus position is kept, of the system data only the
    wavelengths, and of the stated figures only the focal length; findings report this.
    LensError if the medium behind the lens is not air.
    """
    if lens.surfaces[-1].glass.n_d != 1.0:
        raise LensError("a lens with another medium than air behind it cannot be reversed: the medium in front of "
                        "a lens is air")
    surfaces = reversed_surfaces(lens.surfaces)
    lost = [] if lens.positions is None else [
        note(Kind.POSITION, "its zoom and focus positions are left out: it is reversed in the current one")]
    system = SystemData(wavelengths=lens.system.wavelengths, primary=lens.system.primary)
    if system != lens.system:
        lost.append(note(Kind.LEFT_OUT, "the aperture, the fields and the object distance that it was designed for are "
                                        "left out: they belong to its other end"))
    if lens.stated_f_number is not None:
        lost.append(note(Kind.LEFT_OUT, "the stated f-number is left out: it belongs to its other end"))
    return replace(lens.iris_turned, surfaces=surfaces, stop_index=len(surfaces) - 1 - lens.stop_index, positions=None,
                   stated_f_number=None, system=system, findings=(*lens.findings, *lost))
