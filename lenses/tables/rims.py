"""Rims that a design file does not state, estimated from paraxial rays.

Lengths in the unit of the file. With y of the marginal ray of the stated aperture and ȳ of the chief ray of the largest
field, the semi-diameter is |y| + |ȳ|, and |y| at the stop. Vignetting factors narrow the beams of their fields; the
rims then let the widest of these beams pass.
"""

from collections.abc import Sequence
from math import hypot, inf, isfinite, radians, tan
from typing import Any

from lensbench.core.optics.system import FieldKind, SystemData
from lensbench.lenses.tables.aperture import axial_ray, stop_radius
from lensbench.lenses.tables.paraxial import FAR, index_of, ray

STEEPEST_FIELD = 60.0   # degrees: a steeper paraxial chief ray is meaningless
FULLEST = 0.98          # share of a hemisphere that an estimated rim covers at most


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
    found = []
    for point in system.fields:
        size = hypot(point.x, point.y)
        share = 0.0
        if size > 0.0:
            share = _slope(size) / _slope(largest) if is_angle else size / largest
        right, left, up, down = (1.0 - cut for cut in point.vignetting)
        x, y = sign * point.x, sign * point.y
        across_x, across_y = (right, left) if x >= 0.0 else (left, right), (up, down) if y >= 0.0 else (down, up)
        if point.x == 0.0:
            found.append((share, *across_y, max(across_x)))
        elif point.y == 0.0:
            found.append((share, *across_x, max(across_y)))
        else:
            along, against = map(max, across_x, across_y)
            found.append((share, along, against, max(along, against)))
    return found


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
