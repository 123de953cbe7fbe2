"""The spot of what a pixel shows, and the numbers of that pixel.

Lengths in mm, lens frame. The point is the one that the ray through the middle of the pixel's pupil meets. Its rays
are spread evenly over its beam, across the chief ray before the lens, and traced forward to the film.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.bench.build import bench_of
from lensbench.app.bench.focus_plane import seen_from
from lensbench.app.bench.ray_fans import blockers
from lensbench.app.plots.blur import Blur
from lensbench.app.plots.exit_pupil import even_points, from_film, region, region_of, turn
from lensbench.app.plots.pixel_rays import Place, beam, beginning_before, film_place
from lensbench.app.settings.settings import Settings

SAMPLES = 700                   # rays aimed at the box about the beam
MARGIN = 1.15                   # of that box; it grows while light passes near its edges
EDGE = 0.92                     # of the half box: light farther out may be cut
GROWN, TRIALS = 1.6, 4


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
    rays = beam(settings, raster)
    if not len(rays.origins):
        raise ValueError("No light reaches this pixel")
    built = bench_of(settings)
    target = None
    if rays.target is not None:
        pose = settings.present_pose
        point = (rays.target - pose[:3, 3]) @ pose[:3, :3] + [0.0, 0.0, built.film_z]
        target = (float(point[0]), float(point[1]), float(point[2]))
    there, film_xy = seen_from(settings, raster)
    return spot_of(there.lens, there.film_distance, film_xy, target)


@lru_cache(maxsize=8)
def spot_of(lens: lb.Lens, film_distance: float, film_xy: Place, target: tuple[float, float, float] | None) -> Spot:
    """The spot of a point of the lens frame (mm), or of a point at infinity, that a film point (mm) sees.

    ValueError where no light passes between the two.
    """
    pupil = region_of(lens, film_distance, film_xy)
    if pupil.area <= 0.0:
        raise ValueError("No light reaches this pixel")
    middle = pupil.outline.mean(0)
    rim = middle + 0.99 * (pupil.outline[::8] - middle)
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

    uv = 2.0 * even_points(SAMPLES) - 1.0
    for _ in range(TRIALS):
        points = start + (centre + half * uv) @ plane
        ways = points - target if target is not None else np.broadcast_to(-toward, points.shape)
        ways = ways / np.linalg.norm(ways, axis=1)[:, None]
        beginning = beginning_before(lens, film_distance)
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


@dataclass(frozen=True, eq=False)
class PixelReadings:
    """Figures of a raster point; None where a figure has no meaning.

    film: the film point (mm), as the lens forms its image;
    of a panorama, which has no film, None. thing: what the pixel shows; "sky", or "" without light.
    ahead, along: its distance (mm) along the axis from where the focus is measured, and along the ray. diameter: of
    its circle of confusion on the film (mm); pixels: the same in pixels; traced: by rays of the real lens, not by the
    formula of an ideal one; no_blur: why there is none. light: of the axis without vignetting, as a part; open: the
    exit-pupil region against that of the axis, by area.
    """

    raster: Place
    film: Place | None
    thing: str
    ahead: float
    along: float
    diameter: float | None
    pixels: float | None
    traced: bool
    no_blur: str
    light: float
    open: float | None


def pixel_readings(settings: Settings, raster: Place) -> PixelReadings:
    """The figures of a raster point; ValueError or OSError where there is no camera."""
    rays, pitch = beam(settings, raster), settings.film.pitch
    diameter, traced, why = None, False, ""
    if not len(rays.origins):
        why = "no light reaches this pixel"
    elif settings.has_lens and settings.follows_lens:
        try:
            diameter, traced = spot(settings, raster).diameter, True
        except ValueError as error:
            why = str(error)
    else:
        blur = Blur.of(settings)
        if blur.blurs:
            diameter = pitch * blur.pixels(rays.ahead, (raster[0] / settings.film.pixels_x,
                                                        raster[1] / settings.film.pixels_y))
        else:
            why = "this camera has no plane in focus"
    film = None if settings.kind.panorama else film_place(settings, raster)
    return PixelReadings(raster, film, _named(rays.thing, rays.along), rays.ahead, rays.along, diameter,
                         None if diameter is None else diameter / pitch, traced, why, rays.light,
                         _open(settings, raster))


def _named(thing: str, along: float) -> str:
    return "" if math.isnan(along) else "sky" if math.isinf(along) else thing


def _open(settings: Settings, raster: Place) -> float | None:
    """Area of the region of a film point against that of the axis."""
    if not (settings.has_lens and settings.follows_lens):
        return None
    built, film_xy = seen_from(settings, raster)
    axis = region(built.lens, bench_of(settings).film_distance, 0.0).area
    area = region_of(built.lens, built.film_distance, film_xy).area
    return area / axis if axis > 0.0 else None


def colour_of(image: NDArray[np.float32] | None, raster: Place) -> tuple[float, float, float] | None:
    """Red, green and blue of a pixel of a picture (h, w, 3); None outside it or without one."""
    if image is None or not (0 <= raster[1] < image.shape[0] and 0 <= raster[0] < image.shape[1]):
        return None
    red, green, blue = (float(value) for value in image[int(raster[1]), int(raster[0])])
    return red, green, blue
