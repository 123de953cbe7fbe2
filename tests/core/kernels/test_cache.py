"""The files of compiled kernels: found again where nothing that matters has changed, and lensbench's alone."""

import functools
import json
import os
import subprocess
import sys
import time
import warnings
import zipfile
from random import Random
from types import FunctionType, SimpleNamespace

import pytest
from numba import int64, njit, void

from lensbench.core.kernels import cache, compiled_code

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
from lensbench.core.kernels import sampling
import others_kernel
print(json.dumps({"before": before, "after": (numba.config.CACHE_DIR, numba.config.CPU_FEATURES),
                  "ours": sampling.sobol._cache.cache_path, "theirs": others_kernel.double._cache.cache_path}))
"""
SOURCE = '''
from numba import njit
import numpy as np

SCALE = 2.0
TABLE = np.arange(3.0)

@njit
def inner(x):
    """Inner."""
    return x + SCALE

@njit(fastmath={"contract", "nsz"})
def middle(x):
    return inner(x) * TABLE[1]

@njit(nogil=True)
def kernel(x):
    """Kernel."""
    return middle(x)

def other(x):
    return x
'''


def version(source=SOURCE):
    """Version of `kernel` in this source."""
    names = {"__name__": "source"}
    exec(source, names)
    return compiled_code.version(names["kernel"].py_func)


@pytest.mark.parametrize("edit", [
    ("x + SCALE", "x - SCALE"), ("SCALE = 2.0", "SCALE = 3.0"), ("arange(3.0)", "arange(4.0)"),
    ("TABLE[1]", "TABLE[2]"), ('"nsz"', '"arcp"'), ("return middle(x)", "return inner(x)"),
    ("nogil=True", "nogil=False"),
])
def test_a_version_changes_with_what_the_function_calls_and_reads(edit):
    assert version(SOURCE.replace(*edit)) != version()


@pytest.mark.parametrize("edit", [
    ("return x\n", "return 2 * x\n"), ('"""Inner."""', '"""Another text."""'), ('"""Kernel."""', '"""Text."""'),
    ("SCALE = 2.0", "\n\n# A comment\nSCALE = 2.0"), ('{"contract", "nsz"}', '{"nsz", "contract"}'),
])
def test_a_version_stays_where_the_code_is_the_same(edit):
    assert version(SOURCE.replace(*edit)) == version()


def test_a_version_changes_with_the_compiler(monkeypatch):
    before = version()
    monkeypatch.setattr(compiled_code, "COMPILERS", "another numba")
    assert version() != before


@pytest.mark.slow
def test_every_version_of_the_package_is_the_same_in_another_process():
    """Sets, addresses and the order of imports differ from process to process."""
    script = """
import json, sys
from lensbench import *
from numba.core.dispatcher import Dispatcher
from lensbench.core.kernels.cache import KernelCache
from lensbench.core.kernels.compiled_code import version
found = {}
for name, module in sorted(sys.modules.items()):
    if name.startswith("lensbench"):
        for value in vars(module).values():
            if isinstance(value, Dispatcher) and isinstance(value._cache, KernelCache):
                found[value._cache._stem] = version(value.py_func)
