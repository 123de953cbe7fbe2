"""Drawing that is computed once and repeated in every frame while nothing changes."""

from collections.abc import Callable, Hashable
from typing import Any, cast

from imgui_bundle import imgui

from lensbench.app.widgets import theme


class _Recorder:
    """Takes the place of a draw list, and notes the calls."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, tuple[Any, ...]]] = []

    def __getattr__(self, name: str) -> Callable[..., None]:
        return lambda *args: self.calls.append((name, args))


class Recorded:
    """The newest drawing of one panel."""

    def __init__(self) -> None:
        self._key: Hashable = None
        self._calls: list[tuple[str, tuple[Any, ...]]] = []

    def draw(self, into: imgui.ImDrawList, key: Hashable, paint: Callable[[imgui.ImDrawList], None]) -> None:
        """Repeat the drawing of this key and of the present theme, font and screen; paint it anew if they changed.

        into: the draw list. paint: draws into the list that it receives, by methods that return nothing and by
        positional arguments alone; what it draws depends on nothing but the key.
        """
        key = (key, theme.look())
        if key != self._key:
            recorder = _Recorder()
            paint(cast(imgui.ImDrawList, recorder))
            self._key, self._calls = key, recorder.calls
        for name, args in self._calls:
            getattr(into, name)(*args)
