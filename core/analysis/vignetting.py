"""Vignetting: the part of a beam that passes the clear apertures, and falloff of light over the film.

Lengths in mm, angles in radians, lens frame. A ray is named by its height across the beam: its position on the plane
through the first vertex perpendicular to the direction of the field, so that heights exist at 90° and beyond.

The irradiance of a film point under a scene of radiance 1 is E = (1/z²) ∫ cos⁴θ dA over its exit-pupil region, at the
distance z: the mean of cos⁴θ (natural falloff) times the region's area, which shows what clear apertures cut off, and
what pupil aberrations add or take. Both sides in air.
"""

from dataclasses import dataclass
from math import cos, inf, isinf, pi, sin

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import MISSED, PASSED, trace
from lensbench.core.pupils.region import exit_pupil
from lensbench.core.text import significant

_PROFILE = 513          # points along the first surface, whose shadow contains the beam
_SCAN = 1025            # heights in one scan for the beam
_ZOOMS = 5              # scans about the height that comes closest to passing
_PARTS, _SPLITS = 32, 12                        # 32¹² is finer than the rounding of any height


@dataclass(frozen=True)
class Vignetting:
    """The beam of an object point in the plane y–z that passes a lens, from `vignetting`.

    Args:
        field_angle: Angle of the object point from the axis, radians.
        distance: From the first vertex to the object point, mm; may be math.inf.
        low, high: Lowest and highest height across the beam that passes, mm.
        low_surface, high_surface: Surfaces that limit the beam there: by their rims, or because rays beyond miss them
            or are totally reflected.
        half_width: Half the beam's extent in x, midway between low and high, mm.
        half_width_surface: Surface that limits this extent.
    """

    field_angle: float
    distance: float
    low: float
    high: float
    low_surface: int
    high_surface: int
    half_width: float
    half_width_surface: int

    def on_plane(self, z: float) -> tuple[float, float]:
        """Heights y (mm) of the rays `low` and `high` on the plane at z (mm, lens frame), before refraction."""
        rays = (_rays(self.field_angle, self.distance, np.zeros(1), np.array([height])) for height in
                (self.low, self.high))
        low, high = (float(origin[0, 1] + (z - origin[0, 2]) * direction[0, 1] / direction[0, 2])
                     for origin, direction in rays)
        return low, high


def vignetting(lens: Lens, field_angle: float, distance: float = inf, wavelength: float = D_LINE) -> Vignetting:
    """The beam of an object point that passes a lens.

    The edges are exact to rounding. Of a beam in several pieces the widest counts, if it is wider than a thousandth
    of the first surface's shadow; the stop counts as the circle about its blades.

    Args:
        lens: The lens.
        field_angle: Angle of the object point from the axis, radians, its size below π; positive for light that rises
            towards the film.
        distance: From the first vertex to the object point, mm; may be math.inf.
        wavelength: µm.
    Raises:
        LensError: For a lens with tilted or decentred surfaces, where no light passes, for an angle from 180° on, and
            for a distance that is not positive.
    """
    if not abs(field_angle) < pi:
        raise LensError(f"field angle {significant(np.degrees(field_angle), 4)}°: it must lie below 180°")
    if not distance > 0.0:
        raise LensError(f"distance {significant(distance)} mm: it must be positive, or math.inf")

    if not lens.is_centred:
        raise LensError("vignetting needs a plane of symmetry, and this lens has a tilted or decentred surface: "
                        "lb.open_region has the light of a film point")

    beam = _Beam(lens, field_angle, distance, wavelength)
    heights, passing = beam.scan()
    if not passing.size:
        raise LensError(f"no light of a point at {significant(np.degrees(field_angle), 4)}° passes this lens")
    piece = max(np.split(passing, np.flatnonzero(np.diff(passing) > 1) + 1), key=len)
    spacing = float(heights[1] - heights[0])
    (_, low), low_surface = beam.edge(np.array([0.0, heights[piece[0]]]), np.array([0.0, -spacing]))
    (_, high), high_surface = beam.edge(np.array([0.0, heights[piece[-1]]]), np.array([0.0, spacing]))
    middle = np.array([0.0, 0.5 * (low + high)])
    (half, _), half_surface = beam.edge(middle, np.array([lens.surfaces[0].semi_diameter, 0.0]))
    return Vignetting(field_angle, distance, float(low), float(high), low_surface, high_surface, float(half),
                      half_surface)


