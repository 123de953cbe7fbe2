"""Solves and pickups of a design file: a curvature or thickness that follows from a ray, or from another surface.

Lengths are in the unit of the file, slopes are dy/dz. OSLO writes the solve instead of the value, so that a reader has
to solve it (`apply`). Zemax and CODE V write the solved value beside it, so that a reader can check it (`doubts`).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import asin, inf, isfinite, radians, tan
from typing import Any

from lensbench.core.optics.finding import Finding, Kind, Severity
from lensbench.core.optics.lens_surface import LensError, Surface
from lensbench.core.optics.system import ApertureKind, FieldKind, SystemData
from lensbench.core.text import significant
from lensbench.lenses.file_error import RowError
from lensbench.lenses.tables.aperture import marginal_heights
from lensbench.lenses.tables.paraxial import FAR, index_of, ray

SAME = 1e-3             # share of a value: programs differ by their glass data
RAYS = ("axial slope", "chief slope", "axial height", "chief height")
Start = tuple[float, float]         # height of a ray on the first surface, and its slope in front of it


@dataclass(frozen=True)
class RowSolve:
    """A quantity of a row that follows from others.

    row: from 0, the object. quantity: "curvature", "thickness" or "conic". rule: "axial slope" or "chief slope" behind
    the surface, "axial height" or "chief height" on the next surface, "edge" (both surfaces touch at this distance from
    the axis), "pickup" (factor × that of row `source`, plus the value; end: the row behind the last one that it adds
    up, 0 for that of `source` alone), "sum" (with the thicknesses from `source` on; "pair": with that of `source`
    alone). Any other word is a rule that cannot be checked. value: the slope, height, distance, offset or sum. name:
    the keyword in the file.
    """

    row: int
    quantity: str
    rule: str
    value: float
    name: str
    source: int = 0
    factor: float = 1.0
    end: int = 0


def solution(rows: Sequence[Any], solve: RowSolve, axial: Start | None, chief: Start | None,
             wavelength: float) -> float:
    """The value that a solve of a row between object and image asks for; the rays are paraxial, None: not known.

    RowError: no value has this property, or the ray is not known.
    """
    i, value, row = solve.row, solve.value, rows[solve.row]
    if solve.rule == "pickup":
        sources = rows[solve.source:solve.end or solve.source + 1]
        return solve.factor * sum(float(getattr(row, solve.quantity)) for row in sources) + value
    if solve.rule == "sum":
        return value - sum(float(row.thickness) for row in rows[solve.source:i])
    if solve.rule == "pair":
        return value - float(rows[solve.source].thickness)
    if solve.rule == "edge":
        return _sag(row, value) - _sag(rows[i + 1], value)
    if solve.rule not in RAYS:
        raise RowError(f"{solve.name}: a solve of this kind is not known")
    start = axial if solve.rule.startswith("axial") else chief
    if start is None:
        raise RowError(f"{solve.name}: the {solve.rule.split()[0]} ray is not known in front of the surface")
    heights, slope = ray(rows[1:i], *start, wavelength, index_of(rows[0].glass, wavelength))
    height = heights[-1] + slope * rows[i - 1].thickness if heights else start[0]
    before, after = index_of(rows[i - 1].glass, wavelength), index_of(row.glass, wavelength)
    try:
        if solve.quantity == "curvature":
            bend = (before * slope - after * value) / (height * (after - before))
            return float(bend - row.vertex_curvature + row.curvature)
        behind = (before * slope - height * row.vertex_curvature * (after - before)) / after
        return float((value - height) / behind)
    except ZeroDivisionError:
        raise RowError(f"{solve.name}: no {solve.quantity} has this solution") from None


def _sag(row: Any, height: float) -> float:
    """Sag of the surface of a row; 0 for a plane. RowError: the surface ends before."""
    try:
        surface = Surface(0.0, abs(height) or 1.0, curvature=row.curvature, conic=row.conic,
                          aspheric=tuple(row.aspheric.items()))
        depth = float(surface.sag(0.0, height))
    except LensError as error:
        raise RowError(str(error)) from None
    if not isfinite(depth):
        raise RowError(f"the surface ends before the edge, {significant(height)} from the axis")
    return depth


def apply(rows: Sequence[Any], solves: Sequence[RowSolve], system: SystemData, stop: int, beam: float | None,
          wavelength: float) -> None:
    """Give the rows the values of their solves, from the object on, the curvature of a surface before its thickness.

    system: with the object's distance. stop: row of the stop. beam: radius of the axial beam on the first surface, or
    None. RowError: a solve without a solution, or of a ray that only later surfaces fix.
    """
    distance = rows[0].thickness
    axial = None if beam is None else (beam, 0.0 if abs(distance) >= FAR else beam / distance)
    bent = {solve.row for solve in solves if solve.quantity == "curvature"}
    for solve in sorted(solves, key=lambda solve: (solve.row, solve.quantity)):
        chief = chief_ray(rows, stop, system, wavelength) if solve.row >= stop else None
        if solve.rule == "edge" and solve.row + 1 in bent:
            raise RowError(f"SRF {solve.row}, {solve.name}: the curvature of the next surface is solved, too")
        value = solution(rows, solve, axial, chief, wavelength)
        if not isfinite(value):
            raise RowError(f"SRF {solve.row}, {solve.name}: no {solve.quantity} has this solution")
        setattr(rows[solve.row], solve.quantity, value)


def chief_ray(rows: Sequence[Any], stop: int, system: SystemData, wavelength: float) -> Start | None:
    """The paraxial ray of the largest field through the centre of the stop; None for fields by heights in the image."""
    distance, size = rows[0].thickness, max((point.y for point in system.fields), key=abs, default=0.0)
    parallel, tilted = (ray(rows[1:stop + 1], *start, wavelength)[0][-1] for start in ((1.0, 0.0), (0.0, 1.0)))
    if not parallel:
        return None
    pupil = tilted / parallel
    if system.field_kind is FieldKind.ANGLE:
        slope = tan(radians(max(-89.0, min(89.0, size))))
    elif system.field_kind is FieldKind.OBJECT_HEIGHT and abs(distance) < inf and distance + pupil:
        slope = -size / (distance + pupil)
    else:
        return None
    return -pupil * slope, slope


def beam_radius(system: SystemData, distance: float) -> float | None:
    """Radius of the axial beam on the first surface by OSLO's aperture; None where later surfaces fix it."""
    aperture = system.aperture
    if aperture is not None and aperture.kind is ApertureKind.PUPIL_DIAMETER:
        return aperture.values[0] / 2.0
    if aperture is not None and aperture.kind is ApertureKind.OBJECT_NA and aperture.values[0] < 1.0:
        return tan(asin(aperture.values[0])) * distance
    return None


