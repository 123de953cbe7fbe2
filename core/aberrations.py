"""Aberrations of a lens for an object at infinity: Seidel sums, first-order colour, and the foci along the chief ray.

Lengths in mm, angles in radians. Seidel sums are Welford's S_I to S_V (of the
wavefront, in mm), colour his C_L and C_T; a conic and the r⁴ term count, an r²
term is curvature, and odd terms below r⁵, which third-order theory has no place
for, are left out. Sources: Welford, Aberrations of Optical Systems, ch. 8 and
10; Coddington's equations, ch. 9.
"""

from dataclasses import dataclass
from math import cos, hypot, inf, isinf, pi, sin, sqrt, tan

import numpy as np

from lensbench.glass import D_LINE
from lensbench.paraxial import first_order
from lensbench.prescription import Lens, LensError, Surface
from lensbench.tracing import PASSED, surface_table, trace, trace_ray

_FIELD_STEP = 0.05              # from one chief ray to the next on the way to a steep one, rad
_SECANTS = 40
_STILL = 1e-14                  # × the lens's size: where the chief ray crosses the stop


@dataclass(frozen=True, eq=False)
class Seidel:
    """Third-order sums, mm. surfaces (n, 5): S_I … S_V of each surface; total (5,).

    axial_colour, lateral_colour (n,): C_L and C_T of each surface, the shorter
    wavelength less the longer; None where they were not asked for. invariant: Lagrange's, n (ū y − u ȳ).
    """

    surfaces: np.ndarray
    axial_colour: np.ndarray | None
    lateral_colour: np.ndarray | None
    invariant: float

    @property
    def total(self) -> np.ndarray:
        """The sums over all surfaces: spherical aberration, coma, astigmatism, Petzval curvature, distortion."""
        return self.surfaces.sum(axis=0)


@dataclass(frozen=True, eq=False)
class ChiefRay:
    """The real ray through the middle of the stop. points (surfaces, 3) mm, lens frame; direction (3,) after the lens.

    pupil_z: where it crosses the axis in the scene, the real entrance pupil (lens frame, mm).
    """

    field_angle: float
    pupil_z: float
    points: np.ndarray
    direction: np.ndarray


def seidel(lens: Lens, field_angle: float, pupil_radius: float | None = None, wavelength: float = D_LINE,
           colour: tuple[float, float] | None = None) -> Seidel:
    """Seidel sums for an object at infinity, field_angle (rad) from the axis.

    pupil_radius: of the entrance pupil (mm), None: as the stop gives it. colour: two
    wavelengths, the shorter first, such as (lb.F_LINE, lb.C_LINE), for C_L and C_T. LensError where the
    lens has a cylinder or toroid, the entrance pupil lies at infinity, or the angle reaches 90°.
    """
    _check(lens, field_angle)
    pupil = first_order(lens, wavelength).entrance_pupil
    if isinf(pupil.z):
        raise LensError("the entrance pupil of this lens lies at infinity: it has no chief ray from a far object")
    n = lens.indices(wavelength)
    spread = np.subtract(lens.indices(colour[0]), lens.indices(colour[1])) if colour else None

    # A marginal ray (y, w = n u) and a chief ray (ȳ, w̄)
    y, w = pupil.radius if pupil_radius is None else pupil_radius, 0.0
    y_bar, w_bar = -pupil.z * tan(field_angle), n[0] * tan(field_angle)
    invariant = w_bar * y - w * y_bar
    sums, axial, lateral = np.zeros((len(lens.surfaces), 5)), np.zeros(len(n) - 1), np.zeros(len(n) - 1)
    for i, surface in enumerate(lens.surfaces):
        c, before, after = surface.vertex_curvature, n[i], n[i + 1]
        a, a_bar = w + before * y * c, w_bar + before * y_bar * c
        inverse, inverse2 = 1.0 / after - 1.0 / before, after**-2 - before**-2
        bend = a * inverse2 - y * c * inverse                           # Δ(u / n)
        petzval = -(invariant**2) * c * inverse
        # S_V without a quotient, for A may be 0
        distortion = a_bar * (c * y_bar * (a_bar * y + invariant) * inverse - a_bar**2 * y * inverse2)
        sums[i] = -a * a * y * bend, -a * a_bar * y * bend, -a_bar**2 * y * bend, petzval, distortion
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


