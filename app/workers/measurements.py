"""Measurements by key, one at a time in the background, and the automatic lens model among them.

A choice cannot be interrupted. One runs at a time, on a thread of its own, so that the pictures of a drag need not
wait for the choices of settings that have gone by.
"""

from collections.abc import Callable, Hashable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, Generic, TypeVar

from lensbench.app.bench.auto_model import Chosen, choice_key, choose, is_automatic, provisional
from lensbench.app.settings.settings import Settings
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


Finished = Callable[[Future], bool]         # waits for work; False: it is no longer wanted
MOST_SPEEDS = 64            # that are kept: each place of a zoom, and each edit of a lens, has its own


class AutomaticModel:
    """The newest choice and the measured speeds. Called from the render worker's thread; `pool` has one thread."""

    def __init__(self, pool: ThreadPoolExecutor):
        self._pool = pool
        self._chosen: Chosen | None = None
        self._choosing: Future[Chosen] | None = None            # perhaps for settings that have gone by
        self._speeds: dict[tuple, tuple[float, float]] = {}     # ns a ray by the model and by the full trace

    def forget(self) -> None:
        """Drop every choice and speed, because a file has changed."""
        self._chosen = self._choosing = None
        self._speeds.clear()

    def first_camera(self, settings: Settings, camera: Any) -> tuple[Any, bool]:
        """The camera of the first pass, and whether its model is still to be chosen."""
        choosing = self._choosing
        if choosing is not None and choosing.done() and not choosing.cancelled() and choosing.exception() is None:
            self._chosen, self._choosing = choosing.result(), None
        if not is_automatic(settings):
            return camera, False
        if self._chosen is not None and self._chosen.of == choice_key(settings):
            return self._chosen.choice.applied(camera), False
        return provisional(settings, camera, self._chosen), True

    def chosen_camera(self, settings: Settings, camera: Any, scene: Any, finished: Finished) -> Any:
        """The camera with the model chosen for these settings; None if it is no longer wanted."""
        self._choosing = self._pool.submit(choose, settings, camera, scene, self._chosen)
        if not finished(self._choosing):
            return None
        self._chosen, self._choosing = self._choosing.result(), None
        return self._chosen.choice.applied(camera)

    def is_timed(self, settings: Settings, camera: Any) -> bool:
        """Whether the speed of this camera is known, or needs no measurement."""
        return not is_automatic(settings) or _speed_key(settings, camera) in self._speeds

    def time(self, settings: Settings, camera: Any, finished: Finished) -> bool:
        """Measure the time that the chosen model saves; False: no longer wanted."""
        assert self._chosen is not None
        choice = self._chosen.choice
        timing = self._pool.submit(lambda: (choice.ns_per_ray, choice.trace_ns_per_ray))
        if not finished(timing):
            return False
        while len(self._speeds) >= MOST_SPEEDS:
            del self._speeds[next(iter(self._speeds))]
        self._speeds[_speed_key(settings, camera)] = timing.result()
        return True

    def fields(self, settings: Settings, camera: Any, is_provisional: bool) -> dict[str, Any]:
        """The fields of an update that describe the model."""
        if not is_automatic(settings):
            return {}
        known = self._chosen is not None and self._chosen.of.lens == settings.lens
        return {"choice": self._chosen.choice if known and self._chosen is not None else None,
                "speeds": self._speeds.get(_speed_key(settings, camera)), "is_provisional": is_provisional}


def _speed_key(settings: Settings, camera: Any) -> tuple:
    return settings.lens, settings.edited, settings.zoom, camera.model, camera.degree
