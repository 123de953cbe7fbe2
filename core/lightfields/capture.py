"""Recording a light field: every cell of the pupil has its own picture taken, by the stages that take pictures.

A view is sharper than a picture: its samples fill a part of each pixel alone. Focusing adds views whose pixels
lie aside from each other, which fills the pixels again; what was averaged twice could not be told apart any more.
"""

import math
import os
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import count
from typing import NamedTuple

import numpy as np

from lensbench.cameras.base import Camera
from lensbench.cameras.real_lens import LensCamera
from lensbench.imaging.film import Film
from lensbench.imaging.spectrum import WAVELENGTHS, channel_step, spectral_part
from lensbench.kernels.block import PIXEL, TIME, U0, U1, WEIGHT, B, L, M, N, Step, X, Y, Z, lane_buffer, rows, stage
from lensbench.kernels.concentric_map import concentric_disk
from lensbench.kernels.program import Program
from lensbench.kernels.sampling import sampling_steps
from lensbench.kernels.tile_order import strip_count
from lensbench.lightfields.light_field import (
    LightField,
    LightFieldError,
    light_field_bytes,
    middle_of,
    spread_offsets,
)
from lensbench.optics.block_trace import trace_steps
from lensbench.optics.glass import D_LINE
from lensbench.pupils.film_grid import SECTORS
from lensbench.pupils.film_grid_sampler import PupilGrid
from lensbench.pupils.radial_sampler import PupilTable
from lensbench.scenery.scene import Scene

TOP = 60000.0           # the greatest radiance that a half float is given
FILL = 0.5              # the side of the part of a pixel that a view's samples fill
SIDE = 33               # film radii at which a lens is asked how far its pupil reaches


def capture_light_field(camera: Camera, scene: Scene, views: tuple[int, int] = (9, 9), samples: int = 16,
                        seed: int = 0, dtype=np.float16, shadows: bool = True, threads: int | None = None,
                        progress: Callable[[float], bool] = lambda share: True, moments: int = 1) -> LightField:
    """Record the light field of a camera that focuses: a projective one with a lens, traced or ideal.

    views: across and down; samples: for each pixel of each view, and less where the pupil's edge runs through its
    cell: the pupil is sampled evenly. dtype: float16, or float32 for twice the memory.
    told: called with the share that is done; the capture is given up where it answers False. moments: equal parts of
    the exposure that are kept apart, beside their mean; each has its part of the samples.
    LightFieldError for numbers that cannot be, for a camera without an aperture, for moments where nothing moves, for
    more memory than there is, and for a capture that was cancelled.
    """
    across, down = checked_views(camera.film, views, samples, dtype, moments)
    if moments > 1 and not (camera.moves or scene.moves):
        raise LightFieldError(f"{moments} moments: nothing moves while the shutter is open, so that all are alike; "
                              "record one, or choose a longer time, a camera or a scene that moves")
    reach = pupil_reach(camera)
    h, w = camera.film.pixels_y, camera.film.pixels_x
    light = np.zeros((down, across, 3, h, w), dtype)
    coverage = np.zeros((down, across, h, w), dtype)
    apart = np.zeros((moments, *light.shape), dtype) if moments > 1 else None
    offsets = spread_offsets(across, down)
    recorder = Recorder(camera, scene, shadows, np.uint32(seed & 0xFFFFFFFF))
    done = count(1)
    cancelled: list[tuple[int, int]] = []

    def record(place: tuple[int, int]) -> None:
        j, i = place
        cell = _lit_cell(reach, (across, down), (i, j))
        number, first = math.ceil(samples * cell.share / moments), (j * across + i) * samples

        def aims(wavelength: float) -> list[Step]:
            return [camera.film_step, *cell_steps(camera, cell, wavelength)]

        for left in range(0, w if number else 0, recorder.width):
            if cancelled:
                return
            here, mean = slice(left, min(left + recorder.width, w)), np.zeros((4, h, recorder.width), np.float32)
            for moment in range(moments):
                strip = recorder.strip(left, aims, FILL, offsets[j, i], first + moment * number, number,
                                       (moment, moments)) * np.float32(cell.share)
                mean += strip / np.float32(moments)
                if apart is not None:
                    apart[moment, j, i, :, :, here] = np.minimum(strip[:3], TOP)[..., :w - left]
            light[j, i, :, :, here] = np.minimum(mean[:3], TOP)[..., :w - left]
            coverage[j, i, :, here] = mean[3][..., :w - left]
        if not progress(next(done) / (across * down)):
            cancelled.append(place)

    with ThreadPoolExecutor(threads or os.cpu_count() or 1) as pool:
        list(pool.map(record, [(j, i) for j in range(down) for i in range(across)]))
    if cancelled:
        raise LightFieldError("the capture was cancelled")
    return LightField(camera, reach, light, coverage, FILL, moments=apart)


