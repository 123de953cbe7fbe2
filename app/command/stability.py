"""The command `lensbench stability`: a table of where each method fails, as text or JSON, and plots with an index."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from lensbench.app.studies.stability.sweep import Sweep


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
    from lensbench.app.studies.stability.families import FAMILIES

    found = [name for name in FAMILIES if text and name.lower().startswith(text.strip().lower())]
    if len(found) != 1:
        raise ValueError(f"“{text}”: the families are {', '.join(name.lower() for name in FAMILIES)}")
    return found[0]


def stability(arguments: argparse.Namespace) -> int:
    """Measure the sweeps, print them as a table or JSON, and write plots if a folder is given."""
    from lensbench.app.command.output import print_json, progress
    from lensbench.app.studies.stability.domains import domains, save_domains
    from lensbench.app.studies.stability.families import FAMILIES
    from lensbench.app.studies.stability.plots import DOMAINS, INDEX, file_name, save_index, save_plot
    from lensbench.app.studies.stability.sweep import progress_to

    folder = None if arguments.output is None else _made(Path(arguments.output))
    suffix = ".png" if arguments.png else ".svg"
    wanted = [(family, measure) for family, sweeps in FAMILIES.items()
              if not arguments.families or family in arguments.families for measure in sweeps.values()]
    found: list[tuple[str, Sweep]] = []
    with progress() as show, progress_to(lambda part: show((len(found) + part) / len(wanted))):
        for family, measure in wanted:
            show(len(found) / len(wanted))
            found.append((family, measure()))
            if folder is not None:
                save_plot(found[-1][1], folder / file_name(*found[-1], suffix))
    if folder is not None:
        maps = DOMAINS + suffix if "Models" in {family for family, _ in wanted} else ""
        if maps:
            save_domains(domains(), folder / maps)
        save_index(found, folder, suffix, maps)
    if arguments.json:
        print_json([_data(family, sweep) for family, sweep in found])
        return 0
    print("\n".join(_table(found)))
    if folder is not None:
        print(f"\n{folder / INDEX}: {len(found)} plots")
    return 0


def _made(folder: Path) -> Path:
    """The folder, created if it does not exist; ExportError if it cannot be created."""
    from lensbench.app.files.export import ExportError

    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise ExportError(f"{folder}: {error.strerror}: name a folder that can be written to") from error
    return folder


def _table(found: "list[tuple[str, Sweep]]") -> list[str]:
    """Lines of a table: method, safe up to, fails at, result there; a star marks methods that the program relies on."""
    from lensbench.app.studies.stability.sweep import quantity_text

    rows = [[(curve, (("* " if curve.own else "  ") + curve.name, *sweep.words(curve))) for curve in sweep.curves]
            for _, sweep in found]
    head = ("  Method", "Safe up to", "Fails at", "What it returns there")
    widths = [max(len(words[column]) for words in (head, *(words for group in rows for _, words in group)))
              for column in range(3)]

    def line(words: tuple[str, ...]) -> str:
        return "  ".join([*(text.ljust(width) for text, width in zip(words, widths, strict=False)), words[3]]).rstrip()

    lines = [line(head)]
    for (family, sweep), group in zip(found, rows, strict=True):
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
