"""Values as people write them on the command line, in the units of the core.

Each `read_…` takes a text and returns a value in mm, radians or stops, or raises a ValueError that says what to
type. Numbers with a unit are read in `scales`, `time_scales` and `sensor_scales`.
"""

import re

from lensbench.app.state.scales import read_distance, read_f_number


def read_aperture(text: str) -> float | None:
    """“2.8”, “f/2.8”; “open” for the widest aperture of the lens (None)."""
    return None if text.strip().lower() in ("open", "wide", "wide open") else read_f_number(text)


def read_position(text: str) -> tuple[float, float, float]:
    """“0,0.2,-1.5m”: x, y, z in the world, in metres where no unit is given."""
    parts = text.split(",")
    if len(parts) != 3:
        raise ValueError(f"“{text}”: type three distances with commas, such as 0,20cm,-1.5m")
    x, y, z = (read_distance(part) for part in parts)
    return x, y, z


def read_part(text: str) -> float:
    """“25%”, “0.25”."""
    match = re.fullmatch(r"\s*(\d+\.?\d*|\.\d+)\s*(%?)\s*", text)
    if match is None:
        raise ValueError(f"“{text}”: type a part such as 25%")
    return float(match[1]) / (100.0 if match[2] else 1.0)


def read_count(text: str) -> int:
    """A whole number of at least 1."""
    return _whole(text, 1)


def read_whole(text: str) -> int:
    """A whole number of at least 0."""
    return _whole(text, 0)


def read_seed(text: str) -> int:
    """A whole number from 0 to 2³² − 1."""
    if not re.fullmatch(r"\s*\d{1,10}\s*", text) or int(text) >= 1 << 32:
        raise ValueError(f"“{text}”: type a whole number from 0 to {(1 << 32) - 1}")
    return int(text)


def _whole(text: str, least: int) -> int:
    if not re.fullmatch(r"\s*\d{1,9}\s*", text) or int(text) < least:
        raise ValueError(f"“{text}”: type a whole number of at least {least}")
    return int(text)
