"""Wave errors of a lens over fields and colours, in place of spots: what counts where diffraction does.

The error of a ray is the optical length from the plane wave before the lens to the point where the ray passes nearest
to the image point C, which is linear in C (Welford, Aberrations of Optical Systems, 1986, section 7). Pistons of each
field and colour, the height of each field's image point and the place of the film are free.
"""

import numpy as np

from lensbench.optics.prescription import Lens
from lensbench.optics.scalar_trace import surface_table, trace_rays
from lensbench.optics.surfaces import AFTER, BEFORE


def wave_errors(lens: Lens, colours: tuple[float, ...], origins: np.ndarray, directions: np.ndarray,
                weights: np.ndarray) -> np.ndarray | None:
    """The weighted errors (mm) of the rays that count, whose sum of squares is the mean square over fields and colours.

    colours: µm. origins, directions (fields, rays, 3): parallel rays of half a pupil, mm. weights (fields, rays): 0 for
    rays that do not count. None where a ray is lost.
    """
    fields, used = len(weights), weights > 0.0
    start, way = np.ascontiguousarray(origins[used]), np.ascontiguousarray(directions[used])
    number = np.repeat(np.arange(fields), used.sum(1))
    lit = np.unique(number)
    share = np.sqrt(weights[used] / (weights.sum(1)[number] * len(colours) * fields))
    errors, basis = [], []
    for k, colour in enumerate(colours):
        table, count = surface_table(lens, colour), len(start)
        points, after, paths = np.empty((count, 3)), np.empty((count, 3)), np.empty((count, len(lens.surfaces) + 1, 3))
        fate = np.empty(count, np.int32)
        trace_rays(table, False, start, way, points, after, fate, np.empty(count, np.int32), paths, 1)
        if fate.any():
            return None
        index = table.numbers[-1, AFTER]
        steps = np.diff(paths, axis=1)             # a step back, before a surface that crosses, counts negative
        lengths = (np.sign(steps[..., 2]) * np.linalg.norm(steps, axis=2)) @ table.numbers[:, BEFORE]
        plane = table.numbers[0, BEFORE] * (start * way).sum(1)
        errors.append(share * (plane + lengths + index * (([0.0, 0.0, lens.length] - points) * after).sum(1)))
        free = np.zeros((count, len(colours) * len(lit) + len(lit) + 1))
        for j, field in enumerate(lit):
            here = number == field
            free[here, k * len(lit) + j] = share[here]
            free[here, len(colours) * len(lit) + j] = share[here] * after[here, 1]
        free[:, -1] = share * after[:, 2]
        basis.append(free)
    columns, _ = np.linalg.qr(np.concatenate(basis))
    every = np.concatenate(errors)
    return every - columns @ (columns.T @ every)
