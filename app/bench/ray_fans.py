"""Ray fans of the lens section: from three points of the scene through the lens to three points of the film.

Lengths in mm, lens frame, meridional plane; points are (z, y). A fan of the real lens begins at the point in focus
on the chief ray of the film point; its rays are traced forward, and the section draws the points that the tracer
returns. An ideal lens refracts them at its principal planes.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.bench.build import Bench
from lensbench.core.pupils.rim_solver import solve_rims
from lensbench.core.text import fixed

FIELDS = (("axis", 0.0), ("0.7 field", 0.7), ("full field", 1.0))
EDGE_STEPS, EDGE_RADII = 3, 33  # searches for the edge of light: the film's half diagonal to 1 / 32,768
INSIDE = 0.99                   # of the edge of light: the last fan has rays
EDGE = "edge of light"          # name of the full field if the film is larger than the image circle
DARK = "no light of the scene reaches this point of the film"
SCAN = 257                      # rays that search the edges of a fan
CLOSED = 0.3                    # part of the open stop below which a fan has fewer rays
DEAD_EACH_SIDE = 3
WHY = {lb.Fate.MISSED: "misses", lb.Fate.CLIPPED: "is vignetted by",
       lb.Fate.TOTAL_REFLECTION: "is totally reflected at", lb.Fate.BACKWARD: "is turned backward at"}


@dataclass(frozen=True, eq=False)
class Ray:
    """One ray: path (n, 2) from far before the lens to the film, or to the surface that ends it.

    kind is "chief", "marginal", "" or "dead"; `end` describes its end in words. surface: the index of the surface that
    ends it, −1 for a ray that reaches the film.
    """

    path: np.ndarray
    kind: str
    end: str
    surface: int = -1

    @classmethod
    def passing(cls, path: np.ndarray, kind: str) -> "Ray":
        """A ray that reaches the film."""
        return cls(path, kind, f"{kind} ray".lstrip())


def ray_kind(k: int, count: int) -> str:
    """The kind of ray k of so many in a fan that reach the film."""
    return "chief" if k == count // 2 else "marginal" if k in (0, count - 1) else ""


@dataclass(frozen=True, eq=False)
class Fan:
    """The rays of one field point: name, height on the film (mm), and the reason if there are no rays."""

    name: str
    height: float
    rays: tuple[Ray, ...]
    dark: str = ""


def fans(lens_setup: Bench, focus_distance: float, traced: bool, has_stop: bool, open_stop: float) -> tuple[Fan, ...]:
    """The three fans of a lens before its film.

    traced: through the real lens instead of an ideal one. has_stop: False for a pinhole, which has chief rays only.
    open_stop: the stop's radius wide open (mm).
    """
    return _fans(lens_setup.lens, lens_setup.film_distance, 0.5 * lens_setup.film.diagonal, focus_distance, traced,
                 has_stop, open_stop)


@lru_cache(maxsize=32)
def _fans(lens: lb.Lens, film_distance: float, half_diagonal: float, focus_distance: float, traced: bool,
          has_stop: bool, open_stop: float) -> tuple[Fan, ...]:
    count = 5 if lens.stop.semi_diameter < CLOSED * open_stop else 9
    if not traced:
        return tuple(ideal_lens_fan(lens, film_distance, name, share * half_diagonal, count if has_stop else 1)
                     for name, share in FIELDS)
    lit = _lit_radius(lens, film_distance, half_diagonal)
    lit *= 1.0 if lit >= half_diagonal else INSIDE
    names = [EDGE if share == 1.0 and lit < half_diagonal else name for name, share in FIELDS]
    return tuple(_traced(lens, film_distance, names, [share * min(lit, half_diagonal) for _, share in FIELDS],
                         focus_distance, count))


def lit_radius(lens_setup: Bench, out_to: float | None = None) -> float:
    """Radius (mm) of the film that the lens lights, up to `out_to` (mm), by default the film's corner."""
    return _lit_radius(lens_setup.lens, lens_setup.film_distance,
                       0.5 * lens_setup.film.diagonal if out_to is None else out_to)


@lru_cache(maxsize=64)
def _lit_radius(lens: lb.Lens, film_distance: float, half_diagonal: float) -> float:
    low, high = 0.0, half_diagonal
    if lens.is_rotationally_symmetric:              # by the regions themselves: a chief ray misses their last slivers
        for _ in range(EDGE_STEPS):
            radii = np.linspace(low, high, EDGE_RADII)
            _, rims = solve_rims(lens, film_distance, radii, 5, 1e-3 * lens.stop.semi_diameter)
            lit = np.asarray(rims.any((1, 2)))
            if lit.all() or not lit[0]:
                return high if lit[0] else low
            dark = int(np.argmin(lit))
            low, high = float(radii[dark - 1]), float(radii[dark])
        return low

    def is_dark(height: float) -> bool:
        return bool(np.isnan(_chief_rays(lens, film_distance, np.array([height]))[0]).any())

    if not is_dark(half_diagonal):
        return half_diagonal
    for _ in range(12):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if is_dark(middle) else (middle, high)
    return low


