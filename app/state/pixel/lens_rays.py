"""Rays of one pixel through its lens, for the section, and single rays of its pupil and its spot.

Lengths in mm. Rays are traced from the pixel's film point in the lens frame. The section shows the plane of the axis
and the film point: a lens of rotational symmetry is turned about its axis until the film point lies at (0, +r); the
rays of a lens with cylinders are projected onto the section y–z.
"""

import math
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.state.build import Setup, setup
from lensbench.app.state.camera_kinds import readings
from lensbench.app.state.geometry.exit_pupil import from_film, region, turn
from lensbench.app.state.geometry.ray_fans import DARK, Fan, Ray, blockers, end_text, ideal_fan, ideal_lens_fan
from lensbench.app.state.geometry.top_view import quarter_turned
from lensbench.app.state.pixel.beam import landing
from lensbench.app.state.pixel.pointed import Place, PointedRay
from lensbench.app.state.settings import Settings
from lensbench.app.state.view_camera import seen_from
from lensbench.app.state.water_window import port_of

COUNT = 9                       # rays that reach the scene
DEAD_EACH_SIDE = 3
INSIDE = 1.0 - 1e-5             # of the way to the outline, whose chords and bisections err by a part of this


def film_place(settings: Settings, raster: Place) -> Place:
    """The film point (x, y) in mm of a raster point, lens frame: upside down on the film."""
    film = settings.film
    at = (0.5 - raster[0] / film.pixels_x) * film.width, (raster[1] / film.pixels_y - 0.5) * film.height
    if settings.film_pose.is_upright:
        return at
    x, y, _ = settings.film_pose.points(np.array([at]))[0].tolist()
    return x, y


def pixel_fan(settings: Settings, raster: Place, above: bool = False) -> Fan:
    """The rays of a raster point in the section; ValueError or OSError for a camera without any lens.

    above: in the section x–z of a lens without rotational symmetry.
    """
    at = film_place(settings, raster)
    if settings.kind.ideal_lens:
        return _perspective_fan(settings.optics, math.hypot(*at))
    if not settings.has_lens:
        raise ValueError(f"{settings.camera_title}: no lens to draw the rays in")
    built, _ = seen_from(settings, raster)
    if not settings.follows_lens:
        return ideal_lens_fan(built.lens, built.film_distance, "pixel", math.hypot(*at),
                              COUNT if settings.has_stop else 1)
    if above:
        return _traced_fan(quarter_turned(built.lens), built.film_distance, (-at[1], at[0]))
    return _traced_fan(built.lens, built.film_distance, at)


def _perspective_fan(settings: Settings, radius: float) -> Fan:
    got = readings(settings)
    if got.efl is None:
        raise ValueError(got.reason)
    opening = 0.0 if settings.f_number is None else 0.5 * (got.entrance_pupil or 0.0)
    focus = port_of(settings).apparent(settings.focus_distance)
    return ideal_fan("pixel", radius, 1.0 / (1.0 / got.efl + 1.0 / focus), 0.0, 0.0, got.efl, 0.0,
                     opening, COUNT if opening else 1, -8.0 * got.efl)


@lru_cache(maxsize=8)
def _traced_fan(lens: lb.Lens, film_distance: float, film_xy: Place) -> Fan:
    radius = math.hypot(*film_xy) if lens.is_rotationally_symmetric else film_xy[1]
    seen = region(lens, film_distance, math.hypot(*film_xy), math.atan2(film_xy[1], film_xy[0]))
    if seen.area <= 0.0:
        return Fan("pixel", radius, (), DARK)
    back = turn(lens, film_xy)

    # Along a line upward through the middle of the region, from one side of its outline to the other
    middle = seen.outline.mean(0)
    x, y = seen.outline.T
    after_x, after_y = np.roll(x, -1), np.roll(y, -1)
    cut = (x < middle[0]) != (after_x < middle[0])
    part = (middle[0] - x[cut]) / (after_x[cut] - x[cut])
    heights = y[cut] + part * (after_y[cut] - y[cut]) - middle[1]
    low, high = INSIDE * float(heights.min()), INSIDE * float(heights.max())

    def rear(offsets: np.ndarray) -> np.ndarray:
        """Points on the plane of the last vertex, lens frame, at these heights (mm) from the middle."""
        return (middle + np.column_stack([np.zeros_like(offsets), offsets])) @ back

    step = (high - low) / (COUNT - 1)
    dead = [end + sign * k * step for end, sign in ((low, -1.0), (high, 1.0)) for k in range(1, DEAD_EACH_SIDE + 1)]
    offsets = np.concatenate([np.linspace(low, high, COUNT), dead])
    trace = from_film(lens, film_distance, film_xy, rear(offsets), record=True)
    ended = blockers(lens, trace, forward=False)
    assert trace.paths is not None
    far = _upright(trace.points + _beginning(lens, film_distance) * trace.directions, back)
    paths, rays = _upright(trace.paths, back), []
    for i, passes in enumerate(trace.fate == lb.Fate.PASSED):
        path = np.concatenate([far[i:i + 1], paths[i, ::-1]]) if passes else paths[i, np.isfinite(paths[i, :, 0])]
        if passes:
            kind = "chief" if i == COUNT // 2 else "marginal" if i in (0, COUNT - 1) else ""
            rays.append(Ray(path, kind, f"{kind} ray".strip() if kind else "ray"))
        else:
            rays.append(Ray(path, "dead", end_text(lens, lb.Fate(int(trace.fate[i])), int(ended[i])), int(ended[i])))
    return Fan("pixel", radius, tuple(rays))


