"""Lines of the core that each test file executes, and the processor time that its quick tests take.

python -m trials.executed_lines         adds the files of tests/core that build/executed_lines.json does not list yet
                                        (ten minutes); remove it after a change of the core

Each test file runs by itself. A trace function tells the lines of Python code, but not those of compiled kernels: there
all lines of a kernel that a process uses, and of the functions that it may call, count as executed.
"""

import json
import os
import resource
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from types import CodeType, FrameType
from typing import Any, NamedTuple

ROOT = Path(__file__).parent.parent
RECORD = ROOT / "build" / "executed_lines.json"
CORE = str(ROOT / "core") + os.sep
CALLS = 1000            # of a function that are traced, because tracing is slow


class Executed(NamedTuple):
    """What the quick tests of a file do: processor time (s), and lines of the core by path."""

    seconds: float
    lines: dict[str, set[int]]


def executed() -> dict[str, Executed]:
    """The record, by test file."""
    return {name: Executed(seconds, {path: set(lines) for path, lines in numbers.items()})
            for name, (seconds, numbers) in json.loads(RECORD.read_text(encoding="utf-8")).items()}


def lines_of(code: CodeType) -> set[int]:
    """Lines of a function and of all functions inside it, without that of its head."""
    lines = {line for _, _, line in code.co_lines() if line and line != code.co_firstlineno}
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            lines |= lines_of(constant)
    return lines


class _Tracer:
    """Lines of the core that this process executes in Python, in the first CALLS of each function."""

    def __init__(self) -> None:
        self._unseen: dict[CodeType, set[int]] = {}
        self._calls: dict[CodeType, int] = {}
        self.seen: dict[str, set[int]] = {}

    def of_call(self, frame: FrameType, event: str, argument: Any) -> Any:
        code = frame.f_code
        if not code.co_filename.startswith(CORE):
            return None
        if code not in self._unseen:
            self._unseen[code] = {line for _, _, line in code.co_lines() if line}
        unseen, executed = self._unseen[code], self.seen.setdefault(code.co_filename, set())
        self._calls[code] = calls = self._calls.get(code, 0) + 1
        if not unseen or calls > CALLS:
            return None

        def of_line(frame: FrameType, event: str, argument: Any) -> Any:
            if frame.f_lineno in unseen:
                unseen.discard(frame.f_lineno)
                executed.add(frame.f_lineno)
            return of_line if unseen else None
        unseen.discard(frame.f_lineno)
        executed.add(frame.f_lineno)
        return of_line


def _kernel_lines() -> Iterator[tuple[str, set[int]]]:
    """Lines of the kernels that this process uses, and of what they may call."""
    from lensbench.core.kernels import cache, compiled_code
    waiting = [function for function, _ in cache.used.values()]
    codes = set()
    while waiting:
        code = waiting.pop()
        if code not in codes:
            codes.add(code)
            waiting += compiled_code._alone(code)[1]
            yield code.__code__.co_filename, lines_of(code.__code__)


def pytest_configure(config: Any) -> None:
    """Begin to trace: this module is the plug-in of the processes that it starts."""
    config._tracer = _Tracer()
    threading.settrace(config._tracer.of_call)
    sys.settrace(config._tracer.of_call)


def pytest_unconfigure(config: Any) -> None:
    """Write what this process executed."""
    sys.settrace(None)
    threading.settrace(None)
    executed = config._tracer.seen
    for path, lines in _kernel_lines():
        executed.setdefault(path, set()).update(lines)
    told = {path.removeprefix(str(ROOT) + os.sep): sorted(lines) for path, lines in executed.items()
            if path.startswith(CORE)}
    Path(os.environ["EXECUTED_LINES"]).write_text(json.dumps(told), encoding="utf-8")


def _record(name: str) -> tuple[float, dict[str, list[int]]]:
    """Run the quick tests of a file: their time, and the lines."""
    partial_file = RECORD.with_suffix(".part")
    partial_file.write_text("{}", encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "not slow", name]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    ended = subprocess.run([*command, "-p", "trials.executed_lines"], cwd=ROOT, capture_output=True, text=True,
                           env={**os.environ, "EXECUTED_LINES": str(partial_file)})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if ended.returncode not in (0, 5):
        print(ended.stdout[-2000:], ended.stderr[-2000:])
    return round(seconds, 1), json.loads(partial_file.read_text(encoding="utf-8"))


def main() -> None:
    """Record all test files."""
    RECORD.parent.mkdir(exist_ok=True)
    names = [str(path.relative_to(ROOT)) for path in sorted((ROOT / "tests" / "core").rglob("test_*.py"))]
    told = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.exists() else {}
    for name in (name for name in names if name not in told):
        told[name] = _record(name)
        print(f"{told[name][0]:6.1f} s  {name}", flush=True)
        RECORD.write_text(json.dumps(told), encoding="utf-8")


if __name__ == "__main__":
    main()
