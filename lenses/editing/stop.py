"""Edits of the place of the stop. Lengths in mm; surfaces are numbered from 0."""

from dataclasses import replace

from lensbench.core.optics.finding import Kind, note
from lensbench.core.optics.prescription import refracts
from lensbench.core.optics.surface_numbers import with_surfaces
from lensbench.core.text import significant
from lensbench.lenses.editing.document import EditError, LensDocument
from lensbench.lenses.editing.order import surface_at
from lensbench.lenses.editing.solves import settled
from lensbench.lenses.editing.structure import deleted, split
from lensbench.lenses.tables.paraxial import ray


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