# Through the real lens


def _traced(lens: lb.Lens, film_distance: float, names: list[str], heights: list[float], focus_distance: float,
            count: int) -> list[Fan]:
    """The fans of film points, by names and heights (mm), `count` rays each; their rays are traced together."""
    film_z = lens.length + film_distance
    fronts, towards_scene = _chief_rays(lens, film_distance, np.array(heights))
    made = [Fan(name, height, (), DARK) for name, height in zip(names, heights, strict=True)]

    # The point of the scene in focus along each chief ray, and the rays from it
    along = np.full(len(made), np.inf)
    if math.isfinite(focus_distance):
        steep = -towards_scene[:, 0]
        along = np.where(steep > 0.1, (fronts[:, 0] - (film_z - focus_distance)) / np.maximum(steep, 0.1),
                         focus_distance)
    for i in np.flatnonzero(along <= 0.0).tolist():
        made[i] = Fan(names[i], heights[i], (), "the plane in focus lies within the lens")
    left = np.flatnonzero(np.isfinite(fronts[:, 0]) & (along > 0.0))
    aside = np.stack([-towards_scene[:, 1], towards_scene[:, 0]], axis=1)      # unit, across the chief ray
    aside *= np.copysign(1.0, aside[:, 1:])
    beginning = np.minimum(0.98 * along, 4.0 * film_z + 20.0 * lens.surfaces[0].semi_diameter)

    def shot(which: np.ndarray, offsets: np.ndarray, record: bool = False) -> lb.Trace:
        """Rays (k · n) of fans (k,), from before the lens, past the chief ray at its front at offsets (k, n), mm."""
        shrink, front = (1.0 - beginning / along)[which, None, None], fronts[which, None]
        across = offsets[..., None] * aside[which, None]
        starts = front + (beginning[:, None] * towards_scene)[which, None] + shrink * across
        return lb.trace(lens, _in_space(starts), _in_space(front + across - starts), record=record)

    def passes(which: np.ndarray, offsets: np.ndarray) -> np.ndarray:
        return (shot(which, offsets).fate == lb.Fate.PASSED).reshape(offsets.shape)

    edges = _passing_intervals(passes, left, 2.4 * np.maximum(lens.surfaces[0].semi_diameter, np.abs(fronts[:, 1])))
    lit = np.isfinite(edges[:, 0])
    left, edges = left[lit], edges[lit]
    if not left.size:
        return made
    low, high = edges[:, :1], edges[:, 1:]
    live = np.linspace(low[:, 0], high[:, 0], count, axis=-1)
    middle = np.argmin(np.abs(live), axis=1)
    rows = np.arange(len(left))
    live[rows, middle] = np.where((low < 0.0) & (0.0 < high), 0.0, live[rows, middle, None])[:, 0]  # the chief ray
    beyond = np.arange(1.0, DEAD_EACH_SIDE + 1.0) * (high - low) / (count - 1)
    trace = shot(left, np.concatenate([live, low - beyond, high + beyond], axis=1), record=True)
    ended = blockers(lens, trace, forward=True).tolist()
    n_rays = count + 2 * DEAD_EACH_SIDE
    for row, i in enumerate(left.tolist()):
        rays = [_ray(lens, film_z, trace, row * n_rays + k, ended[row * n_rays + k],
                     "chief" if k == middle[row] else "marginal" if k in (0, count - 1) else "") for k in range(n_rays)]
        made[i] = Fan(names[i], heights[i], tuple(ray for ray in rays if ray is not None))
    return made


def _ray(lens: lb.Lens, film_z: float, trace: lb.Trace, i: int, surface: int, kind: str) -> Ray | None:
    """Ray i of a trace to the film, or to the `surface` that ends it; None for one that is lost far from the glass."""
    assert trace.paths is not None
    path = trace.paths[i, :, [2, 1]].T
    fate = int(trace.fate[i])
    if fate == lb.Fate.PASSED:
        direction, point = trace.directions[i], trace.points[i]
        run = (film_z - point[2]) / direction[2]
        return Ray.passing(np.concatenate([path, [[film_z, point[1] + run * direction[1]]]]), kind)
    path = path[np.isfinite(path[:, 0])]
    return Ray(path, "dead", end_text(lens, lb.Fate(fate), surface), surface) if _near_the_glass(lens, path) else None


