"""What is in focus on film points of a lens without rotational symmetry, by traced beams.

Camera frame, mm. A beam has its focus where it looks narrowest from the place at which it leaves the lens, in mean
squares: between both foci of an astigmatic beam. Foci are given by their nearness, 1/mm, which passes through 0 where
they go beyond infinity.
"""

from dataclasses import dataclass

import numpy as np

from lensbench.optics.prescription import Lens
from lensbench.optics.scalar_trace import Fate, trace
from lensbench.pupils.ray_aiming import Aim

ACROSS = 1e-3                   # of the stop's radius: half the width of a narrow beam
NARROW = ACROSS * np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
RAYS = 256                      # of a whole beam, over the open stop
BEYOND = 1.1                    # × the stop's radius: how far they reach, for images of the stop that are not linear
LEAST = 3                       # rays that have a focus


@dataclass(frozen=True, eq=False)
class Beams:
    """Beams of film points: where each leaves the lens (n, 3), its unit direction (n, 3), nearness (n,) of its focus.

    The nearness is one over the distance along the beam. across (n, 3, 3): mean squares and products of how far its
    rays leave the lens beside its middle (mm²); mixed (n, 3, 3): those of these places, by rows, and the slopes of the
    rays against it, by columns (mm); slopes (n, 3, 3): those of the slopes. NaN without light.
    """

    starts: np.ndarray
    directions: np.ndarray
    nearness: np.ndarray
    across: np.ndarray
    mixed: np.ndarray
    slopes: np.ndarray

    @property
    def foci(self) -> np.ndarray:
        """Foci (n, 4) in homogeneous coordinates."""
        return np.column_stack([self.starts * self.nearness[:, None] + self.directions, self.nearness])

    @property
    def depth_nearness(self) -> np.ndarray:
        """One over the distance (n,) from the film's plane, along the axis of the camera, to the foci."""
        x, y, z, w = self.foci.T
        return np.asarray(-w / z)


def beams(lens: Lens, film_distance: float, film: np.ndarray, whole: bool = False) -> Beams:
    """Beams of film points (n, 3), narrow about the ray through the middle of the stop, or of the whole open stop."""
    aim = Aim(lens, film_distance)
    centres, images = aim.stop_centres(film, aim.paraxial_centres(film))
    sides = _disc(RAYS) if whole else NARROW
    rear = centres[:, None] + sides @ images.transpose(0, 2, 1)
    back = lens.length + film_distance
    starts = np.repeat(film + [0.0, 0.0, back], len(sides), 0)
    ways = np.concatenate([rear, np.full((*rear.shape[:2], 1), lens.length)], 2).reshape(-1, 3) - starts
    sent = np.isfinite(ways).all(1)
    met = trace(lens, starts, np.where(sent[:, None], ways, [0.0, 0.0, -1.0]), clip=whole)
    passed = (sent & (met.fate == Fate.PASSED)).reshape(len(film), len(sides), 1)
    passed = passed & (passed.sum(1, keepdims=True) >= (LEAST if whole else len(sides)))
    points, directions = (np.where(passed, values.reshape(len(film), len(sides), 3), 0.0)
                          for values in (met.points, met.directions))

    # About the mean ray, at its distance t: a + t b, which looks narrowest at 1/t = −Σ a·b / Σ a·a
    with np.errstate(divide="ignore", invalid="ignore"):            # no ray
        count = passed.sum(1)
        start, along = points.sum(1) / count, directions.sum(1)
        along /= np.linalg.norm(along, axis=1)[:, None]
        cosines = (directions * along[:, None]).sum(2, keepdims=True)
        a = points - start[:, None]
        a = a - directions * ((a * along[:, None]).sum(2, keepdims=True) / cosines)
        b = directions / cosines
        a, b = (np.where(passed, values - np.where(passed, values, 0.0).sum(1, keepdims=True) / count[:, None], 0.0)
                for values in (a, b))
        across, mixed, slopes = (np.einsum("nri,nrj->nij", one, two) / count[..., None]
                                 for one, two in ((a, a), (a, b), (b, b)))
        nearness = -np.trace(mixed, axis1=1, axis2=2) / np.trace(across, axis1=1, axis2=2)
    return Beams(start - [0.0, 0.0, back], along, nearness, across, mixed, slopes)


def focused_plane(lens: Lens, film_distance: float, film: np.ndarray) -> np.ndarray | None:
    """Plane (4,) with normal · p + last number = 0 that is in focus on the plane of film points (n, 3).

    It is fitted to the foci in homogeneous coordinates, in which it may lie at infinity or behind the lens. None where
    a film point sees no ray through the middle of the stop.
    """
    foci = beams(lens, film_distance, film).foci
    if not np.isfinite(foci).all():
        return None
    foci /= np.linalg.norm(foci, axis=1)[:, None]
    return np.asarray(np.linalg.svd(foci)[2][-1])


def _disc(count: int) -> np.ndarray:
    """Points (count, 2) over a disc of the stop, evenly: the spiral of the golden angle."""
    k = np.arange(count)
    radius, angle = BEYOND * np.sqrt((k + 0.5) / count), k * np.pi * (3.0 - np.sqrt(5.0))
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
