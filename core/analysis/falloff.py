"""Falloff of light over the film, separated into natural falloff and vignetting.

The irradiance of a film point under a scene of radiance 1 is E = (1/z²) ∫ cos⁴θ dA over its
exit-pupil region, on the plane of the last vertex at the distance z: the mean of cos⁴θ over the
region times the region's area. The mean falls off as for any opening (natural falloff); the area shows
what rims cut off, and what pupil aberrations add or take (vignetting). mm; both sides in air.
"""

from dataclasses import dataclass

import numpy as np

from lensbench.optics.glass import D_LINE
from lensbench.optics.prescription import Lens
from lensbench.pupils.region import exit_pupil


@dataclass(frozen=True, eq=False)
class Falloff:
    """Falloff at n film radii relative to the axis, from `falloff`.

    Parameters
    ----------
    radii
        (n,) film radii, mm.
    natural
        (n,) mean of cos⁴θ over the exit-pupil region, over that on the axis; NaN where no light falls.
    vignetting
        (n,) area of the exit-pupil region, over that on the axis; 0 where no light falls.
    irradiance
        (n,) irradiance under a scene of radiance 1; π sin²θ′ on the axis.
    """

    radii: np.ndarray
    natural: np.ndarray
    vignetting: np.ndarray
    irradiance: np.ndarray

    @property
    def total(self) -> np.ndarray:
        """(n,) relative illumination, natural × vignetting; 0 where no light falls."""
        return np.where(self.vignetting > 0.0, self.natural * self.vignetting, 0.0)

    @property
    def stops(self) -> np.ndarray:
        """(n,) total in stops: 0 on the axis, negative where it is darker, −inf where no light falls."""
        with np.errstate(divide="ignore"):
            return np.log2(self.total)


def falloff(lens: Lens, film_distance: float, film_radii, wavelength: float = D_LINE) -> Falloff:
    """The falloff of a lens; its blades count as a circle of as much area.

    Parameters
    ----------
    lens
        The lens.
    film_distance
        From the last vertex to the film, mm.
    film_radii
        (n,) film radii, mm.
    wavelength
        µm.

    Returns
    -------
    Falloff

    Raises
    ------
    LensError
        For invalid radii and distances.
    """
    radii = np.atleast_1d(np.asarray(film_radii, float))
    pupil = exit_pupil(lens.with_round_stop, film_distance, np.append(0.0, radii), wavelength)
    light, area = pupil.cos4_area, pupil.area
    with np.errstate(divide="ignore", invalid="ignore"):
        cos4 = np.where(area > 0.0, light / area, np.nan)
        natural, vignetting = cos4[1:] / cos4[0], area[1:] / area[0]
    return Falloff(radii, natural, np.nan_to_num(vignetting), light[1:] / film_distance**2)
