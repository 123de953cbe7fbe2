"""The stop's shape: a circle, or an iris of n blades, straight or rounded.

An iris stands for a circle about its corners, of the stop's radius: that circle is
what an f-number means, as for a stop that is round, and the blades lie within it. Of
the light of the circle an iris of n straight blades passes (n / 2π) sin(2π/n). Each
blade is an arc between two corners; its height over the chord is `roundness` of the
circle's own: 0 is the polygon, 1 the circle.

Camera and lens frame, x right and y up. The rotation is in radians, and turns the
iris counter-clockwise as seen from behind the camera; at 0 a corner points up.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lensbench.kernels.block import (
    A0,
    A1,
    A2,
    A3,
    A4,
    A5,
    CLEARANCE,
    U0,
    U1,
    WEIGHT,
    B,
    Step,
    X,
    Y,
    gather,
    rows,
    stage,
)

MOST_BLADES = 24
CELLS = 32              # chords of one blade, for the map from the square


class IrisError(ValueError):
    """A stop whose shape cannot be; the message says what to do."""


@dataclass(frozen=True)
class Iris:
    """The shape of a stop of radius 1, by its number of blades (0: a circle), rotation and roundness."""

    blades: int = 0
    rotation: float = 0.0
    roundness: float = 0.0

    def __post_init__(self):
        if not (math.isfinite(self.blades) and int(self.blades) == self.blades
                and (self.blades == 0 or 3 <= self.blades <= MOST_BLADES)):
            raise IrisError(f"{self.blades:g} blades: a stop has 3 to {MOST_BLADES} of them, or 0 for a circle")
        object.__setattr__(self, "blades", int(self.blades))
        if not math.isfinite(self.rotation):
            raise IrisError(f"blade rotation {self.rotation:g}: it must be a finite angle")
        if not 0.0 <= self.roundness <= 1.0:
            raise IrisError(f"blade roundness {self.roundness:g}: it must lie between 0 (straight) and 1 (a circle)")

    @property
    def is_round(self) -> bool:
        """Whether it is the circle."""
        return self.blades == 0 or self.roundness == 1.0

    @property
    def area(self) -> float:
        """Of the opening, π for the circle: the part of a round stop's light that passes is area / π."""
        return self.mean(lambda r: math.pi * r * r)

    def radius(self, azimuth) -> np.ndarray:
        """Distance of the edge from the axis along these azimuths (radians from +x towards +y)."""
        azimuth = np.asarray(azimuth, float)
        if self.is_round:
            return np.ones_like(azimuth)
        half = math.pi / self.blades
        off = (azimuth - self.rotation - 0.5 * math.pi) % (2.0 * half) - half
        flat, bulge, rim = self._edge
        b = flat * np.cos(off)
        return 2.0 * rim / (b + np.sqrt(b * b + 4.0 * bulge * rim))

    def mean(self, function: Callable[[np.ndarray], np.ndarray]) -> float:
        """The mean over all azimuths of a function of the edge's distance, by Gauss's rule along half a blade."""
        if self.is_round:
            return float(function(np.ones(1))[0])
        node, weight = np.polynomial.legendre.leggauss(24)
        corner = self.rotation + 0.5 * math.pi
        return float(0.5 * weight @ function(self.radius(corner + 0.5 * (node + 1.0) * math.pi / self.blades)))

    def outline(self, points: int = 24) -> np.ndarray:
        """(n, 2) points of the edge, counter-clockwise from a corner, `points` to a blade."""
        count = max(self.blades, 3) * points
        azimuth = self.rotation + 0.5 * math.pi + 2.0 * math.pi * np.arange(count) / count
        return self.radius(azimuth)[:, None] * np.column_stack([np.cos(azimuth), np.sin(azimuth)])

    def contains(self, x, y) -> np.ndarray:
        """Whether points x, y lie in the opening, the edge included."""
        return np.hypot(x, y) <= self.radius(np.arctan2(y, x)) * (1.0 + 1e-12)

    def axis_irradiance(self, radius: float, z: float) -> float:
        """∫ cos⁴θ dA in mm² over the opening of a stop of this radius, from the axis point at distance z (both mm)."""
        return self.mean(lambda r: math.pi * (r * radius * z) ** 2 / (z * z + (r * radius) ** 2))

    @property
    def steps(self) -> list[Step]:
        """The step that crowds the places U0, U1 of a round pupil into the opening, equal areas staying equal."""
        return [] if self.is_round else [Step(map_to_iris, _corners(self))]

    def blocking(self, radius: float) -> list[Step]:
        """The step that blocks, at a stop of this radius (mm), what the blades cover; none where it is round."""
        if self.is_round:
            return []
        flat, bulge, rim = self._edge
        towards = self.rotation + 0.5 * math.pi + (2.0 * np.arange(self.blades) + 1.0) * math.pi / self.blades
        ways = np.column_stack([np.cos(towards), np.sin(towards)]) * flat / (rim * radius)
        return [Step(block_by_blades, np.concatenate([[bulge / (rim * radius**2)], ways.ravel()]))]

    @property
    def _edge(self) -> tuple[float, float, float]:
        """(f, b, e): a point at the distance s along a blade's middle, r from the axis, is within it if f s + b r² ≤ e.

        The blade is an arc of curvature κ whose middle is at m: κ r² / 2 + (1 − κ m) s ≤ m − κ m² / 2.
        """
        half = math.pi / self.blades
        height = self.roundness * (1.0 - math.cos(half))
        kappa = 2.0 * height / (math.sin(half) ** 2 + height**2)
        middle = math.cos(half) + height
        return 1.0 - kappa * middle, 0.5 * kappa, middle - 0.5 * kappa * middle**2


