"""What keeps Settings outside of pictures: files, texts for messages, the last session, unsaved lenses, undo.

A settings file is TOML that users read and edit. Its keys are the fields of Settings, in their units; a missing key
means the default. TOML has no null: WORDS has a word for each field that may be None. A lens, a scene or a picture in
the stop may be given by its path relative to the settings file. Files are written by `export.replacing`, completely or
not at all.

A text that fits into a chat message is “lensbench:” and the settings that differ from the defaults: JSON, deflated, in
the letters of URLs. It names lenses and scenes, and holds no files.

The edits of a lens are kept in files of settings while the window is open, so that nothing that a person made is lost.
Each window has its own; what a window that has ended left behind is offered at the next start.

Undo and redo have one entry for each gesture: a drag changes the settings in every frame and is still one step back; so
are the clicks of a wheel that follow each other on the same control.
"""

import base64
import binascii
import json
import os
import re
import tomllib
import zlib
from contextlib import suppress
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from time import time
from typing import Any

from lensbench.app.scenes.asset_files import user_folder
from lensbench.app.scenes.scene_writer import toml_value
from lensbench.app.session.export import read_settings, replacing, runs
from lensbench.app.settings.setting import SettingsError, spec
from lensbench.app.settings.settings import PICTURES, VERSION, Settings, differences
from lensbench.core.text import MOST_CHARACTERS, cut, excerpt
from lensbench.lenses.file_error import open_regular

HEAD = "# lensbench: lengths in mm, angles in radians, times in seconds, exposure in stops\n"
WORDS = {field.name: spec(field).none for field in fields(Settings) if spec(field).none}    # for None
LONGEST = 1 << 20               # bytes read at most


def snapshots_folder() -> Path:
    """The folder of the snapshots."""
    return user_folder("XDG_DATA_HOME", ".local/share") / "snapshots"


def save_settings(path: str | Path, settings: Settings) -> None:
    """Write all settings, completely or not at all; ExportError if the file cannot be written."""
    values = {"version": VERSION, **asdict(settings)}
    lines = (f"{name} = {toml_value(WORDS[name] if value is None else value)}\n" for name, value in values.items())
    with replacing(checked_path(path)) as temporary:
        temporary.write_text(HEAD + "".join(lines), encoding="utf-8")


