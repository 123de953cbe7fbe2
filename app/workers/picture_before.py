"""The picture before: what it lends to the first samples of the next one, while a dial is dragged.

Its light layer shows small lights until they are traced, and its samples hide the noise of the new ones. A
complete picture holds nothing of either.
"""

from collections.abc import Callable
from concurrent.futures import Executor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lensbench.app.state.settings import Settings

# Settings that change circles of confusion and places on the film, and nothing else that a pixel sees
MAPPED = ("focus_distance", "focus_position", "f_number", "blades", "blade_rotation", "roundness", "crop", "zoom",
          "fov", "seed", "lens_model", "degree")


class PictureBefore:
    """Belongs to the render worker's thread; `own_light` alone is called from another."""

    def __init__(self) -> None:
        self._lit: tuple[Any, Any] | None = None        # scene and light layer, the newest
        self._seen: tuple[Settings, Any, Any] | None = None     # settings, excluded light, and the Reusable

    def layer(self, scene: Any) -> Any:
        """The newest light layer of this scene; None if there is none."""
        lit = self._lit
        return lit[1] if lit is not None and lit[0] is scene else None

    def own_light(self, rendering: Any, scene: Any, pool: Executor, threads: int, wanted: Callable[[], bool]) -> Any:
        """The light image of a rendering; its layer is lent from now on, also where the picture has gone by.

        Not where the camera's rays would see other light: samples of the pictures of a drag could not be reused.
        None when `wanted` cancelled.
        """
        light_image = rendering.own_light(pool, threads, wanted)
        if light_image is not None and rendering.leaves_out(light_image.left_out):
            self.lend(scene, light_image.layer())
        return light_image

    def lend(self, scene: Any, layer: Any) -> None:
        """Lend this layer, if there is one."""
        if layer is not None:
            self._lit = scene, layer

    def samples(self, settings: Settings, rendering: Any, pool: Executor, threads: int) -> Any:
        """The samples of the picture before, carried into a rendering of these settings; None where they do not fit.

        Samples that saw other light count nothing; the depth goes on.
        """
        seen = self._seen
        if seen is None or settings.sample_view or seen[0] != _unmapped(settings):
            return None
        before = seen[2] if rendering.leaves_out(seen[1]) else seen[2]._replace(counts=np.zeros_like(seen[2].counts))
        return before.carried(rendering.camera, pool, threads)

    def keep(self, settings: Settings, rendering: Any, mixed: Any, image: NDArray[np.float32],
             depth: NDArray[np.float32] | None) -> None:
        """Keep the picture that is shown now. mixed: with old samples; None: it is `image`, without the light layer."""
        from lensbench.rendering.temporal_reuse import Reusable

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
