"""Recorder: pictures taken strip by strip, together with their coverage, the share of light that arrives."""

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import count
from typing import NamedTuple, TypeVar

import numpy as np

from lensbench.cameras.base import Camera
from lensbench.imaging.spectrum import WAVELENGTHS, channel_step, spectral_part
from lensbench.kernels.block import PIXEL, TIME, WEIGHT, B, Step, X, Y, lane_buffer, rows, stage
from lensbench.kernels.program import Program
from lensbench.kernels.sampling import sampling_steps
from lensbench.kernels.tile_order import strip_count
from lensbench.lightfields.light_field import LightFieldError
from lensbench.optics.glass import D_LINE
from lensbench.scenery.scene import Scene

Item = TypeVar("Item")

# Parameters of `place_samples`: side of the sampled part of a pixel, offset to the right and down; pixels
FILL, OFFSET_X, OFFSET_Y = range(3)
# Parameters of `sample_moment`: length and start, in [0, 1) of the exposure
LENGTH, START = range(2)


class _Counted(NamedTuple):
    """A program and the sums (blocks · B,) of its weights, which its stage `sum_weights` writes."""

    program: Program
    weights: np.ndarray


@dataclass(frozen=True)
class Recorder:
    """Takes pictures strip by strip. camera: its model resolved; seed: sampler seed."""

    camera: Camera
    scene: Scene
    shadows: bool
    seed: np.uint32

    @property
    def width(self) -> int:
        """Pixels of a strip: the same for all, and none wider than the strips of a film."""
        w = self.camera.film.pixels_x
        return -(-w // strip_count(w))

    def strip(self, left: int, aim: Callable[[float], list[Step]], fill: float, offset, first: int,
              number: int, moment: tuple[int, int] = (0, 1)) -> np.ndarray:
        """Mean light and mean weight of a strip: float32 (4, h, width), the weight last.

        left: raster x of its left edge; aim: the stages from raster X, Y and U0, U1 to the ray, for a wavelength (µm);
        fill: side of the sampled part of each pixel, in pixels; offset: its place (2,) from the pixel's middle, right
        and down; first, number: the samples; moment: index and number of the equal parts of the exposure.
        """
        h = self.camera.film.pixels_y
        blocks = -(-self.width * h // B)
        lanes, sums = lane_buffer(), np.zeros((blocks, 3 * B), np.float32)
        seed = np.uint32((int(self.seed) + left) % 2**32)
        covered = np.zeros(blocks * B, np.float32)
        counted: dict[int | None, list[_Counted]] = {}
        before = [Step(place_samples, [fill, left + offset[0], offset[1]])]
        if moment[1] > 1:
            before.append(Step(sample_moment, [1.0 / moment[1], moment[0] / moment[1]]))
        for sample, many, place in self._samples(first, number):
            if place not in counted:
                counted[place] = self._programs(place, before, aim, blocks)
            for program, _ in counted[place]:
                program.expose(sums, lanes, 0, blocks, sample, many, seed)
        for programs in counted.values():
            for _, weights in programs:
                covered += weights / np.float32(len(programs))
        planes = np.concatenate([sums.reshape(blocks, 3, B).transpose(1, 0, 2).reshape(3, -1), covered[None]])
        planes *= np.float32(1.0 / number)
        return planes[:, :self.width * h].reshape(4, h, self.width)

    def _samples(self, first: int, number: int) -> list[tuple[int, int, int | None]]:
        """First sample, number of samples, and their part of the spectrum or None: the d line."""
        if not self.camera.disperses:
            return [(first, number, None)]
        return [(sample, 1, spectral_part(sample, self.seed)) for sample in range(first, first + number)]

    def _programs(self, place: int | None, before: list[Step], aim: Callable[[float], list[Step]], blocks: int
                  ) -> list[_Counted]:
        """The programs of a part of the spectrum, one for each channel; None: that of the d line."""
        camera, scene = self.camera, self.scene
        timed = camera.moves or scene.moves
        clock = [camera.clock] if timed else []
        after = scene.steps(self.shadows, camera.shutter_open, medium=camera.medium)
        lines = [(D_LINE, [])] if place is None else [(row[place], [channel_step(name)])
                                                      for name, row in WAVELENGTHS.items()]
        made = []
        for wavelength, channel in lines:
            to_lens = [*sampling_steps(self.width, camera.film.pixels_y, lit=self.shadows, timed=timed), *before,
                       *clock, *aim(wavelength), *camera.port]
            program = Program([*to_lens, Step(sum_weights, np.zeros(blocks * B)), *camera.carried, *after, *channel])
            first, last = program.code.ends[0, len(to_lens):len(to_lens) + 2]
            made.append(_Counted(program, program.code.numbers[first:last]))
        return made


def in_parallel(work: Callable[[Item, Callable[[], bool]], None], items: Sequence[Item],
                progress: Callable[[float], bool], name: str, threads: int | None = None) -> None:
    """Work on all items in threads. LightFieldError "the NAME was cancelled" when `progress` answers False.

    work: takes an item, and a function that says whether to stop early; progress: takes the share that is done.
    """
    done, cancelled = count(1), threading.Event()

    def one(item: Item) -> None:
        if not cancelled.is_set():
            work(item, cancelled.is_set)
        if not cancelled.is_set() and not progress(next(done) / len(items)):
            cancelled.set()

    with ThreadPoolExecutor(threads or os.cpu_count() or 1) as pool:
        list(pool.map(one, items))
    if cancelled.is_set():
        raise LightFieldError(f"the {name} was cancelled")


@stage
def place_samples(lanes, p, ints, key):
    """X, Y: samples drawn together about the middle of each pixel, then offset. p: FILL … OFFSET_Y."""
    real = lanes.dtype.type
    row = rows(lanes)
    x, y = row[X], row[Y]
    fill, across, down = p[FILL], p[OFFSET_X], p[OFFSET_Y]
    for i in range(B):
        a, b = np.floor(x[i]) + real(0.5), np.floor(y[i]) + real(0.5)
        x[i], y[i] = a + (x[i] - a) * fill + across, b + (y[i] - b) * fill + down


@stage
def sample_moment(lanes, p, ints, key):
    """TIME: within a part of the exposure. p: LENGTH, START."""
    row = rows(lanes)
    time = row[TIME]
    length, start = p[LENGTH], p[START]
    for i in range(B):
        time[i] = start + length * time[i]


@stage
def sum_weights(lanes, p, ints, key):
    """Add the WEIGHT of each lane to the sum of its pixel. p: the sums of all blocks, which this stage writes."""
    real = lanes.dtype.type
    row = rows(lanes)
    weight, sums = row[WEIGHT], p[key[PIXEL]:]
    for i in range(B):
        sums[i] += weight[i] if weight[i] > real(0) else real(0)
