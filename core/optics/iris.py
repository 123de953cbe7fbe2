"""Shape of the stop: a circle, an iris of n blades, straight or rounded, or a picture in it (`stop_image`).

Each blade is an arc between two corners; its height over the chord is `roundness` times that of the circle through
them: 0 is the polygon, 1 the circle. The edge of the stop cuts off corners beyond it: the blades of a lens that is wide
open lie behind it; as the lens is stopped down, their middles first flatten the circle, then the corners appear. The
f-number refers to the circle of equal area (ISO 517): (n / 2π) sin(2π/n) of the circle through n straight blades'
corners. Camera and lens frame, x right and y up; the rotation is in radians, counter-clockwise as seen from behind the
camera, and at 0 a corner points up.

The stages map samples of the disk to the opening, and block rays at the blades.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.kernels.block import (
    A0, A1, A2, A3, A4, A5, CLEARANCE, U0, U1, WEIGHT, B, Step, X, Y, gather, rows, stage
)
from lensbench.core.kernels.numeric import find_root, gauss_rule
from lensbench.core.optics.stop_image import RINGS, StopImage
from lensbench.core.text import significant

# Parameters of `map_to_iris`: chords, azimuth of the first corner (turns), then their ends: x of all, y of all
CHORDS, CORNER, ENDS = range(3)
# Parameters of `block_by_blades`: coefficient of r², then those of x and y for each blade
BULGE, SIDES = range(2)


@stage
def map_to_iris(lanes, p, ints, key):
    """Pupil samples U0, U1 of the whole disk become samples of the opening, by equal areas. p: of `_chords`."""
    real = lanes.dtype.type
    row = rows(lanes)
    u, v = row[U0], row[U1]
    chord, along, ax, ay, bx, by = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    n, begin = p[CHORDS], p[CORNER]
    count = np.int64(n)
    end_x, end_y = p[ENDS:], p[ENDS + count + 1:]
    # Azimuth of the sample in turns, by the concentric map; its chord and the position along it
    for i in range(B):
        a, b = real(2) * v[i] - real(1), real(2) * u[i] - real(1)
        steep = abs(b) > abs(a)
        far, near = (b, a) if steep else (a, b)
        safe = far if far != real(0) else real(1)
        quarter = (real(0.25) if steep else real(0)) + (real(0.5) if far < real(0) else real(0))
        turns = quarter + real(0.125) * (-near / safe if steep else near / safe) - begin
        position = (turns - np.floor(turns)) * n
        # The last chord where rounding makes n of it, and for NaN
        first = np.floor(position) if position < n else n - real(1)
        chord[i], along[i] = first, position - first
    # Ends of the chord
    gather(ax, end_x, chord)
    gather(bx, end_x[1:], chord)
    gather(ay, end_y, chord)
    gather(by, end_y[1:], chord)
    for i in range(B):
        a, b = abs(real(2) * v[i] - real(1)), abs(real(2) * u[i] - real(1))
        reach = a if a > b else b
        f = along[i]
        x, y = (ax[i] + f * (bx[i] - ax[i])) * reach, (ay[i] + f * (by[i] - ay[i])) * reach
        # Back to the square by the inverse concentric map; within an octant atan q = 2 atan(q / (1 + √(1 + q²)))
        steep = abs(y) > abs(x)
        far, near = (y, x) if steep else (x, y)
        q = near / (far if far != real(0) else real(1))
        q = q / (real(1) + math.sqrt(real(1) + q * q))
        s = q * q
        arctangent = q * (real(1) - s * (real(1 / 3) - s * (real(1 / 5) - s * (real(1 / 7) - s * (real(1 / 9) - s * (
            real(1 / 11) - s * (real(1 / 13) - s * (real(1 / 15) - s * real(1 / 17)))))))))
        out = math.sqrt(x * x + y * y)
        far = -out if far < real(0) else out
        near = arctangent * far * real(8 / math.pi)
        c, d = (near, far) if steep else (far, near)
        v[i], u[i] = real(0.5) + real(0.5) * c, real(0.5) + real(0.5) * d


@stage
def block_by_blades(lanes, p, ints, key):
    """Rays at the stop that meet the blades: WEIGHT becomes 0, and CLEARANCE greater than 1.

    p: BULGE, then the coefficients of x and y for each blade; a ray meets a blade where BULGE r² + a x + b y > 1.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, weight, clearance, most = row[X], row[Y], row[WEIGHT], row[CLEARANCE], row[A0]
    for i in range(B):
        most[i] = real(-1e30)
    for s in range(SIDES, p.size, 2):
        a, b = p[s], p[s + 1]
        for i in range(B):
            side = a * x[i] + b * y[i]
            most[i] = most[i] if most[i] >= side else side
    bulge = p[BULGE]
    for i in range(B):
        out = most[i] + bulge * (x[i] * x[i] + y[i] * y[i])
        clearance[i] = clearance[i] if clearance[i] >= out else out
        weight[i] = weight[i] if out <= real(1) else real(0)


