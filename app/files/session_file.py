"""The settings of the last session, which the next one begins with: one file of the user."""

from pathlib import Path

from lensbench.app.files.moment_shelf import moments_folder
from lensbench.app.files.settings_file import load_settings, save_settings
from lensbench.app.state.settings import Settings


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
