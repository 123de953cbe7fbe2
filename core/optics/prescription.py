"""The prescription of a lens: its surfaces from the scene to the film, as frozen values.

Lengths in mm, in the lens frame: the origin is the first vertex, light travels
along +z, and a curvature c = 1/R is positive when the centre of curvature lies
at +z of the vertex; a plane is c = 0. The sag of a rotationally symmetric
surface is z = c r² / (1 + √(1 − (1+k) c² r²)) + Σ a_p r^p.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import isfinite
from typing import Any

import numpy as np

from lensbench.optics.finding import Finding
from lensbench.optics.glass import AIR, D_LINE, Glass
from lensbench.optics.iris import Iris, IrisError
from lensbench.optics.surfaces import HIGHEST_POWER, sags, shape
from lensbench.optics.zoom_positions import Positions, PositionsError


class LensError(ValueError):
    """A lens that cannot be, or that cannot do what is asked of it; the message says what to do."""


@dataclass(frozen=True)
class Surface:
    """One surface: curvature (1/mm), gap to the next one (mm), the medium after it, rim radius (mm).

    conic: k, 0 for a sphere, −1 for a parabola. aspheric: ((power, coefficient in
    mm^(1 − power)), …), powers 2 to 20; kept by rising power, without zeros.
    curvature_x: None where the surface is rotationally symmetric; otherwise the
    curvature of the section x–z, `curvature` being that of y–z (a cylinder or a
    toroid; conic and aspheric must then be left out). The stop is a surface too,
    usually a plane with air on both sides. LensError for what cannot be.
    """

    curvature: float
    thickness: float
    semi_diameter: float
    glass: Glass = AIR
    conic: float = 0.0
    aspheric: tuple[tuple[int, float], ...] = ()
    curvature_x: float | None = None

    def __post_init__(self):
        for name in ("curvature", "thickness", "semi_diameter", "conic"):
            if not isfinite(getattr(self, name)):
                raise LensError(f"{name} is {getattr(self, name)}: it must be a finite number")
        if self.semi_diameter <= 0.0:
            raise LensError(f"semi-diameter is {self.semi_diameter:g} mm: it must be positive")
        object.__setattr__(self, "aspheric", _sound_terms(self.aspheric))
        if self.curvature_x is None:
            return
        if not isfinite(self.curvature_x):
            raise LensError(f"curvature_x is {self.curvature_x}: it must be a finite number, or left out")
        if self.conic != 0.0 or self.aspheric:
            raise LensError("a surface with curvature_x can have neither a conic nor aspheric terms")
        if self.curvature_x == self.curvature:
            object.__setattr__(self, "curvature_x", None)       # both sections alike: a sphere

    @property
    def is_spherical(self) -> bool:
        """Whether it is a plane or a sphere."""
        return not self.aspheric and self.curvature_x is None and (self.conic == 0.0 or self.curvature == 0.0)

    @property
    def vertex_curvature(self) -> float:
        """Curvature at the vertex in the section y–z (1/mm), with that of an r² term."""
        return self.curvature + 2.0 * dict(self.aspheric).get(2, 0.0)

    @cached_property
    def shape(self) -> np.ndarray:
        """The surface as the kernels of `surfaces` read it."""
        return shape(self.curvature, self.conic, self.aspheric, self.curvature_x, self.semi_diameter)

    def sag(self, x, y=0.0) -> np.ndarray:
        """Height z (mm) above the vertex's plane at points x, y (mm, broadcast); NaN where the surface ends before.

        It ends at the equator of a sphere, conic or toroid.
        """
        return sags(self.shape, x, y)

    def scaled(self, factor: float) -> "Surface":
        """The same surface, and the gap behind it, made `factor` times as large."""
        return replace(self, curvature=self.curvature / factor, thickness=self.thickness * factor,
                       semi_diameter=self.semi_diameter * factor,
                       aspheric=tuple((power, a * factor ** (1 - power)) for power, a in self.aspheric),
                       curvature_x=None if self.curvature_x is None else self.curvature_x / factor)


def _sound_terms(terms: Iterable[tuple[int, float]]) -> tuple[tuple[int, float], ...]:
    """Aspheric terms by rising power, without zeros; LensError where a power or a coefficient is none."""
    sound: dict[int, float] = {}
    for power, coefficient in terms:
        if power != int(power) or not 2 <= power <= HIGHEST_POWER:
            raise LensError(f"aspheric power {power}: it must be a whole number from 2 to {HIGHEST_POWER}")
        if power in sound:
            raise LensError(f"the aspheric term r^{power} stands twice")
        if not isfinite(coefficient):
            raise LensError(f"the aspheric coefficient of r^{power} is {coefficient}: it must be a finite number")
        sound[int(power)] = float(coefficient)
    return tuple((power, sound[power]) for power in sorted(sound) if sound[power] != 0.0)


@dataclass(frozen=True)
class Lens:
    """Surfaces 0 … from the scene to the film; the last thickness is the stored back focus (0: not known).

    stop_index names the surface that is the aperture stop. `surfaces` is the lens as
    it stands; `positions`, where it has any, says where its groups can go, and `at` moves
    them. The stop's blades (0: a circle), their rotation (radians) and roundness (0 straight … 1 a
    circle) are those of an `Iris` within the stop's radius. front_index: of what lies before the first
    surface, 1 for air; a lens in water has 1.33. What a reader had to assume or found
    odd stands in `findings`; it does not count in comparisons.
    """

    surfaces: tuple[Surface, ...]
    stop_index: int
    name: str = ""
    kind: str = ""                          # "double Gauss", "fisheye", …
    year: int | None = None
    source: str = ""                        # patent, book or design file
    stated_efl: float | None = None         # mm, as published
    stated_f_number: float | None = None
    notes: str = ""
    positions: Positions | None = None      # of a zoom, or of a lens that focuses by moving groups
    findings: tuple[Finding, ...] = field(default=(), compare=False)
    blades: int = 0
    blade_rotation: float = 0.0
    roundness: float = 0.0
    front_index: float = 1.0

    def __post_init__(self):
        if not self.surfaces:
            raise LensError("a lens needs at least one surface")
        if not 0 <= self.stop_index < len(self.surfaces):
            raise LensError(f"stop index {self.stop_index}: this lens has surfaces 0 to {len(self.surfaces) - 1}")
        if self.positions is not None and self.positions.gaps[-1] >= len(self.surfaces):
            raise LensError(f"the gap behind surface {self.positions.gaps[-1]} varies: this lens has surfaces 0 to "
                            f"{len(self.surfaces) - 1}")
        if not (isfinite(self.front_index) and 1.0 <= self.front_index <= 3.0):
            raise LensError(f"index {self.front_index:g} before the lens: it must lie between 1 (air) and 3")
        try:
            object.__setattr__(self, "blades", self.iris.blades)
        except IrisError as error:
            raise LensError(str(error)) from None

    @property
    def stop(self) -> Surface:
        """The aperture stop."""
        return self.surfaces[self.stop_index]

    @property
    def iris(self) -> Iris:
        """The stop's shape, for a stop of radius 1."""
        return Iris(self.blades, self.blade_rotation, self.roundness)

    @cached_property
    def is_rotationally_symmetric(self) -> bool:
        """Whether no surface is a cylinder or a toroid; blades do not count."""
        return all(surface.curvature_x is None for surface in self.surfaces)

    def section(self, axis: str) -> "Lens":
        """The rotationally symmetric lens that has the section x–z ("x") or y–z ("y") of this one."""
        if axis not in ("x", "y"):
            raise LensError(f"section {axis!r}: it is 'x' for x–z or 'y' for y–z")
        if self.is_rotationally_symmetric:
            return self
        return replace(self, surfaces=tuple(
            surface if surface.curvature_x is None else
            replace(surface, curvature=surface.curvature_x if axis == "x" else surface.curvature, curvature_x=None)
            for surface in self.surfaces))

    @property
    def sections(self) -> tuple["Lens", ...]:
        """The lenses of its sections: x–z and y–z, or of a rotationally symmetric one itself alone."""
        return (self,) if self.is_rotationally_symmetric else (self.section("x"), self.section("y"))

    @cached_property
    def vertices(self) -> tuple[float, ...]:
        """The z of every vertex (mm, lens frame): 0, then the running sum of the gaps."""
        z, places = 0.0, []
        for surface in self.surfaces:
            places.append(z)
            z += surface.thickness
        return tuple(places)

    @property
    def length(self) -> float:
        """From the first vertex to the last (mm)."""
        return self.vertices[-1]

    def indices(self, wavelength: float = D_LINE) -> tuple[float, ...]:
        """Index before the first surface, then after each: one more than surfaces. Wavelength in µm."""
        known = self.known.get(("indices", wavelength))
        if known is None:
            known = self.front_index, *(surface.glass.index(wavelength) for surface in self.surfaces)
            self.known["indices", wavelength] = known
        return known

    @cached_property
    def known(self) -> dict[tuple[str, float], Any]:
        """What has been worked out of this lens, which never changes, by name and wavelength."""
        return {}

    def scaled(self, factor: float) -> "Lens":
        """The same lens made `factor` times as large."""
        if not (isfinite(factor) and factor > 0.0):
            raise LensError(f"scale {factor:g}: it must be a positive number")
        return replace(self, surfaces=tuple(surface.scaled(factor) for surface in self.surfaces),
                       stated_efl=None if self.stated_efl is None else self.stated_efl * factor,
                       positions=None if self.positions is None else self.positions.scaled(factor))

    def with_stop_radius(self, radius: float) -> "Lens":
        """The same lens with its stop opened or closed to this radius (mm), at its other positions in proportion."""
        surfaces = list(self.surfaces)
        surfaces[self.stop_index] = replace(self.stop, semi_diameter=radius)
        positions = self.positions and self.positions.with_stops(radius / self.stop.semi_diameter)
        return replace(self, surfaces=tuple(surfaces), positions=positions)

    @property
    def zooms(self) -> bool:
        """Whether it has zoom stations."""
        return self.positions is not None and self.positions.zooms

    @property
    def has_focus_groups(self) -> bool:
        """Whether it focuses by moving groups, as its positions say; other lenses are focused as a whole."""
        return self.positions is not None and self.positions.focuses

    def at(self, zoom: float | None = None, close: float | None = None) -> "Lens":
        """The same lens with its groups moved: zoom 0 (wide) to 1 (tele), close 0 (infinity) to 1 (nearest).

        What is left out stays where it is. The varying gaps, the last one included where
        it is one of them, a stop that varies and the stated figures follow. LensError: beyond
        0 to 1, or other than 0 where the lens has no such positions.
        """
        for asked, has, what in ((zoom, self.zooms, "does not zoom: zoom must be 0"),
                                 (close, self.has_focus_groups, "has no focus groups and is focused as a whole: "
                                                                "close must be 0")):
            if asked and not has:
                raise LensError(f"this lens {what}")
        now = self.positions
        if now is None:
            return self
        try:
            now = now.at(now.zoom if zoom is None else zoom, now.close if close is None else close)
        except PositionsError as error:
            raise LensError(str(error)) from None
        surfaces = list(self.surfaces)
        for i, gap in zip(now.gaps, now.thickness_now, strict=True):
            surfaces[i] = replace(surfaces[i], thickness=gap)
        if (stop := now.stop_now) is not None:
            surfaces[self.stop_index] = replace(surfaces[self.stop_index], semi_diameter=stop)
        return replace(self, surfaces=tuple(surfaces), positions=now,
                       stated_efl=now.focal_length_now if now.focal_lengths else self.stated_efl,
                       stated_f_number=now.f_number_now if now.f_numbers else self.stated_f_number)