def _chief_rays(lens: lb.Lens, film_distance: float, film_heights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where the chief rays of film points at heights (F,) meet the first surface, and their unit directions from there.

    Both (F, 2) of (z, y); the directions are those to the scene. A chief ray passes the centre of the stop; if that ray
    is lost, it is the middle one of those that pass. NaN if no ray passes.
    """
    start = np.stack([np.full_like(film_heights, lens.length + film_distance), film_heights], axis=1)
    at_stop = len(lens.surfaces) - lens.stop_index                  # in a path traced from the film

    def back(which: np.ndarray, heights: np.ndarray, free: bool = False) -> lb.Trace:
        """Rays from film points (k,) through heights (k, n) at the last vertex: k · n. free: recorded, without rims."""
        ends = np.stack([np.full_like(heights, lens.length), heights], axis=-1)
        starts = np.broadcast_to(start[which, None], ends.shape)
        return lb.trace(lens, _in_space(starts), _in_space(ends - starts), clip=not free, record=free)

    def passes(which: np.ndarray, heights: np.ndarray) -> np.ndarray:
        return (back(which, heights).fate == lb.Fate.PASSED).reshape(heights.shape)

    # The ray through the centre of the stop, without the rims
    every, reach = np.arange(len(film_heights)), np.full(len(film_heights), 1.3 * lens.surfaces[-1].semi_diameter)
    heights = np.linspace(-reach[0], reach[0], SCAN)
    free = back(every, np.broadcast_to(heights, (len(film_heights), SCAN)), free=True)
    assert free.paths is not None
    stop_heights = free.paths[:, at_stop, 1].reshape(len(film_heights), SCAN) - lens.vertex(lens.stop_index)[1]
    chosen = np.full(len(film_heights), np.nan)
    for i, (at_stop_row, crosses) in enumerate(zip(stop_heights, stop_heights[:, :-1] * stop_heights[:, 1:] <= 0.0,
                                              strict=True)):
        crossing = np.flatnonzero(crosses)
        if crossing.size:
            k = crossing[np.argmin(np.abs(heights[crossing]))]
            a, b = at_stop_row[k], at_stop_row[k + 1]
            chosen[i] = heights[k] - a / (b - a) * (heights[k + 1] - heights[k]) if b != a else heights[k]

    # Otherwise the middle ray of those that pass
    traced = back(every, np.nan_to_num(chosen)[:, None])
    lost = np.flatnonzero(np.isnan(chosen) | (traced.fate != lb.Fate.PASSED))
    if lost.size:
        chosen[lost] = _passing_intervals(passes, lost, reach, centred=False).mean(1)
        traced = back(every, np.nan_to_num(chosen)[:, None])
    points, ways = traced.points[:, [2, 1]].copy(), traced.directions[:, [2, 1]]
    dark = np.isnan(chosen) | (traced.fate != lb.Fate.PASSED) | (ways[:, 0] >= 0.0)
    points[dark] = np.nan
    return points, np.where(dark[:, None], np.nan, ways / np.hypot(ways[:, :1], ways[:, 1:]))


def _passing_intervals(passes: Callable[[np.ndarray, np.ndarray], np.ndarray], which: np.ndarray, reach: np.ndarray,
                       centred: bool = True) -> np.ndarray:
    """The ends (k, 2) of the runs of offsets in ±reach that pass: the one about 0, otherwise the longest.

    passes: of fields (k,) and offsets (k, n), booleans (k, n). which: the fields (k,); reach: of all fields, mm. The
    ends are known to 1e-6 of reach; NaN where nothing passes.
    """
    ends = np.full((len(which), 2), np.nan)
    if not which.size:
        return ends
    offsets = np.linspace(-reach[which], reach[which], SCAN, axis=-1)
    mask = passes(which, offsets)
    for _ in range(3):                                              # a nearly closed stop lies between two rays
        closed = ~mask.any(1)
        if not closed.any() or not centred:
            break
        offsets[closed] /= 16.0
        mask[closed] = passes(which[closed], offsets[closed])
    lit = np.flatnonzero(mask.any(1))
    if not lit.size:
        return ends
    steps, middle = np.diff(np.pad(mask[lit].astype(np.int8), ((0, 0), (1, 1)))), SCAN // 2
    inside = np.empty((len(lit), 2))
    for row, (step, row_offsets) in enumerate(zip(steps, offsets[lit], strict=True)):
        runs = list(zip(np.flatnonzero(step > 0).tolist(), (np.flatnonzero(step < 0) - 1).tolist(), strict=True))
        first, last = next((run for run in runs if centred and run[0] <= middle <= run[1]),
                           max(runs, key=lambda run: run[1] - run[0]))
        inside[row] = row_offsets[first], row_offsets[last]
    outward = (offsets[lit, 1] - offsets[lit, 0])[:, None] * [-1.0, 1.0]
    for _ in range(3):
        trial = inside[..., None] + outward[..., None] * np.linspace(0.0, 1.0, 33)
        good = passes(which[lit], trial.reshape(len(lit), -1)).reshape(trial.shape)
        k = np.where(good.all(2), 32, np.maximum(np.argmin(good, axis=2) - 1, 0))
        inside, outward = np.take_along_axis(trial, k[..., None], 2)[..., 0], outward / 32.0
    ends[lit] = inside
    return ends


def _near_the_glass(lens: lb.Lens, path: np.ndarray) -> bool:
    """Whether a blocked ray is worth drawing: it meets the first surface within 1.2 semi-diameters."""
    return len(path) > 2 or (len(path) == 2 and abs(path[1][1]) < 1.2 * lens.surfaces[0].semi_diameter)


def blockers(lens: lb.Lens, trace: lb.Trace, forward: bool) -> np.ndarray:
    """Indices (n,) of the surfaces that end the rays of a trace, −1 for those that pass.

    forward: the rays run from the scene to the film. A ray that misses a surface, or is turned before it, is reported
    by the tracer for the surface before; here for that surface itself.
    """
    first, last = (-1, len(lens.surfaces) - 1) if forward else (len(lens.surfaces), 0)
    step = 1 if forward else -1
    reached = np.where(trace.surface < 0, first, trace.surface)
    early = (trace.fate == lb.Fate.MISSED) | (trace.fate == lb.Fate.BACKWARD)
    blocking = np.where(early & (reached != last), reached + step, reached)
    return np.where(trace.fate == lb.Fate.PASSED, -1, blocking)


def end_text(lens: lb.Lens, fate: lb.Fate, surface: int) -> str:
    """Description of why a ray ends at a surface, as `blockers` reports it."""
    if fate == lb.Fate.CLIPPED and surface == lens.stop_index:
        return "is stopped by the stop"
    radius = lens.surfaces[surface].semi_diameter
    rim = f" (semi-diameter {fixed(radius, 2)} mm)" if fate == lb.Fate.CLIPPED else ""
    return f"{WHY[fate]} surface {surface}{rim}"


def _in_space(points: np.ndarray) -> np.ndarray:
    """(…, 2) of (z, y) as (n, 3) of (x, y, z)."""
    made = np.zeros((points.size // 2, 3))
    made[:, 1:] = points.reshape(-1, 2)[:, ::-1]
    return made


# Through an ideal lens


def ideal_lens_fan(lens: lb.Lens, film_distance: float, name: str, height: float, count: int) -> Fan:
    """Fan of an ideal lens: rays leave the rear principal plane at the height at which they meet the front one."""
    fo = lb.first_order(lens)
    if not (math.isfinite(fo.efl) and fo.efl > 0.0 and math.isfinite(fo.entrance_pupil.z)):
        return Fan(name, height, (), "this lens has no ideal counterpart that forms an image")
    front, rear = fo.front_principal, lens.length + fo.rear_principal
    return ideal_fan(name, height, fo.efl, front, rear, lens.length + film_distance, fo.entrance_pupil.z,
                     fo.entrance_pupil.radius, count, -4.0 * (lens.length + film_distance))


def ideal_fan(name: str, height: float, efl: float, front: float, rear: float, film_z: float, pupil_z: float,
              pupil_radius: float, count: int, beginning: float) -> Fan:
    """Rays of an ideal lens with principal planes at front and rear and a pupil before it, onto one film point."""
    nearness = (1.0 / efl - 1.0 / (film_z - rear)) if film_z > rear else 0.0      # of the object to the front plane
    rays = []
    for k in range(count):
        at_pupil = pupil_radius * (2.0 * k / (count - 1) - 1.0) if count > 1 else 0.0
        # A ray y + w (z − front) of the object at height −h s / s′ has slope w = y / s + h / s′ ahead of the lens
        tilt = height / (film_z - rear)
        reach = pupil_z - front
        y = (at_pupil - reach * tilt) / (1.0 + reach * nearness)
        slope = y * nearness + tilt
        path = np.array([[beginning, y + slope * (beginning - front)], [front, y], [rear, y], [film_z, height]])
        rays.append(Ray.passing(path, ray_kind(k, count)))
    return Fan(name, height, tuple(rays))
