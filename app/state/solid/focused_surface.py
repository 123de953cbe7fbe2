"""The surface of the scene that is in focus on the film. Lengths in mm, camera frame.

For a real lens it is curved: for each film point it lies where the beam of that point is narrowest, in mean squares
across its middle ray; between both foci of an astigmatic beam. For ideal lenses it is the plane in focus.
"""

import math
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.analysis.traced_focus import beams
from lensbench.app.state.build import setup
from lensbench.app.state.camera_kinds import camera
from lensbench.app.state.file_cache import Stamp, file_stamp
from lensbench.app.state.geometry.exit_pupil import from_film, region
from lensbench.app.state.geometry.ray_fans import lit_radius
from lensbench.app.state.settings import Settings
from lensbench.app.state.view_camera import leans, sharp_focus

RADII = 13                      # film radii from the axis to the edge of light
ACROSS, DOWN = 17, 13           # points of the surface
INSIDE = 1.0 - 1e-6             # of the edge of light, where no ray is lost by rounding
FARTHEST = 30_000.0             # mm: beyond it nothing is drawn


def focused_surface(settings: Settings) -> np.ndarray:
    """Points (DOWN, ACROSS, 3) of the focused surface over the film, NaN where it is too far or dark.

    ValueError or OSError for a camera without a focus.
    """
    if not settings.focuses:
        raise ValueError("this camera has no plane in focus")
    if settings.has_lens and settings.follows_lens:
        built = setup(settings)
        if built.lens.is_rotationally_symmetric and settings.film_pose.is_upright:
            return _curved(built.lens, built.film_distance, built.film.width, built.film.height, lit_radius(built))
        return _narrowest(built.lens, built.film_distance, built.film, settings.film_pose)
    return _plane(settings.optics, file_stamp(settings.lens))


@lru_cache(maxsize=8)
def _curved(lens: lb.Lens, film_distance: float, width: float, height: float, lit: float) -> np.ndarray:
    radii = np.linspace(0.0, lit * INSIDE, RADII)
    found = np.array([best_focus(lens, film_distance, float(r)) for r in radii])
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, ACROSS) * width, np.linspace(-0.5, 0.5, DOWN) * height)
    r = np.hypot(x, y)
    aside, z = (np.interp(INSIDE * INSIDE * r, radii, column, right=math.nan) for column in found.T)
    with np.errstate(invalid="ignore", divide="ignore"):
        along = np.where(r > 0.0, aside / r, 0.0)
    return np.stack([along * x, along * y, z - lens.length - film_distance], axis=-1)


def best_focus(lens: lb.Lens, film_distance: float, film_radius: float) -> tuple[float, float]:
    """Where the beam of the film point (0, r) is narrowest before the lens: (y, z) in mm, lens frame; NaN without one.

    With rays p = a + t b across the middle ray at the distance t along it, the mean square of p about its mean is least
    at t = −Σ a·b / Σ b·b, of the deviations of a and b from their means.
    """
    seen = region(lens, film_distance, film_radius)
    if seen.area <= 0.0:
        return math.nan, math.nan
    middle = seen.outline.mean(0)
    rings = [middle + part * (seen.outline[::16] - middle) for part in (0.5, 0.97)]
    trace = from_film(lens, film_distance, (0.0, film_radius), np.vstack([middle, *rings]))
    passes = trace.fate == lb.Fate.PASSED
    if not passes[0] or passes.sum() < 8:
        return math.nan, math.nan
    o, d = trace.points[passes], trace.directions[passes]
    start, chief = o[0], d[0]
    along = d @ chief
    a = o - start - d * (((o - start) @ chief) / along)[:, None]
    b = d / along[:, None] - chief
    a, b = a - a.mean(0), b - b.mean(0)
    spread = float((b * b).sum())
    t = -float((a * b).sum()) / spread if spread > 0.0 else math.inf
    if not 0.0 < t < FARTHEST:
        return math.nan, math.nan
    point = start + t * chief
    return float(point[1]), float(point[2])


@lru_cache(maxsize=8)
def _narrowest(lens: lb.Lens, film_distance: float, film: lb.Film, pose: lb.FilmPose) -> np.ndarray:
    """Points of the surface before a lens or a film without rotational symmetry, by a beam for each."""
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, ACROSS) * film.width, np.linspace(-0.5, 0.5, DOWN) * film.height)
    found = beams(lens, film_distance, pose.points(np.column_stack([x.ravel(), y.ravel()])), whole=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        t = 1.0 / found.nearness
        t = np.where((t > 0.0) & (t < FARTHEST), t, math.nan)
    return np.asarray((found.starts + t[:, None] * found.directions).reshape(DOWN, ACROSS, 3))


@lru_cache(maxsize=8)
def _plane(settings: Settings, lens: Stamp) -> np.ndarray:
    """Points of the plane in focus, where the rays of the film meet it."""
    of = camera(settings)
    x, y = np.meshgrid(np.linspace(0.0, of.film.pixels_x, ACROSS), np.linspace(0.0, of.film.pixels_y, DOWN))
    raster = np.column_stack([x.ravel(), y.ravel()])
    rays = of.with_open_stop.generate_rays(raster, np.tile(of.pupil_centre, (len(raster), 1)))
    with np.errstate(invalid="ignore", divide="ignore"):
        tilted = sharp_focus(settings) if leans(settings) else None
        if tilted is not None and tilted.plane is not None:
            t = -tilted.plane.distance(rays.origins) / (rays.directions @ tilted.plane.normal)
        else:
            t = (-settings.focus_distance - rays.origins[:, 2]) / rays.directions[:, 2]
        good = (rays.weights > 0.0) & (t > 0.0) & (t < FARTHEST)
    points = np.full((len(raster), 3), math.nan)
    points[good] = rays.origins[good] + t[good, None] * rays.directions[good]
    return points.reshape(DOWN, ACROSS, 3)
