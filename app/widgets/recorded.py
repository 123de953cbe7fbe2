"""Drawing that is computed once and repeated in every frame while nothing changes."""

from collections.abc import Callable, Hashable
from typing import Any, cast

from imgui_bundle import imgui

from lensbench.app.widgets import theme

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
        """Repeat the drawing of this key and of the present theme, font and screen; paint it anew if they changed.

        into: the draw list. paint: as `record` takes it; what it draws depends on nothing but the key.
        """
        key = (key, theme.look())
        if key != self._key:
            self._key, self._calls = key, record(paint)
        repeat(self._calls, into)
