"""Zoom and focus stations that disagree with the other stations, or with their own stated figures.

Each station is checked as a lens of its own, except the first, which the other checks cover. Lengths in mm.
"""

from dataclasses import replace
from math import isfinite

from lensbench.core.optics.finding import Change, Finding, Kind, note
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.zoom_positions import Positions
from lensbench.core.text import significant
from lensbench.lenses.checks.axial_beam import ray_findings
from lensbench.lenses.checks.figures import BACK_FOCUS, figure_findings
from lensbench.lenses.checks.geometry import geometry_findings
from lensbench.lenses.checks.hypotheses import stop_findings
from lensbench.lenses.tables.paraxial import FAR, object_distance

DISTANCE = 0.15         # of the stated one: engraved distances are nominal, of published lenses 1 m is 1.11 m
ROUNDING = 2e-5         # of the focal length: what sums of rounded gaps differ by
WITNESSES = 3           # stations that agree, against one that does not


def position_findings(lens: Lens) -> list[Finding]:
    """Findings about a zoom or focus station; each names the station."""
    positions = lens.positions
    if positions is None:
        return []
    findings = _film_gap(lens, positions)
    known = {(f.kind, f.surface) for f in geometry_findings(lens.at(zoom=0.0, close=0.0))}
    for i, zoom in enumerate(positions.zoom_stations):
        far = _figured(lens.at(zoom=zoom, close=0.0), first=i == 0)
        off = first_order(far).bfl - far.surfaces[-1].thickness
        for j, close in enumerate(positions.focus_stations):
            if i == j == 0:
                continue
            there = far.at(close=close)
            doubts = [f for f in geometry_findings(there) if (f.kind, f.surface) not in known]
            if j == 0:
                doubts += [*figure_findings(far), *ray_findings(far), *stop_findings(far)]
            else:
                doubts += _distance(there, off, positions.distances[i][j] if positions.distances else None)
            findings += [Finding(Kind.POSITION, f.surface, f"at {positions.label(i, j)}: {f.message}", f.proposal,
                                 f.severity, f.figures, f.change) for f in doubts]
    return findings + _odd_sums(lens, positions)


def _film_gap(lens: Lens, positions: Positions) -> list[Finding]:
    """Finding about a zoom in focus at its first station alone, whose gap before the film does not vary."""
    last = len(lens.surfaces) - 1
    if not positions.zooms or last in positions.gaps or not lens.surfaces[last].thickness > 0.0:
        return []
    stored = lens.surfaces[last].thickness
    stations = [first_order(lens.at(zoom=zoom, close=0.0)) for zoom in positions.zoom_stations]
    off = [abs(fo.bfl - stored) / abs(fo.efl) for fo in stations]
    if not (off[0] <= BACK_FOCUS < min(off[1:]) and all(isfinite(fo.bfl) and fo.bfl > 0.0 for fo in stations)):
        return []
    foci = ", ".join(significant(fo.bfl, 5) for fo in stations)
    return [Finding(
        Kind.POSITION, last, f"the gap before the film is {significant(stored, 5)} mm at every zoom position, which is "
                             "in focus at the first alone: the lens moves as a whole when it zooms, and the table does "
                             "not have this gap",
        f"gap behind surface {last} at the zoom positions: {foci} mm",
        figures={f"back_focus_{i}": fo.bfl for i, fo in enumerate(stations)},
        change=Change("thickness", last, stored, stations[-1].bfl))]


def _figured(lens: Lens, first: bool) -> Lens:
    """The lens without the figures that are stated for the first station alone."""
    positions = lens.positions
    assert positions is not None
    return lens if first else replace(
        lens, stated_efl=lens.stated_efl if positions.focal_lengths else None,
        stated_f_number=lens.stated_f_number if positions.f_numbers else None)


def _distance(lens: Lens, off: float, stated: float | None) -> list[Finding]:
    """Note about a near station whose focus is not at its stated distance.

    The stated one is often a catalogue's near limit, and the gaps those of a model: the lens itself is sound.
    off: distance from the stored film position to the focus at infinity, mm; the film is moved by it.
    """
    film = lens.surfaces[-1].thickness + off
    if not isfinite(film):                              # afocal: it has no focus
        return []
    surfaces = (*lens.surfaces[:-1], replace(lens.surfaces[-1], thickness=film))
    before = object_distance(surfaces)
    if not 0.0 < before < FAR:
        return [note(Kind.POSITION, "it is in focus no nearer than infinity")]
    distance = before + lens.length + film
    if stated is None or abs(distance / stated - 1.0) <= DISTANCE:
        return []
    return [note(Kind.POSITION, f"it is in focus at {significant(distance / 1000.0, 4)} m from the film, where "
                 f"{significant(stated / 1000.0)} m is stated", distance=distance, stated=stated)]


def _odd_sums(lens: Lens, positions: Positions) -> list[Finding]:
    """Finding about the one station whose sum of neighbouring gaps differs from all the others, or from infinity.

    Groups that move between two fixed ones leave the sum of their gaps constant; a wrong digit changes it.
    """
    rounding = ROUNDING * abs(first_order(lens).efl)
    count = len(positions.gaps)
    runs = [(start, start + size) for size in range(2, count + 1) for start in range(count - size + 1)]
    sums = {run: {(i, j): sum(gaps[run[0]:run[1]]) for i, row in enumerate(positions.thicknesses)
                  for j, gaps in enumerate(row)} for run in runs}
    for by_station, witnesses in ((True, WITNESSES), (False, WITNESSES - 1)):
        for run in runs:                                # the shortest one first: it names the fewest gaps
            values = sums[run]
            if not by_station:                          # the change by focusing: 0 at the other stations
                values = {(i, j): total - values[i, 0] for (i, j), total in values.items() if j}
            odd = _odd_one(values, rounding, witnesses)
            usual = next((value for key, value in values.items() if key != odd), 0.0)
            if odd is None or (not by_station and abs(usual) > rounding):
                continue
            total, others = sums[run][odd], "at the others" if by_station else "at infinity"
            behind = ", ".join(map(str, positions.gaps[run[0]:run[1]]))
            return [Finding(Kind.POSITION, None, f"at {positions.label(*odd)}: the gaps behind surfaces {behind} add "
                            f"up to {significant(total, 6)} mm, {others} to "
                            f"{significant(total - values[odd] + usual, 6)} mm")]
    return []


def _odd_one(values: dict[tuple[int, int], float], rounding: float, witnesses: int) -> tuple[int, int] | None:
    """The one key whose value differs from all the others, which agree; None if there is no such key."""
    for key in values if len(values) > witnesses else ():
        others = [value for other, value in values.items() if other != key]
        if max(others) - min(others) <= rounding:
            return key if abs(values[key] - others[0]) > 2.0 * rounding else None
    return None
