"""Unsaved edits of a lens, kept on disk while the window is open, so that nothing that a person made is lost.

Each window keeps its files of settings beside those of others, written beside their places and then renamed. What a
window that has ended left behind is offered at the next start.
"""

import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import time

from lensbench.app.session.export import runs
from lensbench.app.session.settings_file import load_settings, save_settings
from lensbench.app.settings.settings import Settings

KEPT = 30 * 86400.0             # seconds that edits are kept which nobody has taken


def unsaved_folder() -> Path:
    """The folder of unsaved edits, in that of the configuration."""
    home = os.environ.get("XDG_CONFIG_HOME")
    return (Path(home) if home else Path("~").expanduser() / ".config") / "lensbench" / "unsaved"


@dataclass(frozen=True)
class Unsaved:
    """Edits that a window left behind. written: seconds since 1970."""

    path: Path
    settings: Settings
    written: float

    def remove(self) -> None:
        """Delete the file."""
        with suppress(OSError):
            self.path.unlink()


class Autosave:
    """The file of one window, and one for each lens that another has taken the place of with its edits unsaved."""

    def __init__(self, folder: Path):
        self._folder, self._files = folder, 0
        self._path = self._new()
        self._kept = "", ""                             # the lens and its edits, as written last
        self._left: dict[tuple[str, str], Path] = {}    # the files of former lenses, until these come back

    def _new(self) -> Path:
        self._files += 1
        return self._folder / f"{os.getpid()}-{id(self):x}-{self._files}.toml"

    def keep(self, settings: Settings, saved: tuple[str, str] = ("", "")) -> bool:
        """Write the edits of these settings, or remove the file where there are none; OSError, ValueError.

        saved: the lens and the edits that the window has saved last. True where another lens has taken the place of
        one with other edits: their file stays.
        """
        before, present, path = self._kept, (settings.lens, settings.edited), self._path
        if present == before:
            return False
        leaves = bool(before[1]) and present[0] != before[0] and before != saved
        if leaves or present in self._left:             # undone, the edits have their file again
            path = self._left.get(present) or self._new()
        if settings.edited:
            self._folder.mkdir(parents=True, exist_ok=True)
            save_settings(path, settings)
        else:
            path.unlink(missing_ok=True)
        if leaves:
            self._left[before] = self._path
        elif path != self._path:
            self._path.unlink(missing_ok=True)
        self._left.pop(present, None)
        self._path, self._kept = path, present
        return leaves


def left_behind(folder: Path) -> list[Unsaved]:
    """What windows that have ended left in a folder, the newest first; files that cannot be read are left alone."""
    found = []
    with suppress(OSError):
        for path in folder.glob("*.toml"):
            with suppress(OSError, ValueError):
                if runs(int(path.name.split("-")[0])):
                    continue
                written = path.stat().st_mtime
                if time() - written > KEPT:
                    path.unlink()
                    continue
                settings = load_settings(path)
                if settings.edited:
                    found.append(Unsaved(path, settings, written))
    return sorted(found, key=lambda each: -each.written)

