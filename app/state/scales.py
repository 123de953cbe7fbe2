"""Engraved scales of dials: position of a value, engraved figures, and the text of a value.

A scale maps its values to u from 0 (left) to 1 (right). Lengths in mm, angles
in radians, exposure in stops; the text of a value is in metres and degrees.
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

F_NUMBERS = (0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.4, 1.6, 1.8, 2.0, 2.2, 2.5, 2.8, 3.2, 3.5, 4.0, 4.5, 5.0, 5.6, 6.3, 7.1,
             8.0, 9.0, 10.0, 11.0, 13.0, 14.0, 16.0, 18.0, 20.0, 22.0, 25.0, 29.0, 32.0, 36.0, 40.0, 45.0, 51.0, 57.0,
             64.0, 72.0, 81.0, 90.0)             # as engraved: third stops; each third one is a whole stop
WHOLE_STOPS = F_NUMBERS[0::3]
FOCAL_LENGTHS = (2, 3, 4, 6, 8, 10, 14, 20, 28, 35, 50, 70, 100, 135, 200, 300, 400, 600, 800, 1200)
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


# Text


def format_distance(distance: float) -> str:
    """A distance in mm, written as on a focus scale: 0.205 m, 1.20 m, 12.5 m, 250 m, ∞."""
    if math.isinf(distance):
        return "∞"
    metres = distance / 1000.0
    for limit, digits in ((0.0995, 4), (0.5, 3), (9.995, 2), (99.95, 1)):
        if abs(metres) < limit:
            return f"{metres:.{digits}f} m"
    return f"{metres:.0f} m"


def format_f_number(f_number: float) -> str:
    """f/0.95, f/2, f/2.8, f/11."""
    if f_number < 0.995:
        return f"f/{f_number:.2f}"
    return f"f/{f_number:.1f}".removesuffix(".0") if f_number < 9.95 else f"f/{f_number:.0f}"


def format_exposure(stops: float) -> str:
    """+0.3 EV, 0 EV, −1 EV."""
    tenths = round(stops * 10)
    sign = "+" if tenths > 0 else "−" if tenths < 0 else ""
    return f"{sign}{abs(tenths) / 10:g} EV"


def format_angle(angle: float) -> str:
    """Radians as degrees: 47.2°, 4.72°."""
    degrees = math.degrees(angle)
    return f"{degrees:.2f}°" if degrees < 9.995 else f"{degrees:.1f}°"


def format_length(length: float) -> str:
    """A length in mm: 4.25 mm, 50.4 mm, 250 mm."""
    digits = 2 if length < 9.995 else 1 if length < 99.95 else 0
    return f"{length:.{digits}f} mm"


def format_area(area: float) -> str:
    """An area in mm² with three digits, without a power of ten: 2.23 mm², 123 mm², 1670 mm²."""
    digits = max(0, 2 - math.floor(math.log10(area))) if area > 0.0 else 0
    return f"{float(f'{area:.3g}'):.{min(digits, 6)}f} mm²"


NUMBER = r"([-+−]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:e[-+]?\d+)?)"


def read_number(pattern: str, text: str, example: str) -> tuple[float, str]:
    """Number and unit of a text, by a pattern in which # is the number; ValueError names the example."""
    match = re.fullmatch(pattern.replace("#", NUMBER), text.strip().lower())
    if match is None:
        raise ValueError(f"“{text.strip()}”: type {example}")
    return float(match[1].replace(",", ".").replace("−", "-")), match[2] if match.re.groups > 1 and match[2] else ""


def read_distance(text: str) -> float:
    """“1.2”, “1.2 m”, “120cm”, “1200 mm”, “inf”, “∞” in mm; a bare number is in metres."""
    if text.strip().lower() in ("inf", "infinity", "∞"):
        return math.inf
    number, unit = read_number(r"#\s*(m|cm|mm|km)?", text, "a distance such as 1.2 m, 120 cm or inf")
    return number * {"": 1000.0, "m": 1000.0, "cm": 10.0, "mm": 1.0, "km": 1e6}[unit]


def read_f_number(text: str) -> float:
    """“f/2.8”, “2.8”, “f 2.8”."""
    return read_number(r"(?:f\s*[/:]?\s*)?#", text, "an f-number such as f/2.8")[0]


def read_exposure(text: str) -> float:
    """“+0.3 EV”, “-1”."""
    return read_number(r"#\s*(ev|stops?)?", text, "an exposure such as +0.3 EV")[0]


def read_angle(text: str) -> float:
    """“47.2°”, “47.2”, “47 deg”, “0.8 rad” in radians; a bare number is in degrees."""
    number, unit = read_number(r"#\s*(°|deg|degrees|rad)?", text, "an angle such as 47.2°")
    return number if unit == "rad" else math.radians(number)


def read_length(text: str) -> float:
    """“50 mm”, “50”, “5 cm” in mm."""
    number, unit = read_number(r"#\s*(mm|cm)?", text, "a focal length such as 50 mm")
    return number * (10.0 if unit == "cm" else 1.0)


# Scales


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


@lru_cache(maxsize=64)
def focus_scale(nearest: float, reset: float | None = None) -> Scale:
    """Distances (mm) from the nearest that the lens can focus to infinity: u = (d − n)/(d − n + k).

    k is 1.2 m, or four times the nearest distance if that is larger.
    """
    n = max(nearest, 1.0)
    k = max(1200.0, 4.0 * n)

    def warp(distance: float) -> float:
        return -k / (distance - n + k)

    def unwarp(w: float) -> float:
        return n - k - k / w if w < 0.0 else math.inf

    bare = Scale(n, math.inf, warp, unwarp, format_distance, read_distance, ())
    series = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)
    figures = spaced([(d, f"{d / 1000:g}") for d in decades(n, 40.0 * k, series)] + [(math.inf, "∞")], bare.to_unit)
    minor = decades(n, 40.0 * k, (1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.75, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5,
                                   5.0, 6.0, 7.0, 8.0, 9.0))
    return Scale(n, math.inf, warp, unwarp, format_distance, read_distance, figures, tuple(minor),
                 reset=reset, anchor=len(figures) - 1, amber=True)


