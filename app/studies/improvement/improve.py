"""Damped least squares on the free numbers of a lens: each step is a lens, and the improvement can stop at any.

Source: K. Levenberg, Quarterly of Applied Mathematics 2, 164 (1944), and D. W. Marquardt, J. SIAM 11, 431 (1963). The
derivatives are differences of the fourth order, whose error is that of rounding.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import isfinite

import numpy as np

from lensbench.app.studies.improvement.merit import Goal, Merit, MeritError
from lensbench.lenses.editing.document import (
    CONIC,
    CURVATURE,
    CURVATURE_X,
    SEMI_DIAMETER,
    THICKNESS,
    EditError,
    LensDocument,
    value_of,
    varies,
    with_surfaces,
    with_value_of,
)
from lensbench.lenses.editing.solves import settled
from lensbench.optics.lens_surface import LensError, Surface

STEPS = 60                      # at most
TRIES = 8                       # of the damping within a step
ENOUGH = 1e-4                   # relative fall of the merit; three smaller ones in a row end it
FIRST_DAMPING = 1e-3
PART = 2e-3                     # of the scale of a number, for differences

Cell = tuple[int, str]


@dataclass(frozen=True)
class Step:
    """A lens on the way.

    rms: of spots or waves (mm) over fields and colours. merit: the sum that falls. number: from 0.
    """

    document: LensDocument
    rms: float
    merit: float
    number: int


def radii(document: LensDocument) -> tuple[Cell, ...]:
    """The curvatures that are free to change: all but those of planes that bend no ray, and of rules."""
    found, before = [], document.lens.front_index
    for i, surface in enumerate(document.surfaces):
        if surface.glass.n_d != before and document.rule(i, CURVATURE) is None:
            found.append((i, CURVATURE))
        before = surface.glass.n_d
    return tuple(found)


def improved(document: LensDocument, cells: Sequence[Cell], goal: Goal, merit: Merit | None = None) -> Iterator[Step]:
    """The steps of an improvement, the first of them the lens as it is.

    Parameters
    ----------
    document : LensDocument
        The lens; its solves and pickups are kept.
    cells : sequence of (int, str)
        The numbers that may change: surface and quantity.
    goal : Goal
        What is aimed at and held.
    merit : Merit or None
        That of a lens before, with its rays; None: of this lens.

    Yields
    ------
    Step
        Each better than the one before; the last is the best that was found.

    Raises
    ------
    MeritError
        For a lens that cannot be judged, or no number that may change.
    """
    free = [cell for cell in dict.fromkeys(cells) if document.rule(*cell) is None]
    moving = next((i for i, quantity in free if quantity == THICKNESS and varies(document.lens, i)), None)
    if moving is not None:
        raise MeritError(f"the gap behind surface {moving} varies with zoom or focus: untick it, or edit it at the "
                         "stations of the lens")
    if not free:
        raise MeritError("no number is free to change: tick a cell, or remove its rule")
    merit = Merit(document.lens, goal) if merit is None else merit
    scales = np.array([_scale(document, cell) for cell in free])
    values = np.array([value_of(document.surfaces[i], quantity) for i, quantity in free])
    residuals = merit.residuals(document.lens)
    if not isfinite(residuals[0]):
        raise MeritError("rays are lost in this lens: it cannot be improved before they pass")
    total = float(residuals @ residuals)
    yield Step(document, merit.rms(document.lens), total, 0)
    damping, slow = FIRST_DAMPING, 0
    for number in range(1, STEPS + 1):
        slopes = jacobian(document, free, scales, merit)
        square, gradient = slopes.T @ slopes, slopes.T @ residuals
        taken: LensDocument | None = None
        for _ in range(TRIES):
            step = np.linalg.lstsq(square + damping * np.diag(np.diag(square) + 1e-12 * np.trace(square)), -gradient,
                                   rcond=None)[0]
            after = moved(document, free, values + scales * np.clip(step, -0.5, 0.5))
            if after is not None:
                new = merit.residuals(after.lens)
                if isfinite(new[0]) and float(new @ new) < total:
                    taken = after
                    break
            damping = min(damping * 5.0, 1e6)
        if taken is None:
            return
        fall = 1.0 - float(new @ new) / total
        document, residuals, total = taken, new, float(new @ new)
        values = np.array([value_of(document.surfaces[i], quantity) for i, quantity in free])
        damping = max(damping / 5.0, 1e-9)
        yield Step(document, merit.rms(document.lens), total, number)
        slow = slow + 1 if fall < ENOUGH else 0
        if slow == 3:
            return


def jacobian(document: LensDocument, cells: Sequence[Cell], scales: np.ndarray, merit: Merit) -> np.ndarray:
    """Derivatives of the residuals by each cell in units of its scale, (residuals, cells); rays are aimed anew."""
    values = np.array([value_of(document.surfaces[i], quantity) for i, quantity in cells])
    columns = []
    for k in range(len(cells)):
        at = {}
        for side in (-2, -1, 1, 2):
            there = values.copy()
            there[k] += side * PART * scales[k]
            lens = moved(document, cells, there)
            row = merit.residuals(lens.lens) if lens is not None else np.full(1, np.inf)
            if not isfinite(row[0]):
                row = merit.residuals(document.lens)            # no slope where the lens ends
            at[side] = row
        columns.append((at[-2] - 8.0 * at[-1] + 8.0 * at[1] - at[2]) / (12.0 * PART))
    return np.stack(columns, 1)


def moved(document: LensDocument, cells: Sequence[Cell], values: np.ndarray) -> LensDocument | None:
    """The document with other numbers, its rules settled; None for one that cannot be."""
    changed: dict[int, Surface] = {}
    try:
        for (i, quantity), value in zip(cells, values.tolist(), strict=True):
            surface = changed.get(i, document.surfaces[i])
            changed[i] = with_value_of(surface, quantity, value)
        lens = with_surfaces(document.lens, list(changed.items()))
        return settled(LensDocument(lens, document.comments, document.solves, document.pickups))
    except (LensError, EditError, ArithmeticError):
        return None


def _scale(document: LensDocument, cell: Cell) -> float:
    """A change of a number that moves the light by much: the unit of its steps."""
    i, quantity = cell
    size = document.surfaces[i].semi_diameter
    if quantity in (CURVATURE, CURVATURE_X):
        return 0.1 / size
    if quantity in (THICKNESS, SEMI_DIAMETER):
        return 0.1 * size
    return 0.5 if quantity == CONIC else 0.02 * size ** (1 - int(quantity[1:]))
