"""One-line faults of the core: known kinds that once survived, and random ones at other operators and numbers."""

import ast
import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parent.parent
OPERATORS = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*"}
COMPARISONS = {ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "=="}
NAMES = {"min": "max", "max": "min", "sin": "cos", "cos": "sin", "floor": "ceil", "maximum": "minimum",
         "minimum": "maximum"}
PICTURES = "core/scenery/builtin/"      # whose numbers are what a picture shows: no law says how wide a table is
TELLING = {"progress", "warn"}          # functions whose arguments change no result


class Fault(NamedTuple):
    """A fault: the file, the text that it replaces, by what, and where: line and byte, or 0 if the text is unique."""

    path: str
    old: str
    new: str
    line: int = 0
    byte: int = 0

    def __str__(self) -> str:
        position = f"{self.path}:{self.line}:{self.byte}" if self.line else self.path
        return f"{position} | {' '.join(self.old.split())} → {' '.join(self.new.split())}"

    def put_into(self, text: str) -> str:
        """The text of its file with the fault."""
        if not self.line:
            assert text.count(self.old) == 1, f"{self.path}: {self.old!r} occurs {text.count(self.old)} times"
            return text.replace(self.old, self.new)
        lines = text.splitlines(keepends=True)
        line = lines[self.line - 1].encode()
        end = self.byte + len(self.old.encode())
        assert line[self.byte:end] == self.old.encode()
        lines[self.line - 1] = line[:self.byte].decode() + self.new + line[end:].decode()
        return "".join(lines)


KINDS = {
    "Poisson variance of the sensor": Fault(
        "core/imaging/sensor.py", "math.sqrt(mean - real(5.0 / 36.0))", "math.sqrt(mean + real(5.0 / 36.0))"),
    "full well off by one": Fault(
        "core/imaging/sensor.py", "count = count if count < full_well else full_well",
        "count = count if count < full_well else full_well - real(1)"),
    "tolerance of the surface solver": Fault("core/optics/surfaces.py", "TOLERANCE = 450 ", "TOLERANCE = 4 "),
    "equator of the conic": Fault("core/optics/surfaces.py", "if not side > zero:", "if not side > -one:"),
    "equator of the sphere kernel": Fault(
        "core/optics/block_refraction.py", "v = (x * x + y * y) * rim\n            v = v if (side > real(0)) &",
        "v = (x * x + y * y) * rim\n            v = v if (side == side) &"),
    "equator of the kernels of aspheres": Fault(
        "core/optics/block_refraction.py", "equator_x * x * x + equator_y * y * y < real(1))",
        "equator_x * x * x + equator_y * y * y < real(2))"),
    "clamp of the pupil's rings": Fault(
        "core/pupils/radial_sampler.py", "last = real(RINGS - 1.001)", "last = real(RINGS - 2.001)"),
    "half-pixel shift of refocusing": Fault(
        "core/lightfields/light_field.py", "begins = shifts + (1.0 - scale) * (self._middle - 0.5)",
        "begins = shifts + (1.0 - scale) * self._middle"),
    "cosine of emission": Fault(
        "core/rendering/light_rays.py", "* per * abs(a * ux + b * uy + c * uz) * per * etendue", "* per * etendue"),
    "own-number check": Fault(
        "core/rendering/light_rays.py",
        "weight[i] = weight[i] if met[i] == mark else real(0)\n        left", "weight[i] = weight[i]\n        left"),
    "own-number check of the light": Fault(
        "core/rendering/light_rays.py",
        "-hn[i]\n        weight[i] = weight[i] if met[i] == mark else real(0)",
        "-hn[i]\n        weight[i] = weight[i]"),
    "swing of moving frames": Fault(
        "core/scenery/intersect/moving_objects.py", "PHASE: math.remainder(rotations * opening, 1.0)",
        "PHASE: 0.0"),
    "depth of the nearest": Fault(
        "core/scenery/intersect/spheres.py", "hit = (t > real(0)) & (t < near)", "hit = t > real(0)"),
    "power in the spread of pixels": Fault(
        "core/cameras/ray_generation.py", "part = real(1) / (root * math.sqrt(root))", "part = real(1) / root"),
    "coefficient of fog": Fault(
        "core/scenery/shading/participating_medium.py", "(1.0 - passed)", "(1.0 - passed * passed)"),
    "coefficient of fog in the kernel": Fault(
        "core/scenery/shading/participating_medium.py", "sg[i] += tg[i] * (real(1) - e[i]) * g",
        "sg[i] += tg[i] * (real(1) - e[i]) * r"),
    "disk of the sun": Fault(
        "core/scenery/intersect/sky.py", "CHORD2: (2.0 * math.sin(radius / 2)) ** 2",
        "CHORD2: (2.0 * math.sin(radius / 3)) ** 2"),
    "radiance of the sun's disk": Fault(
        "core/scenery/intersect/sky.py", "/ math.sin(radius) ** 2", "/ math.sin(radius)"),
    "texel of reduced textures": Fault(
        "core/scenery/intersect/texture.py", "b = (real(1) - v[i]) * real(0.5) * tall - real(0.5)",
        "b = (real(1) - v[i]) * real(0.5) * tall"),
    "plate of gleams": Fault(
        "core/scenery/shading/clearcoat.py", "hit = inside_edge(real, qa, qb, disk) & (t > real(0)) & (t < near[i])",
        "hit = inside_edge(real, qa * real(0.9), qb, disk) & (t > real(0)) & (t < near[i])"),
    "stretch in the choice of models": Fault(
        "core/analysis/model_choice.py", "np.maximum((1.0 + along) * (1.0 + around), 1e-30)",
        "np.maximum(1.0 + along, 1e-30)"),
}


