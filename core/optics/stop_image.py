"""Picture in the stop: a filter whose transmission gives the stop its shape, instead of blades.

The picture lies in the plane of the stop, centred on the axis; its longer side is the diameter of the stop, whose
circle cuts its corners. Camera and lens frame, x right and y up, the top row at +y, the left side at −x: lights behind
the plane in focus show it upright, lights before it upside down (the other way round if the exit pupil is inverted).
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.kernels.block import A0, A1, CLEARANCE, U0, U1, WEIGHT, B, Step, X, Y, gather, rows, stage
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.sampling import concentric_disk

MOST = 256              # texels on a side; a larger picture is averaged down to it
RINGS, SPOKES = 512, 2048       # of equal areas, by which transmission is averaged over the disk

# Parameters of both stages: 1 / radius of the stop (1/mm), texels on a side, then the texels
PER_MM, SIDE, TEXELS = range(3)


class StopImageError(ValueError):
    """An impossible picture in a stop; the message says what to do."""


@dataclass(frozen=True)
class StopImage:
    """Transmission over the square about a stop of radius 1; see `StopImage.of`.

    Args:
        side: Texels on a side.
        texels: side² float32 numbers from 0 (opaque) to 1, row by row from the top left.
        file, name: Where it was read from, "" for nowhere: the path of its file, and that as a lens file names it. They
            do not count in comparisons.
    """

    side: int
    texels: bytes
    file: str = field(default="", compare=False, repr=False)
    name: str = field(default="", compare=False, repr=False)

    @classmethod
    def of(cls, transmission: ArrayLike) -> "StopImage":
        """A picture in the stop from its transmission (h, w), 0 to 1, the top row first, averaged down to MOST texels
        on a side.

        StopImageError for fewer than 2 × 2 pixels, numbers outside [0, 1], and a picture that passes no light in the
        circle.
        """
        picture = np.asarray(transmission, float)
        if picture.ndim != 2 or min(picture.shape) < 2:
            raise StopImageError(f"a stop's picture of the shape {picture.shape}: it needs rows and columns, at least "
                                 "2 of each")
        if not (np.isfinite(picture).all() and picture.min() >= 0.0 and picture.max() <= 1.0):
            raise StopImageError("a stop's picture holds the part of the light that passes: numbers from 0 to 1")
        longest = max(picture.shape)
        side = min(MOST, longest)
        for _ in range(2):                              # down the rows, then across the columns
            picture = _averaged(picture, longest, side).T
        made = cls(side, np.ascontiguousarray(np.clip(picture, 0.0, 1.0), np.float32).tobytes())
        if not made.ring_means.any():
            raise StopImageError("the stop's picture passes no light: white is open, black is opaque")
        return made

    @cached_property
    def grid(self) -> np.ndarray:
        """Transmission (side, side), the top row first; float32, read-only."""
        return np.frombuffer(self.texels, np.float32).reshape(self.side, self.side)

    @cached_property
    def ring_means(self) -> np.ndarray:
        """Mean transmission (RINGS,) of rings of equal areas, from the axis outwards."""
        radius = np.sqrt((np.arange(RINGS) + 0.5) / RINGS)[:, None]
        azimuth = 2.0 * np.pi * (np.arange(SPOKES) + 0.5) / SPOKES
        return np.asarray(self.at(radius * np.cos(azimuth), radius * np.sin(azimuth)).mean(1))

    def at(self, x: ArrayLike, y: ArrayLike) -> np.ndarray:
        """Transmission, from 0 to 1, at points x, y of the stop, x right and y up as seen from behind the camera.

        In units of the stop's radius, broadcast; 0 beyond its circle.
        """
        x, y = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float))
        half = 0.5 * self.side
        with np.errstate(invalid="ignore"):
            column, line = ((half + half * coordinate).clip(0, self.side - 1) for coordinate in (x, -y))
            within = x * x + y * y <= 1.0 + 1e-12
        values = self.grid[np.nan_to_num(line).astype(int), np.nan_to_num(column).astype(int)].astype(float)
        return np.where(within, values, 0.0)

    @cached_property
    def upside_down(self) -> "StopImage":
        """The picture turned by half a turn."""
        return StopImage(self.side, np.ascontiguousarray(self.grid[::-1, ::-1]).tobytes())

    @cached_property
    def from_behind(self) -> "StopImage":
        """The picture as it is met from behind: mirrored along x."""
        return StopImage(self.side, np.ascontiguousarray(self.grid[:, ::-1]).tobytes())

    def step(self, radius: float) -> Step:
        """Step that multiplies WEIGHT by the transmission at the point X, Y of a stop of this radius (mm)."""
        return Step(pass_stop_image, self._numbers(1.0 / radius))

    @property
    def sample_step(self) -> Step:
        """Step that multiplies WEIGHT by the transmission where the pupil sample U0, U1 lies in the disk."""
        return Step(pass_stop_image_at_sample, self._numbers(1.0))

    def _numbers(self, per_mm: float) -> np.ndarray:
        return np.concatenate([[per_mm, self.side], self.grid.ravel()])


def _averaged(picture: np.ndarray, longest: int, side: int) -> np.ndarray:
    """Rows (h, w) averaged into `side` rows of the square of side `longest` about their middle; 0 beyond them."""
    edges = np.linspace(0.0, longest, side + 1) - 0.5 * (longest - len(picture))
    edges = np.clip(edges, 0.0, len(picture))
    row = np.minimum(edges.astype(int), len(picture) - 1)
    sums = np.concatenate([np.zeros((1, picture.shape[1])), np.cumsum(picture, 0)])
    below = sums[row] + (edges - row)[:, None] * picture[row]
    return np.asarray(np.diff(below, axis=0) * (side / longest))


@njit(inline="always")
def _texel(real, x, y, side):
    """Index of the texel at a point of the disk; some texel for a lost ray, whose place is NaN."""
    half, last = real(0.5) * side, side - real(1)
    column, line = np.floor(half + half * x), np.floor(half - half * y)
    column, line = column if column < last else last, line if line < last else last
    column, line = column if column > real(0) else real(0), line if line > real(0) else real(0)
    return line * side + column


@stage
def pass_stop_image(lanes, p, ints, key):
    """Rays at the stop: WEIGHT times the transmission; CLEARANCE is greater than 1 where it is 0. p: PER_MM …."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, weight, clearance, texel, passed = row[X], row[Y], row[WEIGHT], row[CLEARANCE], row[A0], row[A1]
    per_mm, side = p[PER_MM], p[SIDE]
    for i in range(B):
        texel[i] = _texel(real, x[i] * per_mm, y[i] * per_mm, side)
    gather(passed, p[TEXELS:], texel)
    for i in range(B):
        weight[i] *= passed[i]
        clearance[i] = clearance[i] if (passed[i] > real(0)) | (clearance[i] >= real(2)) else real(2)


@stage
def pass_stop_image_at_sample(lanes, p, ints, key):
    """WEIGHT times the transmission at the point of the unit disk with the pupil sample U0, U1. p: PER_MM …."""
    real = lanes.dtype.type
    row = rows(lanes)
    u, v, weight, texel, passed = row[U0], row[U1], row[WEIGHT], row[A0], row[A1]
    side = p[SIDE]
    for i in range(B):
        x, y = concentric_disk(real, v[i], u[i])
        texel[i] = _texel(real, x, y, side)
    gather(passed, p[TEXELS:], texel)
    for i in range(B):
        weight[i] *= passed[i]
