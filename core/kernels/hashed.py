"""Frozen values that serve as keys of caches in every frame: their hash is computed once."""

from collections.abc import Callable
from typing import Any, TypeVar

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
