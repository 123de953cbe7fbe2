"""Vignetting: how much of the beam of one object point the rims of a lens let pass, and which rims end it.

Lengths in mm, angles in radians. A ray is named by its height across the beam: where it goes through the plane that
contains the first vertex and stands at right angles to the direction of the field. So the beam has a height at every
field angle, 90° and beyond included; `Vignetting.on_plane` turns it into heights on a plane z = constant, such as
that of the first vertex or of the entrance pupil.
"""

from dataclasses import dataclass
from math import cos, inf, isinf, pi, sin

import numpy as np

from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens, LensError
from lensbench.optics.scalar_trace import MISSED, PASSED, trace

_PROFILE = 513          # points along the first surface, whose shadow says where the beam can be
_SCAN = 1025            # heights in one look for it
_ZOOMS = 5              # looks about the height that comes closest to passing
_PARTS, _SPLITS = 32, 12                        # 32¹² is beyond the rounding of any height


@dataclass(frozen=True)
class Vignetting:
    """The beam of an object point in the plane y–z that passes: from `low` to `high` (mm, across the beam).

    low_surface, high_surface: what ends it there, by its rim or because rays beyond miss it or are
    reflected at it. half_width: half the beam's extent in x where the height is in the middle between low and
    high; half_width_surface ends it.
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
        """Heights y (mm) at which the rays `low` and `high` cross the plane z (mm, lens frame) on their way in."""
        rays = (_rays(self.field_angle, self.distance, np.zeros(1), np.array([height])) for height in
                (self.low, self.high))
        low, high = (float(origin[0, 1] + (z - origin[0, 2]) * way[0, 1] / way[0, 2]) for origin, way in rays)
        return low, high


def vignetting(lens: Lens, field_angle: float, distance: float = inf, wavelength: float = D_LINE) -> Vignetting:
    """What passes of the beam of a point `distance` mm from the first vertex, field_angle (rad) from the axis.

    A positive angle is that of light that rises towards the film; it may reach 90° and more. The edges are exact
    to rounding. Of a beam that falls in pieces the widest counts, if it is wider than a thousandth of the first
    surface's shadow; the stop counts as the circle about its blades. LensError where nothing passes, or for an
    angle of 180° or a distance that cannot be.
    """
    if not abs(field_angle) < pi:
        raise LensError(f"field angle {np.degrees(field_angle):.4g}°: it must lie below 180°")
    if not distance > 0.0:
        raise LensError(f"distance {distance:g} mm: it must be positive, or math.inf")

    rims = np.array([surface.semi_diameter for surface in lens.surfaces])

    def margins(x: np.ndarray, height: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distance from the axis over the rim, the greatest of all surfaces; and which surface ends the ray, or −1."""
        t = trace(lens, *_rays(field_angle, distance, x, height), wavelength, clip=False, record=True, forward=True)
        assert t.paths is not None
        share = np.hypot(t.paths[:, 1:, 0], t.paths[:, 1:, 1]) / rims
        share = np.where(np.isnan(share), 0.0, share)
        lost = t.fate != PASSED
        outside = share > 1.0
        ends = np.where(lost, t.surface + (t.fate == MISSED), -1)
        ends = np.where(outside.any(1), outside.argmax(1), ends)
        return np.where(lost, inf, share.max(1)), ends

    def edge(inside: np.ndarray, step: np.ndarray) -> tuple[np.ndarray, int]:
        """From a place (x, height) that passes, the last one in the direction of step that does, and what ends it."""
        outside = inside + step
        while margins(outside[:1], outside[1:])[1][0] < 0:
            inside, step = outside, 2.0 * step
            outside = inside + step
        for _ in range(_SPLITS):
            places = inside + np.linspace(0.0, 1.0, _PARTS + 1)[:, None] * (outside - inside)
            ends = margins(places[:, 0], places[:, 1])[1]
            first = 1 + int(np.argmax(ends[1:] >= 0))
            inside, outside, end = places[first - 1], places[first], int(ends[first])
        return inside, end

    # Where the beam is
    low, high = _shadow(lens, field_angle, distance)
    width = high - low
    for _ in range(_ZOOMS):
        heights = np.linspace(low - 1e-3 * width, high + 1e-3 * width, _SCAN)
        margin, ends = margins(0.0 * heights, heights)
        if (ends < 0).any() or isinf(margin.min()):
            break
        nearest = heights[int(np.argmin(margin))]
        width *= 8.0 / _SCAN
        low, high = nearest - 0.5 * width, nearest + 0.5 * width
    passing = np.flatnonzero(ends < 0)
    if not passing.size:
        raise LensError(f"no light of a point at {np.degrees(field_angle):.4g}° passes this lens")
    piece = max(np.split(passing, np.flatnonzero(np.diff(passing) > 1) + 1), key=len)

    # Its edges
    spacing = float(heights[1] - heights[0])
    (_, low), low_surface = edge(np.array([0.0, heights[piece[0]]]), np.array([0.0, -spacing]))
    (_, high), high_surface = edge(np.array([0.0, heights[piece[-1]]]), np.array([0.0, spacing]))
    middle = np.array([0.0, 0.5 * (low + high)])
    (half, _), half_surface = edge(middle, np.array([lens.surfaces[0].semi_diameter, 0.0]))
    return Vignetting(field_angle, distance, float(low), float(high), low_surface, high_surface, float(half),
                      half_surface)


def _rays(field_angle: float, distance: float, x: np.ndarray, height: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Origins and directions (n, 3) of the rays at x and height (n,) across the beam."""
    along = np.array([0.0, sin(field_angle), cos(field_angle)])
    across = np.array([0.0, cos(field_angle), -sin(field_angle)])
    origins = x[:, None] * [1.0, 0.0, 0.0] + height[:, None] * across
    if isinf(distance):
        return origins, np.broadcast_to(along, origins.shape)
    return origins, origins / distance + along


def _shadow(lens: Lens, field_angle: float, distance: float) -> tuple[float, float]:
    """The least and the greatest height across the beam of the points of the first surface."""
    y = np.linspace(-1.0, 1.0, _PROFILE) * lens.surfaces[0].semi_diameter
    z = lens.surfaces[0].sag(0.0, y)
    y, z = y[np.isfinite(z)], z[np.isfinite(z)]
    height = y * cos(field_angle) - z * sin(field_angle)
    if not isinf(distance):
        towards = 1.0 + (y * sin(field_angle) + z * cos(field_angle)) / distance
        height = height[towards > 0.0] / towards[towards > 0.0]
    if not height.size:
        raise LensError(f"a point {distance:g} mm away lies within the first surface")
    return float(height.min()), float(height.max())
