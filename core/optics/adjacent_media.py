"""The media on both sides of a surface of a lens, and whether light bends between them."""

from lensbench.core.optics.glass import AIR, Glass
from lensbench.core.optics.prescription import Lens


def front_medium(lens: Lens) -> Glass:
    """The medium before the first surface."""
    return AIR if lens.front_index == 1.0 else Glass(lens.front_index)


def medium_before(lens: Lens, surface: int) -> Glass:
    """The medium before a surface, numbered from 0; that behind the last one for the number of surfaces."""
    return lens.surfaces[surface - 1].glass if surface else front_medium(lens)


def refracts(lens: Lens, surface: int) -> bool:
    """Whether a surface bends light: the indices before and behind it differ, at some wavelength.

    The names of the media do not count. A stop in air, or within an element, bends nothing.
    """
    return _index_law(medium_before(lens, surface)) != _index_law(lens.surfaces[surface].glass)


def _index_law(glass: Glass) -> tuple:
    """The numbers from which the index of a medium follows."""
    if glass.formula != "model":
        return glass.formula, glass.coefficients
    return glass.n_d, glass.v_d if glass.disperses else None
