"""Light of a lens about its lights in a picture: ghosts, and the stars of the blades."""

from collections.abc import Callable, Mapping
from concurrent.futures import Executor

import numpy as np

from lensbench.core.cameras.base import Camera
from lensbench.core.optics.finding import Finding
from lensbench.core.rendering.ghost_image import Flare, GhostImage
from lensbench.core.rendering.star_image import StarImage
from lensbench.core.scenery.scene import Scene


class FlareImage:
    """Ghosts and stars of a picture, after the samples so far; what has the strength 0 is not made.

    Parameters: the camera, whose model is resolved; the scene; what is shown.
    """

    def __init__(self, camera: Camera, scene: Scene, flare: Flare):
        self._parts: list[GhostImage | StarImage] = []
        if flare.strength > 0.0:
            self._parts.append(GhostImage(camera, scene, flare))
        if flare.stars > 0.0:
            self._parts.append(StarImage(camera, scene, flare.stars, flare.channels))

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to add."""
        return all(part.reason for part in self._parts)

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Why there are no ghosts or stars, or which lights have none; the latter is known after the first sample."""
        return tuple(finding for part in self._parts for finding in part.findings)

    @property
    def state(self) -> dict[str, np.ndarray]:
        """The sums so far, by name, for `restore`."""
        return {name: sums for part in self._parts for name, sums in part.state.items()}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Go on from such sums."""
        for part in self._parts:
            part.restore(state)

    def add(self, samples: int, pool: Executor, threads: int, wanted: Callable[[], bool]) -> bool:
        """Add the light of so many samples; False when `wanted` cancelled on the way."""
        return all(part.add(samples, pool, threads, wanted) for part in self._parts)

    def add_to(self, picture: np.ndarray, top: int = 0) -> None:
        """Add the light so far to lines of a picture (lines, w, 3), the first of which is `top`."""
        for part in self._parts:
            part.add_to(picture, top)
