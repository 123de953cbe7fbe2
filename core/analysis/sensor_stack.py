"""The glass in front of a sensor, and the error of an adapter: a lens on a camera that it was not made for.

A plane plate of thickness t and index n moves the image by t (1 − 1/n) away from the lens, which focusing undoes, and
adds spherical aberration, astigmatism and colour, wherever it stands (Smith, "Modern Optical Engineering", ch. 7).
"""

from dataclasses import replace
from math import inf

from lensbench.core.optics.glass import D_LINE, Glass
from lensbench.core.optics.lens_surface import LensError, Surface
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant

CROWN = 64.0            # Abbe number of the plate
RIM = 3.0               # semi-diameter of the plate, × what a ray at 45° from the last rim needs: it ends no light


def with_sensor_stack(lens: Lens, film_distance: float, thickness: float, index: float | Glass = 1.52,
                      adapter_error: float = 0.0, refocused: bool = True) -> tuple[Lens, float]:
    """The lens with a plane plate before its film, and its film distance.

    Args:
        lens: The lens, focused; in air behind.
        film_distance: Last vertex → film, mm.
        thickness: Of the plate, mm; 0 for none.
        index: Of the plate. A number gets the dispersion of crown glass (V_d 64) if any glass of the lens has a known
            one.
        adapter_error: By which an adapter holds the lens too far from the film, mm; negative: too near.
        refocused: Whether the film follows the shift of the plate, as after focusing.
    Returns:
        (Lens, float). The lens with two plane surfaces more, without focus and zoom positions, and the distance from
            the plate to the film, mm.
    Raises:
        LensError: For a negative thickness, an index below 1, a lens that does not end in air, and where plate and
            adapter leave no room before the film.
    """
    if not 0.0 <= thickness < inf:
        raise LensError(f"a stack {significant(thickness)} mm thick: the thickness must be 0 or more")
    glass = index if isinstance(index, Glass) else _glass(lens, index)
    if lens.indices()[-1] != 1.0:
        raise LensError("this lens ends in glass: a stack needs air before it")
    if not -inf < adapter_error < inf:
        raise LensError(f"an adapter error of {significant(adapter_error)} mm: it must be a finite length")
    n = glass.index(D_LINE)
    shift = thickness * (1.0 - 1.0 / n) if refocused else 0.0
    air = film_distance + adapter_error + shift - thickness             # before and behind the plate
    if not air > 0.0:
        raise LensError(f"no room for a stack of {significant(thickness)} mm: the film lies "
                        f"{significant(film_distance + adapter_error, 3)} mm behind the last vertex: choose "
                        "thinner glass")
    if thickness == 0.0:
        return lens, film_distance + adapter_error
    *before, last = lens.surfaces
    half = 0.5 * air
    rim = RIM * (last.semi_diameter + air + thickness)
    plate = Surface(thickness, rim, glass, curvature=0.0), Surface(0.0, rim, curvature=0.0)
    return replace(lens, surfaces=(*before, replace(last, thickness=half), *plate), positions=None), half


def _glass(lens: Lens, index: float) -> Glass:
    """The plate of an index, with dispersion for a lens that has some."""
    if not 1.0 <= index < inf:
        raise LensError(f"a stack of index {significant(index)}: the index must be 1 or more")
    return Glass(index, CROWN if any(surface.glass.disperses for surface in lens.surfaces) and index > 1.0 else None)
