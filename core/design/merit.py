"""The merit function of lens design: spots or wave errors over positions, fields and colours.

Lengths in mm, lens frame. Rays are aimed at points spread evenly over the stop, and weigh as the area of their beam in
front of the lens. The film of each position lies at its best focus, as `best_focus` defines it. A wave error is the
optical length from the wave before the lens to the point nearest to the image point C, which is linear in C (Welford,
Aberrations of Optical Systems, 1986, section 7); pistons of each field and colour, and C of each field, are free.
"""

from dataclasses import dataclass
from math import inf, isfinite, isinf, nan, pi, sqrt
from typing import NamedTuple

import numpy as np

from lensbench.core.analysis.grids.chief_rays import find_chief_rays
from lensbench.core.design.goal import Goal, edge_thickness, held_lengths, image_distance
from lensbench.core.kernels.numeric import gauss_rule
from lensbench.core.optics.focus import sharpest
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.paraxial import ray_matrix, scene_side_origin
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import surface_table, trace_rays
from lensbench.core.optics.surfaces import AFTER, BEFORE, SurfaceTable
from lensbench.core.text import fixed

SAMPLING = 6, 10                # rings and arms of the rays that are improved
DENSE = 16, 30                  # of those by which a lens is judged
AIMING = 8                      # Newton steps, at most, that bring a ray to its point of the stop
AIMED = 1e-11                   # of the stop's radius: an error at which they end
MISSED = 1e-6                   # at which a ray does not count
HELD = 0.1                      # mm of spot radius that a 1 % change of a held length counts as
THIN = 1.0                      # mm of spot radius that 1 mm of missing thickness counts as
LEAST = 3                       # rays of a field that count as light


@dataclass(frozen=True)
class Judgement:
    """A lens as it is judged, by the light that passes it.

    Args:
        rms: Of spots or waves (mm) over positions, fields and colours; inf where a field has no light.
        by_position: The same (mm) of each position.
        total: Sum of squares (mm²) that an improvement lowers: of the aim, of what is held and of what is too thin.
        films: Last vertex → best focus (mm) of each position.
        light: Area (mm²) of the beams in front of the lens, mean over positions and fields.
    """

    rms: float
    by_position: tuple[float, ...]
    total: float
    films: tuple[float, ...]
    light: float


def judge(lens: Lens, goal: Goal) -> Judgement:
    """Judge a lens by the rays that pass it.

    Args:
        lens: The lens.
        goal: What is judged, from `goal_of` of this lens or of another.
    """
    dark = Judgement(inf, (inf,) * len(goal.positions), inf, (inf,) * len(goal.positions), 0.0)
    merit = Merit(lens, goal, DENSE)
    if not all(used.sum(1).min() >= LEAST for used in merit.used):
        return dark
    parts = [merit.errors(lens, k) for k in range(len(goal.positions))]
    if any(one is None for one in parts):
        return dark
    lit = [one for one in parts if one is not None]
    squares = [float(errors @ errors) for errors, _, _ in lit]
    penalties = merit.penalties(lens)
    count = len(lit)
    return Judgement(sqrt(sum(squares)) / merit.scale, tuple(sqrt(count * square) / merit.scale for square in squares),
                     sum(squares) + float(penalties @ penalties), tuple(film for _, film, _ in lit),
                     sum(light for _, _, light in lit) / count)


