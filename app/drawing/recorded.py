"""Drawing that is computed once and repeated while nothing changes, and caches of one panel."""

from collections.abc import Callable, Hashable
from typing import Any, cast

from imgui_bundle import imgui

from lensbench.app.drawing import theme

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


Calls = list[tuple[str, tuple[Any, ...]]]


class Recorder:
    """Takes the place of a draw list, and notes the calls."""

    def __init__(self) -> None:
        self.calls: Calls = []

    def __getattr__(self, name: str) -> Callable[..., None]:
        return lambda *args: self.calls.append((name, args))


def record(paint: Callable[[imgui.ImDrawList], Any]) -> Calls:
    """The calls by which a function draws.

    paint: draws into the list that it receives, by methods that return nothing and by positional arguments alone.
    """
    recorder = Recorder()
    paint(cast(imgui.ImDrawList, recorder))
    return recorder.calls


def repeat(calls: Calls, into: imgui.ImDrawList) -> None:
    """Draw again what was recorded."""
    for name, args in calls:
        getattr(into, name)(*args)


class Recorded:
    """The newest drawing of one panel."""

    def __init__(self) -> None:
        self._key: Hashable = None
        self._calls: Calls = []

    def draw(self, into: imgui.ImDrawList, key: Hashable, paint: Callable[[imgui.ImDrawList], None]) -> None:
        """Repeat the drawing of this key and of the current theme, font and screen; paint it anew if they changed.

        into: the draw list. paint: as `record` takes it; what it draws depends on nothing but the key.
        """
        key = (key, theme.look())
        if key != self._key:
            self._key, self._calls = key, record(paint)
        repeat(self._calls, into)
