"""Exit-pupil region of a film point: paraxial disk, pbrt's boxes and solved region.

Each method draws samples on the rear plane; tracing them shows how good it is. The light is the mean of their weights,
compared with the area of the true region, which is counted in cells of rays of the scalar tracer.
"""

import math
from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.stability.sweep import Curve, Sweep, curve
from lensbench.app.studies.timing import even_points
from lensbench.core.kernels.block import CLEARANCE, U0, U1, WEIGHT, L, M, N, X, Y
from lensbench.core.kernels.program import Program
from lensbench.core.optics.block_trace import surface_steps
from lensbench.core.pupils.film_grid_sampler import PupilGrid
from lensbench.core.pupils.radial_sampler import PupilTable
from lensbench.core.pupils.rim_solver import solve_rims

SAMPLES = 1 << 12       # samples of each method at each value
CELLS = 240             # cells along each side of one grid over the true region
FIRST_CELLS = 400       # of the first grid
LOOKS = 14
ENOUGH = 9000           # cells that a region must have: its area is then exact to a few parts in a thousand
BUCKETS = 64            # film radii, for pbrt's boxes
LIGHT, WASTE = 0.01, 0.5
LENS = "pbrt-dgauss-50mm"
BENT = "panasonic-lumix-g-asph-25-f17"
CYLINDERS = "lentil-schneider-anamorphic-31-2001"
FULL_FRAME = 0.5 * math.hypot(36.0, 24.0)

Aim = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]     # uv (n, 2) → points (n, 2), area (n,) of each


class FilmPoint(NamedTuple):
    """A film point (x, y) behind a lens, the film distance from the last vertex, and half the film diagonal; mm."""

    lens: lb.Lens
    film_distance: float
    film: tuple[float, float]
    reach: float


class Result(NamedTuple):
    """Relative error of the light and blocked share of the samples, for one method at one film point."""

    light: float
    waste: float


def passing(point: FilmPoint, points: np.ndarray) -> np.ndarray:
    """Which rays from the film point to points (n, 2) of the rear plane pass, by the block tracer in float64."""
    way = np.column_stack([points - point.film, np.full(len(points), -point.film_distance)])
    way /= np.linalg.norm(way, axis=1)[:, None]
    n = len(points)
    rays = {X: np.full(n, point.film[0]), Y: np.full(n, point.film[1]), L: way[:, 0], M: way[:, 1], N: way[:, 2]}
    return Program(surface_steps(point.lens, point.film_distance), np.float64).run(rays, [CLEARANCE], n)[0] <= 1.0


@lru_cache(maxsize=256)
def true_area(point: FilmPoint) -> float:
    """Area (mm²) of the region, by grids of scalar rays, each finer around the rays that pass."""
    rear = 1.5 * point.lens.surfaces[-1].semi_diameter
    low, high = np.minimum(-rear, np.minimum(point.film, 0.0)), np.maximum(rear, np.maximum(point.film, 0.0))
    area, cells = 0.0, FIRST_CELLS
    for _ in range(LOOKS):
        cell = (high - low) / cells
        centres = [low[k] + cell[k] * (np.arange(cells) + 0.5) for k in (0, 1)]
        u, v = np.meshgrid(*centres)
        inside = _inside(point, u.ravel(), v.ravel()).reshape(cells, cells)
        area = float(inside.sum() * cell.prod())
        if not inside.any():                            # around the cell that is nearest to passing
            nearest = _nearest(point, u.ravel()[::7], v.ravel()[::7])
            if nearest is None:
                return 0.0
            low, high, cells = nearest - 8.0 * cell, nearest + 8.0 * cell, CELLS
            continue
        across, down = np.asarray(inside.any(0)), np.asarray(inside.any(1))
        open_low, open_high = (np.array([across[k], down[k]]) for k in (0, -1))
        if inside.sum() >= ENOUGH and not (open_low.any() or open_high.any()):
            return area
        ends = np.array([np.flatnonzero(which)[[0, -1]] for which in (across, down)])
        tight = low + cell * (ends[:, 0] - 4), low + cell * (ends[:, 1] + 5)
        # A narrow region may extend beyond the cells that hit it
        width = tight[1] - tight[0]
        low, high, cells = tight[0] - 0.3 * open_low * width, tight[1] + 0.3 * open_high * width, CELLS
    return area


