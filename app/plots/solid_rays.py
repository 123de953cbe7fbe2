"""Rays in space, and the surface of the scene that is in focus. Lengths in mm, camera frame.

For a real lens it is curved: for each film point it lies where the beam of that point is narrowest, in mean squares
across its middle ray; between both foci of an astigmatic beam. For ideal lenses it is the plane in focus.
"""

import math
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import bench_of
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.focus_plane import leans, seen_from, sharp_focus
from lensbench.app.bench.ray_fans import lit_radius
from lensbench.app.plots.exit_pupil import from_film, region, region_of, turn
from lensbench.app.plots.pixel_rays import Place, PointedRay, beam, path_of
from lensbench.app.plots.section import Sketch
from lensbench.app.plots.solids import Strokes, strokes
from lensbench.app.scenes.asset_files import Stamp, file_stamp
from lensbench.app.settings.settings import Settings
from lensbench.core.analysis.focus_wedge import beams
from lensbench.core.cameras.flat_port import FlatPort

RADII = 13                      # film radii from the axis to the edge of light
ACROSS, DOWN = 17, 13           # points of the surface
INSIDE = 1.0 - 1e-6             # of the edge of light, where no ray is lost by rounding
FOCUSED_SURFACE_FARTHEST = 30_000.0             # mm: beyond it nothing is drawn


def focused_surface(settings: Settings) -> np.ndarray:
    """Points (DOWN, ACROSS, 3) of the focused surface over the film, NaN where it is too far or dark.

    ValueError or OSError for a camera without a focus.
    """
    if not settings.focuses:
        raise ValueError("this camera has no plane in focus")
    if settings.has_lens and settings.follows_lens:
        built = bench_of(settings)
        if built.lens.is_rotationally_symmetric and settings.film_pose.is_upright:
            return _curved(built.lens, built.film_distance, built.film.width, built.film.height, lit_radius(built))
        return _narrowest(built.lens, built.film_distance, built.film, settings.film_pose)
    return _plane(settings.optics, file_stamp(settings.lens))


@lru_cache(maxsize=8)
def _curved(lens: lb.Lens, film_distance: float, width: float, height: float, lit: float) -> np.ndarray:
    radii = np.linspace(0.0, lit * INSIDE, RADII)
    foci = np.array([best_focus(lens, film_distance, float(r)) for r in radii])
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, ACROSS) * width, np.linspace(-0.5, 0.5, DOWN) * height)
    r = np.hypot(x, y)
    aside, z = (np.interp(INSIDE * INSIDE * r, radii, column, right=math.nan) for column in foci.T)
    with np.errstate(invalid="ignore", divide="ignore"):
        along = np.where(r > 0.0, aside / r, 0.0)
    return np.stack([along * x, along * y, z - lens.length - film_distance], axis=-1)


def best_focus(lens: lb.Lens, film_distance: float, film_radius: float) -> tuple[float, float]:
    """Where the beam of the film point (0, r) is narrowest before the lens: (y, z) in mm, lens frame; NaN without one.

    With rays p = a + t b across the middle ray at the distance t along it, the mean square of p about its mean is least
    at t = −Σ a·b / Σ b·b, of the deviations of a and b from their means.
    """
    pupil = region(lens, film_distance, film_radius)
    if pupil.area <= 0.0:
        return math.nan, math.nan
    middle = pupil.outline.mean(0)
    rings = [middle + share * (pupil.outline[::16] - middle) for share in (0.5, 0.97)]
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
    if not 0.0 < t < FOCUSED_SURFACE_FARTHEST:
        return math.nan, math.nan
    point = start + t * chief
    return float(point[1]), float(point[2])


@lru_cache(maxsize=8)
def _narrowest(lens: lb.Lens, film_distance: float, film: lb.Film, pose: lb.FilmPose) -> np.ndarray:
    """Points of the surface before a lens or a film without rotational symmetry, by a beam for each."""
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, ACROSS) * film.width, np.linspace(-0.5, 0.5, DOWN) * film.height)
    narrowest = beams(lens, film_distance, pose.points(np.column_stack([x.ravel(), y.ravel()])), whole=True)
    with np.errstate(invalid="ignore", divide="ignore"):
        t = 1.0 / narrowest.nearness
        t = np.where((t > 0.0) & (t < FOCUSED_SURFACE_FARTHEST), t, math.nan)
    return np.asarray((narrowest.starts + t[:, None] * narrowest.directions).reshape(DOWN, ACROSS, 3))


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
        good = (rays.weights > 0.0) & (t > 0.0) & (t < FOCUSED_SURFACE_FARTHEST)
    points = np.full((len(raster), 3), math.nan)
    points[good] = rays.origins[good] + t[good, None] * rays.directions[good]
    return points.reshape(DOWN, ACROSS, 3)


