"""Timing of work that is compared: pieces of work in turn, the least time of each."""

import math
import time
from collections.abc import Callable

from numba import njit

import lensbench as lb
from lensbench.kernels import block
from lensbench.kernels.program import call_stage

LENS = "pbrt-dgauss-50mm"

FILM = lb.Film(32.0, 18.0, 640, 360)


def least(works: dict[str, Callable[[], object]], seconds: float = 0.6) -> dict[str, float]:
    """The least time (s) of each piece of work, all taken in turn for about `seconds` each."""
    best = dict.fromkeys(works, math.inf)
    for work in works.values():
        work()
    end = time.perf_counter() + seconds * len(works)
    while time.perf_counter() < end:
        for name, work in works.items():
            start = time.perf_counter()
            work()
            best[name] = min(best[name], time.perf_counter() - start)
    return best


@njit(nogil=True)
def blocks(bench, given, p, key, code, times):
    """The same block of rays again and again; the rays are put back each time."""
    for _ in range(times):
        bench[block.X * block.PITCH:block.WEIGHT * block.PITCH + block.B] = given
        call_stage(code, bench, p, key)
