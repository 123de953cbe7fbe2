"""Foci of narrow beams about the chief rays of a ray grid, for lenses of any symmetry.

Lengths in mm. Two rays close to the chief ray on either side of it in the pupil cross it at its focus: the sagittal
focus for rays beside it along the sagittal axis, the tangential one for the other. `field_curves` has the same for
lenses of rotational symmetry by Coddington's equations. In other wavelengths the beam is about the same ray of the
object, the chief ray of the primary wavelength.
"""

import numpy as np

from lensbench.analysis.grids.field_beams import OFFSET_S, OFFSET_T, SLOPE_S, SLOPE_T
from lensbench.analysis.grids.traced_grid import RayGrid

STEP = 1e-4             # of the pupil coordinates, to either side of the chief ray


def close_foci(rays: RayGrid) -> np.ndarray:
    """Sagittal and tangential foci of each field and wavelength.

    Parameters
    ----------
    rays : RayGrid
        From `ray_grid`.

    Returns
    -------
    ndarray
        (F, C, 2) focus behind the film, mm along +z, sagittal and tangential; NaN for a field without a chief ray.
    """
    beams, count = rays.beams, len(rays.images)
    s = beams.chief_pupil[:, :1] + STEP * np.array([1.0, -1.0, 0.0, 0.0])
    t = beams.chief_pupil[:, 1:] + STEP * np.array([0.0, 0.0, 1.0, -1.0])
    places = beams.towards_scene(s, t)[0].reshape(-1, 2)
    of_field = np.repeat(np.arange(count), 4)
    known = np.isfinite(places).all(1)
    starts = beams.starts(of_field, places)
    foci = np.full((count, len(rays.conditions.wavelengths), 2), np.nan)
    for c, line in enumerate(rays.conditions.wavelengths):
        landed, _ = beams.forward(line, of_field, starts)
        for a, (offset, slope) in enumerate(((OFFSET_S, SLOPE_S), (OFFSET_T, SLOPE_T))):
            apart, turned = (np.where(known, landed[row], np.nan).reshape(-1, 4)[:, 2 * a:2 * a + 2] @ [1.0, -1.0]
                             for row in (offset, slope))
            with np.errstate(divide="ignore", invalid="ignore"):
                foci[:, c, a] = -apart / turned
    return foci
