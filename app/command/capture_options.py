"""Options and output file of the commands that capture a light field."""

import argparse
import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lensbench.app.settings.settings import Settings

MOST_VIEWS = 999


def read_views(text: str) -> tuple[int, int]:
    """Views across and down, from a text such as “9x9”; ValueError for other texts."""
    match = re.fullmatch(r"\s*(\d{1,3})\s*[x×]\s*(\d{1,3})\s*", text.lower())
    if match is None or not (int(match[1]) and int(match[2])):
        raise ValueError(f"“{text}”: type views across and down, 1 to {MOST_VIEWS}, such as 9x9")
    return int(match[1]), int(match[2])


def prepare_capture(arguments: argparse.Namespace) -> "tuple[Settings, Path]":
    """The settings of a capture and its output file, which is checked to be writable before the work begins.

    What a light field does not record is left out of the settings, and named.
    """
    from lensbench.app.command.lens_options import say
    from lensbench.app.command.options import settings_from
    from lensbench.app.session.export import check_writable
    from lensbench.app.session.recordings import checked_suffix

    settings = settings_from(arguments)
    report_scene(settings.scene)
    if arguments.samples is None and arguments.settings is None:
        settings = replace(settings, samples=16)
    path = checked_suffix(arguments.output)
    check_writable(path)
    added = " and ".join(name for name in ("ghosts", "stars") if getattr(settings, name))
    if added:
        say(f"{added} are left out: a light field records direct light alone")
    if settings.sample_view:
        say(f"the view {settings.view} is left out: a light field records light")
    return replace(settings, ghosts=False, stars=False, view="picture"), path


def report_scene(name_or_path: str) -> None:
    """Print what the reader of a scene file changed or assumed."""
    from lensbench.app.command.lens_options import say
    from lensbench.app.scenes.scene_file import cached_scene

    for note in cached_scene(name_or_path).notes:
        say(f"{name_or_path}: {note}")
