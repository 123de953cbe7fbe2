"""Checks of a prescription: a lint for lens tables, which separates errors from what is merely unusual.

    for finding in lenses.check(lenses.load("mine.zmx")):
        print(finding.surface, finding.message, finding.proposal)

Lengths in mm, surfaces numbered from 0. The thresholds pass the designs of the library,
with their rounded figures and estimated rims; each has its reason beside it. One idea a file.
"""

from math import isfinite

import numpy as np

from lensbench.core.optics.finding import Change, Finding, Kind, Severity, note
from lensbench.core.optics.glass import GlassError
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant
from lensbench.lenses.checks.causes import cause_findings, symptom_findings
from lensbench.lenses.checks.figures import digit_findings
from lensbench.lenses.checks.geometry import fabrication_findings, geometry_findings
from lensbench.lenses.checks.glasses import glass_findings
from lensbench.lenses.checks.hypotheses import vanishing_terms
from lensbench.lenses.checks.near_object import near_findings
from lensbench.lenses.checks.positions import position_findings
from lensbench.lenses.checks.single_change import glass_causes
from lensbench.lenses.tables.paraxial import at_reference, is_d_line

__all__ = ["Change", "Finding", "Kind", "Severity", "check"]


@np.errstate(all="ignore")          # an infinite or undefined figure fails every comparison
def check(lens: Lens) -> list[Finding]:
    """What looks wrong in a lens: its probable causes, then the findings, then what the reader of its file assumed.

    Args:
        lens: Any lens, which is judged at the primary wavelength of its design; a zoom is checked in its first
            position, then at each of its stations. One that was designed for a near object is held to the rays from
            that object, in best focus.
    Returns:
        Causes come first, the most probable of them at the top; each has a `change`. Doubts have the severity WARNING;
            assumptions of the reader, most of them NOTE, come last. Empty where nothing looks wrong and nothing was
            assumed.
    """
    lens = lens.at(zoom=0.0, close=0.0)
    judged, wavelength = at_reference(lens.with_open_stop)        # a picture in the stop ends rays on purpose
    about = [] if is_d_line(wavelength) else [note(
        Kind.CONVENTION, f"its focal lengths, f-number and rays are those at {significant(1000.0 * wavelength)} nm, "
                         "the primary wavelength of its design", wavelength=wavelength)]
    if not lens.is_centred:
        about.append(note(Kind.CONVENTION, "tilted or decentred surfaces: the lens is checked as if centred"))
    try:
        judged.indices()
    except GlassError as error:         # a glass of the infrared, say: nothing can be traced at the d line
        return [Finding(Kind.GLASS, None, str(error))]
    shapes = geometry_findings(lens)
    table = [*digit_findings(lens), *glass_findings(lens), *vanishing_terms(lens), *shapes, *fabrication_findings(lens)]
    if isfinite(lens.system.object_distances[0]):
        return [*near_findings(judged), *table, *position_findings(judged), *about, *lens.findings]
    symptoms = symptom_findings(judged)
    causes = [*glass_causes(lens, table), *cause_findings(judged, [*symptoms, *shapes])]
    return [*causes, *symptoms, *table, *position_findings(judged), *about, *lens.findings]
