"""What looks wrong in a prescription, and why: a lint for lens tables, told apart from what merely looks unusual.

    for finding in lenses.check(lenses.load("mine.zmx")):
        print(finding.surface, finding.message, finding.proposal)

Lengths in mm, surfaces numbered from 0. The thresholds are those that pass
forty published designs, with their rounded figures and estimated rims, and
stand with their reasons beside what they decide. One idea a file.
"""

import numpy as np

from lensbench.lenses.check.digits import digit_findings
from lensbench.lenses.check.figures import figure_findings
from lensbench.lenses.check.finding import Finding
from lensbench.lenses.check.geometry import geometry_findings
from lensbench.lenses.check.glasses import glass_findings
from lensbench.lenses.check.positions import position_findings
from lensbench.lenses.check.rays import ray_findings
from lensbench.lenses.check.single_change import with_proposal
from lensbench.lenses.check.stop import reading_findings, stop_findings
from lensbench.lenses.rows import NEAR_OBJECT
from lensbench.optics.glass import GlassError
from lensbench.optics.prescription import Lens

__all__ = ["Finding", "check"]


@np.errstate(all="ignore")          # an infinite or undefined figure fails every comparison
def check(lens: Lens) -> list[Finding]:
    """What looks wrong in a lens, the gravest first; an empty list where nothing does.

    A zoom is looked at in its first position, then at each of its stations. What the
    reader of its file had to assume comes last, as findings of the kind "reading". A lens
    that was designed for a near object is not held to a focus and to rays from infinity.
    """
    lens = lens.at(zoom=0.0, close=0.0)
    try:
        lens.indices()
    except GlassError as error:         # a glass of the infrared, say: nothing can be traced at the d line
        return [Finding("glass", None, str(error))]
    table = [*digit_findings(lens), *glass_findings(lens), *geometry_findings(lens)]
    if any(told.startswith(NEAR_OBJECT) for told in lens.findings):
        return [*table, *position_findings(lens), *reading_findings(lens)]
    return [*with_proposal(lens, figure_findings(lens)), *table, *ray_findings(lens), *position_findings(lens),
            *stop_findings(lens), *reading_findings(lens)]