@lru_cache(maxsize=64)
def aperture_scale(widest: float, reset: float | None = None) -> Scale:
    """From the widest f-number that the lens can open to six stops above (f/22 at least), snapping to third stops."""
    high = next((n for n in WHOLE_STOPS if n >= max(21.9, 7.8 * widest)), F_NUMBERS[-1])
    high = max(high, 2.0 * widest)
    bare = Scale(widest, high, math.log, math.exp, format_f_number, read_f_number, ())
    snaps = tuple(n for n in F_NUMBERS if widest * 1.02 < n <= high)
    figures = [(n, f"{n:g}") for n in WHOLE_STOPS if widest * 0.99 <= n <= high]
    if not figures or bare.to_unit(figures[0][0]) > FIGURE_GAP:
        figures.insert(0, (widest, format_f_number(widest).removeprefix("f/")))
    return Scale(widest, high, math.log, math.exp, format_f_number, read_f_number, tuple(figures),
                 snaps, (widest, *snaps), reset)


@lru_cache(maxsize=8)
def exposure_scale(stops: float = 5.0, reset: float | None = 0.0) -> Scale:
    """Stops from −`stops` to +`stops`, snapping to thirds."""
    whole = range(-math.floor(stops), math.floor(stops) + 1)
    thirds = tuple(i / 3.0 for i in range(3 * whole.start, 3 * whole.stop - 2))
    figures = tuple((float(i), format_exposure(i).removesuffix(" EV")) for i in whole)
    return Scale(-stops, stops, float, float, format_exposure, read_exposure, figures, thirds, thirds, reset,
                 anchor=len(figures) // 2)


@lru_cache(maxsize=64)
def fov_scale(narrowest: float, widest: float, reset: float | None = None) -> Scale:
    """Angles of view (radians) on a logarithmic dial."""
    low, high = math.degrees(narrowest), math.degrees(widest)
    bare = Scale(narrowest, widest, math.log, math.exp, format_angle, read_angle, ())
    series = decades(low, high, (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 9.0))
    figures = spaced([(math.radians(d), f"{d:g}") for d in (*series, 120.0, 180.0) if low <= d <= high], bare.to_unit)
    minor = tuple(math.radians(d) for d in decades(low, high, tuple(1.0 + 0.25 * i for i in range(4))
                                                    + tuple(2.0 + 0.5 * i for i in range(16))))
    return Scale(narrowest, widest, math.log, math.exp, format_angle, read_angle, figures, minor, reset=reset)


@lru_cache(maxsize=64)
def focal_length_scale(low: float = 8.0, high: float = 800.0, reset: float | None = None) -> Scale:
    """Focal lengths (mm) on a logarithmic dial, snapping to those usually engraved."""
    snaps = tuple(float(f) for f in FOCAL_LENGTHS if low <= f <= high)
    figures = tuple((f, f"{f:g}") for f in snaps)
    minor = tuple(decades(low, high, (1.0, 1.2, 1.5, 1.75, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 6.0, 7.0, 8.0, 9.0)))
    return Scale(low, high, math.log, math.exp, format_length, read_length, figures, minor, snaps, reset)


@lru_cache(maxsize=64)
def zoom_scale(engraved: tuple[float, ...]) -> Scale:
    """The focal lengths (mm) of a zoom on a logarithmic dial from its widest to its longest.

    engraved: focal lengths of its stations, two or more, ascending; figures between them fill the gaps.
    """
    low, high = engraved[0], engraved[-1]
    bare = Scale(low, high, math.log, math.exp, format_length, read_length, ())

    def figure(length: float) -> Figure:
        return length, f"{length:.0f}" if length >= 9.995 else f"{length:.1f}".removesuffix(".0")

    figures = [figure(length) for length in engraved]
    for between in decades(low, high, (1.0, 1.2, 1.35, 1.5, 2.0, 2.4, 2.8, 3.5, 4.0, 5.0, 6.0, 7.0, 8.5)):
        if all(abs(bare.to_unit(between) - bare.to_unit(other)) >= 1.5 * FIGURE_GAP for other, _ in figures):
            figures.append(figure(between))
    series = (*(1.0 + 0.1 * i for i in range(10)), *(2.0 + 0.5 * i for i in range(16)))
    minor = tuple(decades(low, high, series))
    return Scale(low, high, math.log, math.exp, format_length, read_length, tuple(sorted(figures)), minor, reset=low)


@lru_cache(maxsize=16)
def radius_scale(high: float, reset: float | None = None) -> Scale:
    """Radii on the film (mm) from the axis to `high`."""
    step = next(s * 10.0**e for e in range(-3, 5) for s in (1.0, 2.0, 5.0) if high / (s * 10.0**e) <= 7.0)
    figures = tuple((i * step, f"{i * step:g}") for i in range(int(high / step + 1e-9) + 1))
    minor = tuple(i * step / 5.0 for i in range(int(5.0 * high / step + 1e-9) + 1))
    return Scale(0.0, high, float, float, lambda r: f"{r:.1f} mm", read_length, figures, minor, reset=reset)


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
