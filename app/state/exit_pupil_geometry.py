"""Exit-pupil regions of film points, and samples of the bounding box of one.

Lengths in mm on the plane of the last vertex; the film point is (0, +r), as in the section. Pure functions of values.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

import lensbench as lb

SAMPLES = 1024                  # of the box


@dataclass(frozen=True, eq=False)
class Region:
    """The region of one film point: outline (m, 2) as (x, y), its box x0 y0 x1 y1, area (mm²); empty where dark."""

    film_radius: float
    outline: np.ndarray
    box: tuple[float, float, float, float]
    area: float


@dataclass(frozen=True, eq=False)
class BoxSamples:
    """Points (n, 2) spread evenly over the box of a region, also the first few of them, and which pass (n,)."""

    points: np.ndarray
    passes: np.ndarray

    @property
    def rate(self) -> float:
        """The part that passes."""
        return float(self.passes.mean()) if len(self.passes) else 0.0


@lru_cache(maxsize=64)
def region(lens: lb.Lens, film_distance: float, film_radius: float) -> Region:
    """The region that passes light from a film point; LensError where the film lies in the lens."""
    dark = Region(film_radius, np.zeros((0, 2)), (0.0, 0.0, 0.0, 0.0), 0.0)
    if lens.iris.is_round and lens.is_rotationally_symmetric:
        pupil = lb.exit_pupil(lens, film_distance, [film_radius])
        if not pupil.area[0] > 0.0:
            return dark
        x0, y0, x1, y1 = (float(v) for v in pupil.bounds[0])
        x, y = pupil.boundary(0).T                  # of a film point on the x axis
        return Region(film_radius, np.column_stack([-y, x]), (y0, x0, y1, x1), float(pupil.area[0]))
    outline = lb.open_region(lens, film_distance, (0.0, film_radius))
    if not len(outline):
        return dark
    x, y = outline.T
    area = 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
    return Region(film_radius, outline, (float(x.min()), float(y.min()), float(x.max()), float(y.max())), area)


@lru_cache(maxsize=16)
def box_samples(lens: lb.Lens, film_distance: float, film_radius: float) -> BoxSamples:
    """Evenly spread samples of the bounding box, which pbrt samples, traced from the film point."""
    seen = region(lens, film_distance, film_radius)
    if seen.area <= 0.0:
        return BoxSamples(np.zeros((0, 2)), np.zeros(0, bool))
    # The R2 sequence: even, without visible rows
    k = np.arange(1, SAMPLES + 1)
    uv = np.stack([k * 0.7548776662466927, k * 0.5698402909980532], axis=1) % 1.0
    x0, y0, x1, y1 = seen.box
    points = [x0, y0] + uv * [x1 - x0, y1 - y0]
    film = np.array([0.0, film_radius, lens.length + film_distance])
    directions = np.column_stack([points, np.full(SAMPLES, lens.length)]) - film
    passes = lb.trace(lens, film[None, :], directions).fate == lb.Fate.PASSED
    return BoxSamples(points, passes)