def picture_through(camera: Camera, scene: Scene, place: tuple[float, float], radius: float, samples: int = 16,
                    seed: int = 0, moment: tuple[int, int] = (0, 1),
                    progress: Callable[[float], bool] = lambda share: True) -> np.ndarray:
    """What a camera sees through a round part of its pupil alone, (h, w, 3): what focusing a light field comes near to.

    place and radius of the part in radii of the paraxial exit pupil; moment: which of how many parts of the exposure.
    LightFieldError as of `capture_light_field`.
    """
    checked_views(camera.film, (1, 1), samples, np.float32)
    pupil_reach(camera)
    w, h = camera.film.pixels_x, camera.film.pixels_y
    recorder = Recorder(camera, scene, True, np.uint32(seed & 0xFFFFFFFF))
    part = Cell((place[0] - radius, place[1] - radius), (2.0 * radius, 2.0 * radius), 1.0)
    planes = np.zeros((4, h, w), np.float32)
    done, cancelled = count(1), threading.Event()

    def aims(wavelength: float) -> list[Step]:
        return [camera.film_step, Step(within_disk, []), *cell_steps(camera, part, wavelength)]

    def expose(left: int) -> None:
        if not cancelled.is_set():
            strip = recorder.strip(left, aims, 1.0, (0.0, 0.0), 0, samples, moment)
            planes[:, :, left:left + recorder.width] = strip[..., :w - left]
        if not progress(min(next(done) * recorder.width / w, 1.0)):
            cancelled.set()

    with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        list(pool.map(expose, range(0, w, recorder.width)))
    if cancelled.is_set():
        raise LightFieldError("the picture was cancelled")
    return np.ascontiguousarray(planes[:3].transpose(1, 2, 0) / max(float(middle_of(planes[3])), 1e-30))


def free_memory() -> float:
    """Bytes that are free on this machine; infinite where it does not say."""
    try:
        return float(os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):
        return math.inf


def checked_views(film: Film, views: tuple[int, int], samples: int, dtype, moments: int = 1) -> tuple[int, int]:
    """Views across and down; LightFieldError for what cannot be recorded."""
    across, down = (int(number) for number in views)
    if across < 1 or down < 1 or (across, down) != tuple(views):
        raise LightFieldError(f"{views[0]} × {views[1]} views: both must be whole numbers of at least 1")
    if samples < 1:
        raise LightFieldError(f"{samples} samples a pixel: at least 1 is needed")
    if moments < 1 or int(moments) != moments:
        raise LightFieldError(f"{moments} moments: a whole number of at least 1 is needed")
    if np.dtype(dtype) not in (np.float16, np.float32):
        raise LightFieldError("a light field is recorded in float16 or float32")
    size, free = light_field_bytes(film, (across, down), dtype, moments), free_memory()
    if size > 0.9 * free:
        raise LightFieldError(f"{across} × {down} views of {film.pixels_x} × {film.pixels_y} pixels take "
                              f"{size / 1e9:,.1f} GB, more than the {free / 1e9:,.1f} GB that are free: record "
                              f"fewer views{' or moments' if moments > 1 else ''} or pixels")
    return across, down


def pupil_reach(camera: Camera) -> float:
    """How far in radii of the paraxial exit pupil light comes from, for any point of the film."""
    lens = camera.gaussian
    if lens.is_hole:
        raise LightFieldError("a pinhole sees from one place alone: record a light field through a lens")
    if not (isinstance(camera, LensCamera) and camera.follows_rays):
        if not lens.iris.is_round and lens.origin_film != 0.0:
            raise LightFieldError("without a pupil that all film points share, the ideal models record a light field "
                                  "through a round stop alone: choose the full trace, or no blades")
        return 1.0
    table = camera.pupil
    film, slopes = _rims(table, camera.film.diagonal / 2.0) if isinstance(table, PupilTable) else _between(table)
    return float(np.hypot(*(slopes - lens.approach_film * film)).max() / abs(lens.approach_pupil))


def _rims(table: PupilTable, farthest: float) -> tuple[np.ndarray, np.ndarray]:
    """Of a symmetric lens film points (2, n, 1) along a radius, and the slopes (2, n, m) from them to its rim."""
    radii = farthest * np.linspace(0.0, 1.0, SIDE)
    radii = radii[radii <= table.radius]
    ring, inner = table.ring(radii)
    rim = table.outline[ring + np.rint(inner).astype(int)]
    film = np.stack([radii, np.zeros_like(radii)])[..., None]
    to = np.stack([rim[..., 0] + (table.centre(radii) - radii)[:, None], rim[..., 1]])
    return film, to / table.film_distance


