"""Computed late: names that are imported when they are first used, and hashes of frozen values, computed once."""

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, TypeVar

ROOT = __name__.split(".")[0]


def called(module: str, name: str, *arguments: Any) -> Any:
    """Result of a function of another module of lensbench, imported now; for what core shows and does not import."""
    return getattr(import_module(f"{ROOT}.{module}"), name)(*arguments)


def lazy_names(package: str, homes: Mapping[str, str]) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package whose names live in other modules.

    Parameters
    ----------
    package : str
        The package's `__name__`.
    homes : mapping of str to str
        For each module, by its path inside lensbench, the names that it supplies, separated by spaces; `name=there`
        where the module has the name `there` for it. Without names the module itself is meant.

    Returns
    -------
    tuple of callable
        To be bound to `__getattr__` and `__dir__` of the package. A name that was asked for once is an ordinary
        attribute from then on.
    """
    place = {}
    for module, names in homes.items():
        if not names:
            place[module.rpartition(".")[2]] = (f"{ROOT}.{module}", "")
        for each in names.split():
            name, _, there = each.partition("=")
            place[name] = (f"{ROOT}.{module}", there or name)

    def find(name: str) -> Any:
        try:
            module, there = place[name]
        except KeyError:
            raise AttributeError(f"module {package!r} has no attribute {name!r}") from None
        value = import_module(module)
        if there:
            from lensbench.core.named_objects import refusing_names  # with `inspect`: not before a name is used

            value = refusing_names(getattr(value, there), package)
        setattr(sys.modules[package], name, value)
        return value

    def listed() -> list[str]:
        return sorted({*vars(sys.modules[package]), *place})

    return find, listed


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
