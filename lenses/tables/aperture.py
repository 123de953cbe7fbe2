"""Size of the stop by the aperture that a design file states, and clear apertures that it does not state.

Lengths in mm, or in the unit of a file. Object distances count from the object to the first vertex; inf: at infinity.
The medium in front of the lens is air.

The stated aperture of a design file sizes the stop. The clear aperture that the file has for the stop's surface is
kept where both agree, and named by a finding where they do not. Clear apertures that are missing are estimated from
paraxial rays: with y of the marginal ray of the stated aperture and ȳ of the chief ray of the largest field, the
semi-diameter is |y| + |ȳ|, and |y| at the stop. Vignetting factors narrow the beams of their fields; the clear
apertures then pass the widest of these beams.
"""

from collections.abc import Sequence
from dataclasses import replace
from math import asin, hypot, inf, isfinite, radians, sqrt, tan
from typing import Any

from lensbench.core.optics.finding import Finding, Kind, note
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LensError, Surface
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import Fate, trace
from lensbench.core.optics.system import ApertureKind, FieldKind, SystemData
from lensbench.core.text import significant
from lensbench.lenses.file_error import RowError
from lensbench.lenses.tables.paraxial import FAR, index_of, ray
from lensbench.lenses.tables.rows import WIDEST_STOP, check_sizes, widest_other
from lensbench.lenses.tables.stations import Station, placed

SAME = 1e-7             # share of a radius: rounding of a stop that is written and read again
PRINTED = 2e-4          # share of a radius: rounding of a clear aperture in a file
STEEPEST_FIELD = 60.0   # degrees: a steeper paraxial chief ray is meaningless
FULLEST = 0.98          # share of a hemisphere that an estimated clear aperture covers at most


def axial_ray(surfaces: Sequence[Any], distance: float,
              wavelength: float = D_LINE) -> tuple[list[float], float, float]:
    """Ray from the axis point of the object: heights at the surfaces, slope in front of them and slope behind them.

    Its height at the first surface is 1; from an object on that surface, its slope is 1.
    """
    if abs(distance) >= FAR:
        height, slope = 1.0, 0.0
    else:
        height, slope = (1.0, 1.0 / distance) if distance else (0.0, 1.0)
    heights, behind = ray(surfaces, height, slope, wavelength)
    return heights, slope, behind


def stop_radius(surfaces: Sequence[Any], stop: int, kind: ApertureKind, value: float, distance: float,
                wavelength: float = D_LINE) -> float | None:
    """Radius of the stop that an aperture asks for, in the unit of the surfaces (of a lens, or rows of a file).

    value: as in `Aperture.values`. distance: object → first vertex; inf for an object at infinity. wavelength: µm. None
    where no stop has this aperture: an object at infinity has no numerical aperture, an afocal lens no f-number, a stop
    in the front focus of what is before it no entrance pupil.
    """
    try:
        radius = _stop_radius(surfaces, stop, kind, value, distance, wavelength)
    except (ArithmeticError, ValueError):
        return None
    return radius if isfinite(radius) and radius > 0.0 else None


def _stop_radius(surfaces: Sequence[Any], stop: int, kind: ApertureKind, value: float, distance: float,
                 wavelength: float) -> float:
    if kind is ApertureKind.STOP_SIZE:
        return value
    index = index_of(surfaces[-1].glass, wavelength)
    parallel, power_slope = ray(surfaces, 1.0, 0.0, wavelength)
    # The stop is an image of the entrance pupil, and parallel[stop] its magnification
    if kind is ApertureKind.PUPIL_DIAMETER:
        return 0.5 * value * abs(parallel[stop])
    if kind is ApertureKind.F_NUMBER:
        return 0.5 / (index * abs(power_slope)) / value * abs(parallel[stop])
    heights, front, behind = axial_ray(surfaces, distance, wavelength)
    if kind is ApertureKind.OBJECT_NA:
        slope, own = tan(asin(value)), front
        if all(isinstance(surface, Surface) for surface in surfaces) and own:
            return _real_height(surfaces, stop, value, distance, wavelength)
    elif kind is ApertureKind.IMAGE_NA:
        slope, own = tan(asin(value / index)), behind
    else:
        slope, own = 0.5 / (value * index), behind
    return slope / abs(own) * abs(heights[stop])


def f_number_kind(distance: float) -> ApertureKind:
    """Kind of the f-number of programs that state the working one; for an object at infinity both are the same."""
    return ApertureKind.F_NUMBER if abs(distance) >= FAR else ApertureKind.WORKING_F_NUMBER


