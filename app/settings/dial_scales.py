"""The engraved scale of each dial: position of a value from 0 (left) to 1 (right), figures, and the text of a value.

Lengths in mm, angles in radians, exposure in stops, times in seconds.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

from lensbench.app.settings.text_values import (
    format_angle, format_distance, format_duration, format_electrons, format_exposure, format_f_number,
    format_film_curvature, format_hole, format_iso, format_length, format_light, format_part, format_signed_length,
    format_time, read_angle, read_distance, read_electrons, read_exposure, read_f_number, read_film_curvature, read_iso,
    read_length, read_light, read_percent, read_signed_length, read_time
)
from lensbench.core.text import fixed, significant, true_minus

FIGURE_GAP = 0.08                                # of u: least distance of two figures
DIGITS = tuple(float(i) for i in range(1, 10))
Figure = tuple[float, str]


class Warp(NamedTuple):
    """What makes a scale: the position is linear in `to` of the value, and `back` is its inverse."""

    to: Callable[[float], float]
    back: Callable[[float], float]


EVEN = Warp(float, float)
LOGARITHMIC = Warp(math.log, math.exp)
ROOT = Warp(math.sqrt, lambda w: w * w)


@dataclass(frozen=True)
class Scale:
    """One engraved scale from `low` (u = 0) to `high` (u = 1; infinity is allowed, and a value below `low`).

    figures: values with their text; figure number `anchor` is engraved on the shortest dial too. minor: values of
    the short ticks. snaps: values that click and wheel go to; empty for a continuous scale. reset: value that a
    double click restores. amber: drawn in amber, for focus.
    """

    low: float
    high: float
    warp: Warp
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
        low, high = self.warp.to(self.low), self.warp.to(self.high)
        if high == low:
            return 0.0
        return min(max((self.warp.to(self._clamped(value)) - low) / (high - low), 0.0), 1.0)

    def _clamped(self, value: float) -> float:
        return min(max(value, min(self.low, self.high)), max(self.low, self.high))

    def from_unit(self, u: float) -> float:
        """Value at u, exact at both ends."""
        if u <= 0.0:
            return self.low
        if u >= 1.0:
            return self.high
        low, high = self.warp.to(self.low), self.warp.to(self.high)
        return self._clamped(self.warp.back(low + u * (high - low)))

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

    def finely(self, value: float, steps: float) -> float:
        """Value this part of a snap, or of a hundredth of a dial without any, to the right."""
        return self.from_unit(self.to_unit(value) + steps / (max(len(self.snaps) - 1, 1) if self.snaps else 100))

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
    """Figures at the least stride from the anchor at which none touch on a dial `width` wide."""
    positions = [scale.to_unit(value) * width for value, _ in scale.figures]
    for stride in range(1, len(positions) + 1):
        chosen = range(scale.anchor % stride, len(positions), stride) if positions else range(0)
        touching = any(positions[b] - positions[a] < 0.5 * (widths[a] + widths[b]) + gap
                       for a, b in zip(chosen, chosen[1:], strict=False))
        if not touching:
            return tuple(scale.figures[i] for i in chosen)
    return ()


F_NUMBERS = (0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.4, 1.6, 1.8, 2.0, 2.2, 2.5, 2.8, 3.2, 3.5, 4.0, 4.5, 5.0, 5.6, 6.3, 7.1,
             8.0, 9.0, 10.0, 11.0, 13.0, 14.0, 16.0, 18.0, 20.0, 22.0, 25.0, 29.0, 32.0, 36.0, 40.0, 45.0, 51.0, 57.0,
             64.0, 72.0, 81.0, 90.0)             # as engraved: third stops; each third one is a whole stop
WHOLE_STOPS = F_NUMBERS[0::3]
FOCAL_LENGTHS = (2, 3, 4, 6, 8, 10, 14, 20, 28, 35, 50, 70, 100, 135, 200, 300, 400, 600, 800, 1200)
THIRDS = (100, 125, 160, 200, 250, 320, 400, 500, 640, 800, 1000, 1250)
ISOS = (25, 32, 40, 50, 64, 80, *(iso * 2**k for k in (0, 4) for iso in THIRDS),
        *(iso * 2**8 for iso in THIRDS[:7]))         # as engraved: third stops; each third one is a whole stop
SECONDS = (30.0, 25.0, 20.0, 15.0, 13.0, 10.0, 8.0, 6.0, 5.0, 4.0, 3.2, 2.5, 2.0, 1.6, 1.3, 1.0, 0.8, 0.6, 0.5, 0.4,
           0.3)
PARTS = (4, 5, 6, 8, 10, 13, 15, 20, 25, 30, 40, 50, 60, 80, 100, 125, 160, 200, 250, 320, 400, 500, 640, 800, 1000,
         1250, 1600, 2000, 2500, 3200, 4000, 5000, 6400, 8000)
SHUTTERS = (*SECONDS, *(1.0 / rate for rate in PARTS))      # as engraved: third stops; each third one is a whole stop
LONGEST_READOUT = 0.2
STOPS = 5               # of exposure, to either side


def _by_decades(low: float, high: float, form: Callable[[float], str], read: Callable[[str], float],
                series: tuple[float, ...], reset: float, unit: float = 1.0, suffix: str = "") -> Scale:
    """A logarithmic scale with figures, in a unit, at a series in each decade, and ticks at all digits."""
    figures = tuple((value, significant(value / unit) + suffix) for value in decades(low, high, series))
    return Scale(low, high, LOGARITHMIC, form, read, figures, tuple(decades(low, high, DIGITS)), reset=reset)


def _evenly(high: float, form: Callable[[float], str], read: Callable[[str], float], step: float,
            reset: float | None, unit: float = 1.0) -> Scale:
    """An even scale from 0 with figures at steps of a unit, and ticks at fifths of a step."""
    figures, ticks = int(high / unit / step + 1e-9) + 1, int(5.0 * high / unit / step + 1e-9) + 1
    return Scale(0.0, high, EVEN, form, read, tuple((unit * (i * step), significant(i * step)) for i in range(figures)),
                 tuple(unit * (i * step / 5.0) for i in range(ticks)), reset=reset)


def _round_step(high: float, most: float) -> float:
    """The least of 1, 2, 5 × 10ⁿ that divides `high` into at most so many parts."""
    return next(s * 10.0**e for e in range(-6, 5) for s in (1.0, 2.0, 5.0) if high / (s * 10.0**e) <= most)


@lru_cache(maxsize=64)
def focus_scale(nearest: float, reset: float | None = None) -> Scale:
    """From the nearest distance n (mm) to ∞: u = (d − n)/(d − n + k), k = 4 n, at least 1.2 m."""
    n = max(nearest, 1.0)
    k = max(1200.0, 4.0 * n)

    warp = Warp(lambda distance: -k / (distance - n + k), lambda w: n - k - k / w if w < 0.0 else math.inf)
    bare = Scale(n, math.inf, warp, format_distance, read_distance, ())
    series = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)
    figures = spaced([(d, significant(d / 1000)) for d in (*decades(n, 40.0 * k, series), math.inf)], bare.to_unit)
    minor = decades(n, 40.0 * k, (1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.75, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5,
                                   5.0, 6.0, 7.0, 8.0, 9.0))
    return replace(bare, figures=figures, minor=tuple(minor), reset=reset, anchor=len(figures) - 1, amber=True)


@lru_cache(maxsize=64)
def aperture_scale(widest: float, reset: float | None = None) -> Scale:
    """From the widest f-number that the lens can open to six stops above (f/22 at least), snapping to third stops."""
    high = next((n for n in WHOLE_STOPS if n >= max(21.9, 7.8 * widest)), F_NUMBERS[-1])
    high = max(high, 2.0 * widest)
    bare = Scale(widest, high, LOGARITHMIC, format_f_number, read_f_number, ())
    snaps = tuple(n for n in F_NUMBERS if widest * 1.02 < n <= high)
    figures = [(n, significant(n)) for n in WHOLE_STOPS if widest * 0.99 <= n <= high]
    if not figures or bare.to_unit(figures[0][0]) > FIGURE_GAP:
        figures.insert(0, (widest, format_f_number(widest).removeprefix("f/")))
    return replace(bare, figures=tuple(figures), minor=snaps, snaps=(widest, *snaps), reset=reset)


@lru_cache(maxsize=8)
def pinhole_scale(widest: float) -> Scale:
    """`aperture_scale` of an ideal lens, whose narrow end is a pinhole."""
    scale = aperture_scale(widest)
    return replace(scale, format=lambda n: "pinhole" if n == scale.high else format_f_number(n))


@lru_cache(maxsize=1)
def exposure_scale(reset: float = 0.0) -> Scale:
    """Stops from −STOPS to +STOPS, snapping to thirds."""
    whole = range(-STOPS, STOPS + 1)
    thirds = tuple(i / 3.0 for i in range(3 * whole.start, 3 * whole.stop - 2))
    figures = tuple((float(i), format_exposure(i).removesuffix(" EV")) for i in whole)
    return Scale(-float(STOPS), float(STOPS), EVEN, format_exposure, read_exposure, figures, thirds, thirds,
                 reset=reset, anchor=len(figures) // 2)


@lru_cache(maxsize=64)
def fov_scale(narrowest: float, widest: float, reset: float | None = None) -> Scale:
    """Angles of view (radians) on a logarithmic dial."""
    low, high = math.degrees(narrowest), math.degrees(widest)
    bare = Scale(narrowest, widest, LOGARITHMIC, format_angle, read_angle, ())
    series = decades(low, high, (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 9.0))
    figures = spaced([(math.radians(d), significant(d)) for d in (*series, 120.0, 180.0) if low <= d <= high],
                     bare.to_unit)
    minor = tuple(math.radians(d) for d in decades(low, high, tuple(1.0 + 0.25 * i for i in range(4))
                                                    + tuple(2.0 + 0.5 * i for i in range(16))))
    return replace(bare, figures=figures, minor=minor, reset=reset)


@lru_cache(maxsize=64)
def focal_length_scale(low: float = 8.0, high: float = 800.0, reset: float | None = None) -> Scale:
    """Focal lengths (mm) on a logarithmic dial, snapping to those usually engraved."""
    snaps = tuple(float(f) for f in FOCAL_LENGTHS if low <= f <= high)
    figures = tuple((f, significant(f)) for f in snaps)
    minor = tuple(decades(low, high, (1.0, 1.2, 1.5, 1.75, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0, 7.0, 8.0, 9.0)))
    return Scale(low, high, LOGARITHMIC, format_length, read_length, figures, minor, snaps, reset)


@lru_cache(maxsize=64)
def zoom_scale(engraved: tuple[float, ...]) -> Scale:
    """Focal lengths (mm) of a zoom; figures at the engraved ones, two or more, ascending, and in wide gaps."""
    low, high = engraved[0], engraved[-1]
    bare = Scale(low, high, LOGARITHMIC, format_length, read_length, ())

    def figure(length: float) -> Figure:
        return length, fixed(length, 0) if length >= 9.995 else fixed(length, 1).removesuffix(".0")

    figures = [figure(length) for length in engraved]
    for between in decades(low, high, (1.0, 1.2, 1.35, 1.5, 2.0, 2.4, 2.8, 3.5, 4.0, 5.0, 6.0, 7.0, 8.5)):
        if all(abs(bare.to_unit(between) - bare.to_unit(other)) >= 1.5 * FIGURE_GAP for other, _ in figures):
            figures.append(figure(between))
    series = (*(1.0 + 0.1 * i for i in range(10)), *(2.0 + 0.5 * i for i in range(16)))
    minor = tuple(decades(low, high, series))
    return replace(bare, figures=tuple(sorted(figures)), minor=minor, reset=low)


@lru_cache(maxsize=16)
def radius_scale(high: float, reset: float | None = None) -> Scale:
    """Radii on the film (mm) from the axis to `high`."""
    return _evenly(high, lambda r: f"{fixed(r, 1)} mm", read_length, _round_step(high, 7.0), reset)


@lru_cache(maxsize=1)
def iso_scale() -> Scale:
    """From ISO 25 to 102400, snapping to third stops."""
    figures = tuple((float(iso), f"{iso}" if iso < 1000 else f"{significant(iso / 1000, 3)}k") for iso in ISOS[0::3])
    return Scale(ISOS[0], ISOS[-1], LOGARITHMIC, format_iso, read_iso, figures, tuple(map(float, ISOS)),
                 tuple(map(float, ISOS)), 100.0, anchor=2)


@lru_cache(maxsize=1)
def full_well_scale() -> Scale:
    """Electrons on a logarithmic dial."""
    return _by_decades(500.0, 200_000.0, format_electrons, read_electrons, (1.0, 2.0, 5.0), 50_000.0, 1000.0, "k")


@lru_cache(maxsize=1)
def read_noise_scale() -> Scale:
    """Electrons, on a square-root dial."""
    figures = tuple((float(n), f"{n}") for n in (0, 1, 3, 10, 20, 50))
    return Scale(0.0, 50.0, ROOT, format_electrons, read_electrons, figures,
                 tuple(float(n) for n in (2, *range(4, 10), *range(12, 20, 2), 25, 30, 35, 40, 45)), reset=3.0)


@lru_cache(maxsize=32)
def turn_scale(blades: int) -> Scale:
    """Rotation (radians) of an iris with this many blades, from one blade to the next."""
    whole = 360.0 / max(blades, 3)
    step = next(s for s in (1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0) if whole / s <= 7.0)
    return _evenly(math.radians(whole), format_angle, read_angle, step, 0.0, math.radians(1.0))


@lru_cache(maxsize=1)
def lean_scale() -> Scale:
    """Tilt and swing of a film (radians): finer near 0, by the square root of the angle."""
    figures = tuple((math.radians(a), true_minus(significant(a)))
                    for a in (-45.0, -20.0, -8.0, -2.0, 0.0, 2.0, 8.0, 20.0, 45.0))
    minor = tuple(math.radians(a) for a in (*range(-45, -9, 5), *range(-9, 10), *range(10, 46, 5)))
    return _about_zero(math.radians(45.0), format_angle, read_angle, figures, minor)


@lru_cache(maxsize=16)
def move_scale(most: float) -> Scale:
    """Rise and shift of a lens (mm): finer near 0."""
    ends = (0.05, 0.2, 0.5, 1.0)
    figures = tuple((s * share * most, true_minus(significant(s * share * most, 2)))
                    for s in (-1.0, 1.0) for share in ends)
    return _about_zero(most, format_signed_length, read_signed_length, tuple(sorted((*figures, (0.0, "0")))), ())


@lru_cache(maxsize=16)
def curvature_scale(least: float) -> Scale:
    """Curvature of a film (1/mm) about a flat one, engraved with its radius (mm), from just above the `least`."""
    step = 10.0 ** (math.floor(math.log10(least)) - 1)
    tightest = math.ceil(1.02 * least / step) * step        # a rounded figure that is no tighter
    radii = [float(significant(tightest * times, 2)) for times in (1.0, 2.0, 6.0, 40.0)]
    figures = tuple((1.0 / (sign * r), true_minus(significant(sign * r, 2))) for sign in (-1.0, 1.0) for r in radii)
    return _about_zero(1.0 / radii[0], format_film_curvature, read_film_curvature,
                       tuple(sorted((*figures, (0.0, "flat")))), ())


def _about_zero(most: float, form: Callable[[float], str], read: Callable[[str], float],
                figures: tuple[Figure, ...], minor: tuple[float, ...]) -> Scale:
    """A scale that is finer near 0, by the square root of the value."""
    warp = Warp(lambda value: math.copysign(math.sqrt(abs(value) / most), value),
                lambda w: math.copysign(most * w * w, w))
    return Scale(-most, most, warp, form, read, figures, minor, reset=0.0)


@lru_cache(maxsize=8)
def hole_scale(best: float) -> Scale:
    """Diameters of a pinhole (mm) on a logarithmic dial; a double click restores the sharpest."""
    return _by_decades(0.02, 10.0, format_hole, read_length, (1.0, 2.0, 5.0), best)


@lru_cache(maxsize=2)
def shutter_scale(reset: float | None = None) -> Scale:
    """From 30 s to 1/8000 s, snapping to third stops."""
    figures = tuple((s, f"{significant(s)}″" if s >= 0.3 else fixed(1.0 / s, 0)) for s in SHUTTERS[0::3])
    warp = Warp(lambda s: -math.log(s), lambda w: math.exp(-w))
    return Scale(SHUTTERS[0], SHUTTERS[-1], warp, format_time, read_time, figures, SHUTTERS, SHUTTERS, reset,
                 anchor=SHUTTERS[0::3].index(1.0))


@lru_cache(maxsize=1)
def readout_scale() -> Scale:
    """The read-out of a rolling shutter: 0 is a global shutter; a square-root dial."""
    figures = tuple((t / 1e3, f"{t}") for t in (0, 1, 5, 10, 20, 50, 100, 200))
    minor = tuple(t / 1e3 for t in (*range(2, 10), *range(12, 20, 2), *range(25, 50, 5), *range(60, 100, 10), *range(
        120, 200, 20)))
    return Scale(0.0, LONGEST_READOUT, ROOT, format_duration, read_time, figures, minor,
                 reset=0.0)


@lru_cache(maxsize=16)
def moment_scale(duration: float) -> Scale:
    """The scrub bar of two keyframes: from the first to the second."""
    return _evenly(duration, format_duration, read_time, _round_step(duration, 5.001), 0.0)


@lru_cache(maxsize=1)
def duration_scale() -> Scale:
    """From 10 ms to a minute, on a logarithmic dial."""
    full = _by_decades(0.01, 60.0, format_duration, read_time, (1.0, 2.0, 5.0), 1.0)
    return replace(full, figures=spaced(list(full.figures), full.to_unit))


@lru_cache(maxsize=4)
def part_scale(most: float = 0.5, reset: float = 0.0) -> Scale:
    """From nothing to a part of 1, in percent."""
    tenths = tuple(i / 10.0 for i in range(int(10.0 * most + 1e-9) + 1))
    minor = tuple(i / 50.0 for i in range(int(50.0 * most + 1e-9) + 1))
    return Scale(0.0, most, EVEN, format_part, read_percent, tuple((t, fixed(100.0 * t, 0)) for t in tenths),
                 minor, reset=reset)


@lru_cache(maxsize=1)
def light_scale() -> Scale:
    """Radiances from 0 to 2."""
    return Scale(0.0, 2.0, EVEN, format_light, read_light,
                 tuple((i / 4.0, significant(i / 4.0)) for i in range(9)),
                 tuple(i / 20.0 for i in range(41)), reset=0.5)


@lru_cache(maxsize=4)
def visibility_scale(high: float = 1e6) -> Scale:
    """Visibilities (mm; people read metres) on a logarithmic dial."""
    return _by_decades(500.0, high, format_distance, read_distance, (1.0, 3.0), 10_000.0, 1000.0)


@lru_cache(maxsize=4)
def width_scale(reset: float) -> Scale:
    """Widths of scene (mm; people read metres) on a logarithmic dial."""
    return _by_decades(10.0, 100_000.0, format_distance, read_distance, (1.0, 3.0), reset, 1000.0)


@lru_cache(maxsize=4)
def lens_radius_scale(high: float = 100.0, reset: float = 0.0) -> Scale:
    """Radii of an ideal lens (mm): a square-root dial that begins at a pinhole."""
    figures = tuple((float(r), f"{r}") for r in (0, 1, 5, 10, 20, 50, 100) if r <= high)
    minor = tuple(float(r) for r in (*range(1, 10), *range(10, 20, 2), *range(20, 50, 5), *range(50, 101, 10)))
    return Scale(0.0, high, ROOT, format_length, read_length, figures, minor, reset=reset)


@lru_cache(maxsize=4)
def fisheye_scale(widest: float) -> Scale:
    """Fields of view of a fisheye (radians), evenly along the dial."""
    figures = tuple((math.radians(d), f"{d}") for d in range(30, 360, 30) if math.radians(d) <= widest + 1e-9)
    minor = tuple(math.radians(d) for d in range(10, 360, 10) if math.radians(d) <= widest + 1e-9)
    return Scale(math.radians(10.0), widest, EVEN, format_angle, read_angle, figures, minor, reset=math.pi)
