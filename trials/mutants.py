"""One-line faults put into the core, each against the tests nearest to it: which of them survive?

python -m trials.mutants                   the faults of KINDS, each of a kind that once survived
python -m trials.mutants --random 40       random ones, in the files that differ from `main`, else in the whole core
python -m trials.mutants --random 40 core/imaging/sensor.py

The nearest tests of a module are those in files that name it, or that have its name: first the quick ones, then the
slow ones, then the quick ones of its room. The faults are put into a copy of the sources in a temporary folder; kernels
are compiled afresh there, because the cache knows them by their code. Ends with 1 if a fault survives. An equivalent
one, which changes no result, survives rightly: see docs/reliability.md.
"""

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parent.parent
PACKAGES = {"core": "lensbench", "lenses": "lensbench/lenses", "shaders": "lensbench/shaders", "app": "lensbench/app"}
OPERATORS = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*"}
COMPARISONS = {ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "=="}
NAMES = {"min": "max", "max": "min", "sin": "cos", "cos": "sin", "floor": "ceil", "maximum": "minimum",
         "minimum": "maximum"}
NO_TESTS = 5            # the exit status of pytest where none is to be run
SECONDS = 600           # a fault under which the tests run longer is found


class Mutant(NamedTuple):
    """A fault: the file, the text that it replaces, by what, and the line."""

    path: str
    old: str
    new: str
    line: int = 0


KINDS = {
    "Poisson variance of the sensor": Mutant(
        "core/imaging/sensor.py", "math.sqrt(mean - real(5.0 / 36.0))", "math.sqrt(mean + real(5.0 / 36.0))"),
    "full well off by one": Mutant(
        "core/imaging/sensor.py", "count = count if count < full_well else full_well",
        "count = count if count < full_well else full_well - real(1)"),
    "tolerance of the surface solver": Mutant("core/optics/surfaces.py", "TOLERANCE = 450 ", "TOLERANCE = 4 "),
    "equator of the conic": Mutant("core/optics/surfaces.py", "if not side > zero:", "if not side > -one:"),
    "equator of the sphere kernel": Mutant(
        "core/optics/block_refraction.py", "v = (x * x + y * y) * rim\n            v = v if (side > real(0)) &",
        "v = (x * x + y * y) * rim\n            v = v if (side == side) &"),
    "equator of the kernels of aspheres": Mutant(
        "core/optics/block_refraction.py", "equator_x * x * x + equator_y * y * y < real(1))",
        "equator_x * x * x + equator_y * y * y < real(2))"),
    "clamp of the pupil's rings": Mutant(
        "core/pupils/radial_sampler.py", "last = real(RINGS - 1.001)", "last = real(RINGS - 2.001)"),
    "half-pixel shift of refocusing": Mutant(
        "core/lightfields/light_field.py", "begins = shifts + (1.0 - scale) * (self._middle - 0.5)",
        "begins = shifts + (1.0 - scale) * self._middle"),
    "cosine of emission": Mutant(
        "core/rendering/light_rays.py", "* per * abs(a * ux + b * uy + c * uz) * per * etendue", "* per * etendue"),
    "own-number check": Mutant(
        "core/rendering/light_rays.py",
        "weight[i] = weight[i] if met[i] == mark else real(0)\n        left", "weight[i] = weight[i]\n        left"),
    "own-number check of the light": Mutant(
        "core/rendering/light_rays.py",
        "-hn[i]\n        weight[i] = weight[i] if met[i] == mark else real(0)",
        "-hn[i]\n        weight[i] = weight[i]"),
    "swing of moving frames": Mutant(
        "core/scenery/intersect/moving_objects.py", "PHASE: math.remainder(rotations * opening, 1.0)",
        "PHASE: 0.0"),
    "depth of the nearest": Mutant(
        "core/scenery/intersect/spheres.py", "hit = (t > real(0)) & (t < near)", "hit = t > real(0)"),
    "power in the spread of pixels": Mutant(
        "core/cameras/differentials.py", "part = real(1) / (root * math.sqrt(root))", "part = real(1) / root"),
    "coefficient of fog": Mutant(
        "core/scenery/shading/participating_medium.py", "(1.0 - passed)", "(1.0 - passed * passed)"),
    "coefficient of fog in the kernel": Mutant(
        "core/scenery/shading/participating_medium.py", "sg[i] += tg[i] * (real(1) - e[i]) * g",
        "sg[i] += tg[i] * (real(1) - e[i]) * r"),
    "disk of the sun": Mutant(
        "core/scenery/intersect/sky.py", "CHORD2: (2.0 * math.sin(radius / 2)) ** 2",
        "CHORD2: (2.0 * math.sin(radius / 3)) ** 2"),
    "radiance of the sun's disk": Mutant(
        "core/scenery/intersect/sky.py", "/ math.sin(radius) ** 2", "/ math.sin(radius)"),
    "texel of reduced textures": Mutant(
        "core/scenery/intersect/ripmap.py", "b = (real(1) - v[i]) * real(0.5) * tall - real(0.5)",
        "b = (real(1) - v[i]) * real(0.5) * tall"),
    "plate of gleams": Mutant(
        "core/scenery/shading/clearcoat.py", "hit = inside_edge(real, qa, qb, disk) & (t > real(0)) & (t < near[i])",
        "hit = inside_edge(real, qa * real(0.9), qb, disk) & (t > real(0)) & (t < near[i])"),
    "stretch in the choice of models": Mutant(
        "core/analysis/model_error.py", "np.maximum((1.0 + along) * (1.0 + around), 1e-30)",
        "np.maximum(1.0 + along, 1e-30)"),
}


