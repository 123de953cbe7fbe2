"""Values as people read and type them: numbers with units on dials, in panels and on the command line.

Each `format_…` returns the text of a value in mm, radians, seconds or stops. Each `read_…` takes a text and returns
such a value, or raises a ValueError that says what to type.
"""

import math
import re

from lensbench.core.text import INFINITE, cut, f_number_text, fixed, significant, true_minus

LARGEST = 1e300                 # of a number that is read: no unit makes it infinite
INCH = 25.4                     # mm
EXTENT = "a length of at least 0, such as 21.6 mm"
NUMBER = r"([-+−]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:e[-+]?\d+)?)"


def format_distance(distance: float) -> str:
    """A distance in mm, written as on a focus scale: 0.205 m, 1.20 m, 12.5 m, 250 m, ∞."""
    if math.isinf(distance):
        return INFINITE
    metres = distance / 1000.0
    for limit, digits in ((0.09995, 4), (0.4995, 3), (9.995, 2), (99.95, 1)):
        if abs(metres) < limit:
            return f"{fixed(metres, digits)} m"
    return f"{fixed(metres, 0)} m"


def format_f_number(f_number: float) -> str:
    """f/0.95, f/2, f/2.8, f/11; "none" for a camera without one."""
    return f_number_text(f_number)


def format_exposure(stops: float) -> str:
    """+0.3 EV, 0 EV, −1 EV."""
    return true_minus(f"{significant(round(stops * 10) / 10, signed=True)} EV")


def format_angle(angle: float) -> str:
    """Radians as degrees: 47.2°, 4.72°."""
    degrees = math.degrees(angle)
    return true_minus(f"{fixed(degrees, 2 if abs(degrees) < 9.995 else 1)}°")


def format_length(length: float) -> str:
    """A length in mm: 4.25 mm, 50.4 mm, 250 mm."""
    digits = 2 if length < 9.995 else 1 if length < 99.95 else 0
    return f"{fixed(length, digits)} mm"


def format_signed_length(length: float) -> str:
    """A length in mm that may be negative: 0.00 mm, −4.25 mm, 12.0 mm."""
    digits = 2 if abs(length) < 9.995 else 1
    return true_minus(f"{fixed(length, digits)} mm")


def format_film_curvature(curvature: float) -> str:
    """The radius in mm of a film's curvature in 1/mm: −90 mm; flat."""
    return true_minus(f"{significant(1.0 / curvature, 3)} mm") if curvature else "flat"


def format_area(area: float) -> str:
    """An area in mm² with three digits, without a power of ten: 2.23 mm², 123 mm², 1670 mm²."""
    return f"{significant(area, 3)} mm²"


def format_iso(iso: float) -> str:
    """ISO 100."""
    return f"ISO {fixed(iso, 0)}"


def format_electrons(count: float) -> str:
    """3.0 e, 50000 e."""
    return f"{fixed(count, 1) if count < 99.95 else significant(count, 3)} e"


def format_hole(diameter: float) -> str:
    """The diameter of a hole in mm: 0.32 mm, 1.50 mm."""
    return f"{significant(diameter, 3)} mm" if diameter < 1.0 else format_length(diameter)


def format_time(seconds: float) -> str:
    """A shutter time: 30 s, 1.3 s, 1/125 s."""
    if seconds >= 0.295:
        return fixed(seconds, 1).removesuffix(".0") + " s"
    return f"1/{fixed(1.0 / seconds, 0)} s" if seconds > 0.0 else "0 s"


def format_duration(seconds: float) -> str:
    """A span of time: 0 s, 350 µs, 2.5 ms, 20 ms, 1.25 s."""
    for least, gain, unit in ((0.9995, 1.0, "s"), (0.9995e-3, 1e3, "ms"), (0.0, 1e6, "µs")):
        if seconds >= least:
            return f"{significant(seconds * gain, 3)} {unit}" if seconds > 0.0 else "0 s"
    return f"−{format_duration(-seconds)}"


def format_part(share: float) -> str:
    """25 %."""
    return f"{fixed(100.0 * share, 0)} %"


def format_light(radiance: float) -> str:
    """A radiance relative to that of a white wall under an even sky: 0.50."""
    return fixed(radiance, 2)


def read_number(pattern: str, text: str, example: str) -> tuple[float, str]:
    """Number and unit of a text, by a pattern in which # is the number; ValueError names the example."""
    match = re.fullmatch(pattern.replace("#", NUMBER), text.strip().lower())
    if match is None:
        raise ValueError(f"“{cut(text.strip())}”: type {example}")
    number = float(match[1].replace(",", ".").replace("−", "-"))
    if not abs(number) <= LARGEST:
        raise ValueError(f"“{cut(text.strip())}”: this number is too large")
    return number, match[2] if match.re.groups > 1 and match[2] else ""


def read_distance(text: str) -> float:
    """“1.2”, “1.2 m”, “120cm”, “1200 mm”, “10 ft”, “inf”, “∞” in mm; a bare number is in metres."""
    if text.strip().lower() in ("inf", "infinity", "∞"):
        return math.inf
    number, unit = read_number(r"#\s*(m|cm|mm|km|ft|feet|foot|'|′|in|inch|inches)?", text,
                               "a distance such as 1.2 m, 120 cm, 10 ft or inf")
    return number * {"": 1000.0, "m": 1000.0, "cm": 10.0, "mm": 1.0, "km": 1e6}.get(
        unit, INCH if unit.startswith("in") else 12.0 * INCH)


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
    return _millimetres(text, "a focal length such as 50 mm")


