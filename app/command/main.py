"""The command `lensbench`: open the bench, render a picture, print the data of a lens.

The exit code is 2 for bad input, with one line on stderr; 1 for a failure of the program, with its traceback where
LENSBENCH_DEBUG is set; 130 for Ctrl-C. Each command imports the heavy modules that it needs.
"""

import argparse
import ctypes
import gc
import os
import re
import sys
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, NoReturn

from lensbench.app.command.output import UsageError
from lensbench.core.text import MOST_CHARACTERS, cut, escaped

if TYPE_CHECKING:
    from lensbench.app.settings.settings import Settings

SCREENSHOT = "lensbench-window.png"     # where there is no display
LIBRARIES = ("libEGL.so.1", "libGL.so.1", "libX11.so.6", "libXext.so.6")
PACKAGES = "libegl1 libegl-mesa0 libgl1 libgl1-mesa-dri libx11-6 libxext6"     # that bring them, on Debian and Ubuntu


class _Parser(argparse.ArgumentParser):
    """A parser whose options are added when it is used, so that no command loads what another one needs."""

    add_options: Callable[[argparse.ArgumentParser], None] | None = None

    def parse_known_args(self, args=None, namespace=None):
        """Add the options, then parse; --help and errors of the usage pass here too."""
        add, self.add_options = self.add_options, None
        if add is not None:
            add(self)
        for argument in args or ():
            if argument.startswith("--") and argument.endswith("=--"):         # argparse would make it an empty list
                self.error(f"argument {argument[:-3]}: -- is no value")
        return super().parse_known_args(args, namespace)

    def error(self, message: str) -> NoReturn:
        short = re.sub(rf"\S{{{MOST_CHARACTERS + 1},}}", lambda word: cut(word[0]), message)
        raise UsageError(f"{cut(short, 20 * MOST_CHARACTERS)} (see {self.prog} --help)")


