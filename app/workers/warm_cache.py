"""Cache warm-up at the very first start: a second process compiles the scene's kernels beside this one.

Numba compiles one function at a time in a process. This process reaches the scene's kernels last, so the helper
begins with the last of them and leaves them in the common cache. Then it renders a picture with light tracing, which
the first picture leaves out so that it need not wait for those kernels.

The helper is `python -m lensbench.app.workers.warm_cache SCENE`.
"""

import subprocess
import sys
from contextlib import suppress

import numpy as np

from lensbench.kernels import cache


def cold() -> bool:
    """Whether nothing has been compiled yet for this version of the core."""
    return not any(cache.folder.rglob("*.nbi"))


def compile_ahead(scene: str) -> subprocess.Popen | None:
    """The helper, started if nothing is compiled yet. If it fails, this process compiles the kernels itself."""
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
        Rendering(camera(Settings(lens_model="trace", pixels_x=60, pixels_y=40)), scene).add(2, threads=1)
