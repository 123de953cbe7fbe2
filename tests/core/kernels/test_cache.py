"""The folder of compiled kernels: lensbench's alone, and never removed under a process that uses it."""

import json
import os
import subprocess
import sys
import time

import pytest

from lensbench.kernels import cache

DAY = 24 * 3600.0
OTHERS_KERNEL = """
from numba import njit

@njit(cache=True)
def double(x):
    return 2 * x
"""
IMPORT = """
import json, sys
import numba
before = numba.config.CACHE_DIR, numba.config.CPU_FEATURES
import lensbench
from lensbench.kernels import sampling
import others_kernel
print(json.dumps({"before": before, "after": (numba.config.CACHE_DIR, numba.config.CPU_FEATURES),
                  "ours": sampling.sobol._cache.cache_path, "theirs": others_kernel.double._cache.cache_path}))
"""


def folder(home, letter, age):
    """A cache folder that was last used `age` seconds ago."""
    path = home / (16 * letter)
    (path / "kernels").mkdir(parents=True)
    for each in (path / "kernels", path):
        os.utime(each, (time.time() - age,) * 2)
    return path


@pytest.fixture(scope="module")
def imported(tmp_path_factory):
    """What a process reports that imports lensbench beside another library, with cache folders of older versions."""
    home, elsewhere = (tmp_path_factory.mktemp(name) for name in ("cache", "elsewhere"))
    (elsewhere / "others_kernel.py").write_text(OTHERS_KERNEL)
    old = {letter: folder(home / "lensbench", letter, age)
           for letter, age in (("a", 2 * DAY), ("b", 3 * DAY), ("c", 4 * DAY), ("d", 5 * DAY), ("e", 0.5 * DAY))}
    with cache.hold(old["d"]) as stamp:
        os.utime(stamp.name, (time.time() - 5 * DAY,) * 2)       # a process that has run for five days
        os.utime(old["d"], (time.time() - 5 * DAY,) * 2)
        done = subprocess.run([sys.executable, "-c", IMPORT], capture_output=True, text=True, check=True,
                              env={**os.environ, "XDG_CACHE_HOME": str(home), "PYTHONPATH": str(elsewhere),
                                   "LENSBENCH_WIDE_REGISTERS": "0"})
    return json.loads(done.stdout), home / "lensbench", old


def test_only_kernels_of_lensbench_are_cached_in_its_folder(imported):
    report, home, _ = imported
    assert report["ours"].startswith(str(home)) and not report["theirs"].startswith(str(home))


def test_numbas_configuration_stays_as_it_was_where_the_user_asks_for_it(imported):
    report, _, _ = imported
    assert report["after"] == report["before"]


def test_an_import_keeps_two_folders_and_those_recent_or_in_use(imported):
    _, home, old = imported
    left = {path.name[0] for path in home.iterdir() if path in old.values()}
    assert left == {"e", "d"}           # the last one used, half a day ago; the one that a process holds
    assert len(list(home.iterdir())) == 3


def test_a_folder_is_removed_once_no_process_holds_it(tmp_path):
    current = folder(tmp_path, "f", 0.0)
    used_last, old = folder(tmp_path, "a", 2 * DAY), folder(tmp_path, "b", 3 * DAY)
    stranger = tmp_path / "notes"
    stranger.mkdir()
    stamp = cache.hold(old)
    for each in (stamp.name, old):
        os.utime(each, (time.time() - 3 * DAY,) * 2)
    cache.remove_old_folders(tmp_path, current)
    assert old.exists()
    stamp.close()
    cache.remove_old_folders(tmp_path, current)
    assert not old.exists() and used_last.exists() and current.exists() and stranger.exists()
