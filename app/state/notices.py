"""What the window tells its user: errors, remarks and successes, each until it is dismissed or its lens is gone."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum


class NoticeKind(Enum):
    """Errors need an answer, notes do not."""

    ERROR = "error"
    NOTE = "note"
    DONE = "done"               # a success


@dataclass(frozen=True)
class Notice:
    """One sentence. lens: the setting of the lens that it is about. file: the file that cannot be read. "" for none."""

    text: str
    kind: NoticeKind = NoticeKind.ERROR
    lens: str = ""
    file: str = ""


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
        """Add a notice; one that is there already becomes the newest."""
        self.forget(lambda other: other.text == notice.text)
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

    def follow(self, lens: str) -> None:
        """Dismiss what is about another lens than the present one."""
        self.forget(lambda notice: notice.lens not in ("", lens))

    def read(self, file: str) -> None:
        """Dismiss what says that this file cannot be read."""
        self.forget(lambda notice: notice.file == file)
