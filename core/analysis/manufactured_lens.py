"""One copy of a production run as a lens of its own, to be traced, focused and photographed like any other."""

from dataclasses import replace

import numpy as np

from lensbench.analysis.manufacture import Production
from lensbench.analysis.perturbed_copies import elements
from lensbench.optics.glass import D_LINE, MODEL_RANGE, Glass
from lensbench.optics.lens_surface import LensError
from lensbench.optics.prescription import Lens
from lensbench.optics.surface_pose import SurfacePose

LINES = 25              # wavelengths at which a changed glass is listed


def manufactured(lens: Lens, run: Production, copy: int) -> Lens:
    """A copy of a production run, with its errors of radius, thickness, index, decentre and tilt.

    Parameters
    ----------
    lens : Lens
        That of the run.
    run : Production
        As `production` gives it.
    copy : int
        Number of the copy, from 0.

    Returns
    -------
    Lens
        Focused as a whole: at the positions of its groups that `lens` has. A changed glass is a table of 25 indices,
        within 1e-6 of the exact ones.

    Raises
    ------
    LensError
        For a copy that the run does not have, or a run of another lens.
    """
    if not 0 <= copy < len(run.drawn):
        raise LensError(f"copy {copy}: this run has the copies 0 to {len(run.drawn) - 1}")
    if any(surface >= len(lens.surfaces) for _, surface in run.names):
        raise LensError("the production run belongs to another lens, with more surfaces")
    surfaces, last = list(lens.surfaces), dict(elements(lens))
    poses: dict[int, dict[str, list[float]]] = {}
    for (kind, i), error in zip(run.names, run.drawn[copy].tolist(), strict=True):
        here = surfaces[i]
        if kind == "radius":
            surfaces[i] = replace(here, curvature=here.curvature / (1.0 + error))
        elif kind == "thickness":
            surfaces[i] = replace(here, thickness=here.thickness + error)
        elif kind == "index":
            surfaces[i] = replace(here, glass=_changed(here.glass, error))
        else:
            poses.setdefault(i, {}).setdefault(kind, []).append(error)
    for first, errors in poses.items():
        (dy, dx), (about_x, about_y) = (errors.get(kind, (0.0, 0.0)) for kind in ("decentre", "tilt"))
        for i in range(first, last[first] + 1):
            surfaces[i] = replace(surfaces[i], pose=SurfacePose(dx, dy, about_x, about_y, i - first))
    return replace(lens, surfaces=tuple(surfaces), positions=None)


def _changed(glass: Glass, change: float) -> Glass:
    """The glass with an index that is higher by a number at every wavelength."""
    if not glass.disperses:
        return replace(glass, n_d=glass.n_d + change, name="")
    low, high = glass.wavelengths or MODEL_RANGE
    if low < D_LINE < high:
        low, high = max(low, MODEL_RANGE[0]), min(high, MODEL_RANGE[1])
    lines = np.clip(np.linspace(low**-2, high**-2, LINES) ** -0.5, low, high).tolist()      # even for the cubic in λ⁻²
    return Glass(glass.n_d + change, glass.v_d, "", "table",
                 tuple((line, glass.index(line) + change) for line in lines))
