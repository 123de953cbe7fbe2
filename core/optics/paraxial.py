"""First-order optics of a lens: cardinal points, pupils and Petzval surface, from the ABCD matrix.

Lengths in mm, z along +z from scene to film. A ray is (y, w): its height and its reduced slope w = n dy/dz, so that
every matrix has determinant 1. An r² term adds to the curvature of its surface; conics and other terms have no
first-order effect. A cylinder or toroid counts with its section y–z. Source: Welford, Aberrations of Optical Systems,
ch. 3.
"""

from dataclasses import dataclass, replace
from math import inf, isfinite, isinf

from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant

FARTHEST = 20.0                 # lengths of a lens; a farther entrance pupil is no origin for rays
Matrix = tuple[float, float, float, float]
"""(A, B, C, D): y' = A y + B w, w' = C y + D w."""

_ROUNDING = 1e-13               # relative to the terms of a sum; a smaller sum is zero
_ENGRAVED = 0.05                # greatest rounding of an engraved f-number; beyond, it counts as an error


@dataclass(frozen=True)
class Pupil:
    """An image of the stop: z in the lens frame (mm), inf where telecentric, and its radius (mm)."""

    z: float
    radius: float


@dataclass(frozen=True)
class FirstOrder:
    """First-order data of a lens, in mm, every position signed along +z.

    An afocal lens has efl, bfl, ffl, principal planes and f-number at inf.

    Attributes:
        efl: 1 / power, positive for a converging lens: the focal length on the film's side. The one on the side of a
            scene in water is longer by the index of water.
        bfl: Last vertex → rear focus.
        ffl: First vertex → front focus.
        f_number: |efl| over the diameter of the entrance pupil, that of a circle of as much area for blades (ISO 517);
            for an object at infinity.
        front_principal: First vertex → front principal plane.
        rear_principal: Last vertex → rear principal plane.
        entrance_pupil, exit_pupil: z in the lens frame, and radius.
        petzval_radius: Negative if the field curves towards the lens, inf if it is flat.
        stop_radius: Radius of the aperture stop, of the rim or the circle through the blades' corners.
    """

    efl: float
    bfl: float
    ffl: float
    f_number: float
    front_principal: float
    rear_principal: float
    entrance_pupil: Pupil
    exit_pupil: Pupil
    petzval_radius: float
    stop_radius: float


def ray_matrix(lens: Lens, start: int, end: int, wavelength: float = D_LINE) -> Matrix:
    """Matrix from just before surface `start` to just before surface `end`, at the vertices; wavelength in µm.

    end = len(lens.surfaces) leads to just behind the last vertex.
    """
    n = lens.indices(wavelength)
    a, b, c, d = 1.0, 0.0, 0.0, 1.0
    for i in range(start, end):
        surface = lens.surfaces[i]
        power = (n[i + 1] - n[i]) * surface.vertex_curvature
        c, d = c - power * a, d - power * b
        if i < len(lens.surfaces) - 1:
            gap = surface.thickness / n[i + 1]
            a, b = a + gap * c, b + gap * d
    return a, b, c, d


def first_order(lens: Lens, wavelength: float | None = None) -> FirstOrder:
    """First-order data of a lens; kept after the first call (Welford, Aberrations of Optical Systems, ch. 3).

    Args:
        lens: The lens.
        wavelength: Micrometres; None: the lens's `reference_wavelength`, as in the window and `lensbench info`.
    Raises:
        GlassError: If a glass of the lens is not known at this wavelength.
    """
    if wavelength is None:
        wavelength = lens.reference_wavelength
    known = lens.known.get(("first order", wavelength))
    if known is None:
        known = lens.known["first order", wavelength] = _first_order(lens, wavelength)
    return known


