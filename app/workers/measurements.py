"""Measurements by key, one at a time in the background; the key that is wanted last comes first."""

from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

from lensbench.app.workers.task import Task

Key = TypeVar("Key", bound=Hashable)
Result = TypeVar("Result")


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
