"""Aberrations of a lens for an object at infinity: Seidel sums, first-order colour, and the foci along the chief ray.

Lengths in mm, angles in radians, lens frame. Seidel sums are Welford's S_I to S_V (of the wavefront, in mm), colour
his C_L and C_T. Of an aspheric surface the conic, the r² term (curvature) and the r⁴ term contribute; higher terms do
not. An r³ term is refused: its aberration is of the second order, for which there is no sum.

References:
    Welford, "Aberrations of Optical Systems": ch. 8 and 10 (sums), ch. 9 (Coddington's equations).
"""

from dataclasses import dataclass
from math import atan2, copysign, cos, inf, isinf, isnan, nan, pi, sin, tan

import numpy as np

from lensbench.core.kernels.numeric import find_minimum, find_root
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LensError, Surface
from lensbench.core.optics.paraxial import first_order, ray_matrix
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import PASSED, Fate, surface_table, trace_ray, trace_rays
from lensbench.core.text import significant

_FIELD_STEP = 0.02              # rad in the scene, between the rays from the stop that bracket a field angle
_LEAST_STEP = 1e-3              # rad at the stop, at the least
_HALVINGS = 50
_ENDS = {Fate.MISSED: "miss", Fate.CLIPPED: "meet the rim of", Fate.TOTAL_REFLECTION: "be totally reflected at",
         Fate.BACKWARD: "be turned back at"}


@dataclass(frozen=True, eq=False)
class Seidel:
    """Third-order aberrations of a lens, from `seidel`.

    Args:
        surfaces: (n, 5) S_I … S_V of each surface, mm.
        axial_colour, lateral_colour: (n,) C_L and C_T of each surface, mm, the shorter wavelength less the longer; None
            without two wavelengths.
        invariant: Lagrange's invariant n (ū y − u ȳ), mm.
    """

    surfaces: np.ndarray
    axial_colour: np.ndarray | None
    lateral_colour: np.ndarray | None
    invariant: float

    @property
    def total(self) -> np.ndarray:
        """(5,) sums over all surfaces, mm: spherical aberration, coma, astigmatism, Petzval curvature, distortion."""
        return self.surfaces.sum(axis=0)


@dataclass(frozen=True, eq=False)
class ChiefRay:
    """A real ray through the middle of the stop, from `chief_ray`.

    Args:
        field_angle: Angle from the axis in the scene, radians.
        pupil_z: z at which the ray crosses the axis in the scene, the real entrance pupil; mm, lens frame.
        points: (n, 3) points on the surfaces, mm, lens frame.
        direction: (3,) unit direction after the lens, lens frame.
    """

    field_angle: float
    pupil_z: float
    points: np.ndarray
    direction: np.ndarray


