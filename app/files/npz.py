"""Arrays with settings in .npz, as used by the files of light fields and of lumigraphs."""

import json
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from lensbench.app.files.export import ExportError, replacing
from lensbench.app.state.settings import Settings

SUFFIX = ".npz"


def checked_suffix(path: str | Path) -> Path:
    """The path; ExportError if its suffix is not .npz."""
    path = Path(path)
    if path.suffix.lower() != SUFFIX:
        raise ExportError(f"{path}: light fields are written as {SUFFIX}")
    return path


def save_arrays(path: str | Path, settings: Settings, **arrays) -> None:
    """Write arrays and numbers with the settings; ExportError if they cannot be written."""
    path = checked_suffix(path)
    text = np.array(json.dumps(settings.to_dict(), allow_nan=False))
    with replacing(path) as part, part.open("wb") as file:
        np.savez(file, settings=text, **arrays)


def load_arrays(path: Path, what: str, maker: str, wanted: Callable[[set[str]], Sequence[str]],
                say: Callable[[str], object]) -> tuple[dict[str, np.ndarray], Settings]:
    """The arrays of a file, by name, and its settings.

    what: the kind of file, in words. maker: the command that records one. wanted: maps the
    names in the file to those to read; to none for another kind of file. `say` receives a sentence if names of an
    earlier version occur. ExportError if the file is missing, of another kind, incomplete, or has invalid settings.
    """
    try:
        if not zipfile.is_zipfile(path) and path.is_file():
            raise ExportError(f"{path}: this is no {what}, or one that was cut short")
        with np.load(path, allow_pickle=False) as archive:
            names = set(archive.files) if isinstance(archive, np.lib.npyio.NpzFile) else set()
            read = wanted(names) if "settings" in names else ()
            if not read:
                raise ExportError(f"{path}: this is no {what}; lensbench lightfield {maker} records one")
            found, text = {name: archive[name] for name in read}, str(archive["settings"])
    except ExportError:
        raise
    except OSError as error:
        raise ExportError(f"{path}: {error.strerror or error}") from error
    except (ValueError, EOFError, zipfile.BadZipFile, KeyError) as error:
        raise ExportError(f"{path}: this {what} is cut short or damaged ({error})") from error
    try:
        return found, Settings.from_dict(json.loads(text), lambda note: say(f"{path}: {note}"))
    except (ValueError, TypeError) as error:
        raise ExportError(f"{path}: {error}") from error
