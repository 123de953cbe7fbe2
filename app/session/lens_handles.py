"""The handles of the section: what a drag in the drawn lens takes hold of, and the edit that it makes.

Lengths in mm, lens frame, in the section y–z. A handle is found by a point (z, y) of the drawing; a drag is the way of
the mouse since the press. Each drag changes just its own numbers of the document. From above, the drawing is that of
the lens turned by a quarter (`top_view`), and its y the x of the document.
"""

from dataclasses import dataclass
from enum import StrEnum
from math import degrees, hypot

import numpy as np

import lensbench as lb
from lensbench.app.plots.section import elements, surface_curves
from lensbench.app.session.lens_cells import shown
from lensbench.core.optics.prescription import CURVATURE, SEMI_DIAMETER, THICKNESS
from lensbench.core.text import fixed, true_minus
from lensbench.lenses.editing.cells import with_value
from lensbench.lenses.editing.document import EditError, LensDocument, words
from lensbench.lenses.editing.elements import body_at, element_at, with_pose
from lensbench.lenses.tables.paraxial import index_of

BESIDE = 2.5                    # × the reach: from the edges of a body to its handles
APART = 1.5                     # × the reach: half the way from one of them to the other
ROOM = 0.3                      # of a gap, that a handle next to it takes at most


class HandleKind(StrEnum):
    """What a handle moves."""

    VERTEX = "vertex"           # a vertex along the axis, between its neighbours, which stay
    RIM = "rim"
    CURVE = "curvature"         # the surface, until it passes through the mouse
    GAP = "gap"                 # the gap between two elements; all behind it moves
    GROUP = "group"             # an element, a cemented group or the selected surfaces; all others stay
    BEND = "bending"            # both curvatures of an element, at constant power
    DECENTRE = "decentre"       # a surface, or several as one body, across the axis; all others stay
    TILT = "tilt"               # the same body, about the vertex of its first surface


@dataclass(frozen=True)
class Handle:
    """A place to take hold of. first, last: surfaces. z, y: where it is drawn, from above where `above` says so.

    height: of the point on a curve, or of the handle of a tilt over its pivot (mm).
    """

    kind: HandleKind
    first: int
    last: int
    z: float
    y: float
    height: float = 0.0
    above: bool = False


def handle_at(lens: lb.Lens, z: float, y: float, reach: float, selected: tuple[int, int] | None = None,
              bend: bool = False, above: bool = False) -> Handle | None:
    """The handle at a point (z, y), mm, of the lens as it is drawn; None where there is none.

    Vertices and rims come first, then surfaces, the middle of an air gap on the axis, and the glass. reach: how near
    the point must be (mm). selected: first and last of the selected surfaces; an element among them takes all of them
    along. bend: glass is bent, and not moved. above: the drawing from above, where cylinders and toroids show a
    curvature that no handle changes.
    """
    vertices = lens.vertices
    for i in range(len(lens.surfaces)):
        if hypot(z - vertices[i], y) <= _near(lens, i, reach):
            return Handle(HandleKind.VERTEX, i, i, vertices[i], 0.0)
        end = surface_curves(lens)[i][-1 if y >= 0.0 else 0]
        if hypot(z - end[0], y - end[1]) <= reach:
            return Handle(HandleKind.RIM, i, i, float(end[0]), float(end[1]))
    for i, surface in enumerate(lens.surfaces):
        if i == lens.stop_index and _is_dummy(lens, i) or abs(y) >= surface.semi_diameter:
            continue
        if above and surface.curvature_x is not None:
            continue
        surface_z = vertices[i] + float(surface.sag(0.0, y))
        if abs(z - surface_z) <= _near(lens, i, reach) and abs(y) > 0.15 * surface.semi_diameter:
            return Handle(HandleKind.CURVE, i, i, surface_z, y, abs(y))
    for i, surface in enumerate(lens.surfaces[:-1]):
        middle = vertices[i] + 0.5 * surface.thickness
        if surface.glass.n_d == 1.0 and hypot(z - middle, y) <= min(reach, ROOM * abs(surface.thickness)):
            return Handle(HandleKind.GAP, i, i, middle, 0.0)
    for element in elements(lens):
        if element.holds(z, y):
            if bend:
                return Handle(HandleKind.BEND, element.front, element.front + 1, z, y)
            first, last = element_at(lens, element.front)
            if selected is not None and selected[0] <= first and last <= selected[1]:
                first, last = selected
            return Handle(HandleKind.GROUP, first, last, z, y)
    return None


