"""Writer of Zemax files (.zmx); `zemax` and `zemax_system` describe the format."""

from dataclasses import replace
from math import degrees, inf, isinf

import numpy as np

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import Aperture, ApertureKind
from lensbench.lenses.formats import zemax_system
from lensbench.lenses.formats.zemax import EVEN_POWERS, GLASS_COMMENT, ODD_POWERS
from lensbench.lenses.glass import media
from lensbench.lenses.tables import stations as configurations
from lensbench.lenses.tables.axes import angles, axes_at, body, gap_on_axes, lead
from lensbench.lenses.tables.rows import radius_text
from lensbench.lenses.tables.stations import Station, placed, stations_of
from lensbench.lenses.tables.system_text import written_system

Row = tuple[str, int, list[float]]              # of the configurations: a quantity, its surface, its values
FAR_OBJECT = "1e10"                             # where a configuration gives the object distance
ROUNDING = 1e-9                                 # mm, by which a way differs from position to position and is the same


def write(lens: Lens) -> tuple[str, list[Finding]]:
    """Text of a .zmx file, and findings about what it cannot hold, other than shapes."""
    stations, remarks = stations_of(lens)
    lens = lens.at(zoom=0.0, close=0.0)
    aside = _moved_sideways(lens, stations)
    if aside is not None:
        stations, remarks = [], [note(Kind.POSITION, f"its zoom and focus positions are left out: surface {aside} is "
                                                     "tilted about one behind it, and the gap between them varies",
                                      aside)]
    lines = ["VERS 140000 0 0", "MODE SEQ", f"NAME {' '.join(lens.name.split())}"]
    lines += [f"NOTE 0 {' '.join(lens.notes.split())}"] if lens.notes.strip() else []
    system = written_system(lens, stations, lambda kind, distance: kind in zemax_system.HELD)
    remarks += system.findings
    makers = [maker for maker in dict.fromkeys(media.maker_of(surface.glass) for surface in lens.surfaces) if maker]
    lines += ["UNIT MM X W X CM MR CPMM", *([f"GCAT {' '.join(makers)}"] if makers else []),
              *zemax_system.lines(system.data, system.aperture or Aperture(ApertureKind.STOP_SIZE, (0.0,)))]
    ways, number_of = _ways(lens)
    distance = system.data.object_distances[0] + lead(lens, 0)
    lines += ["SURF 0", "  TYPE STANDARD", "  CURV 0", f"  DISZ {'INFINITY' if isinf(distance) else repr(distance)}"]
    number = 0
    for i, surface in enumerate(lens.surfaces):
        moved = body(lens, i)
        if moved and moved[0] == i:
            number += 1
            lines += [f"SURF {number}", *_break_lines(lens.vertex(i), axes_at(lens, i), ways[number])]
        number += 1
        lines.append(f"SURF {number}")
        if i == lens.stop_index:
            lines.append("  STOP")
        of = _surface_lines(replace(surface, thickness=ways[number]))
        lines += of
        glass = surface.glass
        is_found = media.is_known(glass, media.maker_among(glass.name, makers))
        remarks += media.glass_loss(glass, i, is_found=is_found)
        if glass.n_d != 1.0:
            name = " ".join(glass.name.split())
            is_known = is_found and name == glass.name and " " not in name
            if name and not is_known:                       # a model glass has no name
                lines.insert(-len(of), f"  COMM {GLASS_COMMENT}{name}")
            lines.append(f"  GLAS {name if is_known else '___BLANK'} {0 if is_known else 1} 0 {glass.n_d!r} "
                         f"{glass.v_d or 0.0!r} 0 0 0 0 0 0")
            if name != glass.name:
                remarks.append(note(Kind.GLASS, f"the name of the glass {glass.name!r} is written as {name!r}", i))
        lines.append(f"  DIAM {surface.semi_diameter!r} 1 0 0 1 \"\"")
        if moved and moved[1] == i:
            number += 1
            lines += [f"SURF {number}", *_break_lines(lens.vertex(moved[0]), axes_at(lens, i), ways[number], back=True)]
    lines += [f"SURF {number + 1}", "  TYPE STANDARD", "  CURV 0", "  DISZ 0",
              *_configuration_lines(lens, stations, system.aperture, number_of), ""]
    if lens.name != " ".join(lens.name.split()).strip('"') or lens.notes != " ".join(lens.notes.split()):
        remarks.append(note(Kind.TEXT, "name and notes are written in one line each"))
    remarks += configurations.lost_positions(stations, _plain)
    return "\n".join(lines), remarks


def _placed(lens: Lens, stations: list[Station]) -> list[Lens]:
    """The lens with the gaps of each position."""
    return [replace(lens, surfaces=tuple(placed(lens.surfaces, station))) for station in stations]


def _moved_sideways(lens: Lens, stations: list[Station]) -> int | None:
    """The first surface of a body whose vertex moves sideways, which no break with one decentre does; None: none."""
    if lens.is_centred:
        return None
    firsts = [i for i in range(len(lens.surfaces)) if (moved := body(lens, i)) and moved[0] == i]
    return next((i for placement in _placed(lens, stations) for i in firsts
                 if np.abs(placement.vertex(i) - lens.vertex(i))[:2].max() > ROUNDING), None)


