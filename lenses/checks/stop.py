"""The aperture stop: whether it limits the light, and whether a plane that was made for it is another surface."""

from lensbench.kernels.figures import significant
from lensbench.lenses.checks.stop_place import is_plane_in_air, planes_in_air
from lensbench.lenses.paraxial import axial_heights
from lensbench.optics.finding import Finding, Kind
from lensbench.optics.prescription import Lens

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
        Kind.STOP, lens.stop_index, f"the stop does not limit the light: on the axis the rim of surface {narrowest} "
                                    f"passes a beam of {significant(2.0 * beams[narrowest], 4)} mm, the stop one of "
                                    f"{significant(2.0 * beams[lens.stop_index], 4)} mm",
        figures={"beam": 2.0 * beams[narrowest], "stop_beam": 2.0 * beams[lens.stop_index]})]