def body_of(lens: lb.Lens, handle: Handle) -> tuple[int, int]:
    """First and last surface of what a handle belongs to: its surfaces, or the tilted or decentred body around them."""
    if handle.first == handle.last and lens.surfaces[handle.first].pose is not None:
        return body_at(lens, handle.first)
    return handle.first, handle.last


def pose_handles(lens: lb.Lens, body: tuple[int, int], reach: float, highest: float,
                 above: bool) -> tuple[Handle, Handle]:
    """The handles of decentre and tilt of a body (first and last surface), next to each other above its upper edge.

    reach: how near the mouse must be to take hold of one (mm). highest: the upper end of the drawing (mm). above:
    whether the drawing is that from above.
    """
    first, last = body
    tops = np.array([curve[-1] for curve in surface_curves(lens)[first:last + 1]])
    z, y = float(tops[:, 0].mean()), min(float(tops[:, 1].max()) + BESIDE * reach, highest)
    arm = max(y - float(lens.vertex(first)[1]), reach)
    return (Handle(HandleKind.DECENTRE, first, last, z - APART * reach, y, 0.0, above),
            Handle(HandleKind.TILT, first, last, z + APART * reach, y, arm, above))


def _near(lens: lb.Lens, surface: int, reach: float) -> float:
    """The reach (mm) of a surface: it leaves room for the glass or the air between it and its neighbours."""
    gaps = [abs(lens.surfaces[i].thickness) for i in (surface - 1, surface) if 0 <= i < len(lens.surfaces) - 1]
    return min([reach, *(ROOM * gap for gap in gaps if gap)])


def dragged(document: LensDocument, handle: Handle, dz: float, dy: float) -> LensDocument:
    """The document after a drag by dz, dy (mm) from the press; EditError where the numbers follow from others."""
    surface = document.surfaces[handle.first]
    if handle.kind is HandleKind.VERTEX:
        return _shifted(document, handle.first, handle.first, dz)
    if handle.kind is HandleKind.GROUP:
        return _shifted(document, handle.first, handle.last, dz)
    if handle.kind is HandleKind.GAP:
        return with_value(document, handle.first, THICKNESS, surface.thickness + dz)
    if handle.kind is HandleKind.RIM:
        out = dy if handle.y >= 0.0 else -dy
        return with_value(document, handle.first, SEMI_DIAMETER,
                          max(surface.semi_diameter + out, 0.01 * surface.semi_diameter))
    if handle.kind is HandleKind.CURVE:
        return with_value(document, handle.first, CURVATURE, _curvature(surface, handle.height, dz))
    if handle.kind in (HandleKind.DECENTRE, HandleKind.TILT):
        pose, quantity = surface.pose or lb.SurfacePose(), _pose_quantity(handle)
        moved = getattr(pose, quantity) + (
            dy if handle.kind is HandleKind.DECENTRE else (-dz if handle.above else dz) / handle.height)
        return with_pose(document, handle.first, handle.last, quantity, moved)
    return _bent(document, handle.first, dz)


def _pose_quantity(handle: Handle) -> str:
    """The number of a pose that a handle changes: a decentre in the section, or a tilt about the axis across it."""
    if handle.kind is HandleKind.DECENTRE:
        return "decentre_x" if handle.above else "decentre_y"
    return "tilt_y" if handle.above else "tilt_x"


