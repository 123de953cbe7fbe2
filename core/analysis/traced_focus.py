"""The plane in focus of a lens without rotational symmetry, by narrow traced beams near the axis.

Camera frame, mm. The beam of each film point is narrow about the ray through the middle of the stop; its focus is where
it is narrowest in mean squares, between both foci of an astigmatic beam. A plane is fitted to the foci in homogeneous
coordinates, in which it may lie at infinity or behind the lens.
"""

import numpy as np

from lensbench.optics.prescription import Lens
from lensbench.optics.scalar_trace import trace
from lensbench.pupils.ray_aiming import Aim

ACROSS = 1e-3                   # of the stop's radius: half the width of a beam


def focused_plane(lens: Lens, film_distance: float, film: np.ndarray) -> np.ndarray | None:
    """Plane (4,) with normal · p + last number = 0 that is in focus on the plane of film points (n, 3).

    None where a film point sees no ray through the middle of the stop.
    """
    aim = Aim(lens, film_distance)
    centres, images = aim.stop_centres(film, aim.paraxial_centres(film))
    sides = ACROSS * np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    rear = centres[:, None] + sides @ images.transpose(0, 2, 1)
    back = lens.length + film_distance
    starts = np.repeat(film + [0.0, 0.0, back], len(sides), 0)
    ways = np.concatenate([rear, np.full((*rear.shape[:2], 1), lens.length)], 2).reshape(-1, 3) - starts
    met = trace(lens, starts, ways, clip=False)
    points, directions = (values.reshape(len(film), len(sides), 3) for values in (met.points, met.directions))
    if not (np.isfinite(points).all() and np.isfinite(directions).all()):
        return None
    # Across the chief ray at its distance t: a + t b; narrowest at t = −Σ a·b / Σ b·b
    start, chief = points[:, :1] - [0.0, 0.0, back], directions[:, :1]
    along = (directions * chief).sum(2, keepdims=True)
    a = points - points[:, :1]
    a = a - directions * ((a * chief).sum(2, keepdims=True) / along)
    b = directions / along - chief
    spread, t = (b * b).sum((1, 2))[:, None], -(a * b).sum((1, 2))[:, None]
    foci = np.concatenate([spread * start[:, 0] + t * chief[:, 0], spread], 1)
    foci /= np.linalg.norm(foci, axis=1)[:, None]
    return np.asarray(np.linalg.svd(foci)[2][-1])
