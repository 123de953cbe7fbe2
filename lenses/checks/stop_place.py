"""The stop at another surface, or with another rim: what the stated f-number asks for."""

from collections.abc import Iterator
from dataclasses import replace
from math import isfinite

from lensbench.kernels.figures import significant
from lensbench.lenses.checks.hypothesis import Hypothesis
from lensbench.optics.finding import Change, Kind
from lensbench.optics.paraxial import first_order
from lensbench.optics.prescription import Lens

F_NUMBER = 0.05             # of the stated one
DIAMETERS = 0.08            # of a factor of 2, for rims that hold diameters
SAME_FOCAL_LENGTH = 0.02    # of the stated one; otherwise the f-number says nothing about the stop
SAME = 0.15                 # of the stated f-number: the stop is not doubted


def is_plane_in_air(lens: Lens, i: int) -> bool:
    """Whether a surface bends no ray: a plane with air on both sides."""
    n, surface = lens.indices(), lens.surfaces[i]
    return n[i] == n[i + 1] == 1.0 and surface.curvature == 0.0 and surface.is_spherical


def planes_in_air(lens: Lens) -> list[int]:
    """Surfaces within the lens, with glass before and behind, that bend no ray."""
    glass = [i for i, surface in enumerate(lens.surfaces) if surface.glass.n_d != 1.0]
    return [i for i in range(len(lens.surfaces)) if glass and glass[0] < i <= glass[-1] and is_plane_in_air(lens, i)]


def hypotheses(lens: Lens) -> Iterator[Hypothesis]:
    """Other surfaces as the stop, the rim of the stop, and rims that are diameters."""
    stated, here = lens.stated_f_number, first_order(lens).f_number
    planes, marked = planes_in_air(lens), lens.stop_index
    for i in range(len(lens.surfaces)):
        if i == marked or (planes and i not in planes):
            continue
        there = replace(lens, stop_index=i)
        if stated and not abs(first_order(there).f_number / stated - 1.0) <= F_NUMBER:
            continue
        if stated is None and i not in planes:
            continue
        yield Hypothesis(Kind.STOP, Change("stop_index", i, float(marked), float(i)),
                         "the stop is marked at the wrong surface", f"the stop at surface {i} in place of {marked}",
                         there, 1.0 if i in planes else 4.0)
    efl = first_order(lens).efl
    sound = abs(efl / lens.stated_efl - 1.0) <= SAME_FOCAL_LENGTH if lens.stated_efl else False
    if not (stated and sound and isfinite(here) and abs(here / stated - 1.0) > SAME):
        return
    ratio = here / stated
    for factor, cause in ((0.5, "the rims are diameters"), (2.0, "the rims are half the semi-diameters")):
        if abs(ratio / factor - 1.0) <= DIAMETERS:
            rims = tuple(replace(s, semi_diameter=factor * s.semi_diameter) for s in lens.surfaces)
            yield Hypothesis(Kind.RIM, Change("semi_diameter", None, lens.stop.semi_diameter,
                                              factor * lens.stop.semi_diameter), cause, f"all rims × "
                                                                                        f"{significant(factor)}",
                             replace(lens, surfaces=rims), 1.5)
    radius = ratio * lens.stop.semi_diameter
    yield Hypothesis(Kind.STOP, Change("semi_diameter", marked, lens.stop.semi_diameter, radius),
                     "the rim of the stop is not that of the stated f-number",
                     f"rim of surface {marked}: {significant(radius, 4)} mm in place of "
                     f"{significant(lens.stop.semi_diameter, 4)} mm",
                     lens.with_stop_radius(radius), 10.0)
