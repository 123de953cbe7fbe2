"""Improvement of an edited lens: its solves and pickups are kept, and what follows from them is not free."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import lensbench as lb
from lensbench.core.design.goal import Goal
from lensbench.core.design.improve import Cell, Improvement, Step, improve, variables
from lensbench.core.design.substitution import substitute
from lensbench.lenses.editing.document import LensDocument
from lensbench.lenses.editing.solves import settled


def free_cells(document: LensDocument, vary: str) -> tuple[Cell, ...]:
    """The numbers that a word names ("radii", "thicknesses" or "all") and that no rule holds."""
    return tuple(cell for cell in variables(document.lens, vary) if document.rule(*cell) is None)


def improved(document: LensDocument, cells: Sequence[Cell], goal: Goal, glasses: Sequence[lb.Glass] | None,
             progress: Callable[[Step], None], cancelled: Callable[[], bool]) -> Improvement:
    """The improvement of the lens of a document; LensError.

    glasses: those that may replace the glasses of the lens; None leaves them. Other arguments: as for `improve`.
    """
    def rules(lens: lb.Lens) -> lb.Lens:
        return settled(replace(document, lens=lens)).lens

    cells = [cell for cell in cells if document.rule(*cell) is None]
    if glasses is None:
        return improve(document.lens, cells, goal, rules=rules, progress=progress, cancelled=cancelled)
    return substitute(document.lens, cells, goal, glasses, rules=rules, progress=progress, cancelled=cancelled)
