"""The list of a first picture's kernels is that of the kernels it asks for, no more and no less."""

import subprocess
import sys

import pytest

ASKED = """
import sys
from dataclasses import replace
from time import sleep
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.compilers import _needed
from lensbench.app.workers.render_worker import RenderWorker
from lensbench.core.kernels import cache

settings = replace(Settings(pixels_x=48, pixels_y=32, samples=1), scene=sys.argv[1], lens_model=sys.argv[2])
listed = {kernel._cache.path(signature, kernel.targetctx.codegen()).name for kernel, signature in _needed(settings)}
worker = RenderWorker(settings, threads=1)
while worker.newest() is None and worker.error is None:
    sleep(0.001)
asked = set(cache.used)
worker.stop()
print("not listed", sorted(asked - listed))
print("not asked for", sorted(listed - asked))
"""


@pytest.mark.parametrize(("scene", "model"), [("still-life", "auto"), ("night-lights", "trace")])
def test_the_kernels_of_a_first_picture_are_known_beforehand(scene, model):
    for _ in range(2):              # a process that compiles kernels asks for those that they call, too
        done = subprocess.run([sys.executable, "-c", ASKED, scene, model], capture_output=True, text=True, check=True)
        if (last_lines := done.stdout.splitlines()[-2:]) == ["not listed []", "not asked for []"]:
            break
    assert last_lines == ["not listed []", "not asked for []"]


KERNELS = """
from lensbench.app.settings.settings import Settings
from lensbench.app.workers.compilers import missing_kernels
print(len(missing_kernels(Settings())), len(missing_kernels(Settings(camera="perspective"))))
"""


def test_in_an_empty_cache_all_are_missing_and_a_camera_without_a_lens_has_none_of_a_lens(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    done = subprocess.run([sys.executable, "-c", KERNELS], capture_output=True, text=True, check=True)
    lens, without = map(int, done.stdout.split())
    assert 10 < without < lens - 10
