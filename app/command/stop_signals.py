"""Ctrl-C and a termination during long work that keeps what it has."""

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager


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
