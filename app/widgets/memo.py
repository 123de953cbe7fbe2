"""Cache of one panel, for geometry that is drawn in every frame and computed once."""

from collections.abc import Callable, Hashable
from typing import Any


class Memo:
    """Values by key; the `size` newest keys are kept."""

    def __init__(self, size: int):
        self._size = size
        self._values: dict[Hashable, Any] = {}

    def of(self, key: Hashable, make: Callable[[], Any]) -> Any:
        """The value of this key, computed if the key is new."""
        if key in self._values:
            self._values[key] = self._values.pop(key)           # the newest is last
        else:
            self._values[key] = make()
            while len(self._values) > self._size:
                del self._values[next(iter(self._values))]
        return self._values[key]
