"""Rays of a camera and their derivatives per pixel, by the stages that pictures run.

A derivative holds fixed the point where a ray passes the pupil: for a camera that aims at exit-pupil regions the point
on the plane of the last vertex. At fixed U0, U1 that point would rotate with the film point, and no derivative would
exist near the axis. (Igehy 1999, Tracing ray differentials, for their use.)
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from lensbench.core.cameras.camera_stages import CameraStages
from lensbench.core.cameras.shutter import CameraError, Rays, checked_times
from lensbench.core.kernels.block import (
    A0, PIXEL_SIDE, PIXEL_SPREAD, SAMPLE, TIME, U0, U1, WEIGHT, B, L, M, N, Step, X, Y, Z, gather, rows, stage
)
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import unit_table
from lensbench.core.optics.glass import D_LINE

CELLS = 32              # cells across and down the film, each with its pixel spread

# Parameters of `pixel_spread`: cells per pixel across and down, PIXEL_SIDE of the first sample, PIXEL_SPREAD per cell
CELLS_ACROSS, CELLS_DOWN, FIRST_SIDE, SPREADS = range(4)


class Differentials(NamedTuple):
    """Derivatives of rays per pixel to the right, or per pixel down, at a fixed pupil point.

    Source: Igehy 1999, Tracing ray differentials.

    Args:
        origins: (n, 3) array. Derivatives of the origins (mm per pixel), world.
        directions: (n, 3) array. Derivatives of the unit directions (radians per pixel), world; perpendicular to the
            rays.
    """

    origins: np.ndarray
    directions: np.ndarray


_RAY = [X, Y, Z, L, M, N, WEIGHT]


def ray_slopes(camera: CameraStages, inputs: dict[int, np.ndarray], dtype: DTypeLike, wavelength: float,
               timed: bool) -> np.ndarray:
    """Derivatives (2, n, 6) of origins (mm) and directions of rays in the world, per pixel to the right and down.

    inputs: raster X, Y, U0, U1 and TIME, (n,) each; timed: TIME is a shutter sample.
    """
    # A row that opens later sees a camera that has moved: only differences include that
    rolling = camera.moves and camera.readout > 0.0
    slopes = None if rolling else _closed_form(camera, inputs, dtype, wavelength)
    return _by_differences(camera, inputs, dtype, wavelength, timed) if slopes is None else slopes


def _closed_form(camera: CameraStages, inputs: dict[int, np.ndarray], dtype: DTypeLike,
                 wavelength: float) -> np.ndarray | None:
    """`ray_slopes` of a camera with `film_slopes`, placed as it is at the time of each ray; else None."""
    if camera.film_slopes(np.zeros((0, 2)), np.zeros((0, 3))) is None:
        return None                             # known before any ray is computed
    n = len(inputs[X])
    film = Program([camera.film_step], dtype).run(inputs, [X, Y], n).T.astype(float)
    rays = Program([camera.film_step, *camera.camera_steps(wavelength)], dtype).run(inputs, _RAY, n).T.astype(float)
    slopes = camera.film_slopes(film, rays[:, 3:6])
    assert slopes is not None
    across, _, down, _ = camera.film_step.parameters
    slopes = slopes * np.array([-across, down])[:, None, None]
    if camera.has_port:
        assert camera.medium is not None
        slopes = _through_port(slopes, rays, camera.front, 1.0 / camera.medium.index)
    world_from_camera = camera.placement(inputs[TIME], np.stack([inputs[X], inputs[Y]], 1))[..., :3, :3]
    rotation = world_from_camera / np.cbrt(np.linalg.det(world_from_camera))[..., None, None]
    origin_slopes, direction_slopes = slopes[..., :3, None], slopes[..., 3:, None]
    return np.concatenate([(world_from_camera @ origin_slopes)[..., 0], (rotation @ direction_slopes)[..., 0]], -1)


def _through_port(slopes: np.ndarray, rays: np.ndarray, window: float, ratio: float) -> np.ndarray:
    """Derivatives (2, n, 6) of rays (n, 6 or more) behind a flat window at z (camera frame); ratio: 1 / index there."""
    do, dd, d = slopes[..., :3], slopes[..., 3:], rays[:, 3:6]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = ((window - rays[:, 2]) / d[:, 2])[..., None]
        dt = -(do[..., 2:] + t * dd[..., 2:]) / d[:, 2:]
        bent, dbent = ratio * d[:, :2], ratio * dd[..., :2]
        along = -np.sqrt(1.0 - (bent**2).sum(-1))
        dalong = -(bent * dbent).sum(-1) / along
    return np.concatenate([do + t * dd + dt * d, dbent, dalong[..., None]], -1)


def _by_differences(camera: CameraStages, inputs: dict[int, np.ndarray], dtype: DTypeLike, wavelength: float,
                    timed: bool) -> np.ndarray:
    """`ray_slopes` by differences of the camera's own stages.

    Central where the rays on both sides arrive, one-sided of the same order where one does, with smaller steps where
    neither does. NaN for a ray without neighbours.
    """
    n = len(inputs[X])
    steps = camera.steps(wavelength, timed)
    film = next(k for k, step in enumerate(steps) if step.kernel is camera.film_step.kernel) + 1
    aim_distance, posed = camera.aim_distance, not camera.film_pose.is_upright
    if aim_distance is None:
        whole = Program(steps, dtype)
    else:
        to_film, onward = Program(steps[:film], dtype), Program(steps[film + 1:], dtype)
        x, y, l, m, n_ = Program(steps[:film + 1], dtype).run(inputs, [X, Y, L, M, N], n).astype(float)
        rear = np.stack([x - l / n_ * aim_distance, y - m / n_ * aim_distance])

    def rays(h: float) -> tuple[np.ndarray, np.ndarray]:
        """Rays (2, 2, n, 6) of raster points shifted by h pixels right and left, down and up; and which arrive."""
        shifts = h * np.array([[[1.0, 0.0], [-1.0, 0.0]], [[0.0, 1.0], [0.0, -1.0]]])
        m = 4 * n
        shifted = {row: np.tile(values, 4) for row, values in inputs.items()}
        shifted[X], shifted[Y] = ((shifts[..., k, None] + inputs[row]).ravel() for k, row in enumerate((X, Y)))
        if aim_distance is None:
            out = whole.run(shifted, _RAY, m)
        else:
            x, y, time = to_film.run(shifted, [X, Y, TIME], m).astype(float)
            z = np.zeros(m)
            if posed:
                x, y, z = camera.film_pose.points(np.stack([x, y], 1)).T
            direction = np.stack([np.tile(rear[0], 4) - x, np.tile(rear[1], 4) - y, -aim_distance - z])
            l, m_, n_ = direction / np.sqrt((direction * direction).sum(0))
            if posed:
                x, y = x - z * l / n_, y - z * m_ / n_          # where the first camera step lets rays begin
            out = onward.run({X: x, Y: y, L: l, M: m_, N: n_, TIME: time, WEIGHT: np.ones(m)}, _RAY, m)
        arrive = (out[6] > 0.0) & np.isfinite(out[:6]).all(0)
        return out[:6].T.astype(float).reshape(2, 2, n, 6), arrive.reshape(2, 2, n)

    derivatives, todo, middle = np.full((2, n, 6), np.nan), np.ones((2, n), bool), None
    for h in _widths(camera, dtype):
        near, near_ok = rays(h)
        ok = todo & near_ok.all(1)
        derivatives[ok] = (near[:, 0][ok] - near[:, 1][ok]) / (2 * h)
        todo &= ~ok
        if not todo.any():
            break
        # One-sided differences
        middle = rays(0.0)[0][0] if middle is None else middle
        far, far_ok = rays(2 * h)
        for side, k in enumerate((1, -1)):
            ok = todo & near_ok[:, side] & far_ok[:, side]
            derivatives[ok] = (4 * near[:, side][ok] - far[:, side][ok] - 3 * middle[ok]) / (2 * k * h)
            todo &= ~ok
        if not todo.any():
            break
    return derivatives


def _widths(camera: CameraStages, dtype: DTypeLike) -> tuple[float, ...]:
    """Steps of the differences in pixels, smaller for blocked neighbours: errors are h² and rounding error / h."""
    wide = (1e-4 if np.dtype(dtype) == np.float64 else 1e-2) * max(camera.film.pixels_x, camera.film.pixels_y)
    return wide, wide / 16, wide / 256


def spread_step(camera: CameraStages, real: DTypeLike) -> Step:
    """Step between sampler and camera that gives every sample the size of its pixel in the scene; real: precision.

    It is the rms of the extents across and down of rays through the centre of the pupil, by CELLS × CELLS cells.
    """
    camera, film = camera.with_open_stop, camera.film
    nodes = (np.arange(CELLS) + 0.5) / CELLS
    x, y = (values.ravel() for values in np.meshgrid(nodes * film.pixels_x, nodes * film.pixels_y))
    middle = [np.full(x.size, number) for number in (*camera.stage_centre, 0.5)]
    inputs = {X: x, Y: y, U0: middle[0], U1: middle[1], TIME: middle[2]}
    rays = Program(camera.steps(), real).run(inputs, _RAY, x.size).astype(float)
    with np.errstate(invalid="ignore", over="ignore"):      # rays that do not arrive hold any numbers
        slopes = ray_slopes(camera, inputs, real, D_LINE, camera.moves)
        origin_slopes, direction_slopes = slopes[..., :3], slopes[..., 3:]
        directions = rays[3:6].T
        origin_slopes = origin_slopes - (origin_slopes * directions).sum(-1)[..., None] * directions    # across the ray
        spread, foot = (np.sqrt((value**2).sum(-1).mean(0)) for value in (direction_slopes, origin_slopes))
        foot = np.copysign(foot, (origin_slopes * direction_slopes).sum((0, 2)))
    passed = (rays[6] > 0.0) & np.isfinite(spread) & np.isfinite(foot)
    table = fill_gaps(np.where(passed, spread, math.nan).reshape(CELLS, CELLS))
    p = np.empty(SPREADS + CELLS * CELLS)
    p[CELLS_ACROSS], p[CELLS_DOWN] = CELLS / film.pixels_x, CELLS / film.pixels_y
    p[FIRST_SIDE] = foot[passed].mean() if passed.any() else 0.0
    p[SPREADS:] = table.ravel()
    return Step(pixel_spread, p)


def fill_gaps(table: np.ndarray) -> np.ndarray:
    """Copy of a table with NaNs replaced by the means of their neighbours, ring by ring; all zeros if all are NaN."""
    while np.isnan(table).any() and not np.isnan(table).all():
        wide = np.pad(table, 1, constant_values=math.nan)
        near = np.stack([wide[1:-1, :-2], wide[1:-1, 2:], wide[:-2, 1:-1], wide[2:, 1:-1]])
        known = ~np.isnan(near)
        mean = np.where(known, near, 0.0).sum(0) / np.maximum(known.sum(0), 1)
        table = np.where(np.isnan(table) & known.any(0), mean, table)
    return np.nan_to_num(table)


@stage
def pixel_spread(lanes, p, ints, key):
    """PIXEL_SIDE and PIXEL_SPREAD of the part of its pixel that a sample covers; p: see CELLS_ACROSS and following.

    Of n samples that share a pixel each covers the nth part, with sides shorter by √n. The stage shortens them by n^¾:
    the effect of the first samples on the final picture falls as 1 / n, faster than the noise.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, foot, spread, cell = row[X], row[Y], row[PIXEL_SIDE], row[PIXEL_SPREAD], row[A0]
    across, down, last = p[CELLS_ACROSS], p[CELLS_DOWN], real(CELLS - 1)
    # Share of the pixel that this sample covers
    root = math.sqrt(real(key[SAMPLE]) + real(1))
    scale = real(1) / (root * math.sqrt(root))
    begin = p[FIRST_SIDE] * scale
    # Look up the cell of the film
    for i in range(B):
        a, b = np.floor(x[i] * across), np.floor(y[i] * down)
        a, b = a if a < last else last, b if b < last else last
        cell[i] = b * real(CELLS) + a
    gather(spread, p[SPREADS:], cell)
    for i in range(B):
        foot[i] = begin
        spread[i] *= scale