@lru_cache(maxsize=64)
def _corners(iris: Iris) -> np.ndarray:
    """Parameters of `crowd`: how many chords, the turn of the first corner, then the chords' ends, x of all, y of all.

    The triangles under them have equal areas, and together the opening's own.
    """
    n = iris.blades * CELLS
    azimuth = iris.rotation + 0.5 * math.pi + 2.0 * math.pi * np.arange(64 * n + 1) / (64 * n)
    x, y = iris.radius(azimuth) * np.cos(azimuth), iris.radius(azimuth) * np.sin(azimuth)
    area = np.append(0.0, np.cumsum(x[:-1] * y[1:] - x[1:] * y[:-1]))
    wanted = np.linspace(0.0, area[-1], n + 1)
    x, y = np.interp(wanted, area, x), np.interp(wanted, area, y)
    grow = math.sqrt(iris.area / (0.5 * (x[:-1] * y[1:] - x[1:] * y[:-1]).sum()))
    return np.array([n, (iris.rotation / (2.0 * math.pi) + 0.25) % 1.0, *(grow * x), *(grow * y)])


@stage
def map_to_iris(lanes, p, key):
    """From places U0, U1 of a whole disk to those of the part of it that an iris leaves open.

    A place keeps its share of the area, both of the turn about the axis and of the way to the edge: the
    disk's concentric map then fills the opening evenly.  p: as `_corners` gives them.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    u, v = row[U0], row[U1]
    chord, along, ax, ay, bx, by = row[A0], row[A1], row[A2], row[A3], row[A4], row[A5]
    n, begin = p[0], p[1]
    count = np.int64(n)
    across, up = p[2:], p[3 + count:]
    last = n - real(0.5)
    for i in range(B):
        a, b = real(2) * v[i] - real(1), real(2) * u[i] - real(1)
        steep = abs(b) > abs(a)
        far, near = (b, a) if steep else (a, b)
        safe = far if far != real(0) else real(1)
        quarter = (real(0.25) if steep else real(0)) + (real(0.5) if far < real(0) else real(0))
        turn = quarter + real(0.125) * (-near / safe if steep else near / safe) - begin
        place = (turn - np.floor(turn)) * n
        place = place if place < last else last
        chord[i], along[i] = np.floor(place), place - np.floor(place)
    gather(ax, across, chord)
    gather(bx, across[1:], chord)
    gather(ay, up, chord)
    gather(by, up[1:], chord)
    for i in range(B):
        a, b = abs(real(2) * v[i] - real(1)), abs(real(2) * u[i] - real(1))
        reach = a if a > b else b
        f = along[i]
        x, y = (ax[i] + f * (bx[i] - ax[i])) * reach, (ay[i] + f * (by[i] - ay[i])) * reach
        # Back into the square: the turn within an octant by atan q = 2 atan(q / (1 + √(1 + q²)))
        steep = abs(y) > abs(x)
        far, near = (y, x) if steep else (x, y)
        q = near / (far if far != real(0) else real(1))
        q = q / (real(1) + math.sqrt(real(1) + q * q))
        s = q * q
        turn = q * (real(1) - s * (real(1 / 3) - s * (real(1 / 5) - s * (real(1 / 7) - s * (real(1 / 9) - s * (
            real(1 / 11) - s * (real(1 / 13) - s * (real(1 / 15) - s * real(1 / 17)))))))))
        out = math.sqrt(x * x + y * y)
        far = -out if far < real(0) else out
        near = turn * far * real(8 / math.pi)
        c, d = (near, far) if steep else (far, near)
        v[i], u[i] = real(0.5) + real(0.5) * c, real(0.5) + real(0.5) * d


@stage
def block_by_blades(lanes, p, key):
    """Block the rays that meet the blades, X, Y being on the stop: WEIGHT becomes 0, and CLEARANCE more than 1.

    p: what r² counts, then of each blade what x and y count; a blade is met where the sum exceeds 1.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, weight, margin, most = row[X], row[Y], row[WEIGHT], row[CLEARANCE], row[A0]
    for i in range(B):
        most[i] = real(-1e30)
    for s in range(1, p.size, 2):
        a, b = p[s], p[s + 1]
        for i in range(B):
            side = a * x[i] + b * y[i]
            most[i] = most[i] if most[i] >= side else side
    bulge = p[0]
    for i in range(B):
        out = most[i] + bulge * (x[i] * x[i] + y[i] * y[i])
        margin[i] = margin[i] if margin[i] >= out else out
        weight[i] = weight[i] if out <= real(1) else real(0)
