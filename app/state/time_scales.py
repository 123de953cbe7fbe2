"""The engraved scales of time, of parts and radiances, and of cameras without a lens.

Times in seconds, lengths in mm.
"""

import math
import re
from functools import lru_cache

from lensbench.app.state.scales import (
    Scale,
    decades,
    format_angle,
    format_distance,
    format_length,
    read_angle,
    read_distance,
    read_length,
    read_number,
    spaced,
)

SECONDS = (30.0, 25.0, 20.0, 15.0, 13.0, 10.0, 8.0, 6.0, 5.0, 4.0, 3.2, 2.5, 2.0, 1.6, 1.3, 1.0, 0.8, 0.6, 0.5, 0.4,
           0.3)
PARTS = (4, 5, 6, 8, 10, 13, 15, 20, 25, 30, 40, 50, 60, 80, 100, 125, 160, 200, 250, 320, 400, 500, 640, 800, 1000,
         1250, 1600, 2000, 2500, 3200, 4000, 5000, 6400, 8000)
SHUTTERS = (*SECONDS, *(1.0 / part for part in PARTS))      # as engraved: third stops; each third one is a whole stop
LONGEST_READOUT = 0.2


def format_time(seconds: float) -> str:
    """A shutter time: 30 s, 1.3 s, 1/125 s."""
    if seconds >= 0.295:
        return f"{seconds:.1f}".removesuffix(".0") + " s"
    return f"1/{1.0 / seconds:.0f} s" if seconds > 0.0 else "0 s"


def format_duration(seconds: float) -> str:
    """A span of time: 0 s, 350 µs, 2.5 ms, 20 ms, 1.25 s."""
    for least, gain, unit in ((0.9995, 1.0, "s"), (0.9995e-3, 1e3, "ms"), (0.0, 1e6, "µs")):
        if seconds >= least:
            return f"{float(f'{seconds * gain:.3g}'):g} {unit}" if seconds > 0.0 else "0 s"
    return f"−{format_duration(-seconds)}"


def read_time(text: str) -> float:
    """“1/125”, “0.5 s”, “20 ms”, “350 µs” in seconds; a bare number is in seconds."""
    example = "a time such as 1/125 s, 20 ms or 2 s"
    part = re.fullmatch(r"\s*1\s*/\s*(\d+\.?\d*)\s*s?\s*", text)
    if part is not None and float(part[1]) > 0.0:
        return 1.0 / float(part[1])
    number, unit = read_number(r"#\s*(s|ms|µs|us|″|\")?", text, example)
    return number * {"ms": 1e-3, "µs": 1e-6, "us": 1e-6}.get(unit, 1.0)


@lru_cache(maxsize=2)
def shutter_scale(reset: float | None = None) -> Scale:
    """From 30 s to 1/8000 s, snapping to third stops."""
    figures = tuple((s, f"{s:g}″" if s >= 0.3 else f"{1.0 / s:.0f}") for s in SHUTTERS[0::3])
    return Scale(SHUTTERS[0], SHUTTERS[-1], lambda s: -math.log(s), lambda w: math.exp(-w), format_time, read_time,
                 figures, SHUTTERS, SHUTTERS, reset, anchor=SHUTTERS[0::3].index(1.0))


@lru_cache(maxsize=2)
def readout_scale(reset: float = 0.0) -> Scale:
    """The read-out of a rolling shutter: 0 is a global shutter; a square-root dial."""
    figures = tuple((t / 1e3, f"{t}") for t in (0, 1, 5, 10, 20, 50, 100, 200))
    minor = tuple(t / 1e3 for t in (*range(2, 10), *range(12, 20, 2), *range(25, 50, 5), *range(60, 100, 10), *range(
        120, 200, 20)))
    return Scale(0.0, LONGEST_READOUT, math.sqrt, lambda w: w * w, format_duration, read_time, figures, minor,
                 reset=reset)


@lru_cache(maxsize=16)
def moment_scale(duration: float, reset: float | None = 0.0) -> Scale:
    """The scrub bar of two keyframes: from the first to the second."""
    step = next(s * 10.0**e for e in range(-6, 5) for s in (1.0, 2.0, 5.0) if duration / (s * 10.0**e) <= 5.001)
    figures = tuple((i * step, f"{i * step:g}") for i in range(int(duration / step + 1e-9) + 1))
    minor = tuple(i * step / 5.0 for i in range(int(5.0 * duration / step + 1e-9) + 1))
    return Scale(0.0, duration, float, float, format_duration, read_time, figures, minor, reset=reset)