@dataclass(frozen=True, eq=False)
class _Beam:
    """The rays of an object point, at places (x, height) across the beam."""

    lens: Lens
    field_angle: float
    distance: float
    wavelength: float

    def clearances(self, x: np.ndarray, height: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Greatest distance from the axis over the rim, of all surfaces; and the surface that ends the ray, or −1."""
        origins, directions = _rays(self.field_angle, self.distance, x, height)
        t = trace(self.lens, origins, directions, self.wavelength, clip=False, record=True, forward=True)
        assert t.paths is not None
        rims = np.array([surface.semi_diameter for surface in self.lens.surfaces])
        share = np.hypot(t.paths[:, 1:, 0], t.paths[:, 1:, 1]) / rims
        share = np.where(np.isnan(share), 0.0, share)
        lost = t.fate != PASSED
        outside = share > 1.0
        ends = np.where(lost, t.surface + (t.fate == MISSED), -1)
        ends = np.where(outside.any(1), outside.argmax(1), ends)
        return np.where(lost, inf, share.max(1)), ends

    def scan(self) -> tuple[np.ndarray, np.ndarray]:
        """Heights (n,) of a scan that finds the beam, and the indices of those that pass; none for no beam."""
        low, high = _shadow(self.lens, self.field_angle, self.distance)
        width = high - low
        for _ in range(_ZOOMS):
            heights = np.linspace(low - 1e-3 * width, high + 1e-3 * width, _SCAN)
            clearance, ends = self.clearances(0.0 * heights, heights)
            if (ends < 0).any() or isinf(clearance.min()):
                break
            nearest = heights[int(np.argmin(clearance))]
            width *= 8.0 / _SCAN
            low, high = nearest - 0.5 * width, nearest + 0.5 * width
        return heights, np.flatnonzero(ends < 0)

    def edge(self, inside: np.ndarray, step: np.ndarray) -> tuple[np.ndarray, int]:
        """Last point (2,) that passes, from one inside along a step, and the surface that ends the beam."""
        outside = inside + step
        while self.clearances(outside[:1], outside[1:])[1][0] < 0:
            inside, step = outside, 2.0 * step
            outside = inside + step
        for _ in range(_SPLITS):
            points = inside + np.linspace(0.0, 1.0, _PARTS + 1)[:, None] * (outside - inside)
            ends = self.clearances(points[:, 0], points[:, 1])[1]
            first = 1 + int(np.argmax(ends[1:] >= 0))
            inside, outside, end = points[first - 1], points[first], int(ends[first])
        return inside, end


def _rays(field_angle: float, distance: float, x: np.ndarray, height: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions (n, 3) of the rays at places x and height (n,) across the beam."""
    along = np.array([0.0, sin(field_angle), cos(field_angle)])
    across = np.array([0.0, cos(field_angle), -sin(field_angle)])
    origins = x[:, None] * [1.0, 0.0, 0.0] + height[:, None] * across
    if isinf(distance):
        return origins, np.broadcast_to(along, origins.shape)
    return origins, origins / distance + along


def _shadow(lens: Lens, field_angle: float, distance: float) -> tuple[float, float]:
    """Lowest and highest point of the first surface, as heights across the beam."""
    y = np.linspace(-1.0, 1.0, _PROFILE) * lens.surfaces[0].semi_diameter
    z = lens.surfaces[0].sag(0.0, y)
    y, z = y[np.isfinite(z)], z[np.isfinite(z)]
    height = y * cos(field_angle) - z * sin(field_angle)
    if not isinf(distance):
        towards = 1.0 + (y * sin(field_angle) + z * cos(field_angle)) / distance
        height = height[towards > 0.0] / towards[towards > 0.0]
    if not height.size:
        raise LensError(f"a point {significant(distance)} mm away lies within the first surface")
    return float(height.min()), float(height.max())


@dataclass(frozen=True, eq=False)
class Falloff:
    """Falloff at n film radii relative to the axis, from `falloff`.

    Args:
        radii: (n,) film radii, mm.
        natural: (n,) mean of cos⁴θ over the exit-pupil region, over that on the axis; NaN where no light falls.
        vignetting: (n,) area of the exit-pupil region, over that on the axis; 0 where no light falls.
        irradiance: (n,) irradiance under a scene of radiance 1; π sin²θ′ on the axis.
    """

    radii: np.ndarray
    natural: np.ndarray
    vignetting: np.ndarray
    irradiance: np.ndarray

    @property
    def total(self) -> np.ndarray:
        """(n,) relative illumination, natural × vignetting; 0 where no light falls."""
        return np.where(self.vignetting > 0.0, self.natural * self.vignetting, 0.0)

    @property
    def stops(self) -> np.ndarray:
        """(n,) total in stops: 0 on the axis, negative where it is darker, −inf where no light falls."""
        with np.errstate(divide="ignore"):
            return np.log2(self.total)


def falloff(lens: Lens, film_distance: float, film_radii: ArrayLike, wavelength: float = D_LINE) -> Falloff:
    """The falloff of a lens; its blades count as a circle of as much area.

    Args:
        lens: The lens.
        film_distance: From the last vertex to the film, mm.
        film_radii: (n,) film radii, mm.
        wavelength: µm.
    Raises:
        LensError: For invalid radii and distances.
    """
    radii = np.atleast_1d(np.asarray(film_radii, float))
    pupil = exit_pupil(lens.with_round_stop, film_distance, np.append(0.0, radii), wavelength)
    light, area = pupil.cos4_area, pupil.area
    with np.errstate(divide="ignore", invalid="ignore"):
        cos4 = np.where(area > 0.0, light / area, np.nan)
        natural, vignetting = cos4[1:] / cos4[0], area[1:] / area[0]
    return Falloff(radii, natural, np.nan_to_num(vignetting), light[1:] / film_distance**2)
