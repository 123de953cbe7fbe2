"""Curves in pixels: their heights between two columns, so that labels avoid them, and fewer points to draw."""

import numpy as np
from numpy.typing import NDArray

TOLERANCE = 0.05        # pixels that a point may lie off the line between its neighbours
ROUNDS = 5


class Paths:
    """Curves that rise to the right in one common set of columns.

    pixels: (k, n, 2), x and y of the n points of k curves; all curves have the same x, which never decreases.
    """

    def __init__(self, pixels: NDArray[np.float64]):
        self.pixels = pixels
        self._columns, self._rows = pixels[0, :, 0], pixels[..., 1]

    def heights(self, left: float, right: float) -> list[tuple[float, float]]:
        """The least and the greatest y of each curve between two columns, its ends continued."""
        i, j = np.searchsorted(self._columns, (left, right), "right").tolist()
        parts = np.concatenate([self._at(left, i), self._at(right, j), self._rows[:, i:j]], axis=1)
        return list(zip(parts.min(axis=1).tolist(), parts.max(axis=1).tolist(), strict=True))

    def _at(self, column: float, i: int) -> NDArray[np.float64]:
        """Heights (k, 1) of the curves in a column that lies before point i."""
        rows, columns = self._rows, self._columns
        if i == 0 or i == len(columns):
            return rows[:, :1] if i == 0 else rows[:, -1:]
        t = (column - columns[i - 1]) / (columns[i] - columns[i - 1])
        return (1.0 - t) * rows[:, i - 1:i] + t * rows[:, i:i + 1]


def crosses(crossing: list[tuple[float, float]], top: float, bottom: float) -> bool:
    """Whether one of these stretches of curves (least and greatest y) enters the rows between top and bottom."""
    return any(low < bottom and high > top for low, high in crossing)


def simplified(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The curve (n, 2) without points that lie on the line between their neighbours; gaps of NaN stay.

    A round can drop every second point, so that the drawn curve is at most ROUNDS × TOLERANCE pixels away.
    """
    for _ in range(ROUNDS):
        if len(points) < 5:
            return points
        before, at, after = points[0:-2:2], points[1:-1:2], points[2::2]
        chord, part = after - before, at - before
        off = np.abs(chord[:, 0] * part[:, 1] - chord[:, 1] * part[:, 0])
        needless = off <= TOLERANCE * np.hypot(chord[:, 0], chord[:, 1])
        keep = np.ones(len(points), bool)
        keep[1:-1:2] = ~needless
        if keep.all():
            return points
        points = points[keep]
    return points
