"""Fields and wavelengths of a user's choice, from text, for a query in place of those of the lens."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.analysis.grids.chief_rays import find_chief_rays
from lensbench.analysis.grids.field_conditions import Conditions, wanted_chief_rays
from lensbench.app.state.analysis.query import OWN, Query
from lensbench.kernels.figures import significant
from lensbench.optics.system import FieldKind

UNITS = {"deg": "°", "°": "°", "mm": "mm"}      # of fields; without one they are parts of the largest
DESIGN = "design"                       # the fields that the lens file states
MOST_FIELDS, MOST_COLOURS = 8, 12
NANOMETRES = 100.0                      # a smaller number is one of micrometres
STEEPEST = 90.0                         # degrees, of a field of an object plane at a finite distance


class OwnFields(NamedTuple):
    """Field points in the unit "°", "mm" (image heights) or "" (parts of the largest); none: those of the design."""

    values: tuple[float, ...] = ()
    unit: str = ""


def read_fields(text: str) -> OwnFields:
    """From "0,0.7,1", "0,14,20deg", "0,10,21.6mm" or "design"; ValueError with the reason."""
    if text.strip().lower() == DESIGN:
        return OwnFields()
    parts, unit = [part.strip() for part in text.split(",")], ""
    named = {UNITS[name] for part in parts for name in UNITS if part.endswith(name)}
    if len(named) > 1:
        raise ValueError(f"{text!r}: give all fields in one unit")
    if named:
        unit = named.pop()
        parts = [part.removesuffix("deg").removesuffix("°").removesuffix("mm").strip() for part in parts]
    values = _numbers(text, parts)
    if not 1 <= len(values) <= MOST_FIELDS or min(values) < 0.0 or not unit and max(values) > 1.0:
        raise ValueError(f"{text!r}: give 1 to {MOST_FIELDS} fields from 0: parts of the largest up to 1, such as "
                         "0,0.7,1, angles such as 0,14,20deg, image heights such as 0,10,21.6mm, or the word design")
    return OwnFields(values, unit)


def read_wavelengths(text: str) -> tuple[tuple[float, float], ...]:
    """Wavelengths (µm) and weights, from nanometres such as "486.1,587.6:2,656.3"; ValueError with the reason."""
    pairs = [part.partition(":") for part in text.split(",")]
    lines = _numbers(text, [line for line, _, _ in pairs])
    weights = _numbers(text, [weight if colon else "1" for _, colon, weight in pairs])
    if len(lines) > MOST_COLOURS:
        raise ValueError(f"{len(lines)} wavelengths: give 1 to {MOST_COLOURS}")
    if min(lines) <= 0.0 or min(weights) < 0.0 or not max(weights) > 0.0:
        raise ValueError(f"{text!r}: wavelengths must be positive, weights must not be negative, and one positive")
    if min(lines) < NANOMETRES:
        raise ValueError(f"{text!r}: give wavelengths in nanometres, such as 587.6")
    if len(set(lines)) < len(lines):
        raise ValueError(f"{text!r}: a wavelength is given twice")
    return tuple((round(line / 1000.0, 9), weight) for line, weight in zip(lines, weights, strict=True))


def with_own(query: Query, fields: OwnFields | None, wavelengths: tuple[tuple[float, float], ...] | None) -> Query:
    """The query with these fields and wavelengths (µm, weight); None keeps those of the query.

    LensError where the lens has no such field, and where its glasses are not known at such wavelengths.
    """
    if wavelengths is not None:
        if query.alone:
            raise lb.LensError(query.alone)
        query = replace(query, wavelengths=wavelengths, white=OWN)
    return query if fields is None else replace(query, heights=_heights(query, fields))


def _heights(query: Query, fields: OwnFields) -> tuple[float, ...] | tuple[tuple[float, float], ...]:
    """Image heights, or points (x, y) of the film (mm)."""
    if fields.values and not fields.unit:
        return query.parts(*fields.values)
    if fields.unit == "mm":
        return fields.values
    system, given = query.lens.system, query.conditions()
    if fields.values:
        kind, points = FieldKind.ANGLE, tuple((0.0, each) for each in fields.values)
        if math.isfinite(query.object_distance) and max(fields.values) >= STEEPEST:
            raise lb.LensError(f"a field of {significant(max(fields.values))}° lies beside every object plane: it "
                               "needs --focus inf")
    elif system.fields:
        kind, points = system.field_kind, tuple((each.x, each.y) for each in system.fields)
    else:
        raise lb.LensError("the file of this lens states no fields")
    asked = Conditions(kind, points, given.wavelengths, given.weights, given.primary, query.object_distance)
    wanted, by_image = wanted_chief_rays(query.lens, asked)
    images = find_chief_rays(query.lens, query.setup.film_distance, wanted, query.object_distance, by_image,
                             given.primary_wavelength).images
    for (x, y), image in zip(points, images, strict=True):
        if not np.isfinite(image).all():
            unit = "°" if kind is FieldKind.ANGLE else " mm"
            raise lb.LensError(f"field {significant(math.hypot(x, y), 4)}{unit}: no ray through the middle of the stop "
                               "reaches the film from there")
    if any(x for x, _ in points):
        return tuple((float(x), float(y)) for x, y in images)
    return tuple(float(math.hypot(x, y)) for x, y in images)


def _numbers(text: str, parts: list[str]) -> tuple[float, ...]:
    try:
        values = tuple(float(part) for part in parts)
    except ValueError:
        raise ValueError(f"{text!r}: give numbers, separated by commas") from None
    if not all(map(math.isfinite, values)):
        raise ValueError(f"{text!r}: give finite numbers")
    return values
