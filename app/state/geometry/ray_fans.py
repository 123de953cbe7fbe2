"""Ray fans of the lens section: from three points of the scene through the lens to three points of the film.

Lengths in mm, lens frame, meridional plane; points are (z, y). A fan of the real lens begins at the point in focus
on the chief ray of the film point; its rays are traced forward, and the section draws the points that the tracer
returns. An ideal lens refracts them at its principal planes.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

import lensbench as lb
from lensbench.app.state.build import Setup
from lensbench.kernels.figures import fixed
from lensbench.pupils.rim_solver import solve_rims

FIELDS = (("axis", 0.0), ("0.7 field", 0.7), ("full field", 1.0))
EDGE_STEPS, EDGE_RADII = 3, 33  # searches for the edge of light: the film's half diagonal to 1 / 32,768
INSIDE = 0.99                   # of the edge of light: the last fan has rays
EDGE = "edge of light"          # name of the full field if the film is larger than the image circle
DARK = "no light of the scene reaches this point of the film"
SCAN = 257                      # rays that search the edges of a fan
CLOSED = 0.3                    # part of the open stop below which a fan has fewer rays
DEAD_EACH_SIDE = 3
WHY = {lb.Fate.MISSED: "misses", lb.Fate.CLIPPED: "is stopped by the rim of",
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


@dataclass(frozen=True, eq=False)
class Fan:
    """The rays of one field point: name, height on the film (mm), and the reason if there are no rays."""

    name: str
    height: float
    rays: tuple[Ray, ...]
    dark: str = ""


def fans(lens_setup: Setup, focus_distance: float, traced: bool, has_stop: bool, open_stop: float) -> tuple[Fan, ...]:
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
        return tuple(ideal_lens_fan(lens, film_distance, name, part * half_diagonal, count if has_stop else 1)
                     for name, part in FIELDS)
    lit = _lit_radius(lens, film_distance, half_diagonal)
    lit *= 1.0 if lit >= half_diagonal else INSIDE
    return tuple(_traced(lens, film_distance, EDGE if part == 1.0 and lit < half_diagonal else name,
                         part * min(lit, half_diagonal), focus_distance, count) for name, part in FIELDS)


def lit_radius(lens_setup: Setup) -> float:
    """Radius (mm) of the film that the lens lights: to the corner, or that of a smaller image circle."""
    return _lit_radius(lens_setup.lens, lens_setup.film_distance, 0.5 * lens_setup.film.diagonal)


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
    if _chief_ray(lens, film_distance, half_diagonal) is not None:
        return half_diagonal
    for _ in range(12):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if _chief_ray(lens, film_distance, middle) is None else (middle, high)
    return low


# Through the real lens


def _traced(lens: lb.Lens, film_distance: float, name: str, height: float, focus_distance: float, count: int) -> Fan:
    chief = _chief_ray(lens, film_distance, height)
    if chief is None:
        return Fan(name, height, (), DARK)
    front, toward_scene = chief

    # The point of the scene in focus along the chief ray, and the rays from it
    film_z = lens.length + film_distance
    along = np.inf
    if math.isfinite(focus_distance):
        steep = -toward_scene[0]
        along = (front[0] - (film_z - focus_distance)) / steep if steep > 0.1 else focus_distance
    if along <= 0.0:
        return Fan(name, height, (), "the plane in focus lies within the lens")
    aside = np.array([-toward_scene[1], toward_scene[0]])           # unit, across the chief ray
    aside *= math.copysign(1.0, aside[1])
    beginning = min(0.98 * along, 4.0 * (lens.length + film_distance) + 20.0 * lens.surfaces[0].semi_diameter)

    def shot(offsets: np.ndarray, record: bool = False) -> lb.Trace:
        """Rays that cross the chief ray's front point at these offsets (mm), begun well before the lens."""
        shrink = 1.0 - beginning / along
        starts = front + beginning * toward_scene + shrink * offsets[:, None] * aside
        ways = front + offsets[:, None] * aside - starts
        return lb.trace(lens, _in_space(starts), _in_space(ways), record=record)

    reach = 2.4 * max(lens.surfaces[0].semi_diameter, abs(front[1]))
    edges = _passing_interval(lambda offsets: shot(offsets).fate == lb.Fate.PASSED, reach)
    if edges is None:
        return Fan(name, height, (), DARK)
    low, high = edges
    step = (high - low) / (count - 1)
    offsets = list(np.linspace(low, high, count))
    middle = int(np.argmin(np.abs(offsets)))
    if low < 0.0 < high:
        offsets[middle] = 0.0                                       # the chief ray itself
    beyond = [k * step for k in range(1, DEAD_EACH_SIDE + 1)]
    dead = [low - way for way in beyond] + [high + way for way in beyond]
    trace = shot(np.array(offsets + dead), record=True)
    assert trace.paths is not None

    rays = []
    for i in range(len(offsets) + len(dead)):
        live = trace.fate[i] == lb.Fate.PASSED
        path = trace.paths[i][:, [2, 1]]
        path = path[np.isfinite(path[:, 0])]
        if live:
            direction = trace.directions[i]
            run = (film_z - trace.points[i][2]) / direction[2]
            path = np.vstack([path, [film_z, trace.points[i][1] + run * direction[1]]])
            kind = "chief" if i == middle else "marginal" if i in (0, count - 1) else ""
            rays.append(Ray(path, kind, f"{kind} ray".strip() if kind else "ray"))
        elif _near_the_glass(lens, path):
            fate, surface = lb.Fate(int(trace.fate[i])), int(blockers(lens, trace, forward=True)[i])
            rays.append(Ray(path, "dead", end_text(lens, fate, surface), surface))
    return Fan(name, height, tuple(rays))


