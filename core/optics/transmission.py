"""Light passed by a lens: working f-number, transmission, T-number.

Lengths in mm. The film is in air.
"""

from functools import lru_cache
from math import cos, hypot, inf, pi, prod, sin, sqrt

import numpy as np

from lensbench.core.optics.axial_bundle import marginal_height
from lensbench.core.optics.coatings import BARE, Coating, named_coating
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import Fate, surface_table, trace
from lensbench.core.text import significant

AZIMUTHS = 16           # of the marginal rays of a lens with tilted or decentred surfaces
RAYS, REACH = 1 << 15, 1.5      # of a lens that is dark along the axis; their disk over the rear rim


def working_f_number(lens: Lens, film_distance: float) -> float:
    """Working f-number 1 / (2 sin θ′) of the real marginal ray at the axis point of the film.

    All rims and the magnification count; blades count as a circle of as much area, within the rims.

    Args:
        lens: The lens. For a cylinder or toroid the result is the geometric mean of the sections, as the light is; with
            tilted or decentred surfaces that of AZIMUTHS directions, or, where they cut off the ray along the axis,
            that of a round pupil with as much light.
        film_distance: Last vertex → film (mm).
    Returns:
        The working f-number; inf if no ray passes, as the film's middle is dark.
    Raises:
        LensError: If the film is not behind the last vertex.
    """
    if not film_distance > 0.0:
        raise LensError(f"film distance {significant(film_distance)} mm: the film must lie behind the last vertex")
    lens = lens.with_round_stop
    meridians = [(0.0, 1.0)] if lens.is_rotationally_symmetric else [(0.0, 1.0), (1.0, 0.0)]
    if not lens.is_centred:
        meridians = [(cos(turn), sin(turn)) for turn in (2.0 * pi * k / AZIMUTHS for k in range(AZIMUTHS))]
    sines = []
    for across, up in meridians:
        height = marginal_height(surface_table(lens), 1.0 / film_distance, False, across, up)
        sines.append(height / hypot(height, film_distance))
    if not lens.is_centred and not min(sines) > 0.0:
        return _by_light(lens, film_distance)
    sine = prod(sines) ** (1.0 / len(sines)) if len(sines) != 1 else sines[0]
    return 1.0 / (2.0 * sine) if sine > 0.0 else inf


def _by_light(lens: Lens, film_distance: float) -> float:
    """Working f-number of a round pupil with the light of the axis point of the film: E = π L / (2 N)²; inf if dark.

    By rays at equal areas of a disk on the plane of the last vertex.
    """
    rear, frame = lens.surfaces[-1], lens.frames[-1]
    reach = REACH * rear.semi_diameter + (0.0 if frame is None else float(hypot(*lens.vertex(-1)[:2])))
    turn, radius = pi * (3.0 - sqrt(5.0)) * np.arange(RAYS), reach * np.sqrt((np.arange(RAYS) + 0.5) / RAYS)
    x, y = radius * np.cos(turn), radius * np.sin(turn)
    film = np.array([0.0, 0.0, lens.length + film_distance])
    ways = np.column_stack([x, y, np.full(RAYS, -film_distance)])
    passed = trace(lens.with_open_stop, film, ways).fate == Fate.PASSED
    cos2 = film_distance**2 / (film_distance**2 + radius**2)
    light = pi * reach**2 / film_distance**2 * float(np.where(passed, cos2**2, 0.0).mean())     # E / L
    return 0.5 * sqrt(pi / light) if light > 0.0 else inf


def surface_coatings(lens: Lens, coating: str | Coating = "uncoated") -> tuple[Coating, ...]:
    """The coating of each surface: its own, else the given one where it meets air, else none.

    coating: "uncoated", "single-layer", "multi-layer" (`COATINGS`) or any; CoatingError for another name.
    """
    usual, n = named_coating(coating), lens.indices()
    return tuple(surface.coating if surface.coating is not None else usual if 1.0 in n[i:i + 2] else BARE
                 for i, surface in enumerate(lens.surfaces))


def transmission(lens: Lens, wavelength: float | None = None, coating: str | Coating = "uncoated") -> float:
    """Transmitted part of the light on the axis: Π (1 − R), R the reflectance of each surface at normal incidence.

    Args:
        lens: The lens; absorption in the glass is neglected.
        wavelength: Micrometres; None: the lens's `reference_wavelength`.
        coating: As of `surface_coatings`.
    Returns:
        From 0 to 1.
    Raises:
        CoatingError: For an unknown coating.
    """
    wavelength = lens.reference_wavelength if wavelength is None else wavelength
    n = lens.indices(wavelength)
    return prod(_passed(own, before, after, wavelength)
                for own, before, after in zip(surface_coatings(lens, coating), n[:-1], n[1:], strict=True)
                if before != after)


@lru_cache(maxsize=1024)
def _passed(coating: Coating, before: float, after: float, wavelength: float) -> float:
    """Part of the light that passes a coated surface on the axis; it does not depend on focus and aperture."""
    return 1.0 - float(coating.reflectance(before, after, wavelength=wavelength).mean)


def t_number(lens: Lens, coating: str | Coating = "uncoated", wavelength: float | None = None) -> float:
    """f-number of a lens without losses that passes as much light.

    It is N / √(transmission · that of a picture in the stop), N the f-number for an object at infinity.

    Args:
        lens: The lens.
        coating: As of `surface_coatings`.
        wavelength: Micrometres, of the f-number and the transmission; None: the lens's `reference_wavelength`.
    Returns:
        The T-number.
    """
    iris = lens.iris
    passed = transmission(lens, wavelength, coating) * iris.area / (pi * iris.equivalent_radius**2)
    return first_order(lens, wavelength).f_number / sqrt(passed)
