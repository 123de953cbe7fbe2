"""The helper of the first start: it leaves compiled kernels where this process finds them."""

import os
import subprocess
import sys
from pathlib import Path

import pytest


def run(arguments: list[str], cache: Path) -> str:
    done = subprocess.run([sys.executable, *arguments], capture_output=True, text=True, check=True,
                          env={**os.environ, "XDG_CACHE_HOME": str(cache)})
    return done.stdout


@pytest.mark.slow
def test_the_helper_compiles_the_scenes_kernels_into_the_common_cache(tmp_path):
    assert "True" in run(["-c", "from lensbench.app.workers.warm_cache import cold; print(cold())"], tmp_path)
    run(["-m", "lensbench.app.workers.warm_cache", "white-wall"], tmp_path)
    kernels = {path.name.split("-")[0].split(".")[-1] for path in tmp_path.rglob("*.nbi")}
    assert {"sky", "daylight"} <= kernels
    assert "False" in run(["-c", "from lensbench.app.workers.warm_cache import cold; print(cold())"], tmp_path)