def chief_ray(lens: Lens, field_angle: float, wavelength: float = D_LINE) -> ChiefRay:
    """The real ray from a far object, field_angle (rad, below 90°) from the axis, through the middle of the stop.

    It lies in the plane y–z and rises with a positive angle. Steep rays are
    reached from the axis in steps, for the pupil wanders. LensError where no ray
    gets through.
    """
    _check(lens, field_angle)
    z = first_order(lens, wavelength).entrance_pupil.z
    if isinf(z):
        raise LensError("the entrance pupil of this lens lies at infinity: it has no chief ray from a far object")
    table = surface_table(lens, wavelength)[:lens.stop_index + 1]
    steps = max(1, int(abs(field_angle) / _FIELD_STEP))
    before = z
    for step in range(1, steps + 1):
        angle = field_angle * step / steps
        found = _aim(table, angle, z + (z - before)) if angle else z
        before, z = z, found
    direction = np.array([0.0, sin(field_angle), cos(field_angle)])
    t = trace(lens, [0.0, 0.0, z], direction, wavelength, clip=False, record=True)
    if t.fate[0] != PASSED or t.paths is None:
        raise LensError(f"no chief ray gets through at {np.degrees(field_angle):.4g}°")
    return ChiefRay(field_angle, z, t.paths[0, 1:], t.directions[0])


def astigmatic_foci(lens: Lens, field_angle: float, wavelength: float = D_LINE) -> tuple[float, float]:
    """Where, in z (mm, lens frame), the tangential and sagittal foci lie on a far object's chief ray, by Coddington.

    inf where the rays leave parallel. LensError as `chief_ray`.
    """
    ray = chief_ray(lens, field_angle, wavelength)
    n, at = lens.indices(wavelength), ray.points
    tangential = sagittal = 0.0                         # vergences, n / distance
    way = np.array([0.0, sin(field_angle), cos(field_angle)])
    for i, surface in enumerate(lens.surfaces):
        y, before, after = float(at[i, 1]), n[i], n[i + 1]
        slope, across, along = _curvatures(surface, y)
        size = hypot(1.0, slope)
        # Angles with the normal; refraction itself gives the direction after, so that no gap divides
        cos_in = (way[2] - slope * way[1]) / size
        cos_out = sqrt(1.0 - (before / after) ** 2 * (1.0 - cos_in**2))
        power = after * cos_out - before * cos_in
        way = (before * way + power * np.array([0.0, -slope, 1.0]) / size) / after
        sagittal = sagittal + power * across
        tangential = (tangential * cos_in**2 + power * along) / cos_out**2
        if i < len(lens.surfaces) - 1:
            gap = float((at[i + 1] - at[i]) @ way) / after
            sagittal, tangential = sagittal / (1.0 - sagittal * gap), tangential / (1.0 - tangential * gap)
    last = float(at[-1, 2])
    return tuple(last + n[-1] / vergence * float(way[2]) if vergence else inf       # type: ignore[return-value]
                 for vergence in (tangential, sagittal))


def _aim(table: np.ndarray, angle: float, guess: float) -> float:
    """Where on the axis (z, mm) a ray of this angle must cross to pass the middle of the stop; a damped secant."""
    size = 1.0 + float(np.ptp(table[:, 1]))
    dy, dz = sin(angle), cos(angle)

    def height(z: float) -> float:
        _, y, _, _, _, _, fate, _ = trace_ray(table, False, 0.0, 0.0, z, 0.0, dy, dz, None, 0)
        return y if fate == PASSED else inf

    z, other = guess, guess + 1e-3 * size
    at, at_other = height(z), height(other)
    for _ in range(_SECANTS):
        if isinf(at) or isinf(at_other) or at == at_other:
            break
        step = -at * (z - other) / (at - at_other)
        while isinf(ahead := height(z + step)) and abs(step) > _STILL * size:
            step *= 0.5
        other, at_other, z, at = z, at, z + step, ahead
        if abs(step) <= _STILL * size or at == 0.0:
            return z
    if abs(at) <= 1e3 * _STILL * size:                  # rounding makes it wander there
        return z
    raise LensError(f"no chief ray was found at {np.degrees(angle):.4g}°")


def _fourth_power(surface: Surface) -> float:
    """Coefficient of r⁴ beyond that of the sphere of the same curvature at the vertex."""
    c = surface.curvature
    return ((1.0 + surface.conic) * c**3 - surface.vertex_curvature**3) / 8.0 + dict(surface.aspheric).get(4, 0.0)


def _curvatures(surface: Surface, y: float) -> tuple[float, float, float]:
    """At height y: dz/dy, and the curvatures across and along the meridian (1/mm)."""
    c, r = surface.curvature, abs(y)
    root = sqrt(1.0 - (1.0 + surface.conic) * (c * r) ** 2)
    over_r, second = c / root, c / root**3              # dz/dr / r, d²z/dr²
    for power, a in surface.aspheric:
        over_r += power * a * r ** (power - 2)
        second += power * (power - 1) * a * r ** (power - 2)
    steep = sqrt(1.0 + (over_r * r) ** 2)
    return over_r * y, over_r / steep, second / steep**3


def _check(lens: Lens, field_angle: float) -> None:
    if not lens.is_rotationally_symmetric:
        raise LensError("aberrations are known for rotationally symmetric lenses: this one has a cylinder or toroid")
    if not abs(field_angle) < 0.5 * pi:
        raise LensError(f"field angle {np.degrees(field_angle):.4g}°: it must lie below 90°")
