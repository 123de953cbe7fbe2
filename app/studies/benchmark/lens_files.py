"""Time to load and to check lens files, in a running and in a new process: a part of `lensbench bench`."""

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from lensbench import lenses
from lensbench.app.studies.timing import time_in_turn
from lensbench.lenses.catalogue import path_of
from lensbench.lenses.formats.table import WRITERS

CANDIDATES = 12         # lenses with the most surfaces, of which the slowest is sought

ROUNDS = 5              # of each file: fewer, and one pass of the garbage collector is taken for a slow file

FIRST = """
import sys, time
begin = time.perf_counter()
from lensbench import lenses
loaded = lenses.load(sys.argv[1])
between = time.perf_counter()
lenses.check(loaded)
print(between - begin, time.perf_counter() - between)
"""


def files() -> Iterator[tuple[str, float, str]]:
    """The slowest library lens in each format; the first load and check of a new process."""
    longest = sorted(lenses.describe(), key=lambda card: card.surfaces)[-CANDIDATES:]
    names = [card.name for card in longest]
    with tempfile.TemporaryDirectory() as folder:
        for suffix in WRITERS:
            paths = {name: Path(folder) / f"{name}{suffix}" for name in names}
            for name, path in paths.items():
                lenses.save(lenses.load(name), path)
            runs = time_in_turn({name: partial(lenses.load, path) for name, path in paths.items()}, 0.0, ROUNDS)
            yield f"load the slowest {suffix}", max(run.least for run in runs.values()) * 1e3, "ms"
    runs = time_in_turn({name: partial(lenses.check, lenses.load(name)) for name in names}, 0.0, ROUNDS)
    slowest = max(runs, key=lambda name: runs[name].least)
    yield "check the slowest lens", runs[slowest].least * 1e3, "ms"
    first = [_first(str(path_of(slowest))) for _ in range(3)]
    yield "the imports and the first load of a process", min(first)[0] * 1e3, "ms"
    yield "the first check of a process", min(check for _, check in first) * 1e3, "ms"


def _first(path: str) -> tuple[float, float]:
    """Seconds in which a new process imports what it needs and loads a lens file, and in which it checks that."""
    done = subprocess.run([sys.executable, "-c", FIRST, path], capture_output=True, text=True, check=True)
    load, check = done.stdout.split()
    return float(load), float(check)