def path_of(lens: lb.Lens, trace: lb.Trace, i: int) -> np.ndarray:
    """Path (n, 3) of ray i of a recorded trace from the film, lens frame.

    A ray that passes runs from far before the lens to the film, one that is lost from the film to where it ends.
    """
    assert trace.paths is not None
    path = trace.paths[i][np.isfinite(trace.paths[i][:, 0])]
    if trace.fate[i] != lb.Fate.PASSED:
        return path
    beginning = _beginning(lens, path[0, 2] - lens.length)
    return np.vstack([trace.points[i] + beginning * trace.directions[i], path[::-1]])


def path_before_lens(lens: lb.Lens, film_distance: float, point: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Where a ray towards the film begins far before the lens (3,), from a point of it and its direction there."""
    return np.asarray(point - _beginning(lens, film_distance) * direction)


def _beginning(lens: lb.Lens, film_distance: float) -> float:
    """How far before the lens (mm) its rays begin."""
    return 4.0 * (lens.length + film_distance) + 20.0 * lens.surfaces[0].semi_diameter


def _upright(points: np.ndarray, back: np.ndarray) -> np.ndarray:
    """Points (..., 3) of the lens frame as (z, y) of the section."""
    return np.stack([points[..., 2], points[..., :2] @ back[1]], axis=-1)


def in_section(settings: Settings, raster: Place | None, ray: PointedRay, above: bool = False) -> np.ndarray:
    """The path (n, 2) of a pointed ray as (z, y) of the section, in which the film point of the pixel is upright.

    above: as (z, x), of a lens without rotational symmetry.
    """
    lens = setup(settings).lens
    back = np.eye(2) if raster is None else turn(lens, film_place(settings, raster))
    if above and not lens.is_rotationally_symmetric:
        back = back[::-1]
    return _upright(ray.path, back)


def rear_place(settings: Settings, raster: Place | None, ray: PointedRay) -> np.ndarray | None:
    """Where a pointed ray that passes crosses the plane of the last vertex: upright (2,) in mm; None for a lost ray."""
    if ray.surface >= 0:
        return None
    lens, (last, film) = setup(settings).lens, ray.path[-2:]
    crossed = last + (lens.length - last[2]) / (film[2] - last[2]) * (film - last)
    back = np.eye(2) if raster is None else turn(lens, film_place(settings, raster))
    return crossed[:2] @ back.T


def ray_through(settings: Settings, film_xy: Place, rear_xy: Place, here: Setup | None = None) -> PointedRay:
    """The ray from a film point (mm) through a point of the plane of the last vertex (mm), both in the lens frame.

    here: the lens with the film distance of this point, for a film out of line.
    """
    built = setup(settings) if here is None else here
    trace = from_film(built.lens, built.film_distance, film_xy, np.array([rear_xy]), record=True)
    surface = int(blockers(built.lens, trace, forward=False)[0])
    path = path_of(built.lens, trace, 0)
    if surface >= 0:
        return PointedRay(path, surface, end_text(built.lens, lb.Fate(int(trace.fate[0])), surface))
    found = landing(settings, path)
    return PointedRay(path, surface, found.text, found.point, found.raster)
