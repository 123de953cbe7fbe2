"""Outline of the exit-pupil region for any film point and lens, by ray aiming, and the end of the light on the film.

As in `rim_solver`, but without an axis of symmetry: the search covers both directions, and the rim is solved all
around.

A ray is given by its film point (n, 3), camera frame, and its rear point (n, 2), where it crosses the plane of the last
vertex, mm. It passes where its clearance is at most 1. The map from the rear point to the stop is smooth, and Newton's
method inverts it: this finds stops of any size. A scan of the stop then finds what other clear apertures leave open.
Lens frame, float64.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.imaging.film import UPRIGHT
from lensbench.core.kernels.block import L, M, N, X, Y
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.program import Program
from lensbench.core.optics.block_trace import ClearanceTracer, clearance_tracer, clearances, surface_steps
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.pupils.rim_solver import DIGITS, REACH, ROUGH, rear_interval, rim_distances

AIM_ITERATIONS = 30         # of Newton's method, shortened steps included
STEP = 1e-5             # × the rear semi-diameter, for the slopes of the map
CENTRED = 0.01          # × the stop's radius: near enough to its centre
LEGS = 8                # from the axis to a film point whose chief ray is far from the paraxial one
SCAN = 12               # points across and up in one scan
NEARBY = 2              # cells about the best point that the next scan covers
SCANS = 7
WINDOW = 1.25           # × the scanned area: the map of the stop bends farther than its slopes say
COARSE = 0.05           # error of a clearance in a scan, × its cell in stop radii


@njit(cache=True, error_model="numpy", nogil=True)
def _scan(film_x, film_y, film_z, aims, window, distance, enough, tracer):
    """Move the rear points `aims` (n, 2) to the least clearance within aims ± window · (±1, ±1); overwrites window.

    The first scans, which tell apart very different clearances, are traced in float32.
    """
    n, cells = film_x.size, SCAN * SCAN
    from_x, from_y, from_z = np.empty(n * cells), np.empty(n * cells), np.empty(n * cells)
    px, py, out = np.empty(n * cells), np.empty(n * cells), np.empty(n * cells)
    level, finer = np.full(n, np.inf), 2.0 * NEARBY / SCAN
    accuracy = COARSE * WINDOW * 2.0 / SCAN
    for _ in range(SCANS):
        count = 0
        for k in range(n):
            if not level[k] < enough:
                for j in range(cells):
                    across, up = (j % SCAN + 0.5) * (2.0 / SCAN) - 1.0, (j // SCAN + 0.5) * (2.0 / SCAN) - 1.0
                    from_x[count], from_y[count], from_z[count] = film_x[k], film_y[k], film_z[k]
                    px[count] = aims[k, 0] + window[k, 0, 0] * across + window[k, 0, 1] * up
                    py[count] = aims[k, 1] + window[k, 1, 0] * across + window[k, 1, 1] * up
                    count += 1
        if count == 0:
            return
        clearances(from_x, from_y, from_z, px, py, distance, out[:count], tracer, accuracy)
        first = 0
        for k in range(n):
            if not level[k] < enough:
                least = first
                for j in range(first + 1, first + cells):
                    least = j if out[j] < out[least] else least
                if out[least] < level[k]:
                    aims[k, 0], aims[k, 1], level[k] = px[least], py[least], out[least]
                window[k] *= finer
                first += cells
        accuracy *= finer


@dataclass(frozen=True, eq=False)
class Aim:
    """Rays of one lens at one wavelength (µm), with the upright film at film_distance (mm) behind the last vertex."""

    lens: Lens
    film_distance: float
    wavelength: float = D_LINE
    tracer: ClearanceTracer = field(init=False)      # for `clearances` and `rim_distances`

    def __post_init__(self) -> None:
        object.__setattr__(self, "tracer", clearance_tracer(self.lens, self.film_distance, self.wavelength))

    @cached_property
    def _to_stop(self) -> Program:
        """From the film to the stop: most film points never need it."""
        behind = slice(0, len(self.lens.surfaces) - self.lens.stop_index)
        return Program(surface_steps(self.lens, self.film_distance, self.wavelength, which=behind), np.float64)

    def clearances(self, film: np.ndarray, rear: np.ndarray) -> np.ndarray:
        """Clearances (n,) of rays; inf where a ray does not come through."""
        out = np.empty(len(film))
        clearances(*_columns(film), *_columns(rear), self.film_distance, out, self.tracer, 0.0)
        return out

    def find_light(self, film: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rear points (n, 2) of small clearance, and that clearance (n,), ≥ 1 where no light was found."""
        rear = self.paraxial_centres(film)
        level = self.clearances(film, rear)

        def improve(which: np.ndarray, trial: np.ndarray, there: np.ndarray) -> np.ndarray:
            """Keep better rear points of the film points `which`; the indices of those still dark."""
            better = there < level[which]
            rear[which[better]], level[which[better]] = trial[better], there[better]
            return np.flatnonzero(~(level < 1.0))

        # Try the centre of the stop, then the whole stop, then the whole visible part of the last surface
        dark = np.flatnonzero(~(level < 1.0))
        if dark.size:
            centre, window = self.stop_centres(film[dark], rear[dark])
            left = improve(dark, centre, self.clearances(film[dark], centre))
            still = np.isin(dark, left)
            left = improve(left, *self.scan(film[left], centre[still], window[still], 1.0))
            if left.size:
                # Where the line from the film point to the middle of the rear plane crosses z = 0
                centred = film[:, :2] / (1.0 + film[:, 2:] / self.film_distance)
                low, high = np.stack([rear_interval(self.lens, self.film_distance, centred[left, axis], upright)
                                      for axis, upright in ((0, False), (1, True))], 2)
                half = 0.5 * (high - low)[:, :, None] * np.eye(2)
                improve(left, *self.scan(film[left], 0.5 * (low + high), half, 1.0))
        return rear, level

    def stop_centres(self, film: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rear points (n, 2) of the rays to the stop's centre, and the stop's images (n, 2, 2): mm per stop radius.

        Newton's method starts from `start` (n, 2), and where it fails continues the ray of the axis in LEGS steps.
        Without such a ray, the result is the nearest point found.
        """
        aims, off, image = self._newton(film, start)
        far = np.flatnonzero(~((off < CENTRED) & (self.clearances(film, aims) < 1.0)))
        stepped = np.zeros((far.size, 2))
        for leg in range(1, LEGS + 1):
            stepped, stepped_off, stepped_image = self._newton(film[far] * (leg / LEGS), stepped)
        if far.size:
            better = (stepped_off < CENTRED) | (stepped_off < off[far])
            aims[far[better]], image[far[better]] = stepped[better], stepped_image[better]
        return aims, image

    def stop_centres_near(self, film: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """`stop_centres` of film points (n, 3) beside those to which `start` (n, 2) belongs."""
        aims, off, image = self._newton(film, start)
        lost = np.flatnonzero(~(off < CENTRED))
        if lost.size:
            aims[lost], image[lost] = self.stop_centres(film[lost], start[lost])
        return aims, image

    def scan(self, film: np.ndarray, centre: np.ndarray, window: np.ndarray,
                enough: float) -> tuple[np.ndarray, np.ndarray]:
        """Rear points (n, 2) of least clearance within centre ± window (n, 2, 2) · (±1, ±1), and that clearance (n,).

        Scans ever more finely about the best point, until its clearance is below `enough`.
        """
        aims, level = centre.copy(), np.full(len(film), np.inf)
        scanned = np.flatnonzero(np.isfinite(window).all((1, 2)))
        if scanned.size:
            there = aims[scanned]
            _scan(*_columns(film[scanned]), there, WINDOW * window[scanned], self.film_distance, enough, self.tracer)
            aims[scanned], level[scanned] = there, self.clearances(film[scanned], there)
        return aims, level

    def paraxial_centres(self, film: np.ndarray) -> np.ndarray:
        """Rear points (n, 2) on the lines to the centres of the paraxial exit pupils of the sections x–z and y–z."""
        centres = np.empty((len(film), 2))
        for k, section in enumerate("xy"):
            fo = first_order(self.lens.section(section), self.wavelength)
            ahead = self.lens.length + self.film_distance - fo.exit_pupil.z
            away = self.film_distance + film[:, 2]
            centres[:, k] = film[:, k] * (1.0 - away / (ahead + film[:, 2]) if ahead else 1.0)
        return centres

    def _newton(self, film: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rear points near the stop's centre by Newton's method, their distance from it (stop radii), its images."""
        aims, advance = start.copy(), np.zeros_like(start)
        off, image = np.full(len(film), np.inf), np.full((len(film), 2, 2), np.nan)
        left = np.arange(len(film))
        for _ in range(AIM_ITERATIONS):
            if not left.size:
                break
            trial = aims[left] + advance[left]
            stop_point, slopes = self._on_stop(film[left], trial)
            far = np.hypot(*stop_point.T)
            better = far < off[left]
            aims[left[better]], off[left[better]] = trial[better], far[better]
            image[left[better]] = slopes[better]
            advance[left] = np.where(better[:, None], -(slopes @ stop_point[:, :, None])[:, :, 0], 0.25 * advance[left])
            left = left[(off[left] >= CENTRED) & (off[left] < np.inf) & np.isfinite(advance[left]).all(1)]
        return aims, off, image

    def _on_stop(self, film: np.ndarray, rear: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points (n, 2) on the stop, in its radii, and the derivatives (n, 2, 2) of the rear points by these."""
        radius, small = self.lens.stop.semi_diameter, STEP * self.lens.surfaces[-1].semi_diameter
        n = len(film)
        vectors = np.concatenate([rear, rear + [small, 0.0], rear + [0.0, small]]) - np.tile(film[:, :2], (3, 1))
        away = np.tile(self.film_distance + film[:, 2], 3)
        size = 1.0 / np.sqrt((vectors**2).sum(1) + away**2)
        start = np.tile(film[:, :2], (3, 1)) + vectors * (np.tile(film[:, 2], 3) / away)[:, None]       # at z = 0
        inputs = {X: start[:, 0], Y: start[:, 1], L: vectors[:, 0] * size, M: vectors[:, 1] * size, N: -away * size}
        on_stop = self._to_stop.run(inputs, [X, Y], 3 * n).T - self.lens.vertex(self.lens.stop_index)[:2]
        centre, beside, above = (on_stop / radius).reshape(3, n, 2)
        with np.errstate(divide="ignore", invalid="ignore"):        # the point of a lost ray is not finite
            (a, c), (b, d) = ((beside - centre) / small).T, ((above - centre) / small).T
            inverse = np.array([[d, -b], [-c, a]]) / (a * d - b * c)
        return centre, inverse.transpose(2, 0, 1)


def _columns(points: np.ndarray) -> tuple[np.ndarray, ...]:
    """Contiguous coordinates (n,) of points (n, 2) or (n, 3)."""
    return tuple(np.ascontiguousarray(column) for column in points.T)


PLACES = 16             # multiples of each direction, to find the last one with light
FINER = 3               # times that the first multiple is divided alike where it is dark: films of 65 000 image circles
EDGE_ITERATIONS = 4          # of false position between two multiples: within 2e-4 of the film, mostly 1e-5
Placement = Callable[[np.ndarray], np.ndarray]
NO_LIGHT = 2.0          # largest clearance that the iteration uses; beyond it, it may be infinite


def edge_of_light(aim: Aim, directions: np.ndarray, furthest: float,
                  placed: Placement = UPRIGHT.points) -> tuple[np.ndarray, bool]:
    """Multiples (n,) of vectors (n, 2) mm from the film's centre up to which light falls, and whether any light ends.

    `furthest` where light reaches that multiple, or where no multiple has light. placed: camera-frame points (n, 3) of
    film points (n, 2).
    """
    edge, beyond = np.full(len(directions), furthest), np.full(len(directions), math.inf)
    which, reach = np.arange(len(directions)), furthest
    for _ in range(1 + FINER):
        multiples = reach * np.arange(1, PLACES + 1) / PLACES
        film = placed((multiples[:, None, None] * directions[which]).reshape(-1, 2))
        lit = aim.find_light(film)[1].reshape(PLACES, len(which)) < 1.0
        last, any_light = PLACES - 1 - np.argmax(lit[::-1], 0), lit.any(0)
        edge[which[any_light]] = multiples[last[any_light]]
        ends = any_light & (last < PLACES - 1)
        beyond[which[ends]] = multiples[last[ends] + 1]
        which, reach = which[~any_light], multiples[0]
        if not which.size:
            break
    which = np.flatnonzero(beyond < math.inf)
    if not which.size:
        return edge, False

    # The least clearance is 1 at the end of the light: false position, Illinois form
    def level(multiple: np.ndarray, near: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Least clearance − 1 of film points at these multiples, and the stop's centres, from `near` if known."""
        film = placed(multiple[:, None] * directions[which])
        centre, window = (aim.stop_centres(film, aim.paraxial_centres(film)) if near is None else
                          aim.stop_centres_near(film, near))
        return np.minimum(aim.scan(film, centre, window, 0.0)[1], NO_LIGHT) - 1.0, centre

    low, high = edge[which], beyond[which]
    at_low, centre = level(low)
    at_high, centre = level(high, centre)
    at_low, at_high, side = np.minimum(at_low, -1e-9), np.maximum(at_high, 1e-9), np.zeros(which.size)
    for _ in range(EDGE_ITERATIONS):
        multiple = np.clip(high - at_high * (high - low) / (at_high - at_low), low, high)
        middle, centre = level(multiple, centre)
        dark = ~(middle < 0.0)
        at_low = np.where(dark, np.where(side > 0.0, 0.5 * at_low, at_low), middle)
        at_high = np.where(dark, middle, np.where(side < 0.0, 0.5 * at_high, at_high))
        low, high, side = np.where(dark, low, multiple), np.where(dark, multiple, high), np.where(dark, 1.0, -1.0)
    edge[which] = low
    return edge, True


ROUGH_POINTS = 16       # of a rough rim, along which the final points are spaced evenly
DIRECTIONS = 128        # in which the length of the rough rim is measured


def solve_outlines(lens: Lens, film_distance: float, film_points: ArrayLike, points: int, tolerance: float,
                   wavelength: float = D_LINE, placed: Placement = UPRIGHT.points) -> tuple[np.ndarray, np.ndarray]:
    """Centres (n, 2), and points (n, points, 2) of each rim from its centre, counter-clockwise from +x, in mm.

    The centre is the centroid; the points are evenly spaced to about a tenth, and 0 for an empty region. film_points:
    (n, 2) mm; tolerance: of the rims (mm); wavelength: µm; placed: as in `edge_of_light`.
    """
    film = placed(np.asarray(film_points, float))
    film_x, film_y, film_z = np.ascontiguousarray(film.T)
    n = len(film)
    aim = Aim(lens, film_distance, wavelength)
    rear = lens.surfaces[-1].semi_diameter
    reach, size = REACH * rear, REACH * min(rear, lens.stop.semi_diameter)

    def solved(centre: np.ndarray, level: np.ndarray, cosine: np.ndarray, sine: np.ndarray, guess: np.ndarray,
               accuracy: float, error: float) -> np.ndarray:
        """Distances (n, directions) to the rims from these centres, to `accuracy` mm; error: of clearances."""
        rim = np.zeros(cosine.shape)
        rim_distances(film_x, film_y, film_z, *np.ascontiguousarray(centre.T), level, np.ascontiguousarray(cosine),
             np.ascontiguousarray(sine), guess, film_distance, reach, accuracy, rim, aim.tracer, error)
        return rim

    centre, level = aim.find_light(film)
    lit = level < 1.0

    # Rough rims, and from their centroids the directions of the final ones
    turn = 2.0 * math.pi * np.arange(ROUGH_POINTS) / ROUGH_POINTS
    cosine, sine = (np.tile(f(turn), (n, 1)) for f in (np.cos, np.sin))
    begin = np.where(lit, 0.6 * reach * np.maximum(1.0 - level, 1e-3), reach)
    rough = solved(centre, level, cosine, sine, np.tile(begin[:, None], ROUGH_POINTS), ROUGH * size, ROUGH)
    outline = np.stack([rough * cosine, rough * sine], 2)
    moved = centre + _centroids(outline)
    there = aim.clearances(film, moved)
    better = lit & (there < 1.0)                        # otherwise keep the first centre
    outline += np.where(better[:, None], centre - moved, 0.0)[:, None, :]
    centre, level = np.where(better[:, None], moved, centre), np.where(better, there, level)
    angle, guess = _even_directions(outline, points)
    rim = solved(centre, level, np.cos(angle), np.sin(angle), np.maximum(guess, 1e-3 * tolerance), tolerance,
                 DIGITS * tolerance / size)
    centre[~lit] = 0.0
    return centre, np.stack([rim * np.cos(angle), rim * np.sin(angle)], 2)


def _centroids(outlines: np.ndarray) -> np.ndarray:
    """Centroids (n, 2) of polygons (n, m, 2); 0 for an empty one."""
    after = np.roll(outlines, -1, 1)
    cross = outlines[..., 0] * after[..., 1] - outlines[..., 1] * after[..., 0]
    area = cross.sum(1)[:, None]
    moment = (cross[..., None] * (outlines + after)).sum(1) / 3.0
    return np.divide(moment, area, out=np.zeros_like(moment), where=area > 0.0)


@njit(cache=True, error_model="numpy", nogil=True)
def _even_directions(outlines, points):
    """Angles (n, points), from 0, of points evenly spaced along outlines (n, m, 2) about 0, and their distances."""
    count, corners, _ = outlines.shape
    angles, sizes = np.zeros((count, points)), np.zeros((count, points))
    turn, length = np.empty(corners + 2), np.empty(corners + 2)
    size, along = np.empty(DIRECTIONS + 1), np.zeros(DIRECTIONS + 1)
    step = 2.0 * math.pi / DIRECTIONS
    cosine, sine = np.cos(step * np.arange(DIRECTIONS + 1)), np.sin(step * np.arange(DIRECTIONS + 1))
    for k in range(count):
        # Corners by rising angle in [0, 2π), and those at the ends once more beyond the other end
        for i in range(corners):
            x, y = outlines[k, i]
            angle, slot = math.atan2(y, x) % (2.0 * math.pi), i + 1
            while slot > 1 and turn[slot - 1] > angle:
                turn[slot], length[slot] = turn[slot - 1], length[slot - 1]
                slot -= 1
            turn[slot], length[slot] = angle, math.hypot(x, y)
        turn[0], length[0] = turn[corners] - 2.0 * math.pi, length[corners]
        turn[corners + 1], length[corners + 1] = turn[1] + 2.0 * math.pi, length[1]
        # Length of the outline up to even angles
        i = 0
        for j in range(DIRECTIONS):
            while turn[i + 1] <= j * step:
                i += 1
            share = (j * step - turn[i]) / (turn[i + 1] - turn[i])
            size[j] = length[i] + share * (length[i + 1] - length[i])
        size[DIRECTIONS] = size[0]
        for j in range(DIRECTIONS):
            along[j + 1] = along[j] + math.hypot(
                size[j + 1] * cosine[j + 1] - size[j] * cosine[j], size[j + 1] * sine[j + 1] - size[j] * sine[j])
        if along[DIRECTIONS] == 0.0:                    # an empty region
            continue
        i = 0
        for j in range(points):
            target = along[DIRECTIONS] * j / points
            while along[i + 1] <= target:
                i += 1
            share = (target - along[i]) / (along[i + 1] - along[i])
            angles[k, j] = (i + share) * step
            sizes[k, j] = size[i] + share * (size[i + 1] - size[i])
    return angles, sizes
