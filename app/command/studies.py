"""The commands that measure the program: `chart` its methods' speed and accuracy, `stability` where each method fails,
`bench` its speed on this machine.
"""

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, NamedTuple

from lensbench.core.text import excerpt, fixed, significant

if TYPE_CHECKING:
    from lensbench.app.studies.stability.sweep import Sweep


def add_bench_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench bench`."""
    from lensbench.app.benchmark.parts import LONG, parts
    from lensbench.app.command.lens_options import option

    parser.add_argument("part", nargs="*", type=option(read_part), help=f"parts to run: {', '.join(parts())} (default: "
                        f"all but the long ones, {', '.join(LONG)})")
    parser.add_argument("--only", type=option(read_parts), default=[], metavar="PART,…",
                        help="the same parts, with commas between them")
    parser.add_argument("--all", action="store_true", help="the long parts too")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")


def read_part(text: str) -> str:
    """The name of a part."""
    from lensbench.app.benchmark.parts import parts

    known = parts()
    if text not in known:
        raise ValueError(f"no part is called {excerpt(text)}: choose from {', '.join(known)}")
    return text


def read_parts(text: str) -> list[str]:
    """“pupil,tracer”: the names of parts."""
    return [read_part(word) for word in text.split(",") if word]


def bench(arguments: argparse.Namespace) -> int:
    """Run the named parts, or the usual ones; print each figure as it is measured, or JSON."""
    from lensbench.app.benchmark.parts import LONG, parts
    from lensbench.app.command.output import print_json
    from lensbench.app.studies.timing import machine

    known = parts()
    usual = [name for name in known if arguments.all or name not in LONG]
    figures: dict[str, dict[str, float | str]] = {}
    if not arguments.json:
        print(f"{machine()}, {time.strftime('%Y-%m-%d')}")
    for name in [*arguments.part, *arguments.only] or usual:
        for figure, value, unit in known[name]():
            figures[figure] = {"value": value, "unit": unit}
            if not arguments.json:
                print(f"{figure:<58}{significant(value, 4):>10} {unit}", flush=True)
    if arguments.json:
        print_json({"machine": machine(), "date": time.strftime("%Y-%m-%d"), "figures": figures})
    return 0


def add_chart_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench chart`."""
    from lensbench.app.command.lens_options import add_lens_options, option
    from lensbench.app.command.options import read_film, read_size
    from lensbench.app.settings.text_values import read_distance

    add = parser.add_argument
    add("lens", nargs="*", metavar="LENS", help="lenses of the library, or lens files (default: one of each kind)")
    add("-o", "--output", metavar="FILE", help=".svg or .png: the chart; .json: its numbers")
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
    from lensbench.app.studies.charts.curves import plain, table
    from lensbench.app.studies.charts.peers import PEERS, installed
    from lensbench.app.studies.charts.sheet import draw
    from lensbench.app.studies.charts.subjects import charts, subjects

    lenses, left_out = subjects(arguments)
    peers = installed()
    made = charts(lenses, report, peers)
    if len(peers) < len(PEERS):
        absent = ", ".join(name for name in PEERS if name not in peers)
        left_out.append(f"{absent}: not installed (pip install 'lensbench[peers]')")
    return Made([table(figure) for figure in made], plain(made),
                lambda path, heading: draw(made, path, arguments.summary, heading), left_out)


def _others(arguments: argparse.Namespace, report: Callable[[float], bool]) -> Made:
    from lensbench.app.studies.charts.curves import draw_panels, panel_table, plain_panels
    from lensbench.app.studies.charts.subjects import TITLES, panels

    made = panels(arguments, report)
    return Made([panel_table(panel) for panel in made], plain_panels(made),
                lambda path, heading: draw_panels(made, path, TITLES[arguments.of], heading), [])


def add_stability_options(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `lensbench stability`."""
    from lensbench.app.command.lens_options import option

    parser.add_argument("families", nargs="*", type=option(read_family), metavar="FAMILY",
                        help="family of methods, such as intersection (default: all)")
    parser.add_argument("-o", "--output", metavar="FOLDER", help="write a plot of each sweep and an index.md to FOLDER")
    parser.add_argument("--png", action="store_true", help="write plots as PNG instead of SVG")
    parser.add_argument("--json", action="store_true", help="print JSON: values, errors and verdicts of every method")


