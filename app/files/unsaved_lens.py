"""Unsaved edits of a lens, kept on disk while the window is open, so that nothing that a person made is lost.

Each window keeps one file of settings beside those of others, written beside its place and then renamed. What a window
that has ended left behind is offered at the next start.
"""

import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from time import time

from lensbench.app.files.export import runs
from lensbench.app.files.settings_file import load_settings, save_settings
from lensbench.app.state.settings import Settings

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
    """The file of one window."""

    def __init__(self, folder: Path):
        self._path = folder / f"{os.getpid()}-{id(self):x}.toml"
        self._folder, self._saved = folder, ""

    def keep(self, settings: Settings) -> None:
        """Write the edits of these settings, or remove the file where there are none; OSError, ValueError."""
        if settings.edited == self._saved:
            return
        if settings.edited:
            self._folder.mkdir(parents=True, exist_ok=True)
            save_settings(self._path, settings)
        else:
            self._path.unlink(missing_ok=True)
        self._saved = settings.edited


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

