"""The command `lensbench bench`: figures of the program's speed on this machine, as a table or JSON."""

import argparse
import time

from lensbench.kernels.figures import significant
from lensbench.kernels.quotation import excerpt


def add_bench_options(parser: argparse.ArgumentParser) -> None:
    """The arguments of `lensbench bench`."""
    from lensbench.app.command.lens_options import option
    from lensbench.app.studies.benchmark.parts import LONG, parts

    parser.add_argument("part", nargs="*", type=option(read_part), help=f"parts to run: {', '.join(parts())} (default: "
                        f"all but the long ones, {', '.join(LONG)})")
    parser.add_argument("--only", type=option(read_parts), default=[], metavar="PART,…",
                        help="the same parts, with commas between them")
    parser.add_argument("--all", action="store_true", help="the long parts too")
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")


def read_part(text: str) -> str:
    """The name of a part."""
    from lensbench.app.studies.benchmark.parts import parts

    known = parts()
    if text not in known:
        raise ValueError(f"no part is called {excerpt(text)}: choose from {', '.join(known)}")
    return text


def read_parts(text: str) -> list[str]:
    """“pupil,tracer”: the names of parts."""
    return [read_part(part) for part in text.split(",") if part]


def bench(arguments: argparse.Namespace) -> int:
    """Run the named parts, or the usual ones; print each figure as it is measured, or JSON."""
    from lensbench.app.command.output import print_json
    from lensbench.app.studies.benchmark.parts import LONG, parts
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
