"""The zoom of a lens by its focal length, as its dial is engraved, and the figures of its stations.

Lengths in mm; focal lengths are those at infinity.
"""

import argparse
from functools import lru_cache
from math import inf
from typing import Any

import lensbench as lb
from lensbench.app.settings.text_values import format_distance
from lensbench.core.kernels.numeric import find_root
from lensbench.core.text import f_number_text, fixed, significant

SAMPLES = 33            # of the focal length along the dial, to find it again
ROUNDING = 1e-13        # of a focal length
ENGRAVED = 1e-3         # of a focal length: one that is so near to that of a station names the station


def positioned(lens: lb.Lens, arguments: argparse.Namespace) -> lb.Lens:
    """The lens at the zoom and focus positions of the options --zoom and --close."""
    return lens.at(asked_zoom(lens, arguments.zoom), arguments.close)


def stations(lens: lb.Lens) -> list[dict[str, Any]]:
    """Figures of the lens at each of its stations; an empty list for a lens without stations.

    in_focus: focus distance (mm from the film) at the back focus of the file. stated_efl, stated_distance: as the file
    states them.
    """
    positions, rows = lens.positions, []
    if positions is None:
        return []
    wavelength = lens.reference_wavelength
    for i, zoom in enumerate(positions.zoom_stations):
        for j, close in enumerate(positions.focus_stations):
            far, there = lens.at(zoom=zoom, close=0.0), lens.at(zoom=zoom, close=close)
            fo, film = lb.first_order(there, wavelength), there.surfaces[-1].thickness
            off = lb.first_order(far).bfl - far.surfaces[-1].thickness
            rows.append({
                "name": positions.label(i, j), "zoom": zoom, "close": close, "efl": fo.efl,
                "f_number": fo.f_number if close == 0.0 else None,      # which counts at infinity
                "length": there.length, "back_focus": film, "in_focus": lb.focused_distance(there, film + off),
                "stated_efl": positions.focal_lengths[i] if positions.focal_lengths else None,
                "stated_distance": positions.distances[i][j] if positions.distances else None})
    return rows


def station_lines(figures: list[dict[str, Any]]) -> list[str]:
    """The stations as a table."""
    rows = [("Positions", "EFL", "f-number", "Length", "Back focus", "In focus at")]
    rows += [(f"  {row['name']}", f"{fixed(row['efl'], 3)} mm",
              "" if row["f_number"] is None else f_number_text(row["f_number"], 2), f"{fixed(row['length'], 3)} mm",
              f"{fixed(row['back_focus'], 3)} mm", format_distance(row["in_focus"])) for row in figures]
    widths = [max(len(row[k]) for row in rows) for k in range(6)]
    return ["   ".join([row[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(row[1:], widths[1:],
                                                                                           strict=True))])
            for row in rows] if figures else []


def asked_zoom(lens: lb.Lens, asked: tuple[str, float] | None) -> float | None:
    """The zoom (0 to 1) that `read_zoom` read, for this lens; None: none was asked for. LensError: out of its reach."""
    if asked is None:
        return None
    kind, value = asked
    if kind == "part" or not lens.zooms:
        lens.at(zoom=value)                     # raises where it cannot be
        return value
    if not is_engraved(lens):
        raise lb.LensError(f"zoom to {significant(value)} mm: the focal length of this lens does not grow as it zooms; "
                           "give a number from 0 to 1")
    shortest, longest = focal_length(lens, 0.0), focal_length(lens, 1.0)
    if not shortest * (1.0 - 5e-3) <= value <= longest * (1.0 + 5e-3):      # engraved ends are rounded
        raise lb.LensError(f"zoom to {significant(value)} mm: this lens zooms from {significant(shortest, 4)} to "
                           f"{significant(longest, 4)} mm")
    return engraved_zoom(lens, value)


@lru_cache(maxsize=256)
def focal_length(lens: lb.Lens, zoom: float) -> float:
    """Of the lens at a zoom setting, focused at infinity, at the primary wavelength of its design."""
    return lb.first_order(lens.at(zoom=zoom, close=0.0)).efl


def is_engraved(lens: lb.Lens) -> bool:
    """Whether focal lengths name zoom positions: positive, finite, growing. An edited lens may diverge half-way."""
    assert lens.positions is not None
    lengths = [focal_length(lens, zoom) for zoom in lens.positions.zoom_stations]
    return 0.0 < min(lengths) and max(lengths) < inf and lengths[0] < lengths[-1]


@lru_cache(maxsize=256)
def zoom_of(lens: lb.Lens, length: float) -> float:
    """The zoom setting of a focal length, the nearest end for one beyond it; of a lens that `is_engraved`."""
    curve = _curve(lens)
    if length <= curve[0]:
        return 0.0
    if length >= curve[-1]:
        return 1.0
    i = next(i for i in range(SAMPLES - 1) if (curve[i] - length) * (curve[i + 1] - length) <= 0.0)
    low, high, rising = i / (SAMPLES - 1), (i + 1) / (SAMPLES - 1), curve[i + 1] >= curve[i]
    sign = 1.0 if rising else -1.0
    return find_root(lambda zoom: sign * (focal_length(lens, zoom) - length), low, high,
                ROUNDING * length)


def engraved_zoom(lens: lb.Lens, length: float) -> float:
    """As `zoom_of`, but the station itself for its focal length as people read it: its gaps are edited there."""
    assert lens.positions is not None
    near = min(lens.positions.zoom_stations, key=lambda zoom: abs(focal_length(lens, zoom) - length))
    return near if abs(focal_length(lens, near) - length) <= ENGRAVED * length else zoom_of(lens, length)


@lru_cache(maxsize=16)
def _curve(lens: lb.Lens) -> tuple[float, ...]:
    return tuple(focal_length(lens, i / (SAMPLES - 1)) for i in range(SAMPLES))

