"""Dispersion of a lens in colour pictures, whose 24 wavelengths its glasses have to know."""

from functools import lru_cache

from lensbench.imaging.spectrum import WAVELENGTHS
from lensbench.optics.glass import Glass, GlassError
from lensbench.optics.prescription import Lens


def has_dispersion(lens: Lens) -> bool:
    """Whether any glass disperses, and the indices of all are known at the wavelengths of pictures."""
    return any(surface.glass.disperses for surface in lens.surfaces) and not missing_dispersion(lens)


def missing_dispersion(lens: Lens) -> str:
    """Message that names a glass whose index is unknown at some wavelength of pictures; "" where all are known."""
    return _missing_index(tuple(surface.glass for surface in lens.surfaces))


@lru_cache(maxsize=64)
def _missing_index(glasses: tuple[Glass, ...]) -> str:
    """`missing_dispersion` of a lens of these glasses: the same wherever it is focused and stopped down."""
    try:
        for wavelength in (wavelength for row in WAVELENGTHS.values() for wavelength in row):
            for glass in glasses:
                glass.index(wavelength)
    except GlassError as error:
        return str(error)
    return ""
