"""The shelf of snapshots: pictures that were kept with their settings, one PNG each, in a folder of the user.

A snapshot's name is that of its file; the newest comes first. Each file is written beside its place, then renamed, so
that a snapshot is whole or not there. Any such PNG can be opened by `lensbench view` and dropped on the window.
"""

import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lensbench.app.session.export import ExportError, read_settings, save_picture
from lensbench.app.settings.settings import Settings
from lensbench.lenses.picture_file import PictureFileError, read_picture_file

LONGEST_NAME = 60               # characters
THUMBNAIL = 288                 # pixels of the longer side
FORBIDDEN = r'[\x00-\x1f/\\:*?"<>|]'


def snapshots_folder() -> Path:
    """The user's snapshots: lensbench/snapshots in $XDG_DATA_HOME or ~/.local/share; it may not exist yet."""
    home = os.environ.get("XDG_DATA_HOME")
    return (Path(home) if home else Path("~").expanduser() / ".local" / "share") / "lensbench" / "snapshots"


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A kept picture: its file, settings, and thumbnail uint8 (h, w, 3)."""

    path: Path
    settings: Settings
    thumbnail: NDArray[np.uint8]

    @property
    def name(self) -> str:
        """Shown under the thumbnail."""
        return self.path.stem

    def codes(self) -> NDArray[np.float32]:
        """The picture (h, w, 3) as codes of the screen from 0 to 1; ExportError if the file is gone."""
        return _codes(self.path).astype(np.float32) / np.float32(255.0)


class SnapshotShelf:
    """The snapshots of one folder, the newest first. say: receives a sentence for each file that cannot be read."""

    def __init__(self, folder: Path, say: Callable[[str], object] = lambda text: None):
        self.folder, self._say = folder, say
        self.snapshots: list[Snapshot] = []

    def load(self) -> None:
        """Read the folder."""
        found: list[Snapshot] = []
        try:
            paths = sorted((path for path in self.folder.glob("*.png") if path.is_file()),
                           key=lambda path: path.stat().st_mtime, reverse=True)
        except OSError:
            paths = []
        for path in paths:
            try:
                found.append(_read(path))
            except (ValueError, OSError) as error:
                self._say(f"The snapshot {path.stem} cannot be read: {error}")
        self.snapshots = found

    def keep(self, image: NDArray[np.float32], settings: Settings, name: str) -> Snapshot:
        """Add a linear picture (h, w, 3) with its settings; ExportError if it cannot be written."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ExportError(f"{self.folder}: {error.strerror}: the snapshot was not kept") from error
        path = self._free(name)
        save_picture(path, image, settings)
        snapshot = _read(path)
        self.snapshots.insert(0, snapshot)
        return snapshot

    def rename(self, snapshot: Snapshot, name: str) -> None:
        """Give a snapshot another name; ExportError if it cannot be written."""
        if cleaned(name) == snapshot.name:
            return
        path = self._free(name)
        try:
            snapshot.path.rename(path)
        except OSError as error:
            raise ExportError(f"{snapshot.path}: {error.strerror}: the snapshot keeps its name") from error
        self.snapshots[self.snapshots.index(snapshot)] = Snapshot(path, snapshot.settings, snapshot.thumbnail)

    def remove(self, snapshot: Snapshot) -> None:
        """Delete a snapshot and its file; ExportError if that cannot be."""
        try:
            snapshot.path.unlink(missing_ok=True)
        except OSError as error:
            raise ExportError(f"{snapshot.path}: {error.strerror}: the snapshot was not deleted") from error
        self.snapshots.remove(snapshot)

    def _free(self, name: str) -> Path:
        """A path for this name, with a number behind it if the name is taken."""
        stem, number = cleaned(name), 1
        path = self.folder / f"{stem}.png"
        while path.exists():
            number += 1
            path = self.folder / f"{stem} {number}.png"
        return path


def cleaned(name: str) -> str:
    """A name that every file system takes."""
    kept = " ".join(re.sub(FORBIDDEN, " ", name).split()).strip(". ")
    return kept[:LONGEST_NAME].strip(". ") or "snapshot"


def _read(path: Path) -> Snapshot:
    from PIL import Image

    settings = read_settings(path)
    picture = Image.fromarray(_codes(path))
    picture.thumbnail((THUMBNAIL, THUMBNAIL))
    return Snapshot(path, settings, np.asarray(picture))


def _codes(path: Path) -> NDArray[np.uint8]:
    try:
        return np.asarray(read_picture_file(path).convert("RGB"))
    except PictureFileError as error:
        raise ExportError(f"{path}: {error}") from error
