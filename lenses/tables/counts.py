"""Elements, groups, aspheres and focus groups of a lens, counted as makers count them."""

from dataclasses import dataclass

from lensbench.core.optics.prescription import Lens, refracts

STILL = 1e-6        # mm: gaps that differ by less are equal
RESIN = 0.3         # mm: a cemented medium up to this thickness is a moulded layer or cement, not an element


@dataclass(frozen=True)
class Counts:
    """What a lens consists of.

    surfaces: rows of the table, the stop included. elements: pieces of glass; plane plates in air (filters, cover
    glass) and cemented layers up to 0.3 mm do not count. groups: elements that touch count as one. aspheres: surfaces
    with a conic or aspheric terms. focus_groups: groups that move on their own from infinity to the nearest distance; 0
    where the lens is focused as a whole.
    """

    surfaces: int
    elements: int
    groups: int
    aspheres: int
    focus_groups: int


def counts(lens: Lens) -> Counts:
    """What a lens consists of."""
    elements = groups = 0
    for members in _cemented(lens):
        if len(members) > 1:
            members = [i for i in members if lens.surfaces[i].thickness > RESIN] or members
        elif lens.surfaces[members[0]].vertex_curvature == lens.surfaces[members[0] + 1].vertex_curvature == 0.0 and \
                lens.surfaces[members[0]].is_spherical and lens.surfaces[members[0] + 1].is_spherical:
            continue                                                    # a plane plate
        elements += len(members)
        groups += 1
    aspheres = sum(s.is_rotationally_symmetric and not s.is_spherical for s in lens.surfaces)
    return Counts(len(lens.surfaces), elements, groups, aspheres, _focus_groups(lens))


def _cemented(lens: Lens) -> list[list[int]]:
    """The front surfaces of the media that touch, a list for each group."""
    groups: list[list[int]] = []
    in_group = False
    for i, surface in enumerate(lens.surfaces[:-1]):
        if surface.glass.n_d == 1.0:
            in_group = False
        elif not in_group:
            groups.append([i])
            in_group = True
        elif refracts(lens, i):                                         # not a stop inside an element
            groups[-1].append(i)
    return groups


def _focus_groups(lens: Lens) -> int:
    """Blocks between varying gaps that change their distance from the film between infinity and close."""
    if lens.positions is None or not lens.has_focus_groups:
        return 0
    most = 0
    for zoom in lens.positions.zoom_stations if lens.zooms else (None,):
        far, near = lens.at(zoom, 0.0).surfaces, lens.at(zoom, 1.0).surfaces
        changes = [b.thickness - a.thickness for a, b in zip(far, near, strict=True)]
        shift, blocks = 0.0, 0
        for change in reversed(changes):                                # from the film to the scene
            shift += change
            blocks += abs(change) > STILL and abs(shift) > STILL
        most = max(most, blocks)
    return most
