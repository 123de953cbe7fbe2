"""Cost of open plots for the picture: from a dial to the first picture with the plots of a layout and without them.

Both take turns in one window, so that other load of the machine affects both alike.
"""

import time
from collections.abc import Iterator
from functools import partial

import numpy as np
from imgui_bundle import hello_imgui

from lensbench.app.studies.benchmark.driven_window import SMALL, DrivenSession, focused, run
from lensbench.app.window.analyses import PANELS

LAYOUT, SIZE = "Designer", (1920, 1080)
TURNS, MOVES = 4, 6             # of each kind of window, and moves in one of them
SETTLE = 8                     # frames until panels have opened or closed
REST = 5                        # frames between two moves of the dial


def first_pictures() -> tuple[list[tuple[float, float]], list[tuple[float, float]]]:
    """Seconds from a move of the focus to the end of the first pass, and to its picture on the screen.

    With all plots of the layout, and without.
    """
    found: tuple[list[tuple[float, float]], list[tuple[float, float]]] = ([], [])
    plots: list[hello_imgui.DockableWindow] = []
    rest, moves, turn = [SETTLE], [0], [0]

    def watch(session: DrivenSession) -> bool:
        if not plots:
            if session.settled(1):
                plots.extend(each for each in hello_imgui.get_runner_params().docking_params.dockable_windows
                             if each.label in PANELS and each.is_visible)
            return False
        if session.moved and session.current:
            found[turn[0] % 2].append((session.worker.first_seconds, time.perf_counter() - session.moved))
            session.moved, rest[0], moves[0] = 0.0, REST, moves[0] + 1
            if moves[0] == MOVES:
                turn[0], moves[0], rest[0] = turn[0] + 1, 0, SETTLE
                for each in plots:
                    each.is_visible = turn[0] % 2 == 0
        elif not session.moved and session.move is None and session.current:
            rest[0] -= 1
            if rest[0] <= 0:
                session.move = partial(focused, turn=MOVES * turn[0] + moves[0])
        return turn[0] == 2 * TURNS

    run(SMALL, watch, size=SIZE, layout=LAYOUT)
    return found


def beside_plots() -> Iterator[tuple[str, float, str]]:
    """From a dial to the first picture beside the plots of the Designer layout, over that without plots."""
    beside, alone = (1e3 * np.median(each, 0) for each in first_pictures())
    for k, name in enumerate(("end of the first pass", "first picture on the screen")):
        yield f"dial to {name}, no plots, median", float(alone[k]), "ms"
        yield f"dial to {name}, plots of {LAYOUT}, median", float(beside[k]), "ms"
        yield f"dial to {name}, with plots over without", float(beside[k] / alone[k]), "×"