def _between(grid: PupilGrid) -> tuple[np.ndarray, np.ndarray]:
    """As `_rims`, (2, n) each: of a lens with two planes of symmetry all over a quadrant of its film."""
    x, y, turn = (axis.ravel() for axis in np.meshgrid(
        np.linspace(0.0, grid.half_width, SIDE), np.linspace(0.0, grid.half_height, SIDE),
        (np.arange(4 * SECTORS) + 0.5) / (4 * SECTORS)))
    l, m, n, weight = Program([grid.step(1.0)], np.float64).run(
        {X: x, Y: y, U0: turn, U1: np.full_like(turn, 1.0)}, [L, M, N, WEIGHT], len(turn))
    lit = weight > 0.0
    return np.stack([x, y])[:, lit], np.stack([l, m])[:, lit] / -n[lit]


class Cell(NamedTuple):
    """Of a cell of the pupil the box that light can come through: a corner and the sides, in the pupil's radii."""

    corner: tuple[float, float]
    sides: tuple[float, float]
    share: float                    # of the whole cell's area


def _lit_cell(reach: float, views: tuple[int, int], place: tuple[int, int]) -> Cell:
    """What of the cell at this place (across, down) lies within the circle of radius `reach`, as a box."""
    sides = [2.0 * reach / number for number in views]
    low = [-reach + k * side for k, side in zip(place, sides, strict=True)]
    high = [a + side for a, side in zip(low, sides, strict=True)]
    nearest = [max(a, -b, 0.0) for a, b in zip(low, high, strict=True)]
    for axis in (0, 1):
        half = math.sqrt(max(reach**2 - nearest[1 - axis] ** 2, 0.0))
        low[axis], high[axis] = max(low[axis], -half), min(high[axis], half)
    width, height = (max(b - a, 0.0) for a, b in zip(low, high, strict=True))
    return Cell((low[0], low[1]), (width, height), width * height / (sides[0] * sides[1]))


