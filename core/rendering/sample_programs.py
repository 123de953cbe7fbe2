"""Samples of a picture: the programs that trace them, and the sums over the film to which these add."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from itertools import count
from typing import Any

import numpy as np

from lensbench.core.cameras.base import Camera
from lensbench.core.cameras.pupil_footprint import footprint_steps
from lensbench.core.cameras.ray_generation import spread_step
from lensbench.core.imaging.spectrum import WAVELENGTHS, channel_step, spectral_part
from lensbench.core.kernels.block import B, Step, lane_buffer
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import BAND_LINES, raster_image, sampling_steps
from lensbench.core.rendering.aovs import AVERAGED, aov_steps, arrival_steps
from lensbench.core.rendering.sample_allocation import SampleAllocation
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.small_lights import ExcludedLight


class SamplePrograms:
    """The programs that the samples of a picture run, and the numbers of these samples; arguments as for `Rendering`.

    With a camera that disperses, the first sample is of the d line, and every later one is three, one wavelength for
    each channel. The later ones are numbered from 0 again, since they replace the first. `before`: stages that place
    the samples and give each the size of its part of the pixel. `counting`: the program that counts the samples that
    arrive, for the AOVs that are means over these.
    """

    def __init__(self, camera: Camera, scene: Scene, seed: np.uint32, real: Any, steps: Sequence[Step] | None,
                 shadows: bool, view: str, filtered: bool):
        film = camera.film
        self._camera, self._scene, self._seed, self._real = camera, scene, seed, real
        self._shadows, self._view = shadows, view
        self._timed = camera.moves or scene.moves
        timed = self._timed or view == "time"
        self.before = (sampling_steps(film.pixels_x, film.pixels_y, lit=shadows, timed=timed) if steps is None
                       else [*steps])
        self._pupil_part: list[Step] = []
        if filtered and not view:
            if scene.is_patterned or scene.is_rough:
                self.before.append(spread_step(camera, real))
            if scene.is_rough:
                size, self._pupil_part = footprint_steps(camera, real)
                self.before += size
        self.disperses = camera.disperses and not view
        self.counting = Program([*self.before, *arrival_steps(camera, timed)], real) if view in AVERAGED else None

    def compose(self, excluded: ExcludedLight | None) -> None:
        """Put the stages together. excluded: light that the camera's rays leave out."""
        self._after = self._after_camera(excluded)
        self._program = self.plain(excluded)
        self._channel_programs: dict[int, list[Program]] = {}   # of each part of the spectrum, one for each channel

    def plain(self, excluded: ExcludedLight | None) -> Program:
        """The program of the samples of the d line, where the camera's rays leave out this light."""
        camera = self._camera
        steps = aov_steps(camera, self._scene, self._view) if self._view else [
            *camera.steps(timed=self._timed), *self._after_camera(excluded)]
        return Program([*self.before, *steps], self._real)

    def _after_camera(self, excluded: ExcludedLight | None) -> list[Step]:
        """The stages that follow a ray into the scene."""
        return [*self._pupil_part,
                *self._scene.steps(self._shadows, self._camera.shutter_open, excluded, self._camera.medium)]

    def passes(self, samples: np.ndarray, counts: np.ndarray, is_first: bool, wanted: Callable[[], bool]
               ) -> list[tuple[Program, np.ndarray, np.ndarray]] | None:
        """The samples of some blocks as passes: program, number of the first sample of each block, number of samples.

        samples, counts: (blocks,) int64, number of the first sample of each block and of its samples. is_first: whether
        they are the first sample alone, of the d line. None when `wanted` returned False: the cameras of a new part of
        the spectrum take time.
        """
        if not self.disperses or is_first:
            return [(self._program, samples, counts)]
        passes = []
        ranges = np.unique(np.stack([samples, samples + counts]), axis=1).T
        for sample in np.unique(np.concatenate([np.arange(*span) for span in ranges])):
            if not wanted():
                return None
            now = ((samples <= sample) & (sample < samples + counts)).astype(np.int64)
            passes += [(program, np.full_like(samples, sample), now)
                       for program in self._channels(spectral_part(sample, self._seed))]
        return passes

    def numbers(self, done: int, samples: int) -> list[tuple[int, int | None]]:
        """Numbers of the samples that follow `done` samples, each with its part of the spectrum; None: the d line."""
        if not self.disperses or done + samples == 1:
            return [(sample, None) for sample in range(done, done + samples)]
        return [(sample, spectral_part(sample, self._seed)) for sample in range(max(done - 1, 0), done + samples - 1)]

    def numbers_so_far(self, done: int) -> list[tuple[int, int | None]]:
        """`numbers` of the samples that count among the first `done` samples; at least one."""
        if not self.disperses or done <= 1:
            return [(sample, None) for sample in range(max(done, 1))]
        return [(sample, spectral_part(sample, self._seed)) for sample in range(done - 1)]

    def counted(self, done: int) -> int:
        """Number of samples that the picture is the mean of: that of the d line is dropped once others follow."""
        return done - 1 if self.disperses and done > 1 else done

    def kept(self, done: int) -> int:
        """Number of samples among the first `done` that count when others follow."""
        return max(done - 1, 0) if self.disperses else done

    def _channels(self, part: int) -> list[Program]:
        """The programs of a part of the spectrum, one for each channel."""
        if part not in self._channel_programs:
            self._channel_programs[part] = [
                Program([*self.before, *self._camera.steps(row[part], self._timed), *self._after, channel_step(name)],
                        self._real)
                for name, row in WAVELENGTHS.items()]
        return self._channel_programs[part]


