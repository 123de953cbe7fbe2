"""Light passed by a lens: working f-number, transmission, T-number.

Lengths in mm. The film is in air.
"""

from math import hypot, inf, pi, sqrt

from lensbench.kernels.figures import significant
from lensbench.optics.axial_bundle import marginal_height
from lensbench.optics.glass import D_LINE
from lensbench.optics.paraxial import first_order
from lensbench.optics.prescription import Lens, LensError
from lensbench.optics.scalar_trace import surface_table


def working_f_number(lens: Lens, film_distance: float) -> float:
    """Working f-number 1 / (2 sin θ′) of the real marginal ray at the axis point of the film.

    All rims and the magnification count; an iris counts as the circle about its blades.

    Parameters
    ----------
    lens : Lens
        The lens. For a cylinder or toroid the result is the geometric mean of the sections, as the light is.
    film_distance : float
        Last vertex → film (mm).

    Returns
    -------
    float
        The working f-number; inf if no ray passes.

    Raises
    ------
    LensError
        If the film is not behind the last vertex.
    """
    if not film_distance > 0.0:
        raise LensError(f"film distance {significant(film_distance)} mm: the film must lie behind the last vertex")
    meridians = ((0.0, 1.0),) if lens.is_rotationally_symmetric else ((0.0, 1.0), (1.0, 0.0))
    sines = []
    for across, up in meridians:
        height = marginal_height(surface_table(lens), 1.0 / film_distance, False, across, up)
        sines.append(height / hypot(height, film_distance))
    sine = sines[0] if len(sines) == 1 else sqrt(sines[0] * sines[1])
    return 1.0 / (2.0 * sine) if sine > 0.0 else inf


# Reflected part of a coated surface to air, a usual mean over visible light; None: as bare glass reflects
COATINGS: dict[str, float | None] = {"uncoated": None, "single-layer": 0.015, "multi-layer": 0.003}


def transmission(lens: Lens, wavelength: float = D_LINE, coating: str = "uncoated") -> float:
    """Transmitted part of the light on the axis: Π (1 − R), for bare surfaces R = ((n′ − n) / (n′ + n))² by Fresnel.

    Parameters
    ----------
    lens : Lens
        The lens; absorption in the glass is neglected.
    wavelength : float
        Micrometres.
    coating : {"uncoated", "single-layer", "multi-layer"}
        Of the surfaces to air, which reflect 1.5 % with a single layer and 0.3 % with several, or less where the bare
        surface does. Cemented surfaces are bare.

    Returns
    -------
    float
        From 0 to 1.

    Raises
    ------
    LensError
        For an unknown coating.
    """
    if coating not in COATINGS:
        raise LensError(f"coating {coating!r}: choose one of {', '.join(COATINGS)}")
    coated = COATINGS[coating]
    n = lens.indices(wavelength)
    passed = 1.0
    for before, after in zip(n[:-1], n[1:], strict=True):
        reflected = ((after - before) / (after + before)) ** 2
        if coated is not None and 1.0 in (before, after):
            reflected = min(reflected, coated)
        passed *= 1.0 - reflected
    return passed


def t_number(lens: Lens, coating: str = "uncoated") -> float:
    """f-number of a lens without losses and blades that passes as much light.

    It is N / √(transmission · open part of the stop), N the f-number for an object at infinity.

    Parameters
    ----------
    lens : Lens
        The lens.
    coating : {"uncoated", "single-layer", "multi-layer"}
        Of its surfaces to air, as in `transmission`.

    Returns
    -------
    float
        The T-number.
    """
    return first_order(lens).f_number / sqrt(transmission(lens, coating=coating) * lens.iris.area / pi)
