"""Time from an edit of a radius to the picture and to all open plots: a part of `lensbench bench`."""

import time
from collections.abc import Iterator
from functools import partial

import numpy as np

from lensbench.app.state.lens_edit.editing import edited
from lensbench.app.state.settings import Settings
from lensbench.app.studies.benchmark.driven_window import SIZE as SMALL_WINDOW
from lensbench.app.studies.benchmark.driven_window import SMALL, DrivenSession, run
from lensbench.app.studies.benchmark.plots import LAYOUT, SIZE
from lensbench.lenses.editing.cells import with_radius

SURFACE, RADIUS = 1, 150.0      # of the double Gauss; its radius there is near this
EDITS, REST = 24, 5             # edits one by one, and frames between two of them
HELD = 3.0                      # seconds of a radius that is dragged


def with_turn(settings: Settings, turn: int) -> Settings:
    """Settings whose lens has a radius of its own for each turn, 0.2 mm apart."""
    return edited(settings, lambda document: with_radius(document, SURFACE, RADIUS + 0.2 * turn))[0]


def edits() -> Iterator[tuple[str, float, str]]:
    """In a window of full HD, and in one of the usual size, on whose drawing less of the time goes."""
    for size in (SIZE, SMALL_WINDOW):
        yield from _edits_in(size)


def _edits_in(size: tuple[int, int]) -> Iterator[tuple[str, float, str]]:
    """One by one, with the plots of the Designer layout; then as fast as pictures and plots follow. size: pixels."""
    pictures: list[float] = []
    plots: list[float] = []
    rest, turn, held, began, seen, frames = [REST], [0], [0], [0.0], [0.0], [0]

    def watch(session: DrivenSession) -> bool:
        now = time.perf_counter()
        if not began[0]:
            began[0] = now if session.settled(1) else 0.0
            return False
        if session.moved:
            seen[0] = seen[0] or (now - session.moved if session.current else 0.0)
            frames[0] += 1                          # the first one draws the plots of the settings before
            if frames[0] > 1 and seen[0] and not session.analyses.worker.is_late:
                if turn[0] <= EDITS:
                    pictures.append(seen[0])
                    plots.append(now - session.moved)
                held[0] += turn[0] > EDITS
                began[0] = now if turn[0] == EDITS else began[0]
                session.moved, seen[0], rest[0], frames[0] = 0.0, 0.0, REST, 0
        else:
            rest[0] -= 1
        if not session.moved and session.move is None and (rest[0] <= 0 or turn[0] >= EDITS):
            turn[0] += 1
            session.move = partial(with_turn, turn=turn[0])
        return turn[0] > EDITS and now - began[0] > HELD

    run(SMALL, watch, size=size, layout=LAYOUT)
    window = f"plots of {LAYOUT}, {size[0]} × {size[1]}"
    yield f"radius edited to picture, {window}, median", 1e3 * float(np.median(pictures)), "ms"
    yield f"radius edited to all {window}, median", 1e3 * float(np.median(plots)), "ms"
    yield f"radius edited again as soon as picture and {window} follow", held[0] / HELD, "/s"