def read_signed_length(text: str) -> float:
    """“10 mm”, “-10”, “1 cm” in mm; such a length may be negative."""
    return _millimetres(text, "a length such as 10 mm")


def read_extent(text: str) -> float:
    """“21.6”, “21.6 mm”, “2 cm” in mm; such a length is at least 0."""
    length = _millimetres(text, EXTENT)
    if length < 0.0:
        raise ValueError(f"“{cut(text.strip())}”: type {EXTENT}")
    return length


def _millimetres(text: str, example: str) -> float:
    number, unit = read_number(r"#\s*(mm|cm)?", text, example)
    return number * (10.0 if unit == "cm" else 1.0)


def read_film_radius(text: str) -> float:
    """“-90 mm”: the radius of a film that is curved as a sphere; “flat” or “inf”: infinite."""
    return math.inf if text.strip().lower() in ("flat", "inf", "∞") else read_signed_length(text)


def read_film_curvature(text: str) -> float:
    """“-90 mm”: the curvature of that radius, in 1/mm; “flat” or “inf”: 0."""
    if text.strip().lower() in ("flat", "inf", "∞", "0"):
        return 0.0
    return 1.0 / read_signed_length(text)


def read_ghost_pair(text: str) -> str:
    """“3-7”, “7 · 3”: the two surfaces that reflect a ghost, as 3-7; "" for all ghosts."""
    if not text.strip():
        return ""
    match = re.fullmatch(r"\s*(\d{1,4})\s*[-–·,]\s*(\d{1,4})\s*", text)
    if match is None or int(match[1]) == int(match[2]):
        raise ValueError(f"“{cut(text)}”: type two surfaces, numbered from 0 at the scene, such as 3-7")
    return "-".join(map(str, sorted(map(int, match.groups()))))


def read_aperture(text: str) -> float | None:
    """“2.8”, “f/2.8”; “open” for the widest aperture of the lens (None)."""
    return None if text.strip().lower() in ("open", "wide", "wide open") else read_f_number(text)


def read_position(text: str) -> tuple[float, float, float]:
    """“0,0.2,-1.5m”: x, y, z in the world, in metres where no unit is given."""
    words = text.split(",")
    if len(words) != 3:
        raise ValueError(f"“{cut(text)}”: type three distances with commas, such as 0,20cm,-1.5m")
    x, y, z = (read_distance(word) for word in words)
    return x, y, z


def read_part(text: str) -> float:
    """“25%”, “0.25”."""
    match = re.fullmatch(r"\s*(\d+\.?\d*|\.\d+)\s*(%?)\s*", text)
    if match is None:
        raise ValueError(f"“{cut(text)}”: type a part such as 25%")
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
        raise ValueError(f"“{cut(text)}”: type a whole number from 0 to {(1 << 32) - 1}")
    return int(text)


def read_iso(text: str) -> float:
    """“400”, “ISO 400”."""
    return read_number(r"(?:iso\s*)?#", text, "a speed such as ISO 400")[0]


def read_electrons(text: str) -> float:
    """“50000”, “50000 e”, “50k”."""
    number, unit = read_number(r"#\s*(k\s*e?|e)?", text, "electrons such as 50000")
    return number * (1000.0 if unit.startswith("k") else 1.0)


def read_time(text: str) -> float:
    """“1/125”, “0.5 s”, “20 ms”, “350 µs” in seconds; a bare number is in seconds."""
    reciprocal = re.fullmatch(r"\s*1\s*/\s*(\d+\.?\d*)\s*s?\s*", text)
    if reciprocal is not None and float(reciprocal[1]) > 0.0:
        return 1.0 / float(reciprocal[1])
    number, unit = read_number(r"#\s*(s|ms|µs|us|″|\")?", text, "a time such as 1/125 s, 20 ms or 2 s")
    return number * {"ms": 1e-3, "µs": 1e-6, "us": 1e-6}.get(unit, 1.0)


def read_percent(text: str) -> float:
    """“25 %”, “25” as a part of 1."""
    return read_number(r"#\s*%?", text, "a part such as 25 %")[0] / 100.0


def read_light(text: str) -> float:
    """“0.5”."""
    return read_number("#", text, "a radiance such as 0.5")[0]


def _whole(text: str, least: int) -> int:
    if not re.fullmatch(r"\s*\d{1,9}\s*", text) or int(text) < least:
        raise ValueError(f"“{cut(text)}”: type a whole number of at least {least}")
    return int(text)


def read_zoom(text: str) -> tuple[str, float]:
    """“0.4” from 0 (wide) to 1 (tele): ("part", 0.4); “105mm”, with its unit: ("length", 105.0)."""
    if re.search(r"[cm]m\s*$", text.lower()):
        return "length", read_length(text)
    return "part", _read_share(text, "0 (wide) to 1 (tele), or a focal length such as 105mm")


def read_close(text: str) -> float:
    """“0.5” from 0 (infinity) to 1 (the nearest position of the focus groups)."""
    return _read_share(text, "0 (infinity) to 1 (the nearest position)")


def _read_share(text: str, range_text: str) -> float:
    try:
        share = float(text.replace(",", "."))
    except ValueError:
        share = math.nan
    if not 0.0 <= share <= 1.0:
        raise ValueError(f"“{cut(text.strip())}”: type a number from {range_text}")
    return share