@dataclass(frozen=True)
class Recorder:
    """Takes pictures strip by strip, and what part of the light comes to them."""

    camera: Camera
    scene: Scene
    shadows: bool
    seed: np.uint32

    @property
    def width(self) -> int:
        """Of a strip, in pixels: all alike, and none wider than those of which a film is made."""
        w = self.camera.film.pixels_x
        return -(-w // strip_count(w))

    def strip(self, left: int, aims: Callable[[float], list[Step]], fill: float, aside, first: int,
              number: int, moment: tuple[int, int] = (0, 1)) -> np.ndarray:
        """(4, h, width) float32: the mean light, and last the mean weight, of samples first … of a number.

        left: where the strip begins; aims: the steps from raster X, Y and U0, U1 to the ray, for a wavelength (µm);
        fill: the part of a pixel's side that is sampled, aside: by what part it lies aside (2). moment: which of how
        many parts of the exposure.
        """
        h = self.camera.film.pixels_y
        blocks = -(-self.width * h // B)
        lanes, sums = lane_buffer(), np.zeros((blocks, 3 * B), np.float32)
        seed = np.uint32((int(self.seed) + left) % 2**32)
        covered = np.zeros(blocks * B, np.float32)
        programs: dict[int | None, list[tuple[Program, np.ndarray]]] = {}
        before = [Step(placed, [fill, left + aside[0], aside[1]])]
        if moment[1] > 1:
            before.append(Step(during, [1.0 / moment[1], moment[0] / moment[1]]))
        for sample, many, place in self._samples(first, number):
            if place not in programs:
                programs[place] = self._programs(place, before, aims, blocks)
            for program, _ in programs[place]:
                program.expose(sums, lanes, 0, blocks, sample, many, seed)
        for made in programs.values():
            for _, weights in made:
                covered += weights / np.float32(len(made))
        planes = np.concatenate([sums.reshape(blocks, 3, B).transpose(1, 0, 2).reshape(3, -1), covered[None]])
        planes *= np.float32(1.0 / number)
        return planes[:, :self.width * h].reshape(4, h, self.width)

    def _samples(self, first: int, number: int) -> list[tuple[int, int, int | None]]:
        """Which samples, how many, and the part of the spectrum that they take; None: the d line."""
        if not self.camera.disperses:
            return [(first, number, None)]
        return [(sample, 1, spectral_part(sample, self.seed)) for sample in range(first, first + number)]

    def _programs(self, place: int | None, before: list[Step], aims: Callable[[float], list[Step]], blocks: int):
        """For a part of the spectrum, or the d line: the programs, with the sums of their weights, (blocks · B,)."""
        camera, scene = self.camera, self.scene
        timed = camera.moves or scene.moves
        clock = [camera.clock] if timed else []
        after = scene.steps(self.shadows, camera.shutter_open, medium=camera.medium)
        lines = [(D_LINE, [])] if place is None else [(row[place], [channel_step(name)])
                                                      for name, row in WAVELENGTHS.items()]
        made = []
        for wavelength, ending in lines:
            aim = [*sampling_steps(self.width, camera.film.pixels_y, lit=self.shadows, timed=timed), *before, *clock,
                   *aims(wavelength), *camera.port]
            program = Program([*aim, Step(covering, np.zeros(blocks * B)), *camera.carried, *after, *ending])
            made.append((program, program.data[program.ends[len(aim)]:program.ends[len(aim) + 1]]))
        return made


def cell_steps(camera: Camera, cell: Cell, wavelength: float) -> list[Step]:
    """From the film point X, Y and U0, U1 of a box of the pupil to the ray; WEIGHT: cos⁴θ where light comes."""
    lens, box = camera.gaussian, [*cell.corner, *cell.sides]
    if isinstance(camera, LensCamera) and camera.follows_rays:
        aims = Step(aimed, [*box, lens.approach_film, lens.approach_pupil])
        return [aims, *trace_steps(camera.lens, camera.film_distance, wavelength)]
    return [Step(through_cell, [*box, *lens[:-1]]), *lens.iris.blocking(lens.origin_pupil)]


@stage
def placed(lanes, p, key):
    """Samples X, Y of pixels drawn together about the pixels' middles, and set aside. p: by how much; aside (2)."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y = row[X], row[Y]
    fill, across, down = p[0], p[1], p[2]
    for i in range(B):
        a, b = np.floor(x[i]) + real(0.5), np.floor(y[i]) + real(0.5)
        x[i], y[i] = a + (x[i] - a) * fill + across, b + (y[i] - b) * fill + down


@stage
def within_disk(lanes, p, key):
    """U0, U1 of the unit square to those of the disk that just fits into it, evenly."""
    real = lanes.dtype.type
    row = rows(lanes)
    u, v = row[U0], row[U1]
    for i in range(B):
        a, b = concentric_disk(real, u[i], v[i])
        u[i], v[i] = real(0.5) + real(0.5) * a, real(0.5) + real(0.5) * b


@stage
def during(lanes, p, key):
    """TIME within a part of the exposure. p: how long that is, and where it begins, of [0, 1)."""
    row = rows(lanes)
    time = row[TIME]
    share, begin = p[0], p[1]
    for i in range(B):
        time[i] = begin + share * time[i]


@stage
def aimed(lanes, p, key):
    """From the film point X, Y (Z = 0) to U0, U1 of a box of the exit pupil. p: corner, sides, slopes by both."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight, u, v = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT], row[U0], row[U1]
    left, low, width, height, film, pupil = p[0], p[1], p[2], p[3], p[4], p[5]
    for i in range(B):
        dx, dy = x[i] * film + (left + u[i] * width) * pupil, y[i] * film + (low + v[i] * height) * pupil
        c2 = real(1) / (dx * dx + dy * dy + real(1))
        size = math.sqrt(c2)
        l[i], m[i], n[i] = dx * size, dy * size, -size
        z[i] = real(0)
        weight[i] = c2 * c2


@stage
def through_cell(lanes, p, key):
    """As the stage of `Gaussian`, by U0, U1 of a box of its pupil's disk. p: corner, sides, its numbers."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y, z, l, m, n, weight, u, v = row[X], row[Y], row[Z], row[L], row[M], row[N], row[WEIGHT], row[U0], row[U1]
    left, low, width, height = p[0], p[1], p[2], p[3]
    place, origin, origin_p, slope, slope_p, aim, aim_p = p[4], p[5], p[6], p[7], p[8], p[9], p[10]
    for i in range(B):
        a, b = left + u[i] * width, low + v[i] * height
        dx, dy = x[i] * slope + a * slope_p, y[i] * slope + b * slope_p
        size = real(1) / math.sqrt(dx * dx + dy * dy + real(1))
        l[i], m[i], n[i] = dx * size, dy * size, -size
        ex, ey = x[i] * aim + a * aim_p, y[i] * aim + b * aim_p
        c2 = real(1) / (ex * ex + ey * ey + real(1))
        weight[i] = c2 * c2 if a * a + b * b <= real(1) else real(0)
        x[i], y[i], z[i] = x[i] * origin + a * origin_p, y[i] * origin + b * origin_p, place


@stage
def covering(lanes, p, key):
    """Sum up the WEIGHT of every pixel. p: the sums of all blocks, to which it adds."""
    real = lanes.dtype.type
    row = rows(lanes)
    weight, sums = row[WEIGHT], p[key[PIXEL]:]
    for i in range(B):
        sums[i] += weight[i] if weight[i] > real(0) else real(0)
