"""The folder of compiled kernels, and the processor features that kernels are compiled for.

`lensbench/__init__.py` imports this module before any kernel is declared. It has two effects on numba:

- Compiled functions of lensbench, and no others, are kept in $XDG_CACHE_HOME/lensbench/kernels, by default
  ~/.cache/lensbench/kernels, or in a temporary folder where that is not writable. The name of a file has a hash of the
  function, of all that it calls and of the constants that it reads. So an edit compiles anew what it changes and
  nothing else, and several versions of lensbench share what they have in common.
- On processors with AVX-512 all code that this process compiles, other libraries' too, uses 512-bit registers. LLVM
  prefers 256-bit ones on some processors; lensbench's kernels are a fifth faster with 512. Numba has one setting for
  the whole process. LENSBENCH_WIDE_REGISTERS=0 or any value of NUMBA_CPU_FEATURES leaves it as it is.

Of each function the files used last are kept.
"""

import atexit
import hashlib
import os
import pickle
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from functools import cache, cached_property
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import llvmlite
import numba
import numpy as np
from llvmlite import binding
from numba.core import caching, dispatcher, serialize
from numba.extending import _Intrinsic

KEPT = 24                               # files of one function: signatures times versions
DAY = 24 * 3600.0                       # s; a file's time of last use is exact to a day
_PACKAGE = __name__.split(".")[0]
_COMPILERS = f"{numba.__version__} {llvmlite.__version__} {sys.implementation.cache_tag}"


def version(function: FunctionType) -> str:
    """16 hex digits that change with the function, with what it calls and with the constants that it reads."""
    found: dict[FunctionType, str] = {}
    waiting = [function]
    while waiting:
        each = waiting.pop()
        if each not in found:
            found[each], called = _alone(each)
            waiting += called
    return _digest(_COMPILERS, *sorted(found.values()))


@cache
def _alone(function: FunctionType) -> tuple[str, list[FunctionType]]:
    """Digest of a function without what it calls, and the functions of lensbench that it calls."""
    parts, called = [f"{function.__module__}.{function.__qualname__}"], []
    names: set[str] = set()

    def describe(value: Any) -> None:
        if isinstance(value, CodeType):
            names.update(value.co_names)
            parts.append(f"{value.co_code.hex()} {value.co_names} {value.co_varnames} {value.co_freevars}")
            for constant in value.co_consts:
                if constant != function.__doc__ or constant is None:
                    describe(constant)
        elif isinstance(value, dispatcher.Dispatcher):
            parts.append(_options(value.targetoptions))
            called.append(value.py_func)
        elif isinstance(value, _Intrinsic):
            called.append(value._defn)
        elif isinstance(value, FunctionType | type) and value.__module__.split(".")[0] == _PACKAGE:
            parts.append(_source(value.__module__))     # its overloads are anywhere in its module
        elif isinstance(value, FunctionType | type | ModuleType):
            parts.append(f"{getattr(value, '__module__', '')}.{value.__name__}")
        elif isinstance(value, np.ndarray):
            parts.append(f"{value.dtype} {value.shape} {hashlib.sha256(value.tobytes()).hexdigest()}")
        elif isinstance(value, tuple | list):
            parts.append(f"{type(value).__name__} {len(value)}")
            for item in value:
                describe(item)
        elif isinstance(value, frozenset | set | dict):
            parts.append(_options(value))
        else:
            parts.append(re.sub(r" at 0x[0-9a-f]+", "", f"{type(value).__name__} {value!r}"))

    describe(function.__code__)
    for cell in function.__closure__ or ():
        describe(cell.cell_contents)
    describe(function.__defaults__)
    for name in sorted(names & function.__globals__.keys()):
        parts.append(name)
        describe(function.__globals__[name])
    return _digest(*parts), called


def _options(value: Any) -> str:
    """Text of a set or dictionary, the same in every process."""
    items = [f"{key}: {_options(item)}" for key, item in value.items()] if isinstance(value, dict) else \
        [repr(item) for item in value] if isinstance(value, set | frozenset) else [repr(value)]
    return ", ".join(sorted(items))


@cache
def _source(module: str) -> str:
    return _digest(Path(str(sys.modules[module].__file__)).read_text(encoding="utf-8"))


