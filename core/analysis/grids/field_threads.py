"""Two threads that the analyses share, so that a figure of milliseconds does not wait for threads to start."""

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import TypeVar

from lensbench.kernels.pauses import due, pause

THREADS = 2
PARTS = 8               # handed to the threads at most: each costs a twentieth of a millisecond
Item = TypeVar("Item")


@lru_cache(maxsize=1)
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(THREADS, "lensbench analysis")


def each_in_turn(work: Callable[[Item], object], items: Iterable[Item]) -> None:
    """Do the work of each item on the present thread, which may pause before each: of work that is soon done."""
    for item in items:
        pause()
        work(item)


def each_of(work: Callable[[Item], object], items: Iterable[Item]) -> None:
    """Do the work of each item on the threads and wait for all; an error in one is raised. `work` must not call it.

    Where the present thread shall pause, what is not begun waits, and the threads are free for others.
    """
    left, paused = list(items), due()

    def do(part: list[Item]) -> list[Item]:
        for done, item in enumerate(part):
            if paused():
                return part[done:]
            work(item)
        return []

    while left:
        pause()
        parts = [left[i::PARTS] for i in range(min(PARTS, len(left)))]
        left = [item for part in _pool().map(do, parts) for item in part]