def seidel(lens: Lens, field_angle: float, pupil_radius: float | None = None, wavelength: float = D_LINE,
           colour: tuple[float, float] | None = None) -> Seidel:
    """Seidel sums for an object at infinity (Welford, ch. 8 and 10).

    Args:
        lens: Rotationally symmetric lens.
        field_angle: Angle of the object from the axis, radians, below π/2.
        pupil_radius: Radius of the entrance pupil, mm; None: the paraxial image of the stop.
        wavelength: µm.
        colour: Two wavelengths, µm, the shorter first, such as (lb.F_LINE, lb.C_LINE), for C_L and C_T; None: without
            colour.
    Raises:
        LensError: For a lens with a cylinder, a toroid or an r³ term, an entrance pupil at infinity, angles from 90°
            on, and a pupil radius that is not positive.
    """
    check_symmetry(lens)
    if not abs(field_angle) < 0.5 * pi:
        raise LensError(f"field angle {significant(np.degrees(field_angle), 4)}°: it must lie below 90°")
    if pupil_radius is not None and not 0.0 < pupil_radius < inf:
        raise LensError(f"pupil radius {significant(pupil_radius)} mm: it must be a positive length")
    for i, surface in enumerate(lens.surfaces):
        if dict(surface.aspheric).get(3):
            raise LensError(f"surface {i} has an r³ term: its aberration is of the second order, which Seidel sums "
                            "have no place for; trace real rays instead")
    pupil = first_order(lens, wavelength).entrance_pupil
    if isinf(pupil.z):
        raise LensError("the entrance pupil of this lens lies at infinity: it has no chief ray from a far object")
    n = lens.indices(wavelength)
    spread = np.subtract(lens.indices(colour[0]), lens.indices(colour[1])) if colour else None

    # Start a marginal ray (y, w = n u) and a chief ray (ȳ, w̄)
    y, w = pupil.radius if pupil_radius is None else pupil_radius, 0.0
    y_bar, w_bar = -pupil.z * tan(field_angle), n[0] * tan(field_angle)
    invariant = w_bar * y - w * y_bar
    sums, axial, lateral = np.zeros((len(lens.surfaces), 5)), np.zeros(len(n) - 1), np.zeros(len(n) - 1)
    for i, surface in enumerate(lens.surfaces):
        # Sums of the surface: A = n i, Ā = n ī, Δ(u / n)
        c, before, after = surface.vertex_curvature, n[i], n[i + 1]
        a, a_bar = w + before * y * c, w_bar + before * y_bar * c
        inverse, inverse2 = 1.0 / after - 1.0 / before, after**-2 - before**-2
        delta = a * inverse2 - y * c * inverse
        petzval = -(invariant**2) * c * inverse
        # S_V without a quotient, since A may be 0
        distortion = a_bar * (c * y_bar * (a_bar * y + invariant) * inverse - a_bar**2 * y * inverse2)
        sums[i] = -a * a * y * delta, -a * a_bar * y * delta, -a_bar**2 * y * delta, petzval, distortion
        figure = 8.0 * _fourth_power(surface) * (after - before)
        sums[i] += figure * y * np.array([y**3, y * y * y_bar, y * y_bar**2, 0.0, y_bar**3])
        if spread is not None:
            chromatic = y * (spread[i + 1] / after - spread[i] / before)
            axial[i], lateral[i] = a * chromatic, a_bar * chromatic

        # Refraction and transfer
        power = (after - before) * c
        w, w_bar = w - power * y, w_bar - power * y_bar
        gap = surface.thickness / after
        y, y_bar = y + gap * w, y_bar + gap * w_bar
    return Seidel(sums, axial if colour else None, lateral if colour else None, invariant)


def chief_ray(lens: Lens, field_angle: float, wavelength: float = D_LINE, clip: bool = False) -> ChiefRay:
    """The real ray from an object at infinity through the middle of the stop.

    It lies in the plane y–z and rises towards the film with a positive angle. The search traces from the stop
    outwards, so that the ray is exact to the rounding of its angle.

    Args:
        lens: Rotationally symmetric lens.
        field_angle: Angle of the object from the axis, radians; its size below π, beyond π/2 where the lens sees that
            far.
        wavelength: µm.
        clip: Whether the rims of the surfaces end the ray.
    Raises:
        LensError: For a lens with a cylinder or toroid, an entrance pupil at infinity, and where no ray passes: the
            message names the surface that ends the field and the angle at which it does.
    """
    check_symmetry(lens)
    if not abs(field_angle) < pi:
        raise LensError(f"field angle {significant(np.degrees(field_angle), 4)}°: it must lie below 180°")
    if isinf(first_order(lens, wavelength).entrance_pupil.z):
        raise LensError("the entrance pupil of this lens lies at infinity: it has no chief ray from a far object")
    ray = _chief_ray(lens, field_angle, wavelength, clip)
    if isinstance(ray, ChiefRay):
        return ray
    end, dark, why = 0.0, field_angle, ray
    for _ in range(_HALVINGS):
        middle = 0.5 * (end + dark)
        ray = _chief_ray(lens, middle, wavelength, clip)
        end, dark, why = (middle, dark, why) if isinstance(ray, ChiefRay) else (end, middle, ray)
    raise LensError(f"no chief ray at {significant(np.degrees(field_angle), 4)}°: beyond "
                    f"{significant(np.degrees(end), 4)}° it would {why}")