FIELDS = ("field0", "field1", "field2")
RIM = 16                        # rays along the edge of a pixel's beam
RAY_LINES_FARTHEST = 20_000.0             # mm


def fan_lines(shown: Sketch, focus_distance: float) -> tuple[Strokes, ...]:
    """The section's rays that reach the film, from where they are in focus, one of the FIELDS after the other."""
    return tuple(strokes(kind, [_extended(_in_space(ray.path, shown.film_z), focus_distance, shown.port)
                                for ray in fan.rays if ray.kind != "dead"])
                 for kind, fan in zip(FIELDS, shown.fans, strict=True))


def lost_lines(shown: Sketch, surfaces: tuple[int, ...]) -> Strokes:
    """The section's rays that one of these surfaces ends."""
    return strokes("lost", [_in_space(ray.path, shown.film_z) for fan in shown.fans for ray in fan.rays
                            if ray.kind == "dead" and ray.surface in surfaces])


def _in_space(path: np.ndarray, film_z: float) -> np.ndarray:
    """A path (n, 2) of the section as (n, 3)."""
    return np.column_stack([np.zeros(len(path)), path[:, 1], path[:, 0] - film_z])


def _extended(path: np.ndarray, focus_distance: float, port: FlatPort) -> np.ndarray:
    """A path whose first stretch runs to the plane in focus, or far before the lens."""
    path, way = _at_window(path, port)
    reaches = math.isfinite(focus_distance) and way[2] < -0.05
    along = (-focus_distance - path[0, 2]) / way[2] if reaches else RAY_LINES_FARTHEST
    return np.vstack([path[0] + min(max(along, 0.0), RAY_LINES_FARTHEST) * way, path])


def _at_window(path: np.ndarray, port: FlatPort) -> tuple[np.ndarray, np.ndarray]:
    """A path without its first stretch, up to the window where there is one, and the unit vector on towards the scene.

    Snell's law at the window, which lies across z.
    """
    way = path[0] - path[1]
    way /= np.linalg.norm(way)
    if port.index == 1.0 or not way[2] < 0.0:
        return path[1:], way
    window = path[1] + (-port.window - path[1, 2]) / way[2] * way
    x, y = way[:2] / port.index
    return np.vstack([window, path[1:]]), np.array([x, y, -math.sqrt(1.0 - x * x - y * y)])


def pixel_lines(settings: Settings, raster: Place) -> Strokes:
    """The beam of a pixel, up to what it shows; ValueError or OSError where there is no camera."""
    rays = beam(settings, raster)
    pose = settings.present_pose
    if settings.has_lens and settings.follows_lens:
        built, xy = seen_from(settings, raster)
        outline = region_of(built.lens, built.film_distance, xy).outline
        if not len(outline):
            return strokes("pixel", [])
        middle = outline.mean(0)
        rim = middle + 0.995 * (outline[:: max(len(outline) // RIM, 1)] - middle)
        trace = from_film(built.lens, built.film_distance, xy, np.vstack([middle, rim]) @ turn(built.lens, xy),
                          record=True)
        far = min(rays.along, RAY_LINES_FARTHEST) if rays.along > 0.0 else RAY_LINES_FARTHEST
        paths = []
        for i in np.flatnonzero(trace.fate == lb.Fate.PASSED):
            path = path_of(built.lens, trace, int(i)) - [0.0, 0.0, bench_of(settings).film_z]
            path, way = _at_window(path, built.port)
            paths.append(np.vstack([path[0] + far * way, path]))
        return strokes("pixel", paths)
    ends = rays.origins + np.minimum(rays.ends, RAY_LINES_FARTHEST)[:, None] * rays.directions
    local = [(points - pose[:3, 3]) @ pose[:3, :3] for points in (ends, rays.origins)]
    return Strokes("pixel", np.stack(local, axis=1))


def pointed_line(ray: PointedRay, film_z: float) -> Strokes:
    """One ray of a plot."""
    return strokes("pointed", [ray.path - [0.0, 0.0, film_z]])
