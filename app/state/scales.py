"""An engraved scale of a dial: position of a value, engraved figures, and the text of a value.

A scale maps its values to u from 0 (left) to 1 (right). `dial_scales` makes the scale of each dial.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

FIGURE_GAP = 0.08                                # of u: least distance of two figures
Figure = tuple[float, str]


@dataclass(frozen=True)
class Scale:
    """One engraved scale from `low` (u = 0) to `high` (u = 1; infinity is allowed, and a value below `low`).

    warp makes the scale: u is linear in warp(value), and unwarp is its inverse.
    figures: values with their text; figure number `anchor` is engraved on the shortest dial too. minor: values of
    the short ticks. snaps: values that click and wheel go to; empty for a continuous scale. reset: value that a
    double click restores. amber: drawn in amber, for focus.
    """

    low: float
    high: float
    warp: Callable[[float], float]
    unwarp: Callable[[float], float]
    format: Callable[[float], str]
    read: Callable[[str], float]
    figures: tuple[Figure, ...]
    minor: tuple[float, ...] = ()
    snaps: tuple[float, ...] = ()
    reset: float | None = None
    anchor: int = 0
    amber: bool = False

    def to_unit(self, value: float) -> float:
        """Position of a value, from 0 to 1; a value beyond an end has the position of that end."""
        if math.isnan(value):
            return 0.0
        low, high = self.warp(self.low), self.warp(self.high)
        if high == low:
            return 0.0
        return min(max((self.warp(self._clamped(value)) - low) / (high - low), 0.0), 1.0)

    def _clamped(self, value: float) -> float:
        return min(max(value, min(self.low, self.high)), max(self.low, self.high))

    def from_unit(self, u: float) -> float:
        """Value at u, exact at both ends."""
        if u <= 0.0:
            return self.low
        if u >= 1.0:
            return self.high
        low, high = self.warp(self.low), self.warp(self.high)
        return self._clamped(self.unwarp(low + u * (high - low)))

    def snapped(self, value: float) -> float:
        """Nearest snap along the dial, or the value itself on a continuous scale."""
        u = self.to_unit(value)
        return min(self.snaps, key=lambda snap: abs(self.to_unit(snap) - u), default=value)

    def stepped(self, value: float, steps: int) -> float:
        """Value this many snaps to the right; on a continuous scale, this many hundredths of the dial."""
        if not self.snaps:
            return self.from_unit(self.to_unit(value) + 0.01 * steps)
        u, ladder = self.to_unit(value), sorted(self.to_unit(snap) for snap in self.snaps)
        beyond = [v for v in ladder if v > u + 1e-6] if steps > 0 else [v for v in reversed(ladder) if v < u - 1e-6]
        if not beyond:
            return value
        target = beyond[min(abs(steps), len(beyond)) - 1]
        return min(self.snaps, key=lambda snap: abs(self.to_unit(snap) - target))

    def parse(self, text: str) -> float:
        """Value of a typed text; the message of a ValueError says what to type, or gives the range."""
        value = self.read(text)
        # A typed end may be the rounded figure of the dial's own end
        for end in (self.low, self.high):
            if self.format(value) == self.format(end):
                return end
        if self._clamped(value) != value:
            raise ValueError(f"{self.format(value)} is out of reach: "
                             f"{self.format(self.low)} to {self.format(self.high)}")
        return value


def spaced(figures: list[Figure], to_unit: Callable[[float], float]) -> tuple[Figure, ...]:
    """The figures, from the right, that lie at least FIGURE_GAP from the previous one."""
    kept: list[Figure] = []
    for value, text in sorted(figures, reverse=True):
        if not kept or to_unit(kept[-1][0]) - to_unit(value) >= FIGURE_GAP:
            kept.append((value, text))
    return tuple(reversed(kept))


def decades(low: float, high: float, series: tuple[float, ...]) -> list[float]:
    """The series times every power of ten, from low to high, as a list."""
    first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
    values = (m * 10.0**e for e in range(first, last + 1) for m in series)
    return [float(f"{v:.6g}") for v in values if low * (1 - 1e-6) <= v <= high * (1 + 1e-6)]


def figures_that_fit(scale: Scale, width: float, widths: tuple[float, ...], gap: float) -> tuple[Figure, ...]:
    """Figures at the smallest stride at which none touch on a dial of this width; `widths` are those of the texts.

    The stride counts from the anchor, which is always kept.
    """
    positions = [scale.to_unit(value) * width for value, _ in scale.figures]
    for stride in range(1, len(positions) + 1):
        chosen = range(scale.anchor % stride, len(positions), stride) if positions else range(0)
        touching = any(positions[b] - positions[a] < 0.5 * (widths[a] + widths[b]) + gap
                       for a, b in zip(chosen, chosen[1:], strict=False))
        if not touching:
            return tuple(scale.figures[i] for i in chosen)
    return ()
