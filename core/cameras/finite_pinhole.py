"""Pinhole of finite size, whose blur is nearly the same at all distances."""

import math
from dataclasses import dataclass

from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.ideal_lens import Gaussian
from lensbench.core.cameras.rays import CameraError
from lensbench.core.imaging.film import Film
from lensbench.core.optics.glass import D_LINE
from lensbench.core.text import significant

RAYLEIGH = 1.9          # diameter of the sharpest hole over √(wavelength · distance)
AIRY = 2.44             # diameter of Airy's disk, to its first dark ring, over wavelength · distance / hole diameter


@dataclass(frozen=True, eq=False)
class PinholeCamera(Camera):
    """Round hole of finite size at the camera's origin, looking along −z.

    Rays run straight through every point of the hole, without diffraction: `diffraction` gives the diameter of its
    disk, and `best_pinhole` the hole for which both together blur least.

    Parameters
    ----------
    film : Film
        Size (mm) and pixels.
    distance : float
        Distance (mm) from the hole to the film.
    radius : float
        Radius (mm) of the hole.
    **placement
        Keyword arguments of `Camera`: transform, shutter, weights and medium.

    Raises
    ------
    CameraError
        A distance or radius that is not positive and finite.
    """

    film: Film
    distance: float = 50.0
    radius: float = 0.15

    def __post_init__(self):
        super().__post_init__()
        for name, value in (("film distance", self.distance), ("hole radius", self.radius)):
            if not (math.isfinite(value) and value > 0.0):
                raise CameraError(f"{name} {significant(value)} mm: it must be a positive number")

    @property
    def gaussian(self) -> Gaussian:
        """First-order map of a lens without power."""
        per = 1.0 / self.distance
        return Gaussian(0.0, 0.0, self.radius, -per, self.radius * per, -per, self.radius * per)

    @property
    def fov(self) -> float:
        """Field of view (radians) along the shorter side of the film."""
        return 2.0 * math.atan(min(self.film.width, self.film.height) / (2.0 * self.distance))

    @property
    def f_number(self) -> float:
        """Ratio of film distance to hole diameter."""
        return self.distance / (2.0 * self.radius)

    def blur(self, object_distance: float = math.inf) -> float:
        """Diameter of the disk of light from an object point on the film.

        Parameters
        ----------
        object_distance : float
            Distance (mm) from the hole to the point; math.inf is allowed.

        Returns
        -------
        float
            Diameter (mm).

        Raises
        ------
        CameraError
            A distance that is not positive.
        """
        if not object_distance > 0.0:
            raise CameraError(f"object distance {significant(object_distance)} mm: it must be positive")
        return 2.0 * self.radius * (1.0 + self.distance / object_distance)

    def diffraction(self, wavelength: float = D_LINE) -> float:
        """Diameter of Airy's disk on the film, to its first dark ring.

        Parameters
        ----------
        wavelength : float
            Wavelength of the light (µm).

        Returns
        -------
        float
            Diameter (mm).
        """
        return AIRY * wavelength * 1e-3 * self.distance / (2.0 * self.radius)


def best_pinhole(distance: float, object_distance: float = math.inf, wavelength: float = D_LINE) -> float:
    """Diameter of the sharpest pinhole: 1.9 √(λ b), with 1 / b = 1 / distance + 1 / object_distance.

    The sharpest hole passes 0.9 of the first Fresnel zone.

    Parameters
    ----------
    distance : float
        Distance (mm) from the hole to the film.
    object_distance : float
        Distance (mm) from the hole to the object; math.inf is allowed.
    wavelength : float
        Wavelength of the light (µm).

    Returns
    -------
    float
        Diameter (mm).

    Raises
    ------
    CameraError
        A distance or wavelength that is not positive.

    References
    ----------
    Rayleigh 1891, On pin-hole photography.
    """
    if not (distance > 0.0 and object_distance > 0.0 and wavelength > 0.0):
        raise CameraError("the sharpest pinhole needs positive distances and a positive wavelength")
    return RAYLEIGH * math.sqrt(wavelength * 1e-3 / (1.0 / distance + 1.0 / object_distance))
