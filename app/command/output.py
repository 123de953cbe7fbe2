"""Output of the commands: JSON, and a progress bar."""

import json
import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import Any

WIDTH = 30                      # of the progress bar, in characters


@contextmanager
def progress() -> Iterator[Callable[[float], None]]:
    """A progress bar on the last line of the terminal, called with the completed fraction; none off a terminal."""
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
    """Print data as indented JSON in UTF-8; `plain` replaces infinite numbers and nan."""
    print(json.dumps(plain(data), indent=2, ensure_ascii=False, allow_nan=False))


def plain(data: Any) -> Any:
    """Data for JSON: infinities as "inf" or "-inf", as in the settings of a picture, and nan as null."""
    if isinstance(data, dict):
        return {key: plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [plain(value) for value in data]
    if isinstance(data, float) and not math.isfinite(data):
        return None if math.isnan(data) else str(data)
    return data
