"""Settings as TOML files, to repeat a picture; users can read and edit them.

The keys are the fields of Settings, in their units; a missing key means the default. TOML has no null: WORDS has a word
for each field that may be None. A lens or scene file may be given by its path relative to the settings file.

Settings as a short text that fits into a chat message: “lensbench:” and the settings that differ from the defaults.

The text is JSON of plain settings, deflated, in the letters of URLs. It names lenses and scenes, and holds no files.

The settings of the last session, which the next one begins with: one file of the user.
"""

import base64
import binascii
import json
import re
import tomllib
import zlib
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any

from lensbench.app.session.export import read_settings, replacing
from lensbench.app.session.snapshots import moments_folder
from lensbench.app.settings.setting import SettingsError, spec
from lensbench.app.settings.settings import PICTURES, VERSION, Settings
from lensbench.core.text import MOST_CHARACTERS, cut, excerpt
from lensbench.lenses.file_error import open_regular

HEAD = "# lensbench: lengths in mm, angles in radians, times in seconds, exposure in stops\n"
WORDS = {field.name: spec(field).none for field in fields(Settings) if spec(field).none}    # for None
LONGEST = 1 << 20               # bytes read at most


def save_settings(path: str | Path, settings: Settings) -> None:
    """Write all settings, completely or not at all; ExportError if the file cannot be written."""
    values = {"version": VERSION, **asdict(settings)}
    lines = (f"{name} = {_toml(WORDS[name] if value is None else value)}\n" for name, value in values.items())
    with replacing(checked_path(path)) as part:
        part.write_text(HEAD + "".join(lines), encoding="utf-8")


def load_settings(path: str | Path) -> Settings:
    """Read settings, or those of an exported picture; SettingsError with the file, the line and the key at fault.

    ExportError for a picture without settings.
    """
    path = Path(path)
    if path.suffix.lower() in PICTURES:
        return read_settings(path)
    try:
        with open_regular(path) as file:
            raw = file.read(LONGEST + 1)
        if len(raw) > LONGEST:
            raise SettingsError(f"{path}: this is larger than {LONGEST >> 20} MB: that is no settings file")
        text = raw.decode("utf-8")
        plain = tomllib.loads(text)
    except OSError as error:
        raise SettingsError(f"{path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise SettingsError(f"{path}: this is no text in UTF-8") from error
    except SettingsError:
        raise
    except (ValueError, RecursionError) as error:       # of TOML, of a number of 5000 digits, of nested brackets
        raise SettingsError(f"{path}: this is no TOML: {cut(str(error), 4 * MOST_CHARACTERS)}") from error
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


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list | tuple):
        return f"[{', '.join(_toml(item) for item in value)}]"
    return repr(value)


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
    """The settings with the absolute paths of the files beside them: lens, scene, and the picture in the stop."""
    def place(text: str) -> str:
        try:
            path = (folder / text).resolve()
            return str(path) if path.suffix and path.is_file() else text
        except ValueError:              # not a valid file name
            return text

    return replace(settings, lens=place(settings.lens), scene=place(settings.scene),
                   stop_image=place(settings.stop_image))


PREFIX = "lensbench:"
LONGEST_TEXT = 1 << 16               # characters, and bytes of the JSON
DIGITS = 7                      # of a number: finer than any dial


def state_text(settings: Settings) -> str:
    """The settings as one word; numbers are rounded to DIGITS."""
    defaults = Settings().to_dict()
    plain = {name: _short(value) for name, value in settings.to_dict().items()
             if name == "version" or value != defaults[name]}
    packed = json.dumps(plain, ensure_ascii=False, separators=(",", ":"), allow_nan=False).encode()
    deflate = zlib.compressobj(9, zlib.DEFLATED, -15)
    return PREFIX + base64.urlsafe_b64encode(deflate.compress(packed) + deflate.flush()).decode().rstrip("=")


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


def left_behind(settings: Settings) -> list[str]:
    """Names of the files that the settings name, and that their text does not hold."""
    return [Path(name).name for name in (settings.lens, settings.scene, settings.stop_image)
            if Path(name).suffix and Path(name).is_file()]


def _short(value: object) -> object:
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    return [_short(part) for part in value] if isinstance(value, list | tuple) else value


def session_path() -> Path:
    """The file; it may not exist yet."""
    return moments_folder().parent / "session.toml"


def save_session(settings: Settings) -> None:
    """Write the settings beside their place, then rename; OSError or ExportError if that cannot be."""
    path = session_path()
    path.parent.mkdir(parents=True, exist_ok=True)
    save_settings(path, settings)


def last_session() -> Settings | None:
    """The settings of the last session; None before the first. ValueError or OSError for a file that cannot be read."""
    path = session_path()
    return load_settings(path) if path.exists() else None
