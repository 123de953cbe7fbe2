"""The spot of what a pixel shows: the light of that point of the scene on the film, traced through the real lens.

Lengths in mm, lens frame. The point is the one that the ray through the middle of the pixel's pupil meets. Its rays
are spread evenly over its beam, across the chief ray before the lens, and traced forward to the film.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.state.build import setup
from lensbench.app.state.geometry.exit_pupil import from_film, region, turn
from lensbench.app.state.geometry.ray_fans import blockers
from lensbench.app.state.pixel.beam import beam
from lensbench.app.state.pixel.pointed import Place
from lensbench.app.state.settings import Settings
from lensbench.app.state.view_camera import seen_from

SAMPLES = 700                   # rays aimed at the box about the beam
MARGIN = 1.15                   # of that box; it grows while light passes near its edges
EDGE = 0.92                     # of the half box: light farther out may be cut
GROWN, TRIALS = 1.6, 4
EVEN = 0.7548776662466927, 0.5698402909980532       # steps of an even sequence of points (Roberts' R2)


@dataclass(frozen=True, eq=False)
class Spot:
    """Where the rays of one point of the scene meet the film.

    landings (n, 2): film points (mm) of the rays that arrive. rear (n, 2): where these cross the plane of the last
    vertex (mm). paths (n, surfaces + 2, 3): from before the lens to the film (mm). lost: for each surface how many of
    the rays in the box it ends. diameter: of the circle of confusion, 2√2 × the rms distance from the centroid (mm);
    extent: of the smallest circle about the centroid that holds all of them, its diameter (mm).
    """

    landings: np.ndarray
    rear: np.ndarray
    paths: np.ndarray
    lost: dict[int, int]
    centroid: tuple[float, float]
    diameter: float
    extent: float


def spot(settings: Settings, raster: Place) -> Spot:
    """The spot of a raster point; ValueError or OSError, with the reason, where there is none."""
    if not settings.has_lens:
        raise ValueError("This camera has no lens to trace a spot through")
    if not settings.follows_lens:
        raise ValueError("An ideal lens images every point as the same disk: see its circle of confusion")
    if settings.medium == "water" and not settings.immersed:
        raise ValueError("The spot is not traced through a window into water")
    seen = beam(settings, raster)
    if not len(seen.origins):
        raise ValueError("No light reaches this pixel")
    built = setup(settings)
    target = None
    if seen.target is not None:
        pose = settings.present_pose
        point = (seen.target - pose[:3, 3]) @ pose[:3, :3] + [0.0, 0.0, built.film_z]
        target = (float(point[0]), float(point[1]), float(point[2]))
    here, at = seen_from(settings, raster)
    return spot_of(here.lens, here.film_distance, at, target)


@lru_cache(maxsize=8)
def spot_of(lens: lb.Lens, film_distance: float, film_xy: Place, target: tuple[float, float, float] | None) -> Spot:
    """The spot of a point of the lens frame (mm), or of a point at infinity, that a film point (mm) sees.

    ValueError where no light passes between the two.
    """
    seen = region(lens, film_distance, math.hypot(*film_xy), math.atan2(film_xy[1], film_xy[0]))
    if seen.area <= 0.0:
        raise ValueError("No light reaches this pixel")
    middle = seen.outline.mean(0)
    rim = middle + 0.99 * (seen.outline[::8] - middle)
    back = from_film(lens, film_distance, film_xy, np.vstack([middle, rim]) @ turn(lens, film_xy))
    passes = back.fate == lb.Fate.PASSED
    first = int(np.argmax(passes))
    if not passes[first]:
        raise ValueError("No light reaches this pixel")

    # A plane across the chief ray before the lens, and the box of the pixel's own rays in it
    start, toward = back.points[first], back.directions[first]
    if target is not None and not (np.asarray(target) - start) @ toward > 0.0:
        raise ValueError("What this pixel shows touches the lens")
    across = np.cross(toward, [1.0, 0.0, 0.0] if abs(toward[0]) < 0.9 else [0.0, 1.0, 0.0])
    across /= np.linalg.norm(across)
    plane = np.stack([across, np.cross(toward, across)])
    run = ((start - back.points[passes]) @ toward) / (back.directions[passes] @ toward)
    met = (back.points[passes] + run[:, None] * back.directions[passes] - start) @ plane.T
    centre, half = 0.5 * (met.min(0) + met.max(0)), 0.5 * MARGIN * np.ptp(met, axis=0).max()
    half = max(half, 1e-6 * lens.surfaces[0].semi_diameter)

    k = np.arange(1, SAMPLES + 1)
    uv = 2.0 * (np.outer(k, EVEN) % 1.0) - 1.0
    for _ in range(TRIALS):
        points = start + (centre + half * uv) @ plane
        ways = points - target if target is not None else np.broadcast_to(-toward, points.shape)
        ways = ways / np.linalg.norm(ways, axis=1)[:, None]
        beginning = 4.0 * (lens.length + film_distance) + 20.0 * lens.surfaces[0].semi_diameter
        if target is not None:
            beginning = min(beginning, 0.98 * float(np.linalg.norm(start - target)))
        trace = lb.trace(lens, points - beginning * ways, ways, record=True, forward=True)
        arrived = trace.fate == lb.Fate.PASSED
        if not arrived.any() or np.abs(uv[arrived]).max() < EDGE:
            break
        half *= GROWN
    ended, counts = np.unique(blockers(lens, trace, forward=True), return_counts=True)
    lost = {int(surface): int(count) for surface, count in zip(ended, counts, strict=True) if surface >= 0}
    if not arrived.any():
        raise ValueError("No ray from what this pixel shows reaches the film")
    return _landed(lens, film_distance, trace, arrived, lost)


def _landed(lens: lb.Lens, film_distance: float, trace: lb.Trace, arrived: np.ndarray, lost: dict[int, int]) -> Spot:
    """The spot of the rays that arrive."""
    assert trace.paths is not None
    points, directions = trace.points[arrived], trace.directions[arrived]
    slopes = directions[:, :2] / directions[:, 2:]
    rear = points[:, :2] + (lens.length - points[:, 2:]) * slopes
    film_z = lens.length + film_distance
    landings = points[:, :2] + (film_z - points[:, 2:]) * slopes
    ends = np.column_stack([landings, np.full(len(landings), film_z)])
    centroid = landings.mean(0)
    away = ((landings - centroid) ** 2).sum(1)
    return Spot(landings, rear, np.concatenate([trace.paths[arrived], ends[:, None, :]], 1), lost,
                (float(centroid[0]), float(centroid[1])), 2.0 * math.sqrt(2.0 * float(away.mean())),
                2.0 * math.sqrt(float(away.max())))
