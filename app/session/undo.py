"""Undo and redo over the Settings: one entry for each gesture.

A drag changes the settings in every frame and is still one step back; so are the
clicks of a wheel that follow each other on the same control.
"""

from lensbench.app.settings.settings import Settings, differences

DEPTH = 200                     # entries that are kept
PAUSE = 0.6                     # seconds: edits of the same fields that follow sooner are one entry


class History:
    """The current settings, the earlier ones, and those that an undo took back."""

    def __init__(self, settings: Settings):
        self.present = settings
        self._past: list[Settings] = []
        self._dropped = 0                               # entries that are older than those in _past
        self._future: list[Settings] = []
        self._open: frozenset[str] = frozenset()        # the fields that the latest entry changes
        self._held = False                              # whether the gesture of the latest entry continues
        self._time = -1e9

    @property
    def can_undo(self) -> bool:
        """Whether there is an earlier state."""
        return bool(self._past)

    @property
    def can_redo(self) -> bool:
        """Whether an undo can be repeated forward."""
        return bool(self._future)

    @property
    def step(self) -> int:
        """Number of gestures that led to the current settings: an undo lowers it."""
        return self._dropped + len(self._past)

    def edit(self, settings: Settings, is_held: bool, time: float) -> None:
        """Make these the current settings.

        is_held: whether a mouse button is down or a text entry is active, so that this and the next edits are one
        gesture. time: seconds of any clock.
        """
        if settings == self.present:
            self._held = self._held and is_held
            return
        changed = differences(settings, self.present)
        follows = self._past and (self._held and is_held or changed.keys() <= self._open and time - self._time < PAUSE)
        if not follows:
            self._past.append(self.present)
            self._dropped += len(self._past[:-DEPTH])
            del self._past[:-DEPTH]
            self._open = frozenset()
        self._future.clear()
        self._open |= changed.keys()
        self._held, self._time = is_held, time
        self.present = settings

    def part(self) -> None:
        """Let the next edit begin an entry of its own, however soon it follows."""
        self._close()

    def undo(self) -> Settings:
        """Take back the latest gesture, if any."""
        if self._past:
            self._future.append(self.present)
            self.present = self._past.pop()
        self._close()
        return self.present

    def redo(self) -> Settings:
        """Repeat the latest gesture that was taken back, if any."""
        if self._future:
            self._past.append(self.present)
            self.present = self._future.pop()
        self._close()
        return self.present

    def correct(self, settings: Settings) -> None:
        """Replace invalid current settings by valid ones, without an entry."""
        if self._past and self._past[-1] == settings:
            self._past.pop()
        self.present = settings
        self._close()

    def _close(self) -> None:
        self._open, self._held, self._time = frozenset(), False, -1e9
