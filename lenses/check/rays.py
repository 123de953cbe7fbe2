"""Real rays near the axis: they must pass, and meet where the paraxial ones do."""

from math import isinf

import numpy as np

from lensbench.kernels.figures import fixed, significant
from lensbench.optics.finding import Finding, Kind
from lensbench.optics.paraxial import first_order
from lensbench.optics.prescription import Lens
from lensbench.optics.scalar_trace import Fate, trace

HEIGHTS = np.array([0.02, 0.1, 0.2, 0.3, 0.4, 0.5])     # of the entrance pupil; near its rim good lenses clip
SPREAD = 0.25                   # of the focal length, at half the aperture: a fast fisheye reaches a tenth of that
WORDS = {
    Fate.MISSED: "misses surface {0}", Fate.CLIPPED: "falls outside the rim of surface {0}",
    Fate.TOTAL_REFLECTION: "is totally reflected at surface {0}", Fate.BACKWARD: "is bent backward at surface {0}",
}


def ray_findings(lens: Lens) -> list[Finding]:
    """The lowest ray parallel to the axis, up to half the aperture, that fails or lands far from the focus."""
    fo = first_order(lens)
    pupil = fo.entrance_pupil.radius
    if isinf(fo.efl) or isinf(pupil):
        return []
    heights = HEIGHTS * pupil
    before = -sum(s.semi_diameter for s in lens.surfaces[:1]) - pupil
    start = np.stack([0.0 * heights, heights, np.full_like(heights, before)], axis=1)
    rays = trace(lens, start, [0.0, 0.0, 1.0])
    failed = np.flatnonzero(rays.fate)
    if failed.size:
        first = failed[0]
        fate = Fate(rays.fate[first])
        ended = int(rays.surface[first]) + (fate == Fate.MISSED)
        return [Finding(Kind.RAY, ended, f"a ray {significant(heights[first], 4)} mm from the axis, "
                                         f"{fixed(100.0 * HEIGHTS[first], 0)} % "
                                      f"of the aperture's radius, {WORDS[fate].format(ended)}")]
    to_focus = lens.length + fo.bfl - rays.points[:, 2]
    miss = np.abs(rays.points[:, 1] + to_focus * rays.directions[:, 1] / rays.directions[:, 2])
    far = np.flatnonzero(miss > SPREAD * abs(fo.efl))
    if not far.size:
        return []
    first = far[0]
    return [Finding(Kind.RAY, None, f"a ray {significant(heights[first], 4)} mm from the axis, "
                                    f"{fixed(100.0 * HEIGHTS[first], 0)} % of "
                                 f"the aperture's radius, lands {significant(miss[first], 3)} mm beside the focus")]
