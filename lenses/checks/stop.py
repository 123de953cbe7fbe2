"""The aperture stop: whether it limits the light, and whether a plane that was made for it is another surface.

The stop at another surface, or with another rim: what the stated f-number asks for.
"""

from collections.abc import Iterator
from dataclasses import replace
from math import isfinite

from lensbench.core.optics.finding import Change, Finding, Kind
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant
from lensbench.lenses.checks.hypothesis import Hypothesis
from lensbench.lenses.tables.paraxial import axial_heights

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
    stated, f_number = lens.stated_f_number, first_order(lens).f_number
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
                         "the stop is marked at the wrong surface", f"the stop at surface {i} instead of {marked}",
                         there, 1.0 if i in planes else 4.0)
    efl = first_order(lens).efl
    sound = abs(efl / lens.stated_efl - 1.0) <= SAME_FOCAL_LENGTH if lens.stated_efl else False
    if not (stated and sound and isfinite(f_number) and abs(f_number / stated - 1.0) > SAME):
        return
    ratio = f_number / stated
    for factor, cause in ((0.5, "the semi-diameters are diameters"), (2.0, "the semi-diameters are halved")):
        if abs(ratio / factor - 1.0) <= DIAMETERS:
            rims = tuple(replace(s, semi_diameter=factor * s.semi_diameter) for s in lens.surfaces)
            yield Hypothesis(Kind.RIM, Change("semi_diameter", None, lens.stop.semi_diameter,
                                              factor * lens.stop.semi_diameter), cause, f"all semi-diameters × "
                                                                                        f"{significant(factor)}",
                             replace(lens, surfaces=rims), 1.5)
    radius = ratio * lens.stop.semi_diameter
    yield Hypothesis(Kind.STOP, Change("semi_diameter", marked, lens.stop.semi_diameter, radius),
                     "the stop's semi-diameter is not that of the stated f-number",
                     f"semi-diameter of surface {marked}: {significant(radius, 4)} mm instead of "
                     f"{significant(lens.stop.semi_diameter, 4)} mm",
                     lens.with_stop_radius(radius), 10.0)


LIMITING = 0.67         # of the stop's beam: what other rims must leave of it; rims that are estimates leave 0.72


def stop_findings(lens: Lens) -> list[Finding]:
    """Findings about a stop that does not limit the light because another rim does, or that is marked on glass."""
    heights = axial_heights(lens.surfaces)
    beams = [surface.semi_diameter / abs(height) if height else float("inf")
             for surface, height in zip(lens.surfaces, heights, strict=True)]
    narrowest = min(range(len(beams)), key=beams.__getitem__)
    planes = planes_in_air(lens)
    findings = []
    assumed = any(finding.kind is Kind.NO_STOP for finding in lens.findings)
    if not assumed and len(planes) == 1 and 0 < lens.stop_index and not is_plane_in_air(lens, lens.stop_index):
        findings.append(Finding(
            Kind.STOP, lens.stop_index, f"the stop is marked on surface {lens.stop_index}, which refracts; surface "
            f"{planes[0]} is a plane in air between the elements, as stops are"))
    if not beams[narrowest] < LIMITING * beams[lens.stop_index]:
        return findings
    return [*findings, Finding(
        Kind.STOP, lens.stop_index, f"the stop does not limit the light: on the axis surface {narrowest} "
                                    f"passes a beam of {significant(2.0 * beams[narrowest], 4)} mm, the stop one of "
                                    f"{significant(2.0 * beams[lens.stop_index], 4)} mm",
        figures={"beam": 2.0 * beams[narrowest], "stop_beam": 2.0 * beams[lens.stop_index]})]