def pupil_diameter(surfaces: Sequence[Any], stop: int, radius: float, wavelength: float = D_LINE) -> float:
    """Paraxial diameter of the entrance pupil; inf if the stop lies in the front focus of what is before it.

    radius: of the stop. wavelength: µm.
    """
    height = abs(ray(surfaces, 1.0, 0.0, wavelength)[0][stop])
    return 2.0 * radius / height if height else inf


def _real_height(surfaces: Sequence[Surface], stop: int, na: float, distance: float, wavelength: float) -> float:
    """Height at the stop of the real axial ray of a numerical aperture; NaN if it does not reach the stop.

    Beyond an aperture of 0.3 the paraxial height is several per cent off.
    """
    cosine = sqrt(1.0 - na * na)
    if not cosine:
        return inf
    tangent = na / cosine
    before = distance + 1.0                         # so that the ray begins in front of an object that touches the lens
    rays = trace(Lens(tuple(surfaces[:stop + 1]), stop), [0.0, -tangent * (before - distance), -before],
                 [0.0, na, cosine], wavelength=wavelength, clip=False, forward=True)
    reached = rays.surface[0] == stop and rays.fate[0] != Fate.MISSED
    return hypot(*rays.points[0, :2]) if reached else inf


def with_stated_aperture(lens: Lens, stations: list[Station],
                         wavelength: float) -> tuple[Lens, list[Station], list[Finding]]:
    """The lens and its configurations, each with the stop of its stated aperture; wavelength (µm): of paraxial rays.

    A configuration may state an aperture of its own, of the same kind. The findings name both sizes where the stop's
    clear aperture in the file contradicts the stated aperture.
    """
    aperture, stop = lens.system.aperture, lens.stop_index
    if aperture is None or (
            aperture.kind is ApertureKind.STOP_SIZE and not aperture.values[0]
            and not any(station.aperture for station in stations)):
        return lens, stations, []
    findings: list[Finding] = []

    def sized(surfaces: Sequence[Surface], value: float, distance: float, rim: float) -> float:
        """Radius of the stop by the aperture; the rim where both agree, and where no stop has this aperture."""
        if aperture.kind is ApertureKind.STOP_SIZE and not value:
            return rim
        asked = stop_radius(surfaces, stop, aperture.kind, value, distance, wavelength)
        if asked is not None and asked > WIDEST_STOP * widest_other(surfaces, stop):
            asked = None
        stated = f"the stated {aperture.kind}, {significant(value, 6)},"
        try:
            if asked is not None:
                check_sizes(replace(surfaces[stop], semi_diameter=asked))
        except (RowError, LensError, ArithmeticError):
            asked = None
        if asked is None:
            findings.append(Finding(Kind.STOP_SIZE, stop, f"{stated} fits no stop of this lens: the "
                                                          f"semi-diameter in the file, {significant(rim, 5)} mm, is "
                                                          "kept"))
            return rim
        if abs(asked - rim) <= SAME * rim:
            return rim
        if abs(asked - rim) > PRINTED * rim:
            findings.append(note(Kind.STOP_SIZE, f"{stated} sizes the stop: its semi-diameter is "
                                                 f"{significant(asked, 5)} mm, instead of the {significant(rim, 5)} mm "
                                                 "of its clear aperture in the file", stop, aperture=asked, rim=rim))
        return asked

    rim, value = lens.stop.semi_diameter, aperture.values[0]
    radius = sized(lens.surfaces, value, lens.system.object_distances[0], rim)
    surfaces = list(lens.surfaces)
    surfaces[stop] = replace(lens.stop, semi_diameter=radius)
    made = []
    for station in stations:
        moved = placed(lens.surfaces, station)
        size = sized(moved, value if station.aperture is None else station.aperture, station.distance,
                     rim if station.stop is None else station.stop)
        made.append(replace(station, stop=station.stop if size == radius and station.stop is None else size))
    return replace(lens, surfaces=tuple(surfaces)), made, findings[:1]     # the positions repeat it


def estimate_rims(surfaces: Sequence[Any], stop: int, stop_is_marked: bool, system: SystemData, distance: float,
                  wavelength: float) -> bool:
    """Fill the missing semi-diameters of the rows of a file, and return whether that is possible.

    surfaces: without the object and the image. stop_is_marked: whether the file states this stop; otherwise its clear
    aperture has to pass the field too. system: in the unit of the file. distance: object → first vertex. wavelength:
    µm. Nothing is filled if neither the aperture nor another clear aperture gives the width of the marginal ray.
    """
    try:
        marginal = marginal_heights(surfaces, stop, system, distance, wavelength)
        chief = chief_heights(surfaces, stop, system, distance, wavelength)
    except (ArithmeticError, ValueError):
        return False
    if not marginal:
        return False
    beams = _beams(system)
    for i, row in enumerate(surfaces):
        if row.semi_diameter is not None:
            continue
        y = abs(marginal[i])
        if not (stop_is_marked and i == stop):
            y = max([y, *(_reach(marginal[i], chief[i], beam) for beam in beams)])
        bend = (1.0 + row.conic) * row.curvature * row.curvature
        if bend > 0.0:
            y = min(y, FULLEST / bend ** 0.5)
        row.semi_diameter = y if isfinite(y) and y > 1e-9 else max(map(abs, marginal))
    return True


