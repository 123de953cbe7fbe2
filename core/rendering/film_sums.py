"""Sums of a picture's samples over its film, to which the programs of `sample_programs` add, block by block."""

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from itertools import count

import numpy as np

from lensbench.kernels.block import B, lane_buffer
from lensbench.kernels.tile_order import BAND_LINES, raster_image
from lensbench.rendering.sample_allocation import SampleAllocation
from lensbench.rendering.sample_programs import SamplePrograms

TURN = 16               # blocks that a thread takes at a time


class FilmSums:
    """The sums of the lines that are held, and the shares of their blocks in the samples.

    Parameters
    ----------
    shape : tuple of int
        (h, w) pixels of the film.
    programs : SamplePrograms
        The programs of the samples.
    seed : np.uint32
        Sampler seed.
    real : type
        np.float32 or np.float64: the numbers of the sums.
    even : bool
        Whether all blocks take the same samples.
    in_bands : bool
        Whether one band of lines is held at a time.

    Attributes
    ----------
    lines : range
        The lines of the film that are held.
    allocation : SampleAllocation
        Shares of the blocks.
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
        found = {"sums": self._sums} | self.allocation.state
        return found if self._arrived is None else found | {"arrived": self._arrived}

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
                place = origin + first, origin + last
                for program, sample, number in passes:
                    begins, many = sample[first:last], number[first:last]
                    program.expose(self._sums, lanes, *place, begins, many, self._seed, origin, weights[first:last])
                    if counting and self._arrived is not None:
                        counting.expose(self._arrived, lanes, *place, begins, many, self._seed, origin)
            return True

        return all(list(pool.map(work, range(threads))))

    def next_band(self) -> bool:
        """Go on to the next band of lines, of 0 samples; False when there is none: the present band stays."""
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