def doubts(rows: Sequence[Any], solves: Sequence[RowSolve], system: SystemData, stop: int,
           wavelength: float) -> list[Finding]:
    """Findings about stored values that are not those of their solves; stop: row of the stop."""
    findings, body, distance = [], rows[1:-1], rows[0].thickness
    try:
        in_air = rows[0].glass.n_d == 1.0
        heights = marginal_heights(body, stop - 1, system, distance, wavelength) if in_air else []
        chief = chief_ray(rows, stop, system, wavelength) if in_air else None
    except (ArithmeticError, ValueError):
        heights, chief = [], None
    y = heights[0] if heights else 1.0          # for a height of 0 any ray on the axis will do
    axial = (y, 0.0 if abs(distance) >= FAR or not distance else y / distance)
    for solve in solves:
        kept = float(getattr(rows[solve.row], solve.quantity))
        known = bool(heights) or solve.value == 0.0 and solve.quantity == "thickness"
        try:
            asked = solution(rows, solve, axial if known else None, chief, wavelength)
        except (RowError, ArithmeticError):
            asked = inf
        what = f"the {solve.quantity} of surface {solve.row - 1} follows from a solve ({solve.name})"
        if not isfinite(asked):
            findings.append(Finding(Kind.UNSOLVED, solve.row - 1, f"{what} that cannot be checked: the value of the "
                                    f"file, {significant(kept)}, is read", severity=Severity.NOTE))
        elif abs(asked - kept) > SAME * max(abs(asked), abs(kept)):
            findings.append(Finding(Kind.UNSOLVED, solve.row - 1, f"{what}: it is {significant(asked, 6)}, and not the "
                                    f"{significant(kept, 6)} of the file, which is read", figures={"solved": asked,
                                                                                                   "stored": kept}))
    return findings
