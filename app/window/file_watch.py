"""Notices when a file of the settings changes on disk: the lens, the scene, or the picture in the stop."""

import sys
from pathlib import Path

from lensbench import lenses
from lensbench.app.state.build import own_picture
from lensbench.app.state.file_cache import file_stamp
from lensbench.app.state.scene_file import find_scene, scene_stamp
from lensbench.app.state.settings import Settings
from lensbench.app.state.stop_picture import stop_picture

SECONDS = 1.0                   # between two looks at the disk


class FileWatch:
    """Compares the stamps of the files with those of the last look."""

    def __init__(self) -> None:
        self._stamps: dict[str, tuple] = {}
        self._next = 0.0

    def note(self, name: str) -> None:
        """The present content of a file is known, such as one that the window has written."""
        self._stamps[name] = file_stamp(name)

    def changed(self, settings: Settings, now: float) -> tuple[list[str], dict[str, str]]:
        """Names of the files that have changed and can be read, and messages by name about those that cannot.

        At most once a second. A file that the settings have not named before counts as unchanged; its stamp is taken
        at once, so that a change within that second is seen.
        """
        files = [each for each in ((settings.lens, file_stamp, lenses.load),
                                   (settings.scene, scene_stamp, find_scene),
                                   (settings.stop_image, file_stamp, stop_picture),
                                   (own_picture(settings), file_stamp, stop_picture)) if each[0]]
        for name, stamp_of, _ in files:
            if name not in self._stamps:
                self._stamps[name] = stamp_of(name)
        if now < self._next:
            return [], {}
        self._next = now + SECONDS
        found, problems = [], dict[str, str]()
        for name, stamp_of, load in files:
            stamp = stamp_of(name)
            if self._stamps[name] == stamp:
                continue
            self._stamps[name] = stamp
            try:
                load(name)
            except (ValueError, OSError) as error:
                problems[name] = (f"{Path(name).name} has changed and cannot be read; its last good content stays in "
                                  f"use: {error}")
            else:
                found.append(name)
        return found, problems


def forget_derived() -> None:
    """Clear the caches that are keyed by settings: their values come from the old content of a file."""
    for name, module in list(sys.modules.items()):
        if name.startswith(("lensbench.app.state.", "lensbench.app.panels.")):
            for value in list(vars(module).values()):
                if hasattr(value, "cache_clear"):
                    value.cache_clear()
