"""Whether the lights of a scene would show as ghosts and stars, measured in the background on a small picture."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

import lensbench as lb
from lensbench.app.bench.build import flare
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.bench.constraints import with_longer_side
from lensbench.app.bench.exposure import applied_exposure
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.session.export import develop
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.task import Measurements, Task, TaskCancelledError

SIDE = 120                      # pixels of the small picture's longer side
SEEN = 2.0 / 255.0              # change of a developed colour, in 8 bits two steps, that an eye may see

Reasons = dict[str, str]        # by "ghosts" and "stars"; "" where they show


class FlareWorker(Measurements[Settings, Reasons]):
    """The newest measurement."""

    def __init__(self, wake: Callable[[], None] = lambda: None):
        super().__init__(_reasons, wake, keep_all=False)

    def reasons(self, settings: Settings) -> Reasons:
        """Why a picture of these settings would show no ghosts and no stars; {} until it is known."""
        small = replace(with_longer_side(settings, SIDE), samples=1, ghosts=True, stars=True, compare="off",
                        view="picture", lens_model="trace" if settings.follows_lens else settings.lens_model)
        self.want(small)
        return self.found.get(small, {})


def _reasons(settings: Settings, task: Task[Reasons]) -> Reasons:
    view, scene = camera(settings), cached_scene(settings.scene)
    if reason := lb.why_no_ghosts(view, scene):
        return {name: reason.replace("ghosts", name).capitalize() for name in ("ghosts", "stars")}

    def picture(added: str = "") -> NDArray[np.float32]:
        taken = replace(settings, ghosts=added == "ghosts", stars=added == "stars")
        rendering = lb.Rendering(view, scene, seed=settings.seed, flare=flare(taken), light_passes=1)
        if not rendering.add(1, wanted=lambda: not task.cancelled, threads=1):
            raise TaskCancelledError
        return rendering.image()

    plain = picture()
    gain = np.float32(applied_exposure(settings, plain).gain)
    shown = develop(gain * plain, settings)
    return {name: "" if np.abs(develop(gain * picture(name), settings) - shown).max() > SEEN else
            f"No light in this scene is small and bright enough to show {name}" for name in ("ghosts", "stars")}
