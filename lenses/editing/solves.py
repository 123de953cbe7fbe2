"""Solves and pickups: the numbers of a document that follow from others.

Paraxial rays are those of the reference wavelength of the design, mm. A power, and with it the focal length and the
slope of a ray, is a linear function of one curvature; the root is found by secants, which end in one step where the
function is linear, and go on to the last bit where the entrance pupil moves too.
"""

from collections.abc import Callable
from dataclasses import replace
from math import inf, isfinite

from lensbench.core.optics.finding import Finding, Kind
from lensbench.core.optics.lens_surface import LensError, Surface
from lensbench.core.optics.prescription import Lens, value_of, with_surfaces, with_value_of
from lensbench.lenses.editing.document import LensDocument, Pickup, Solve, words
from lensbench.lenses.file_error import RowError
from lensbench.lenses.tables.paraxial import FAR, image_distance, ray
from lensbench.lenses.tables.rows import check_sizes

PASSES = 40             # of all rules, while one changes what another follows from
STEPS = 60              # of a secant
EXACT = 1e-13           # relative residual at which a solve is met; rounding of the sums is larger than this


def settled(document: LensDocument) -> LensDocument:
    """The document with the values of all its solves and pickups.

    Pickups come first, then solves from the scene to the film; they are repeated until nothing changes. A solve without
    a solution leaves its number, and becomes a finding; so do rules that contradict each other. The rules of a lens
    whose gaps vary hold at its wide end, focused at infinity, wherever it is set.
    """
    if not document.rules:
        return document
    positions = document.lens.positions
    if positions is not None and (positions.zoom or positions.close):
        wide = settled(replace(document, lens=document.lens.at(zoom=0.0, close=0.0)))
        return replace(wide, lens=wide.lens.at(zoom=positions.zoom, close=positions.close))
    lens, unsolved = document.lens, dict[tuple[int, str], Finding]()
    for _ in range(PASSES):
        before = lens
        for pickup in _in_order(document.pickups):
            lens = _applied(lens, pickup, pickup.factor * value_of(lens.surfaces[pickup.source], pickup.quantity)
                            + pickup.offset, unsolved)
        for solve in document.solves:
            lens = _applied(lens, solve, solution(lens, solve), unsolved)
        if lens == before or _close(lens, before):
            break
    else:
        surface = min(rule.surface for rule in document.rules)
        unsolved[surface, ""] = Finding(Kind.UNSOLVED, surface, "the solves and pickups contradict each other: they "
                                                                "find no common solution")
    return replace(document, lens=lens, findings=(
        *(f for f in document.findings if f.kind is not Kind.UNSOLVED), *unsolved.values()))


def _in_order(pickups: tuple[Pickup, ...]) -> list[Pickup]:
    """Sources before those that follow them."""
    waiting, ordered = list(pickups), list[Pickup]()
    while waiting:
        open_cells = {(p.surface, p.quantity) for p in waiting}
        ready = [p for p in waiting if (p.source, p.quantity) not in open_cells]
        ordered += ready
        waiting = [p for p in waiting if p not in ready]
    return ordered


def _close(lens: Lens, before: Lens) -> bool:
    """Whether two lenses differ by rounding alone."""
    return all(abs(value_of(a, q) - value_of(b, q)) <= 4e-16 * abs(value_of(a, q))
               for a, b in zip(lens.surfaces, before.surfaces, strict=True)
               for q in ("curvature", "thickness", "semi_diameter"))


def _applied(lens: Lens, rule: Solve | Pickup, value: float, unsolved: dict[tuple[int, str], Finding]) -> Lens:
    """The lens with one number that follows; a finding where a surface cannot have it."""
    cell = rule.surface, rule.quantity
    unsolved.pop(cell, None)
    try:
        if not isfinite(value):
            raise LensError("it has no solution")
        made = with_value_of(lens.surfaces[rule.surface], rule.quantity, value)
        check_sizes(made)
    except (LensError, RowError) as error:
        unsolved[cell] = Finding(Kind.UNSOLVED, rule.surface, f"the {words(rule.quantity)} of surface {rule.surface} "
                                                              f"({rule}) cannot follow: {error}")
        return lens
    return with_surfaces(lens, [(rule.surface, made)])


def solution(lens: Lens, solve: Solve) -> float:
    """The number that meets a solve, all others as they are, in the unit of its quantity; inf where there is none."""
    wavelength, i = lens.reference_wavelength, solve.surface
    surface = lens.surfaces[i]
    distance = lens.system.object_distances[0]
    if solve.kind == "image":
        before = lens.surfaces[:i + 1]
        return image_distance(before, inf if abs(distance) >= FAR else distance, wavelength,
                              lens.front_index) - solve.target
    if solve.kind == "edge":
        ahead, behind = _rim_sag(surface), _rim_sag(lens.surfaces[i + 1])
        return solve.target + ahead - behind
    if solve.kind == "efl":
        return _root(lambda c: -ray(with_surfaces(lens, [(i, replace(surface, curvature=c))]).surfaces,
                                    wavelength=wavelength, front_index=lens.front_index)[1] * solve.target - 1.0,
                     surface.curvature)
    if solve.kind == "f-number":
        heights, slope = ray(lens.surfaces, wavelength=wavelength, front_index=lens.front_index)
        return abs(heights[i] / (2.0 * solve.target * slope)) if slope else inf
    return _root(lambda c: _marginal_slope(with_surfaces(lens, [(i, replace(surface, curvature=c))]), i, wavelength)
                 - solve.target, surface.curvature)


def _rim_sag(surface: Surface) -> float:
    """Sag (mm) at the rim; inf where the surface ends before it."""
    depth = float(surface.sag(0.0, surface.semi_diameter))
    return depth if isfinite(depth) else inf


def _marginal_slope(lens: Lens, surface: int, wavelength: float) -> float:
    """Slope behind a surface of the paraxial ray that touches the rim of the stop, from the object of the design."""
    distance = lens.system.object_distances[0]
    start = (1.0, 0.0) if abs(distance) >= FAR else (distance, 1.0) if abs(distance) < 1.0 else (1.0, 1.0 / distance)
    heights, _ = ray(lens.surfaces, *start, wavelength, lens.front_index)
    at_stop = heights[lens.stop_index]
    _, slope = ray(lens.surfaces[:surface + 1], *start, wavelength, lens.front_index)
    return slope * lens.surfaces[lens.stop_index].semi_diameter / at_stop if at_stop else inf


def _root(residual: Callable[[float], float], start: float) -> float:
    """The curvature with a residual of 0, near `start`; inf where the secants find none."""
    a, at_a = start, residual(start)
    b = start + (1e-3 * abs(start) or 1e-4)
    at_b = residual(b)
    best = (abs(at_a), a) if isfinite(at_a) else (inf, a)
    scale = max(abs(at_a), abs(at_b), 1.0)
    for _ in range(STEPS):
        if abs(at_b) < best[0]:
            best = abs(at_b), b
        if at_b == at_a or not (isfinite(at_a) and isfinite(at_b)) or best[0] == 0.0:
            break
        a, at_a, b = b, at_b, b - at_b * (b - a) / (at_b - at_a)
        at_b = residual(b)
        if b == a:
            break
    return best[1] if best[0] <= EXACT * scale else inf
