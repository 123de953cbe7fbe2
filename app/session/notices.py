"""What the window tells its user, and the requests of panels, menus and keys."""

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from enum import Enum, auto


class NoticeKind(Enum):
    """Errors need an answer, notes do not."""

    ERROR = "error"
    NOTE = "note"
    DONE = "done"               # a success


SECONDS = {NoticeKind.NOTE: 6.0, NoticeKind.DONE: 4.0}      # that they stay in sight; an error stays until dismissed
READ = 12.0                     # characters a second, for which they stay longer


@dataclass(frozen=True)
class Notice:
    """One sentence.

    lens: the setting of the lens that it is about. file: the file that cannot be read. "" for none.
    change: it is about the change of settings in the frame in which it is said. step: of the history, that this change
    made; 0 until that frame ends. about: the kind of work that it reports, whose next report replaces it; "" for none.
    seen: seconds that it was in sight. offer: the text of a button, and what it requests.
    """

    text: str
    kind: NoticeKind = NoticeKind.ERROR
    lens: str = ""
    file: str = ""
    change: bool = False
    step: int = 0
    about: str = ""
    seen: float = 0.0
    offer: "tuple[str, Request] | None" = None


class Notices:
    """The notices of one window, the oldest first, without duplicates."""

    def __init__(self) -> None:
        self._all: list[Notice] = []

    def __len__(self) -> int:
        return len(self._all)

    @property
    def texts(self) -> list[str]:
        """All texts, the oldest first."""
        return [notice.text for notice in self._all]

    def say(self, notice: Notice) -> None:
        """Add a notice, instead of one with its text and of those about its kind of work."""
        self.forget(lambda other: other.text == notice.text or other.about == notice.about != "")
        self._all.append(notice)

    def errors(self) -> list[Notice]:
        """The errors, the newest first."""
        return [notice for notice in reversed(self._all) if notice.kind is NoticeKind.ERROR]

    def others(self) -> list[Notice]:
        """Notes and successes, the newest first."""
        return [notice for notice in reversed(self._all) if notice.kind is not NoticeKind.ERROR]

    def forget(self, which: Callable[[Notice], bool] = lambda notice: True) -> None:
        """Dismiss the notices for which `which` is true; by default all."""
        self._all = [notice for notice in self._all if not which(notice)]

    def pass_time(self, shown: Collection[Notice], seconds: float) -> None:
        """Count the seconds that some were in sight, and dismiss those whose time is over."""
        self._all = [replace(notice, seen=notice.seen + seconds) if notice in shown else notice
                     for notice in self._all]
        self.forget(lambda notice: notice.offer is None and notice.seen > SECONDS.get(notice.kind, math.inf)
                    + len(notice.text) / READ)

    def follow(self, lens: str, step: int) -> None:
        """At a frame's end, dismiss what is about another lens, or about a change that undo has taken back."""
        self.forget(lambda notice: notice.lens not in ("", lens) or notice.step > step)
        self._all = [replace(notice, step=step) if notice.change and not notice.step else notice
                     for notice in self._all]

    def read(self, file: str) -> None:
        """Dismiss what says that this file cannot be read."""
        self.forget(lambda notice: notice.file == file)


class Request(Enum):
    """The window answers a request at the beginning of its next frame."""

    # The render
    PAUSE = auto()                      # or go on
    RESTART = auto()
    PIN = auto()                        # keep the picture as A
    EXPORT = auto()

    # Files to open
    OPEN = auto()                       # of any kind
    CHOOSE_DEPTH = auto()               # of a photograph
    OPEN_STOP_IMAGE = auto()

    # Files to save
    SAVE_LENS = auto()
    SAVE_EDITED = auto()                # the edited lens, in its own file
    SAVE_SCENE = auto()
    SAVE_SETTINGS = auto()
    SAVE_INTRINSICS = auto()
    SAVE_RENDER = auto()
    SAVE_WINDOW = auto()
    SAVE_LIGHT_FIELD = auto()
    SAVE_REFOCUSED = auto()
    SAVE_PLOT_CSV = auto()              # the figure of an analysis
    SAVE_PLOT_SVG = auto()
    SAVE_PLOT_PNG = auto()
    CHOOSE_EXPORT_PATH = auto()

    # The light field
    RECORD = auto()
    FIND_DEPTH = auto()
    COMPARE = auto()                    # render the same picture with the camera

    # The window
    ADJUST_SCENE = auto()               # show the form of an opened mesh, sky or photograph
    BROWSE_LENSES = auto()
    IMPROVE_LENS = auto()
    RESET_LAYOUT = auto()
    FOLLOW_WINDOW = auto()              # with the pixels of the picture, or keep those that it has
    HIDE_PANELS = auto()                # or show them again
    FULL_SCREEN = auto()                # or leave it
    SHOW_HELP = auto()
    SHOW_PALETTE = auto()
    SHOW_TERMS = auto()

    # Snapshots
    KEEP_SNAPSHOT = auto()
    COPY_PICTURE = auto()
    COPY_STATE = auto()
    PASTE = auto()
    SAVE_CARD = auto()
    CONTACT_SHEET = auto()
    SAVE_SHEET = auto()
