"""Histogram of the tones of the developed picture."""

import numpy as np
from numpy.typing import NDArray

from lensbench.app.state import tone

BINS = 64
SAMPLED = 20_000            # pixels that are looked at: the shape needs no more, and a frame has no time for all


def histogram(image: NDArray[np.float32], exposure: float, curve: str, sensor: bool = False) -> NDArray[np.float64]:
    """Shares (4, BINS) of the pixels of a linear picture (h, w, 3): red, green, blue and luminance; see `tone.develop`.

    Each row is divided by its greatest inner bin, so that a clipped end does not flatten the rest; at most 1.
    """
    stride = max(1, int(np.sqrt(image.shape[0] * image.shape[1] / SAMPLED)))
    part = np.nan_to_num(image[stride // 2::stride, stride // 2::stride].reshape(-1, 3), nan=0.0, posinf=1e9)
    shown = tone.develop(part, exposure, curve, sensor)
    channels = [*shown.T, shown @ (0.2126, 0.7152, 0.0722)]
    counts = np.array([np.histogram(channel, BINS, (0.0, 1.0))[0] for channel in channels], np.float64)
    top = np.maximum(counts[:, 1:-1].max(), 1.0)
    return np.minimum(counts / top, 1.0)
