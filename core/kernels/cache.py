"""Compiled kernels: the folder that keeps them, those shipped with the package, and the processor they are made for.

Kernels are declared with the `njit` of this module, so that it is imported before any of them. Its import has these
effects on numba:

- Compiled functions of lensbench, and no others, are kept in $XDG_CACHE_HOME/lensbench/kernels, by default
  ~/.cache/lensbench/kernels, or in a temporary folder where that is not writable. The name of a file contains the
  version of the function (`kernel_version`). So an edit compiles anew what it changes and nothing else, and several
  versions of lensbench share what they have in common.
- A file begins with a digest of its name and content. The code of a file runs only if the digest fits, the file and
  the folder belong to this user, and nobody else may write to them; otherwise the kernel is compiled anew.
- No wrapper for C is made of functions of lensbench and numba: a fifth of the time to compile. The types of operators
  between the same kinds of numbers are found once in a process: another tenth.
- All code that this process compiles, other libraries' too, is made for the highest x86-64 level of the processor (v3,
  or v4 with 512-bit registers) instead of its exact model: machine code of one computer then fits another. Numba has
  one setting for the whole process. LENSBENCH_LEVEL names another level, to compile a wheel for. LENSBENCH_NATIVE=1,
  or any value of NUMBA_CPU_NAME or NUMBA_CPU_FEATURES, leaves numba's setting as it is.

A wheel may carry kernels that were compiled where it was built: `shipped/LEVEL.zip` beside this file holds files of the
same names. A shipped kernel whose name does not fit (another source, numba or Python) is not used, and a warning says
so once. Of each function the files used last are kept.
"""

import atexit
import hashlib
import os
import pickle
import platform
import re
import shutil
import tempfile
import time
import warnings
import zipfile
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache, cached_property, partial, wraps
from pathlib import Path
from types import FunctionType
from typing import Any

import numba
import numpy.ma  # noqa: F401  numba asks for it at the first array: two threads at once recursed in numpy's late import
from llvmlite import binding
from numba import njit, types
from numba.core import caching, dispatcher, serialize, sigutils
from numba.core.runtime import rtsys
from numba.core.types import functions

from lensbench.core.kernels.compiled_code import COMPILERS, CodeReducer, digest, signals_held, version

__all__ = ["KernelCache", "NotCompiledError", "folder", "is_compiled", "level", "njit", "resumable", "used"]

KEPT = 200                              # files of one function: signatures, versions, what its closure holds
DAY = 24 * 3600.0                       # s; a file's time of last use is exact to a day
SHIPPED = Path(__file__).parent / "shipped"     # a folder of archives, one for each level; absent in a source tree
LEVELS = {                              # of x86-64: processor features that a level needs, and LLVM's options for it
    "x86-64-v4": ("avx512f avx512bw avx512cd avx512dq avx512vl", "-prefer-256-bit"),    # else LLVM leaves half unused
    "x86-64-v3": ("avx2 bmi bmi2 f16c fma lzcnt movbe", ""),
}
SEAL = hashlib.sha256().digest_size     # bytes in front of a file
_PACKAGE = __name__.split(".")[0]


class NotCompiledError(Exception):
    """A kernel is being compiled, and this thread must not wait for it. resume: what to call then, or None."""

    resume: Callable[[], Any] | None = None


def resumable(change: Callable[..., Any]) -> Callable[..., Any]:
    """Let a `NotCompiledError` of a function carry the call as its `resume`."""
    @wraps(change)
    def tried(*arguments: Any, **named: Any) -> Any:
        try:
            return change(*arguments, **named)
        except NotCompiledError as error:
            error.resume = partial(tried, *arguments, **named)
            raise
    return tried


