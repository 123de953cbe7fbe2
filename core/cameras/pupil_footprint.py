"""Which part of the pupil a sample stands for: a rough mirror shows lights out of focus on average over it.

The rays from a film point through all of the pupil nearly meet in one point, the focus; that, the
middle of the pupil and its size, for every part of the film, are found from the camera's own rays. A sample stands
for a disk. So that all disks together are the pupil, and no larger, they lie nearer to its middle than
their samples do: the spread of the middles and that of a disk add up to the spread of the pupil.
"""

import math

import numpy as np

from lensbench.cameras.base import Camera
from lensbench.cameras.differentials import fill_gaps
from lensbench.imaging.animated_transform import AnimatedTransform
from lensbench.kernels.block import (
    A0,
    OX,
    OY,
    OZ,
    PUPIL_RADIUS,
    PUPIL_SPREAD,
    SAMPLE,
    TIME,
    U0,
    U1,
    WEIGHT,
    B,
    L,
    M,
    N,
    Step,
    X,
    Y,
    Z,
    gather,
    rows,
    stage,
)
from lensbench.kernels.program import Program

CELLS = 16              # of the film, each way, for which the pupil is known
PLACES = 16             # of the pupil, by which it is known
FEWEST = 8              # of those that must be open, or a part of the film is told by its neighbours
STEADY = 0.2            # radii of the pupil: by how much its middle may change, at the most, from cell to cell
FULL_PUPIL_SAMPLES = 4               # first samples, of which each stands for all of the pupil
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def footprint_steps(camera: Camera, real) -> tuple[list[Step], list[Step]]:
    """The steps between the sampler and the camera, and after the camera, that tell every sample its part of the pupil.

    None where every film point has a single ray, where the camera moves, or where the pupil is not the same one for
    neighbouring parts of the film. `real`: the precision in which the camera's stages are compiled.
    """
    place = camera.world_from_camera
    if isinstance(place, AnimatedTransform):
        return [], []
    film, n = camera.film, CELLS * CELLS
    nodes = (np.arange(CELLS) + 0.5) / CELLS
    k = np.arange(PLACES)
    x, y = (np.repeat(values.ravel(), PLACES) for values in np.meshgrid(nodes * film.pixels_x, nodes * film.pixels_y))
    given = {X: x, Y: y, U0: np.tile((k + 0.5) / PLACES, n), U1: np.tile((k * GOLDEN + 0.5) % 1.0, n),
             TIME: np.full(n * PLACES, 0.5)}
    rays = Program([camera.film_step, *camera.aimed()], real).run(given, [X, Y, Z, L, M, N, WEIGHT], n * PLACES)
    rays = rays.astype(float).reshape(7, n, PLACES)
    seen = rays[6] > 0.0
    known = seen.sum(1) >= FEWEST
    if not known.any():
        return [], []
    seen[~known] = False

    def mean(values: np.ndarray) -> np.ndarray:
        with np.errstate(invalid="ignore"):
            return np.where(seen, values, 0.0).sum(-1) / seen.sum(1)

    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = rays[3:5] / rays[5]
        plane = float(rays[2][seen].mean())
        points = rays[:2] + slopes * (plane - rays[2])
        # where rays through the middle cross: the pupil
        middles, ways = mean(points)[:, known], mean(slopes)[:, known]
        ways = ways - ways.mean(1)[:, None]
        shift = -float((middles * ways).sum() / max((ways**2).sum(), 1e-30))
        plane, points = plane + shift, points + slopes * shift
        middles = mean(points)
        off, turned = points - middles[..., None], slopes - mean(slopes)[..., None]
        spread = mean((off**2).sum(0)) / 2.0
        focus = -spread[known].sum() / (mean((off * turned).sum(0))[known].sum() / 2.0)
    if not spread[known].min() > 0.0:
        return [], []
    radius, *middle = (fill_gaps(np.where(known, values, math.nan).reshape(CELLS, CELLS))
                       for values in (2.0 * np.sqrt(spread), *middles))
    if max(np.abs(np.diff(table, axis=axis)).max() for table in middle for axis in (0, 1)) > STEADY * radius.min():
        return [], []
    tables = np.concatenate([[CELLS / film.pixels_x, CELLS / film.pixels_y], radius.ravel(), *map(np.ravel, middle)])
    axes = place[:3, :3]
    numbers = [*axes.T.ravel(), *(axes[:, 2] * plane + place[:3, 3]), focus]
    return [Step(pupil_size, tables)], [Step(pupil_part, numbers)]


@stage
def pupil_size(lanes, p, key):
    """PUPIL_RADIUS: that of the pupil; OX, OY: its middle, on its plane. p: cells a pixel (2), three of every cell."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, disk, ox, oy, cell = row[X], row[Y], row[PUPIL_RADIUS], row[OX], row[OY], row[A0]
    across, down, last = p[0], p[1], real(CELLS - 1)
    for i in range(B):
        a, b = np.floor(x[i] * across), np.floor(y[i] * down)
        a, b = a if a < last else last, b if b < last else last
        cell[i] = b * real(CELLS) + a
    gather(disk, p[2:], cell)
    gather(ox, p[2 + CELLS * CELLS:], cell)
    gather(oy, p[2 + 2 * CELLS * CELLS:], cell)


@stage
def pupil_part(lanes, p, key):
    """PUPIL_RADIUS, PUPIL_SPREAD, OX, OY, OZ of the ray, from what `pupil_size` left.

    p: the camera's axes in the world (9), the origin of the pupil's plane (3), z from there to the focus.
    The nth of a pixel's samples stands for less than the nth part of the pupil, with the radius (WHOLE / n)^¾: what it
    blurs of the last picture falls faster than its noise.
    """
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n = row[X], row[Y], row[Z], row[L], row[M], row[N]
    disk, fan, ox, oy, oz = row[PUPIL_RADIUS], row[PUPIL_SPREAD], row[OX], row[OY], row[OZ]
    rx, ry, rz, ux, uy, uz, bx, by, bz = p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7], p[8]
    cx, cy, cz = p[9], p[10], p[11]
    late = real(FULL_PUPIL_SAMPLES) / (real(key[SAMPLE]) + real(1))
    part = math.sqrt(late * math.sqrt(late)) if late < real(1) else real(1)
    share = part / (real(1) + math.sqrt(real(1) - part * part))
    nearer = -part / p[12]
    for i in range(B):
        a, b, c = x[i] - cx, y[i] - cy, z[i] - cz
        along = l[i] * bx + m[i] * by + n[i] * bz
        t = -(a * bx + b * by + c * bz) / along
        a, b, c = a + t * l[i], b + t * m[i], c + t * n[i]
        per = share / disk[i]
        u, v = (a * rx + b * ry + c * rz - ox[i]) * per, (a * ux + b * uy + c * uz - oy[i]) * per
        ox[i], oy[i], oz[i] = u * rx + v * ux, u * ry + v * uy, u * rz + v * uz
        fan[i] = disk[i] * along * nearer
        disk[i] = disk[i] * part - t * fan[i]