class Merit:
    """The residuals of lenses near a first one, whose rays count.

    used: (fields, rays) for each position: whether a ray counts. scale: 4 √6 N, by which a wave error of defocus counts
    as its spot.
    """

    def __init__(self, start: Lens, goal: Goal, sampling: tuple[int, int] = SAMPLING) -> None:
        rings, arms = sampling
        squares, shares = gauss_rule(rings)
        radii = np.sqrt(squares)
        turns = np.arange(arms) + 0.5 * (np.arange(rings) % 2)[:, None]
        angles = 2.0 * pi * (turns + 0.25) / arms
        self._points = np.stack([radii[:, None] * np.cos(angles), radii[:, None] * np.sin(angles)], 2).reshape(-1, 2)
        self._parts = np.repeat(shares / arms, arms)               # of the stop's area, by ray
        self.goal = goal
        lenses = [position.of(start) for position in goal.positions]
        f_number = held_lengths(lenses[0], inf, goal.primary_wavelength, False)[0]
        self.scale = 4.0 * sqrt(6.0) * f_number if goal.aim == "wavefront" else 1.0
        self._planes = [scene_side_origin(lens, goal.primary_wavelength) for lens in lenses]
        self._near = [self._entries(lens, k) for k, lens in enumerate(lenses)]
        self._near = [self._aimed(lens, k, None)[0] for k, lens in enumerate(lenses)]
        self.used = [self._passing(lens, k) for k, lens in enumerate(lenses)]

    def residuals(self, lens: Lens) -> np.ndarray | None:
        """The residuals (mm, weighted), whose sum of squares is the merit; None where a ray is lost."""
        parts = []
        for k in range(len(self.goal.positions)):
            judged = self.errors(lens, k)
            if judged is None:
                return None
            parts.append(judged[0])
        return np.concatenate([*parts, self.penalties(lens)])

    def include(self, lens: Lens) -> bool:
        """Count the rays too that pass this lens; whether there are any that did not count."""
        before = self.used
        self.used = [used | self._passing(position.of(lens), k)
                     for k, (used, position) in enumerate(zip(before, self.goal.positions, strict=True))]
        return any((now & ~then).any() for now, then in zip(self.used, before, strict=True))

    def errors(self, lens: Lens, k: int) -> tuple[np.ndarray, float, float] | None:
        """Residuals of position k (mm, weighted), its film (mm behind the last vertex) and light; None for a ray that
        is lost.

        Those of spots are the distances of the rays from the centre of their spot, over all colours of its field.
        """
        position, used, moved = self.goal.positions[k], self.used[k], self.goal.positions[k].of(lens)
        aims, areas, hit = self._aimed(moved, k, used)
        if not hit[used].all():
            return None
        areas = np.where(used, areas, 0.0)
        light = areas.sum(1)
        fields = np.repeat(np.arange(len(used)), used.sum(1))
        ray_weights = (areas / np.where(light > 0.0, light, 1.0)[:, None])[used]
        origins, directions = (values[used] for values in self._rays(k, aims))
        traced = []
        for wavelength in self.goal.wavelengths:
            one = _traced(moved, wavelength, origins, directions, isinf(position.object_distance))
            if one is None:
                return None
            traced.append(one)
        points, ways = (np.stack([one[quantity] for one in traced]) for quantity in (0, 1))
        slopes = ways[..., :2] / ways[..., 2:]
        shifts = points[..., :2] + (moved.length - points[..., 2:]) * slopes
        weights = np.array(self.goal.weights)[:, None] * ray_weights            # (colours, rays); 1 over a field
        shifts, slopes = (values - _means(values, weights, fields)[fields] for values in (shifts, slopes))
        axis = fields == 0
        film = sharpest(shifts[:, axis], slopes[:, axis], weights[:, axis, None])
        shares = np.sqrt(weights * np.array(position.weights)[fields] / len(self.goal.positions))
        if self.goal.aim == "wavefront":
            errors = self.scale * self._waves(moved, traced, shares, fields, film)
        else:
            errors = (shares[..., None] * (shifts + film * slopes)).ravel()
        return errors, film, float(light @ position.weights)

    def penalties(self, lens: Lens) -> np.ndarray:
        """Residuals (mm) of what is held and of what must not be thinner."""
        penalties: list[float] = []
        for position in self.goal.positions:
            moved = position.of(lens)
            now = held_lengths(moved, position.object_distance, self.goal.primary_wavelength,
                               self.goal.hold_back_focus) if position.held else ()
            penalties += [100.0 * HELD * (value / target - 1.0) if isfinite(value) else 100.0 * HELD
                          for value, target in zip(now, position.held, strict=False)]
            for i, edge, centre in position.floors:
                thickness = edge_thickness(moved.surfaces[i], moved.surfaces[i + 1])
                penalties.append(THIN * max(0.0, edge - thickness) if isfinite(thickness) else THIN)
                penalties.append(THIN * max(0.0, centre - moved.surfaces[i].thickness))
        return np.array(penalties)

    def _entries(self, lens: Lens, k: int) -> np.ndarray:
        """Where rays to the points of the stop cross the entrance pupil, (fields, rays, 2), as a first guess."""
        position, plane, wavelength = self.goal.positions[k], self._planes[k], self.goal.primary_wavelength
        chief = find_chief_rays(lens, image_distance(lens, position.object_distance, wavelength),
                                np.array(position.fields), position.object_distance, wavelength=wavelength)
        away = (plane - chief.points[:, 2]) / chief.directions[:, 2]
        middles = chief.points[:, :2] + away[:, None] * chief.directions[:, :2]
        return np.asarray(middles[:, None] + self._points * _pupil_radius(lens, wavelength))

    def _rays(self, k: int, aims: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Origins and unit directions (..., fields, rays, 3) of rays that cross the entrance pupil at (..., 2)."""
        position, plane = self.goal.positions[k], self._planes[k]
        through = np.concatenate([aims, np.full((*aims.shape[:-1], 1), plane)], -1)
        fields = np.array(position.fields)
        if isinf(position.object_distance):
            size = np.hypot(*fields.T)[:, None]
            ways = np.concatenate([fields * np.sinc(size / pi), np.cos(size)], 1)[:, None]
            return through, np.broadcast_to(ways, through.shape)
        origins = np.column_stack([fields, np.full(len(fields), -position.object_distance)])[:, None]
        ways = (through - origins) * np.sign(plane + position.object_distance)
        return np.broadcast_to(origins, through.shape), ways / np.linalg.norm(ways, axis=-1, keepdims=True)

    def _aimed(self, lens: Lens, k: int, used: np.ndarray | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Crossings of the entrance pupil (fields, rays, 2), areas there (mm²), and whether the stop was hit, by ray.

        By Newton's method, until the rays that are used, or all, have arrived.
        """
        radius, wavelength = lens.stop.semi_diameter, self.goal.primary_wavelength
        front = surface_table(lens, wavelength).part(0, lens.stop_index + 1)
        aims, step = self._near[k], 1e-4 * abs(_pupil_radius(lens, wavelength))
        for n in range(AIMING + 1):
            origins, ways = self._rays(k, np.stack([aims, aims + [step, 0.0], aims + [0.0, step]]))
            points, _, fate = trace_points(front, origins.reshape(-1, 3), ways.reshape(-1, 3), False)
            hits = np.where((fate == 0)[:, None], points[:, :2], nan).reshape(3, *aims.shape)
            by_x, by_y = (hits[1:] - hits[0]) / step
            missing = self._points * radius - hits[0]
            turn = by_x[..., 0] * by_y[..., 1] - by_x[..., 1] * by_y[..., 0]
            off = np.abs(missing).max(-1)
            if n == AIMING or not ((off if used is None else off[used]) > AIMED * radius).any():
                break
            with np.errstate(all="ignore"):
                move = np.stack([missing[..., 0] * by_y[..., 1] - missing[..., 1] * by_y[..., 0],
                                 missing[..., 1] * by_x[..., 0] - missing[..., 0] * by_x[..., 1]], -1) / turn[..., None]
            aims = aims + np.where(np.isfinite(move), move, 0.0)
        with np.errstate(all="ignore"):
            areas = pi * radius * radius * self._parts / np.abs(turn)
        hit = (off < MISSED * radius) & np.isfinite(areas)
        return aims, np.where(hit, areas, 0.0), hit

    def _passing(self, lens: Lens, k: int) -> np.ndarray:
        """Which rays pass the rims of a lens, (fields, rays)."""
        aims, _, hit = self._aimed(lens, k, None)
        origins, ways = self._rays(k, aims)
        _, _, fate = trace_points(surface_table(lens, self.goal.primary_wavelength), origins[hit], ways[hit], True)
        passing = hit.copy()
        passing[hit] = fate == 0
        return passing

    def _waves(self, lens: Lens, traced: list["_Traced"], shares: np.ndarray, fields: np.ndarray,
               film: float) -> np.ndarray:
        """The weighted wave errors (mm), field by field."""
        image = [0.0, 0.0, lens.length + film]
        lengths = np.stack([one.lengths + one.medium * ((image - one.points) * one.directions).sum(1)
                            for one in traced])                                     # (colours, rays)
        ways = np.stack([one.directions for one in traced])
        waves = []
        for field in np.unique(fields):
            of_field, count = fields == field, len(traced)
            share = shares[:, of_field]
            free = np.zeros((count, int(of_field.sum()), count + 2))
            free[range(count), :, range(count)] = share
            free[..., count:] = share[..., None] * ways[:, of_field, :2]
            basis, errors = free.reshape(-1, count + 2), (share * lengths[:, of_field]).ravel()
            waves.append(errors - basis @ np.linalg.lstsq(basis, errors, rcond=None)[0])
        return np.concatenate(waves)


class _Traced(NamedTuple):
    """Points and directions (n, 3) behind the lens, optical lengths (n,) up to there, and the index there."""

    points: np.ndarray
    directions: np.ndarray
    lengths: np.ndarray
    medium: float


def _traced(lens: Lens, wavelength: float, origins: np.ndarray, directions: np.ndarray,
            plane_wave: bool) -> _Traced | None:
    """Rays through the whole lens; None where one is lost. plane_wave: the wave is that of an object at infinity."""
    table, paths = surface_table(lens, wavelength), np.empty((len(origins), len(lens.surfaces) + 1, 3))
    points, after, fate = trace_points(table, origins, directions, False, paths)
    if fate.any():
        return None
    steps = np.diff(paths, axis=1)                  # a step back, before a surface that crosses, counts negative
    lengths = (np.sign(steps[..., 2]) * np.linalg.norm(steps, axis=2)) @ table.numbers[:, BEFORE]
    if plane_wave:
        lengths = lengths + table.numbers[0, BEFORE] * (origins * directions).sum(1)
    return _Traced(points, after, lengths, float(table.numbers[-1, AFTER]))


def amount(rms: float, aim: str) -> str:
    """The rms (mm) of an aim in words."""
    if aim == "wavefront":
        return f"wave error {fixed(1000.0 * rms / D_LINE, 4)} waves rms"
    return f"spot {fixed(1000.0 * rms, 3)} µm rms"


def trace_points(table: SurfaceTable, origins: np.ndarray, directions: np.ndarray, clip: bool,
                 paths: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (n, 3), directions (n, 3) and fates (n,) behind the surfaces of a table; paths as for `trace_rays`."""
    count = len(origins)
    points, after = np.empty((count, 3)), np.empty((count, 3))
    fate, surface = np.empty(count, np.int32), np.empty(count, np.int32)
    trace_rays(table, clip, np.ascontiguousarray(origins), np.ascontiguousarray(directions), points, after, fate,
               surface, paths, 1)
    return points, after, fate


def _means(values: np.ndarray, weights: np.ndarray, fields: np.ndarray) -> np.ndarray:
    """Weighted means (fields, 2) of values (colours, rays, 2) over the rays and colours of each field."""
    summed = (weights[..., None] * values).sum(0)
    return np.stack([np.bincount(fields, summed[:, axis]) for axis in (0, 1)], 1)


def _pupil_radius(lens: Lens, wavelength: float) -> float:
    """Radius (mm) of the entrance pupil, negative where the stop is imaged upside down."""
    return lens.stop.semi_diameter / ray_matrix(lens, 0, lens.stop_index, wavelength)[0]
