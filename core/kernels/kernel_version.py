"""Version of a kernel: a hash that changes exactly when its compiled code may change.

It covers the function, its options, all functions of lensbench that it calls, the constants that they read, and the
versions of numba, LLVM and Python. It does not cover comments, docstrings, or code that the function does not reach.
"""

import hashlib
import re
import sys
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core import dispatcher
from numba.extending import _Intrinsic

COMPILERS = f"{numba.__version__} {llvmlite.__version__} {sys.implementation.cache_tag}"
FORMAT = "4"            # of the files of stored kernels
_PACKAGE = __name__.split(".")[0]


def version(function: FunctionType) -> str:
    """Version of a function that numba compiles or compiled: 16 hex digits."""
    found: dict[FunctionType, str] = {}
    own = function.__globals__.get(function.__name__)
    options = _options(own.targetoptions) if isinstance(own, dispatcher.Dispatcher) else ""
    waiting = [function]
    while waiting:
        each = waiting.pop()
        if each not in found:
            found[each], called = _alone(each)
            waiting += called
    return digest(COMPILERS, FORMAT, options, *sorted(found.values()))


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
    return digest(*parts), called


def _options(value: Any) -> str:
    """Text of a set or dictionary, the same in every process."""
    items = [f"{key}: {_options(item)}" for key, item in value.items()] if isinstance(value, dict) else \
        [repr(item) for item in value] if isinstance(value, set | frozenset) else [repr(value)]
    return ", ".join(sorted(items))


@cache
def _source(module: str) -> str:
    return digest(Path(str(sys.modules[module].__file__)).read_text(encoding="utf-8"))


def digest(*parts: str) -> str:
    """16 hex digits of texts."""
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]
