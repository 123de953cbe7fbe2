"""First-order optics of a lens: cardinal points, pupils and the Petzval surface, from the ABCD matrix.

Lengths in mm, z along +z from scene to film. A ray is (y, w): its height and its
reduced slope w = n dy/dz, so that every matrix has determinant 1. An r² term adds to
the curvature of its surface; conics and the other terms do not count here, and of a
cylinder or toroid it is the section y–z that does.
Source: Welford, Aberrations of Optical Systems, ch. 3.
"""

from dataclasses import dataclass
from math import inf, isfinite, isinf

from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens, LensError

FARTHEST = 20.0         # lengths of a lens: an entrance pupil beyond is no place to measure from
Matrix = tuple[float, float, float, float]
"""(A, B, C, D): y' = A y + B w, w' = C y + D w."""

_ROUNDING = 1e-13               # what is no larger than this beside the terms of its sum is zero
_ENGRAVED = 0.05                # an engraved f-number is rounded; by more than this it is taken for an error


@dataclass(frozen=True)
class Pupil:
    """An image of the stop: z in the lens frame (mm), inf where telecentric, and its radius (mm)."""

    z: float
    radius: float


@dataclass(frozen=True)
class FirstOrder:
    """First-order data of a lens, in mm, every position signed along +z.

    efl: 1 / power, positive for a converging lens (the focal length of the film's side: that of a scene in water
    is longer by its index); bfl: last vertex → rear focus; ffl: first
    vertex → front focus; front_principal: from the first vertex; rear_principal:
    from the last. The pupils' z is in the lens frame. f_number = |efl| / (2 radius
    of the entrance pupil), for an object at infinity. petzval_radius is negative
    where the field curves towards the lens, inf where it is flat. An afocal lens
    has efl, bfl, ffl, principal planes and f-number at inf.
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
    """Matrix from just before surface `start` to just before surface `end` (both at the vertex).

    end = len(lens.surfaces) leads to just after the last surface, at its vertex.
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


def first_order(lens: Lens, wavelength: float = D_LINE) -> FirstOrder:
    """First-order data of the lens at a wavelength (µm)."""
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

    # Pupils: the stop seen through what stands before it, and through what stands behind it
    stop_radius = lens.stop.semi_diameter
    a, b, _, _ = ray_matrix(lens, 0, lens.stop_index, wavelength)
    entrance_pupil = Pupil(n[0] * b / a, stop_radius / abs(a)) if abs(a) > _ROUNDING else Pupil(inf, inf)
    _, b, _, d = ray_matrix(lens, lens.stop_index, last, wavelength)    # B and D know nothing of the stop's own power
    exit_pupil = Pupil(lens.length - n_film * b / d, stop_radius / abs(d)) if abs(d) > _ROUNDING else Pupil(inf, inf)

    petzval_sum = sum(s.vertex_curvature * (n[i + 1] - n[i]) / (n[i] * n[i + 1]) for i, s in enumerate(lens.surfaces))
    return FirstOrder(
        efl=efl, bfl=bfl, ffl=ffl, f_number=_f_number(efl, entrance_pupil.radius),
        front_principal=front_principal, rear_principal=rear_principal,
        entrance_pupil=entrance_pupil, exit_pupil=exit_pupil,
        petzval_radius=-1.0 / petzval_sum if petzval_sum != 0.0 else inf, stop_radius=stop_radius,
    )


def stopped_down(lens: Lens, f_number: float) -> Lens:
    """A new lens whose stop gives this f-number: the stop's radius goes as 1 / f-number.

    The engraved number of a lens (its stated_f_number, f/2 where the prescription
    gives 2.03) means wide open. LensError where the f-number is no positive finite
    number, where the lens cannot open so far, or where it has none.
    """
    if not (isfinite(f_number) and f_number > 0.0):
        raise LensError(f"f-number {f_number:g}: it must be a positive finite number")
    widest = first_order(lens).f_number
    if isinf(widest) or widest == 0.0:
        raise LensError("this lens is afocal or telecentric towards the scene: it has no f-number to stop down to")
    engraved = lens.stated_f_number
    limit = engraved if engraved is not None and widest * (1.0 - _ENGRAVED) <= engraved <= widest else widest
    if f_number < limit * (1.0 - 1e-6):
        raise LensError(f"f/{f_number:g}: this lens opens no further than f/{widest:.4g}")
    return lens.with_stop_radius(lens.stop.semi_diameter * min(1.0, widest / f_number))


def scene_side_origin(lens: Lens, wavelength: float = D_LINE) -> float:
    """From where rays in front of a lens are best measured: its entrance pupil, or its first vertex where that lies far
    away (z in the lens frame, mm).
    """
    z = first_order(lens, wavelength).entrance_pupil.z
    return z if abs(z) < FARTHEST * lens.length else 0.0


def _f_number(efl: float, radius: float) -> float:
    return inf if isinf(efl) else abs(efl) / (2.0 * radius)


def _is_afocal(lens: Lens, wavelength: float) -> bool:
    """Whether the power is no more than the rounding of the terms that it is the sum of."""
    n = lens.indices(wavelength)
    height, slope, terms = 1.0, 0.0, 0.0                # of the ray that enters parallel to the axis; slope times index
    for i, surface in enumerate(lens.surfaces):
        bend = (n[i + 1] - n[i]) * surface.vertex_curvature * height
        slope, terms = slope - bend, terms + abs(bend)
        height += surface.thickness / n[i + 1] * slope
    return abs(slope) <= _ROUNDING * terms
