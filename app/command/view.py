"""The command `lensbench view`, the one without a command: the window."""

import argparse
import ctypes
import os
import sys
from pathlib import Path

from lensbench.app.bench.build import with_readable_stop
from lensbench.app.bench.constraints import constrained
from lensbench.app.command.lens_options import LENS_HELP, say
from lensbench.app.command.main import loading
from lensbench.app.command.options import add_picture_options, settings_from
from lensbench.app.command.output import UsageError, checked_screenshot_path
from lensbench.app.scenes.scene_file import cached_scene
from lensbench.app.session.file_kinds import file_kind
from lensbench.app.session.states import carries_settings, last_session
from lensbench.app.settings.settings import Settings

SCREENSHOT = "lensbench-window.png"     # where there is no display
LIBRARIES = ("libEGL.so.1", "libGL.so.1", "libX11.so.6", "libXext.so.6")
PACKAGES = "libegl1 libegl-mesa0 libgl1 libgl1-mesa-dri libx11-6 libxext6"     # that bring them, on Debian and Ubuntu


def add_view_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench view`."""
    parser.add_argument("lens", nargs="?", metavar="LENS", help=f"{LENS_HELP}, or any file that the window opens: "
                        "a scene, a mesh, a sky, a photograph, settings, a light field")
    add_picture_options(parser)
    parser.add_argument("--screenshot", metavar="FILE.png",
                        help="write a picture of the whole window and end; needs no display")


def view(arguments: argparse.Namespace) -> int:
    """Open the window, or write a picture of it; the exit code."""
    with loading():
        shot = arguments.screenshot or (None if _has_display() else SCREENSHOT)
        screenshot = None if shot is None else checked_screenshot_path(shot)
        opened = _opened_file(arguments)
        settings = settings_from(arguments)
        if arguments.stop_image is None:                # of a file or a text
            settings = with_readable_stop(settings, say)
        asked = {name for name, value in vars(arguments).items() if value is not None} - {"command"}
        if arguments.scene is not None:
            cached_scene(settings.scene)                    # refused here: the window would show another
        if not asked and opened is None and _has_display():
            settings = _last_session(settings)
        missing = [name for name in LIBRARIES if not _loads(name)] if sys.platform == "linux" else []
        if missing:
            raise UsageError(f"the window needs {', '.join(missing)}: on Debian or Ubuntu, apt-get install {PACKAGES}")
        from lensbench.app.window import window

    kept = arguments.settings is not None or carries_settings(arguments.lens or "")
    file = "The settings file" if arguments.settings else "The state text" if kept else ""
    follows = arguments.size is None and not kept       # the pixels of a size or a file that was asked for stay
    try:
        is_early = window.run(settings, screenshot=screenshot, follows=follows, opened=opened,
                              file=file if arguments.size is None else "")
    except OSError as error:
        raise UsageError(f"{screenshot}: {error.strerror}" if error.strerror else str(error)) from error
    if screenshot is None:
        return 0
    why = "" if arguments.screenshot else "no display: "
    print(f"{why}wrote the window to {screenshot}")
    if is_early:
        print("lensbench: the picture was not ready in time, the screenshot shows the window without it: "
              "run the command again, the kernels are compiled then", file=sys.stderr)
        return 1
    return 0


def _opened_file(arguments: argparse.Namespace) -> Path | None:
    """A mesh, sky, photograph or light field in the place of the lens, which the window opens; a scene or settings file
    there takes the place of its option.
    """
    given = arguments.lens
    if given is None or not os.path.isfile(given):
        return None
    path = Path(given).resolve()
    kind = file_kind(path)
    if kind in ("lens", "picture"):
        return None
    arguments.lens = None
    if kind in ("scene", "settings"):
        if getattr(arguments, kind) is not None:
            raise UsageError(f"{given} and --{kind} {getattr(arguments, kind)}: give one of them")
        setattr(arguments, kind, given)
        return None
    return path


def _last_session(otherwise: Settings) -> Settings:
    """The settings of the last session, if its lens and scene are still there."""
    try:
        last = last_session()
        return otherwise if last is None else constrained(with_readable_stop(last, say))
    except (ValueError, OSError) as error:
        say(f"the last session is not opened again: {error}")
        return otherwise


def _has_display() -> bool:
    if sys.platform != "linux":
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _loads(library: str) -> bool:
    try:
        ctypes.CDLL(library)
    except OSError:
        return False
    return True
