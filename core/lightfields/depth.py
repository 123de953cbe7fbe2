"""Depth from a light field, and the picture in which everything is in focus.

The view at the point a of the pupil sees a point at the distance d shifted by σ(d) a from where the pupil's middle sees
it. For each of many σ the variance of the views, shifted back by σ a, is summed over a window about each pixel; the
least of the sums, interpolated by a parabola, gives the depth, and how far it lies below the others the confidence. The
picture in focus everywhere is the sum of the views with the σ of each pixel's own depth.

References:
    Bolles, Baker and Marimont, "Epipolar-plane image analysis", 1987: slopes. Okutomi and Kanade, "A multiple-baseline
    stereo", 1993: the sum over views.
"""

import math
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from lensbench.core.kernels.cache import njit
from lensbench.core.lightfields.light_field import LightField, LightFieldError
from lensbench.core.text import significant

STEP = 0.5              # pixels by which the shift of the outermost view changes from one σ to the next
WINDOW = 3              # pixels to either side over which the variance is summed
NOISE = 1e-4            # variance of grey below which there is no confidence
MOST_VIEWS = 9          # across and down that are compared; of more, some are left out
TABLE = 129             # distances for which σ is computed; between them it is interpolated
LEAST_APART = 2.0       # pixels between neighbouring views at the nearest distance, at least
SHIFT_ERROR = 0.3       # pixels, of the outermost views' shift: half to four fifths of the sure ones keep it
LIT = 0.3               # of the greatest coverage, below which a view of a pixel is left out


@dataclass(frozen=True, eq=False)
class Depth:
    """Depth of a light field, from `find_depth`; pixels as seen from the middle of the pupil, the top row first.

    Args:
        distance: float32 (h, w) mm, measured as the camera measures its focus distance.
        confidence: float32 (h, w): 0 where any distance fits, to 1 where no other does.
        error: float32 (h, w) mm: what half to four fifths of the sure pixels are off by at the most. It grows with the
            square of the distance and falls with the baseline, the width of the pupil.
        picture: float32 (h, w, 3), linear RGB, in focus everywhere.
    """

    distance: np.ndarray
    confidence: np.ndarray
    error: np.ndarray
    picture: np.ndarray


def find_depth(field: LightField, nearest: float | None = None, farthest: float = math.inf,
               progress: Callable[[float], bool] = lambda share: True) -> Depth:
    """The depth of a light field between two distances (Okutomi and Kanade 1993).

    Args:
        field: A light field of at least 3 × 3 views.
        nearest: Nearest distance, mm, measured as the camera measures its focus; None: where neighbouring views are as
            far apart as at `farthest`, and at least two pixels.
        farthest: Farthest distance, mm; may be math.inf.
        progress: Called with the share done, 0 to 1; return False to cancel.
    Raises:
        LightFieldError: For a single view, invalid distances, and when `progress` cancels.
    """
    if min(field.views) < 2 and max(field.views) < 3:
        raise LightFieldError("a single view has no depth: record a light field of at least 3 × 3")
    if nearest is not None and not nearest > 0.0:
        raise LightFieldError(f"nearest depth {significant(nearest / 1000.0)} m: it must be positive")
    near = max(_nearest(field, farthest) if nearest is None else nearest, field.nearest)
    if not 0.0 < near < farthest:
        raise LightFieldError(f"depth between {significant(near / 1000.0)} and {significant(farthest / 1000.0)} m: the "
                              f"first must be nearer")
    per_distance, shears = _table(field, near, farthest)
    farthest_view = float(np.abs(field.shifts(1.0) - field.shifts(0.0)).max())
    count = max(math.ceil((shears[-1] - shears[0]) * farthest_view / STEP) + 1, 3)
    sigma = np.linspace(shears[0], shears[-1], count)

    def report(share: float) -> None:
        if not progress(share):
            raise LightFieldError("the search for depth was cancelled")

    # Sum the variance of the views over the window, for every σ
    views = _ShiftedViews(field)
    costs = np.empty((count, *field.light.shape[3:]), np.float32)
    for k in range(count):
        costs[k] = views.variance(sigma[k])
        report(0.6 * (k + 1) / count)
    position, confidence = _best(costs)

    # Blend the pictures at the two σ next to each pixel's own
    picture = np.zeros((*position.shape, 3), np.float32)
    for k in range(count):
        share = np.maximum(1.0 - np.abs(position - k), 0.0)
        if share.any():
            picture += share[..., None] * views.radiance(sigma[k])
        report(0.6 + 0.4 * (k + 1) / count)
    shear = sigma[0] + position * (sigma[1] - sigma[0])
    nearness = np.interp(shear, shears, per_distance)
    slope = np.abs(np.interp(shear, shears, np.gradient(per_distance, shears)))
    with np.errstate(divide="ignore", invalid="ignore"):
        error = np.where(nearness > 0.0, slope * SHIFT_ERROR / farthest_view / nearness**2, math.inf)
        return Depth((1.0 / nearness).astype(np.float32), confidence, error.astype(np.float32), picture)


def _table(field: LightField, near: float, far: float) -> tuple[np.ndarray, np.ndarray]:
    """1 / distance (1/mm) between two distances, and σ, which increases."""
    per_distance = np.linspace(1.0 / near, 1.0 / far, TABLE)
    shears = np.array([field.shear(1.0 / t if t else math.inf)[1] for t in per_distance])
    return (per_distance, shears) if shears[-1] > shears[0] else (per_distance[::-1], shears[::-1])