def _digest(*parts: str) -> str:
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]


class KernelCache(caching.FunctionCache):
    """The files of one function: one for each signature, processor and version."""

    def __init__(self, function: FunctionType):
        self._name, self._py_func = repr(function), function
        self._impl = _Reducer()
        self._cache_path = str(folder)
        self._stem = f"{function.__module__.partition('.')[2]}.{function.__qualname__}".replace("<locals>", "")
        self.enable()

    @cached_property
    def _version(self) -> str:
        return version(self._py_func)       # at the first use, when all that the function calls has been declared

    def path(self, signature: Any, codegen: Any) -> Path:
        """The file for a signature and a processor."""
        return folder / f"{self._stem}-{_digest(str(signature), str(codegen.magic_tuple()), self._version)}.kernel"

    def _load_overload(self, sig: Any, target_context: Any) -> Any:
        path = self.path(sig, target_context.codegen())
        try:
            data = pickle.loads(path.read_bytes())
            if time.time() - path.stat().st_mtime > DAY:
                os.utime(path)
        except FileNotFoundError:
            return None
        except Exception:                   # a damaged file, by whatever error pickle raises: compile again
            with suppress(OSError):
                path.unlink()
            return None
        return self._impl.rebuild(target_context, data)

    def _save_overload(self, sig: Any, data: Any) -> None:
        if not self._impl.check_cachable(data):
            return
        path = self.path(sig, data.codegen)
        part = path.with_suffix(f".{os.getpid()}.part")
        with suppress(OSError):             # a full disk, or one that is read only by now: this process has the code
            part.write_bytes(serialize.dumps(self._impl.reduce(data)))
            part.replace(path)
            for old in sorted(self._files(), key=_last_use, reverse=True)[KEPT:]:
                old.unlink(missing_ok=True)

    def _files(self) -> Iterator[Path]:
        return folder.glob(f"{self._stem}-*.kernel")

    def flush(self) -> None:
        """Remove the files of this function."""
        for path in self._files():
            path.unlink(missing_ok=True)


class _Reducer(caching.CompileResultCacheImpl):
    """Numba's conversion of compiled code to and from what can be pickled, without its search for a folder."""

    def __init__(self) -> None:
        """Numba's own needs the folder of the source."""

    def check_cachable(self, cres: Any) -> bool:
        """Whether the code refers to no address of this process."""
        return not cres.library.has_dynamic_globals and all(lifted.can_cache for lifted in cres.lifted)


def is_compiled(kernel: Any, signature: Any) -> bool:
    """Whether a kernel need not be compiled for this signature: this process or the folder has it."""
    if signature.args in kernel.overloads:
        return True
    kernel.targetctx.refresh()
    return kernel._cache.path(signature, kernel.targetctx.codegen()).exists()


def _last_use(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:                         # another process has removed it
        return 0.0


def _open_folder() -> Path:
    """The folder of kernels; those of versions before 2026-11 are removed unless used within a day."""
    try:
        home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "lensbench"
        kernels = home / "kernels"
        kernels.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=kernels).close()
    except (OSError, RuntimeError):
        kernels = Path(tempfile.mkdtemp(prefix="lensbench-"))
        atexit.register(shutil.rmtree, kernels, ignore_errors=True)
        return kernels
    with suppress(OSError):
        for old in home.iterdir():
            if re.fullmatch("[0-9a-f]{16}", old.name) and time.time() - _last_use(old) > DAY:
                shutil.rmtree(old, ignore_errors=True)
    return kernels


def _cache_of(function: FunctionType) -> caching.FunctionCache:
    """The cache of a function that is declared with cache=True."""
    if function.__module__.split(".")[0] == _PACKAGE:
        return KernelCache(function)
    return caching.FunctionCache(function)


def _prefer_wide_registers() -> None:
    """Let LLVM use 512-bit registers where the processor has them and the user has not said otherwise."""
    features = binding.get_host_cpu_features()
    if (features.get("avx512f") and numba.config.CPU_FEATURES is None
            and os.environ.get("LENSBENCH_WIDE_REGISTERS", "1") != "0"):
        numba.config.CPU_FEATURES = features.flatten() + ",-prefer-256-bit"


folder = _open_folder()
dispatcher.FunctionCache = _cache_of
_prefer_wide_registers()