MOST_BLADES = 24
CELLS = 32              # chords of one blade, for the map from the disk


class IrisError(ValueError):
    """An impossible shape of the stop; the message says what to do."""


@dataclass(frozen=True)
class Iris:
    """The shape of a stop of radius 1.

    Args:
        blades: Number of blades, 3 to 24, or 0 for a circle.
        rotation: Angle in radians, counter-clockwise as seen from behind the camera; at 0 a corner points up.
        roundness: 0 for straight blades to 1 for a circle.
        image: A picture in the stop, instead of blades.
        reach: Distance of the corners from the axis in units of the stop's radius, from 1; inf: behind the rim.
    Raises:
        IrisError: For other numbers, and for blades together with a picture.
    """

    blades: int = 0
    rotation: float = 0.0
    roundness: float = 0.0
    image: StopImage | None = None
    reach: float = 1.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.blades) and int(self.blades) == self.blades
                and (self.blades == 0 or 3 <= self.blades <= MOST_BLADES)):
            raise IrisError(f"{significant(self.blades)} blades: a stop has 3 to {MOST_BLADES} of them, or 0 "
                            f"for a circle")
        object.__setattr__(self, "blades", int(self.blades))
        if not math.isfinite(self.rotation):
            raise IrisError(f"blade rotation {significant(self.rotation)}: it must be a finite angle")
        if not 0.0 <= self.roundness <= 1.0:
            raise IrisError(f"blade roundness {significant(self.roundness)}: it must lie between 0 (straight) and "
                            f"1 (a circle)")
        if not self.reach >= 1.0:
            raise IrisError(f"reach {significant(self.reach)} of the blades: their corners lie on the stop's rim, 1, "
                            f"or farther out")
        if self.image is not None and self.blades:
            raise IrisError("a picture in the stop takes the place of the blades: give one of the two")

    @property
    def is_round(self) -> bool:
        """Whether the opening is a circle that passes all light."""
        return self.image is None and self._is_circle

    @property
    def _is_circle(self) -> bool:
        """Whether the opening is a circle, with or without a picture in it."""
        return self.blades == 0 or self.roundness == 1.0 or self._nearest * self.reach >= 1.0

    @property
    def is_mirrored(self) -> bool:
        """Whether the opening is its own mirror image left to right."""
        if self.image is not None:
            return False
        turns = self.rotation * self.blades / math.pi
        return self.is_round or math.isclose(turns, round(turns), abs_tol=1e-12)

    @property
    def upside_down(self) -> "Iris":
        """The iris turned by half a turn."""
        return replace(self, rotation=self.rotation + math.pi, image=self.image and self.image.upside_down)

    @property
    def area(self) -> float:
        """Area of the opening times its mean transmission, π for the circle.

        area / π of the light of a round stop passes.
        """
        return self.mean(lambda r: math.pi * r * r)

    @property
    def sampled_area(self) -> float:
        """Area over which pupil samples are spread: that within the blades, and the whole disk of a picture."""
        return math.pi if self.image is not None else self.area

    @property
    def equivalent_radius(self) -> float:
        """Radius of the circle that has the area of the opening; 1 for a picture, whose light is another matter."""
        return 1.0 if self.image is not None else math.sqrt(self.area / math.pi)

    def closed(self, share: float) -> tuple[float, float]:
        """The stop with its blades closed, or a round one made smaller, to a share (0 to 1) of the opening's current
        area.

        Returns the radius of the stop in units of the current one, and the `reach` of the blades for it.
        """
        if self.blades == 0 or self.roundness == 1.0 or share == 1.0:      # an open stop stays round to the last bit
            return math.sqrt(share), self.reach
        return _closed(self, share)

    def radius(self, azimuth: ArrayLike) -> np.ndarray:
        """Distance of the edge from the axis at an azimuth (radians from +x towards +y, also an array), in stop radii.

        1 for a picture, whose edge is that of the stop.
        """
        azimuth = np.asarray(azimuth, float)
        if self._is_circle:
            return np.ones_like(azimuth)
        half = math.pi / self.blades
        off = (azimuth - self.rotation - 0.5 * math.pi) % (2.0 * half) - half
        flat, bulge, rim = self._edge
        b = flat * np.cos(off)
        return np.minimum(2.0 * self.reach * rim / (b + np.sqrt(b * b + 4.0 * bulge * rim)), 1.0)

    def mean(self, function: Callable[[np.ndarray], np.ndarray]) -> float:
        """Mean over all azimuths of a function of the edge's distance (n,) in stop radii, by Gauss's rule along half a
        blade.

        The function returns what lies within these distances, (n,), 0 at 0. With a picture in the stop, each ring
        counts by its mean transmission.
        """
        if self.image is not None:
            return float(self.image.ring_means @ np.diff(function(np.sqrt(np.arange(RINGS + 1) / RINGS))))
        if self.is_round:
            return float(function(np.ones(1))[0])
        nodes, weights = gauss_rule(24)
        half, cut = math.pi / self.blades, self._cut
        azimuth = self.rotation + 0.5 * math.pi + cut + nodes * (half - cut)
        along = float(weights @ function(self.radius(azimuth)))
        return along if cut == 0.0 else (cut * float(function(np.ones(1))[0]) + (half - cut) * along) / half

    def outline(self, points: int = 24) -> np.ndarray:
        """Points (n, 2) of the edge, counter-clockwise from a corner, in stop radii: so many points a blade, 3 × of a
        circle.
        """
        count = max(self.blades, 3) * points
        azimuth = self.rotation + 0.5 * math.pi + 2.0 * math.pi * np.arange(count) / count
        return self.radius(azimuth)[:, None] * np.column_stack([np.cos(azimuth), np.sin(azimuth)])

    def contains(self, x: ArrayLike, y: ArrayLike) -> np.ndarray:
        """Whether points x, y (in units of the stop's radius, broadcast) lie in the opening, edge included.

        Of a picture where it passes any light.
        """
        within = np.hypot(x, y) <= self.radius(np.arctan2(y, x)) * (1.0 + 1e-12)
        return within if self.image is None else within & (self.image.at(x, y) > 0.0)

    def transmission(self, x: ArrayLike, y: ArrayLike) -> np.ndarray:
        """Part of the light that passes at points x, y (in units of the stop's radius, broadcast), from 0 to 1."""
        return self.contains(x, y).astype(float) if self.image is None else self.image.at(x, y)

    def axis_irradiance(self, radius: float, z: float) -> float:
        """∫ cos⁴θ dA (mm²) over the opening of a stop of this radius (mm), seen from a point on the axis z mm away."""
        return self.mean(lambda r: math.pi * (r * radius * z) ** 2 / (z * z + (r * radius) ** 2))

    @property
    def steps(self) -> list[Step]:
        """The step that maps pupil samples U0, U1 from the disk to the opening, by equal areas; none for a circle."""
        return [] if self._is_circle else [Step(map_to_iris, _chords(self))]

    @property
    def weighing(self) -> list[Step]:
        """The step that weighs rays by the picture where their pupil sample U0, U1 lies; none without a picture."""
        return [] if self.image is None else [self.image.sample_step]

    def blocking(self, radius: float) -> list[Step]:
        """Step of blades, or of the picture, in a stop of this radius (mm); none if round."""
        if self.image is not None:
            return [self.image.step(radius)]
        if self.is_round:
            return []
        flat, bulge, rim = self._edge
        radius = radius * self.reach            # beyond the stop's own radius the rim blocks
        azimuth = self.rotation + 0.5 * math.pi + (2.0 * np.arange(self.blades) + 1.0) * math.pi / self.blades
        normals = np.column_stack([np.cos(azimuth), np.sin(azimuth)]) * flat / (rim * radius)
        return [Step(block_by_blades, np.concatenate([[bulge / (rim * radius**2)], normals.ravel()]))]

    @property
    def _nearest(self) -> float:
        """Distance of the middle of a blade from the axis, the corners at 1."""
        cosine = math.cos(math.pi / self.blades)
        return cosine + self.roundness * (1.0 - cosine)

    @property
    def _cut(self) -> float:
        """Angle (radians) between a corner and where the rim meets the blade; 0 where the rim cuts off no corner."""
        if self.reach == 1.0:
            return 0.0
        flat, bulge, rim = self._edge
        # Where r = 1 / reach: f r cos(angle from the middle) + b r² = e
        cosine = (rim * self.reach - bulge / self.reach) / flat
        return math.pi / self.blades - math.acos(min(max(cosine, -1.0), 1.0))

    @property
    def _edge(self) -> tuple[float, float, float]:
        """(f, b, e): a point passes a blade if f s + b r² ≤ e, r from the axis and s along the blade's middle.

        The corners lie at 1. An arc of curvature κ with its middle at s = m: κ r² / 2 + (1 − κ m) s ≤ m − κ m² / 2.
        """
        half, middle = math.pi / self.blades, self._nearest
        height = middle - math.cos(half)
        kappa = 2.0 * height / (math.sin(half) ** 2 + height**2)
        return 1.0 - kappa * middle, 0.5 * kappa, middle - 0.5 * kappa * middle**2