def label(document: LensDocument, handle: Handle) -> tuple[str, str]:
    """What a handle does, and the current values of its numbers."""
    i, j, surfaces = handle.first, handle.last, document.surfaces

    def gap(k: int) -> str:
        return f"{shown(surfaces[k], THICKNESS)} mm"

    if handle.kind is HandleKind.RIM:
        return f"Rim of surface {i}", f"semi-diameter {shown(surfaces[i], SEMI_DIAMETER)} mm"
    if handle.kind is HandleKind.CURVE:
        return f"Curvature of surface {i}", f"R {shown(surfaces[i], CURVATURE)} mm"
    if handle.kind is HandleKind.GAP:
        return f"Gap behind surface {i}", gap(i)
    if handle.kind is HandleKind.BEND:
        return (f"Bend the element at surface {i}, at constant power",
                f"R {shown(surfaces[i], CURVATURE)} and {shown(surfaces[j], CURVATURE)} mm")
    if handle.kind in (HandleKind.DECENTRE, HandleKind.TILT):
        quantity = _pose_quantity(handle)
        value = getattr(surfaces[i].pose or lb.SurfacePose(), quantity)
        body = f"surface {i}" if i == j else f"surfaces {i} to {j} as one"
        if handle.kind is HandleKind.DECENTRE:
            return f"Decentre {body}", f"{quantity[-1]} {true_minus(fixed(value, 3))} mm"
        return f"Tilt {body}", f"about {quantity[-1]} {true_minus(fixed(degrees(value), 2))}°"
    what = f"Vertex of surface {i}" if handle.kind is HandleKind.VERTEX else (
        f"Surfaces {i} to {j}: drag to move, Ctrl+drag to bend, click to tilt or decentre")
    before = f"{gap(i - 1)} before, " if i else ""
    return what, f"{before}{gap(j)} behind"


def _shifted(document: LensDocument, first: int, last: int, dz: float) -> LensDocument:
    """The surfaces from first to last moved along the axis; all others, and the film of a stored back focus, stay."""
    surfaces, changes = document.surfaces, []
    if first > 0:
        changes.append((first - 1, surfaces[first - 1].thickness + dz))
    if last + 1 < len(surfaces) or surfaces[last].thickness != 0.0:
        changes.append((last, surfaces[last].thickness - dz))
    return _together(document, [(i, THICKNESS, value) for i, value in changes])


def _together(document: LensDocument, changes: list[tuple[int, str, float]]) -> LensDocument:
    """The document with several numbers changed; none of them where one cannot be."""
    for i, quantity, _ in changes:
        rule = document.rule(i, quantity)
        if rule is not None:
            raise EditError(f"the {words(quantity)} of surface {i} follows from a rule ({rule}): remove it first")
    for i, quantity, value in changes:
        document = with_value(document, i, quantity, value)
    return document


def _curvature(surface: lb.Surface, height: float, dz: float) -> float:
    """The curvature with which a surface's point at this height (mm) lies dz further along the axis."""
    terms = float(sum(a * height**power for power, a in surface.aspheric))
    sag = float(surface.sag(0.0, height)) - terms + dz
    # c = 2 z / (h² + (1 + k) z²) holds as far as the equator of the conic
    shape = 1.0 + surface.conic
    if shape > 0.0:
        most = height / np.sqrt(shape)
        sag = float(np.clip(sag, -0.999 * most, 0.999 * most))
    return 2.0 * sag / (height * height + shape * sag * sag)


def _bent(document: LensDocument, front: int, dz: float) -> LensDocument:
    """An element with its front rim dz further along the axis, and the rear bent so that its power stays."""
    lens = document.lens
    wavelength = lens.reference_wavelength
    first, second = lens.surfaces[front], lens.surfaces[front + 1]
    before = index_of(lens.surfaces[front - 1].glass, wavelength) if front else lens.front_index
    n, after = index_of(first.glass, wavelength), index_of(second.glass, wavelength)
    one, two, reduced = n - before, after - n, first.thickness / n
    power = (one * first.curvature + two * second.curvature
             - reduced * one * two * first.curvature * second.curvature)
    bent = first.curvature + 2.0 * dz / first.semi_diameter**2
    divisor = two * (1.0 - reduced * one * bent)
    if abs(divisor) < 1e-9:
        raise EditError("the rear surface cannot keep the power of this element: its front focuses on it")
    return _together(document, [(front, CURVATURE, bent), (front + 1, CURVATURE, (power - one * bent) / divisor)])


def _is_dummy(lens: lb.Lens, i: int) -> bool:
    before = lens.surfaces[i - 1].glass.n_d if i else lens.front_index
    return lens.surfaces[i].curvature == 0.0 and before == lens.surfaces[i].glass.n_d
