"""One picture of the render worker: what is handed to the window, the rendering, and its automatic lens model.

A choice of the model cannot be interrupted. One runs at a time, on a thread of its own, so that the pictures of a drag
need not wait for the choices of settings that have gone by.
"""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lensbench.app.bench.auto_model import Chosen, choice_key, choose, is_automatic, provisional
from lensbench.app.settings.settings import Settings
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
        from lensbench.app.bench.coating import flare

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
