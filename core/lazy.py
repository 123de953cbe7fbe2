"""Computed late: names that are imported when they are first used, and hashes of frozen values, computed once."""

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any, TypeVar

ROOT = __name__.split(".")[0]


def called(module: str, name: str, *arguments: Any) -> Any:
    """Result of a function of another module of lensbench, imported now; for what core shows and does not import."""
    return getattr(import_module(f"{ROOT}.{module}"), name)(*arguments)


def typed_imports(package: str) -> dict[str, tuple[str, str]]:
    """Module and name there of each name that a package imports under `if TYPE_CHECKING:`, read from its source."""
    spec = sys.modules[package].__spec__
    body = ast.parse(spec.loader.get_source(package)).body         # type: ignore[union-attr]
    return {name.asname or name.name: (str(imported.module), name.name)
            for node in body if isinstance(node, ast.If)
            for imported in node.body if isinstance(imported, ast.ImportFrom) for name in imported.names}


def lazy_names(package: str) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """`__getattr__`, `__dir__` and `__all__` of a package that lists its names as imports under `if TYPE_CHECKING:`.

    Each name is imported when it is first used, and is an ordinary attribute from then on.
    """
    homes = typed_imports(package)

    def find(name: str) -> Any:
        if (package, name) == (ROOT, "__version__"):
            return import_module("importlib.metadata").version(ROOT)
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, there = homes[name]
        home = import_module(module)
        if hasattr(home, there):
            from lensbench.core.named_objects import accepting_names  # with `inspect`: not before a name is used

            value = accepting_names(getattr(home, there), package)
        else:
            value = import_module(f"{module}.{there}")
        setattr(sys.modules[package], name, value)
        return value

    def listed() -> list[str]:
        return sorted({*vars(sys.modules[package]), *homes})

    return find, listed, sorted(homes)


Value = TypeVar("Value", bound=type)


def hashed_once(cls: Value) -> Value:
    """Class decorator, over @dataclass(frozen=True): keep the hash of each value with it.

    A copy in another process computes its own, for hashes of text differ there.
    """
    computed: Callable[[Any], int] = vars(cls)["__hash__"]

    def kept(self: Any) -> int:
        try:
            return self.__dict__["_hash"]
        except KeyError:
            value = computed(self)
            object.__setattr__(self, "_hash", value)
            return value

    def state(self: Any) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "_hash"}

    for name, method in (("__hash__", kept), ("__getstate__", state)):
        setattr(cls, name, method)
    return cls
