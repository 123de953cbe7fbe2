"""One-line faults put into the core, each against the tests nearest to it: which of them survive?

python -m trials.mutants                   the faults of KINDS, each of a kind that once survived
python -m trials.mutants --random 40       random ones, in the files that differ from `main`, else in the whole core
python -m trials.mutants --random 80 --since COMMIT
                                           random ones in lines of the core and the lenses that are new since a commit
python -m trials.mutants --random 500 --record trials/mutants.txt
                                           those that the record does not list yet; their fates are added to it

The quick tests run until the first failure: first files that have the name of the module, then those that name it or
use its public names, then the same for its importers, then others that execute the line (`python -m
trials.executed_lines` records which; a file that does not execute the line is left out). The slow tests of files that
name the module follow, unless --quick. Faults are put into a copy of sources and tests in a temporary folder; kernels
are compiled afresh there, because their cache knows them by their code. Ends with 1 if a fault survives. An equivalent
one, which changes no result, survives rightly: see docs/reliability.md.
"""

import argparse
import ast
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from functools import cache
from pathlib import Path

from lensbench.core.lazy import typed_imports
from trials.executed_lines import RECORD, Executed, executed
from trials.faults import KINDS, ROOT, Fault, random_faults

CORE = ROOT / "core"
PACKAGES = {"lensbench": "lensbench", "core": "lensbench/core", "lenses": "lensbench/lenses",
            "shaders": "lensbench/shaders", "app": "lensbench/app"}
NO_TESTS = 5            # the exit status of pytest where none is to be run
FILES = 4               # test files that name the module or its importers
UNKNOWN = 10.0          # s of processor time of the quick tests of a file that is not recorded
OTHERS = 20.0           # s of processor time of the tests of files that do not name the module
COMPILING = 120.0       # s of processor time for kernels with a fault; quick tests that need more find it
UNLIMITED = 1e6         # s
SLOW = 300.0            # s of processor time of the slow tests; what they do not find by then survives


@cache
def recorded() -> dict[str, Executed]:
    """Executed lines by test file; none where they are not recorded."""
    return executed() if RECORD.exists() else {}


@cache
def test_files() -> dict[str, str]:
    """Text of the test files of the core and the lenses, by name."""
    return {str(path.relative_to(ROOT)): path.read_text(encoding="utf-8") for room in ("core", "lenses")
            for path in sorted((ROOT / "tests" / room).rglob("test_*.py"))}


@cache
def importers() -> dict[str, set[str]]:
    """Files of the core and the lenses that import a file of them."""
    files: dict[str, set[str]] = {}
    for path in [*(ROOT / "core").rglob("*.py"), *(ROOT / "lenses").rglob("*.py")]:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("lensbench.") and path.parent != CORE:
                name = str(node.module).removeprefix("lensbench.").replace(".", "/")
                for candidate in (f"{name}.py", *(f"{name}/{alias.name}.py" for alias in node.names)):
                    files.setdefault(candidate, set()).add(str(path.relative_to(ROOT)))
    return files


@cache
def naming_tests(path: str) -> list[str]:
    """Test files that have the name of a module, those that name it, and those that use its public names."""
    *rooms, name = Path(path).with_suffix("").parts
    room = ".".join(["lensbench", *rooms])
    public = [offered for offered, (home, _) in typed_imports("lensbench").items() if home == f"{room}.{name}"]
    own = [file for file in test_files() if re.fullmatch(rf"test_(\w+_)?{name}", Path(file).stem)]
    files = [own]
    for pattern in (rf"{re.escape(room)}\.{name}\b|from {re.escape(room)} import .*\b{name}\b",
                    rf"\blb\.({'|'.join(public)})\b" if public else "(?!)"):
        files.append([file for file, text in test_files().items()
                      if re.search(pattern, text) and not any(file in near for near in files)])
    return sum(files, [])


