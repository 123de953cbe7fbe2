"""The C heap of a long session: few arenas, and what is free in them goes back to the system.

glibc gives threads arenas of their own. A window has many short-lived threads; what one leaves free in its arena serves
no other one, so that the process grows while it holds no more. Other systems' heaps are left as they are.
"""

import ctypes
import sys
from typing import Any

from lensbench.app.workers.task import Task

ARENAS = 2
EVERY = 20.0                    # seconds between two times that free memory is given back
_ARENA_MAX = -8                 # M_ARENA_MAX of mallopt


class Heap:
    """Keeps the heap of this process small, from its creation on."""

    def __init__(self) -> None:
        library: Any = ctypes.CDLL(None) if sys.platform == "linux" else None
        self._library: Any = library if hasattr(library, "malloc_trim") else None
        if self._library is not None:
            self._library.mallopt(_ARENA_MAX, ARENAS)
        self._last = 0.0
        self._task: Task[None] | None = None

    def advance(self, now: float) -> None:
        """Give back what is free, on a thread of its own, where it is time for it. now: seconds."""
        if self._library is None or now - self._last < EVERY or (self._task is not None and not self._task.done):
            return
        self._last = now
        self._task = Task("Memory", self._give_back)

    def _give_back(self, _: Task[None]) -> None:
        self._library.malloc_trim(0)
