"""What the renderer hands to the window: a picture with its samples so far, or the reason why there is none."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lensbench.app.state.settings import Settings
from lensbench.optics.finding import Finding


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