def nearest_tests(fault: Fault) -> tuple[list[str], bool]:
    """Test files to run against a fault, the likeliest killers first, and whether one is known to execute the line.

    Those that name the module, then those that name a module that imports it, and so on, then all others.
    """
    lines = {fault.line}
    if not fault.line or _at_import(fault):         # all files that execute some function of the module
        lines = {line for node in ast.walk(ast.parse((ROOT / fault.path).read_text(encoding="utf-8")))
                 if isinstance(node, ast.FunctionDef)
                 for line in range(node.body[0].lineno, (node.end_lineno or 0) + 1)}
    times = {file: record.seconds for file, record in recorded().items() if lines & record.lines.get(fault.path, set())}
    chosen: list[str] = []
    ring, known = {fault.path}, {fault.path}
    while ring and len(chosen) < FILES:
        near = [file for path in sorted(ring) for file in naming_tests(path)
                if file in times or file not in recorded()]
        chosen += [file for file in dict.fromkeys(near) if file not in chosen][:FILES - len(chosen)]
        ring = set().union(*(importers().get(path, set()) for path in ring)) - known
        known |= ring
    left = OTHERS
    for seconds, file in sorted((seconds, file) for file, seconds in times.items() if file not in chosen):
        left -= seconds
        chosen += [file] if left > 0 else []
    return chosen, bool(times) or any(file not in recorded() for file in chosen)


def _at_import(fault: Fault) -> bool:
    """Whether a line is outside of all functions."""
    return not any(node.body[0].lineno <= fault.line <= (node.end_lineno or 0)
                   for node in ast.walk(ast.parse((ROOT / fault.path).read_text(encoding="utf-8")))
                   if isinstance(node, ast.FunctionDef))


def fate(fault: Fault, folder: Path, quick: bool) -> str:
    """What becomes of a fault in the copy of the sources in `folder`: "killed by …" or "SURVIVES …"."""
    room, _, inside = fault.path.partition("/")
    target = folder / PACKAGES[room] / inside
    whole = target.read_text(encoding="utf-8")
    changed = fault.put_into(whole)
    nearest, reached = nearest_tests(fault)
    seconds = sum(recorded()[file].seconds if file in recorded() else UNKNOWN for file in nearest)
    try:
        compile(changed, fault.path, "exec")
        _write(target, changed)
        killer = _killer(folder, nearest, "not slow", COMPILING + 4 * seconds)
        if killer:
            _write(target, whole)
            _demand_innocent(folder, killer)
            return f"killed by {killer}"
        killer = None if quick else _killer(folder, naming_tests(fault.path), "slow", SLOW)
        if killer and killer != "its time":
            return f"killed by {killer} (slow)"
    except SyntaxError:
        return "killed by the compiler"
    finally:
        _write(target, whole)
    return f"SURVIVES {len(nearest)} files{'' if reached else ', none of which executes the line'}"


def _write(target: Path, text: str) -> None:
    """Write a source, and remove its bytecode: that of a text of the same second and size would count as its own."""
    target.write_text(text, encoding="utf-8")
    for compiled in (target.parent / "__pycache__").glob(f"{target.stem}.*.pyc"):
        compiled.unlink()


def _killer(folder: Path, files: list[str], marked: str, seconds: float) -> str | None:
    """The test file that fails first, "its time" where the processor time runs out, or None where all pass."""
    if not files:
        return None
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *files, "-m", marked]
    environment = {**os.environ, "PYTHONPATH": str(folder), "XDG_CACHE_HOME": str(folder / "cache")}
    limit = int(seconds)
    ended = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True,
                           preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5)))
    if ended.returncode in (0, NO_TESTS):
        return None
    failed = re.search(r"^(?:FAILED|ERROR) (\S+?\.py)", ended.stdout, re.MULTILINE)
    return failed.group(1) if failed else "its time" if ended.returncode in (-9, -24) else "a crash"


