"""The aperture stop: whether there is one, and whether it limits the light; and what else the reader assumed."""

from lensbench.lenses.check.finding import Finding
from lensbench.lenses.rows import NO_STOP
from lensbench.lenses.soundness import axial_heights
from lensbench.optics.prescription import Lens

LIMITING = 0.67         # of the stop's beam: what other rims must leave of it; rims that are estimates leave 0.72


def reading_findings(lens: Lens) -> list[Finding]:
    """The reader's remarks, a missing stop among them."""
    return [Finding("no-stop" if told.startswith(NO_STOP) else "reading", None, told) for told in lens.findings]


def stop_findings(lens: Lens) -> list[Finding]:
    """A stop that another rim makes idle."""
    heights = axial_heights(lens.surfaces)
    beams = [surface.semi_diameter / abs(height) if height else float("inf")
             for surface, height in zip(lens.surfaces, heights, strict=True)]
    narrowest = min(range(len(beams)), key=beams.__getitem__)
    if not beams[narrowest] < LIMITING * beams[lens.stop_index]:
        return []
    return [Finding(
        "stop", lens.stop_index, f"the stop does not limit the light: on the axis the rim of surface {narrowest} "
        f"passes a beam of {2.0 * beams[narrowest]:.4g} mm, the stop one of {2.0 * beams[lens.stop_index]:.4g} mm")]
