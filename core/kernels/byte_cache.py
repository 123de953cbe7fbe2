"""Caches of large values, bounded by the bytes that they hold and not by their number alone."""

import threading
from collections.abc import Callable, Iterable
from functools import update_wrapper
from typing import Any, Generic, ParamSpec, TypeVar

import numpy as np

Given = ParamSpec("Given")
Value = TypeVar("Value")
SMALL = 1024            # bytes of a buffer that does not count
PLAIN = frozenset({type(None), float, int, bool, str, np.float64})


class ByteCache(Generic[Given, Value]):
    """A function with its newest values; see `byte_cache`."""

    def __init__(self, function: Callable[Given, Value], most_bytes: int, most: int, least: int):
        update_wrapper(self, function)
        self._function, self._most, self._least = function, most, least
        self.most_bytes = most_bytes
        self._kept: dict[Any, tuple[Value, dict[int, int]]] = {}        # with their buffers; the newest is last
        self._lock = threading.Lock()

    def __call__(self, *arguments: Given.args, **named: Given.kwargs) -> Value:
        """The value for these arguments, computed if it is not known."""
        key = (arguments, tuple(sorted(named.items())))
        with self._lock:
            if known := self._kept.pop(key, None):
                self._kept[key] = known
                return known[0]
        value = self._function(*arguments, **named)
        with self._lock:
            for last in list(self._kept)[-1:]:          # its value may have grown by cached properties
                self._kept[last] = self._kept[last][0], buffers((last, self._kept[last][0]))
            self._kept[key] = value, buffers((key, value))
            while len(self._kept) > self._most or (
                    len(self._kept) > self._least and self.held > self.most_bytes):
                del self._kept[next(iter(self._kept))]
        return value

    @property
    def held(self) -> int:
        """Bytes of all buffers of all values and arguments."""
        return total(sizes for _, sizes in self._kept.values())

    def cache_clear(self) -> None:
        """Forget all values."""
        with self._lock:
            self._kept.clear()


def byte_cache(most_bytes: int, most: int,
               least: int = 1) -> Callable[[Callable[Given, Value]], ByteCache[Given, Value]]:
    """Decorator like `lru_cache`: what was used longest ago is forgotten while all values hold more than `most_bytes`.

    Arrays and `bytes` of arguments and values count, a shared buffer once. most: number of values; least: number of
    newest values that stay whatever they hold, such as those that one picture asks for by turns.
    """
    def decorate(function: Callable[Given, Value]) -> ByteCache[Given, Value]:
        return ByteCache(function, most_bytes, most, least)

    return decorate


def total(parts: Iterable[dict[int, int]]) -> int:
    """Bytes of the `buffers` of several values; a shared one counts once."""
    together: dict[int, int] = {}
    for sizes in parts:
        together.update(sizes)
    return sum(together.values())


def buffers(root: Any) -> dict[int, int]:
    """Bytes of each array and `bytes` that a value of this package reaches, by the identity of the buffer."""
    sizes: dict[int, int] = {}
    visited: set[int] = set()
    waiting = [root]
    while waiting:                          # tens of thousands of turns for a large scene
        value = waiting.pop()
        kind = type(value)
        if kind in PLAIN or id(value) in visited:
            continue
        visited.add(id(value))
        if isinstance(value, np.ndarray):
            while isinstance(value.base, np.ndarray):
                value = value.base
            sizes[id(value.base if isinstance(value.base, bytes) else value)] = value.nbytes
        elif isinstance(value, bytes):
            sizes[id(value)] = len(value)
        elif isinstance(value, (tuple, list, set, frozenset)):      # noqa: UP038 — a union is slower
            waiting += value
        elif isinstance(value, dict):
            waiting += value.values()
        elif kind.__module__.startswith("lensbench"):
            waiting += getattr(value, "__dict__", {}).values()
    return {buffer: size for buffer, size in sizes.items() if size >= SMALL}