@cache
def _demand_innocent(folder: Path, file: str) -> None:
    """End the trial if the quick tests of a file fail without a fault too."""
    if file in test_files() and _killer(folder, [file], "not slow", UNLIMITED):
        sys.exit(f"{file} fails without a fault: no fate that names it can be trusted")


def copy_sources(folder: Path) -> None:
    """Copy sources, tests and compiled kernels into a folder."""
    ignored = shutil.ignore_patterns("__pycache__", "shipped")
    for room, package in PACKAGES.items():
        shutil.copytree(ROOT / room, folder / package, dirs_exist_ok=True, ignore=ignored)
    shutil.copytree(ROOT / "tests", folder / "tests", ignore=ignored)
    for path in ROOT.iterdir():
        if path.name not in ("lensbench", "tests", "build") and not path.name.startswith("."):
            (folder / path.name).symlink_to(path)
    kernels = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "lensbench" / "kernels"
    if kernels.exists():
        shutil.copytree(kernels, folder / "cache" / "lensbench" / "kernels")


def changed_files() -> list[Path]:
    """Files of the core that differ from `main`; all of the core where there are none."""
    told = subprocess.run(["git", "diff", "--name-only", "main", "--", "core"], cwd=ROOT, capture_output=True,
                          text=True).stdout.split()
    named = [ROOT / name for name in told if name.endswith(".py") and (ROOT / name).exists()]
    return named or sorted((ROOT / "core").rglob("*.py"))


def new_lines(commit: str) -> dict[str, set[int]]:
    """Lines of the core and the lenses by file that are new since a commit; one that only moved is not."""
    told = subprocess.run(["git", "diff", "-U0", commit, "--", "core/*.py", "lenses/*.py"], cwd=ROOT,
                          capture_output=True, text=True, check=True).stdout.splitlines()
    gone = {row[1:].strip() for row in told if row.startswith("-")}
    lines_of: dict[str, set[int]] = {}
    for row in told:
        if row.startswith("+++ "):
            path = row.removeprefix("+++ b/")
        elif row.startswith("@@"):
            line = int(row.split("+")[1].split()[0].partition(",")[0])
        elif row.startswith("+"):
            if row[1:].strip() not in gone:
                lines_of.setdefault(path, set()).add(line)
            line += 1
    return lines_of


def main() -> int:
    """Run the faults, and print their fates."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--random", type=int, metavar="N", help="random faults instead of those of KINDS")
    parser.add_argument("--since", metavar="COMMIT", help="random ones in lines that are new since a commit")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--record", type=Path, help="file of fates: those in it are not run again")
    parser.add_argument("--quick", action="store_true", help="without the slow tests")
    parser.add_argument("--kind", help="only the kinds whose name contains this")
    options = parser.parse_args()
    if options.random:
        lines = new_lines(options.since) if options.since else None
        files = [path.resolve() for path in options.files] or [ROOT / line for line in lines or ()] or changed_files()
        faults = random_faults(files, options.random, options.seed, lines)
    else:
        faults = [fault for name, fault in KINDS.items() if (options.kind or "") in name]
    known = options.record.read_text(encoding="utf-8") if options.record and options.record.exists() else ""
    faults = [fault for fault in faults if f"{fault} | " not in known]
    left = 0
    with tempfile.TemporaryDirectory() as temporary:
        copy_sources(Path(temporary))
        for fault in faults:
            begun = time.monotonic()
            told = fate(fault, Path(temporary), options.quick)
            left += told.startswith("SURVIVES")
            row = f"{fault} | {told}"
            print(f"{row}, {time.monotonic() - begun:.0f} s", flush=True)
            if options.record:
                with options.record.open("a", encoding="utf-8") as record:
                    record.write(row + "\n")
    print(f"{len(faults) - left} of {len(faults)} killed")
    return left > 0


if __name__ == "__main__":
    sys.exit(main())
