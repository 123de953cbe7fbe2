"""Two threads that the analyses share, so that a figure of milliseconds does not wait for threads to start."""

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import TypeVar

THREADS = 2
PARTS = 8               # handed to the threads at most: each costs a twentieth of a millisecond
Item = TypeVar("Item")


@lru_cache(maxsize=1)
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(THREADS, "lensbench analysis")


def each_of(work: Callable[[Item], object], items: Iterable[Item]) -> None:
    """Do the work of each item on the threads and wait for all; an error in one is raised. `work` must not call it."""
    every = list(items)
    parts = [every[i::PARTS] for i in range(min(PARTS, len(every)))]

    def do(part: list[Item]) -> None:
        for item in part:
            work(item)

    for _ in _pool().map(do, parts):
        pass
