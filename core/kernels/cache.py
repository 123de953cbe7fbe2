"""The folder of compiled kernels, and the processor features that kernels are compiled for.

`lensbench/__init__.py` imports this module before any kernel is declared. It has two effects on numba:

- Compiled functions of lensbench, and no others, go to a folder named by a hash of the core's sources. Numba notices
  an edit to the file of a function, but neither to what that function calls nor to constants from other files. The
  folder lies in $XDG_CACHE_HOME/lensbench, by default ~/.cache/lensbench, or in a temporary folder where that is not
  writable. The user's variable NUMBA_CACHE_LOCATOR_CLASSES takes precedence.
- On processors with AVX-512 all code that this process compiles, other libraries' too, uses 512-bit registers. LLVM
  prefers 256-bit ones on some processors; lensbench's kernels are a fifth faster with 512. Numba has one setting for
  the whole process. LENSBENCH_WIDE_REGISTERS=0 or any value of NUMBA_CPU_FEATURES leaves it as it is.

Folders of other versions are removed when lensbench is imported, but for the one used last, those used within a day
and those that a running process holds.
"""

import atexit
import hashlib
import os
import re
import shutil
import tempfile
import time
from contextlib import suppress
from pathlib import Path
from typing import IO

import numba
from llvmlite import binding
from numba.core import caching

try:
    import fcntl
except ImportError:                     # Windows: the age alone protects a folder
    fcntl = None                        # type: ignore[assignment]

KEPT = 2                                # folders, the current one included
RECENT = 24 * 3600.0                    # s since the last use; a folder used more recently stays
STAMP = "in-use"                        # file in a cache folder: locked by every process that uses it
_PACKAGE = __name__.split(".")[0]


def source_hash(package: Path) -> str:
    """16 hex digits that change with any source or table of the package."""
    sources = sorted(path for path in package.rglob("*") if path.suffix in (".py", ".npy"))
    return hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()[:16]


def hold(folder: Path) -> IO[bytes]:
    """A file that marks the folder as used now, and as in use until the file is closed."""
    stamp = (folder / STAMP).open("ab")
    os.utime(stamp.fileno() if os.utime in os.supports_fd else folder / STAMP)
    if fcntl is not None:
        with suppress(OSError):         # a file system without locks: the age alone protects the folder
            fcntl.flock(stamp, fcntl.LOCK_SH | fcntl.LOCK_NB)
    return stamp


def remove_old_folders(home: Path, current: Path) -> None:
    """Remove cache folders in `home`: all but the current one, the one used last, recent ones and those in use."""
    others = [path for path in home.iterdir()
              if path != current and path.is_dir() and re.fullmatch("[0-9a-f]{16}", path.name)]
    others.sort(key=_last_use, reverse=True)
    for folder in others[KEPT - 1:]:
        if time.time() - _last_use(folder) > RECENT and not _in_use(folder):
            shutil.rmtree(folder, ignore_errors=True)


def _last_use(folder: Path) -> float:
    """Seconds since the epoch; folders of versions without a stamp count by their last change."""
    with suppress(OSError):
        return max(path.stat().st_mtime for path in (folder, *folder.iterdir()))
    return 0.0


def _in_use(folder: Path) -> bool:
    """Whether another process holds the folder."""
    if fcntl is None:
        return False
    try:
        with (folder / STAMP).open("rb") as stamp:
            fcntl.flock(stamp, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except FileNotFoundError:
        return False
    except OSError:
        return True
    return False


def _open_folder() -> tuple[Path, IO[bytes] | None]:
    """The folder of this version's kernels, and the stamp that holds it."""
    try:
        home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "lensbench"
        folder = home / source_hash(Path(__file__).parent.parent)
        folder.mkdir(parents=True, exist_ok=True)
        stamp = hold(folder)
    except (OSError, RuntimeError):
        temporary = tempfile.mkdtemp(prefix="lensbench-")
        atexit.register(shutil.rmtree, temporary, ignore_errors=True)
        return Path(temporary), None
    with suppress(OSError):
        remove_old_folders(home, folder)
    return folder, stamp


class KernelLocator(caching._SourceFileBackedLocatorMixin, caching._CacheLocator):
    """Directs numba to the cache folder for functions of lensbench, and for no others."""

    def __init__(self, py_func, py_file):
        self._py_file = py_file
        self._lineno = py_func.__code__.co_firstlineno

    def get_cache_path(self) -> str:
        """The folder of all functions of one source folder."""
        return str(folder / self.get_suitable_cache_subpath(self._py_file))

    @classmethod
    def from_function(cls, py_func, py_file):
        """A locator for this function, or None where it is another library's."""
        if py_func.__module__.split(".")[0] != _PACKAGE:
            return None
        return super().from_function(py_func, py_file)


def _prefer_wide_registers() -> None:
    """Let LLVM use 512-bit registers where the processor has them and the user has not said otherwise."""
    features = binding.get_host_cpu_features()
    if (features.get("avx512f") and numba.config.CPU_FEATURES is None
            and os.environ.get("LENSBENCH_WIDE_REGISTERS", "1") != "0"):
        numba.config.CPU_FEATURES = features.flatten() + ",-prefer-256-bit"


folder, _stamp = _open_folder()         # the stamp stays open, and the folder in use, as long as the process runs
caching.FunctionCache._impl_class._locator_classes.insert(0, KernelLocator)
_prefer_wide_registers()
