"""Edits of the place of surfaces out of line: of one surface, of an element or of a group as one body.

Lengths in mm, angles in radians; surfaces are numbered from 0.
"""

from dataclasses import replace

from lensbench.core.optics.lens_surface import LensError, PoseError, SurfacePose
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.surface_numbers import POSE, with_surfaces
from lensbench.lenses.editing.document import EditError, LensDocument, words
from lensbench.lenses.editing.elements import element_at
from lensbench.lenses.editing.solves import settled
from lensbench.lenses.tables.axes import body


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