def read_family(text: str) -> str:
    """The one family whose name begins with a text; ValueError lists the families where there is not exactly one."""
    from lensbench.app.studies.stability.plots import FAMILIES

    families = [name for name in FAMILIES if text and name.lower().startswith(text.strip().lower())]
    if len(families) != 1:
        raise ValueError(f"“{text}”: the families are {', '.join(name.lower() for name in FAMILIES)}")
    return families[0]


def stability(arguments: argparse.Namespace) -> int:
    """Measure the sweeps, print them as a table or JSON, and write plots if a folder is given."""
    from lensbench.app.command.output import print_json, progress
    from lensbench.app.studies.stability.models import domains, save_domains
    from lensbench.app.studies.stability.plots import DOMAINS, FAMILIES, INDEX, file_name, save_index, save_plot
    from lensbench.app.studies.stability.sweep import progress_to

    folder = None if arguments.output is None else _made(Path(arguments.output))
    suffix = ".png" if arguments.png else ".svg"
    chosen = [(family, measure) for family, sweeps in FAMILIES.items()
              if not arguments.families or family in arguments.families for measure in sweeps.values()]
    sweeps_done: list[tuple[str, Sweep]] = []
    with progress() as show, progress_to(lambda share: show((len(sweeps_done) + share) / len(chosen))):
        for family, measure in chosen:
            show(len(sweeps_done) / len(chosen))
            sweeps_done.append((family, measure()))
            if folder is not None:
                save_plot(sweeps_done[-1][1], folder / file_name(*sweeps_done[-1], suffix))
    if folder is not None:
        maps = DOMAINS + suffix if "Models" in {family for family, _ in chosen} else ""
        if maps:
            save_domains(domains(), folder / maps)
        save_index(sweeps_done, folder, suffix, maps)
    if arguments.json:
        print_json([_data(family, sweep) for family, sweep in sweeps_done])
        return 0
    print("\n".join(_table(sweeps_done)))
    if folder is not None:
        print(f"\n{folder / INDEX}: {len(sweeps_done)} plots")
    return 0


def _made(folder: Path) -> Path:
    """The folder, created if it does not exist; ExportError if it cannot be created."""
    from lensbench.app.session.export import ExportError

    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise ExportError(f"{folder}: {error.strerror}: name a folder that can be written to") from error
    return folder


def _table(sweeps: "list[tuple[str, Sweep]]") -> list[str]:
    """Lines of a table: method, safe up to, fails at, result there; a star marks methods that the program relies on."""
    from lensbench.app.studies.stability.sweep import quantity_text

    rows = [[(curve, (("* " if curve.own else "  ") + curve.name, *sweep.words(curve))) for curve in sweep.curves]
            for _, sweep in sweeps]
    head = ("  Method", "Safe up to", "Fails at", "What it returns there")
    widths = [max(len(words[column]) for words in (head, *(words for group in rows for _, words in group)))
              for column in range(3)]

    def line(words: tuple[str, ...]) -> str:
        return "  ".join([*(text.ljust(width) for text, width in zip(words, widths, strict=False)), words[3]]).rstrip()

    lines = [line(head)]
    for (family, sweep), group in zip(sweeps, rows, strict=True):
        lines += ["", f"{family}: {sweep.title}, against {sweep.axis[:1].lower()}{sweep.axis[1:]}; "
                  f"limit {quantity_text(sweep.limit, sweep.measure_unit)}, {sweep.why}"]
        for curve, words in group:
            lines.append(line(words))
            if curve.own and curve.switch and words[2] != "never":
                lines.append(f"      there: {curve.switch}")
    return [*lines, "", "* the program relies on this method; the others are there for comparison"]


def _data(family: str, sweep: "Sweep") -> dict[str, Any]:
    """A sweep as JSON data; null where a method returned no number."""
    curves = []
    for curve in sweep.curves:
        verdict = sweep.verdict(curve)
        curves.append({"method": curve.name, "own": curve.own, "safe_up_to": verdict.safe_up_to,
                       "fails_at": verdict.fails_at, "returns": verdict.returns, "worst_in_safe_domain": verdict.worst,
                       "switch": curve.switch, "errors": [float(error) for error in curve.errors],
                       "returned": list(curve.returned)})
    return {"family": family, "sweep": sweep.title, "axis": sweep.axis, "unit": sweep.unit,
            "values": [float(value) for value in sweep.values], "measure": sweep.measure,
            "measure_unit": sweep.measure_unit, "limit": sweep.limit, "why": sweep.why, "note": sweep.note,
            "expected": list(sweep.expected), "methods": curves}
