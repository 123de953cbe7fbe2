"""What ray differentials and the rolling shutter ask of a camera.

`cameras.base.Camera` satisfies this protocol. It stands apart so that the helpers of the base class need not
import the base class.
"""

from typing import Any, Protocol

import numpy as np

from lensbench.imaging.film import Film
from lensbench.kernels.block import Step
from lensbench.scenery.shading.participating_medium import Medium


class DifferentiableCamera(Protocol):
    """A camera whose stages, film and placement are known; see `cameras.base.Camera` for each member."""

    @property
    def film(self) -> Film: ...                                                                     # noqa: D102

    @property
    def readout(self) -> float: ...                                                                 # noqa: D102

    @property
    def readout_direction(self) -> str: ...                                                         # noqa: D102

    @property
    def medium(self) -> Medium | None: ...                                                          # noqa: D102

    @property
    def moves(self) -> bool: ...                                                                    # noqa: D102

    @property
    def has_port(self) -> bool: ...                                                                 # noqa: D102

    @property
    def front(self) -> float: ...                                                                   # noqa: D102

    @property
    def pupil_centre(self) -> tuple[float, float]: ...                                              # noqa: D102

    @property
    def film_step(self) -> Step: ...                                                                # noqa: D102

    @property
    def aim_distance(self) -> float | None: ...                                                     # noqa: D102

    def camera_steps(self, wavelength: float = ...) -> list[Step]: ...                              # noqa: D102

    def steps(self, wavelength: float = ..., timed: bool = ...) -> list[Step]: ...                  # noqa: D102

    def film_slopes(self, film_xy: np.ndarray, directions: np.ndarray) -> np.ndarray | None: ...    # noqa: D102

    def placement(self, time: Any = ..., raster: Any = ...) -> np.ndarray: ...                      # noqa: D102
