"""Statistics of pictures: the histogram of developed tones, and how far two linear pictures differ."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lensbench.app.state.picture import tone

BINS = 64
TONES_SAMPLED = 20_000          # pixels of a histogram: its shape needs no more, and a frame has no time for all
SHARE = 0.98                    # of the differences that lie below the end of their scale
DIFFERENCES_SAMPLED = 40_000    # pixels from which that scale is found


def histogram(image: NDArray[np.float32], exposure: float, curve: str, sensor: bool = False) -> NDArray[np.float64]:
    """Shares (4, BINS) of the pixels of a linear picture (h, w, 3): red, green, blue and luminance; see `tone.develop`.

    Each row is divided by its greatest inner bin, so that a clipped end does not flatten the rest; at most 1.
    """
    stride = max(1, int(np.sqrt(image.shape[0] * image.shape[1] / TONES_SAMPLED)))
    part = np.nan_to_num(image[stride // 2::stride, stride // 2::stride].reshape(-1, 3), nan=0.0, posinf=1e9)
    shown = tone.develop(part, exposure, curve, sensor)
    channels = [*shown.T, shown @ (0.2126, 0.7152, 0.0722)]
    counts = np.array([np.histogram(channel, BINS, (0.0, 1.0))[0] for channel in channels], np.float64)
    top = np.maximum(counts[:, 1:-1].max(), 1.0)
    return np.minimum(counts / top, 1.0)


@dataclass(frozen=True)
class Difference:
    """B − A over all pixels and channels: root mean square, greatest amount, and the amount to be shown as white."""

    rms: float
    largest: float
    scale: float

    @classmethod
    def of(cls, a: NDArray[np.float32], b: NDArray[np.float32]) -> "Difference":
        """Difference of two linear pictures (h, w, 3) of equal size; it is 0 where either is not finite."""
        apart = np.abs(np.nan_to_num(b.astype(np.float32) - a, nan=0.0, posinf=0.0, neginf=0.0))
        stride = max(1, int(math.sqrt(apart.shape[0] * apart.shape[1] / DIFFERENCES_SAMPLED)))
        most = float(np.quantile(apart[::stride, ::stride], SHARE))
        largest = float(apart.max())
        return cls(float(np.sqrt(np.mean(np.square(apart, dtype=np.float64)))), largest,
                   round_above(most or largest or 1.0))


def decibels(a: NDArray[np.float32], b: NDArray[np.float32]) -> float:
    """Peak signal to noise of two linear pictures of one size, clipped to [0, 1], peak 1; infinite where alike."""
    error = float(np.mean(np.square(np.clip(a, 0.0, 1.0) - np.clip(b, 0.0, 1.0), dtype=np.float64)))
    return -10.0 * math.log10(error) if error else math.inf


def round_above(value: float) -> float:
    """The least of 1, 2, 5 · 10ⁿ that is not below a positive value."""
    decade = 10.0 ** math.floor(math.log10(value))
    return next(step * decade for step in (1.0, 2.0, 5.0, 10.0) if step * decade >= value * (1.0 - 1e-12))