class RayGeneration(CameraStages):
    """The part of `Camera` that turns raster points and pupil samples into rays of the world."""

    def generate_rays(self, raster_xy: ArrayLike, pupil_uv: ArrayLike, time: ArrayLike = 0.0,
                      dtype: DTypeLike = np.float64, wavelength: float = D_LINE) -> Rays:
        """Rays through raster points and pupil samples, by the same stages that the renderer runs.

        Args:
            raster_xy: (n, 2) array. Raster points (pixels), the origin at the top left and pixel centres at +0.5.
            pupil_uv: (n, 2) array. Pupil samples in [0, 1]², by which equal areas of the square have equal areas of the
                pupil. In every camera (0.5, 0.5) is the pupil's centre, and `unit_disk` maps them to the pupil: to a
                disk, or to the exit-pupil region of the film point.
            time: float or (n,) array. Shutter samples in [0, 1]: the part of the light that the shutter has let
                through, 0 as it begins to open and 1 as it has closed.
            dtype: type. Precision of the stages, float64 or float32.
            wavelength: Wavelength of the light (µm).
        Returns:
            Origins (mm) and unit directions in the world, weights, and times in seconds, which include the delay of
                each ray's row.
        Raises:
            CameraError: Arrays of other shapes, raster points that are not finite, or times outside [0, 1].
            ValueError: Pupil samples outside the unit square.
        """
        raster_xy, pupil_uv = np.atleast_2d(np.asarray(raster_xy, float)), unit_table(pupil_uv, dtype)
        if raster_xy.shape[1:] != (2,) or raster_xy.shape != pupil_uv.shape:
            raise CameraError(f"raster points {raster_xy.shape} and pupil points {pupil_uv.shape} must both be (n, 2)")
        if not np.isfinite(raster_xy).all():
            raise CameraError("raster points must be finite numbers")
        n = len(raster_xy)
        times = np.broadcast_to(checked_times(time), (n,))
        pupil_uv = self._stage_uv_of_raster(raster_xy, pupil_uv, dtype)
        inputs = {X: raster_xy[:, 0], Y: raster_xy[:, 1], U0: pupil_uv[:, 0], U1: pupil_uv[:, 1], TIME: times}
        out = Program(self.steps(wavelength, timed=True), dtype).run(inputs, [X, Y, Z, L, M, N, WEIGHT, TIME], n)
        return Rays(out[:3].T, out[3:6].T, out[6], self.shutter_open + out[7].astype(float))

    def _stage_uv_of_raster(self, raster_xy: np.ndarray, pupil_uv: np.ndarray, dtype: DTypeLike) -> np.ndarray:
        """`stage_uv` of raster points (n, 2), within the unit square for numbers of this type."""
        film = Program([self.film_step], np.float64).run({X: raster_xy[:, 0], Y: raster_xy[:, 1]}, [X, Y],
                                                         len(raster_xy)).T
        return unit_table(self.stage_uv(film, pupil_uv), dtype)

    def generate_ray_differentials(self, raster_xy: ArrayLike, pupil_uv: ArrayLike, time: ArrayLike = 0.0,
                                   dtype: DTypeLike = np.float64, wavelength: float = D_LINE
                                  ) -> tuple[Rays, Differentials, Differentials]:
        """Rays, and their derivatives per pixel to the right and per pixel down.

        The derivatives hold the pupil point fixed: the point of the unit disk, or of an exit-pupil region on the plane
        of the last vertex. They hold the shutter sample `time` fixed too, so with a rolling shutter they include the
        motion of the camera between rows. They have a closed form, or are differences of the camera's own stages with
        a relative error of 1e-7 in double precision.

        Args:
            raster_xy, pupil_uv, time, dtype, wavelength: As for `generate_rays`.
        Returns:
            rays: The rays of `generate_rays`; a blocked neighbour does not change their weights.
            dx, dy: Derivatives in the world per pixel to the right and down; NaN where the ray itself is blocked.
        Raises:
            CameraError, ValueError: As for `generate_rays`.
        """
        rays = self.generate_rays(raster_xy, pupil_uv, time, dtype, wavelength)
        raster = np.atleast_2d(np.asarray(raster_xy, float))
        uv = self._stage_uv_of_raster(raster, unit_table(pupil_uv, dtype), dtype)
        inputs = {X: raster[:, 0], Y: raster[:, 1], U0: uv[:, 0], U1: uv[:, 1],
                  TIME: np.broadcast_to(checked_times(time), (len(raster),))}
        slopes = ray_slopes(self, inputs, dtype, wavelength, timed=True)
        slopes = np.where(rays.weights[:, None] > 0.0, slopes, math.nan)
        dx, dy = (Differentials(slope[:, :3], slope[:, 3:]) for slope in slopes)
        return rays, dx, dy
