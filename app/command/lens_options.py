"""The command-line options of single settings, and those that change a lens. Imports no optics."""

import argparse
import sys
from collections.abc import Callable
from dataclasses import Field, fields
from typing import Any

from lensbench.app.settings.camera_facts import LensSettings
from lensbench.app.settings.setting import spec
from lensbench.app.settings.text_values import read_aperture, read_close, read_zoom
from lensbench.core.text import escaped

LENS_HELP = "a lens of the library (see `lensbench lenses`), a lens file, or an exported picture with its settings"


def option(read: Callable[[str], Any]) -> Callable[[str], Any]:
    """A reader for argparse, whose message reaches the user."""
    def convert(text: str) -> Any:
        try:
            return read(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None
    return convert


def add_zoom_option(parser: argparse.ArgumentParser) -> None:
    """The option --zoom."""
    parser.add_argument("--zoom", type=option(read_zoom), metavar="ZOOM",
                        help="of a zoom lens: from 0 (wide) to 1 (tele), or a focal length such as 105mm")


def add_close_option(parser: argparse.ArgumentParser) -> None:
    """The option --close, which moves the focus groups, for commands without a focus distance."""
    parser.add_argument("--close", type=option(read_close), metavar="CLOSE",
                        help="of a lens that focuses by groups: from 0 (infinity) to 1 (their nearest position)")


def add_lens_options(parser: argparse.ArgumentParser) -> None:
    """The options that change the lens itself."""
    add_zoom_option(parser)
    for field in fields(LensSettings):
        if spec(field).help:
            add_setting(parser, field)
    parser.add_argument("--f-number", type=option(read_aperture), metavar="N", default=argparse.SUPPRESS,
                        help="aperture, such as 2.8 or f/2.8; “open”, as wide as the lens goes, by default")


def add_setting(parser: argparse.ArgumentParser, of: Field) -> None:
    """The option of one setting."""
    about = spec(of)
    form: dict[str, Any] = {"dest": dest(of), "default": None}
    if about.read is not None:
        form |= {"type": option(about.read), "metavar": about.metavar}
    elif about.choices:
        form |= {"choices": about.choices, "metavar": about.metavar or None}
    name = _option_name(of)
    if of.type is bool:
        parser.add_argument(name, action=argparse.BooleanOptionalAction, help=about.help, **form)
    else:
        parser.add_argument(name, help=about.help, **form)


def _option_name(of: Field) -> str:
    """The option of a setting, with its two dashes."""
    return "--" + (spec(of).option or of.name.replace("_", "-"))


def dest(of: Field) -> str:
    """The attribute of the parsed arguments that holds a setting."""
    return _option_name(of)[2:].replace("-", "_")


def say(text: str) -> None:
    """One line on stderr, besides what the command prints."""
    print(f"lensbench: {escaped(text)}", file=sys.stderr)
