"""The first start ever: a second process compiles the scene's kernels while this one compiles the camera's.

Numba compiles one function at a time in a process. The scene's kernels are met
last, so the helper begins at their end and leaves them in the common cache,
where this process finds them. Then it takes a picture of its own with the light of small
lights traced from their side, which the first picture does without: it need not wait for
those kernels. `python -m lensbench.app.workers.warm_cache SCENE` is the helper.
"""

import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import numba
import numpy as np


def cold() -> bool:
    """Whether nothing has been compiled yet for this version of the core."""
    return not any(Path(numba.config.CACHE_DIR).rglob("*.nbi"))


def compile_ahead(scene: str) -> subprocess.Popen | None:
    """The helper, started where it is of use; what goes wrong in it, this process does itself."""
    if cold():
        with suppress(OSError):
            return subprocess.Popen([sys.executable, "-m", "lensbench.app.workers.warm_cache", scene],
                                    stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return None


if __name__ == "__main__":
    from lensbench.app.state.build import camera
    from lensbench.app.state.scene_file import find_scene
    from lensbench.app.state.settings import Settings
    from lensbench.kernels.program import stage_address
    from lensbench.rendering.progressive import Rendering
    from lensbench.scenery.small_lights import small_lights

    scene = find_scene(sys.argv[1])
    for step in reversed(scene.steps()):
        stage_address(step.kernel, np.float32)
    if small_lights(scene.objects):
        Rendering(camera(Settings(model="trace", pixels_x=60, pixels_y=40)), scene).add(2, threads=1)