def astigmatic_foci(lens: Lens, field_angle: float, wavelength: float = D_LINE) -> tuple[float, float]:
    """Tangential and sagittal foci along the chief ray of an object at infinity (Welford, ch. 9).

    Args:
        lens: Rotationally symmetric lens.
        field_angle: Angle of the object from the axis, radians.
        wavelength: µm.
    Returns:
        z of the tangential and of the sagittal focus, mm, lens frame; inf where the rays leave parallel.
    Raises:
        LensError: As `chief_ray`.
    """
    ray = chief_ray(lens, field_angle, wavelength)
    start = np.array([[0.0, sin(field_angle), cos(field_angle)]])
    return tuple(float(focus[0]) for focus in coddington(lens, ray.points[None], start, wavelength))    # type: ignore


def coddington(lens: Lens, points: np.ndarray, directions: np.ndarray, wavelength: float = D_LINE,
               vergences: np.ndarray | float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Tangential and sagittal foci along n rays of the meridian y–z, by Coddington's equations: z (n,) each, mm.

    points: (n, surfaces, 3) on the surfaces, mm; directions: (n, 3) unit vectors in the scene, both lens frame.
    vergences: (n,) index over distance to the object point, 1/mm, negative for a real object. inf where the rays leave
    parallel.
    """
    n, direction = lens.indices(wavelength), directions
    tangential = sagittal = np.broadcast_to(np.asarray(vergences, float), len(directions))
    with np.errstate(divide="ignore", invalid="ignore"):
        for i, surface in enumerate(lens.surfaces):
            before, after = n[i], n[i + 1]
            # Refract
            slope, across, along = _curvatures(surface, points[:, i, 1])
            size = np.hypot(1.0, slope)
            # The new direction comes from refraction, not from path points, whose gap may be too short to divide by
            cos_in = (direction[:, 2] - slope * direction[:, 1]) / size
            cos_out = np.sqrt(1.0 - (before / after) ** 2 * (1.0 - cos_in**2))
            power = after * cos_out - before * cos_in
            normal = np.stack([0.0 * slope, -slope, 1.0 + 0.0 * slope], 1)
            direction = (before * direction + (power / size)[:, None] * normal) / after
            sagittal = sagittal + power * across
            tangential = (tangential * cos_in**2 + power * along) / cos_out**2

            # Transfer along the chief ray
            if i < len(lens.surfaces) - 1:
                gap = ((points[:, i + 1] - points[:, i]) * direction).sum(1) / after
                sagittal, tangential = sagittal / (1.0 - sagittal * gap), tangential / (1.0 - tangential * gap)
        return tuple(np.where(vergence == 0.0, inf, points[:, -1, 2] + n[-1] / vergence * direction[:, 2])
                     for vergence in (tangential, sagittal))            # type: ignore[return-value]


def _chief_ray(lens: Lens, field_angle: float, wavelength: float, clip: bool) -> ChiefRay | str:
    """The chief ray, traced from the stop to both sides so that no digits are lost; or why it ends, in words."""
    z, angle = first_order(lens, wavelength).entrance_pupil.z, 0.0
    if field_angle:
        aim = _aim(lens, abs(field_angle), wavelength)
        if isinstance(aim, str):
            return aim
        z, angle = aim
    table, stop = surface_table(lens, wavelength), lens.stop_index
    direction = np.array([[0.0, copysign(1.0, field_angle) * sin(angle), cos(angle)]])
    points = np.full((2, 1, len(lens.surfaces) + 1, 3), nan)
    after, position = np.zeros((1, 3)), np.array([[0.0, 0.0, lens.vertices[stop]]])
    fate, surface = np.zeros(1, np.int32), np.zeros(1, np.int32)
    for order, first, last in ((-1, 0, stop), (1, stop, len(lens.surfaces))):
        if first == last:
            continue
        trace_rays(table.part(first, last), clip, position, order * direction, np.empty((1, 3)), after, fate, surface,
                   points[max(order, 0)], order)
        if fate[0] != PASSED:
            return _end(int(fate[0]), int(surface[0]), order, first, last)
    path = np.concatenate([points[0, 0, 1:stop + 1][::-1], points[1, 0, 1:len(lens.surfaces) - stop + 1]])
    return ChiefRay(field_angle, z, path, after[0])


def _end(fate: int, surface: int, order: int, first: int, last: int) -> str:
    """Why a ray ends among the surfaces first … last − 1, in words; surface counts from first."""
    if fate == Fate.MISSED:
        surface = surface + order if surface >= 0 else (0 if order > 0 else last - first - 1)
    return f"{_ENDS[Fate(fate)]} surface {first + surface}"


def _aim(lens: Lens, target: float, wavelength: float) -> tuple[float, float] | str:
    """The point of the axis (z, mm) that the chief ray of an angle crosses in the scene, and its angle at the stop.

    Rays leave the middle of the stop for the scene, ever steeper, until one leaves the lens beyond the wanted angle;
    the root lies between the last two. Where these rays end, or their angle decreases again, the result is the reason,
    in words.
    """
    stop = lens.stop_index
    table, start, n = surface_table(lens, wavelength).part(0, stop), lens.vertices[stop], lens.indices(wavelength)
    magnified = ray_matrix(lens, 0, stop, wavelength)[0] * n[stop] / n[0]       # scene angle over angle at stop
    side = -1.0 if magnified > 0.0 else 1.0

    def leave(angle: float) -> tuple[float, float, float, str]:
        """Height, z and angle in the scene of a ray from the stop; NaN where it ends, and why."""
        if not stop:
            return 0.0, start, angle, ""
        _, y, z, _, dy, dz, fate, surface = trace_ray(table, False, 0.0, 0.0, start, 0.0, side * sin(angle),
                                                      -cos(angle), None, 0, -1)
        if fate == PASSED:
            return y, z, atan2(-dy, -dz), ""
        return nan, nan, nan, _end(fate, surface, -1, 0, stop)

    def short(angle: float) -> float:
        return leave(angle)[2] - target

    # Bracket the wanted angle
    step = max(_FIELD_STEP / max(1.0, abs(magnified)), _LEAST_STEP)
    before, low, high, why = 0.0, 0.0, 0.0, f"not meet surface {stop} from the scene"
    while short(high) < 0.0 and high < 0.5 * pi:
        before, low, high = low, high, min(high + step, 0.5 * pi)
        if isnan(short(high)) or short(high) <= short(low):
            break
    # Where the last ray is lost, find the steepest one that passes
    if isnan(short(high)):
        good = low
        for _ in range(_HALVINGS):
            middle = 0.5 * (good + high)
            good, high = (good, middle) if isnan(short(middle)) else (middle, high)
        why, high = leave(high)[3], good
    # Where the angle turns back, find its maximum
    if not short(high) >= 0.0:
        top = find_minimum(lambda angle: -short(angle), before, high)
        if short(top) > short(high):
            low, high, why = before, top, "see no more of the scene"
        if not short(high) >= 0.0:
            return why

    # Find the root between
    angle = find_root(short, low, high)
    angle = high if isnan(short(angle)) else angle                      # rounding loses some rays at the field's end
    y, z, beyond, _ = leave(angle)
    return z - y * cos(beyond) / sin(beyond), -side * angle


def _fourth_power(surface: Surface) -> float:
    """Coefficient of r⁴ less that of the sphere with the same vertex curvature, mm⁻³."""
    c = surface.curvature
    return ((1.0 + surface.conic) * c**3 - surface.vertex_curvature**3) / 8.0 + dict(surface.aspheric).get(4, 0.0)


def _curvatures(surface: Surface, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """dz/dy at heights y (n,), and the curvatures across and along the meridian, 1/mm."""
    c, r = surface.curvature, np.abs(y)
    root = np.sqrt(1.0 - (1.0 + surface.conic) * (c * r) ** 2)
    over_r, second = c / root, c / root**3              # dz/dr / r, d²z/dr²
    for power, a in surface.aspheric:
        over_r = over_r + power * a * r ** (power - 2)
        second = second + power * (power - 1) * a * r ** (power - 2)
    steep = np.sqrt(1.0 + (over_r * r) ** 2)
    return over_r * y, over_r / steep, second / steep**3


def check_symmetry(lens: Lens) -> None:
    """LensError for a lens without rotational symmetry."""
    if not lens.is_rotationally_symmetric:
        raise LensError("aberrations are computed for rotationally symmetric lenses: this one has "
                        f"{lens.asymmetry}")
