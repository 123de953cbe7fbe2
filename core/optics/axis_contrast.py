"""Contrast of fine lines on the axis, from traced rays, and the film on which it is best.

Lengths in mm, frequencies in cycles/mm. The contrast is the geometrical MTF of the open pupil, the mean of lines up and
across, in all wavelengths of a light together. Of diffraction it counts that a ray needs a partner on either side, half
the angle λ × frequency away, within the pupil (of rotational symmetry).
"""

from functools import lru_cache
from math import ceil, inf, pi

import numpy as np

from lensbench.core.kernels.cache import njit
from lensbench.core.optics.axial_bundle import pupil_rays
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.prescription import Lens

FREQUENCY = 30.0                # cycles/mm, at which a lens is focused for the best contrast
AZIMUTHS = 8                    # in a quadrant, of a rotationally symmetric bundle: J0 to an argument of 28
STEP, MOST = 0.15, 301          # of the scan, in blurs of one line pair; films
REACH = 3.0                     # of the scan: rms blurs at the least blur, in depths of it, and line pairs
Light = tuple[tuple[float, float], ...]         # µm and weights
D_LIGHT: Light = ((D_LINE, 1.0),)


def axis_contrast(lens: Lens, film_distances: np.ndarray, object_distance: float = inf, light: Light = D_LIGHT,
                  frequency: float = FREQUENCY) -> np.ndarray:
    """Contrast of the image of an axis point on films.

    Args:
        lens: The lens, its focus groups as they are, with the stop as it is.
        film_distances: (K,) last vertex → film, at even steps; one or two films are always so.
        object_distance: Axis point → first vertex.
        light: Wavelengths in µm and weights.
        frequency: Cycles/mm.
    Returns:
        (K,) contrasts from 0 to 1; 0 beyond the limit of diffraction and, of a symmetric bundle, where dark and light
        lines change places; NaN where no ray passes.
    """
    points, slopes, weights = _bundle(lens, light, object_distance, frequency)
    if not weights.size:
        return np.full(len(film_distances), np.nan)
    step = film_distances[1] - film_distances[0] if len(film_distances) > 1 else 0.0
    turns = 2.0 * pi * frequency
    out = np.zeros(len(film_distances))
    axes = 1 if lens.is_rotationally_symmetric else 2
    _add_modulus(turns * points[:, :axes], turns * slopes[:, :axes], weights, lens.is_mirror_symmetric,
                 film_distances[0], step, out)
    return out / axes


def best_contrast(lens: Lens, around: float, object_distance: float = inf, light: Light = D_LIGHT,
                  frequency: float = FREQUENCY) -> float:
    """Last vertex → film on which the contrast of an axis point is best.

    Args:
        lens, object_distance, light, frequency: As for `axis_contrast`.
        around: Last vertex → film of the least blur.
    Returns:
        The film distance; NaN where no ray passes, or for lines beyond the limit of diffraction.
    """
    points, slopes, weights = _bundle(lens, light, object_distance, frequency)
    spread = weights @ (slopes**2).sum(1) / max(weights.sum(), 1e-300)
    if not spread > 0.0:
        return np.nan
    heights = points + around * slopes
    heights = heights - (0.0 if lens.is_mirror_symmetric else weights @ heights / weights.sum())
    pair = 1.0 / (frequency * np.sqrt(8.0 * spread))            # the blur 2√2 rms is a line pair
    reach = REACH * (np.sqrt(weights @ (heights**2).sum(1) / weights.sum() / spread) + pair)
    count = min(2 * ceil(reach / (STEP * pair)) + 1, MOST)
    films = around + np.linspace(-reach, reach, count)
    contrasts = axis_contrast(lens, films, object_distance, light, frequency)
    peak = min(max(int(contrasts.argmax()), 1), count - 2)
    before, top, after = contrasts[peak - 1:peak + 2]
    bend = before - 2.0 * top + after
    shift = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    return float(films[peak] + min(max(shift, -1.0), 1.0) * (films[1] - films[0]))


@lru_cache(maxsize=8)
def _bundle(lens: Lens, light: Light, object_distance: float, frequency: float
            ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points and slopes (n, 2) on the plane of the last vertex, and weights (n,); n = 0 where no ray passes."""
    total = sum(weight for _, weight in light)
    parts = [pupil_rays(lens, np.array([1.0 / object_distance]), line) for line, _ in light]
    points, slopes = (np.concatenate([part[quantity][0] for part in parts]) for quantity in (0, 1))
    weights = np.concatenate([part[2][0] * weight / total for part, (_, weight) in zip(parts, light, strict=True)])
    halves = np.repeat([0.5e-3 * line * frequency for line, _ in light], [part[2].size for part in parts])
    rim = np.nanmax(np.abs(slopes), initial=0.0)        # of the pupil's edge, whose rays weigh nothing
    passed = (weights > 0.0) & np.isfinite(points).all(1) & np.isfinite(slopes).all(1)
    points, slopes, weights, halves = points[passed], slopes[passed], weights[passed], halves[passed]
    if lens.is_rotationally_symmetric:                  # rays of one meridian, the second coordinate
        azimuth = 0.5 * pi * (np.arange(AZIMUTHS) + 0.5) / AZIMUTHS
        ways = np.stack([np.cos(azimuth), np.sin(azimuth)], 1)
        points, slopes = ((values[:, None, 1:] * ways).reshape(-1, 2) for values in (points, slopes))
        weights = np.repeat(weights / AZIMUTHS, AZIMUTHS)
        aside = np.abs(slopes[:, 0]) + np.repeat(halves, AZIMUTHS)
        weights = weights * (np.hypot(aside, slopes[:, 1]) <= rim)
    return points, slopes, weights


@njit(cache=True, nogil=True, error_model="numpy")
def _add_modulus(points, slopes, weights, is_symmetric, first, step, out):
    """Sums (K,) of |Σ weights · exp i (points + film · slopes)| over the coordinates, for films at even steps.

    points, slopes: (n, 1 or 2), times 2π × frequency. A symmetric bundle is known by one quadrant: the sum
    is real, and counts as 0 where it is negative: there dark and light lines change places.
    """
    cosines, sines = np.empty(out.size), np.empty(out.size)
    for axis in range(points.shape[1]):
        cosines[:] = 0.0
        sines[:] = 0.0
        for i in range(weights.size):
            angle, turn = points[i, axis] + first * slopes[i, axis], step * slopes[i, axis]
            c, s, dc, ds = np.cos(angle), np.sin(angle), np.cos(turn), np.sin(turn)
            for k in range(out.size):
                cosines[k] += weights[i] * c
                sines[k] += weights[i] * s
                c, s = c * dc - s * ds, s * dc + c * ds
        for k in range(out.size):
            out[k] += max(cosines[k], 0.0) if is_symmetric else np.hypot(cosines[k], sines[k])