@lru_cache(maxsize=256)
def _closed(iris: Iris, share: float) -> tuple[float, float]:
    """`Iris.closed` of blades."""
    area, whole = share * iris.area, replace(iris, reach=1.0).area
    if area <= whole:                           # the corners lie within the rim
        return math.sqrt(area / whole), 1.0
    widest = min(iris.reach, 1.0 / iris._nearest)
    return 1.0, find_root(lambda reach: replace(iris, reach=reach).area - area, 1.0, widest)


@lru_cache(maxsize=64)
def _chords(iris: Iris) -> np.ndarray:
    """The parameters of `map_to_iris`: chords whose triangles with the axis share the opening's area equally."""
    n = iris.blades * CELLS
    azimuth = iris.rotation + 0.5 * math.pi + 2.0 * math.pi * np.arange(64 * n + 1) / (64 * n)
    x, y = iris.radius(azimuth) * np.cos(azimuth), iris.radius(azimuth) * np.sin(azimuth)
    area = np.append(0.0, np.cumsum(x[:-1] * y[1:] - x[1:] * y[:-1]))
    areas = np.linspace(0.0, area[-1], n + 1)
    x, y = np.interp(areas, area, x), np.interp(areas, area, y)
    grow = math.sqrt(iris.area / (0.5 * (x[:-1] * y[1:] - x[1:] * y[:-1]).sum()))
    return np.array([n, (iris.rotation / (2.0 * math.pi) + 0.25) % 1.0, *(grow * x), *(grow * y)])
