"""What the commands print: JSON, and a bar of progress."""

import json
import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import Any

WIDTH = 30                      # of the bar, characters


@contextmanager
def progress() -> Iterator[Callable[[float], None]]:
    """A bar on the last line of the terminal, given what part is done; nothing where no person reads it."""
    began = perf_counter()

    def show(fraction: float) -> None:
        done = round(WIDTH * fraction)
        passed = perf_counter() - began
        left = f"{passed / fraction - passed:5.0f} s left" if fraction > 0.02 else ""
        print(f"\r[{'#' * done}{'.' * (WIDTH - done)}] {100 * fraction:3.0f} %  {left:12}",
              end="", file=sys.stderr, flush=True)

    if not sys.stderr.isatty():
        yield lambda fraction: None
        return
    try:
        yield show
    finally:
        print("\r" + " " * (WIDTH + 24) + "\r", end="", file=sys.stderr, flush=True)


def print_json(data: Any) -> None:
    """Indented, in UTF-8, numbers that JSON has no word for as `plain` says."""
    print(json.dumps(plain(data), indent=2, ensure_ascii=False, allow_nan=False))


def plain(data: Any) -> Any:
    """With the infinite as "inf" or "-inf", as in a picture's settings, and what is not a number as null."""
    if isinstance(data, dict):
        return {key: plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [plain(value) for value in data]
    if isinstance(data, float) and not math.isfinite(data):
        return None if math.isnan(data) else str(data)
    return data
