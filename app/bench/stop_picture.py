"""Picture files for the stop in the settings: each read once, and a sentence about one that cannot be."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import lensbench as lb
from lensbench.app.scenes.file_cache import Stamp, file_stamp, keeps_last_good
from lensbench.app.settings.setting import SettingsError
from lensbench.app.settings.settings import Settings
from lensbench.core.text import excerpt
from lensbench.lenses.stop_picture import read_picture


def stop_picture(path: str) -> lb.StopImage:
    """The picture of a file, read once for each change of it.

    SettingsError where it cannot be read, is larger than MOST_PIXELS, or passes no light.
    """
    return _read(path, file_stamp(path))


def with_readable_stop(settings: Settings, say: Callable[[str], object]) -> Settings:
    """The settings without a picture in the stop that cannot be read; `say` receives a sentence on it."""
    if settings.stop_image:
        try:
            stop_picture(settings.stop_image)
        except SettingsError as error:
            say(f"{error}; the stop opens without it")
            return replace(settings, stop_image="")
    return settings


def stop_picture_path(settings: Settings, text: str) -> str:
    """The absolute path of a picture that was typed: relative to the folder of the lens file, else to the present one.

    SettingsError where neither folder has it; the message names them.
    """
    lens = Path(settings.lens)
    folders = ([lens.resolve().parent] if settings.has_lens and lens.suffix and lens.is_file() else []) + [Path.cwd()]
    places = [(folder / Path(text.strip()).expanduser()).resolve() for folder in folders]
    for place in places:
        if place.is_file():
            return str(place)
    named = " and ".join(dict.fromkeys(str(place.parent) for place in places))
    raise SettingsError(f"there is no picture {excerpt(Path(text.strip()).name)} in {named}")


@keeps_last_good(8)
def _read(path: str, _stamp: Stamp) -> lb.StopImage:
    try:
        return read_picture(path)
    except lb.StopImageError as error:
        raise SettingsError(str(error)) from error
