"""Pupil footprint: the part of the pupil that a sample covers, over which rough mirrors average lights out of focus.

The camera's own rays give the focus, where the rays from a film point through all of the pupil nearly meet, and the
centre and radius of the pupil for every cell of the film. Each sample covers a disk of the pupil, drawn towards the
pupil's centre, so that the variance of the disks' centres and that of one disk add up to the variance of the pupil.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import DTypeLike

from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.ray_generation import fill_gaps
from lensbench.core.imaging.transform import AnimatedTransform
from lensbench.core.kernels.block import (
    A0, OX, OY, OZ, PUPIL_RADIUS, PUPIL_SPREAD, SAMPLE, TIME, U0, U1, WEIGHT, B, L, M, N, Step, X, Y, Z, gather, rows,
    stage
)
from lensbench.core.kernels.program import Program

CELLS = 16              # cells across and down the film, each with its pupil
PUPIL_SAMPLES = 16      # rays through the pupil for each cell
FEWEST = 8              # rays of a cell that must pass; otherwise its neighbours define its pupil
STEADY = 0.2            # largest shift of the pupil's centre between neighbouring cells, in pupil radii
FARTHEST = 1000.0       # distances to the focus, of the pupil's plane: farther, single precision loses the pupil's size
FULL_PUPIL_SAMPLES = 4  # first samples of a pixel, each of which covers the whole pupil
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0

# Parameters of `pupil_size`: cells per pixel across and down, then three tables of all cells
CELLS_ACROSS, CELLS_DOWN, RADII = range(3)
CENTRES_X, CENTRES_Y, SIZES_END = (RADII + table * CELLS * CELLS for table in (1, 2, 3))
# Parameters of `pupil_part`: the camera's axes in the world, right, up and back; the origin of the pupil's plane in the
# world (mm); the distance (mm) along the back axis from that plane to the focus
RIGHT, UP, BACK, PLANE, FOCUS, PART_END = 0, 3, 6, 9, 12, 13


class _Pupil(NamedTuple):
    """Pupil as the camera's rays show it, in mm, camera frame."""

    plane: float                # z
    focus: float                # z from the plane to the focus
    radius: np.ndarray          # (CELLS, CELLS)
    centre_x: np.ndarray        # (CELLS, CELLS)
    centre_y: np.ndarray        # (CELLS, CELLS)


def footprint_steps(camera: Camera, real: DTypeLike) -> tuple[list[Step], list[Step]]:
    """Steps before and after those of the camera that give each sample its part of the pupil; real: the stages'
    precision.

    Empty where every film point has a single ray, the camera moves, or the pupil differs between neighbouring cells.
    """
    world_from_camera = camera.world_from_camera
    if isinstance(world_from_camera, AnimatedTransform) or camera.moves:
        return [], []
    pupil = _measured_pupil(camera, real)
    if pupil is None:
        return [], []
    sizes, numbers = np.empty(SIZES_END), np.empty(PART_END)
    sizes[CELLS_ACROSS], sizes[CELLS_DOWN] = CELLS / camera.film.pixels_x, CELLS / camera.film.pixels_y
    sizes[RADII:CENTRES_X] = pupil.radius.ravel()
    sizes[CENTRES_X:CENTRES_Y], sizes[CENTRES_Y:] = pupil.centre_x.ravel(), pupil.centre_y.ravel()
    axes = world_from_camera[:3, :3]
    numbers[RIGHT:PLANE] = axes.T.ravel()
    numbers[PLANE:FOCUS] = axes[:, 2] * pupil.plane + world_from_camera[:3, 3]
    numbers[FOCUS] = pupil.focus
    return [Step(pupil_size, sizes)], [Step(pupil_part, numbers)]


