"""Output of the commands: JSON, a progress bar, checked paths; errors of a user, and signals that ask for an end."""

import json
import math
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter
from typing import Any

from lensbench.core.text import fixed


class UsageError(ValueError):
    """Invalid request of a user; the message says what to do."""


WIDTH = 30                      # of the progress bar, in characters


@contextmanager
def progress() -> Iterator[Callable[[float], bool]]:
    """A progress bar on the terminal's last line: called with the finished part, it returns True, to go on."""
    began = perf_counter()

    def show(fraction: float) -> bool:
        done = round(WIDTH * fraction)
        passed = perf_counter() - began
        left = f"{fixed(passed / fraction - passed, 0):>5} s left" if fraction > 0.02 else ""
        print(f"\r[{'#' * done}{'.' * (WIDTH - done)}] {fixed(100 * fraction, 0):>3} %  {left:12}",
              end="", file=sys.stderr, flush=True)
        return True

    if not sys.stderr.isatty():
        yield lambda fraction: True
        return
    try:
        yield show
    finally:
        print("\r" + " " * (WIDTH + 24) + "\r", end="", file=sys.stderr, flush=True)


def print_json(data: Any) -> None:
    """Print data as indented JSON in UTF-8; `plain` replaces infinite numbers and nan."""
    print(_json_text(data))


def checked_chart_path(path: str | None, figures: bool = True) -> Path | None:
    """The path of a chart (.svg, .png) or, with figures, of its figures (.json), checked before the work begins."""
    from lensbench.app.drawing.sheet import checked_suffix
    from lensbench.app.session.export import check_writable

    if path is None:
        return None
    if not (figures and is_json(Path(path))):
        checked_suffix(Path(path), figures)
    check_writable(Path(path))
    return Path(path)


def checked_picture_path(path: str) -> Path:
    """The path of a picture, whose suffix and place are checked before the work begins."""
    from lensbench.app.session.export import check_writable, checked_place

    checked_place(Path(path))
    check_writable(Path(path))
    return Path(path)


def checked_screenshot_path(path: str) -> Path:
    """The path of a picture of the window, a PNG, checked before the window opens."""
    from lensbench.app.session.export import check_writable

    if Path(path).suffix.lower() != ".png":
        raise UsageError(f"{path}: a picture of the window is written as .png: choose this suffix")
    check_writable(Path(path))
    return Path(path)


def checked_lens_path(path: str | None) -> Path | None:
    """The path of a lens file, whose suffix and place are checked before the work begins."""
    from lensbench.app.session.export import check_writable
    from lensbench.lenses.lens_file import writer_of

    if path is None:
        return None
    writer_of(Path(path))
    check_writable(Path(path))
    return Path(path)


def is_json(path: Path) -> bool:
    """Whether a file is to hold figures instead of a chart."""
    return path.suffix.lower() == ".json"


def save_json(path: Path, data: Any) -> None:
    """Write data as `print_json` prints it; ExportError if the file cannot be written."""
    from lensbench.app.session.export import replacing

    with replacing(path) as partial_file:
        partial_file.write_text(_json_text(data) + "\n", encoding="utf-8")


def _json_text(data: Any) -> str:
    return json.dumps(plain(data), indent=2, ensure_ascii=False, allow_nan=False)


def plain(data: Any) -> Any:
    """Data for JSON: infinities as "inf" or "-inf", as in the settings of a picture, and nan as null."""
    if isinstance(data, dict):
        return {key: plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [plain(value) for value in data]
    if isinstance(data, float) and not math.isfinite(data):
        return None if math.isnan(data) else str(data)
    return data


@contextmanager
def stop_signals(kept: bool) -> Iterator[list[int]]:
    """The signals that have asked for an end: Ctrl-C and a termination, where samples or lenses are kept.

    The first one lets the current pass of the work end, the next one ends at once. Where nothing is kept, Ctrl-C
    interrupts as usual, and a termination unwinds, so that a half-written file is removed.
    """
    asked: list[int] = []

    def handle(number: int, frame: object) -> None:
        if kept and not asked:
            asked.append(number)
            return
        if number == signal.SIGINT:
            raise KeyboardInterrupt
        sys.exit(128 + number)

    former = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield asked
    finally:
        for number, handler in former.items():
            signal.signal(number, handler)
