"""Cache warm-up of a first command: a second process compiles the scene's kernels beside this one.

Numba compiles one function at a time in a process. This process reaches the scene's kernels last, so the helper
begins with the last of them and leaves them in the common cache. Then it traces the small lights of the scene. The
window has its own processes for that (`compilers`).

The helper is `python -m lensbench.app.workers.warm_cache SCENE`.
"""

import gc
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from lensbench.app.bench.camera_kinds import camera
from lensbench.app.scenes.scene_file import cached_scene, find_scene
from lensbench.app.settings.settings import Settings
from lensbench.core.kernels.program import is_stage_compiled, stage_address
from lensbench.core.rendering.progressive import Rendering
from lensbench.core.scenery.small_lights import small_lights


@contextmanager
def compiling_ahead(scene: str) -> Iterator[subprocess.Popen | None]:
    """The helper, started if a kernel of the scene is not compiled; it ends with the block at the latest.

    What it has compiled by then is kept. If it fails, this process compiles the kernels itself.
    """
    helper = _helper(scene)
    try:
        yield helper
    finally:
        if helper is not None:
            helper.terminate()
            helper.wait()


def _helper(scene: str) -> subprocess.Popen | None:
    try:
        compiled = all(is_stage_compiled(step.kernel, np.float32) for step in cached_scene(scene).steps())
        return None if compiled else subprocess.Popen(
            [sys.executable, "-m", "lensbench.app.workers.warm_cache", scene],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    except (ValueError, OSError):       # of the scene: the worker reports it; of the process: it is not needed
        return None


def trace_lights(scene: Any) -> None:
    """Trace the small lights of a scene in a small picture, and so compile what that needs."""
    if small_lights(scene.objects):
        Rendering(camera(Settings(lens_model="trace", pixels_x=60, pixels_y=40)), scene).add(2, threads=1)


if __name__ == "__main__":
    gc.disable()                                # an eighth of the time
    scene = find_scene(sys.argv[1])
    for step in reversed(scene.steps()):
        stage_address(step.kernel, np.float32)
    trace_lights(scene)
