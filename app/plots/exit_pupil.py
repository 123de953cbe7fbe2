"""Exit-pupil regions of film points, and samples of the bounding box of one.

Lengths in mm on the plane of the last vertex. Regions are upright, as in the section: where only blades break the
symmetry of a lens, they are turned about the axis until the film point is (0, +r). For a lens with a cylinder or
toroid they are not turned. Pure functions of values.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.bench.ray_fans import blockers
from lensbench.core.lens_models.polynomial import SPREAD

SAMPLES = 512                   # of the box
UP = 0.5 * math.pi              # azimuth of a film point on +y


@dataclass(frozen=True, eq=False)
class Region:
    """The region of one film point: outline (m, 2) as (x, y), its box x0 y0 x1 y1, area (mm²); empty where dark."""

    film_radius: float
    outline: np.ndarray
    box: tuple[float, float, float, float]
    area: float


@dataclass(frozen=True, eq=False)
class BoxSamples:
    """Points (n, 2) spread evenly over the box of a region, also the first few of them.

    passes (n,): whether light passes there. blocked_by (n,): index of the surface that ends the ray, −1 for one that
    passes.
    """

    points: np.ndarray
    passes: np.ndarray
    blocked_by: np.ndarray

    @property
    def rate(self) -> float:
        """The part that passes."""
        return float(self.passes.mean()) if len(self.passes) else 0.0


def even_points(count: int) -> np.ndarray:
    """Points (n, 2) spread evenly over the unit square, without visible rows: the R2 sequence of Roberts (2018)."""
    return np.outer(np.arange(1, count + 1), SPREAD) % 1.0


def turn(lens: lb.Lens, film_xy: tuple[float, float]) -> np.ndarray:
    """Rotation (2, 2) about the axis that brings a film point (mm) to (0, +r); the identity for a lens without
    rotational symmetry.

    Upright points are `points @ turn.T`, points of the lens frame `upright @ turn`.
    """
    r = math.hypot(*film_xy)
    if r == 0.0 or not lens.is_rotationally_symmetric:
        return np.eye(2)
    x, y = film_xy[0] / r, film_xy[1] / r
    return np.array([[y, -x], [x, y]])


def film_point(film_radius: float, azimuth: float) -> tuple[float, float]:
    """The film point (x, y) in mm at a radius and an azimuth (radians)."""
    if azimuth == UP:
        return 0.0, film_radius
    return film_radius * math.cos(azimuth), film_radius * math.sin(azimuth)


def region(lens: lb.Lens, film_distance: float, film_radius: float, azimuth: float = UP) -> Region:
    """The region that passes light from a film point; LensError where the film lies in the lens.

    azimuth: of the film point (radians); it matters for a stop with blades and for a lens without
    rotational symmetry.
    """
    return _region(lens, film_distance, film_radius, UP if _is_round(lens) else azimuth)


def region_of(lens: lb.Lens, film_distance: float, film_xy: tuple[float, float]) -> Region:
    """The region of a film point (x, y), mm; as `region`."""
    return region(lens, film_distance, math.hypot(*film_xy), math.atan2(film_xy[1], film_xy[0]))


def _is_round(lens: lb.Lens) -> bool:
    """Whether the azimuth of a film point does not count."""
    return lens.iris.is_round and lens.is_rotationally_symmetric


@lru_cache(maxsize=64)
def _region(lens: lb.Lens, film_distance: float, film_radius: float, azimuth: float) -> Region:
    dark = Region(film_radius, np.zeros((0, 2)), (0.0, 0.0, 0.0, 0.0), 0.0)
    if _is_round(lens):
        pupil = lb.exit_pupil(lens, film_distance, [film_radius])
        if not pupil.area[0] > 0.0:
            return dark
        x0, y0, x1, y1 = (float(v) for v in pupil.bounds[0])
        x, y = pupil.boundary(0).T                  # of a film point on the x axis
        return Region(film_radius, np.column_stack([-y, x]), (y0, x0, y1, x1), float(pupil.area[0]))
    film_xy = film_point(film_radius, azimuth)
    outline = lb.open_region(lens, film_distance, film_xy)
    if not len(outline):
        return dark
    outline = outline @ turn(lens, film_xy).T
    x, y = outline.T
    area = 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
    return Region(film_radius, outline, (float(x.min()), float(y.min()), float(x.max()), float(y.max())), area)


def box_samples(lens: lb.Lens, film_distance: float, film_radius: float, azimuth: float = UP) -> BoxSamples:
    """Evenly spread samples of the bounding box, which pbrt samples, traced from the film point; see `region`."""
    return _box_samples(lens, film_distance, film_radius, UP if _is_round(lens) else azimuth)


@lru_cache(maxsize=16)
def _box_samples(lens: lb.Lens, film_distance: float, film_radius: float, azimuth: float) -> BoxSamples:
    outlined = region(lens, film_distance, film_radius, azimuth)
    if outlined.area <= 0.0:
        return BoxSamples(np.zeros((0, 2)), np.zeros(0, bool), np.zeros(0, int))
    uv = even_points(SAMPLES)
    x0, y0, x1, y1 = outlined.box
    points = [x0, y0] + uv * [x1 - x0, y1 - y0]
    film_xy = film_point(film_radius, azimuth)
    trace = from_film(lens, film_distance, film_xy, points @ turn(lens, film_xy))
    return BoxSamples(points, trace.fate == lb.Fate.PASSED, blockers(lens, trace, forward=False))


def from_film(lens: lb.Lens, film_distance: float, film_xy: tuple[float, float], rear: np.ndarray,
              record: bool = False) -> lb.Trace:
    """Rays from a film point (mm) through points (n, 2) of the plane of the last vertex, traced to the scene."""
    film = np.array([*film_xy, lens.length + film_distance])
    return lb.trace(lens, film[None, :], np.column_stack([rear, np.full(len(rear), lens.length)]) - film,
                    record=record)