def _nearest(field: LightField, farthest: float) -> float:
    """Distance (mm) at which neighbouring views are as far apart as at the farthest one, at least LEAST_APART."""
    most = max(field.apart(farthest), LEAST_APART)
    inner, outer = 1.0 / min(field.camera.focus_distance, farthest), 1.0 / field.nearest     # type: ignore[attr-defined]
    for _ in range(60):
        middle = 0.5 * (inner + outer)
        inner, outer = (middle, outer) if field.apart(1.0 / middle) <= most else (inner, middle)
    return 1.0 / inner


class _ShiftedViews:
    """Views to be read at shifts: grey from 0 to 1, and its weight."""

    def __init__(self, field: LightField):
        self._field = field
        across, down = field.views
        self._rows, self._columns = (np.arange(0, n, -(-n // MOST_VIEWS)) for n in (down, across))
        chosen = np.ix_(self._rows, self._columns)
        h, w = field.light.shape[3:]
        self._weight = field.coverage[chosen].astype(np.float32).reshape(-1, h, w)
        self._grey = np.zeros_like(self._weight)
        for q, (j, i) in enumerate((j, i) for j in self._rows for i in self._columns):
            grey = field.light[j, i].astype(np.float32).mean(0)
            self._grey[q] = grey / np.maximum(grey + self._weight[q], 1e-6)         # x / (1 + x) compresses lights
        self._weight[self._weight < LIT * self._weight.max()] = 0.0
        self._whole = np.maximum(field.coverage.sum((0, 1), dtype=np.float32), 1e-6)
        self._threads = os.cpu_count() or 1

    def variance(self, shear: float) -> np.ndarray:
        """(h, w) variance of the views shifted by this σ, averaged over the window."""
        shifts = self._field.shifts(shear)[np.ix_(self._rows, self._columns)].reshape(-1, 2)
        h, w = self._grey.shape[1:]
        variance = np.empty((h, w), np.float32)
        lines = np.linspace(0, h, self._threads + 1).astype(int)
        with ThreadPoolExecutor(self._threads) as pool:
            list(pool.map(lambda k: _variance(self._grey, self._weight, shifts, variance, lines[k], lines[k + 1]),
                          range(self._threads)))
        return _window_mean(variance)

    def radiance(self, shear: float) -> np.ndarray:
        """(h, w, 3) mean radiance of all views shifted by this σ."""
        return self._field.stacked(shear) / self._whole[..., None]


@njit(nogil=True, cache=True, error_model="numpy", fastmath={"contract", "nsz"})
def _variance(grey, weight, shifts, out, first, last):
    """Set rows first … last − 1 to the weighted variance over views (n, h, w) read at shifts (n, 2), pixels."""
    n, h, w = grey.shape
    greys, heavy = np.zeros(w, np.float32), np.zeros(w, np.float32)
    total, linear, square = np.zeros(w, np.float32), np.zeros(w, np.float32), np.zeros(w, np.float32)
    for y in range(first, last):
        # Sum the weights, and the weighted grey and its square, over the views
        total[:], linear[:], square[:] = 0.0, 0.0, 0.0
        for q in range(n):
            top, left = math.floor(y + shifts[q, 1]), math.floor(shifts[q, 0])
            if top < 0 or top + 1 >= h:
                continue
            b, f = np.float32(y + shifts[q, 1] - top), np.float32(shifts[q, 0] - left)
            for i in range(w):
                greys[i] = grey[q, top, i] + b * (grey[q, top + 1, i] - grey[q, top, i])
                heavy[i] = min(weight[q, top, i], weight[q, top + 1, i])
            low, high = max(-left, 0), min(w - 1 - left, w)
            left_greys, right_greys = greys[low + left:high + left], greys[low + left + 1:high + left + 1]
            near, next_ = heavy[low + left:high + left], heavy[low + left + 1:high + left + 1]
            t, s, v = total[low:high], linear[low:high], square[low:high]
            for i in range(t.size):
                x, m = left_greys[i] + f * (right_greys[i] - left_greys[i]), min(near[i], next_[i])
                t[i] += m
                s[i] += m * x
                v[i] += m * x * x

        # Their variance
        for i in range(w):
            mean = linear[i] / max(total[i], np.float32(1e-6))
            spread = square[i] / max(total[i], np.float32(1e-6)) - mean * mean
            out[y, i] = max(spread, np.float32(0.0))


def _window_mean(picture: np.ndarray) -> np.ndarray:
    """(h, w) mean over the window about each pixel; the last pixel repeats beyond the edge."""
    size = 2 * WINDOW + 1
    for axis in (0, 1):
        padded = np.pad(picture, [(WINDOW + 1, WINDOW) if a == axis else (0, 0) for a in (0, 1)], mode="edge")
        sums = np.cumsum(padded, axis, dtype=np.float64)
        picture = ((sums[size:] - sums[:-size] if axis == 0 else sums[:, size:] - sums[:, :-size]) / size)
    return picture.astype(np.float32)


def _best(costs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fractional index (h, w) of the least cost along the first axis, by a parabola, and the confidence (h, w)."""
    best = np.clip(costs.argmin(0), 1, len(costs) - 2)
    before, least, after = (np.take_along_axis(costs, (best + k)[None], 0)[0] for k in (-1, 0, 1))
    curvature = before - 2.0 * least + after
    off = np.clip(0.5 * (before - after) / np.maximum(curvature, 1e-12), -1.0, 1.0)
    return best + off, np.clip(1.0 - (least + NOISE) / (costs.mean(0) + NOISE), 0.0, 1.0).astype(np.float32)
