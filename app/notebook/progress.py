"""A progress bar below the cell of a notebook."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import Any

from lensbench.kernels.figures import fixed

SILENT = 1.0                    # seconds before a bar appears


def notebook_display() -> Any:
    """The function `IPython.display.display` in a notebook; None elsewhere, as in a terminal."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    if shell is None or not hasattr(shell, "kernel"):
        return None
    from IPython.display import display  # type: ignore[import-not-found]
    return display


class _Html:
    def __init__(self, html: str):
        self._html = html

    def _repr_html_(self) -> str:
        return self._html


@contextmanager
def shown_progress(wanted: bool | Callable[[float], object] | None) -> Iterator[Callable[[float], object] | None]:
    """Function to call with the share that is done, 0 to 1; None where no progress is shown.

    wanted: a function of the caller; True or False for a bar; None: a bar in a notebook alone.
    """
    if callable(wanted):
        yield wanted
        return
    display = notebook_display()
    if wanted is False or display is None:
        yield None
        return
    started, handle = perf_counter(), None

    def show(part: float) -> None:
        nonlocal handle
        passed = perf_counter() - started
        if handle is None and passed > SILENT:
            handle = display(_Html(_bar(part, passed)), display_id=True)
        elif handle is not None:
            handle.update(_Html(_bar(part, passed)))

    try:
        yield show
    finally:
        if handle is not None:
            handle.update(_Html(""))


def _bar(part: float, passed: float) -> str:
    left = f"{fixed(passed / part - passed, 0)} s left" if part > 0.02 else ""
    return f'<progress value="{fixed(part, 3)}"></progress> {fixed(100.0 * part, 0)} % {left}'
