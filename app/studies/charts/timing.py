"""How long pieces of work take beside each other, and what stages cost on rays that stay in the first cache.

Works are taken in turn, so that what else the machine does meets all of them alike. The least time of many is the
cost, for other work can only add; the middle one beside it says by how much.
"""

import time
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from numba import njit

from lensbench.kernels import block
from lensbench.kernels.block import B, Step
from lensbench.kernels.program import Program, run_steps

BLOCKS = 40                     # of rays in one piece of work
FIRST = block.X * block.PITCH   # of the numbers that a camera writes: from X to WEIGHT


class Time(NamedTuple):
    """Of one piece of work, in seconds: the least of its runs and the middle one."""

    least: float
    usual: float

    def each(self, count: int) -> "Time":
        """Of one of so many, ns."""
        return Time(1e9 * self.least / count, 1e9 * self.usual / count)

    def without(self, least: float) -> "Time":
        """Less what takes this long itself; never nothing."""
        return Time(*(max(time - least, 0.01) for time in self))

    @property
    def spread(self) -> float:
        """By what percentage the middle run took longer than the least."""
        return 100.0 * (self.usual / self.least - 1.0)


class StoppedError(Exception):
    """The work was not wanted any more."""


def go_on(progress: Callable[[float], bool], share: float) -> None:
    """Tell what part is done; StoppedError where the answer is no."""
    if not progress(share):
        raise StoppedError


def in_turn(works: dict[str, Callable[[], object]], seconds: float) -> dict[str, Time]:
    """The time of each piece of work, all taken in turn for about so many seconds each, and at least five times."""
    runs: dict[str, list[float]] = {name: [] for name in works}
    for work in works.values():
        work()
    end, rounds = time.perf_counter() + seconds * len(works), 0
    while rounds < 5 or time.perf_counter() < end:
        for name, work in works.items():
            start = time.perf_counter()
            work()
            runs[name].append(time.perf_counter() - start)
        rounds += 1
    return {name: Time(min(times), float(np.median(times))) for name, times in runs.items()}


@njit(nogil=True, cache=True)
def _again(bench, given, code, gated, data, ends, key, times):
    """Run the steps of a Program over one block again and again; its rays are put back each time."""
    for _ in range(times):
        for i in range(given.size):
            bench[FIRST + i] = given[i]
        run_steps(bench, code, gated, data, ends, key)


def streamed(steps: list[Step], given: dict[int, np.ndarray], real=np.float32) -> Callable[[], None]:
    """A piece of work: BLOCKS times the steps over one block of lanes, whose rows are given: {row: (B,) values}.

    Those of them that a camera writes, from X on, are put back each time.
    """
    program, bench = Program(steps, real), block.lane_buffer(real)
    table = bench.reshape(block.ROWS, block.PITCH)
    for row, values in given.items():
        table[row, :B] = values
    kept = bench[FIRST:max((row for row in given if row <= block.WEIGHT), default=0) * block.PITCH + B].copy()
    return partial(_again, bench, kept, program.code, program.gated, program.data, program.ends,
                   np.zeros(block.KEYS, np.uint32), BLOCKS)