print(json.dumps(found))
"""
    reports = [json.loads(subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True,
                                         env={**os.environ, "PYTHONHASHSEED": seed}).stdout) for seed in ("1", "2")]
    assert len(reports[0]) > 100 and reports[0] == reports[1]


@pytest.fixture
def kept(tmp_path, monkeypatch):
    """A folder of kernels, and a function that declares the same kernel anew."""
    monkeypatch.setattr(cache, "folder", tmp_path)

    def add(x):
        return x + 1

    def declared():
        kernel = njit(FunctionType(add.__code__, {"__name__": __name__}, "add"))
        kernel._cache = cache.KernelCache(kernel.py_func)
        return kernel

    return SimpleNamespace(folder=tmp_path, declared=declared)


def counts(kernel):
    """Files loaded from the cache, and signatures compiled."""
    return sum(kernel.stats.cache_hits.values()), sum(kernel.stats.cache_misses.values())


def test_a_kernel_is_loaded_where_it_was_compiled_before(kept):
    first = kept.declared()
    assert first(1) == 2 and counts(first) == (0, 1)
    second = kept.declared()
    assert second(1) == 2 and counts(second) == (1, 0)


def test_a_file_holds_no_source_and_names_no_folder_of_the_machine_that_compiled_it(kept):
    kept.declared()(1)
    file, = kept.folder.iterdir()
    assert b"# File:" not in file.read_bytes() and os.fsencode(os.path.dirname(__file__)) not in file.read_bytes()


def damaged(content, random):
    """A file with one bit changed, in every third cut short, or with a stretch that another one has overwritten."""
    kind, i = random.randrange(3), random.randrange(len(content))
    if kind == 0:
        return content[:i]
    if kind == 1:
        return content[:i] + bytes([content[i] ^ 1 << random.randrange(8)]) + content[i + 1:]
    j = min(i + 16, len(content))
    return content[:i] + bytes(byte ^ 0x5a for byte in content[i:j]) + content[j:]


@pytest.mark.parametrize("seed", range(60))
def test_no_byte_of_a_damaged_file_is_used(kept, seed, monkeypatch):
    """Neither unpickled nor linked: machine code with a wrong bit would end the process, or give other numbers."""
    kept.declared()(1)
    file, = kept.folder.iterdir()
    file.write_bytes(damaged(file.read_bytes(), Random(seed)))
    monkeypatch.setattr(cache.pickle, "loads", lambda content: pytest.fail("a damaged file was unpickled"))
    again = kept.declared()
    assert again(1) == 2 and counts(again) == (0, 1)


@pytest.mark.parametrize("damage", ["empty", "pickle", "of another kernel", "writable by others"])
def test_a_file_that_cannot_be_trusted_is_replaced(kept, damage):
    kept.declared()(1.0)
    other, = kept.folder.iterdir()
    kept.declared()(1)
    file, = set(kept.folder.iterdir()) - {other}
    if damage == "writable by others":
        file.chmod(0o666)
    else:
        file.write_bytes({"empty": b"", "pickle": b"\x80\x05X\xff\xff\xff\xff"}.get(damage, other.read_bytes()))
    again = kept.declared()
    assert again(1) == 2 and counts(again) == (0, 1)
    third = kept.declared()
    assert third(1) == 2 and counts(third) == (1, 0)


def test_the_files_of_a_function_that_were_used_last_are_kept(kept):
    first = kept.declared()
    for i in range(cache.KEPT + 3):
        path = kept.folder / f"{first._cache._stem}-{i:016x}.kernel"
        path.touch()
        os.utime(path, (time.time() - i * DAY - DAY,) * 2)
    first(1)
    left = {path.name[-23:-7] for path in kept.folder.iterdir()}
    assert len(left) == cache.KEPT and {f"{i:016x}" for i in range(cache.KEPT - 1)} < left


def test_loading_a_kernel_marks_its_file_as_used(kept):
    kept.declared()(1)
    file, = kept.folder.iterdir()
    os.utime(file, (time.time() - 5 * DAY,) * 2)
    kept.declared()(1)
    assert time.time() - file.stat().st_mtime < DAY


@pytest.fixture
def shipped(kept, monkeypatch):
    """The kernel of `kept` in an archive of this level, and no file of it in the folder."""
    kept.declared()(1)
    file, = kept.folder.iterdir()
    archive = kept.folder / "shipped" / "some-level.zip"
    archive.parent.mkdir()
    with zipfile.ZipFile(archive, "w") as packed:
        packed.write(file, file.name)
    file.unlink()
    monkeypatch.setattr(cache, "SHIPPED", archive.parent)
    monkeypatch.setattr(cache, "level", "some-level")
    for cached in (cache._archive, cache._shipped_names, cache._warn_of_other_versions, cache._warn_of_damage):
        monkeypatch.setattr(cache, cached.__name__, functools.cache(cached.__wrapped__))
    return SimpleNamespace(archive=archive, name=file.name, **vars(kept))


def files(folder):
    return [path.name for path in folder.iterdir() if path.suffix == ".kernel"]


def test_a_shipped_kernel_is_loaded_and_not_compiled(shipped):
    kernel = shipped.declared()
    assert cache.is_compiled(kernel, void(int64)) is False
    assert kernel(1) == 2 and counts(kernel) == (1, 0) and not files(shipped.folder)


def test_a_shipped_kernel_for_another_signature_is_compiled_without_a_word(shipped):
    kernel = shipped.declared()
    assert kernel(1.0) == 2.0 and counts(kernel) == (0, 1) and len(files(shipped.folder)) == 1


def test_a_shipped_kernel_of_another_source_is_refused_with_a_warning(shipped, monkeypatch):
    monkeypatch.setattr(compiled_code, "COMPILERS", "another numba")
    with pytest.warns(UserWarning, match="compiled from other sources, or with another numba"):
        kernel = shipped.declared()
        assert kernel(1) == 2 and counts(kernel) == (0, 1)
    again = shipped.declared()              # warns once
    assert again(1.0) == 2.0


def test_asking_for_a_kernel_leaves_the_names_of_the_shipped_ones_as_they_are(shipped, monkeypatch):
    """Threads ask without a lock, while another one goes through the names."""
    names = {**cache._shipped_names()}
    monkeypatch.setattr(compiled_code, "COMPILERS", "another numba")
    assert not cache.is_compiled(shipped.declared(), void(int64))
    assert cache._shipped_names() == names


@pytest.mark.parametrize("damage", ["archive", "kernel", "compressed"])
def test_damaged_shipped_kernels_are_compiled_again(shipped, damage):
    if damage == "archive":
        shipped.archive.write_bytes(b"no archive")
    else:
        with zipfile.ZipFile(shipped.archive, "w", zipfile.ZIP_DEFLATED) as packed:
            packed.writestr(shipped.name, b"no kernel" * 100)
            start = packed.getinfo(shipped.name).header_offset + 30 + len(shipped.name)
    if damage == "compressed":
        content = bytearray(shipped.archive.read_bytes())
        content[start] = 0xff               # a kind of block that does not exist
        shipped.archive.write_bytes(content)
    kernel = shipped.declared()
    with pytest.warns(UserWarning, match="shipped with lensbench are damaged"):
        assert kernel(1) == 2 and counts(kernel) == (0, 1)
    assert files(shipped.folder) == [shipped.name]


@pytest.mark.parametrize("seed", range(20))
def test_a_damaged_archive_gives_a_whole_kernel_or_none(shipped, seed):
    shipped.archive.write_bytes(damaged(shipped.archive.read_bytes(), Random(seed)))
    kernel = shipped.declared()
    with warnings.catch_warnings(record=True):
        warnings.simplefilter("always")
        assert kernel(1) == 2


@pytest.mark.slow
def test_a_level_is_compiled_for_only_where_the_processor_has_it():
    script = "from lensbench.core.kernels import cache; import numba; print(cache.level, numba.config.CPU_NAME)"

    def chosen(**variables):
        return subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True,
                              env={**os.environ, **variables}).stdout.split()

    features = cache.binding.get_host_cpu_features()
    fitting = [name for name, (needed, _) in cache.LEVELS.items() if all(features[each] for each in needed.split())]
    assert chosen()[:1] == fitting[:1] or not fitting
    assert chosen(LENSBENCH_LEVEL="x86-64-v4") == ["x86-64-v4", "x86-64-v4"]
    assert chosen(LENSBENCH_NATIVE="1") == ["None"]


@pytest.fixture(scope="module")
def imported(tmp_path_factory):
    """What a process reports that imports lensbench beside another library, with cache folders of older versions."""
    home, elsewhere = (tmp_path_factory.mktemp(name) for name in ("cache", "elsewhere"))
    (elsewhere / "others_kernel.py").write_text(OTHERS_KERNEL)
    for name, age in ((16 * "a", 2 * DAY), (16 * "b", 0.5 * DAY), ("notes", 2 * DAY)):
        (home / "lensbench" / name).mkdir(parents=True)
        os.utime(home / "lensbench" / name, (time.time() - age,) * 2)
    done = subprocess.run([sys.executable, "-c", IMPORT], capture_output=True, text=True, check=True,
                          env={**os.environ, "XDG_CACHE_HOME": str(home), "PYTHONPATH": str(elsewhere),
                               "LENSBENCH_NATIVE": "1"})
    return json.loads(done.stdout), home / "lensbench"


def test_only_kernels_of_lensbench_are_cached_in_its_folder(imported):
    report, home = imported
    assert report["ours"] == str(home / "kernels") and not report["theirs"].startswith(str(home))


def test_numbas_configuration_stays_as_it_was_where_the_user_asks_for_it(imported):
    report, _ = imported
    assert report["after"] == report["before"]


def test_folders_of_older_versions_are_removed_a_day_after_their_last_use(imported):
    _, home = imported
    assert {path.name for path in home.iterdir()} == {16 * "b", "kernels", "notes"}


def opened(home):
    """What a process reports that imports the cache with this home of caches: its folder, and its warnings."""
    done = subprocess.run([sys.executable, "-c", "from lensbench.core.kernels import cache; "
                           "print(cache.folder.is_dir(), cache.folder)"], capture_output=True, text=True, check=True,
                          env={**os.environ, "XDG_CACHE_HOME": str(home)})
    there, folder = done.stdout.split()
    assert there == "True"
    return folder, done.stderr


def test_a_folder_that_cannot_be_written_is_replaced_by_a_temporary_one(tmp_path):
    (tmp_path / "file").touch()
    folder, said = opened(tmp_path / "file")
    assert not folder.startswith(str(tmp_path)) and not os.path.exists(folder) and "kernels cannot be kept" in said


@pytest.mark.parametrize("mode", [0o777, 0o770, 0o757])
def test_a_folder_that_others_may_write_to_is_refused(tmp_path, mode):
    kernels = tmp_path / "lensbench" / "kernels"
    kernels.mkdir(parents=True)
    kernels.chmod(mode)
    folder, said = opened(tmp_path)
    assert not folder.startswith(str(tmp_path)) and not list(kernels.iterdir())
    assert f"{kernels} belongs to another user, or others may write to it" in said


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can give a folder away")
def test_a_folder_of_another_user_is_refused(tmp_path):
    kernels = tmp_path / "lensbench" / "kernels"
    kernels.mkdir(parents=True)
    os.chown(kernels, 12345, 12345)
    folder, said = opened(tmp_path)
    assert not folder.startswith(str(tmp_path)) and "belongs to another user" in said


def test_the_folder_that_is_made_is_accepted_whatever_the_mask_of_new_files(tmp_path):
    before = os.umask(0)
    try:
        folders = [opened(tmp_path) for _ in range(2)]
    finally:
        os.umask(before)
    assert folders == [(str(tmp_path / "lensbench" / "kernels"), "")] * 2


LOAD = """
import sys
import numpy as np
from numba import njit
from lensbench.core.optics.surfaces import sags, shape
print(sags(*shape(0.02, -1.0, [], None, 10.0), [3.0], [4.0]))
print("numba.typed.typedlist" in sys.modules)

