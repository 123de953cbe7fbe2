"""The command `lensbench chart`: the speed of methods against their accuracy, measured on this machine."""

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

from lensbench.kernels.figures import fixed


def add_chart_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench chart`."""
    from lensbench.app.command.lens_options import add_lens_options, option
    from lensbench.app.command.options import read_film, read_size
    from lensbench.app.state.text_values import read_distance

    add = parser.add_argument
    add("lens", nargs="*", metavar="LENS", help="lenses of the library, or lens files (default: one of each kind)")
    add("-o", "--output", metavar="FILE", help=".svg or .png: the chart; .json: its figures")
    add("--of", choices=("models", "pupil", "focus", "image", "sampler"), default="models",
        help="subject of the chart: camera models (default), methods that sample the pupil, focus methods, whole "
             "pictures against render time, or samplers against white noise")
    add("--scene", action="append", metavar="SCENE", help="built-in scene for images and samplers; may be repeated")
    add("--summary", action="store_true", help="draw only the summary of several lenses, without a small chart of each")
    add_lens_options(parser)
    add("--focus", type=option(read_distance), metavar="DISTANCE",
        help="distance from the film to the plane in focus (default: 50 focal lengths)")
    add("--film", type=option(read_film), metavar="FILM",
        help="width x height in mm, or the name of a format (default: the part of 36x24 that the lens lights)")
    add("--size", type=option(read_size), metavar="WxH", help="pixels across and down (6000x4000)")
    add("--json", action="store_true", help="print JSON instead of tables")


def chart(arguments: argparse.Namespace) -> int:
    """Measure, print tables or JSON, and write the output file if one is given."""
    from lensbench.app.command.output import checked_chart_path, is_json, print_json, progress, save_json
    from lensbench.app.studies.timing import machine

    path = checked_chart_path(arguments.output)
    start = perf_counter()
    with progress() as show:
        made = _models(arguments, show) if arguments.of == "models" else _others(arguments, show)
    heading = f"{machine()}, {time.strftime('%Y-%m-%d')}; {fixed(perf_counter() - start, 0)} s"
    data = {"machine": machine(), "date": time.strftime("%Y-%m-%d"), "of": arguments.of, "left out": made.left_out,
            "charts": made.data}
    if arguments.json:
        print_json(data)
    else:
        print("\n\n".join([heading, *made.tables]))
    for line in made.left_out:
        print(f"Left out: {line}", file=sys.stderr)
    if path is None:
        return 0
    if is_json(path):
        save_json(path, data)
    else:
        made.draw(path, heading)
    if not arguments.json:
        print(f"\n{path}: written")
    return 0


class Made(NamedTuple):
    """A measurement as tables, as data, and as a function that draws it into a file; and the lenses left out."""

    tables: list[str]
    data: list[dict[str, Any]]
    draw: Callable[[Path, str], None]
    left_out: list[str]


def _models(arguments: argparse.Namespace, report: Callable[[float], bool]) -> Made:
    from lensbench.app.studies.charts.models import charts
    from lensbench.app.studies.charts.peers import PEERS, installed
    from lensbench.app.studies.charts.sheet import draw
    from lensbench.app.studies.charts.subjects import subjects
    from lensbench.app.studies.charts.table import plain, table

    found, left_out = subjects(arguments)
    peers = installed()
    made = charts(found, report, peers)
    if len(peers) < len(PEERS):
        absent = ", ".join(name for name in PEERS if name not in peers)
        left_out.append(f"{absent}: not installed (pip install 'lensbench[peers]')")
    return Made([table(each) for each in made], plain(made),
                lambda path, heading: draw(made, path, arguments.summary, heading), left_out)


def _others(arguments: argparse.Namespace, report: Callable[[float], bool]) -> Made:
    from lensbench.app.studies.charts.curves import draw_panels, panel_table, plain_panels
    from lensbench.app.studies.charts.panels import TITLES, panels

    made = panels(arguments, report)
    return Made([panel_table(each) for each in made], plain_panels(made),
                lambda path, heading: draw_panels(made, path, TITLES[arguments.of], heading), [])
