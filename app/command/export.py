"""The command `lensbench export`: the camera of a picture in the words of another renderer."""

import argparse
from pathlib import Path


def add_export_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench export`."""
    from lensbench.app.command.lens_options import LENS_HELP
    from lensbench.app.command.options import add_picture_options

    parser.add_argument("what", choices=("camera",), help="what to write: the camera, with its place and its film")
    parser.add_argument("lens", nargs="?", metavar="LENS", help=f"{LENS_HELP}; not needed for a --camera without one")
    add_picture_options(parser)
    parser.add_argument("--to", required=True, choices=("pbrt", "mitsuba", "blender"), help="for which program")
    parser.add_argument("-o", "--output", required=True, metavar="FILE",
                        help="the file: .pbrt with the lens as .dat beside it, .xml, or .py for Blender")


def export(arguments: argparse.Namespace) -> int:
    """Write what the arguments ask for; the exit code."""
    from lensbench.app.command.errors import UsageError
    from lensbench.app.command.lens_options import say
    from lensbench.app.command.options import settings_from
    from lensbench.app.files.camera_export import PROGRAMS, export_camera
    from lensbench.app.files.export import check_writable
    from lensbench.app.state.camera_facts import CAMERA_KINDS
    from lensbench.app.state.camera_kinds import camera

    if CAMERA_KINDS[arguments.camera or "lens"].has_lens and arguments.lens is None and arguments.settings is None:
        raise UsageError("which LENS? Name one, or a --camera without a lens")
    path = Path(arguments.output)
    if path.suffix.lower() != PROGRAMS[arguments.to]:
        raise UsageError(f"{path}: cameras for {arguments.to} are {PROGRAMS[arguments.to]} files")
    check_writable(path)
    try:
        remarks = export_camera(camera(settings_from(arguments)), arguments.to, path)
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror or error}") from error
    for remark in remarks:
        say(remark)
    print(f"{path}: camera for {arguments.to}")
    return 0