@njit
def lengths(points):
    lengths = [np.sqrt(x * x + y * y) for x, y in points]
    return np.array(lengths)

print(lengths(np.array([[3.0, 4.0]])))
"""


@pytest.mark.slow
def test_a_stored_kernel_is_loaded_without_the_tables_of_the_compiler_which_are_there_when_one_is_compiled(tmp_path):
    reports = [subprocess.run([sys.executable, "-c", LOAD], capture_output=True, text=True, check=True,
                              env=os.environ | {"XDG_CACHE_HOME": str(tmp_path)}).stdout.splitlines()
               for _ in range(2)]
    assert reports[0] == ["[0.25]", "True", "[5.]"]
    assert reports[1] == ["[0.25]", "False", "[5.]"]


PICTURE = """
import hashlib
import lensbench as lb
camera = lb.PerspectiveCamera(lb.Film(36.0, 24.0, 24, 16))
print(hashlib.sha256(lb.render(camera, lb.builtin_scene("still-life"), samples=1).tobytes()).hexdigest())
"""


@pytest.mark.slow
@pytest.mark.long
def test_a_picture_is_the_same_after_sixty_kernels_were_damaged(tmp_path):
    random = Random(39)

    def picture():
        done = subprocess.run([sys.executable, "-c", PICTURE], capture_output=True, text=True,
                              env=os.environ | {"XDG_CACHE_HOME": str(tmp_path)})
        return done.returncode, done.stdout, done.stderr

    first = picture()
    assert first[0] == 0
    for _ in range(6):
        for file in random.sample(sorted((tmp_path / "lensbench" / "kernels").glob("*.kernel")), 10):
            file.write_bytes(damaged(file.read_bytes(), random))
        assert picture() == first
