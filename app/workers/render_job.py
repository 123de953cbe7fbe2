"""One picture of the render worker: its camera, its scene, its rendering, and how many samples the next pass has."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lensbench.app.state.settings import Settings

PASS_SECONDS = 0.03         # aimed at between two pictures on the screen


def prepare(settings: Settings) -> tuple[Any, Any]:
    """The camera and the scene of the settings."""
    from lensbench.app.state.camera_kinds import camera
    from lensbench.app.state.scene_file import cached_scene

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
        from lensbench.app.state.coating import flare

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
