"""What is screwed onto a lens: a filter, a close-up lens, a cover plate, a converter or another lens.

Lengths in mm. What is attached consists of surfaces like any others, which can be edited; the first has its name as a
comment.
"""

from collections.abc import Sequence
from dataclasses import replace

from lensbench.core.optics.glass import AIR, Glass
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.optics.prescription import THICKNESS, Lens, with_surfaces
from lensbench.core.text import significant
from lensbench.lenses.editing.cells import with_value
from lensbench.lenses.editing.document import EditError, LensDocument, varies
from lensbench.lenses.editing.elements import reversed_surfaces
from lensbench.lenses.editing.solves import settled
from lensbench.lenses.editing.structure import inserted

CROWN = Glass(1.5168, 64.17, "N-BK7")
FILTER = 2.0                    # mm: thickness of a filter
EDGE = 1.0                      # mm: of a close-up lens at its rim
GAP = 2.0                       # mm of air at the nearest places of the rims


def plate(thickness: float, semi_diameter: float, glass: Glass = CROWN) -> tuple[Surface, ...]:
    """Both faces of a plane-parallel plate, a filter or a cover glass. EditError: a size that is not positive."""
    _positive(thickness=thickness, semi_diameter=semi_diameter)
    return Surface(thickness, semi_diameter, glass, curvature=0.0), Surface(0.0, semi_diameter, curvature=0.0)


def close_up_lens(dioptres: float, semi_diameter: float, glass: Glass = CROWN) -> tuple[Surface, ...]:
    """A plano-convex lens, its convex side towards the scene; of negative power, plano-concave.

    dioptres: from −20 to 20 (1/m), not 0. EditError for another power, or a clear aperture beyond the sphere.
    """
    _positive(semi_diameter=semi_diameter)
    if not 0.0 < abs(dioptres) <= 20.0:
        raise EditError(f"close-up lens of {significant(dioptres)} dioptres: choose −20 to 20, and not 0")
    curvature = 1e-3 * dioptres / (glass.n_d - 1.0)
    if abs(curvature) * semi_diameter >= 0.95:
        raise EditError(f"a lens of {significant(dioptres)} dioptres is no wider than "
                        f"{significant(0.95 / abs(curvature), 3)} mm: make it narrower")
    front = Surface(1.0, semi_diameter, glass, curvature=curvature)
    sag = float(front.sag(0.0, semi_diameter))
    return replace(front, thickness=EDGE + max(sag, 0.0)), Surface(0.0, semi_diameter, curvature=0.0)


def front_width(document: LensDocument, thickness: float = FILTER) -> float:
    """Semi-diameter (mm) of an attachment of this thickness that clears the light of the first surface up to 45°."""
    first = document.surfaces[0]
    return first.semi_diameter + _clearance(first, -1.0) + thickness


def attached_in_front(document: LensDocument, surfaces: Sequence[Surface], name: str,
                      gap: float | None = None) -> LensDocument:
    """The document with surfaces before its first one; the stop stays the surface that it was.

    gap: last vertex of the attachment → first vertex of the lens; None: GAP at the nearest points. name: comment of the
    first of the surfaces, whose last thickness is replaced. EditError for a lens that is not in air, or a gap below 0.
    """
    if document.lens.front_index != 1.0:
        raise EditError("only in front of a lens in air something can be attached")
    made = _ended(surfaces, _clearance(document.surfaces[0], -1.0) if gap is None else gap)
    return inserted(document, 0, made, (name,))


def attached_behind(document: LensDocument, surfaces: Sequence[Surface], name: str,
                    gap: float | None = None) -> LensDocument:
    """The document with surfaces behind its last one; the last gap of the lens becomes that to the attachment.

    A last gap that varies with zoom or focus does so behind the attachment, shorter by its length: the film stays.
    EditError for a lens that does not end in air, a gap below 0, or one that follows from a rule.
    """
    count, last = len(document.surfaces), document.surfaces[-1]
    if last.glass != AIR:
        raise EditError("only behind a lens that ends in air something can be attached")
    apart = _clearance(last, 1.0) if gap is None else gap
    made = _ended(surfaces, 0.0)
    if not apart >= 0.0:
        raise EditError(f"gap {significant(apart)} mm: it must not be negative")
    if not varies(document.lens, count - 1):
        return inserted(with_value(document, count - 1, THICKNESS, apart), count, made, (name,))
    # The film stays where it is at each station: behind the attachment its distance varies
    span = apart + sum(surface.thickness for surface in made)
    attached = inserted(document, count, made, (name,))
    positions = attached.lens.positions
    assert positions is not None
    table = tuple(tuple((*gaps[:-1], gaps[-1] - span) for gaps in row) for row in positions.thicknesses)
    positions = replace(positions, gaps=(*positions.gaps[:-1], count - 1 + len(made)), thicknesses=table)
    rear = replace(attached.surfaces[-1], thickness=positions.thickness_now[-1])
    behind = [(count - 1, replace(last, thickness=apart)), (count - 1 + len(made), rear)]
    return settled(replace(attached, lens=replace(with_surfaces(attached.lens, behind), positions=positions)))


def surfaces_of(lens: Lens, reverse: bool = False) -> tuple[Surface, ...]:
    """The surfaces of another lens to attach, reversed as by a reversing ring. EditError: it is not in air."""
    if lens.front_index != 1.0 or lens.surfaces[-1].glass != AIR:
        raise EditError(f"{lens.name or 'the lens'} is not in air: it cannot be attached")
    return reversed_surfaces(lens.surfaces) if reverse else lens.surfaces


def _ended(surfaces: Sequence[Surface], gap: float) -> list[Surface]:
    """The surfaces with another last gap, in air."""
    if not surfaces or surfaces[-1].glass != AIR:
        raise EditError("what is attached must end in air")
    if not gap >= 0.0:
        raise EditError(f"gap {significant(gap)} mm: it must not be negative")
    return [*surfaces[:-1], replace(surfaces[-1], thickness=gap)]


def _clearance(surface: Surface, side: float) -> float:
    """Gap (mm) at the vertex that leaves GAP at the rim too; side: −1 before the surface, 1 behind it."""
    sag = float(surface.sag(0.0, surface.semi_diameter))
    return GAP + max(side * sag, 0.0) if sag == sag else GAP + surface.semi_diameter


def _positive(**sizes: float) -> None:
    for name, size in sizes.items():
        if not 0.0 < size < 1e6:
            raise EditError(f"{name.replace('_', ' ')} {significant(size)} mm: it must be positive")