def _first_order(lens: Lens, wavelength: float) -> FirstOrder:
    n = lens.indices(wavelength)
    last, n_film = len(lens.surfaces), n[-1]

    # Cardinal points
    a, _, c, d = ray_matrix(lens, 0, last, wavelength)
    if _is_afocal(lens, wavelength):
        efl = bfl = ffl = front_principal = rear_principal = inf
    else:
        efl = -1.0 / c
        bfl, ffl = -n_film * a / c, n[0] * d / c
        front_principal, rear_principal = n[0] * (d - 1.0) / c, n_film * (1.0 - a) / c

    # Pupils: images of the stop by the surfaces before it, and by those behind it
    stop_radius = lens.stop.semi_diameter
    a, b, _, _ = ray_matrix(lens, 0, lens.stop_index, wavelength)
    entrance_pupil = Pupil(n[0] * b / a, stop_radius / abs(a)) if abs(a) > _ROUNDING else Pupil(inf, inf)
    _, b, _, d = ray_matrix(lens, lens.stop_index, last, wavelength)    # B and D do not depend on the stop's own power
    exit_pupil = Pupil(lens.length - n_film * b / d, stop_radius / abs(d)) if abs(d) > _ROUNDING else Pupil(inf, inf)

    petzval_sum = sum(s.vertex_curvature * (n[i + 1] - n[i]) / (n[i] * n[i + 1]) for i, s in enumerate(lens.surfaces))
    return FirstOrder(
        efl=efl, bfl=bfl, ffl=ffl, f_number=_f_number(efl, entrance_pupil.radius * lens.iris.equivalent_radius),
        front_principal=front_principal, rear_principal=rear_principal,
        entrance_pupil=entrance_pupil, exit_pupil=exit_pupil,
        petzval_radius=-1.0 / petzval_sum if petzval_sum != 0.0 else inf, stop_radius=stop_radius,
    )


def f_number_at_infinity(lens: Lens, wavelength: float | None = None) -> float:
    """The f-number of a lens in air and focused at infinity, whatever is before it and wherever its groups are now.

    Args:
        lens: The lens at its zoom setting, with its stop as open as it is.
        wavelength: Micrometres; None: the lens's `reference_wavelength`.
    Returns:
        Focal length over the diameter of the entrance pupil; inf for an afocal lens.
    """
    return first_order((lens.at(close=0.0) if lens.has_focus_groups else lens).in_air, wavelength).f_number


def stopped_down(lens: Lens, f_number: float) -> Lens:
    """The lens with its stop closed to an f-number: the area of its opening is proportional to 1 / f-number².

    Blades leave the rim of a lens that is wide open, whose stop is round, and cut off more and more of it.

    Args:
        lens: The lens, wide open.
        f_number: f-number in air for an object at infinity. The engraved f-number (`stated_f_number`) also means wide
            open, even if it is slightly lower: f/2 for a prescription of f/2.03.
    Returns:
        A new lens; other zoom and focus positions are stopped down in proportion.
    Raises:
        LensError: If the f-number is not positive and finite, if the lens does not open that far, or if it has no
            f-number.
    """
    if not (isfinite(f_number) and f_number > 0.0):
        raise LensError(f"f-number {significant(f_number)}: it must be a positive finite number")
    widest = f_number_at_infinity(lens)
    if isinf(widest) or widest == 0.0:
        raise LensError("this lens is afocal or telecentric towards the scene: it has no f-number to stop down to")
    engraved = lens.stated_f_number
    limit = engraved if engraved is not None and widest * (1.0 - _ENGRAVED) <= engraved <= widest else widest
    if f_number < limit * (1.0 - 1e-6):
        raise LensError(f"f/{significant(f_number)}: the maximum aperture of this lens is f/{significant(widest, 4)}")
    radius, reach = lens.iris.closed(min(1.0, widest / f_number) ** 2)
    return replace(lens.with_stop_radius(lens.stop.semi_diameter * radius), blade_reach=reach)


def scene_side_origin(lens: Lens, wavelength: float = D_LINE) -> float:
    """Origin of rays before a lens, z in the lens frame (mm): the entrance pupil, or the first vertex if it is far."""
    z = first_order(lens, wavelength).entrance_pupil.z
    return z if abs(z) < FARTHEST * lens.length else 0.0


def _f_number(efl: float, radius: float) -> float:
    """|efl| / (2 radius); inf for an afocal lens."""
    return inf if isinf(efl) else abs(efl) / (2.0 * radius)


def _is_afocal(lens: Lens, wavelength: float) -> bool:
    """Whether the power is within the rounding error of its sum."""
    n = lens.indices(wavelength)
    height, slope, terms = 1.0, 0.0, 0.0                # of the ray that enters parallel to the axis; slope · index
    for i, surface in enumerate(lens.surfaces):
        bend = (n[i + 1] - n[i]) * surface.vertex_curvature * height
        slope, terms = slope - bend, terms + abs(bend)
        height += surface.thickness / n[i + 1] * slope
    return abs(slope) <= _ROUNDING * terms
