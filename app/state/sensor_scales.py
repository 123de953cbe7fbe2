"""The engraved scales of ISO, of a sensor's figures, and of a stop's blades."""

import math
from functools import lru_cache

from lensbench.app.state.scales import (
    Scale,
    decades,
    format_angle,
    format_length,
    read_angle,
    read_length,
    read_number,
)

THIRDS = (100, 125, 160, 200, 250, 320, 400, 500, 640, 800, 1000, 1250)
ISOS = (25, 32, 40, 50, 64, 80, *(iso * 2**k for k in (0, 4) for iso in THIRDS),
        *(iso * 2**8 for iso in THIRDS[:7]))         # as engraved: third stops; each third one is a whole stop


def format_iso(iso: float) -> str:
    """ISO 100."""
    return f"ISO {iso:.0f}"


def read_iso(text: str) -> float:
    """“400”, “ISO 400”."""
    return read_number(r"(?:iso\s*)?#", text, "a speed such as ISO 400")[0]


@lru_cache(maxsize=1)
def iso_scale() -> Scale:
    """From ISO 25 to 102400, snapping to third stops."""
    figures = tuple((float(iso), f"{iso}" if iso < 1000 else f"{float(f'{iso / 1000:.3g}'):g}k") for iso in ISOS[0::3])
    return Scale(ISOS[0], ISOS[-1], math.log, math.exp, format_iso, read_iso, figures, tuple(map(float, ISOS)),
                 tuple(map(float, ISOS)), 100.0, anchor=2)


def format_electrons(count: float) -> str:
    """3.0 e, 50000 e."""
    return f"{count:.1f} e" if count < 99.95 else f"{float(f'{count:.3g}'):.0f} e"


def read_electrons(text: str) -> float:
    """“50000”, “50000 e”, “50k”."""
    number, unit = read_number(r"#\s*(k\s*e?|e)?", text, "electrons such as 50000")
    return number * (1000.0 if unit.startswith("k") else 1.0)


@lru_cache(maxsize=1)
def full_well_scale() -> Scale:
    """Electrons on a logarithmic dial."""
    figures = tuple((n, f"{n / 1000:g}k") for n in decades(500.0, 200_000.0, (1.0, 2.0, 5.0)))
    return Scale(500.0, 200_000.0, math.log, math.exp, format_electrons, read_electrons, figures,
                 tuple(decades(500.0, 200_000.0, tuple(float(i) for i in range(1, 10)))), reset=50_000.0)


@lru_cache(maxsize=1)
def read_noise_scale() -> Scale:
    """Electrons, on a square-root dial."""
    figures = tuple((float(n), f"{n}") for n in (0, 1, 3, 10, 20, 50))
    return Scale(0.0, 50.0, math.sqrt, lambda w: w * w, format_electrons, read_electrons, figures,
                 tuple(float(n) for n in (2, *range(4, 10), *range(12, 20, 2), 25, 30, 35, 40, 45)), reset=3.0)


@lru_cache(maxsize=32)
def turn_scale(blades: int) -> Scale:
    """Rotation (radians) of an iris with this many blades, from one blade to the next."""
    whole = 360.0 / max(blades, 3)
    step = next(s for s in (1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 30.0) if whole / s <= 7.0)
    figures = tuple((math.radians(i * step), f"{i * step:g}") for i in range(int(whole / step + 1e-9) + 1))
    minor = tuple(math.radians(i * step / 5.0) for i in range(int(5.0 * whole / step + 1e-9) + 1))
    return Scale(0.0, math.radians(whole), float, float, format_angle, read_angle, figures, minor, reset=0.0)


@lru_cache(maxsize=8)
def hole_scale(best: float) -> Scale:
    """Diameters of a pinhole (mm) on a logarithmic dial; a double click restores the sharpest."""
    figures = tuple((d, f"{d:g}") for d in decades(0.02, 10.0, (1.0, 2.0, 5.0)))
    return Scale(0.02, 10.0, math.log, math.exp, format_hole, read_length, figures,
                 tuple(decades(0.02, 10.0, tuple(float(i) for i in range(1, 10)))), reset=best)


def format_hole(diameter: float) -> str:
    """ø 0.32 mm."""
    return f"{diameter:.3g} mm" if diameter < 1.0 else format_length(diameter)
