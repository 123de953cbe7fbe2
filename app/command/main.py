"""The command `lensbench`: its table of commands, errors and exit codes.

The exit code is 2 for bad input, with one line on stderr; 1 for a failure of the program, with its traceback where
LENSBENCH_DEBUG is set; 130 for Ctrl-C. The module of a command is imported when that command is used.
"""

import argparse
import gc
import os
import re
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from typing import NoReturn

from lensbench.app.command.output import UsageError
from lensbench.core.text import MOST_CHARACTERS, cut, escaped

# Of each command: the module with its functions `NAME` and `add_NAME_options`, and what it does
COMMANDS = {
    "view": ("view", "Open the bench on a lens and a scene."),
    "render": ("render", "Render a picture, or the frames of one that moves."),
    "contact-sheet": ("contact_sheet", "Render several lenses in one framing, or join snapshots, in one picture."),
    "info": ("info", "Print provenance, first-order data, glasses and check of a lens."),
    "lenses": ("info", "List the lenses of the library."),
    "scenes": ("info", "List the built-in scenes, a line each."),
    "check": ("info", "Report what looks wrong in lens files."),
    "convert": ("lens_files", "Write a lens file in the format of another program."),
    "export": ("lens_files", "Write the camera of a picture for pbrt, Mitsuba or Blender."),
    "trace": ("lens_files", "Trace a table of rays through a lens."),
    "analyse": ("analyse", "Draw spots, focus shift and other plots of a lens as a sheet, or write their numbers."),
    "lightfield": ("light_field", "Record a light field through a lens; focus it afterwards."),
    "improve": ("design", "Improve a lens by damped least squares on its radii, thicknesses or other numbers."),
    "tolerances": ("design", "Show what errors of manufacture cost a lens, and the spread of many copies."),
    "chart": ("studies", "Chart the speed of methods against their accuracy."),
    "stability": ("studies", "Show where each numerical method breaks down, and what it returns there."),
    "bench": ("studies", "Measure the program's speed on this machine."),
}


class _Parser(argparse.ArgumentParser):
    """A parser of the command `name`; the module of the command adds its options when they are parsed."""

    name = ""

    def parse_known_args(self, args=None, namespace=None):
        """Add the options, then parse; --help and errors of the usage pass here too."""
        if self.name:
            module = import_module(f"lensbench.app.command.{COMMANDS[self.name][0]}")
            function = self.name.replace("-", "_")
            self.set_defaults(command=getattr(module, function, None))      # sub-commands bring theirs
            getattr(module, f"add_{function}_options")(self)
            self.name = ""
        for argument in args or ():
            if argument.startswith("--") and argument.endswith("=--"):         # argparse would make it an empty list
                self.error(f"argument {argument[:-3]}: -- is not a value")
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
    from lensbench.app.scenes.scene_file import SceneFileError
    from lensbench.app.session.export import ExportError
    from lensbench.app.settings.setting import SettingsError

    return (SettingsError, ExportError, SceneFileError, lenses.LensFileError, lb.LensError,
            lb.LightFieldError, lb.GlassError, lb.MediumError, lb.ExposureError, lb.TransformError,
            lb.FilmError, lb.CameraError, lb.SceneError)


def _parser() -> argparse.ArgumentParser:
    parser = _Parser("lensbench", description="A bench of lenses and cameras: a real lens, rendered live, next to its "
                     "section. Without a command it opens the bench.")
    parser.add_argument("--version", action=_Version, nargs=0, help="show program's version number and exit")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for name, (_, summary) in COMMANDS.items():
        commands.add_parser(name, help=summary, description=summary).name = name
    return parser


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


if __name__ == "__main__":
    sys.exit(main())
