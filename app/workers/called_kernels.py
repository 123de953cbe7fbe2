"""The compiled functions that the code of lensbench needs on their own, found in its sources.

Those are the ones that code which is not compiled names: to call them, or as stages of a program. All others are parts
of these. A wheel has to ship each.
"""

import ast
import inspect
import pkgutil
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from numba.core.dispatcher import Dispatcher

from lensbench import app, core, lenses

STAGE = ("lanes", "p", "ints", "key")           # arguments of a stage
ELSEWHERE = "lensbench.app.studies.", "lensbench.app.benchmark."        # they compile their own


def called_kernels() -> dict[tuple[str, str], Any]:
    """Compiled functions by module and name."""
    found: dict[tuple[str, str], Any] = {}
    for package in (core, lenses, app):
        for each in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not each.name.startswith(ELSEWHERE) and not each.name.endswith("__main__"):      # which runs
                for kernel in _named(import_module(each.name)):
                    found[kernel.py_func.__module__, kernel.py_func.__qualname__] = kernel
    return {key: kernel for key, kernel in found.items() if not key[0].startswith(ELSEWHERE)}


def is_stage(kernel: Any) -> bool:
    """Whether a compiled function is a stage, which all have the same signature."""
    return tuple(inspect.signature(kernel.py_func).parameters) == STAGE


def _named(module: ModuleType) -> Iterator[Any]:
    """The compiled functions that the Python code of a module names."""
    waiting: list[ast.AST] = [ast.parse(Path(str(module.__file__)).read_text(encoding="utf-8"))]
    while waiting:
        node, value = waiting.pop(), None
        if isinstance(node, ast.FunctionDef) and _is_compiled(module, node):
            continue
        if isinstance(node, ast.Attribute) and node.attr == "py_func":      # is not compiled
            continue
        if isinstance(node, ast.Name):
            value = vars(module).get(node.id)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            home = vars(module).get(node.value.id)
            value = getattr(home, node.attr, None) if isinstance(home, ModuleType) else None
        if isinstance(value, Dispatcher):
            yield value
        waiting += ast.iter_child_nodes(node)


def _is_compiled(module: ModuleType, node: ast.FunctionDef) -> bool:
    """Whether numba compiles a function, or reads it while it does."""
    value, lines = vars(module).get(node.name), [decorator.lineno for decorator in node.decorator_list]
    if isinstance(value, Dispatcher):               # and no method of the same name
        return value.py_func.__code__.co_firstlineno in lines
    return any("overload" in ast.unparse(each) or "intrinsic" in ast.unparse(each) for each in node.decorator_list)
