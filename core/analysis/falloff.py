"""How the light falls off over the film, the natural part and the lens's own apart.

The irradiance of a film point under a scene of radiance 1 is E = (1/z²) ∫ cos⁴θ dA over its
exit-pupil region, on the plane of the last vertex at the distance z. That is the mean of cos⁴θ over the
region times its area: the first falls off as for any opening (natural falloff), and the second says
what rims cut off, and what pupils gain or lose by their aberrations (vignetting). mm; both sides in air.
"""

from dataclasses import dataclass

import numpy as np

from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens
from lensbench.pupils.region import exit_pupil


@dataclass(frozen=True, eq=False)
class Falloff:
    """At film radii (n,) mm: parts of what the axis gets, 1 there; their product is `total`. 0 where no light falls.

    irradiance: (n,) of a scene of radiance 1, π sin²θ′ on the axis.
    """

    radii: np.ndarray
    natural: np.ndarray
    vignetting: np.ndarray
    irradiance: np.ndarray

    @property
    def total(self) -> np.ndarray:
        """(n,) relative illumination."""
        return self.natural * self.vignetting

    @property
    def stops(self) -> np.ndarray:
        """(n,) of the total, 0 on the axis and negative where it is darker; −inf where no light falls."""
        with np.errstate(divide="ignore"):
            return np.log2(self.total)


def falloff(lens: Lens, film_distance: float, film_radii, wavelength: float = D_LINE) -> Falloff:
    """The falloff of a lens with its film `film_distance` mm behind the last vertex, at film radii (n,) mm.

    The stop counts as the circle about its blades. LensError for radii and distances that cannot be.
    """
    radii = np.atleast_1d(np.asarray(film_radii, float))
    pupil = exit_pupil(lens, film_distance, np.append(0.0, radii), wavelength)
    light, area = pupil.cos4_area, pupil.area
    with np.errstate(divide="ignore", invalid="ignore"):
        cos4 = np.where(area > 0.0, light / area, 0.0)
        natural, vignetting = cos4[1:] / cos4[0], area[1:] / area[0]
    return Falloff(radii, np.nan_to_num(natural), np.nan_to_num(vignetting), light[1:] / film_distance**2)