def _measured_pupil(camera: Camera, real: DTypeLike) -> _Pupil | None:
    """Pupil and focus from PUPIL_SAMPLES rays of every cell; None where they define no common pupil."""
    # Rays of all cells
    film, n = camera.film, CELLS * CELLS
    nodes = (np.arange(CELLS) + 0.5) / CELLS
    k = np.arange(PUPIL_SAMPLES)
    x, y = (np.repeat(values.ravel(), PUPIL_SAMPLES)
            for values in np.meshgrid(nodes * film.pixels_x, nodes * film.pixels_y))
    inputs = {X: x, Y: y, U0: np.tile((k + 0.5) / PUPIL_SAMPLES, n), U1: np.tile((k * GOLDEN + 0.5) % 1.0, n),
              TIME: np.full(n * PUPIL_SAMPLES, 0.5)}
    rays = Program([camera.film_step, *camera.aimed()], real).run(inputs, [X, Y, Z, L, M, N, WEIGHT],
                                                                  n * PUPIL_SAMPLES)
    rays = rays.astype(float).reshape(7, n, PUPIL_SAMPLES)
    passed = rays[6] > 0.0
    known = passed.sum(1) >= FEWEST
    if not known.any():
        return None
    passed[~known] = False

    def mean(values: np.ndarray) -> np.ndarray:
        """Mean over the rays of each cell that pass."""
        with np.errstate(invalid="ignore"):
            return np.where(passed, values, 0.0).sum(-1) / passed.sum(1)

    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = rays[3:5] / rays[5]
        plane = float(rays[2][passed].mean())
        points = rays[:2] + slopes * (plane - rays[2])
        slope_offsets = slopes - mean(slopes)[..., None]

        def meeting(points: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
            """Middles and variances of the cells' points on a plane, and how far from it the rays of a cell meet."""
            centres = mean(points)
            offsets = points - centres[..., None]
            spread = mean((offsets**2).sum(0)) / 2.0
            return centres, spread, -float(spread[known].sum() / (
                mean((offsets * slope_offsets).sum(0))[known].sum() / 2.0))

        # The pupil's plane: where the mean rays of the cells cross, at infinity for parallel ones
        centres, _, focus = meeting(points)
        mean_slopes = mean(slopes)[:, known]
        mean_slopes = mean_slopes - mean_slopes.mean(1)[:, None]
        shift = -(centres[:, known] * mean_slopes).sum() / (mean_slopes**2).sum()
        shift = float(np.clip(shift if np.isfinite(shift) else math.inf, -FARTHEST * abs(focus), FARTHEST * abs(focus)))
        plane, points = plane + shift, points + slopes * shift
        # The focus: where the rays of a cell meet
        centres, spread, focus = meeting(points)
    if not spread[known].min() > 0.0:
        return None
    radius, *centre = (fill_gaps(np.where(known, values, math.nan).reshape(CELLS, CELLS))
                       for values in (2.0 * np.sqrt(spread), *centres))
    if max(np.abs(np.diff(table, axis=axis)).max() for table in centre for axis in (0, 1)) > STEADY * radius.min():
        return None
    return _Pupil(plane, focus, radius, *centre)


@stage
def pupil_size(lanes, p, ints, key):
    """PUPIL_RADIUS, and the pupil's centre OX, OY on its plane (mm), of the film's cell. p: CELLS_ACROSS and so on."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, radius, ox, oy, cell = row[X], row[Y], row[PUPIL_RADIUS], row[OX], row[OY], row[A0]
    across, down, last = p[CELLS_ACROSS], p[CELLS_DOWN], real(CELLS - 1)
    for i in range(B):
        a, b = np.floor(x[i] * across), np.floor(y[i] * down)
        a, b = a if a < last else last, b if b < last else last
        cell[i] = b * real(CELLS) + a
    gather(radius, p[RADII:], cell)
    gather(ox, p[CENTRES_X:], cell)
    gather(oy, p[CENTRES_Y:], cell)


@stage
def pupil_part(lanes, p, ints, key):
    """PUPIL_RADIUS, PUPIL_SPREAD, OX, OY, OZ of the ray, from the rows that `pupil_size` wrote. p: RIGHT and following.

    The nth sample of a pixel covers a part of the radius (FULL_PUPIL_SAMPLES / n)^¾, less than the nth part of the
    pupil, so that the blur that it adds to the final picture falls faster than the noise.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n = row[X], row[Y], row[Z], row[L], row[M], row[N]
    radius, spread, ox, oy, oz = row[PUPIL_RADIUS], row[PUPIL_SPREAD], row[OX], row[OY], row[OZ]
    rx, ry, rz = p[RIGHT], p[RIGHT + 1], p[RIGHT + 2]
    ux, uy, uz = p[UP], p[UP + 1], p[UP + 2]
    bx, by, bz = p[BACK], p[BACK + 1], p[BACK + 2]
    cx, cy, cz = p[PLANE], p[PLANE + 1], p[PLANE + 2]
    # Radius of the part, and how far its centre is drawn towards that of the pupil
    late = real(FULL_PUPIL_SAMPLES) / (real(key[SAMPLE]) + real(1))
    scale = math.sqrt(late * math.sqrt(late)) if late < real(1) else real(1)
    share = scale / (real(1) + math.sqrt(real(1) - scale * scale))
    nearer = -scale / p[FOCUS]
    for i in range(B):
        # Cross the pupil's plane
        a, b, c = x[i] - cx, y[i] - cy, z[i] - cz
        along = l[i] * bx + m[i] * by + n[i] * bz
        t = -(a * bx + b * by + c * bz) / along
        a, b, c = a + t * l[i], b + t * m[i], c + t * n[i]
        # Offset from the centre of the part, in its radii, in the world
        per = share / radius[i]
        u, v = (a * rx + b * ry + c * rz - ox[i]) * per, (a * ux + b * uy + c * uz - oy[i]) * per
        ox[i], oy[i], oz[i] = u * rx + v * ux, u * ry + v * uy, u * rz + v * uz
        # Radius at the origin of the ray, and its change along the ray
        spread[i] = radius[i] * along * nearer
        radius[i] = radius[i] * scale - t * spread[i]
