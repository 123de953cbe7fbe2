"""System data: the aperture, fields, wavelengths and object distance that a lens was designed for.

Held as a lens file gives them, so that they can be written again: mm, degrees, µm.
"""

from dataclasses import dataclass, replace
from enum import StrEnum
from math import hypot, inf, isfinite

from lensbench.core.optics.glass import D_LINE
from lensbench.core.text import significant


class SystemDataError(ValueError):
    """Invalid system data; the message says why."""


class ApertureKind(StrEnum):
    """The quantity that a stated aperture fixes."""

    PUPIL_DIAMETER = "entrance-pupil diameter"
    F_NUMBER = "f-number"
    WORKING_F_NUMBER = "working f-number"
    OBJECT_NA = "object NA"
    IMAGE_NA = "image NA"
    STOP_SIZE = "stop size"


class FieldKind(StrEnum):
    """The quantity in which field points are stated."""

    ANGLE = "angle"
    OBJECT_HEIGHT = "object height"
    IMAGE_HEIGHT = "paraxial image height"
    REAL_IMAGE_HEIGHT = "real image height"


LARGEST_FIELD = 1e21    # mm: design programs give heights at an object "at infinity", 1e20 away
LENGTHS = {ApertureKind.PUPIL_DIAMETER, ApertureKind.STOP_SIZE}


@dataclass(frozen=True)
class Aperture:
    """An aperture as it was stated.

    Args:
        kind: The quantity that is fixed.
        values: One value for all zoom stations, or one a station: a diameter (mm), a number, a numerical aperture. For
            STOP_SIZE the semi-diameter of the stop (mm), or 0 where the rim in the table of surfaces says it.
    Raises:
        SystemDataError: For no value, or one that is negative or not finite, or 0 for another kind than STOP_SIZE.
    """

    kind: ApertureKind
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        least = 0.0 if self.kind is ApertureKind.STOP_SIZE else 5e-324
        if not self.values or not all(isfinite(value) and value >= least for value in self.values):
            raise SystemDataError(f"aperture: the {self.kind} must be one or more positive numbers")


@dataclass(frozen=True)
class FieldPoint:
    """A point of the field.

    Args:
        x, y: In the quantity and unit of `SystemData.field_kind`: degrees or mm.
        weight: In merit functions.
        vignetting: (4,) tuple of float. Shares of the pupil's half-width that are cut off at its +x, −x, +y and −y
            edge; negative beyond the pupil.
    Raises:
        SystemDataError: For a number that is not finite, a place beyond LARGEST_FIELD, or a negative weight.
    """

    x: float
    y: float
    weight: float = 1.0
    vignetting: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not all(map(isfinite, (self.x, self.y, self.weight, *self.vignetting))) or self.weight < 0.0:
            raise SystemDataError("field point: its place, weight and vignetting must be finite, its weight not "
                                  "negative")
        if not max(abs(self.x), abs(self.y)) <= LARGEST_FIELD:
            raise SystemDataError(f"field point ({significant(self.x)}, {significant(self.y)}): it must lie within "
                                  f"{significant(LARGEST_FIELD)}")


@dataclass(frozen=True)
class Wavelength:
    """A wavelength of a design and its weight.

    Args:
        micrometres: In air, µm.
        weight: In sums over the wavelengths.
    Raises:
        SystemDataError: For a wavelength that is not positive and finite, or a negative weight.
    """

    micrometres: float
    weight: float = 1.0

    def __post_init__(self) -> None:
        if not (0.0 < self.micrometres < inf and 0.0 <= self.weight < inf):
            raise SystemDataError(f"wavelength {significant(self.micrometres)} µm of weight "
                                  f"{significant(self.weight)}: it must be positive "
                                  "and finite, its weight not negative")


@dataclass(frozen=True)
class SystemData:
    """System data of one lens; what its file does not state stays at its default.

    Args:
        aperture: As it was stated.
        field_kind: Of all points of `fields`.
        fields: In the order of the file.
        wavelengths: In the order of the file.
        primary: Index of the primary wavelength, for which first-order data are stated.
        object_distances: Object → first vertex (mm), positive for a real object; inf for one at infinity. One for all
            zoom stations, or one a station.
    Raises:
        SystemDataError: For a primary wavelength that does not exist, or an object distance that is no number.
    """

    aperture: Aperture | None = None
    field_kind: FieldKind = FieldKind.ANGLE
    fields: tuple[FieldPoint, ...] = ()
    wavelengths: tuple[Wavelength, ...] = ()
    primary: int = 0
    object_distances: tuple[float, ...] = (inf,)

    def __post_init__(self) -> None:
        if not 0 <= self.primary < max(len(self.wavelengths), 1):
            raise SystemDataError(f"primary wavelength {self.primary}: there are {len(self.wavelengths)} wavelengths")
        if not self.object_distances or any(distance != distance for distance in self.object_distances):
            raise SystemDataError("object distance: it must be a number or inf")

    @property
    def primary_wavelength(self) -> float:
        """The primary wavelength (µm); the d line where no wavelength is stated."""
        return self.wavelengths[self.primary].micrometres if self.wavelengths else D_LINE

    @property
    def largest_field(self) -> float:
        """Greatest distance of a field point from the axis, in the unit of `field_kind`; 0 without fields."""
        return max((hypot(point.x, point.y) for point in self.fields), default=0.0)

    def scaled(self, factor: float) -> "SystemData":
        """The data of a lens scaled by a factor; angles, ratios and wavelengths stay."""
        aperture, fields = self.aperture, self.fields
        if aperture is not None and aperture.kind in LENGTHS:
            aperture = replace(aperture, values=tuple(value * factor for value in aperture.values))
        if self.field_kind is not FieldKind.ANGLE:
            fields = tuple(replace(point, x=point.x * factor, y=point.y * factor) for point in fields)
        return replace(self, aperture=aperture, fields=fields,
                       object_distances=tuple(distance * factor for distance in self.object_distances))
