"""Timing of pieces of work in turn, of stages on rays in the first-level cache; and evenly spread points.

Pieces of work run in turn, so that other load of the machine affects all of them equally. The cost is the least of many
times, because other load can only add time; the median shows how much it added.
"""

import os
import platform
import time
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

import lensbench as lb
from lensbench.core.kernels import block
from lensbench.core.kernels.block import B, Step
from lensbench.core.kernels.cache import njit
from lensbench.core.kernels.program import Program, run_steps

GOLDEN = 0.6180339887498949             # the golden ratio less 1


def even_points(count: int) -> np.ndarray:
    """Points (count, 2) in [0, 1)²: the first coordinate in equal steps, the second in steps of the golden ratio."""
    k = np.arange(count)
    return np.column_stack([(k + 0.5) / count, k * GOLDEN % 1.0])


LENS = "pbrt-dgauss-50mm"
FILM = lb.Film(32.0, 18.0, 640, 360)
BLOCKS = 40                     # blocks of rays in one piece of streamed work
FIRST = block.X * block.PITCH   # rows that a camera writes, from X to WEIGHT


class Time(NamedTuple):
    """Time of one piece of work (s): the least and the median of its runs."""

    least: float
    median: float

    def per_item(self, count: int) -> "Time":
        """Time of one of `count` items (ns)."""
        return Time(1e9 * self.least / count, 1e9 * self.median / count)

    def without(self, overhead: float) -> "Time":
        """Time less an overhead in the same unit; at least 0.01."""
        return Time(*(max(time - overhead, 0.01) for time in self))

    @property
    def spread(self) -> float:
        """Excess of the median run over the least run, in percent."""
        return 100.0 * (self.median / self.least - 1.0)


class StoppedError(Exception):
    """The caller cancelled the work."""


def report_progress(progress: Callable[[float], bool], share: float) -> None:
    """Report the finished share (0 to 1); StoppedError where `progress` returns False."""
    if not progress(share):
        raise StoppedError


def time_in_turn(works: dict[str, Callable[[], object]], seconds: float, rounds: int = 5) -> dict[str, Time]:
    """Times of works in turn, about `seconds` each and at least `rounds` times, after a run that compiles."""
    runs: dict[str, list[float]] = {name: [] for name in works}
    for work in works.values():
        work()
    end, done = time.perf_counter() + seconds * len(works), 0
    while done < rounds or time.perf_counter() < end:
        for name, work in works.items():
            start = time.perf_counter()
            work()
            runs[name].append(time.perf_counter() - start)
        done += 1
    return {name: Time(min(times), float(np.median(times))) for name, times in runs.items()}


def least_times(works: dict[str, Callable[[], object]], seconds: float = 0.25) -> dict[str, float]:
    """Least time (s) of each piece of work; all run in turn for about `seconds` each."""
    return {name: times.least for name, times in time_in_turn(works, seconds, rounds=1).items()}


@njit(nogil=True, cache=True)
def _repeated(lanes, rays, code, key, times):
    """Run the steps of a Program over one block `times` times; restore the rays before each run."""
    for _ in range(times):
        for i in range(rays.size):
            lanes[FIRST + i] = rays[i]
        run_steps(lanes, code, key)


def streamed(steps: list[Step], rays: dict[int, np.ndarray], real=np.float32) -> Callable[[], None]:
    """A piece of work that runs the steps BLOCKS times over one block of lanes, which stays in the first-level cache.

    given: {row: (B,) values}. Rows that a camera writes, from X on, are restored before each run.
    """
    program, lanes = Program(steps, real), block.lane_buffer(real)
    table = lanes.reshape(block.ROWS, block.PITCH)
    for row, values in rays.items():
        table[row, :B] = values
    kept = lanes[FIRST:max((row for row in rays if row <= block.WEIGHT), default=0) * block.PITCH + B].copy()
    return partial(_repeated, lanes, kept, program.code, np.zeros(block.KEYS, np.uint32), BLOCKS)


@block.stage
def idle(lanes, p, ints, key):
    """A stage that changes nothing; its time is the cost of restoring the rays."""


def machine() -> str:
    """Description of the machine: processor, number of cores, Python and system."""
    name = platform.processor() or platform.machine()
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as lines:
            name = next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    return f"{name}, {os.cpu_count()} cores, Python {platform.python_version()}, {platform.system()}"
