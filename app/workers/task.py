"""One piece of background work, the threads that do it, and the memory that it leaves.

A `Task` runs once, on a thread of its own. The window polls `done`; the work reports its progress and learns from the
answer whether it goes on.

glibc gives threads arenas of their own. A window has many short-lived threads; what one leaves free in its arena serves
no other one, so that the process grows while it holds no more. Other systems' heaps are left as they are.
"""

import ctypes
import os
import sys
import threading
import traceback
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from lensbench.core.kernels.cache import NotCompiledError

NICE = 10                   # of the rendering threads, so that the window keeps its pace


def lower_priority() -> None:
    """Lower the priority of the calling thread, below the window's, if the system allows it; never raise it."""
    if sys.platform == "linux":
        thread = threading.get_native_id()
        try:
            os.setpriority(os.PRIO_PROCESS, thread, max(NICE, os.getpriority(os.PRIO_PROCESS, thread)))
        except OSError:                         # not allowed here: unchanged
            pass


def thread_count() -> int:
    """The cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


Result = TypeVar("Result")
STEP = 0.01                     # of progress, at which the window is woken


class TaskCancelledError(Exception):
    """Ends work that reports its progress by `Task.check`."""


def error_text(error: Exception, description: str) -> str:
    """The error of a piece of work in words for the user."""
    if isinstance(error, MemoryError):
        return str(error) or f"{description}: there is not enough memory"
    return str(error) if isinstance(error, ValueError | OSError) else f"{type(error).__name__}: {error}"


def report_unforeseen(error: Exception) -> None:
    """Print the traceback of an error that neither the user nor the system nor the end of the window has caused."""
    if not isinstance(error, ValueError | OSError | MemoryError | NotCompiledError):
        traceback.print_exception(error)


class Task(Generic[Result]):
    """Work that begins at once on a background thread.

    work: receives the task, and returns its result. wake: called from the thread when there is something new to show.
    lowered: the thread runs at a lower priority than the window.
    """

    def __init__(self, description: str, work: Callable[["Task[Result]"], Result],
                 wake: Callable[[], None] = lambda: None, lowered: bool = True):
        self.description = description
        self.progress = 0.0                     # 0 to 1
        self.cancelled = False
        self.result: Result | None = None       # None until the work is done, and after a cancellation or an error
        self.error: Exception | None = None     # None after a cancellation
        self._work, self._wake, self._lowered = work, wake, lowered
        self._woken_at = 0.0
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"lensbench {description.lower()}", daemon=True)
        self._thread.start()

    @property
    def done(self) -> bool:
        """Whether the work has ended: with a result, with an error or cancelled."""
        return self._done.is_set()

    @property
    def message(self) -> str:
        """The error in words for the user; "" without an error."""
        return "" if self.error is None else error_text(self.error, self.description)

    def report(self, progress: float) -> bool:
        """Note the part that is done; False: the task is cancelled, and the work must end."""
        self.progress = progress
        if abs(progress - self._woken_at) >= STEP:
            self._woken_at = progress
            self._wake()
        return not self.cancelled

    def check(self, progress: float) -> None:
        """As `report`, for work that an exception ends: TaskCancelledError."""
        if not self.report(progress):
            raise TaskCancelledError

    def cancel(self) -> None:
        """Ask the work to end; its result is dropped. Returns at once."""
        self.cancelled = True

    def join(self, seconds: float | None = None) -> None:
        """Wait for the end."""
        self._thread.join(seconds)

    def _run(self) -> None:
        if self._lowered:
            lower_priority()
        try:
            result = self._work(self)
            if not self.cancelled:
                self.result = result
        except Exception as error:              # the thread has no caller: whoever polls the task shows the message
            if not self.cancelled:
                self.error = error
                report_unforeseen(error)
        finally:
            self._done.set()
            self._wake()


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
