"""The light that pictures get from their lamps, traced beside their passes on a thread of low priority.

The user waits for first pictures, and for the panels that follow them: lights pause meanwhile. Those of settings that
have gone by are traced to their end, for the next ones: a drag need not rest for them.
"""

import math
from collections.abc import Callable
from concurrent.futures import Executor, Future
from time import perf_counter
from typing import Any

from lensbench.app.workers.automatic_model import Finished
from lensbench.app.workers.picture_before import PictureBefore
from lensbench.kernels.pauses import pause

LIGHT_SECONDS = 0.5         # between lights while settings change without a rest; and how long they pause


class PictureLights:
    """Traces one picture's lights at a time.

    thread: of one worker, which traces them with `threads` of `pool`. alive: whether the render goes on. awaited:
    whether the user waits for something that comes before lights; both are called from other threads.
    """

    def __init__(self, thread: Executor, pool: Executor, threads: int, alive: Callable[[], bool],
                 awaited: Callable[[], bool]):
        self._thread, self._pool, self._threads, self._alive, self._awaited = thread, pool, threads, alive, awaited
        self._making: tuple[Any, Future] | None = None      # a rendering, and its light on the way
        self._came = -math.inf                  # when the newest light was there
        self._free = 0.0                        # when lights could be traced the last time

    @property
    def are_recent(self) -> bool:
        """Whether the newest have come within LIGHT_SECONDS."""
        return perf_counter() < self._came + LIGHT_SECONDS

    def begin(self, rendering: Any, scene: Any, before: PictureBefore) -> None:
        """Begin with the own light of a rendering, unless another one is under way; `before` keeps it for later."""
        def end(_: Future) -> None:
            self._came = perf_counter()

        if self._making is None or self._making[1].done():
            self._free = perf_counter()
            self._making = rendering, self._thread.submit(before.own_light, rendering, scene, self._pool,
                                                          self._threads, self._wanted)
            self._making[1].add_done_callback(end)

    def of(self, rendering: Any, scene: Any, before: PictureBefore, finished: Finished) -> Any:
        """The own light of a rendering, once; None where something else is `finished` or wanted first."""
        self.begin(rendering, scene, before)
        assert self._making is not None
        lit, making = self._making
        if not finished(making) or lit is not rendering:
            return None
        self._making = None
        return making.result()

    def warm_up(self, scene: Any, done: Callable[[], None]) -> None:
        """Trace the lights of a small picture, which waits for its kernels; then call `done`."""
        from lensbench.app.workers.warm_cache import trace_lights

        self._thread.submit(trace_lights, scene).add_done_callback(lambda _: done())

    def _wanted(self) -> bool:
        """Whether lights are traced to their end."""
        pause(self._pauses)
        return self._alive()

    def _pauses(self) -> bool:
        now = perf_counter()
        if not self._awaited():
            self._free = now
            return False
        return self._alive() and now < self._free + LIGHT_SECONDS
