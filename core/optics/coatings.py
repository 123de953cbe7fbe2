"""Coatings of surfaces: reflectance of thin layers by the characteristic matrix, or from a table.

Wavelengths in µm. Layers are listed from the side of the smaller index (the air) to that of the larger one, so that a
coating is the same for light from either side: without absorption, both directions reflect the same part at angles that
Snell's law connects. R + T = 1 everywhere.

References:
    Macleod, "Thin-Film Optical Filters", ch. 2; Born and Wolf, "Principles of Optics", § 1.6.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.optics.glass import D_LINE
from lensbench.core.text import significant

MGF2 = 1.38             # magnesium fluoride
HALF_WAVE = 2.05        # zirconium dioxide, the middle of three layers
DESIGN_WAVELENGTH = 0.55
MOST_LAYERS = 200


class CoatingError(ValueError):
    """An invalid coating; the message says what to do."""


class Reflectance(NamedTuple):
    """Reflected parts of light, from `Coating.reflectance`.

    Args:
        s, p: From 0 to 1, of light polarised across (s) and in (p) the plane of incidence.
    """

    s: np.ndarray
    p: np.ndarray

    @property
    def mean(self) -> np.ndarray:
        """Of unpolarised light."""
        return 0.5 * (self.s + self.p)


class Layer(NamedTuple):
    """A thin layer of a coating.

    Args:
        n: Refractive index. None: n₁ √(n / n₀) for the glass n that is coated in a medium n₀, n₁ the first layer; this
            makes the reflectance of a quarter, half and quarter wave zero at the design wavelength, whatever the glass.
        waves: Optical thickness n d, in waves of the coating's design wavelength.
    """

    n: float | None
    waves: float


@dataclass(frozen=True)
class Coating:
    """A coating of one surface: thin layers without absorption, or a table of reflectance.

    Args:
        layers: From the side of the smaller index on; none for bare glass, which reflects by Fresnel's formulas.
        wavelength: Design wavelength (µm), in whose waves the thickness of the layers counts.
        wavelengths: Of a table, rising (µm); () for layers.
        angles: Of a table, rising: angle of incidence on the side of the smaller index (radians).
        reflectances: Of a table: a row for each wavelength, a value from 0 to 1 for each angle. Between entries it is
            interpolated linearly, and beyond them it keeps the nearest value; both polarisations have it.
    Raises:
        CoatingError: For layers that are not of positive thickness and an index of at least 1, or a table that is not
            one.
    """

    layers: tuple[Layer, ...] = ()
    wavelength: float = DESIGN_WAVELENGTH
    wavelengths: tuple[float, ...] = ()
    angles: tuple[float, ...] = (0.0,)
    reflectances: tuple[tuple[float, ...], ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "layers", tuple(Layer(*layer) for layer in self.layers))
        if not 0.0 < self.wavelength < inf:
            raise CoatingError(f"coating: the design wavelength {significant(self.wavelength)} µm must be positive")
        if len(self.layers) > MOST_LAYERS:
            raise CoatingError(f"coating: {len(self.layers)} layers; at most {MOST_LAYERS} are computed")
        for i, (index, waves) in enumerate(self.layers):
            if index is None and i == 0:
                raise CoatingError("coating: the first layer needs its index; only a later one can be matched to it")
            if not (index is None or 1.0 <= index < 10.0):
                raise CoatingError(f"coating: index {significant(index)} of layer {i + 1}: it must lie between 1 and "
                                   "10")
            if not 0.0 < waves < 1e6:
                raise CoatingError(f"coating: {significant(waves)} waves of layer {i + 1}: it must be positive")
        if self.wavelengths:
            self._check_table()
        elif self.reflectances:
            raise CoatingError("coating: a table of reflectance needs its wavelengths")

    def _check_table(self) -> None:
        if self.layers:
            raise CoatingError("coating: either layers or a table of reflectance, not both")
        for name, axis in (("wavelengths", self.wavelengths), ("angles", self.angles)):
            if not axis or not all(map(isfinite, axis)) or not all(np.diff(axis) > 0.0):
                raise CoatingError(f"coating: the {name} of a table must be rising numbers")
        if self.wavelengths[0] <= 0.0 or self.angles[0] < 0.0 or self.angles[-1] > 0.5 * np.pi + 1e-12:
            raise CoatingError("coating: wavelengths must be positive, and angles lie between 0 and 90°")
        table = self.reflectances
        if len(table) != len(self.wavelengths) or any(len(row) != len(self.angles) for row in table):
            raise CoatingError(f"coating: a table of {len(self.wavelengths)} wavelengths and {len(self.angles)} angles "
                            "needs as many rows and columns of reflectance")
        if not all(0.0 <= value <= 1.0 for row in table for value in row):
            raise CoatingError("coating: every reflectance must lie between 0 and 1")

    @classmethod
    def single_layer(cls, index: float = MGF2, wavelength: float = DESIGN_WAVELENGTH) -> "Coating":
        """A quarter wave, at a wavelength (µm), of one material of this index; by default magnesium fluoride at 0.55
        µm.
        """
        return cls((Layer(index, 0.25),), wavelength)

    @classmethod
    def broadband(cls, wavelength: float = DESIGN_WAVELENGTH) -> "Coating":
        """Three layers of a quarter, half and quarter wave at the wavelength (µm): MgF₂, ZrO₂, and one matched to the
        glass.
        """
        return cls((Layer(MGF2, 0.25), Layer(HALF_WAVE, 0.5), Layer(None, 0.25)), wavelength)

    @classmethod
    def table(cls, wavelengths: Sequence[float], reflectances: ArrayLike, angles: Sequence[float] = (0.0,)
              ) -> "Coating":
        """A measured curve: reflectances from 0 to 1, (wavelengths,) or (wavelengths, angles), at rising wavelengths
        (µm).

        angles: rising angles of incidence in the medium of the smaller index, radians. CoatingError for other shapes or
        values.
        """
        rows = np.asarray(reflectances, float)
        rows = rows[:, None] if rows.ndim == 1 else rows
        if rows.ndim != 2:
            raise CoatingError("coating: reflectances must have a row for each wavelength, a column for each angle")
        return cls(wavelengths=tuple(map(float, wavelengths)), angles=tuple(map(float, angles)),
                   reflectances=tuple(tuple(row) for row in rows.tolist()))

    def reflectance(self, before: float, after: float, cosine: ArrayLike = 1.0, wavelength: float = D_LINE
                    ) -> Reflectance:
        """Reflected part of a plane wave.

        Args:
            before, after: Indices of the medium that the light comes from and of the one behind the surface.
            cosine: Cosine of the angle of incidence in the medium before, from 0 to 1.
            wavelength: Micrometres.
        Returns:
            Of the shape of `cosine`; 1 where the light is totally reflected.
        Raises:
            CoatingError: A cosine outside 0 to 1 by more than rounding.
        """
        low, high = min(before, after), max(before, after)
        cosines = np.asarray(cosine, float)
        if not ((cosines >= -1e-9) & (cosines <= 1.0 + 1e-9)).all():
            raise CoatingError("the cosine of an angle of incidence must lie between 0 and 1")
        tangential = before * np.sqrt(np.maximum(1.0 - cosines * cosines, 0.0))     # n sin I, the same in every layer
        with np.errstate(invalid="ignore", divide="ignore"):
            total = tangential >= low
            inner = np.where(total, 1.0, np.sqrt(np.maximum(1.0 - (tangential / low) ** 2, 0.0)))
            if self.wavelengths:
                s = p = self._from_table(inner, wavelength)
            else:
                s, p = self._from_layers(low, high, tangential, wavelength)
        return Reflectance(np.where(total, 1.0, s), np.where(total, 1.0, p))

    def _from_table(self, inner: np.ndarray, wavelength: float) -> np.ndarray:
        columns = np.array([np.interp(wavelength, self.wavelengths, column)
                            for column in zip(*self.reflectances, strict=True)])
        return np.interp(np.arccos(np.clip(inner, 0.0, 1.0)), self.angles, columns)

    def _from_layers(self, low: float, high: float, tangential: np.ndarray, wavelength: float
                     ) -> tuple[np.ndarray, np.ndarray]:
        """The characteristic matrix of the layers times the admittance of the glass, for s and p."""
        def cosine(index: float) -> np.ndarray:
            return np.sqrt((1.0 - (tangential / index) ** 2).astype(complex))

        first = self.layers[0].n if self.layers else None
        stack = [((first or 1.0) * (high / low) ** 0.5 if index is None else index, waves)
                 for index, waves in self.layers]
        reflectances = []
        for admittance in (lambda n, c: n * c, lambda n, c: n / c):
            field, flow = np.ones_like(tangential, complex), admittance(high, cosine(high))
            for index, waves in reversed(stack):
                inside = cosine(index)
                phase = 2.0 * np.pi * waves * self.wavelength / wavelength * inside
                eta = admittance(index, inside)
                c, s = np.cos(phase), np.sin(phase)
                field, flow = c * field + 1j * s / eta * flow, 1j * eta * s * field + c * flow
            outer = admittance(low, cosine(low))
            reflectances.append(np.abs((outer * field - flow) / (outer * field + flow)) ** 2)
        return reflectances[0], reflectances[1]


BARE = Coating()
COATINGS: dict[str, Coating] = {"uncoated": BARE, "single-layer": Coating.single_layer(),
                                "multi-layer": Coating.broadband()}


def named_coating(coating: "str | Coating") -> Coating:
    """A coating by its key in COATINGS, or itself; CoatingError for an unknown name."""
    if isinstance(coating, Coating):
        return coating
    if coating not in COATINGS:
        raise CoatingError(f"coating {coating!r}: choose one of {', '.join(COATINGS)}")
    return COATINGS[coating]
