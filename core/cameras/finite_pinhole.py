"""A pinhole of finite size: sharp at no distance, and for all distances nearly alike."""

import math
from dataclasses import dataclass

from lensbench.cameras.base import Camera
from lensbench.cameras.film_landing import FilmLanding, ideal_film_landing
from lensbench.cameras.ideal_lens import Gaussian
from lensbench.cameras.rays import CameraError
from lensbench.imaging.film import Film
from lensbench.optics.glass import D_LINE

RAYLEIGH = 1.9          # the diameter of the sharpest hole over √(wavelength · distance)
AIRY = 2.44             # the diameter of Airy's disk, to its first dark ring, over wavelength · distance / diameter


@dataclass(frozen=True, eq=False)
class PinholeCamera(Camera):
    """A round hole at the camera's origin, `radius` mm, and a film `distance` mm behind it; it looks along −z.

    Rays run straight through every point of the hole. They know no diffraction: `diffraction` tells its disk,
    and `best_pinhole` the hole for which both together blur least. CameraError for what cannot be.
    """

    film: Film
    distance: float = 50.0
    radius: float = 0.15

    def __post_init__(self):
        super().__post_init__()
        for name, value in (("film distance", self.distance), ("hole radius", self.radius)):
            if not (math.isfinite(value) and value > 0.0):
                raise CameraError(f"{name} {value:g} mm: it must be a positive number")

    @property
    def gaussian(self) -> Gaussian:
        """Its rays: those of a lens without power."""
        per = 1.0 / self.distance
        return Gaussian(0.0, 0.0, self.radius, -per, self.radius * per, -per, self.radius * per)

    @property
    def fov(self) -> float:
        """Along the shorter side of the film (radians)."""
        return 2.0 * math.atan(min(self.film.width, self.film.height) / (2.0 * self.distance))

    @property
    def f_number(self) -> float:
        """Film distance over the diameter of the hole."""
        return self.distance / (2.0 * self.radius)

    def blur(self, object_distance: float = math.inf) -> float:
        """Diameter (mm) of the light that a point at this distance from the hole (mm) leaves on the film."""
        if not object_distance > 0.0:
            raise CameraError(f"object distance {object_distance:g} mm: it must be positive")
        return 2.0 * self.radius * (1.0 + self.distance / object_distance)

    def diffraction(self, wavelength: float = D_LINE) -> float:
        """Diameter (mm) of Airy's disk on the film, to its first dark ring; wavelength in µm."""
        return AIRY * wavelength * 1e-3 * self.distance / (2.0 * self.radius)

    def way_back(self, wavelength: float = D_LINE) -> FilmLanding | None:
        """In closed form, for every wavelength alike."""
        return ideal_film_landing(self.gaussian, self.film_step, self.gain)

    @property
    def gain(self) -> float:
        """Weight of the ray along the axis."""
        lens = self.gaussian
        return lens.cone / self._normaliser(lens.axis_irradiance, 1.0)


def best_pinhole(distance: float, object_distance: float = math.inf, wavelength: float = D_LINE) -> float:
    """The diameter (mm) of the sharpest hole: 1.9 √(λ b) with 1 / b = 1 / distance + 1 / object distance.

    distance: hole → film, mm; wavelength in µm. Source: Rayleigh, On pin-hole photography, 1891: the sharpest hole
    passes 0.9 of the first zone of Fresnel. CameraError for distances that are not positive.
    """
    if not (distance > 0.0 and object_distance > 0.0 and wavelength > 0.0):
        raise CameraError("the sharpest pinhole needs positive distances and a positive wavelength")
    return RAYLEIGH * math.sqrt(wavelength * 1e-3 / (1.0 / distance + 1.0 / object_distance))
