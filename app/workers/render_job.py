"""One picture of the render worker: its camera, its scene, its rendering, and how many samples the next pass has.

What the renderer hands to the window: a picture with its samples so far, or the reason why there is none.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

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
