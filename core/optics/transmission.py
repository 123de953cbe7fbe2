"""How much light a lens passes: working f-number, transmission, T-number.

Lengths in mm; the scene and the film are in air.
"""

from math import hypot, inf, pi, sqrt

from lensbench.optics.axial_bundle import marginal_height
from lensbench.optics.glass import D_LINE
from lensbench.optics.paraxial import first_order
from lensbench.optics.prescription import Lens, LensError
from lensbench.optics.scalar_trace import surface_table


def working_f_number(lens: Lens, film_distance: float) -> float:
    """1 / (2 sin θ′) of the real marginal ray at the axis point of a film this far (mm) behind the last vertex.

    Every rim counts, and so does the magnification; of blades the circle about them. Of a lens with a cylinder or
    toroid the geometric mean of its sections', which goes with the light. LensError where the film does not stand
    behind the last vertex.
    """
    if not film_distance > 0.0:
        raise LensError(f"film distance {film_distance:g} mm: the film must stand behind the last vertex")
    ways = ((0.0, 1.0),) if lens.is_rotationally_symmetric else ((0.0, 1.0), (1.0, 0.0))
    sines = []
    for across, up in ways:
        height = marginal_height(surface_table(lens), 1.0 / film_distance, False, across, up)
        sines.append(height / hypot(height, film_distance))
    sine = sines[0] if len(sines) == 1 else sqrt(sines[0] * sines[1])
    return 1.0 / (2.0 * sine) if sine > 0.0 else inf


def transmission(lens: Lens, wavelength: float = D_LINE) -> float:
    """Part of the light on the axis that uncoated surfaces let through: Π (1 − ((n′ − n) / (n′ + n))²), by Fresnel."""
    n = lens.indices(wavelength)
    passed = 1.0
    for before, after in zip(n[:-1], n[1:], strict=True):
        passed *= 1.0 - ((after - before) / (after + before)) ** 2
    return passed


def t_number(lens: Lens) -> float:
    """The f-number of a lens without losses and blades that would pass as much: N / √(transmission · open part)."""
    return first_order(lens).f_number / sqrt(transmission(lens) * lens.iris.area / pi)