class KernelCache(caching.FunctionCache):
    """The files of one function: one for each signature, processor and version."""

    def __init__(self, function: FunctionType):
        self._name, self._py_func = repr(function), function
        self._impl = CodeReducer()
        self._cache_path = str(folder)
        self._stem = f"{function.__module__.partition('.')[2]}.{function.__qualname__}".replace("<locals>", "")
        self.enable()

    @cached_property
    def _version(self) -> str:
        return version(self._py_func)       # at the first use, when all that the function calls has been declared

    def path(self, signature: Any, codegen: Any) -> Path:
        """The file for a signature and a processor."""
        return folder / f"{self._stem}-{self._version}-{digest(str(signature), str(codegen.magic_tuple()))}.kernel"

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled kernel, or None; numba's own first fills the tables of its compiler, a quarter of a second."""
        rtsys.initialize(target_context)    # the functions that count references of arrays
        return self._load_overload(sig, target_context)

    def _load_overload(self, sig: Any, target_context: Any) -> Any:
        path = self.path(sig, target_context.codegen())
        used[path.name] = self._py_func, sig
        content = _kept(path) or _shipped(path.name)
        try:
            return self._impl.rebuild(target_context, pickle.loads(content)) if content else None
        except Exception:                   # a class that a signature names has moved since: compile again
            with suppress(OSError):
                path.unlink()
            return None

    def _save_overload(self, sig: Any, data: Any) -> None:
        if not self._impl.check_cachable(data):
            return
        path = self.path(sig, data.codegen)
        temporary = path.with_suffix(f".{os.getpid()}.part")
        with suppress(OSError):             # a full disk, or one that is read only by now: this process has the code
            temporary.touch(0o600)
            temporary.write_bytes(_sealed(path.name, serialize.dumps(self._impl.reduce(data))))
            temporary.replace(path)
            for old in sorted(self._files(), key=_last_use, reverse=True)[KEPT:]:
                old.unlink(missing_ok=True)

    def _files(self) -> Iterator[Path]:
        return folder.glob(f"{self._stem}-*.kernel")

    def flush(self) -> None:
        """Remove the files of this function."""
        for path in self._files():
            path.unlink(missing_ok=True)


def _sealed(name: str, content: bytes) -> bytes:
    """What a file holds: the digest of its name and content, and the content."""
    return hashlib.sha256(name.encode() + content).digest() + content


def _unsealed(name: str, file: bytes) -> memoryview | None:
    """Content of a file; None where the file is damaged, or holds the kernel of another name."""
    content = memoryview(file)[SEAL:]
    computed = hashlib.sha256(name.encode())
    computed.update(content)
    return content if computed.digest() == file[:SEAL] else None


def _is_private(status: os.stat_result) -> bool:
    """Whether a file or folder belongs to this user, and nobody else may write to it."""
    return not hasattr(os, "getuid") or status.st_uid == os.getuid() and not status.st_mode & 0o022


def _kept(path: Path) -> memoryview | None:
    """Content of a file of the folder, which counts as used now; None where there is none.

    A file that is damaged, or that another user may have written, is removed.
    """
    try:
        with path.open("rb") as file:
            status = os.fstat(file.fileno())
            content = _unsealed(path.name, file.read()) if _is_private(status) else None
        if content is None:
            path.unlink()
        elif time.time() - status.st_mtime > DAY:
            os.utime(path)
        return content
    except OSError:
        return None


@cache
def _archive() -> zipfile.ZipFile | None:
    """The kernels shipped for this processor."""
    try:
        return zipfile.ZipFile(SHIPPED / f"{level}.zip") if level else None
    except FileNotFoundError:
        return None
    except Exception:                       # of any kind: the directory of a damaged archive holds any numbers
        _warn_of_damage()
        return None


@cache
def _shipped_names() -> dict[str, set[str]]:
    """Names of the shipped kernels by function and version; only read, for threads ask without a lock."""
    archive = _archive()
    names: dict[str, set[str]] = {}
    for name in archive.namelist() if archive else ():
        names.setdefault(name.rpartition("-")[0], set()).add(name)
    return names


def _shipped(name: str) -> memoryview | None:
    """Content of a shipped kernel; None, with a warning the first time, where it is damaged or of another version."""
    archive, kernel = _archive(), name.rpartition("-")[0]
    if archive is None:
        return None
    if name in _shipped_names().get(kernel, ()):
        with suppress(Exception):           # of any kind, as in `_archive`
            content = _unsealed(name, archive.read(name))
            if content is not None:
                return content
        _warn_of_damage()
    elif kernel not in _shipped_names() and any(
            other.rpartition("-")[0] == kernel.rpartition("-")[0] for other in _shipped_names()):
        _warn_of_other_versions()
    return None


@cache
def _warn_of_damage() -> None:
    warnings.warn("kernels shipped with lensbench are damaged and are compiled anew, which takes longer: install "
                  "lensbench again", stacklevel=1)


@cache
def _warn_of_other_versions() -> None:
    warnings.warn(f"the kernels shipped with lensbench were compiled from other sources, or with another numba or "
                  f"Python than {COMPILERS}: they are not used, and compiling takes longer", stacklevel=1)


def is_compiled(kernel: Any, signature: Any) -> bool:
    """Whether a kernel need not be compiled for this signature, or for these types of arguments.

    This process, the folder or the package has it then.
    """
    arguments, _ = sigutils.normalize_signature(signature)
    return tuple(arguments) in kernel.overloads or _is_stored(kernel, signature)


