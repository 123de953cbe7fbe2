"""Settings as TOML files, to repeat a picture; users can read and edit them.

The keys are the fields of Settings, in their units; a missing key means the default. TOML has no null: WORDS has a word
for each field that may be None. A lens or scene file may be given by its path relative to the settings file.
"""

import json
import re
import tomllib
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any

from lensbench.app.files.export import read_settings, replacing
from lensbench.app.state.setting import spec
from lensbench.app.state.settings import PICTURES, VERSION, Settings, SettingsError
from lensbench.kernels.quotation import MOST, cut
from lensbench.lenses.regular_file import open_regular

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
        raise SettingsError(f"{path}: this is no TOML: {cut(str(error), 4 * MOST)}") from error
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
