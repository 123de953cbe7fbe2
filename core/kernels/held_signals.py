"""Ctrl-C and terminations held back while a kernel is compiled or loaded.

LLVM calls Python back, and an exception that a signal's handler raises there is lost: the compilation then fails with
another error, or goes on with half of an object. What came meanwhile is handled at the end of the kernel.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

NUMBERS = (signal.SIGINT, signal.SIGTERM)
_holding = False


@contextmanager
def signals_held() -> Iterator[None]:
    """Hold back the signals of NUMBERS that Python handles; only the main thread gets any."""
    global _holding
    if _holding or threading.current_thread() is not threading.main_thread():
        yield
        return
    asked: list[int] = []
    former = {number: handler for number in NUMBERS if callable(handler := signal.getsignal(number))}
    for number in former:
        signal.signal(number, lambda number, frame: asked.append(number))
    _holding = True
    try:
        yield
    finally:
        _holding = False
        for number, handler in former.items():
            signal.signal(number, handler)
        for late in asked:
            former[signal.Signals(late)](late, None)
