"""The commands about files of other programs: `convert A B`, `export` of a camera, `trace LENS --rays rays.csv`.

Rays are read and written as tables: x, y, z (mm, lens frame: the first vertex is the origin, light travels along +z)
and the direction l, m, n, of any length when read and a unit vector when written. Each number is written with enough
digits to read it back to the last bit.
"""

import argparse
import json
import math
import re
import sys
from collections.abc import Iterable
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import Any, TextIO

from lensbench.app.command.output import UsageError
from lensbench.core.optics.finding import Finding, Kind
from lensbench.core.text import excerpt, fixed, significant
from lensbench.lenses.file_error import open_regular


def add_export_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench export`."""
    from lensbench.app.command.lens_options import LENS_HELP
    from lensbench.app.command.options import add_picture_options

    parser.add_argument("what", choices=("camera",), help="what to write: the camera, with its place and its film")
    parser.add_argument("lens", nargs="?", metavar="LENS", help=f"{LENS_HELP}; not needed for a --camera without one")
    add_picture_options(parser)
    parser.add_argument("--to", required=True, choices=("pbrt", "mitsuba", "blender"), help="for which program")
    parser.add_argument("-o", "--output", required=True, metavar="FILE",
                        help="the file: .pbrt with the lens as .dat next to it, .xml, or .py for Blender")


def export(arguments: argparse.Namespace) -> int:
    """Write what the arguments ask for; the exit code."""
    from lensbench.app.bench.camera_kinds import camera
    from lensbench.app.command.lens_options import say
    from lensbench.app.command.options import settings_from
    from lensbench.app.session.camera_export import PROGRAMS, export_camera
    from lensbench.app.session.export import check_writable
    from lensbench.app.settings.camera_facts import CAMERA_KINDS

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


COLUMNS = ("x", "y", "z", "l", "m", "n")
NAMES = {"dx": "l", "dy": "m", "dz": "n", "origin_x": "x", "origin_y": "y", "origin_z": "z"}
OUT = (*COLUMNS, "fate", "surface")
LARGEST_TABLE = 200_000_000         # bytes


class RaysError(UsageError):
    """A ray table that cannot be read or written; the message says where."""


def add_convert_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench convert`."""
    parser.add_argument("source", metavar="A", help="a lens of the library, or a lens file")
    parser.add_argument("target", metavar="B", help="the file to write; its suffix says the format")
    parser.add_argument("--scale", type=float, default=1.0, metavar="FACTOR",
                        help="make the lens this many times as large")
    parser.add_argument("--reverse", action="store_true", help="reverse the lens, front to rear")
    _add_position_options(parser)


def convert(arguments: argparse.Namespace) -> int:
    """Write a lens in the format of the target's suffix; print the findings and what the format cannot hold."""
    from lensbench import lenses
    from lensbench.app.bench.zoom import positioned
    from lensbench.core.optics.lens_surface import LensError
    from lensbench.lenses.editing.document import EditError, LensDocument, lost_edits
    from lensbench.lenses.editing.elements import reversed_lens
    from lensbench.lenses.editing.structure import scaled
    from lensbench.lenses.tables.stations import at_one_position

    source, target = arguments.source, Path(arguments.target)
    document, lost = lenses.load_document(source), list[lenses.Finding]()
    if arguments.zoom is not None or arguments.close is not None:
        lost += lost_edits(document, "they hold at all positions, and one alone is written")
        document = LensDocument(at_one_position(positioned(document.lens, arguments)))
    with suppress(OSError):
        if target.exists() and target.samefile(source):
            raise lenses.LensFileError(target, None, "this is the file to be converted: name another one to write")
    if arguments.scale != 1.0:
        try:
            document = scaled(document, arguments.scale)
        except EditError as error:
            raise LensError(f"--scale {significant(arguments.scale)}: {error}") from None
    if arguments.reverse:
        lost += lost_edits(document, "they belong to the surfaces before the reversal")
        document = LensDocument(reversed_lens(document.lens))
    remarks, lens = (*lost, *lenses.save(document, target)), document.lens
    print(f"{target}: {len(lens.surfaces)} surfaces, the stop at surface {lens.stop_index}")
    print("".join(f"Found: {finding}\n" for finding in lens.findings), end="")
    print_remarks(remarks, sys.stdout)
    return 0


def print_remarks(remarks: Iterable[Finding], to: TextIO) -> None:
    """One line for each remark of `lenses.save`: what was written besides, and what was not kept."""
    besides = (Kind.BESIDE, Kind.ASSUMED, Kind.BACK_FOCUS)
    for remark in remarks:
        print(f"{'Also' if remark.kind in besides else 'Not kept'}: {remark}", file=to)