class _Version(argparse.Action):
    """The option --version."""

    def __call__(self, parser, namespace, values, option_string=None):
        """Print the version of the installed package and end."""
        from importlib.metadata import version

        print(f"lensbench {version('lensbench')}")
        parser.exit()


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command with these arguments (those of the process when None) and return its exit code."""
    try:
        code = _run(list(sys.argv[1:] if argv is None else argv))
        sys.stdout.flush()                              # here, where a closed pipe can be handled
        return code
    except SystemExit as ended:                         # --help, --version, a termination
        return ended.code if isinstance(ended.code, int) else 0
    except KeyboardInterrupt:
        return _end("stopped", 130)
    except BrokenPipeError:                             # the reader of the output has closed it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception as error:
        if os.environ.get("LENSBENCH_DEBUG"):
            raise
        if isinstance(error, UsageError) or isinstance(error, _mistakes()):
            return _end(str(error), 2)
        return _end(f"failed: {type(error).__name__}: {error} (LENSBENCH_DEBUG=1 shows where)", 1)


def _run(argv: list[str]) -> int:
    warnings.formatwarning = lambda message, *_, **__: f"lensbench: {escaped(str(message))}\n"
    with loading():
        arguments = parsed(argv or ["view"])
    return arguments.command(arguments)


def parsed(argv: Sequence[str]) -> argparse.Namespace:
    """The arguments of a command; its function is their `command`."""
    return _parser().parse_args(argv)


def _end(message: str, code: int) -> int:
    print(f"lensbench: {escaped(message)}", file=sys.stderr)
    return code


def _mistakes() -> tuple[type[Exception], ...]:
    """The errors that bad input can cause; their messages say what to do."""
    import lensbench as lb
    from lensbench import lenses
    from lensbench.app.command.lens_files import RaysError
    from lensbench.app.scenes.scene_file import SceneFileError
    from lensbench.app.session.export import ExportError
    from lensbench.app.settings.setting import SettingsError

    return (SettingsError, ExportError, SceneFileError, RaysError, lenses.LensFileError, lb.LensError,
            lb.LightFieldError, lb.GlassError, lb.MediumError, lb.ExposureError, lb.TransformError,
            lb.FilmError, lb.CameraError, lb.SceneError)


def _parser() -> argparse.ArgumentParser:
    from lensbench.app.command import (
        analyse, check, design, info, lens_files, lens_files as export, library, light_field, render, studies
    )

    parser = _Parser("lensbench", description="A bench of lenses and cameras: a real lens, rendered live, beside its "
                     "section. Without a command it opens the bench.")
    parser.add_argument("--version", action=_Version, nargs=0, help="show program's version number and exit")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for name, run, add, summary in (
            ("view", _view, _add_view_options, "Open the bench on a lens and a scene."),
            ("render", render.render, render.add_render_options, "Render a picture, or the frames of one that moves."),
            ("info", info.info, info.add_info_options,
             "Print provenance, first-order data, glasses and check of a lens."),
            ("lenses", library.library, library.add_library_options, "List the lenses of the library."),
            ("check", check.check, check.add_check_options, "Report what looks wrong in lens files."),
            ("convert", lens_files.convert, lens_files.add_convert_options,
             "Write a lens file in the format of another program."),
            ("export", export.export, export.add_export_options,
             "Write the camera of a picture for pbrt, Mitsuba or Blender."),
            ("trace", lens_files.trace, lens_files.add_trace_options, "Trace a table of rays through a lens."),
            ("analyse", analyse.analyse, analyse.add_analyse_options,
             "Draw spots, focus shift and other figures of a lens as a sheet, or write their numbers."),
            ("lightfield", None, light_field.add_light_field_options,
             "Record a light field through a lens; focus it afterwards."),
            ("improve", design.improve, design.add_improve_options,
             "Improve a lens by damped least squares on its radii, thicknesses or other numbers."),
            ("tolerances", design.tolerances, design.add_tolerance_options,
             "Show what errors of manufacture cost a lens, and the spread of many copies."),
            ("chart", studies.chart, studies.add_chart_options, "Chart the speed of methods against their accuracy."),
            ("stability", studies.stability, studies.add_stability_options,
             "Show where each numerical method breaks down, and what it returns there."),
            ("bench", studies.bench, studies.add_bench_options, "Measure the program's speed on this machine.")):
        command = commands.add_parser(name, help=summary, description=summary)
        command.set_defaults(command=run)
        command.add_options = add
    return parser


def _add_view_options(parser: argparse.ArgumentParser) -> None:
    from lensbench.app.command.lens_options import LENS_HELP
    from lensbench.app.command.options import add_picture_options

    parser.add_argument("lens", nargs="?", metavar="LENS", help=LENS_HELP)
    add_picture_options(parser)
    parser.add_argument("--screenshot", metavar="FILE.png",
                        help="write a picture of the whole window and end; needs no display")


@contextmanager
def loading() -> Iterator[None]:
    """Import without a search for garbage; what is there at the end is left out of all later searches.

    The window's modules and kernels stay to its end. Searched again and again they would delay the start by a tenth,
    and hold a frame up by 50 ms now and then.
    """
    gc.disable()
    try:
        yield
        gc.freeze()
    finally:
        gc.enable()


def _view(arguments: argparse.Namespace) -> int:
    with loading():
        from lensbench.app.bench.stop_picture import with_readable_stop
        from lensbench.app.command.lens_options import say
        from lensbench.app.command.options import carries_settings, settings_from
        from lensbench.app.command.output import checked_screenshot_path

        shot = arguments.screenshot or (None if _has_display() else SCREENSHOT)
        screenshot = None if shot is None else checked_screenshot_path(shot)
        settings = settings_from(arguments)
        if arguments.stop_image is None:                # of a file or a text
            settings = with_readable_stop(settings, say)
        asked = {name for name, value in vars(arguments).items() if value is not None} - {"command"}
        if arguments.scene is not None:
            from lensbench.app.scenes.scene_file import cached_scene

            cached_scene(settings.scene)                    # refused here: the window would show another
        if not asked and _has_display():
            settings = _last_session(settings)
        missing = [name for name in LIBRARIES if not _loads(name)] if sys.platform == "linux" else []
        if missing:
            raise UsageError(f"the window needs {', '.join(missing)}: on Debian or Ubuntu, apt-get install {PACKAGES}")
        from lensbench.app.window import window

    kept = arguments.settings is not None or carries_settings(arguments.lens or "")
    follows = arguments.size is None and not kept       # the pixels of a size or a file that was asked for stay
    try:
        is_early = window.run(settings, screenshot=screenshot, follows=follows)
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


def _last_session(otherwise: "Settings") -> "Settings":
    """The settings of the last session, if its lens and scene are still there."""
    from lensbench.app.bench.constraints import constrained
    from lensbench.app.bench.stop_picture import with_readable_stop
    from lensbench.app.command.lens_options import say
    from lensbench.app.session.settings_file import last_session

    try:
        last = last_session()
        return otherwise if last is None else constrained(with_readable_stop(last, say))
    except (ValueError, OSError) as error:
        print(f"lensbench: the last session is not opened again: {escaped(str(error))}", file=sys.stderr)
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


if __name__ == "__main__":
    sys.exit(main())