def random_mutants(paths: list[Path], count: int, seed: int) -> list[Mutant]:
    """Faults at random places of files: another operator, comparison, number or function, or no `not`."""
    found = [mutant for path in paths for mutant in _mutants_of(path)]
    return random.Random(seed).sample(found, min(count, len(found)))


def _mutants_of(path: Path) -> list[Mutant]:
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines(keepends=True)
    found = []

    def add(node: ast.expr, new: str) -> None:
        if node.lineno == node.end_lineno:
            line = lines[node.lineno - 1].encode()
            changed = line[:node.col_offset].decode() + new + line[node.end_col_offset:].decode()
            found.append(Mutant(str(path.relative_to(ROOT)), lines[node.lineno - 1], changed, node.lineno))

    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
            add(node, f"({ast.unparse(node.left)}) {OPERATORS[type(node.op)]} ({ast.unparse(node.right)})")
        elif isinstance(node, ast.Compare) and type(node.ops[0]) in COMPARISONS and len(node.ops) == 1:
            add(node, f"({ast.unparse(node.left)}) {COMPARISONS[type(node.ops[0])]} "
                      f"({ast.unparse(node.comparators[0])})")
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            add(node, f"({ast.unparse(node.operand)})")
        elif isinstance(node, ast.Constant) and type(node.value) in (int, float) and node.value:
            add(node, repr(node.value + 1 if isinstance(node.value, int) else node.value * 1.1))
        elif isinstance(node, ast.Attribute) and node.attr in NAMES:
            add(node, f"{ast.unparse(node.value)}.{NAMES[node.attr]}")
    return found


def nearest_tests(path: str) -> list[str]:
    """The test files that name a module, or that have its name; those of its room where there are none."""
    inside = Path(path).relative_to("core").with_suffix("")
    dotted = "lensbench." + ".".join(inside.parts)
    files = [file for file in sorted((ROOT / "tests").rglob("test_*.py"))
             if dotted in file.read_text(encoding="utf-8") or file.stem == f"test_{inside.name}"]
    return [str(file.relative_to(ROOT)) for file in files] or tests_of_room(path)


def tests_of_room(path: str) -> list[str]:
    """The test files of the room of a module."""
    room = ROOT / "tests" / "core" / Path(path).parts[1]
    return [str(file.relative_to(ROOT)) for file in sorted(room.rglob("test_*.py"))]


def survives(mutant: Mutant, folder: Path) -> bool:
    """Whether the nearest tests pass with the fault in the copy of the sources in `folder`."""
    room, _, inside = mutant.path.partition("/")
    place = folder / PACKAGES[room] / inside
    whole = place.read_text(encoding="utf-8")
    if mutant.line:
        lines = whole.splitlines(keepends=True)
        lines[mutant.line - 1] = mutant.new
        changed = "".join(lines)
    else:
        assert whole.count(mutant.old) == 1, f"{mutant.path}: {mutant.old!r} occurs {whole.count(mutant.old)} times"
        changed = whole.replace(mutant.old, mutant.new)
    try:
        compile(changed, mutant.path, "exec")
        place.write_text(changed, encoding="utf-8")
        command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider"]
        environment = {**os.environ, "PYTHONPATH": str(folder)}
        nearest, room = nearest_tests(mutant.path), tests_of_room(mutant.path)
        return all(subprocess.run([*command, *files, "-m", marked], cwd=folder, env=environment, timeout=SECONDS,
                                  capture_output=True).returncode in (0, NO_TESTS)
                   for marked, files in (("not slow", nearest), ("slow", nearest), ("not slow", room)) if files)
    except (subprocess.TimeoutExpired, SyntaxError):
        return False
    finally:
        place.write_text(whole, encoding="utf-8")


def changed_files() -> list[Path]:
    """Files of the core that differ from `main`; all of the core where there are none."""
    told = subprocess.run(["git", "diff", "--name-only", "main", "--", "core"], cwd=ROOT, capture_output=True,
                          text=True).stdout.split()
    named = [ROOT / name for name in told if name.endswith(".py") and (ROOT / name).exists()]
    return named or sorted((ROOT / "core").rglob("*.py"))


def main() -> int:
    """Run the faults, and print the survivors."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--random", type=int, metavar="N", help="random faults in place of those of KINDS")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", help="only the kinds whose name contains this")
    options = parser.parse_args()
    if options.random:
        paths = [path.resolve() for path in options.files] or changed_files()
        mutants = {f"{one.path}:{one.line}": one for one in random_mutants(paths, options.random, options.seed)}
    else:
        mutants = {name: one for name, one in KINDS.items() if (options.kind or "") in name}
    left = 0
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for room, package in PACKAGES.items():
            shutil.copytree(ROOT / room, folder / package, dirs_exist_ok=True,
                            ignore=shutil.ignore_patterns("__pycache__", "shipped"))
        for name in ("tests", "docs", "core", "lenses", "app", "shaders", "pyproject.toml", "README.md"):
            (folder / name).symlink_to(ROOT / name)
        for name, mutant in mutants.items():
            survived = survives(mutant, folder)
            left += survived
            print(f"{'SURVIVES' if survived else 'killed':9} {name}", flush=True)
            if survived:
                print(f"          - {mutant.old.strip()}\n          + {mutant.new.strip()}", flush=True)
    print(f"{len(mutants) - left} of {len(mutants)} killed")
    return left > 0


if __name__ == "__main__":
    sys.exit(main())
