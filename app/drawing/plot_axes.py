"""Parts that plots share: the map from plot coordinates to pixels, curves with dashes, ticks of axes."""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, floor, log10

import numpy as np
from imgui_bundle import ImVec2, imgui, implot
from numpy.typing import NDArray

from lensbench.app.drawing import theme
from lensbench.core.text import RAISED, significant, true_minus

TOLERANCE = 0.05        # pixels that a point may lie off the line between its neighbours
ROUNDS = 5


def simplified(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The curve (n, 2) without points that lie on the line between their neighbours; gaps of NaN stay.

    A round can drop every second point, so that the drawn curve is at most ROUNDS × TOLERANCE pixels away.
    """
    for _ in range(ROUNDS):
        if len(points) < 5:
            return points
        before, middle, after = points[0:-2:2], points[1:-1:2], points[2::2]
        chord, arm = after - before, middle - before
        off = np.abs(chord[:, 0] * arm[:, 1] - chord[:, 1] * arm[:, 0])
        needless = off <= TOLERANCE * np.hypot(chord[:, 0], chord[:, 1])
        keep = np.ones(len(points), bool)
        keep[1:-1:2] = ~needless
        if keep.all():
            return points
        points = points[keep]
    return points


PLOT_FLAGS = (implot.Flags_.no_title | implot.Flags_.no_legend | implot.Flags_.no_menus | implot.Flags_.no_box_select
              | implot.Flags_.no_mouse_text)
AXIS_FLAGS = implot.AxisFlags_.no_menus | implot.AxisFlags_.no_side_switch | implot.AxisFlags_.no_highlight
FAR = 1e5                       # pixels, to which points far outside are clipped
TINY = 1e-300                   # on a logarithmic axis, instead of what has no logarithm


@dataclass(frozen=True)
class PlotMap:
    """The plot being drawn: its corners in pixels and in plot coordinates (their logarithms on logarithmic axes).

    log: of both axes, or of the horizontal one alone where log_y is given.
    """

    left: float
    top: float
    right: float
    bottom: float
    x0: float
    x1: float
    y0: float
    y1: float
    log: bool
    log_y: bool | None = None

    @classmethod
    def current(cls, log: bool, log_y: bool | None = None, falling: bool = False) -> "PlotMap":
        """The plot between begin_plot and end_plot; falling: its horizontal axis is inverted."""
        limits, corner, size = implot.get_plot_limits(), implot.get_plot_pos(), implot.get_plot_size()
        ends = np.array([limits.x.min, limits.x.max, limits.y.min, limits.y.max])
        for interval, is_log in ((ends[:2], log), (ends[2:], log if log_y is None else log_y)):
            if is_log:
                interval[:] = np.log10(np.maximum(interval, TINY))
        x0, x1, y0, y1 = (float(v) for v in ends)
        if falling:
            x0, x1 = x1, x0
        return cls(corner.x, corner.y, corner.x + size.x, corner.y + size.y, x0, x1, y0, y1, log, log_y)

    def pixels(self, x, y) -> np.ndarray:
        """Arrays (n,) of plot coordinates to (n, 2) pixels."""
        x, y = np.asarray(x, float), np.asarray(y, float)
        if x.shape != y.shape:
            x, y = np.broadcast_arrays(x, y)
        if self.log:
            x = np.log10(np.maximum(x, TINY))
        if self.log if self.log_y is None else self.log_y:
            y = np.log10(np.maximum(y, TINY))
        px = self.left + (x - self.x0) / (self.x1 - self.x0) * (self.right - self.left)
        py = self.bottom - (y - self.y0) / (self.y1 - self.y0) * (self.bottom - self.top)
        points = np.empty((*px.shape, 2))
        points[..., 0], points[..., 1] = px, py
        return np.minimum(np.maximum(points, -FAR), FAR)

    def at(self, x: float, y: float) -> ImVec2:
        """One point."""
        if self.log:
            x = log10(max(x, TINY))
        if self.log if self.log_y is None else self.log_y:
            y = log10(max(y, TINY))
        px = self.left + (x - self.x0) / (self.x1 - self.x0) * (self.right - self.left)
        py = self.bottom - (y - self.y0) / (self.y1 - self.y0) * (self.bottom - self.top)
        return ImVec2(min(max(px, -FAR), FAR), min(max(py, -FAR), FAR))

    def x_at(self, pixel: float) -> float:
        """The plot coordinate under a pixel's column."""
        x = self.x0 + (pixel - self.left) / max(self.right - self.left, 1e-6) * (self.x1 - self.x0)
        return float(10.0**x) if self.log else float(x)

    def y_at(self, pixel: float) -> float:
        """The plot coordinate under a pixel's row."""
        y = self.y0 + (self.bottom - pixel) / max(self.bottom - self.top, 1e-6) * (self.y1 - self.y0)
        return float(10.0**y) if (self.log if self.log_y is None else self.log_y) else float(y)


def pieces(points: np.ndarray, on: float = 0.0, off: float = 0.0) -> list[list[ImVec2]]:
    """The parts of a curve through pixels (n, 2): its unbroken runs, or dashes of `on` pixels with gaps of `off`."""
    runs: list[list] = []
    for run in _runs(points):
        if on <= 0.0:
            runs.append(run.tolist())
            continue
        lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(run, axis=0).T))])
        starts = (on + off) * np.arange(min(int(lengths[-1] / (on + off)) + 1, 2000))
        ends = np.minimum(starts + on, lengths[-1])
        corners = [np.interp(marks, lengths, coordinate).tolist() for marks in (starts, ends) for coordinate in run.T]
        inner, points = np.searchsorted(lengths, starts, "right"), run.tolist()
        beyond = np.searchsorted(lengths, ends, "left")
        runs += [[(x0, y0), *points[i:j], (x1, y1)]
                 for x0, y0, x1, y1, i, j in zip(*corners, inner.tolist(), beyond.tolist(), strict=True)]
    return [[ImVec2(x, y) for x, y in piece] for piece in runs]


