"""Cache of one panel, for geometry that is drawn in every frame and computed once."""

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
