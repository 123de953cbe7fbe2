"""Field of view, focal length and film: each from the other two, and equivalent lenses on another film.

A field of view is that of a lens without distortion focused at infinity, 2 atan(h / 2f), in radians; lengths in mm.
"""

import math
from typing import NamedTuple

from lensbench.core.imaging.film import Film, FilmError
from lensbench.core.text import significant

FULL_FRAME = Film(36.0, 24.0)


class Equivalent(NamedTuple):
    """The lens that takes the same picture on another film.

    The field along the diagonal and the diameter of the aperture are the same, hence also the depth of field, the blur
    as a part of the picture, the diffraction and the light of the whole picture. For a point at infinity this is exact
    at any focus distance that is measured from the front focal point.

    Attributes:
        crop: Crop factor: the other film's diagonal over this one's.
        focal_length: mm.
        f_number: None if none was given.
        iso: Factor of the sensitivity for the same brightness at the same shutter time.
    """

    crop: float
    focal_length: float
    f_number: float | None
    iso: float


def field_of_view(focal_length: float, film: Film, axis: str = "diagonal") -> float:
    """Field of view of a lens without distortion, focused at infinity.

    Args:
        focal_length: mm; math.inf is allowed.
        film: The film.
        axis: {"shorter", "longer", "horizontal", "vertical", "diagonal"}. Along which side of the film.
    Returns:
        Radians.
    Raises:
        FilmError: For a focal length that is not positive, or another axis.
    """
    if not focal_length > 0.0:
        raise FilmError(f"focal length {significant(focal_length)}: it must be positive")
    return 2.0 * math.atan(film.extent(axis) / (2.0 * focal_length))


def focal_length(fov: float, film: Film, axis: str = "diagonal") -> float:
    """Focal length for a field of view.

    Args:
        fov: Radians, between 0 and π.
        film: The film.
        axis: {"shorter", "longer", "horizontal", "vertical", "diagonal"}. Along which side of the film.
    Returns:
        mm.
    Raises:
        FilmError: For another field of view or axis.
    """
    return film.extent(axis) / (2.0 * math.tan(_checked_fov(fov) / 2.0))


def film_extent(fov: float, focal_length: float) -> float:
    """Extent of a film for a field of view.

    Args:
        fov: Radians along this extent, between 0 and π.
        focal_length: mm.
    Returns:
        mm.
    Raises:
        FilmError: For another field of view, or a focal length that is not positive.
    """
    _check("focal length", focal_length)
    return 2.0 * focal_length * math.tan(_checked_fov(fov) / 2.0)


def equivalent(focal_length: float, film: Film, f_number: float | None = None, to: Film = FULL_FRAME) -> Equivalent:
    """Equivalent focal length and f-number on another film.

    Args:
        focal_length: mm, on `film`.
        film: The film.
        f_number: On `film`.
        to: The other film; by default 36 × 24 mm.
    Raises:
        FilmError: For a focal length or f-number that is not positive.
    """
    _check("focal length", focal_length)
    if f_number is not None:
        _check("f-number", f_number)
    crop = to.diagonal / film.diagonal
    return Equivalent(crop, focal_length * crop, None if f_number is None else f_number * crop, crop * crop)


def _check(name: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0.0):
        raise FilmError(f"{name} {significant(value)}: it must be a positive finite number")


def _checked_fov(fov: float) -> float:
    if not 0.0 < fov < math.pi:
        raise FilmError(f"field of view {significant(math.degrees(fov))}°: it must lie between 0° and 180°")
    return fov