def _runs(points: np.ndarray) -> list[np.ndarray]:
    good = np.isfinite(points).all(axis=1)
    if good.all() or not good.any():
        return [points] if good.size > 1 and good[0] else []
    ends = np.flatnonzero(np.diff(np.concatenate([[0], good.astype(int), [0]])))
    return [points[a:b] for a, b in zip(ends[::2], ends[1::2], strict=True) if b - a > 1]


def text(draw: imgui.ImDrawList, corner: ImVec2, colour: theme.Colour, words: str, right: bool = False,
         plate: bool = False) -> None:
    """Text on whole pixels. at: its upper left corner, or the upper right one; plate: it hides the lines below."""
    size = imgui.calc_text_size(words)
    x, y = floor((corner.x - size.x if right else corner.x) + 0.5), floor(corner.y + 0.5)
    if plate:
        pad = theme.scale()
        draw.add_rect_filled(ImVec2(x - 2.0 * pad, y + pad), ImVec2(x + size.x + 2.0 * pad, y + size.y),
                             theme.packed(theme.colours().well, 0.8), 2.0 * pad)
    draw.add_text(ImVec2(x, y), theme.packed(colour), words)


@lru_cache(maxsize=256)
def linear_ticks(low: float, high: float, pixels: float, room: float,
                 whole: int | None = None) -> tuple[list[float], list[str]]:
    """Ticks of a linear axis from low to high of a length in pixels, each needing `room` pixels: by 1, 2 or 5 × 10ⁿ.

    There are two at least, closer than `room` if need be: one alone tells no scale. whole: at whole numbers alone, up
    to this one.
    """
    least = max(abs(high - low) * max(room / max(pixels, 1.0), 0.02), 0.0 if whole is None else 1.0)
    decade = 10.0 ** floor(np.log10(max(least, 1e-300)))
    steps = [decade * x for x in (10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1) if whole is None or decade * x >= 1.0]
    fitting = [step for step in steps if step >= least]
    step = next((step for step in (fitting[-1], *steps[len(fitting):]) if len(_multiples(step, low, high)) > 1),
                fitting[-1])
    values = [step * k for k in _multiples(step, low, high) if whole is None or step * k <= whole]
    return values, [true_minus(significant(value)) for value in values]


def _multiples(step: float, low: float, high: float) -> range:
    """The whole numbers whose multiples of a step lie on an axis."""
    return range(-floor(-min(low, high) / step), floor(max(low, high) / step) + 1)


@lru_cache(maxsize=64)
def log_ticks(low: float, high: float, pixels: float, room: float) -> tuple[list[float], list[str]]:
    """Ticks of a logarithmic axis from low to high of a length in pixels, each needing `room` pixels.

    The finest of 1-2-5, 1-3 and 1 a decade that fits, or of one in two decades and more; from the first decade of the
    axis on where two would not lie on it else.
    """
    per_decade = pixels / max(np.log10(high / low), 1e-6)
    every = max(1, ceil(room / max(per_decade, 1e-6)))
    decades = range(floor(np.log10(low)), floor(np.log10(high)) + 2)
    series = (1.0, 2.0, 5.0) if per_decade >= 3.4 * room else (1.0, 3.0) if per_decade >= 2.1 * room else (1.0,)
    values = [m * 10.0**e for e in decades if e % every == 0 for m in series]
    if sum(low <= value <= high for value in values) < 2:
        first = ceil(np.log10(low) - 1e-9)
        values = [10.0**e for e in decades if e >= first and (e - first) % every == 0] if every > 1 else \
            [m * 10.0**e for e in decades for m in (1.0, 2.0, 5.0)]
    return values, [_short(value) for value in values]


def _short(value: float) -> str:
    """The number at a tick: beyond 10⁻⁵ to 10⁵ with a power of ten, 10⁻⁹ or 3×10⁵."""
    if 0.99e-5 < value < 0.99e5:
        return significant(value)
    mantissa, power = f"{value:.0e}".split("e")
    return f"{mantissa}×10{str(int(power)).translate(RAISED)}".removeprefix("1×")
