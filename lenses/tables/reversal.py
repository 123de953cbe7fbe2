"""Lens reversal: the last surface becomes the first."""

from collections.abc import Sequence
from dataclasses import replace

from lensbench.core.optics.finding import Kind, note
from lensbench.core.optics.glass import AIR, Glass
from lensbench.core.optics.lens_surface import LensError, Surface
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import SystemData


def reversed_surfaces(surfaces: Sequence[Surface], thickness: float = 0.0, glass: Glass = AIR) -> tuple[Surface, ...]:
    """Surfaces turned round as one body, in reverse order; thickness and glass: of the gap behind the last of them."""
    gaps = [(s.thickness, s.glass) for s in surfaces[:-1]][::-1] + [(thickness, glass)]
    return tuple(surface.reversed(*gap) for surface, gap in zip(reversed(surfaces), gaps, strict=True))


def reversed_lens(lens: Lens) -> Lens:
    """The lens turned by half a turn about y: surfaces in reverse order, curvatures and aspheric terms negated.

    Its back focus is unknown (0). Only the present zoom and focus position is kept, of the system data only the
    wavelengths, and of the stated figures only the focal length; findings report this.
    LensError if the medium behind the lens is not air.
    """
    if lens.surfaces[-1].glass.n_d != 1.0:
        raise LensError("a lens with another medium than air behind it cannot be turned round: the medium in front of "
                        "a lens is air")
    surfaces = reversed_surfaces(lens.surfaces)
    lost = [] if lens.positions is None else [
        note(Kind.POSITION, "its zoom and focus positions are left out: it is turned round in the present one")]
    system = SystemData(wavelengths=lens.system.wavelengths, primary=lens.system.primary)
    if system != lens.system:
        lost.append(note(Kind.LEFT_OUT, "the aperture, the fields and the object distance that it was designed for are "
                                        "left out: they belong to its other end"))
    if lens.stated_f_number is not None:
        lost.append(note(Kind.LEFT_OUT, "the stated f-number is left out: it belongs to its other end"))
    return replace(lens.iris_turned, surfaces=surfaces, stop_index=len(surfaces) - 1 - lens.stop_index, positions=None,
                   stated_f_number=None, system=system, findings=(*lens.findings, *lost))
