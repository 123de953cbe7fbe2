"""Impossible geometry: surfaces that cross, and what a workshop refuses: thin edges and centres, steep surfaces.

Lengths in mm. Each glass is ground and centred by itself before it is cemented, but for a layer of resin that is
moulded onto a glass, as on hybrid aspheres: only the body that carries it needs the thickness.
"""

import numpy as np

from lensbench.core.optics.finding import Change, Finding, Kind, Severity
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import fixed, significant

HEMISPHERE = 1.01       # × the largest height that the surface has: tables round to three digits
CROSSING = 0.01         # of the rim: depth by which neighbours that touch may overlap, by rounding
ESTIMATED = 0.05        # of the rim: the same where rims are estimates
STOP = 0.1              # of the rim: the same beside a stop, whose plane is nominal
EDGE = 0.005            # of the diameter: a thinner edge chips when it is centred; workshops ask for 2 to 4 %
LEAST_EDGE = 0.1        # mm: the same of small elements
CENTRE = 0.02           # of the diameter: thinner glass bends on the polishing block; workshops ask for 5 to 10 %
RESIN = 0.3             # mm: a cemented layer that is no thicker is resin
STEEPEST = 70.0         # degrees: tools and coatings reach 60° to 65°; the front of a fisheye has up to 75°
HEIGHTS = np.linspace(0.0, 1.0, 33)
_MIRROR = ": a sign is wrong, or light goes back after a mirror, and mirrors are not traced"


def geometry_findings(lens: Lens) -> list[Finding]:
    """Findings where the table describes glass that cannot be ground."""
    findings = []
    n_before = 1.0
    for i, surface in enumerate(lens.surfaces):
        equator = reach(surface)
        if surface.semi_diameter > HEMISPHERE * equator:
            rim, largest = significant(surface.semi_diameter, 5), significant(equator, 4)
            findings.append(Finding(
                Kind.HEMISPHERE, i, f"the semi-diameter is {rim} mm, but the surface ends at "
                                    f"{significant(equator, 5)} mm from the axis",
                f"semi-diameter of surface {i}: at most {largest} mm instead of {rim} mm",
                change=Change("semi_diameter", i, surface.semi_diameter, equator)))
        if i + 1 < len(lens.surfaces):
            findings += _gap(lens, i, n_before)
        n_before = surface.glass.n_d
    return findings


def _gap(lens: Lens, i: int, n_before: float) -> list[Finding]:
    """Findings about the gap behind surface i."""
    front, back = lens.surfaces[i], lens.surfaces[i + 1]
    in_glass = front.glass.n_d > 1.0
    beside_stop = _is_dummy(lens, i, n_before) or _is_dummy(lens, i + 1, front.glass.n_d)
    if in_glass and front.thickness <= 0.0:
        return [Finding(Kind.THICKNESS, i, f"the element behind surface {i} has a thickness of "
                                           f"{significant(front.thickness)} mm{_MIRROR if front.thickness else ''}")]
    if front.thickness < 0.0 and not beside_stop:
        return [Finding(Kind.THICKNESS, i, f"the air behind surface {i} has a thickness of "
                                           f"{significant(front.thickness)} mm{_MIRROR}")]
    rim = min(front.semi_diameter, back.semi_diameter)
    gaps, heights = gaps_within(front, back, rim)
    if beside_stop:                                                 # a stop may stand inside the bulge of a surface
        gaps, heights = gaps[-1:], heights[-1:]
    narrow = int(np.argmin(gaps))
    if not gaps[narrow] < -(STOP if beside_stop else CROSSING) * rim:
        return []
    slight = has_estimated_clear_apertures(lens) and gaps[narrow] > -ESTIMATED * rim
    severity = Severity.NOTE if slight else Severity.WARNING
    where = f"{significant(-gaps[narrow], 3)} mm deep, {significant(heights[narrow], 4)} mm from the axis"
    if in_glass:
        return [Finding(Kind.EDGE, i, f"the element between surfaces {i} and {i + 1} has a negative edge thickness: "
                                   f"{where}", severity=severity)]
    return [Finding(Kind.CROSSING, i, f"surfaces {i} and {i + 1} cross inside their clear apertures: {where}",
                    severity=severity)]


def has_estimated_clear_apertures(lens: Lens) -> bool:
    """Whether rims of the lens are estimates of its source or of the reader."""
    return "rim" in lens.estimates or any(finding.kind is Kind.RIM for finding in lens.findings)


def _is_dummy(lens: Lens, i: int, n_before: float) -> bool:
    """Whether a surface is the stop, or a plane in air that bends no ray."""
    surface = lens.surfaces[i]
    in_air = n_before == surface.glass.n_d == 1.0
    return in_air and (i == lens.stop_index or (surface.curvature == 0.0 and surface.is_spherical))


def gaps_within(front: Surface, back: Surface, rim: float) -> tuple[np.ndarray, np.ndarray]:
    """The gap (mm) between two neighbours at heights to the smaller rim, in the narrower of the two sections."""
    heights = HEIGHTS * min(rim, reach(front), reach(back))
    gaps = [front.thickness + back.sag(x, y) - front.sag(x, y)
            for x, y in ((0.0 * heights, heights), (heights, 0.0 * heights))]
    gap = np.fmin(*gaps)
    known = np.isfinite(gap)
    return gap[known], heights[known]


def reach(surface: Surface) -> float:
    """Height of the surface's equator (mm), or inf."""
    steepest = max((1.0 + surface.conic) * surface.curvature**2, (surface.curvature_x or 0.0)**2)
    return steepest**-0.5 if steepest > 0.0 else np.inf


def fabrication_findings(lens: Lens) -> list[Finding]:
    """Findings where the glass is possible and hardly to be made; at estimated rims they are notes."""
    severity = Severity.NOTE if has_estimated_clear_apertures(lens) else Severity.WARNING
    at_rim = "at its estimated clear aperture" if has_estimated_clear_apertures(lens) else "at its clear aperture"
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
    findings = []
    if 0.0 <= edge < max(EDGE * diameter, LEAST_EDGE):
        findings.append(Finding(Kind.EDGE, i, f"{of} is {significant(edge, 2)} mm thick {at_rim}: an edge chips below "
                                              f"{significant(100.0 * EDGE)} % of the diameter, or "
                                              f"{significant(LEAST_EDGE)} mm", severity=severity,
                                figures={"edge": edge, "diameter": diameter}))
    if front.thickness < CENTRE * diameter:
        findings.append(Finding(Kind.THICKNESS, i, f"{of} is {significant(front.thickness, 2)} mm thick in the centre: "
                                                   f"glass below {significant(100.0 * CENTRE)} % of its diameter bends "
                                                   "when it is polished", severity=severity,
                                figures={"centre": front.thickness, "diameter": diameter}))
    return findings


def _slope(surface: Surface) -> float:
    """Largest slope (degrees) of a surface within its rim, aspheres included; that of a sphere's equator is 90."""
    radius = min(surface.semi_diameter, reach(surface))
    heights = radius * np.sin(np.linspace(0.0, 0.5 * np.pi, 65))        # closer near the rim, where it is steepest
    nothing = np.zeros_like(heights)
    slopes = [np.abs(np.diff(sag) / np.diff(heights)) for sag in (surface.sag(nothing, heights),
                                                                   surface.sag(heights, nothing))]
    return float(np.degrees(np.arctan(np.nanmax(slopes, initial=0.0))))
