"""The same lens with its other end towards the scene."""

from dataclasses import replace

from lensbench.optics.finding import Kind, note
from lensbench.optics.glass import AIR
from lensbench.optics.prescription import Lens, LensError


def reversed_lens(lens: Lens) -> Lens:
    """The lens turned round: surfaces in the other order, each bent the other way; its back focus is not known.

    Of a lens with zoom or focus positions only the one it stands in is kept, and a finding says so.

    LensError: a lens with another medium than air behind it.
    """
    if lens.surfaces[-1].glass.n_d != 1.0:
        raise LensError("a lens that ends in another medium than air cannot be turned round: nothing can stand in "
                        "front of the first surface but air")
    gaps = [(s.thickness, s.glass) for s in lens.surfaces[:-1]][::-1] + [(0.0, AIR)]
    surfaces = tuple(
        replace(s, curvature=-s.curvature or 0.0, thickness=gap, glass=glass,
                aspheric=tuple((power, -a) for power, a in s.aspheric),
                curvature_x=None if s.curvature_x is None else -s.curvature_x or 0.0)
        for s, (gap, glass) in zip(reversed(lens.surfaces), gaps, strict=True))
    lost = () if lens.positions is None else (
        note(Kind.POSITION, "its zoom and focus positions are left out: it is turned round in the present one"),)
    return replace(lens, surfaces=surfaces, stop_index=len(surfaces) - 1 - lens.stop_index, positions=None,
                   findings=(*lens.findings, *lost))
