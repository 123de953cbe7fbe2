"""What a picture takes over from the one before while a dial is dragged, and the light that it gets from its lamps.

The light layer of the picture before shows small lights until those of the new picture are traced, and its samples hide
the noise of the new ones. A picture that is complete contains neither. Lights are traced next to the passes, on a
thread of low priority. They pause while the user waits for a first picture and the panels that follow it; those of
settings that have gone by are traced to their end, for the next ones: a drag need not rest for them.
"""

import math
from collections.abc import Callable
from concurrent.futures import Executor, Future
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lensbench.app.settings.settings import Settings
from lensbench.app.workers.render_job import Finished
from lensbench.core.kernels.pauses import pause

# Settings that change circles of confusion and places on the film, and nothing else that a pixel sees
MAPPED = ("focus_distance", "focus_position", "f_number", "blades", "blade_rotation", "roundness", "stop_image", "crop",
          "zoom", "fov", "seed", "lens_model", "degree")


class PictureBefore:
    """Light layer and samples of the picture before; only `own_light` is called from a second thread."""

    def __init__(self) -> None:
        self._lit: tuple[Any, Any] | None = None        # scene and light layer, the newest
        self._seen: tuple[Settings, Any, Any] | None = None     # settings, excluded light, and the Reusable

    def layer(self, scene: Any, camera: Any) -> Any:
        """The newest light layer of this scene; an empty one before the first, None for a scene without small lights.

        Beside an empty layer the camera's rays see all light: the first picture of a scene waits for no other.
        """
        from lensbench.core.rendering.light_layer import LightLayer
        from lensbench.core.scenery.small_lights import small_lights

        lit = self._lit
        if lit is not None and lit[0] is scene:
            return lit[1]
        return LightLayer.of(camera, [], [], None) if small_lights(scene.objects) else None

    def own_light(self, rendering: Any, scene: Any, pool: Executor, threads: int, goes_on: Callable[[], bool]) -> Any:
        """The light image of a rendering; None when `goes_on` cancelled.

        Later pictures take over its layer, even if the rendering itself is given up meanwhile. They do not where the
        camera's rays leave out other light than before: the samples of a drag could not be reused then. The first layer
        of a scene they take over in any case.
        """
        light_image = rendering.own_light(pool, threads, goes_on)
        is_first = self._lit is None or self._lit[0] is not scene
        if light_image is not None and (is_first or rendering.leaves_out(light_image.left_out)):
            self.lend(scene, light_image.layer())
        return light_image

    def lend(self, scene: Any, layer: Any) -> None:
        """Keep this layer for the pictures that follow, if there is one."""
        if layer is not None:
            self._lit = scene, layer

    def samples(self, settings: Settings, rendering: Any, pool: Executor, threads: int) -> Any:
        """The samples of the picture before, carried into a rendering of these settings; None where they do not fit.

        Where the camera's rays left out other light, the samples get no weight, and only their depth is used.
        """
        last = self._seen
        if last is None or settings.sample_view or last[0] != _unmapped(settings):
            return None
        before = last[2] if rendering.leaves_out(last[1]) else last[2]._replace(counts=np.zeros_like(last[2].counts))
        return before.carried(rendering.camera, pool, threads)

    def keep(self, settings: Settings, rendering: Any, mixed: Any, image: NDArray[np.float32],
             depth: NDArray[np.float32] | None) -> None:
        """Keep the shown picture without its light layer; mixed: with old samples, None where `image` has none."""
        from lensbench.core.rendering.temporal_reuse import Reusable

        self._seen = None
        if settings.sample_view or settings.moves:
            return
        if mixed is None and depth is not None:
            mixed = Reusable(rendering.camera, image, np.full(image.shape[:2], rendering.samples, np.float32), depth)
        if mixed is not None:
            self._seen = (_unmapped(settings), rendering.excluded,
                          mixed if depth is None else mixed._replace(depth=depth))


def _unmapped(settings: Settings) -> Settings:
    return settings.picture.plain(*MAPPED)


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
                                                          self._threads, self._goes_on)
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
        from lensbench.app.workers.compilers import trace_lights

        self._thread.submit(trace_lights, scene).add_done_callback(lambda _: done())

    def _goes_on(self) -> bool:
        """Whether lights are traced to their end."""
        pause(self._pauses)
        return self._alive()

    def _pauses(self) -> bool:
        now = perf_counter()
        if not self._awaited():
            self._free = now
            return False
        return self._alive() and now < self._free + LIGHT_SECONDS
