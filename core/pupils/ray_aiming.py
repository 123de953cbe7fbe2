"""Ray aiming: rays from any film point, through lenses of any symmetry, at places where light passes.

A ray is given by its film point (n, 3), camera frame, and its rear point (n, 2), where it crosses the plane of the last
vertex, mm. It passes where its clearance is at most 1: the greatest share of a rim's radius at which it meets a
surface. The map from the rear point to the point on the stop is smooth, and Newton's method inverts it: this finds
stops of any size. A scan of the stop then finds what other rims leave open. Float64.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from lensbench.kernels.block import L, M, N, X, Y
from lensbench.kernels.cache import njit
from lensbench.kernels.program import Program
from lensbench.optics.block_trace import surface_steps
from lensbench.optics.clearance import ClearanceTracer, clearance_tracer, clearances
from lensbench.optics.glass import D_LINE
from lensbench.optics.paraxial import first_order
from lensbench.optics.prescription import Lens
from lensbench.pupils.rim_solver import rear_interval

ITERATIONS = 30         # of Newton's method, shortened steps included
STEP = 1e-5             # × the rear semi-diameter, for the slopes of the map
CENTRED = 0.01          # × the stop's radius: near enough to its centre
LEGS = 8                # from the axis to a film point whose chief ray is far from the paraxial one
SCAN = 12               # points across and up in one scan
NEARBY = 2              # cells about the best point that the next scan covers
SCANS = 7
WINDOW = 1.25           # × the scanned area: the map of the stop bends farther than its slopes say
COARSE = 0.05           # error of a clearance in a scan, × its cell in stop radii


@njit(cache=True, error_model="numpy", nogil=True)
def _scan(film_x, film_y, film_z, at, window, distance, enough, tracer):
    """Move the rear points `at` (n, 2) to the least clearance within at ± window · (±1, ±1); overwrites window.

    The first scans tell apart places whose clearances differ so much that float32 is exact enough.
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
                    px[count] = at[k, 0] + window[k, 0, 0] * across + window[k, 0, 1] * up
                    py[count] = at[k, 1] + window[k, 1, 0] * across + window[k, 1, 1] * up
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
                    at[k, 0], at[k, 1], level[k] = px[least], py[least], out[least]
                window[k] *= finer
                first += cells
        accuracy *= finer