@lru_cache(maxsize=2)
def duration_scale(reset: float = 1.0) -> Scale:
    """From 10 ms to a minute, on a logarithmic dial."""
    bare = Scale(0.01, 60.0, math.log, math.exp, format_duration, read_time, ())
    figures = spaced([(s, f"{s:g}") for s in decades(0.01, 60.0, (1.0, 2.0, 5.0))], bare.to_unit)
    return Scale(0.01, 60.0, math.log, math.exp, format_duration, read_time, figures,
                 tuple(decades(0.01, 60.0, tuple(float(i) for i in range(1, 10)))), reset=reset)


def format_part(part: float) -> str:
    """25 %."""
    return f"{100.0 * part:.0f} %"


def read_percent(text: str) -> float:
    """“25 %”, “25” as a part of 1."""
    return read_number(r"#\s*%?", text, "a part such as 25 %")[0] / 100.0


@lru_cache(maxsize=4)
def part_scale(most: float = 0.5, reset: float = 0.0) -> Scale:
    """From nothing to a part of 1, in percent."""
    tenths = tuple(i / 10.0 for i in range(int(10.0 * most + 1e-9) + 1))
    minor = tuple(i / 50.0 for i in range(int(50.0 * most + 1e-9) + 1))
    return Scale(0.0, most, float, float, format_part, read_percent, tuple((t, f"{100.0 * t:.0f}") for t in tenths),
                 minor, reset=reset)


def format_light(radiance: float) -> str:
    """A radiance beside that of a white wall under an even sky: 0.50."""
    return f"{radiance:.2f}"


def read_light(text: str) -> float:
    """“0.5”."""
    return read_number("#", text, "a radiance such as 0.5")[0]


@lru_cache(maxsize=1)
def light_scale() -> Scale:
    """Radiances from 0 to 2."""
    return Scale(0.0, 2.0, float, float, format_light, read_light, tuple((i / 4.0, f"{i / 4.0:g}") for i in range(9)),
                 tuple(i / 20.0 for i in range(41)), reset=0.5)


@lru_cache(maxsize=4)
def visibility_scale(high: float = 1e6) -> Scale:
    """Visibilities (mm; people read metres) on a logarithmic dial."""
    figures = tuple((w, f"{w / 1000.0:g}") for w in decades(500.0, high, (1.0, 3.0)))
    minor = tuple(decades(500.0, high, tuple(float(i) for i in range(1, 10))))
    return Scale(500.0, high, math.log, math.exp, format_distance, read_distance, figures, minor, reset=10_000.0)


@lru_cache(maxsize=4)
def width_scale(low: float = 10.0, high: float = 100_000.0, reset: float | None = None) -> Scale:
    """Widths of scene (mm; people read metres) on a logarithmic dial."""
    figures = tuple((w, f"{w / 1000.0:g}") for w in decades(low, high, (1.0, 3.0)))
    minor = tuple(decades(low, high, tuple(float(i) for i in range(1, 10))))
    return Scale(low, high, math.log, math.exp, format_distance, read_distance, figures, minor, reset=reset)


@lru_cache(maxsize=4)
def lens_radius_scale(high: float = 100.0, reset: float = 0.0) -> Scale:
    """Radii of an ideal lens (mm): a square-root dial that begins at a pinhole."""
    figures = tuple((float(r), f"{r}") for r in (0, 1, 5, 10, 20, 50, 100) if r <= high)
    minor = tuple(float(r) for r in (*range(1, 10), *range(10, 20, 2), *range(20, 50, 5), *range(50, 101, 10)))
    return Scale(0.0, high, math.sqrt, lambda w: w * w, format_length, read_length, figures, minor, reset=reset)


@lru_cache(maxsize=4)
def fisheye_scale(widest: float, reset: float = math.pi) -> Scale:
    """Fields of view of a fisheye (radians), evenly along the dial."""
    figures = tuple((math.radians(d), f"{d}") for d in range(30, 360, 30) if math.radians(d) <= widest + 1e-9)
    minor = tuple(math.radians(d) for d in range(10, 360, 10) if math.radians(d) <= widest + 1e-9)
    return Scale(math.radians(10.0), widest, float, float, format_angle, read_angle, figures, minor, reset=reset)
