"""Error of the rays of a camera model against those of the lens, in film pixels, and of its light, in stops.

The reference is the scalar tracer in double precision. Film points lie evenly over the film, each with one ray in its
exit-pupil region. Objects lie at three distances from the entrance pupil: in focus, half that distance, and infinity.
Where model and lens see different points of an object, the error is the difference of their directions from the
entrance pupil, converted into a displacement of the film point (same part of its pupil region) by the derivative of the
lens. So fisheyes and near objects have the local scale. The pupil of an ideal model is a disk; its ray is the one at
the same part of the area, in the same direction.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.app.studies.charts.ladder import Model
from lensbench.app.studies.timing import even_points
from lensbench.core.kernels.block import U0, U1, WEIGHT, L, M, N, Step, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.pupils.radial_sampler import PupilTable

RAYS = 4096
STEP = 1e-4                     # step of the derivative, in half film diagonals
STEEPEST = 0.2                  # lower limit of the cosine between ray and axis
FARTHEST = 20.0                 # lens lengths: a farther entrance pupil is replaced by the first vertex
RADII, SAMPLES = 16, 1024       # for the falloff
LIT = 0.02                      # share of the light on the axis: darker film is not compared
LINE = [X, Y, Z, L, M, N, WEIGHT]


class Error(NamedTuple):
    """Errors of one model: displacements in pixels over all rays and distances, light in stops over the film.

    focus: rms of objects in focus alone. lost: share of the rays that the lens passes and the model loses.
    """

    rms: float
    p99: float
    worst: float
    focus: float
    stops_rms: float
    stops_worst: float
    lost: float


@dataclass(frozen=True, eq=False)
class Truth:
    """Reference rays and light of a lens in front of a film. camera: with any model."""

    camera: lb.LensCamera

    def error(self, model: Model) -> Error:
        """Errors of the model."""
        program = Program(list(model.lens), model.real)
        if model.aim:
            off = self._displaced(program.run(self._aims, LINE, self.rays))
        else:                                           # the disk may be upside down: take the better way
            ways = [self._displaced(program.run(self._on_disk(turn), LINE, self.rays)) for turn in (0.0, math.pi)]
            off = min(ways, key=lambda way: float(np.nansum(way**2)))
        passes = np.isfinite(off).all(0)
        lost, off = 1.0 - float(passes.mean()), off[:, passes]
        stops = self._stops(model)
        if not off.size:
            return Error(math.inf, math.inf, math.inf, math.inf, math.inf, math.inf, lost)
        return Error(_rms(off), float(np.quantile(off, 0.99)), float(off.max()), _rms(off[0]), _rms(stops),
                     float(stops.max()), lost)

    @property
    def rays(self) -> int:
        """Number of sampled rays that pass the lens."""
        return len(self._chosen)

    @cached_property
    def widest(self) -> float:
        """Largest angle of the field of view from the axis (radians)."""
        return float(np.arccos(np.clip(-self._exact[5], -1.0, 1.0)).max())

    def arriving(self, before: float) -> tuple[np.ndarray, np.ndarray]:
        """Rays (n, 3), lens frame, mm, from a plane `before` the first vertex, none flatter than STEEPEST."""
        camera, ray = self.camera, self._exact[:, -self._exact[5] > STEEPEST]
        points, directions = ray[:3] + [[0.0], [0.0], [camera.lens.length + camera.film_distance]], -ray[3:]
        return (points - directions * (points[2] + before) / directions[2]).T.copy(), directions.T.copy()

    # The rays

    @cached_property
    def _spread(self) -> np.ndarray:
        """Film x, y (mm) and U0, U1, (4, RAYS), evenly over both: multiples of the roots of x⁵ = x + 1."""
        root = 1.1673039782614187
        unit = (0.5 + np.arange(RAYS) * root ** -np.arange(1.0, 5.0)[:, None]) % 1.0
        film = self.camera.film
        return np.stack([(unit[0] - 0.5) * film.width, (unit[1] - 0.5) * film.height, unit[2], unit[3]])

    @cached_property
    def _traced(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Places on the plane of the last vertex (2, n), rays in front of the lens (6, n), and whether they pass."""
        rear, lit = self._rear(self._spread)
        ray, passes = self._through(self._spread[:2], rear)
        return rear, ray, passes & lit

    def _rear(self, spread: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Aim points (2, n) on the plane of the last vertex for film x, y and U0, U1 (4, n), and whether lit."""
        x, y, u0, u1 = spread
        l, m, n, weight = Program([self._regions], np.float64).run({X: x, Y: y, U0: u0, U1: u1}, [L, M, N, WEIGHT],
                                                                   spread.shape[1])
        return np.stack([x, y]) - self.camera.film_distance * np.stack([l, m]) / n, weight > 0.0

    @cached_property
    def _regions(self):
        """The step into the exit-pupil regions, at their true size if the lens has rotational symmetry."""
        camera = self.camera
        if camera.lens.is_rotationally_symmetric:
            return PupilTable.of(camera.lens, camera.film_distance, camera.film.diagonal / 2.0, widened=False).step(1.0)
        return camera.pupil.step(1.0)

    @cached_property
    def _chosen(self) -> np.ndarray:
        return np.flatnonzero(self._traced[2])

    @cached_property
    def _exact(self) -> np.ndarray:
        """Rays (6, rays) of the lens, in front of it."""
        return self._traced[1][:, self._chosen]

    def _through(self, film: np.ndarray, rear: np.ndarray, clip: bool = True) -> tuple[np.ndarray, np.ndarray]:
        """Rays (6, n) in front of the lens from film points and rear-plane points (2, n), and whether they pass."""
        lens, away, n = self.camera.lens, self.camera.film_distance, film.shape[1]
        traced = lb.trace(lens, np.column_stack([*film, np.full(n, lens.length + away)]),
                         np.column_stack([*(rear - film), np.full(n, -away)]), forward=False, clip=clip)
        points = traced.points - [0.0, 0.0, lens.length + away]
        return np.concatenate([points.T, traced.directions.T]), traced.fate == lb.Fate.PASSED

    @cached_property
    def _aims(self) -> dict[int, np.ndarray]:
        """Lane rows of the rays at the film."""
        film, rear = self._spread[:2, self._chosen], self._traced[0][:, self._chosen]
        way = np.stack([*(rear - film), np.full(self.rays, -self.camera.film_distance)])
        way /= np.sqrt((way**2).sum(0))
        return {X: film[0], Y: film[1], L: way[0], M: way[1], N: way[2], WEIGHT: np.ones(self.rays)}

    def _on_disk(self, turn: float) -> dict[int, np.ndarray]:
        """Lane rows of an ideal model's rays at the same part of the area; U0 of a table goes around each half."""
        x, y, u0, u1 = self._spread[:, self._chosen]
        around = 2.0 * math.pi * np.where(u0 < 0.5, u0, 0.5 - u0)
        v, u = _square(np.sqrt(u1), around + np.arctan2(y, x) + turn)
        return {X: x, Y: y, U0: u, U1: v}

    # The difference

    @cached_property
    def _eye(self) -> float:
        """Z of the entrance pupil in the camera frame; of the first vertex if the pupil lies far away."""
        camera, z = self.camera, self.camera.first_order.entrance_pupil.z
        return (z if abs(z) < FARTHEST * camera.lens.length else 0.0) - camera.lens.length - camera.film_distance

    @cached_property
    def distances(self) -> tuple[float, float, float]:
        """Distances of the objects from the entrance pupil along the axis (mm): in focus, nearer, infinity or far."""
        focus = self.camera.focus_distance + self._eye
        far = 50.0 * abs(self.camera.first_order.efl)
        return (focus, far / 2.0, far) if math.isinf(focus) else (focus, focus / 2.0, math.inf)

    def _directions_to_objects(self, ray: np.ndarray) -> np.ndarray:
        """Directions (distances, 3, n) from the entrance pupil to the points where rays meet the objects."""
        away = ray[:3] - np.array([0.0, 0.0, self._eye])[:, None]
        foot = away - (away * ray[3:]).sum(0) * ray[3:]
        slant = np.maximum(-self._exact[5], STEEPEST)
        return np.stack([ray[3:] + foot * (slant / distance) for distance in self.distances])

    @cached_property
    def _true(self) -> np.ndarray:
        return self._directions_to_objects(self._exact)

    @cached_property
    def _film_of_direction(self) -> np.ndarray:
        """Film displacement (mm) per change of direction (distances, 2, 3, n): the lens's inverse derivative."""
        h = STEP * self.camera.film.diagonal / 2.0
        slopes = []
        for axis in (0, 1):
            sides = []
            for step in (h, -h):
                moved = self._spread[:, self._chosen]
                moved[axis] += step
                sides.append(self._directions_to_objects(self._through(moved[:2], self._rear(moved)[0], clip=False)[0]))
            slopes.append((sides[0] - sides[1]) / (2.0 * h))
        a, b = slopes
        aa, ab, bb = (a * a).sum(1), (a * b).sum(1), (b * b).sum(1)
        det = np.maximum(aa * bb - ab * ab, 1e-300)
        return np.stack([(bb[:, None] * a - ab[:, None] * b) / det[:, None],
                         (aa[:, None] * b - ab[:, None] * a) / det[:, None]], 1)

    def _displaced(self, ray: np.ndarray) -> np.ndarray:
        """Displacement (pixels) of the model's rays (distances, n); NaN where the model loses them."""
        off = self._directions_to_objects(ray[:6].astype(float)) - self._true
        pixels = np.sqrt(((self._film_of_direction * off[:, None]).sum(2) ** 2).sum(1)) / self.camera.film.pitch
        return np.where(ray[6] > 0.0, pixels, np.nan)

    # The light

    @cached_property
    def _places(self) -> tuple[np.ndarray, np.ndarray]:
        """Film radii (mm) from the axis to the corner, equally many in each part of the area, and the light there."""
        camera = self.camera
        radii = 0.5 * camera.film.diagonal * np.sqrt(np.append(0.0, (np.arange(RADII) + 0.5) / RADII))
        if camera.lens.is_rotationally_symmetric and camera.lens.iris.is_round:
            return radii, lb.falloff(camera.lens, camera.film_distance, radii).total
        light = self._light(replace(camera, model="trace").camera_steps(), np.float64, radii)
        return radii, light / light[0]

    def _light(self, steps: list[Step], real, radii: np.ndarray) -> np.ndarray:
        """Mean weight of rays over the pupil, for film points on the diagonal at radii (mm)."""
        film = self.camera.film
        u0, u1 = even_points(SAMPLES).T
        r = np.repeat(radii, SAMPLES) / film.diagonal
        samples = {X: r * film.width, Y: r * film.height, U0: np.tile(u0, len(radii)), U1: np.tile(u1, len(radii))}
        return Program(steps, real).run(samples, [WEIGHT], len(r))[0].astype(float).reshape(len(radii), -1).mean(1)

    def _stops(self, model: Model) -> np.ndarray:
        """Error of the light in stops, relative to the axis, where the lens lights the film."""
        radii, true = self._places
        lit = true > LIT
        light = self._light(model.steps, model.real, radii)
        with np.errstate(divide="ignore"):
            return np.abs(np.log2(light[lit] / light[0] / true[lit]))


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt((values**2).mean()))


def _square(radius: np.ndarray, angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points of the unit square whose concentric map gives points of the unit disk: inverse of `disk.concentric`."""
    x, y = np.cos(angle), np.sin(angle)
    steep = np.abs(y) > np.abs(x)
    far = np.where(steep, np.sign(y), np.sign(x)) * radius
    near = far * np.arctan(np.where(steep, x, y) / np.where(steep, y, x)) * (4.0 / math.pi)
    a, b = np.where(steep, near, far), np.where(steep, far, near)
    return 0.5 * (a + 1.0), 0.5 * (b + 1.0)