def load_settings(path: str | Path) -> Settings:
    """Settings of a file or an exported picture; SettingsError with file, line and key, ExportError of a picture."""
    path = Path(path)
    if path.suffix.lower() in PICTURES:
        return read_settings(path)
    try:
        with open_regular(path) as file:
            raw = file.read(LONGEST + 1)
        if len(raw) > LONGEST:
            raise SettingsError(f"{path}: this is larger than {LONGEST >> 20} MB: not a settings file")
        text = raw.decode("utf-8")
        plain = tomllib.loads(text)
    except OSError as error:
        raise SettingsError(f"{path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise SettingsError(f"{path}: not UTF-8 text") from error
    except SettingsError:
        raise
    except (ValueError, RecursionError) as error:       # of TOML, of a number of 5000 digits, of nested brackets
        raise SettingsError(f"{path}: not TOML: {cut(str(error), 4 * MOST_CHARACTERS)}") from error
    plain = {name: None if value == WORDS.get(name) else value for name, value in plain.items()}
    try:
        return _placed(Settings.from_dict(plain), path.parent)
    except ValueError as error:
        raise SettingsError(f"{path}:{_where(plain, text)} {error}") from error


def checked_path(path: str | Path) -> Path:
    """The path; SettingsError if its suffix is not .toml."""
    if Path(path).suffix.lower() != ".toml":
        raise SettingsError(f"{path}: settings are written as .toml")
    return Path(path)


def _where(plain: dict[str, Any], text: str) -> str:
    """Line and key of the first setting that is invalid on its own; "" if only the combination is invalid."""
    known = {field.name for field in fields(Settings)}
    for name, value in plain.items():
        try:
            if name == "version" or name in known:
                Settings.from_dict({"version": 1, name: value})
                continue
        except ValueError:
            pass
        line = next((i for i, row in enumerate(text.splitlines(), 1)
                     if re.match(rf"\s*\"?{re.escape(name)}\"?\s*[=.]", row)), None)
        return f"{line}: {cut(name)}:" if line else f" {cut(name)}:"
    return ""


def _placed(settings: Settings, folder: Path) -> Settings:
    """The settings with the absolute paths of the files next to them: lens, scene, and the picture in the stop."""
    def place(text: str) -> str:
        try:
            path = (folder / text).resolve()
            return str(path) if path.suffix and path.is_file() else text
        except ValueError:              # not a valid file name
            return text

    return replace(settings, lens=place(settings.lens), scene=place(settings.scene),
                   stop_image=place(settings.stop_image))


# As a text

PREFIX = "lensbench:"
LONGEST_TEXT = 1 << 16          # characters, and bytes of the JSON
DIGITS = 7                      # of a number: finer than any dial


def state_text(settings: Settings) -> str:
    """The settings as one word; numbers are rounded to DIGITS."""
    defaults = Settings().to_dict()
    plain = {name: _short(value) for name, value in settings.to_dict().items()
             if name == "version" or value != defaults[name]}
    packed = json.dumps(plain, ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode()
    deflate = zlib.compressobj(9, zlib.DEFLATED, -15)
    return PREFIX + base64.urlsafe_b64encode(deflate.compress(packed) + deflate.flush()).decode().rstrip("=")


def carries_settings(lens: str) -> bool:
    """Whether what is given instead of a LENS is an exported picture, or the text of a state."""
    return lens.startswith(PREFIX) or Path(lens).suffix.lower() in PICTURES


def read_state(text: str) -> Settings:
    """The settings of the text of a state, or of a file of settings or an exported picture; errors are theirs."""
    return settings_of_text(text) if text.startswith(PREFIX) else load_settings(text)


def is_state_text(text: str) -> bool:
    """Whether a text claims to be one of `state_text`."""
    return text.strip().startswith(PREFIX)


def settings_of_text(text: str) -> Settings:
    """The settings of a `state_text`; SettingsError for another text, a cut one, or settings that cannot be."""
    word = "".join(text.split())
    if not word.startswith(PREFIX) or len(word) > LONGEST_TEXT:
        raise SettingsError(f"“{excerpt(text[:60])}”: a state of lensbench begins with {PREFIX}")
    letters = word[len(PREFIX):]
    try:
        packed = base64.b64decode(letters + "=" * (-len(letters) % 4), altchars=b"-_", validate=True)
        inflate = zlib.decompressobj(-15)
        raw = inflate.decompress(packed, LONGEST_TEXT)
        if not inflate.eof:
            raise ValueError("it ends too early")
        plain = json.loads(raw.decode())
    except (ValueError, binascii.Error, zlib.error, RecursionError) as error:
        raise SettingsError("this state of lensbench is incomplete or damaged: copy the whole text again") from error
    if not isinstance(plain, dict):
        raise SettingsError("this state of lensbench is damaged: it holds no settings")
    return Settings.from_dict(plain)


def named_files(settings: Settings) -> list[str]:
    """Names of the files that the settings name, and that their text does not hold."""
    return [Path(name).name for name in (settings.lens, settings.scene, settings.stop_image)
            if Path(name).suffix and Path(name).is_file()]


def _short(value: object) -> object:
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    return [_short(item) for item in value] if isinstance(value, list | tuple) else value


# The last session


def session_path() -> Path:
    """The file; it may not exist yet."""
    return user_folder("XDG_DATA_HOME", ".local/share") / "session.toml"


def save_session(settings: Settings) -> None:
    """Keep the settings for the next session; OSError or ExportError if that cannot be."""
    path = session_path()
    path.parent.mkdir(parents=True, exist_ok=True)
    save_settings(path, settings)


def last_session() -> Settings | None:
    """The settings of the last session; None before the first. ValueError or OSError for a file that cannot be read."""
    path = session_path()
    return load_settings(path) if path.exists() else None


# Unsaved edits of lenses

KEPT = 30 * 86400.0             # seconds that edits are kept which nobody has taken


def unsaved_folder() -> Path:
    """The folder of unsaved edits, in that of the configuration."""
    return user_folder("XDG_CONFIG_HOME", ".config") / "unsaved"


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
        before, lens, path = self._kept, (settings.lens, settings.edited), self._path
        if lens == before:
            return False
        leaves = bool(before[1]) and lens[0] != before[0] and before != saved
        if leaves or lens in self._left:             # undone, the edits have their file again
            path = self._left.get(lens) or self._new()
        if settings.edited:
            self._folder.mkdir(parents=True, exist_ok=True)
            save_settings(path, settings)
        else:
            path.unlink(missing_ok=True)
        if leaves:
            self._left[before] = self._path
        elif path != self._path:
            self._path.unlink(missing_ok=True)
        self._left.pop(lens, None)
        self._path, self._kept = path, lens
        return leaves


def left_behind(folder: Path) -> list[Unsaved]:
    """What windows that have ended left in a folder, the newest first; files that cannot be read are left alone."""
    edits = []
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
                    edits.append(Unsaved(path, settings, written))
    return sorted(edits, key=lambda edit: -edit.written)


# Undo and redo

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
