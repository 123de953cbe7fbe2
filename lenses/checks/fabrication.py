"""What a workshop refuses: edges and centres too thin for the diameter, and surfaces too steep.

Lengths in mm. Each glass is ground and centred by itself before it is cemented, but for a layer of resin that is
moulded onto a glass, as on hybrid aspheres: only the body that carries it needs the thickness.
"""

import numpy as np

from lensbench.core.optics.finding import Finding, Kind, Severity
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import fixed, significant
from lensbench.lenses.checks.geometry import gaps_within, has_estimated_rims, reach

EDGE = 0.005            # of the diameter: a thinner edge chips when it is centred; workshops ask for 2 to 4 %
LEAST_EDGE = 0.1        # mm: the same of small elements
CENTRE = 0.02           # of the diameter: thinner glass bends on the polishing block; workshops ask for 5 to 10 %
RESIN = 0.3             # mm: a cemented layer that is no thicker is resin
STEEPEST = 70.0         # degrees: tools and coatings reach 60° to 65°; the front of a fisheye has up to 75°


def fabrication_findings(lens: Lens) -> list[Finding]:
    """Findings where the glass is possible and hardly to be made; at estimated rims they are notes."""
    severity = Severity.NOTE if has_estimated_rims(lens) else Severity.WARNING
    at_rim = "at its estimated rim" if has_estimated_rims(lens) else "at its rim"
    findings, before = [], 1.0
    for i, surface in enumerate(lens.surfaces):
        slope = _slope(surface)
        if surface.glass.n_d != before and slope > STEEPEST:
            findings.append(Finding(Kind.SLOPE, i, f"surface {i} slopes by {fixed(slope, 0)}° {at_rim}: beyond "
                                                   f"{significant(STEEPEST)}° it can hardly be polished, tested or "
                                                   "coated", severity=severity, figures={"slope": slope}))
        if surface.glass.n_d > 1.0 and i + 1 < len(lens.surfaces) and surface.thickness > 0.0:
            findings += _element(lens, i, before, at_rim, severity)
        before = surface.glass.n_d
    return findings


def _element(lens: Lens, i: int, before: float, at_rim: str, severity: Severity) -> list[Finding]:
    """Findings about the glass behind surface i."""
    front, back = lens.surfaces[i], lens.surfaces[i + 1]
    is_cemented = before > 1.0 or (i + 2 < len(lens.surfaces) and back.glass.n_d > 1.0)
    if is_cemented and front.thickness <= RESIN:
        return []
    diameter = 2.0 * max(front.semi_diameter, back.semi_diameter)
    edge = float(min(gaps_within(front, back, min(front.semi_diameter, back.semi_diameter))[0][-1:], default=np.inf))
    of = f"the element between surfaces {i} and {i + 1}, {significant(diameter, 3)} mm across,"
    found = []
    if 0.0 <= edge < max(EDGE * diameter, LEAST_EDGE):
        found.append(Finding(Kind.EDGE, i, f"{of} is {significant(edge, 2)} mm thick {at_rim}: an edge chips below "
                                           f"{significant(100.0 * EDGE)} % of the diameter, or "
                                           f"{significant(LEAST_EDGE)} mm", severity=severity,
                             figures={"edge": edge, "diameter": diameter}))
    if front.thickness < CENTRE * diameter:
        found.append(Finding(Kind.THICKNESS, i, f"{of} is {significant(front.thickness, 2)} mm thick in the centre: "
                                                f"glass below {significant(100.0 * CENTRE)} % of its diameter bends "
                                                "when it is polished", severity=severity,
                             figures={"centre": front.thickness, "diameter": diameter}))
    return found


def _slope(surface: Surface) -> float:
    """Largest slope (degrees) of a surface within its rim, aspheres included; that of a sphere's equator is 90."""
    radius = min(surface.semi_diameter, reach(surface))
    heights = radius * np.sin(np.linspace(0.0, 0.5 * np.pi, 65))        # closer near the rim, where it is steepest
    nothing = np.zeros_like(heights)
    slopes = [np.abs(np.diff(sag) / np.diff(heights)) for sag in (surface.sag(nothing, heights),
                                                                   surface.sag(heights, nothing))]
    return float(np.degrees(np.arctan(np.nanmax(slopes, initial=0.0))))
