"""Caches of one panel, for geometry that is drawn in every frame and computed once."""

from collections.abc import Callable, Hashable
from typing import Any

UNKNOWN = object()


class Memo:
    """Values by key; the `size` newest keys are kept."""

    def __init__(self, size: int):
        self._size = size
        self._values: dict[Hashable, Any] = {}

    def of(self, key: Hashable, make: Callable[[], Any]) -> Any:
        """The value of this key, computed if the key is new."""
        value = self._values.pop(key, UNKNOWN)          # a key may be large, and every look at it hashes it
        if value is UNKNOWN:
            value = make()
            while len(self._values) >= self._size:
                del self._values[next(iter(self._values))]
        self._values[key] = value                       # the newest is last
        return value


class FrameMemo:
    """Values by key; what a frame has not used is forgotten with the next one.

    For drawings whose keys hold figures, places and sizes: those of former settings do not come back.
    """

    def __init__(self) -> None:
        self._values: dict[Hashable, Any] = {}          # of this frame,
        self._before: dict[Hashable, Any] = {}          # and of the one before what this one has not used yet

    def __len__(self) -> int:
        return len(self._values) + len(self._before)

    def begin_frame(self) -> None:
        """Call before the values of a frame."""
        self._values, self._before = {}, self._values

    def of(self, key: Hashable, make: Callable[[], Any]) -> Any:
        """The value of this key, computed if neither this frame nor the one before has used it."""
        value = self._before.pop(key, UNKNOWN)
        if value is UNKNOWN:
            value = self._values.get(key, UNKNOWN)
            if value is not UNKNOWN:
                return value
            value = make()
        self._values[key] = value
        return value
