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
    """The document with one number of the place of the surfaces from `first` to `last` changed.

    Parameters
    ----------
    document : LensDocument
        The document before.
    first, last : int
        The body: its surfaces have one pose from now on, about the vertex of surface `first`, with the other numbers
        of that surface.
    quantity : str
        "decentre_x", "decentre_y" (mm), "tilt_x", "tilt_y" or "roll" (radians), as of `lb.SurfacePose`.
    value : float
        The new number.

    Returns
    -------
    LensDocument
        With all that follows. A pose whose numbers are all 0 is none.

    Raises
    ------
    EditError
        For another quantity or range, and a number that no pose has.
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
    """First and last surface of what moves with a surface.

    Parameters
    ----------
    lens : Lens
        The lens.
    surface : int
        Number of the surface, from 0.

    Returns
    -------
    tuple of int
        Of its body if it is out of line, else of its element; twice itself where it belongs to neither.
    """
    return body(lens, surface) or element_at(lens, surface)