@dataclass(frozen=True, eq=False)
class Aim:
    """Rays of one lens at one wavelength (µm), with the film in line at film_distance (mm) behind the last vertex."""

    lens: Lens
    film_distance: float
    wavelength: float = D_LINE
    tracer: ClearanceTracer = field(init=False)      # for `clearances` and `rim_distances`

    def __post_init__(self):
        object.__setattr__(self, "tracer", clearance_tracer(self.lens, self.film_distance, self.wavelength))

    @cached_property
    def _to_stop(self) -> Program:
        """From the film to the stop: most film points never need it."""
        behind = slice(0, len(self.lens.surfaces) - self.lens.stop_index)
        return Program(surface_steps(self.lens, self.film_distance, self.wavelength, part=behind), np.float64)

    def clearances(self, film: np.ndarray, rear: np.ndarray) -> np.ndarray:
        """Clearances (n,) of rays; inf where a ray does not come through."""
        out = np.empty(len(film))
        clearances(*_columns(film), *_columns(rear), self.film_distance, out, self.tracer, 0.0)
        return out

    def find_light(self, film: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rear points (n, 2) of small clearance, and that clearance (n,), ≥ 1 where no light was found."""
        rear = self.paraxial_centres(film)
        level = self.clearances(film, rear)

        def improve(which: np.ndarray, found: np.ndarray, there: np.ndarray) -> np.ndarray:
            """Keep better rear points of the film points `which`; the indices of those still dark."""
            better = there < level[which]
            rear[which[better]], level[which[better]] = found[better], there[better]
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
                in_line = film[:, :2] / (1.0 + film[:, 2:] / self.film_distance)
                low, high = np.stack([rear_interval(self.lens, self.film_distance, in_line[left, axis], upright)
                                      for axis, upright in ((0, False), (1, True))], 2)
                half = 0.5 * (high - low)[:, :, None] * np.eye(2)
                improve(left, *self.scan(film[left], 0.5 * (low + high), half, 1.0))
        return rear, level

    def stop_centres(self, film: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rear points (n, 2) of the rays to the stop's centre, and the stop's images (n, 2, 2): mm per stop radius.

        Newton's method starts from `start` (n, 2). Where it fails or ends beyond a rim, it continues the ray of
        the axis in LEGS steps. Without such a ray, the result is the nearest point found.
        """
        at, off, image = self._newton(film, start)
        far = np.flatnonzero(~((off < CENTRED) & (self.clearances(film, at) < 1.0)))
        stepped = np.zeros((far.size, 2))
        for leg in range(1, LEGS + 1):
            stepped, stepped_off, stepped_image = self._newton(film[far] * (leg / LEGS), stepped)
        if far.size:
            better = (stepped_off < CENTRED) | (stepped_off < off[far])
            at[far[better]], image[far[better]] = stepped[better], stepped_image[better]
        return at, image

    def stop_centres_near(self, film: np.ndarray, start: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """`stop_centres` of film points (n, 3) beside those to which `start` (n, 2) belongs."""
        at, off, image = self._newton(film, start)
        lost = np.flatnonzero(~(off < CENTRED))
        if lost.size:
            at[lost], image[lost] = self.stop_centres(film[lost], start[lost])
        return at, image

    def scan(self, film: np.ndarray, centre: np.ndarray, window: np.ndarray,
                enough: float) -> tuple[np.ndarray, np.ndarray]:
        """Rear points (n, 2) of least clearance within centre ± window · (±1, ±1), and that clearance (n,).

        window: (n, 2, 2). Scans ever more finely about the best point, until its clearance is below `enough`.
        """
        at, level = centre.copy(), np.full(len(film), np.inf)
        scanned = np.flatnonzero(np.isfinite(window).all((1, 2)))
        if scanned.size:
            there = at[scanned]
            _scan(*_columns(film[scanned]), there, WINDOW * window[scanned], self.film_distance, enough, self.tracer)
            at[scanned], level[scanned] = there, self.clearances(film[scanned], there)
        return at, level

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
        """Rear points near the stop's centre, their distance from it (stop radii), and the stop's images.

        Newton's method from `start` (n, 2); a step that does not reduce the distance is cut to a quarter.
        """
        at, advance = start.copy(), np.zeros_like(start)
        off, image = np.full(len(film), np.inf), np.full((len(film), 2, 2), np.nan)
        left = np.arange(len(film))
        for _ in range(ITERATIONS):
            if not left.size:
                break
            trial = at[left] + advance[left]
            stop_point, slopes = self._on_stop(film[left], trial)
            far = np.hypot(*stop_point.T)
            better = far < off[left]
            at[left[better]], off[left[better]] = trial[better], far[better]
            image[left[better]] = slopes[better]
            advance[left] = np.where(better[:, None], -(slopes @ stop_point[:, :, None])[:, :, 0], 0.25 * advance[left])
            left = left[(off[left] >= CENTRED) & (off[left] < np.inf) & np.isfinite(advance[left]).all(1)]
        return at, off, image

    def _on_stop(self, film: np.ndarray, rear: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points (n, 2) on the stop, in its radii, and the derivatives (n, 2, 2) of the rear points by these."""
        radius, small = self.lens.stop.semi_diameter, STEP * self.lens.surfaces[-1].semi_diameter
        n = len(film)
        vectors = np.concatenate([rear, rear + [small, 0.0], rear + [0.0, small]]) - np.tile(film[:, :2], (3, 1))
        away = np.tile(self.film_distance + film[:, 2], 3)
        size = 1.0 / np.sqrt((vectors**2).sum(1) + away**2)
        start = np.tile(film[:, :2], (3, 1)) + vectors * (np.tile(film[:, 2], 3) / away)[:, None]       # at z = 0
        given = {X: start[:, 0], Y: start[:, 1], L: vectors[:, 0] * size, M: vectors[:, 1] * size, N: -away * size}
        on_stop = self._to_stop.run(given, [X, Y], 3 * n).T - self.lens.vertex(self.lens.stop_index)[:2]
        here, beside, above = (on_stop / radius).reshape(3, n, 2)
        with np.errstate(divide="ignore", invalid="ignore"):        # the point of a lost ray is not finite
            (a, c), (b, d) = ((beside - here) / small).T, ((above - here) / small).T
            inverse = np.array([[d, -b], [-c, a]]) / (a * d - b * c)
        return here, inverse.transpose(2, 0, 1)


def _columns(points: np.ndarray) -> tuple[np.ndarray, ...]:
    """Contiguous coordinates (n,) of points (n, 2) or (n, 3)."""
    return tuple(np.ascontiguousarray(column) for column in points.T)