TURN = 16               # blocks that a thread takes at a time


class FilmSums:
    """The sums of the lines of a film (h, w) that are held, and the shares of their blocks in the samples.

    even: all blocks take the same samples. in_bands: one band of lines is held at a time.
    """

    def __init__(self, shape: tuple[int, int], programs: SamplePrograms, seed: np.uint32, real: type, even: bool,
                 in_bands: bool):
        self._height, self._width = shape
        self._programs, self._seed, self._real = programs, seed, real
        self.lines = range(min(BAND_LINES, self._height) if in_bands else self._height)
        self._sums: np.ndarray = np.zeros((-(-self._width * len(self.lines) // B), 3 * B), real)
        self._arrived = np.zeros_like(self._sums) if programs.counting else None
        self.allocation = SampleAllocation(len(self._sums), self._width, real, even)

    @property
    def state(self) -> dict[str, np.ndarray]:
        """The arrays by name, for `restore`."""
        arrays = {"sums": self._sums} | self.allocation.state
        return arrays if self._arrived is None else arrays | {"arrived": self._arrived}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Take over the arrays of other sums of the same picture."""
        for name, sums in (("sums", self._sums), ("arrived", self._arrived)):
            if sums is not None and sums is not state[name]:
                sums[:] = state[name]
        self.allocation.restore(state)

    def clear(self) -> None:
        """Begin the picture anew."""
        self._sums[:] = 0.0
        self.allocation.clear()

    def drop_first(self) -> None:
        """Drop the sample of the d line, which those at many wavelengths replace."""
        self._sums[:] = 0.0

    def add(self, done: int, end: int, is_first: bool, pool: Executor, threads: int, wanted: Callable[[], bool]
            ) -> bool:
        """Add the samples of all blocks between two numbers of samples a pixel, of those that count.

        is_first: whether they are the first sample alone, of the d line. False when `wanted` cancelled: the sums are
        then incomplete.
        """
        for begin, stop in self.allocation.pieces(done, end):
            if not self._expose(begin, stop, is_first, pool, threads, wanted):
                return False
            self.allocation.finish(stop, self._sums)
        return True

    def _expose(self, done: int, end: int, is_first: bool, pool: Executor, threads: int, wanted: Callable[[], bool]
                ) -> bool:
        """Add the samples of one piece; False when `wanted` cancelled."""
        turns, stop, counting = count(0, TURN), len(self._sums), self._programs.counting
        origin = self.lines.start * self._width // B
        first_samples, counts, weights = self.allocation.samples(done, end)
        passes = self._programs.passes(first_samples, counts, is_first, wanted)
        if passes is None:
            return False

        def work(_: int) -> bool:
            lanes = lane_buffer(self._real)
            while (first := next(turns)) < stop:
                if not wanted():
                    return False
                last = min(first + TURN, stop)
                span = origin + first, origin + last
                for program, sample, number in passes:
                    begins, taken = sample[first:last], number[first:last]
                    program.expose(self._sums, lanes, *span, begins, taken, self._seed, origin, weights[first:last])
                    if counting and self._arrived is not None:
                        counting.expose(self._arrived, lanes, *span, begins, taken, self._seed, origin)
            return True

        return all(list(pool.map(work, range(threads))))

    def next_band(self) -> bool:
        """Go on to the next band of lines, of 0 samples; False when there is none: the current band stays."""
        if self.lines.stop == self._height:
            return False
        self.lines = range(self.lines.stop, min(self.lines.stop + BAND_LINES, self._height))
        for sums in (self._sums, self._arrived):
            if sums is not None:
                sums[:] = 0.0
        blocks = -(-self._width * len(self.lines) // B)             # fewer in the last band
        self.allocation.clear(blocks)
        self._sums, self._arrived = self._sums[:blocks], None if self._arrived is None else self._arrived[:blocks]
        return True

    def mean(self, lines: range, counted: int) -> np.ndarray:
        """Mean of the samples (h, w, 3) in whole bands of lines; counted: samples a pixel that count."""
        h, w = len(lines), self._width
        first = (lines.start - self.lines.start) * w // B
        sums = self._sums[first:]
        if self._arrived is not None:
            arrived = raster_image(self._arrived[first:], w, h)
            return raster_image(sums, w, h) / np.maximum(arrived, np.float32(1))
        weights = self.allocation.weights(counted)
        return raster_image(sums, w, h, 1.0 / np.maximum(weights[first:], 1.0))
