"""The command `lensbench contact-sheet`: several lenses in one framing, or snapshots, in one picture with captions."""

import argparse
import os
from dataclasses import replace
from pathlib import Path

from lensbench.app.command.output import UsageError, progress

OWN = ("lenses", "output", "seconds", "threads", "command")      # arguments that are not about a render


def add_contact_sheet_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench contact-sheet`."""
    from lensbench.app.command.lens_options import option
    from lensbench.app.command.options import add_picture_options
    from lensbench.app.settings.text_values import read_count, read_time

    add = parser.add_argument
    add("lenses", nargs="+", metavar="LENS", help="lenses of the library, lens files, what to search the library for, "
        "such as “six 50 mm lenses”; or snapshots and pictures exported as .png or .ppm, shown as they are")
    add_picture_options(parser)
    add("-o", "--output", required=True, metavar="FILE", help="a grid as .png or .jpg; the pictures one after the "
        "other as .gif or .webp")
    add("--seconds", type=option(read_time), metavar="TIME", help="that .gif and .webp show each picture (1.2s)")
    add("--threads", type=option(read_count), metavar="N", help="threads; one a core by default")


def contact_sheet(arguments: argparse.Namespace) -> int:
    """Write the sheet that the arguments ask for; the exit code, 1 where a lens has no picture."""
    from lensbench import lenses
    from lensbench.app.bench.constraints import with_longer_side
    from lensbench.app.command.lens_options import say
    from lensbench.app.command.options import settings_from
    from lensbench.app.session.contact_sheet import (
        MOVING, SECONDS, Cell, checked_sheet, found_lenses, rendered_cells, write_sheet
    )
    from lensbench.app.session.export import check_writable
    from lensbench.app.session.snapshots import read_snapshot
    from lensbench.app.workers.compilers import compiling_ahead

    path, seconds = checked_sheet(Path(arguments.output)), arguments.seconds or SECONDS
    check_writable(path)
    if arguments.seconds is not None and path.suffix.lower() not in MOVING:
        say(f"--seconds has no effect on {path}: a grid does not move; give {' or '.join(MOVING)}")
    names, cells, problems = list[str](), list[Cell](), 0
    for text in arguments.lenses:
        if Path(text).suffix.lower() in (".exr", ".pfm"):
            raise UsageError(f"{text} holds linear light, without a look of its own: export the picture as .png")
        if Path(text).suffix.lower() in (".png", ".ppm"):
            cells.append(Cell.of(read_snapshot(Path(text))))
        elif " " in text and text not in lenses.names() and not os.path.exists(text):
            try:
                matching, count = found_lenses(text)
            except ValueError as error:
                raise UsageError(str(error)) from error
            names += matching[:count]
            say(f"“{text}”: {', '.join(matching[:count])}")
        else:
            names.append(str(Path(text).resolve()) if Path(text).is_file() else text)
    checked_sheet(path, len(names) + len(cells), seconds)
    if names:
        arguments.lens = names[0]
        settings = settings_from(arguments)
        if not settings.has_lens:
            raise UsageError(f"the camera {settings.camera} has no lens: leave out --camera")
        if arguments.size is None:
            settings = with_longer_side(settings, 480)
        if arguments.samples is None and arguments.settings is None:
            settings = replace(settings, samples=64)
        with compiling_ahead(settings.scene), progress() as show:
            for cell in rendered_cells(settings, names, show, threads=arguments.threads):
                if isinstance(cell, Cell):
                    cells.append(cell)
                else:
                    problems += 1
                    say(cell)
    else:
        for name in sorted(set(vars(arguments)) - set(OWN)):
            if getattr(arguments, name) is not None:
                say(f"--{name.replace('_', '-')} has no effect on snapshots, which are shown as they are: name a lens")
    write_sheet(path, cells, seconds)
    print(f"{path}: {len(cells)} picture{'s' if len(cells) > 1 else ''}")
    return 1 if problems else 0
