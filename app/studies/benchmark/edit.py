"""Time from an edit of a radius to the picture and to all open plots: a part of `lensbench bench`."""

import time
from collections.abc import Iterator
from functools import partial

import numpy as np

from lensbench.app.state.lens_edit.editing import edited
from lensbench.app.state.settings import Settings
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
    """One by one, with the plots of the Designer layout; then as fast as pictures and plots follow."""
    pictures: list[float] = []
    plots: list[float] = []
    rest, turn, held, began, seen, computed = [REST], [0], [0], [0.0], [0.0], [False]

    def watch(session: DrivenSession) -> bool:
        now = time.perf_counter()
        if not began[0]:
            began[0] = now if session.settled(1) else 0.0
            return False
        if session.moved:
            seen[0] = seen[0] or (now - session.moved if session.current else 0.0)
            if computed[0]:                         # before this frame, which shows them
                if turn[0] <= EDITS:
                    pictures.append(seen[0])
                    plots.append(now - session.moved)
                held[0] += turn[0] > EDITS
                began[0] = now if turn[0] == EDITS else began[0]
                session.moved, seen[0], rest[0] = 0.0, 0.0, REST
            computed[0] = bool(session.moved and seen[0]) and not session.analyses.worker.is_behind
        else:
            rest[0] -= 1
        if not session.moved and session.move is None and (rest[0] <= 0 or turn[0] >= EDITS):
            turn[0] += 1
            session.move = partial(with_turn, turn=turn[0])
        return turn[0] > EDITS and now - began[0] > HELD

    run(SMALL, watch, size=SIZE, layout=LAYOUT)
    yield f"radius edited to picture, plots of {LAYOUT}, median", 1e3 * float(np.median(pictures)), "ms"
    yield f"radius edited to all plots of {LAYOUT}, median", 1e3 * float(np.median(plots)), "ms"
    yield f"radius edited again as soon as picture and plots of {LAYOUT} follow", held[0] / HELD, "/s"
