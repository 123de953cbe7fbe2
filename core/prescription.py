"""The prescription of a lens: its surfaces from the scene to the film, as frozen values.

Lengths in mm, in the lens frame: the origin is the first vertex, light travels
along +z, and a curvature c = 1/R is positive when the centre of curvature lies
at +z of the vertex; a plane is c = 0.
"""

from dataclasses import dataclass, field, replace
from math import isfinite

from lensbench.glass import AIR, D_LINE, Glass


class LensError(ValueError):
    """A lens that cannot be, or that cannot do what is asked of it; the message says what to do."""


@dataclass(frozen=True)
class Surface:
    """One surface: curvature (1/mm), gap to the next one (mm), the medium after it, rim radius (mm).

    The stop is a surface too, usually a plane with air on both sides.
    """

    curvature: float
    thickness: float
    semi_diameter: float
    glass: Glass = AIR

    def __post_init__(self):
        for name in ("curvature", "thickness", "semi_diameter"):
            if not isfinite(getattr(self, name)):
                raise LensError(f"{name} is {getattr(self, name)}: it must be a finite number")
        if self.semi_diameter <= 0.0:
            raise LensError(f"semi-diameter is {self.semi_diameter:g} mm: it must be positive")


@dataclass(frozen=True)
class Lens:
    """Surfaces 0 … from the scene to the film; the last thickness is the stored back focus (0: not known).

    stop_index names the surface that is the aperture stop. What a reader had to
    assume or found odd stands in `findings`; it does not count in comparisons.
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
    findings: tuple[str, ...] = field(default=(), compare=False)

    def __post_init__(self):
        if not self.surfaces:
            raise LensError("a lens needs at least one surface")
        if not 0 <= self.stop_index < len(self.surfaces):
            raise LensError(f"stop index {self.stop_index}: this lens has surfaces 0 to {len(self.surfaces) - 1}")

    @property
    def stop(self) -> Surface:
        """The aperture stop."""
        return self.surfaces[self.stop_index]

    @property
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
        return (1.0, *(surface.glass.index(wavelength) for surface in self.surfaces))

    def scaled(self, factor: float) -> "Lens":
        """The same lens made `factor` times as large."""
        if not (isfinite(factor) and factor > 0.0):
            raise LensError(f"scale {factor:g}: it must be a positive number")
        surfaces = tuple(replace(s, curvature=s.curvature / factor, thickness=s.thickness * factor,
                                 semi_diameter=s.semi_diameter * factor) for s in self.surfaces)
        return replace(self, surfaces=surfaces,
                       stated_efl=None if self.stated_efl is None else self.stated_efl * factor)

    def with_stop_radius(self, radius: float) -> "Lens":
        """The same lens with its stop opened or closed to this radius (mm)."""
        surfaces = list(self.surfaces)
        surfaces[self.stop_index] = replace(self.stop, semi_diameter=radius)
        return replace(self, surfaces=tuple(surfaces))
