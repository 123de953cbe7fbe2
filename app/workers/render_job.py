"""One picture of the render worker: what is handed to the window, the rendering, and its automatic lens model.

A choice of the model cannot be interrupted. One runs at a time, on a thread of its own, so that the pictures of a drag
need not wait for the choices of settings that have gone by.

While a dial is dragged, a picture takes over from the one before: its light layer shows small lights until those of the
new picture are traced, and its samples hide the noise of the new ones. A complete picture contains neither. Lights are
traced next to the passes, on a thread of low priority. They pause while the user waits for a first picture and the
panels that follow it; those of settings that have gone by are traced to their end, for the next ones.
"""

import math
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from dataclasses import dataclass
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lensbench.app.bench.auto_model import Chosen, choice_key, choose, is_automatic, provisional
from lensbench.app.settings.settings import Settings
from lensbench.core.kernels.pauses import pause
from lensbench.core.optics.finding import Finding


class RenderUpdate(NamedTuple):
    """A picture with its samples so far."""

    generation: int                             # counts the restarts
    image: NDArray[np.float32]                  # (h, w, 3) linear
    samples: int                                # a pixel
    seconds: float                              # since the restart, without pauses
    settings: Settings
    rate: float                                 # samples a second, over the whole picture
    depth: NDArray[np.float32] | None = None    # (h, w) mm from the film along the axis, inf for the sky
    choice: Any = None                          # of the automatic model: the Choice
    speeds: tuple[float, float] | None = None   # ns a ray by that model, and by the full trace
    is_provisional: bool = False                # model or light of earlier settings: the picture may restart
    coded: bool = False                         # the image holds codes of the screen, neither exposed nor toned
    field_picture: int = 0                      # of a light field: its number
    plain: NDArray[np.float32] | None = None    # the image without samples of the picture before; None: it has none
    findings: tuple[Finding, ...] = ()        # what it leaves out, as `Rendering.findings`

    @property
    def key(self) -> tuple[int, int, bool, int]:
        """Distinguishes the image from all other images of the window."""
        return self.generation, self.samples, self.is_provisional, self.field_picture

    @property
    def raw(self) -> bool:
        """Whether it shows something else than light."""
        return self.coded or bool(self.settings.sample_view)


class Failure(NamedTuple):
    """Settings that cannot be rendered, and why."""

    generation: int
    settings: Settings
    error: Exception


PASS_SECONDS = 0.03         # aimed at between two pictures on the screen


def prepare(settings: Settings) -> tuple[Any, Any]:
    """The camera and the scene of the settings."""
    from lensbench.app.bench.camera_kinds import camera
    from lensbench.app.scenes.scene_file import cached_scene

    return camera(settings), cached_scene(settings.scene)


@dataclass
class RenderJob:
    """One picture under way."""

    generation: int
    settings: Settings
    camera: Any                                 # as it is rendered
    scene: Any
    rendering: Any = None                       # after `begin`
    automatic: Any = None                       # the camera whose model is to be chosen, until it is
    light_tracing: bool = True                  # where the settings want it
    seconds: float = 0.0
    rate: float = 0.0                           # samples a second, over the whole picture
    pass_samples: int = 1
    depth: NDArray[np.float32] | None = None
    before: Any = None                          # samples of the picture before, carried into this one
    mixed: Any = None                           # with those of this one

    def begin(self, layer: Any) -> None:
        """Begin the picture of the camera with a layer of light of another picture, or None."""
        import lensbench as lb
        from lensbench.app.bench.build import flare

        self.pass_samples = 1
        self.rendering = lb.Rendering(self.camera, self.scene, seed=self.settings.seed, view=self.settings.sample_view,
                                      light_tracing=self.light_tracing and self.settings.light_tracing, layer=layer,
                                      flare=flare(self.settings))

    def timed(self, samples: int, seconds: float) -> None:
        """Note how long a pass of so many samples took."""
        height, width = self.rendering.shape
        rate = height * width * samples / max(seconds, 1e-9)
        self.seconds += seconds
        self.rate = rate if self.rate == 0.0 else 0.7 * self.rate + 0.3 * rate
        self.pass_samples = max(1, min(2 * self.pass_samples, round(samples * PASS_SECONDS / max(seconds, 1e-6))))


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