def add_trace_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench trace`."""
    parser.add_argument("lens", metavar="LENS", help="a lens of the library, or a lens file")
    parser.add_argument("--rays", required=True, metavar="RAYS.csv",
                        help="columns x y z (mm, from the first vertex) and l m n (direction); - is the standard input")
    parser.add_argument("-o", "--output", metavar="FILE", help="a .csv or .json file; the standard output by default")
    parser.add_argument("--wavelength", type=float, default=None, metavar="UM",
                        help="in µm, such as 0.55; the d line by default")
    parser.add_argument("--no-clip", action="store_true", help="let rays pass outside the clear apertures and the stop")
    parser.add_argument("--json", action="store_true", help="print JSON: a list for each column")
    _add_position_options(parser)


def _add_position_options(parser: argparse.ArgumentParser) -> None:
    from lensbench.app.command.lens_options import add_close_option, add_zoom_option

    add_zoom_option(parser)
    add_close_option(parser)


def trace(arguments: argparse.Namespace) -> int:
    """Trace the rays of a table through a lens; write their end points, directions and fates."""
    import lensbench as lb
    from lensbench import lenses
    from lensbench.app.bench.zoom import positioned
    from lensbench.app.command.lens_options import say
    from lensbench.app.session.export import check_writable, replacing
    from lensbench.core.analysis.grids.field_conditions import check_wavelength, unknown_dispersion

    suffix = Path(arguments.output).suffix.lower() if arguments.output else (".json" if arguments.json else ".csv")
    if suffix not in (".csv", ".json"):
        raise RaysError(f"{arguments.output}: rays are written as .csv or .json")
    if arguments.output:
        check_writable(Path(arguments.output))
    lens = positioned(lenses.load(arguments.lens), arguments)
    rays = read_rays(arguments.rays)
    wavelength = lb.D_LINE if arguments.wavelength is None else arguments.wavelength
    check_wavelength(wavelength)
    if wavelength != lb.D_LINE:
        for finding in unknown_dispersion(lens):
            say(f"{arguments.lens}: {finding}")
    traced = lb.trace(lens, [ray[:3] for ray in rays], [ray[3:] for ray in rays], wavelength=wavelength,
                      clip=not arguments.no_clip)
    columns: dict[str, list[Any]] = {name: traced.points[:, i].tolist() for i, name in enumerate("xyz")}
    columns |= {name: traced.directions[:, i].tolist() for i, name in enumerate("lmn")}
    columns["fate"] = [lb.Fate(fate).name for fate in traced.fate]
    columns["surface"] = traced.surface.tolist()
    text = json.dumps(columns) + "\n" if suffix == ".json" else _csv(columns)
    if arguments.output:
        with replacing(Path(arguments.output)) as partial_file:
            partial_file.write_text(text, encoding="utf-8", newline="\n")
        counts = {name: columns["fate"].count(name) for name in dict.fromkeys(columns["fate"])}
        print(f"{arguments.output}: {len(rays)} rays: {', '.join(f'{n} {name}' for name, n in counts.items())}")
    else:
        sys.stdout.write(text)
    return 0


def read_rays(path: str) -> list[list[float]]:
    """The rays of a table, six numbers each: x y z l m n.

    Commas, semicolons, tabs or blanks separate the columns, which are in that order or as
    a heading names them; empty lines and what follows a # are left out. RaysError:
    the line, and what is wrong in it.
    """
    try:
        with nullcontext(sys.stdin.buffer) if path == "-" else open_regular(path) as file:
            data = file.read(LARGEST_TABLE + 1)
        if len(data) > LARGEST_TABLE:
            raise RaysError(f"{path}: more than {fixed(LARGEST_TABLE / 1e6, 0)} MB are too many rays for one table")
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise RaysError(f"{path}: this is no text; rays are a table of columns {' '.join(COLUMNS)}") from None
    except OSError as error:
        raise RaysError(f"{path}: {error.strerror or error}") from None
    rays: list[list[float]] = []
    order = list(range(6))
    first = True
    for line, content in enumerate(text.splitlines(), start=1):
        cells = _cells(content.partition("#")[0])
        if not cells:
            continue
        if first and any(re.fullmatch(r"[A-Za-z_]\w*(\s*\(\w+\))?", cell) and not _is_float(cell) for cell in cells):
            order, first = _order(cells, f"{path}:{line}"), False
            continue
        first = False
        if len(cells) <= max(order):
            raise RaysError(f"{path}:{line}: a ray needs {max(order) + 1} columns ({' '.join(COLUMNS)}), "
                            f"this one has {len(cells)}")
        rays.append(_ray([cells[i] for i in order], f"{path}:{line}"))
    if not rays:
        raise RaysError(f"{path}: there are no rays; a ray is a line with {' '.join(COLUMNS)}")
    return rays


def _cells(content: str) -> list[str]:
    """The values of a line."""
    content = content.strip()
    for sign in (";", "\t", ","):
        if sign in content:
            return [cell.strip().strip('"') for cell in content.split(sign)]
    return content.split()


def _order(cells: list[str], position: str) -> list[int]:
    """Indices of the six columns, from a heading."""
    names = [re.sub(r"\s*\(.*\)", "", cell).strip().lower() for cell in cells]
    names = [NAMES.get(name, name) for name in names]
    for name in COLUMNS:
        if names.count(name) != 1:
            raise RaysError(f"{position}: the heading needs one column {excerpt(name)} (columns: {' '.join(COLUMNS)})")
    return [names.index(name) for name in COLUMNS]


def _is_float(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _ray(cells: list[str], position: str) -> list[float]:
    """The six finite numbers of a ray; RaysError if the last three are all 0."""
    numbers = []
    for name, cell in zip(COLUMNS, cells, strict=True):
        if not _is_float(cell) or not math.isfinite(float(cell)):
            raise RaysError(f"{position}: {name} is {excerpt(cell)}: it must be a finite number")
        numbers.append(float(cell))
    if not any(numbers[3:]):
        raise RaysError(f"{position}: the direction l m n is 0 0 0")
    return numbers


def _csv(columns: dict[str, list[Any]]) -> str:
    rows = (",".join(repr(value) if isinstance(value, float) else str(value) for value in row)
            for row in zip(*(columns[name] for name in OUT), strict=True))
    return "\n".join([",".join(OUT), *rows, ""])
