"""Compiled kernels: the version of a function, its code as a file, and interrupts held back while it is compiled.

A version covers the function, its options, all functions of lensbench that it calls, the constants that they read, and
the versions of numba, LLVM and Python; not comments, docstrings, or code that the function does not reach.
"""

import hashlib
import re
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

import llvmlite
import numba
import numpy as np
from llvmlite import binding
from numba.core import caching, codegen, compiler, dispatcher
from numba.core.environment import Environment, lookup_environment
from numba.extending import _Intrinsic

NUMBERS = (signal.SIGINT, signal.SIGTERM)
_holding = False


@contextmanager
def signals_held() -> Iterator[None]:
    """Hold back the signals of NUMBERS that Python handles, on the main thread; no other gets any.

    LLVM calls Python back. An exception that a signal's handler raises there is lost, and the compilation fails with
    another error or goes on with half of an object. Signals that came meanwhile are handled at the end.
    """
    global _holding
    if _holding or threading.current_thread() is not threading.main_thread():
        yield
        return
    asked: list[int] = []
    former = {number: handler for number in NUMBERS if callable(handler := signal.getsignal(number))}
    for number in former:
        signal.signal(number, lambda number, frame: asked.append(number))
    _holding = True
    try:
        yield
    finally:
        _holding = False
        for number, handler in former.items():
            signal.signal(number, handler)
        for late in asked:
            former[signal.Signals(late)](late, None)


COMPILERS = f"{numba.__version__} {llvmlite.__version__} {sys.implementation.cache_tag}"
FORMAT = "4"            # of the files of stored kernels
_PACKAGE = __name__.split(".")[0]


def version(function: FunctionType) -> str:
    """Version of a function that numba compiles or compiled: 16 hex digits."""
    digests: dict[FunctionType, str] = {}
    own = function.__globals__.get(function.__name__)
    options = _options(own.targetoptions) if isinstance(own, dispatcher.Dispatcher) else ""
    waiting = [function]
    while waiting:
        callee = waiting.pop()
        if callee not in digests:
            digests[callee], called = _alone(callee)
            waiting += called
    return digest(COMPILERS, FORMAT, options, *sorted(digests.values()))


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


class _StoredLibrary(codegen.JITCodeLibrary):
    """The code of a stored kernel, whose form for inlining is read only when another kernel is compiled with it.

    Numba's own reads it at once, and looks at each of its symbols: most of the time that it takes to load a kernel.
    """

    _shared_module: Any                     # the form for inlining, from when it is read

    def __init__(self, generator: Any, name: str, code: bytes, bitcode: bytes, entries: tuple[str, ...]):
        """entries: names under which other code may call it, of which `code` has some."""
        super().__init__(generator, name)
        self._bitcode = bitcode
        self.enable_object_caching()
        self._set_compiled_object(code)
        self._finalize_final_module()
        generator._engine._defined_symbols.update(entry for entry in entries if entry.encode() in code)

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None:
            self._shared_module = binding.parse_bitcode(self._bitcode)
            self._codegen._engine._load_defined_symbols(self._shared_module)
        return self._shared_module


class CodeReducer(caching.CompileResultCacheImpl):
    """Numba's conversion of compiled code to and from what can be pickled, without its search for a folder."""

    def __init__(self) -> None:
        """Numba's own needs the folder of the source."""

    def rebuild(self, target_context: Any, payload: tuple[Any, ...]) -> Any:
        """The compiled kernel of what `reduce` made of it."""
        (name, _, codes), described, environment, signature, in_objects, lifted, typed, begin, constants = payload
        for function in begin:
            function()
        generator = target_context.codegen()
        entries = (described.llvm_func_name, described.llvm_cpython_wrapper_name,
                   described.llvm_cfunc_wrapper_name)
        library = _StoredLibrary(generator, name, *codes, entries)      # type: ignore[call-arg]
        environments = tuple(_environment(*one) for one in constants)   # kept by the result: code has addresses only
        result = compiler.CompileResult(
            target_context=target_context, typing_context=target_context.typing_context, library=library,
            environment=environment, entry_point=target_context.get_executable(library, described, environment),
            fndesc=described, type_annotation=typed, signature=signature, objectmode=in_objects, lifted=lifted,
            typing_error=None, call_helper=None, metadata=None, reload_init=begin, referenced_envs=environments)
        for one in environments:
            generator.set_env(one.env_name, one)
        return result

    def reduce(self, cres: Any) -> tuple[Any, ...]:
        """What can be pickled, without the source that numba annotates with types: half of a file, and never read."""
        *parts, environments = super().reduce(cres._replace(type_annotation=""))
        return *parts, tuple((one.globals["__name__"], one.consts, one.env_name) for one in environments)

    def check_cachable(self, cres: Any) -> bool:
        """Whether the code refers to no address of this process."""
        return not cres.library.has_dynamic_globals and all(lifted.can_cache for lifted in cres.lifted)


def _environment(module: str, constants: list[Any], name: str) -> Environment:
    """The constants of a function that compiled code calls, without the names of its module.

    Numba's own environment imports the module for these, which interpreted code alone would need: up to 50 ms.
    """
    environment = lookup_environment(name)
    if environment is None:
        environment = Environment({"__name__": module})
        environment.consts[:] = constants
        environment.env_name = name
        Environment._memo[name] = environment
    return environment