def _chief_ray(lens: lb.Lens, film_distance: float, height: float):
    """Where the chief ray of a film point meets the first surface (z, y), and its unit direction to the scene.

    The chief ray passes the centre of the stop; if that ray is lost, it is the middle one of those that pass. None
    if no ray passes.
    """
    start = np.array([lens.length + film_distance, height])
    at_stop = len(lens.surfaces) - lens.stop_index                  # in a path traced from the film

    def back(heights: np.ndarray) -> lb.Trace:
        ways = np.stack([np.full_like(heights, lens.length), heights], axis=1) - start
        return lb.trace(lens, _in_space(start[None, :]), _in_space(ways))

    # The ray through the centre of the stop, without the rims
    reach = 1.3 * lens.surfaces[-1].semi_diameter
    heights = np.linspace(-reach, reach, SCAN)
    ways = np.stack([np.full_like(heights, lens.length), heights], axis=1) - start
    free = lb.trace(lens, _in_space(start[None, :]), _in_space(ways), clip=False, record=True)
    assert free.paths is not None
    stop_heights = free.paths[:, at_stop, 1] - lens.vertex(lens.stop_index)[1]
    crossing = np.flatnonzero(stop_heights[:-1] * stop_heights[1:] <= 0.0)
    if crossing.size:
        k = crossing[np.argmin(np.abs(heights[crossing]))]
        a, b = stop_heights[k], stop_heights[k + 1]
        chosen = heights[k] - a / (b - a) * (heights[k + 1] - heights[k]) if b != a else heights[k]
        trace = back(np.array([chosen]))
    # Otherwise the middle ray of those that pass
    if not crossing.size or trace.fate[0] != lb.Fate.PASSED:
        interval = _passing_interval(lambda heights: back(heights).fate == lb.Fate.PASSED, reach, centred=False)
        if interval is None:
            return None
        trace = back(np.array([0.5 * (interval[0] + interval[1])]))
    if trace.fate[0] != lb.Fate.PASSED or trace.directions[0][2] >= 0.0:
        return None
    point, way = trace.points[0][[2, 1]], trace.directions[0][[2, 1]]
    return point, way / np.hypot(*way)


def _passing_interval(passes, reach: float, centred: bool = True) -> tuple[float, float] | None:
    """The ends of the run of offsets in ±reach that pass: the one about 0, otherwise the longest; to 1e-6 of reach."""
    offsets = np.linspace(-reach, reach, SCAN)
    mask = passes(offsets)
    for _ in range(3):                                              # a nearly closed stop lies between two rays
        if mask.any() or not centred:
            break
        offsets = offsets / 16.0
        mask = passes(offsets)
    if not mask.any():
        return None
    ends = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    runs = [(int(a), int(b) - 1) for a, b in zip(ends[::2], ends[1::2], strict=True)]
    middle = SCAN // 2
    first, last = next((run for run in runs if centred and run[0] <= middle <= run[1]),
                       max(runs, key=lambda run: run[1] - run[0]))
    spacing = offsets[1] - offsets[0]
    found = []
    for inside, outward in ((offsets[first], -spacing), (offsets[last], spacing)):
        for _ in range(3):
            trial = inside + outward * np.linspace(0.0, 1.0, 33)
            good = np.flatnonzero(~passes(trial))
            k = int(good[0]) - 1 if good.size else 32
            inside, outward = float(trial[max(k, 0)]), outward / 32.0
        found.append(inside)
    return found[0], found[1]


def _near_the_glass(lens: lb.Lens, path: np.ndarray) -> bool:
    """Whether a dead ray is worth drawing: it meets the first surface within 1.2 semi-diameters."""
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
    found = np.where(early & (reached != last), reached + step, reached)
    return np.where(trace.fate == lb.Fate.PASSED, -1, found)


def end_text(lens: lb.Lens, fate: lb.Fate, surface: int) -> str:
    """Description of why a ray ends at a surface, as `blockers` reports it."""
    if fate == lb.Fate.CLIPPED and surface == lens.stop_index:
        return "is stopped by the stop"
    radius = lens.surfaces[surface].semi_diameter
    rim = f" (semi-diameter {fixed(radius, 2)} mm)" if fate == lb.Fate.CLIPPED else ""
    return f"{WHY[fate]} surface {surface}{rim}"


def _in_space(points: np.ndarray) -> np.ndarray:
    """(n, 2) of (z, y) as (n, 3) of (x, y, z)."""
    return np.stack([np.zeros(len(points)), points[:, 1], points[:, 0]], axis=1)


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
        kind = "chief" if count == 1 or k == count // 2 else "marginal" if k in (0, count - 1) else ""
        rays.append(Ray(path, kind, f"{kind} ray".strip() if kind else "ray"))
    return Fan(name, height, tuple(rays))