def random_faults(paths: list[Path], count: int, seed: int, lines: dict[str, set[int]] | None = None) -> list[Fault]:
    """Faults at random places of files: another operator, comparison, number or function, or no `not`.

    With `lines`, by file, only there. Files get faults in proportion to their own number of possible ones, and so does
    each part of the list: the faults of a smaller `count` come first in that of a larger one.
    """
    placed = []
    for path in paths:
        name = str(path.relative_to(ROOT))
        if not name.startswith(PICTURES):
            text = path.read_text(encoding="utf-8")
            faults = sorted((_hash(f"{seed} {fault}"), fault) for fault in _faults(name, text)
                           if lines is None or fault.line in lines.get(name, ()))
            offset = _hash(f"{seed} {name}")
            placed += [((k + offset) / len(faults), fault) for k, (_, fault) in enumerate(faults)]
    return [fault for _, fault in sorted(placed)[:count]]


def _hash(text: str) -> float:
    """A number in [0, 1) that depends on a text alone."""
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:6], "big") / 2.0**48


def _faults(name: str, text: str) -> list[Fault]:
    lines = text.splitlines(keepends=True)
    edits = []
    for node in _nodes(ast.parse(text)):
        new = _changed(node)
        if new and node.lineno == node.end_lineno:
            old = lines[node.lineno - 1].encode()[node.col_offset:node.end_col_offset].decode()
            edits.append(Fault(name, old, new, node.lineno, node.col_offset))
    return edits


def _nodes(node: ast.AST) -> Iterator[ast.expr]:
    """Expressions that can change a result: not types, options of decorators, messages, or the layout of rows."""
    for field, value in ast.iter_fields(node):
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST) or field in ("annotation", "returns", "decorator_list"):
                continue
            if isinstance(child, ast.Raise | ast.JoinedStr | ast.Import | ast.ImportFrom):
                continue
            if isinstance(child, ast.Call) and getattr(child.func, "attr", getattr(child.func, "id", "")) in TELLING:
                continue
            if isinstance(node, ast.Module) and isinstance(child, ast.Assign) and isinstance(child.targets[0],
                                                                                             ast.Tuple):
                continue
            if isinstance(child, ast.expr):
                yield child
            yield from _nodes(child)


def _changed(node: ast.expr) -> str | None:
    """Source of an expression with a fault."""
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
        return f"({ast.unparse(node.left)}) {OPERATORS[type(node.op)]} ({ast.unparse(node.right)})"
    if isinstance(node, ast.Compare) and type(node.ops[0]) in COMPARISONS and len(node.ops) == 1:
        return f"({ast.unparse(node.left)}) {COMPARISONS[type(node.ops[0])]} ({ast.unparse(node.comparators[0])})"
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
        return f"({ast.unparse(node.operand)})"
    if isinstance(node, ast.Constant) and not isinstance(node.value, bool) and isinstance(
            node.value, (int, float)) and node.value:
        return repr(node.value + 1 if isinstance(node.value, int) else node.value * 1.1)
    if isinstance(node, ast.Attribute) and node.attr in NAMES:
        return f"{ast.unparse(node.value)}.{NAMES[node.attr]}"
    return None