def _is_stored(kernel: Any, signature: Any) -> bool:
    """Whether the folder or the package has a kernel.

    Threads ask without numba's lock, so this calls no function of numba that fills its tables.
    """
    path = kernel._cache.path(signature, kernel.targetctx.codegen())
    return path.exists() or path.name in _shipped_names().get(path.name.rpartition("-")[0], ())


def _compile(kernel: Any, signature: Any) -> Any:
    """`Dispatcher.compile`, which first asks `missing`, before it takes numba's lock."""
    if missing is not None and isinstance(kernel._cache, KernelCache):
        arguments, _ = sigutils.normalize_signature(signature)
        if tuple(arguments) not in kernel.overloads:
            if not _is_stored(kernel, signature):
                missing(kernel.py_func, signature)
    with signals_held():
        return _numba_compile(kernel, signature)


def _without_c_wrapper(compiler: Any, flags: Any) -> Any:
    """The options of a compilation, without the wrapper that functions handed on as values would need."""
    if compiler.py_func.__module__.split(".")[0] in (_PACKAGE, "numba"):
        flags.no_cfunc_wrapper = True
    return flags


def _call_type(function: Any, context: Any, arguments: Any, named: Any) -> Any:
    """`BaseFunction.get_call_type`, which remembers what it found for numbers: it tries all of numpy's functions."""
    if named or not all(isinstance(argument, types.Number | types.Boolean) for argument in arguments):
        return _numba_call_type(function, context, arguments, named)
    known = vars(function).setdefault("_lensbench_known", {})
    if arguments not in known:
        known[arguments] = _numba_call_type(function, context, arguments, named)
    return known[arguments]


def _last_use(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:                         # another process has removed it
        return 0.0


def _open_folder() -> Path:
    """The folder of kernels; those of versions before 2026-11 are removed unless used within a day."""
    refused = ""
    try:
        home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "lensbench"
        kernels = home / "kernels"
        home.mkdir(parents=True, exist_ok=True)
        kernels.mkdir(0o700, exist_ok=True)
        if not _is_private(kernels.stat()):
            refused = f"{kernels} belongs to another user, or others may write to it"
        else:
            tempfile.TemporaryFile(dir=kernels).close()
    except (OSError, RuntimeError) as error:
        refused = f"kernels cannot be kept ({error})"
    if refused:
        warnings.warn(f"{refused}: this process compiles its kernels anew in a temporary folder; remove that folder, "
                      f"or let XDG_CACHE_HOME name one that is yours alone", stacklevel=1)
        kernels = Path(tempfile.mkdtemp(prefix="lensbench-"))
        atexit.register(shutil.rmtree, kernels, ignore_errors=True)
        return kernels
    with suppress(OSError):
        for leftover in kernels.glob("*.part"):             # of a process that was ended while it wrote
            if time.time() - _last_use(leftover) > DAY:
                leftover.unlink(missing_ok=True)
        for old in home.iterdir():
            if re.fullmatch("[0-9a-f]{16}", old.name) and time.time() - _last_use(old) > DAY:
                shutil.rmtree(old, ignore_errors=True)
    return kernels


def _cache_of(function: FunctionType) -> caching.FunctionCache:
    """The cache of a function that is declared with cache=True."""
    if function.__module__.split(".")[0] == _PACKAGE:
        return KernelCache(function)
    return caching.FunctionCache(function)


def _choose_level() -> str:
    """Let numba compile for the highest level of x86-64 of this processor, and return it; "" leaves it as it is."""
    if (os.environ.get("LENSBENCH_NATIVE", "0") != "0" or numba.config.CPU_NAME is not None
            or numba.config.CPU_FEATURES is not None or platform.machine().lower() not in ("x86_64", "amd64")):
        return ""
    features, asked = binding.get_host_cpu_features(), os.environ.get("LENSBENCH_LEVEL")
    for name, (needed, options) in LEVELS.items():
        if name == asked or not asked and all(features.get(feature) for feature in needed.split()):
            numba.config.CPU_NAME, numba.config.CPU_FEATURES = name, options
            return name
    return ""


folder = _open_folder()
level = _choose_level()                 # of x86-64 that kernels are compiled for; "" for this very processor
used: dict[str, tuple[FunctionType, Any]] = {}      # file names asked for by this process: function and signature
dispatcher.FunctionCache = _cache_of
missing: Callable[[FunctionType, Any], None] | None = None
"""Called with a function and a signature before this process compiles them.

It returns when another process has done so, or for this one to compile; or it raises `NotCompiledError`.
"""
_numba_compile = dispatcher.Dispatcher.compile
dispatcher.Dispatcher.compile = _compile
dispatcher._FunctionCompiler._customize_flags = _without_c_wrapper
_numba_call_type = functions.BaseFunction.get_call_type
functions.BaseFunction.get_call_type = _call_type
