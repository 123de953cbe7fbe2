"""Pauses of long computations, at the places where these ask for them: something more urgent may need the processors.

A computation calls `pause` between its parts. Nothing happens unless a caller further up in the same thread has said,
by `pausing`, when the thread shall pause.
"""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import sleep

LOOK = 0.001            # seconds between two looks whether a pause is over
_thread = threading.local()


def never() -> bool:
    """No pause is due."""
    return False


def due() -> Callable[[], bool]:
    """Tells, from any thread, whether the computation of the current thread shall pause."""
    predicate: Callable[[], bool] = getattr(_thread, "due", never)
    return predicate


def pause(is_due: Callable[[], bool] | None = None) -> None:
    """Wait as long as the computation of this thread shall pause.

    wanted: in a thread that helps another one, what `due` returned there.
    """
    is_due = is_due or due()
    while is_due():
        sleep(LOOK)


@contextmanager
def pausing(is_due: Callable[[], bool]) -> Iterator[None]:
    """Let the computations of this thread pause while `wanted` is true; it is called from other threads too."""
    former, _thread.due = due(), is_due
    try:
        yield
    finally:
        _thread.due = former
