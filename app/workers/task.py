"""Pieces of background work, the threads that do them, and the memory that they leave.

A `Task` runs once, on a thread of its own. The window polls `done`; the work reports its progress and learns from the
answer whether it goes on. `Measurements` are tasks with a key, one at a time, whose results are kept.

glibc gives threads arenas of their own. A window has many short-lived threads; what one leaves free in its arena serves
no other one, so that the process grows while it holds no more. Other systems' heaps are left as they are.
"""

import ctypes
import os
import sys
import threading
import traceback
from collections.abc import Callable, Hashable
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


Key = TypeVar("Key", bound=Hashable)
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


class Measurements(Generic[Key, Result]):
    """Results of measurements, and the task that measures. Call all methods from the window's thread.

    measure: receives the key and the task, and returns the result. keep_all: results of earlier keys stay.
    lowered: as of `Task`.
    """

    def __init__(self, measure: Callable[[Key, Task[Result]], Result], wake: Callable[[], None] = lambda: None,
                 keep_all: bool = True, lowered: bool = True):
        self.found: dict[Key, Result] = {}
        self.problems: dict[Key, str] = {}
        self.declined: Key | None = None        # cancelled by the user: not measured until `again`
        self.key: Key | None = None             # being measured
        self.task: Task[Result] | None = None
        self._measure, self._wake, self._keep_all, self._lowered = measure, wake, keep_all, lowered
        self._replaced = False                  # the task was cancelled for the sake of another key

    def want(self, key: Key) -> None:
        """Measure this key next, unless it is known or declined. A task for another key is cancelled."""
        self.collect()
        if key in (self.key, self.declined) or key in self.found or key in self.problems:
            return
        if self.task is None:
            self._begin(key)
        else:
            self.give_way()

    def again(self, key: Key) -> None:
        """Measure this key although it is known or declined, unless a task is under way."""
        self.collect()
        if self.task is None:
            self._begin(key)

    def give_way(self) -> None:
        """Cancel the task because its key is no longer wanted; it may be wanted again later."""
        if self.task is not None and not self.task.cancelled:
            self._replaced = True
            self.task.cancel()

    def forget(self) -> None:
        """Drop all results, because their subject has changed."""
        self.give_way()
        self.found, self.problems, self.declined = {}, {}, None

    def stop(self) -> None:
        """Cancel the task."""
        if self.task is not None:
            self.task.cancel()

    def collect(self) -> None:
        """Take the result of a task that is done."""
        task, key = self.task, self.key
        if task is None or key is None or not task.done:
            return
        self.task = self.key = None
        if task.cancelled:
            self.declined = None if self._replaced else key
            return
        if not self._keep_all:
            self.found, self.problems = {}, {}
        self.found.pop(key, None)
        self.problems.pop(key, None)
        if task.error is None and task.result is not None:
            self.found[key] = task.result
        else:
            self.problems[key] = task.message

    def _begin(self, key: Key) -> None:
        self.key, self.declined, self._replaced = key, None, False
        self.task = Task("Measuring", lambda task: self._measure(key, task), self._wake, self._lowered)


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