def _beams(system: SystemData) -> list[tuple[float, float, float, float]]:
    """Each field as the part of its chief ray's slope in that of the largest field, and three open parts of the pupil.

    They are of its half-width at the edge that this slope, in front of the lens, points to, at the other edge, and
    across. The light of an object above the axis falls, that of an image above it rises.
    """
    largest, is_angle = system.largest_field, system.field_kind is FieldKind.ANGLE
    sign = -1.0 if system.field_kind is FieldKind.OBJECT_HEIGHT else 1.0
    beams = []
    for point in system.fields:
        size = hypot(point.x, point.y)
        share = 0.0
        if size > 0.0:
            share = _slope(size) / _slope(largest) if is_angle else size / largest
        right, left, up, down = (1.0 - cut for cut in point.vignetting)
        x, y = sign * point.x, sign * point.y
        across_x, across_y = (right, left) if x >= 0.0 else (left, right), (up, down) if y >= 0.0 else (down, up)
        if point.x == 0.0:
            beams.append((share, *across_y, max(across_x)))
        elif point.y == 0.0:
            beams.append((share, *across_x, max(across_y)))
        else:
            along, against = map(max, across_x, across_y)
            beams.append((share, along, against, max(along, against)))
    return beams


def _reach(y: float, y_bar: float, beam: tuple[float, float, float, float]) -> float:
    """Greatest height of a beam of `_beams` on a surface; y, ȳ: of the marginal and of the largest chief ray there."""
    share, along, against, across = beam
    return max(abs(share * y_bar + along * y), abs(share * y_bar - against * y), hypot(share * y_bar, across * y))


def _slope(degrees: float) -> float:
    return tan(radians(min(degrees, STEEPEST_FIELD)))


def marginal_heights(surfaces: Sequence[Any], stop: int, system: SystemData, distance: float,
                     wavelength: float) -> list[float]:
    """Heights of the paraxial marginal ray at the surfaces; empty if the aperture is not known."""
    heights, _, _ = axial_ray(surfaces, distance, wavelength)
    radius = None
    if system.aperture is not None:
        radius = stop_radius(surfaces, stop, system.aperture.kind, system.aperture.values[0], distance, wavelength)
    radius = radius or surfaces[stop].semi_diameter
    if radius is not None and heights[stop]:
        scale = radius / abs(heights[stop])
    else:
        scale = min((row.semi_diameter / abs(y) for row, y in zip(surfaces, heights, strict=True)
                     if row.semi_diameter is not None and y), default=0.0)
    return [scale * y for y in heights] if 0.0 < scale < inf else []


def chief_heights(surfaces: Sequence[Any], stop: int, system: SystemData, distance: float,
                  wavelength: float) -> list[float]:
    """Heights of the paraxial chief ray of the largest field at the surfaces; zeros if no field is stated."""
    parallel, power_slope = ray(surfaces, 1.0, 0.0, wavelength)
    tilted, _ = ray(surfaces, 0.0, 1.0, wavelength)
    pupil = tilted[stop] / parallel[stop] if parallel[stop] else 0.0            # entrance pupil, from the first vertex
    through_stop = [b - pupil * a for a, b in zip(parallel, tilted, strict=True)]       # slope 1 in front of the lens
    size, at_infinity, slope = system.largest_field, abs(distance) >= FAR, 0.0
    behind_index = index_of(surfaces[-1].glass, wavelength)
    if system.field_kind is FieldKind.ANGLE:
        slope = _slope(size)
    elif at_infinity:
        if system.field_kind is not FieldKind.OBJECT_HEIGHT and power_slope:
            slope = size * behind_index * abs(power_slope)
    else:
        if system.field_kind is not FieldKind.OBJECT_HEIGHT:                    # a height in the image
            _, front, behind = axial_ray(surfaces, distance, wavelength)
            size *= abs(behind / front) * behind_index if front else 0.0
        slope = size / abs(distance + pupil) if distance + pupil else 0.0
    return [slope * y for y in through_stop]
