"""The first start ever: a second process compiles the scene's kernels while this one compiles the camera's.

Numba compiles one function at a time in a process. The scene's kernels are met
last, so the helper begins at their end and leaves them in the common cache,
where this process finds them. `python -m lensbench.app.ahead SCENE` is the helper.
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


def compile_ahead(scene: str) -> None:
    """Start the helper where it is of use; what goes wrong in it, this process does itself."""
    if cold():
        with suppress(OSError):
            subprocess.Popen([sys.executable, "-m", "lensbench.app.ahead", scene],
                             stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


if __name__ == "__main__":
    from lensbench.app.scene_file import find_scene
    from lensbench.driver import stage_address
    from lensbench.splats import STAGES, small_lights

    scene = find_scene(sys.argv[1])
    kernels = [step.kernel for step in scene.steps()]
    for kernel in [*reversed(kernels), *(STAGES if small_lights(scene) else ())]:
        stage_address(kernel, np.float32)