def _ways(lens: Lens) -> tuple[dict[int, float], list[int]]:
    """Ways (mm) along the axes behind the surfaces and breaks of the file, and the number of each surface there."""
    ways: dict[int, float] = {}
    number_of = []
    for i, surface in enumerate(lens.surfaces):
        moved = body(lens, i)
        if moved and moved[0] == i:
            ways[len(ways) + 1] = 0.0
        number_of.append(len(ways) + 1)
        ways[len(ways) + 1] = gap_on_axes(lens, i)
        if moved and moved[1] == i:
            ways[len(ways) + 1] = (lens.vertices[i] + surface.thickness + lead(lens, i + 1)
                                   - float(lens.vertex(moved[0])[2]))
    return ways, number_of


def _configuration_lines(lens: Lens, stations: list[Station], aperture: Aperture | None,
                         number_of: list[int]) -> list[str]:
    """Lines of the configurations, one quantity after the other, as Zemax requires. number_of: surfaces in the file."""
    if not stations:
        return []
    lines = [f"MNUM {len(stations)} 1"]
    if any(station.name for station in stations):
        lines += [f'LTTL 0 {k} "{_plain(s.name)}" 0 0 0 1 1 0 0.0 "" 0' for k, s in enumerate(stations, start=1)]
    rows = configurations.rows(lens, stations, inf, aperture)
    if not lens.is_centred:
        rows = _along_axes(lens, stations, rows, number_of)
    for quantity, i, values in rows:
        name = {"stop": "SDIA", "gap": "THIC", "aperture": "APER"}[quantity]
        lines += [f'{name} {i} {k} {FAR_OBJECT if isinf(value) else repr(value)} 0 0 0 1 1 1 0 0 "" 0'
                  for k, value in enumerate(values, start=1)]
    return lines


def _along_axes(lens: Lens, stations: list[Station], rows: list[Row], number_of: list[int]) -> list[Row]:
    """The rows of the configurations by the numbers of the file, with all ways along its axes that vary."""
    placements = _placed(lens, stations)
    ways, leads = [_ways(lens)[0] for lens in placements], [lead(lens, 0) for lens in placements]
    rows_on_axes = [row for row in rows if row[0] == "aperture"]
    rows_on_axes += [("gap", k, values) for k in ways[0]
                     if np.ptp(values := [placement[k] for placement in ways]) > ROUNDING]
    rows_on_axes += [("gap", 0, [value + ahead for value, ahead in zip(values, leads, strict=True)])
                     for quantity, i, values in rows if quantity == "gap" and i == 0]
    return rows_on_axes + [("stop", number_of[i - 1], values) for quantity, i, values in rows if quantity == "stop"]


def _break_lines(vertex: np.ndarray, rotation: np.ndarray, distance: float, back: bool = False) -> list[str]:
    """Lines of a coordinate break onto the axis of a body with its first vertex there, or back from that vertex."""
    sign, order = (-1.0, 1) if back else (1.0, 0)
    values = [sign * float(vertex[0]), sign * float(vertex[1]), *(sign * degrees(a) for a in angles(rotation)), order]
    return ["  TYPE COORDBRK", "  CURV 0", *(f"  PARM {n} {v!r}" for n, v in enumerate(values, start=1)),
            f"  DISZ {distance!r}", "  DIAM 0 0 0 0 1 \"\""]


def _plain(text: str) -> str:
    return " ".join(text.replace('"', "'").split())


def _surface_lines(surface: Surface) -> list[str]:
    """Type, curvature, parameters, gap and conic of a surface."""
    terms = dict(surface.aspheric)
    if surface.curvature_x is not None:
        kind = "BICONICX"
        radius = radius_text(surface.curvature_x)
        values = [f"PARM 1 {'0' if radius == 'inf' else radius}"]
    elif not terms:
        kind, values = "STANDARD", []
    elif set(terms) <= set(EVEN_POWERS):
        kind, values = "EVENASPH", [f"PARM {p // 2} {terms[p]!r}" for p in EVEN_POWERS if p in terms]
    elif set(terms) <= set(ODD_POWERS):
        kind, values = "ODDASPHE", [f"PARM {p} {terms[p]!r}" for p in ODD_POWERS if p in terms]
    else:
        step = 1 if any(p % 2 for p in terms) else 2
        kind = "XODDASPH" if step == 1 else "XASPHERE"
        values = [f"XDAT 1 {max(terms) // step}", "XDAT 2 1"]
        values += [f"XDAT {p // step + 2} {a!r}" for p, a in terms.items()]
    lines = [f"  TYPE {kind}", f"  CURV {surface.curvature!r}", *(f"  {value}" for value in values),
             f"  DISZ {surface.thickness!r}"]
    return lines + ([f"  CONI {surface.conic!r}"] if surface.conic else [])
