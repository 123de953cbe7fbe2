"""Field of view, focal length and film: each from the other two, and what stands for a lens on another film.

A field of view is that of a lens without distortion focused at infinity, 2 atan(h / 2f), in radians; lengths in mm.
"""

import math
from typing import NamedTuple

from lensbench.imaging.film import Film, FilmError

FULL_FRAME = Film(36.0, 24.0)


class Equivalent(NamedTuple):
    """What takes the same picture on another film.

    The field is the same along the diagonal; the aperture is as wide, so that the depth of field, the blur as a part
    of the picture, the diffraction and the light of the whole picture are the same too. Of a point
    at infinity that is exact for any focus that is measured from the front focal point.
    """

    crop: float                 # the other film's diagonal over this one's: the crop factor
    focal_length: float         # mm
    f_number: float | None      # None where none was given
    iso: float                  # what the sensitivity is multiplied by for the same brightness at the same time


def field_of_view(focal_length: float, film: Film, axis: str = "diagonal") -> float:
    """Radians along one of the film's AXES: 0 for a focal length of math.inf.

    FilmError for a focal length (mm) that is not positive, or another axis.
    """
    if not focal_length > 0.0:
        raise FilmError(f"focal length {focal_length:g}: it must be positive")
    return 2.0 * math.atan(film.extent(axis) / (2.0 * focal_length))


def focal_length(fov: float, film: Film, axis: str = "diagonal") -> float:
    """The focal length (mm) that sees fov (radians) along one of the film's AXES; FilmError unless 0 < fov < π."""
    return film.extent(axis) / (2.0 * math.tan(_checked_fov(fov) / 2.0))


def film_extent(fov: float, focal_length: float) -> float:
    """How far a film must reach (mm) for a lens of this focal length (mm) to see fov (radians) along it.

    FilmError unless 0 < fov < π and the focal length is positive.
    """
    _check("focal length", focal_length)
    return 2.0 * focal_length * math.tan(_checked_fov(fov) / 2.0)


def equivalent(focal_length: float, film: Film, f_number: float | None = None, to: Film = FULL_FRAME) -> Equivalent:
    """The focal length and f-number that take on `to` what these take on `film`: on 36 × 24 mm by default.

    FilmError for a focal length or f-number that is not positive.
    """
    _check("focal length", focal_length)
    if f_number is not None:
        _check("f-number", f_number)
    crop = to.diagonal / film.diagonal
    return Equivalent(crop, focal_length * crop, None if f_number is None else f_number * crop, crop * crop)


def _check(name: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise FilmError(f"{name} {value:g}: it must be a positive finite number")


def _checked_fov(fov: float) -> float:
    if not 0.0 < fov < math.pi:
        raise FilmError(f"field of view {math.degrees(fov):g}°: it must lie between 0° and 180°")
    return fov
