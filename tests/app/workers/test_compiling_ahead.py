"""The helper of the first start: it leaves compiled kernels where this process finds them."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from lensbench.app.workers import compilers

HELPER = compilers._helper             # the real one, which the other tests do without


def run(arguments: list[str], cache: Path) -> str:
    done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=True,
                          env={**os.environ, "XDG_CACHE_HOME": str(cache)})
    return done.stdout


ASK = """
import numpy as np
from lensbench.app.scenes.scene_file import find_scene
from lensbench.core.kernels.program import is_stage_compiled
print([is_stage_compiled(step.kernel, np.float32) for step in find_scene("white-wall").steps()])
"""


@pytest.mark.slow
def test_the_helper_compiles_the_scenes_kernels_into_the_common_cache(tmp_path):
    assert "True" not in run(["-c", ASK], tmp_path)
    run(["-m", "lensbench.app.workers.compilers", "white-wall"], tmp_path)
    assert "False" not in run(["-c", ASK], tmp_path)


def test_the_helper_ends_with_what_it_helps(monkeypatch):
    monkeypatch.setattr(compilers, "_helper", HELPER)
    monkeypatch.setattr(compilers, "is_stage_compiled", lambda kernel, real: False)
    with compilers.compiling_ahead("white-wall") as helper:
        assert helper.poll() is None
    assert helper.returncode == -signal.SIGTERM