def _ways(point: FilmPoint, u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    film = np.array([*point.film, point.lens.length + point.film_distance])
    return film, np.column_stack([u, v, np.full(u.size, point.lens.length)]) - film


def _inside(point: FilmPoint, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return lb.trace(point.lens, *_ways(point, u, v)).fate == lb.Fate.PASSED


def _nearest(point: FilmPoint, u: np.ndarray, v: np.ndarray) -> np.ndarray | None:
    """The point of the rear plane whose ray exceeds the rims least; None where all rays miss."""
    t = lb.trace(point.lens, *_ways(point, u, v), record=True, clip=False)
    assert t.paths is not None
    rims = np.array([surface.semi_diameter for surface in point.lens.surfaces])[::-1]
    share = np.where(t.fate == lb.Fate.PASSED, (np.hypot(t.paths[:, 1:, 0], t.paths[:, 1:, 1]) / rims).max(1), np.inf)
    best = int(np.argmin(share))
    return np.array([u[best], v[best]]) if math.isfinite(share[best]) else None


def result(point: FilmPoint, aim: Aim) -> Result:
    """Light error and blocked share of the samples of a method."""
    points, area = aim(even_points(SAMPLES))
    passed = passing(point, points) & (area > 0.0)
    truth, estimate = true_area(point), float((area * passed).mean())
    if truth == 0.0:
        return Result(0.0 if estimate == 0.0 else math.inf, float((area > 0.0).mean()))
    return Result(abs(estimate / truth - 1.0), 1.0 - float(passed.mean()))


def paraxial_disk(point: FilmPoint) -> Aim:
    """Paraxial exit pupil, projected from the film point onto the rear plane."""
    pupil = lb.first_order(point.lens).exit_pupil
    toward = point.film_distance / (point.lens.length + point.film_distance - pupil.z)
    centre, radius = np.array(point.film) * (1.0 - toward), abs(pupil.radius * toward)

    def aim(uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        r, turn = radius * np.sqrt(uv[:, 0]), 2.0 * math.pi * uv[:, 1]
        return centre + r[:, None] * np.column_stack([np.cos(turn), np.sin(turn)]), np.full(
            len(uv), math.pi * radius**2)

    return aim


def box(point: FilmPoint, samples: int) -> Aim:
    """As pbrt: the box of those of `samples` rays from a bucket of film radii that pass."""
    random = np.random.default_rng(7)
    radius, width = math.hypot(*point.film), point.reach / BUCKETS
    bucket = min(int(radius / width), BUCKETS - 1)
    cosine, sine = np.array(point.film) / radius if radius > 0.0 else (1.0, 0.0)
    square = 1.5 * point.lens.surfaces[-1].semi_diameter
    film = (bucket + random.random(samples)) * width
    points = random.uniform(-square, square, (samples, 2))
    way = np.column_stack([points[:, 0] - film, points[:, 1], np.full(samples, -point.film_distance)])
    way /= np.linalg.norm(way, axis=1)[:, None]
    rays = {X: film, L: way[:, 0], M: way[:, 1], N: way[:, 2]}
    program = Program(surface_steps(point.lens, point.film_distance), np.float64)
    through = program.run(rays, [CLEARANCE], samples)[0] <= 1.0
    margin = 2.0 * math.sqrt(2.0) * 2.0 * square / math.sqrt(samples)
    low, high = ((points[through].min(0) - margin, points[through].max(0) + margin) if through.any()
                 else (np.full(2, -square), np.full(2, square)))

    def aim(uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        aims = low + uv * (high - low)
        turned = np.column_stack([aims[:, 0] * cosine - aims[:, 1] * sine, aims[:, 0] * sine + aims[:, 1] * cosine])
        return turned, np.full(len(uv), (high - low).prod())

    return aim


def sampled(point: FilmPoint, table: PupilTable | PupilGrid) -> Aim:
    """Samples as a camera draws them from this table."""
    def aim(uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        n = len(uv)
        samples = {X: np.full(n, point.film[0]), Y: np.full(n, point.film[1]), U0: uv[:, 0], U1: uv[:, 1]}
        l, m, n_, weight = Program([table.step(1.0)], np.float64).run(samples, [L, M, N, WEIGHT], n)
        with np.errstate(divide="ignore", invalid="ignore"):
            points = np.array(point.film) + point.film_distance * np.column_stack([l, m]) / -n_[:, None]
            return np.nan_to_num(points), np.where(weight > 0.0, weight / n_**4, 0.0)

    return aim


_table = lru_cache(maxsize=32)(PupilTable.of)
_grid = lru_cache(maxsize=2)(PupilGrid.of)


def solved(point: FilmPoint) -> Aim:
    """The program's method: regions of 64 film radii, divided into triangles of equal area."""
    return sampled(point, _table(point.lens, point.film_distance, point.reach))


def solved_everywhere(point: FilmPoint) -> Aim:
    """The program's method for lenses with cylinders: regions of a grid of film points."""
    side = point.reach / math.sqrt(2.0)
    return sampled(point, _grid(point.lens, point.film_distance, side, side))


def turned(point: FilmPoint) -> Aim:
    """The table by radius of the section y–z, rotated with the film point, as if there were no cylinder."""
    return sampled(point, _table(point.lens.section("y"), point.film_distance, point.reach))


def star(point: FilmPoint) -> Aim:
    """What is seen from one centre of the region of this very film point, and nothing beyond it."""
    radius = math.hypot(*point.film)
    centre, rim = solve_rims(point.lens, point.film_distance, np.array([radius]), 129, 1e-6)
    corners = np.concatenate([rim[0], rim[0, -2::-1] * [1.0, -1.0]])
    cross = corners[:-1, 0] * corners[1:, 1] - corners[:-1, 1] * corners[1:, 0]
    upto = np.append(0.0, np.cumsum(np.maximum(cross, 0.0)))

    def aim(uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if not upto[-1] > 0.0:
            return np.zeros_like(uv), np.zeros(len(uv))
        bins = np.interp(uv[:, 0] * upto[-1], upto, np.arange(len(upto)))
        k = np.minimum(bins.astype(int), len(cross) - 1)
        share = (bins - k)[:, None]
        edge = corners[k] * (1.0 - share) + corners[k + 1] * share
        return np.sqrt(uv[:, 1:]) * edge + [centre[0], 0.0], np.full(len(uv), 0.5 * upto[-1])

    return aim


METHODS: dict[str, Callable[[FilmPoint], Aim]] = {
    "paraxial disk": paraxial_disk, **{f"boxes of {rays:,} rays": partial(box, samples=rays)
                                       for rays in (1 << 10, 1 << 15, 1 << 20)}, "solved region": solved}
OWN = {"solved region", "solved all over the film"}


def _curves(points: Sequence[FilmPoint], methods: dict[str, Callable[[FilmPoint], Aim]]) -> dict[str, list[Result]]:
    return {name: [result(point, method(point)) for point in points] for name, method in methods.items()}


def _sweeps(title: str, axis: str, unit: str, values: np.ndarray, note: str,
              by_method: Callable[[], dict[str, list[Result]]], linear: bool = False,
              switch: str = "") -> dict[str, Callable[[], Sweep]]:
    """Two sweeps from one run: light and samples. switch: what the program does where its own method fails."""
    once = lru_cache(maxsize=1)(by_method)

    def sweep(light: bool) -> Sweep:
        curves: tuple[Curve, ...] = tuple(
            curve(name, [result.light if light else result.waste for result in results], name in OWN,
                  switch if name in OWN else "") for name, results in once().items())
        what, limit, why = (("Light", LIGHT, "a hundredth: a step that can be visible in an even sky") if light
                            else ("Share of the samples that pass", WASTE, "half of them are blocked"))
        return Sweep(f"{title}: {'light' if light else 'samples'}", axis, unit, values, what, "", limit, why, curves,
                      note, linear)

    return {f"{title}: light": lambda: sweep(True), f"{title}: samples": lambda: sweep(False)}


def _film_point(name: str, radius: float, reach: float = FULL_FRAME, stop: float = 1.0) -> FilmPoint:
    lens = lenses.load(name)
    closed = lens.with_stop_radius(stop * lens.stop.semi_diameter)
    return FilmPoint(closed, lb.film_distance(lens, math.inf), (radius, 0.0), reach)


@lru_cache(maxsize=4)
def _end(name: str) -> float:
    """Film radius (mm) at which the light ends."""
    lens = lenses.load(name)
    return PupilTable.of(lens, lb.film_distance(lens, math.inf), 10.0 * lens.surfaces[-1].semi_diameter).dark_beyond


FIELD, STOPS, SIZES = np.logspace(0.0, -3.5, 12), np.logspace(0.0, -4.0, 9), np.geomspace(1.0, 20.0, 5)
LAST, ACROSS = np.geomspace(0.1, 4e-3, 9), np.linspace(0.0, 11.0, 6)


def _field() -> dict[str, list[Result]]:
    end = _end(LENS)
    return _curves([_film_point(LENS, end * (1.0 - left), 1.0001 * end) for left in FIELD], METHODS)


def _stop() -> dict[str, list[Result]]:
    return _curves([_film_point(LENS, 15.0, stop=share) for share in STOPS], METHODS)


def _size() -> dict[str, list[Result]]:
    end = _end(LENS)
    return _curves([_film_point(LENS, 0.9 * end, size * end) for size in SIZES], METHODS)


def _bent() -> dict[str, list[Result]]:
    end = _end(BENT)
    return _curves([_film_point(BENT, end * (1.0 - left), 1.0001 * end) for left in LAST],
                   {**METHODS, "star-shaped outline": star})


def _cylinders() -> dict[str, list[Result]]:
    lens = lenses.load(CYLINDERS)
    z, turn = lb.film_distance(lens, 3000.0), math.radians(45.0)
    points = [FilmPoint(lens, z, (r * math.cos(turn), r * math.sin(turn)), 12.0) for r in ACROSS]
    return _curves(points, {"paraxial disk": paraxial_disk, "boxes of 1,048,576 rays": partial(box, samples=1 << 20),
                            "table by radius, turned": turned, "solved all over the film": solved_everywhere})


SWEEPS: dict[str, Callable[[], Sweep]] = {
    **_sweeps("Field up to the dark", "Part of the field left to where the light ends", "", FIELD,
                "The region shrinks to a thin crescent and then to nothing. A paraxial disk ignores the rims.", _field,
                switch="in the last thousandth of the field half of the samples are blocked; no light is lost"),
    **_sweeps("Pupil as the stop closes", "Stop, of the full one", "", STOPS,
                "15 mm from the axis. Random rays rarely hit a small region; a box that no ray finds is taken as the "
                "whole rear opening.", _stop),
    **_sweeps("Film too large", "Half the film's diagonal, of the circle of light", "", SIZES,
                "At nine tenths of the image circle. The 64 boxes of a larger film are wider.", _size),
    **_sweeps("A region that bends round", "Part of the field left to where the light ends", "", LAST,
                "Panasonic's 25 mm f/1.7, beyond the film that it is made for: it bends round its centre.", _bent,
                switch="up to nine in ten samples are blocked; no light is lost"),
    **_sweeps("Cylinders", "Film point from the axis, diagonally", "mm", ACROSS,
                "An anamorphic lens: no rotation about the axis maps its regions onto each other.", _cylinders, True)}
