"""Improvement of a lens by bounded least squares on its free numbers, and by other glasses; each step is judged anew.

The solver is scipy's trust region reflective method (Branch, Coleman and Li, SIAM J. Sci. Comput. 21, 1, 1999). It sees
the rays that pass the start; where it ends, the rays that have come to pass count too, and it goes on until there are
none. What is reported is the judgement of the lens that is returned, by the light that passes that lens. A round of
other glasses tries some around each glass of the lens and keeps the best of all.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import hypot, inf, isfinite

import numpy as np

from lensbench.core.design.goal import Goal, MeritError, held_lengths
from lensbench.core.design.merit import DENSE, Judgement, Merit, judge
from lensbench.core.design.standard_goal import goal_of
from lensbench.core.optics.glass import Glass
from lensbench.core.optics.lens_surface import LensError, Surface
from lensbench.core.optics.prescription import (
    CONIC, CURVATURE, CURVATURE_X, SEMI_DIAMETER, THICKNESS, Lens, value_of, with_surfaces, with_value_of
)
from lensbench.core.text import significant

LIMIT = 400             # lenses that are tried
STEP = 1e-6             # of the scale of a number, for its derivative
ENOUGH = 1e-5           # relative fall of the merit, or change of the numbers, at which the solver ends
ALIKE = 1.2             # ratio of the merit as it is judged and as the solver has it, with fewer rays
DARKEST = 0.7           # of the light that passes the start: a lens that vignettes more is no step
LIGHT = 2.0             # % of a change of the light that passes, which is reported
VARIED = ("radii", "thicknesses", "all")

Cell = tuple[int, str]


@dataclass(frozen=True)
class Step:
    """A lens on the way, its last gap up to the best focus of its judgement; number 0 is the start."""

    lens: Lens
    judgement: Judgement
    number: int

    @property
    def rms(self) -> float:
        """Of spots or waves (mm) over positions, fields and colours."""
        return self.judgement.rms


@dataclass(frozen=True)
class Improvement:
    """A lens that was improved.

    Args:
        lens: The best lens that was found; the start, where none is better.
        start, end: Of the lens before and of `lens`.
        ended: "converged", "cancelled", or the limit that was reached.
        steps: Better lenses on the way.
        goal: What was judged and held.
    """

    lens: Lens
    start: Judgement
    end: Judgement
    ended: str
    steps: int
    goal: Goal


class _CancelledError(Exception):
    """Ends the solver."""


def improve(lens: Lens, vary: str | Sequence[Cell] = "radii", goal: Goal | None = None, *,
            rules: Callable[[Lens], Lens] = lambda lens: lens, progress: Callable[[Step], None] = lambda step: None,
            cancelled: Callable[[], bool] = lambda: False, limit: int = LIMIT) -> Improvement:
    """Make the spots or wave errors of a lens smaller.

    The semi-diameter of the stop follows, so that the f-number is kept, and the last gap, which ends at the best focus.

    Args:
        lens: The start.
        vary: str or sequence of (int, str). What may change: "radii", "thicknesses", "all", or surfaces and quantities
            such as (3, "curvature").
        goal: What is aimed at and held; None: `goal_of(lens)`.
        rules: Lens → lens, whose other numbers follow from those that were changed.
        progress: Is called with each better lens, the start first.
        cancelled: Whether to end; the best lens so far is returned.
        limit: Lenses that are tried at most.
    Raises:
        LensError: For a lens that cannot be judged, no number that may change, or where scipy is not installed.

    Examples:
        >>> better = lb.improve(lens, "all", lb.goal_of(lens, image_height=21.6))
        >>> print(1000.0 * better.start.rms, 1000.0 * better.end.rms, better.ended)     # µm
    """
    goal = goal_of(lens) if goal is None else goal
    cells = _checked(lens, variables(lens, vary) if isinstance(vary, str) else vary)
    start = judge(lens, goal)
    if not isfinite(start.total):
        raise MeritError("rays are lost in this lens: it cannot be improved before they pass")
    progress(Step(lens, start, 0))
    search = _Search(lens, cells, goal, start, rules, progress, cancelled)
    try:
        ended = search.run(limit)
    except _CancelledError:
        ended = "cancelled"
    return Improvement(search.best.lens, start, search.best.judgement, ended, search.best.number, goal)


class _Search:
    """The search for the best lens from a start: its numbers in units of their scales, and what the solver asks for."""

    def __init__(self, lens: Lens, cells: Sequence[Cell], goal: Goal, start: Judgement, rules: Callable[[Lens], Lens],
                 progress: Callable[[Step], None], cancelled: Callable[[], bool]) -> None:
        self.lens, self.cells, self.goal, self.rules = lens, cells, goal, rules
        self.start, self.progress, self.cancelled = start, progress, cancelled
        self.best, self.merit = Step(lens, start, 0), Merit(lens, goal)
        self._scales = np.array([_scale(lens, cell) for cell in cells])
        floors = {i: centre for i, _, centre in goal.positions[0].floors}
        self._low = np.array([floors[i] if quantity == THICKNESS else -inf for i, quantity in cells]) / self._scales
        values = np.array([value_of(lens.surfaces[i], quantity) for i, quantity in cells]) / self._scales
        self._best_values = np.maximum(values, self._low)
        self._lowest, self._size, self._tried = inf, 0, 0

    def run(self, limit: int) -> str:
        """Search, and return why it ended."""
        try:
            from scipy.optimize import least_squares
        except ImportError:
            raise LensError("improving a lens needs scipy: pip install 'lensbench[design]'") from None
        values, dense = self._best_values, False
        while self._tried < limit:
            lens = self._lens(values)
            first = None if lens is None else self.merit.residuals(lens)
            if first is None:
                raise MeritError("rays are lost in this lens: it cannot be improved before they pass")
            self._size, self._lowest = len(first), inf
            done = least_squares(self._try, values, self._slopes, (self._low, inf), ftol=ENOUGH, xtol=ENOUGH, gtol=None,
                                 max_nfev=limit - self._tried)
            if not done.status:
                break
            values, lens = done.x, self._lens(done.x)
            if lens is not None and self.merit.include(lens):
                continue
            if dense or self.best.judgement.total < ALIKE * 2.0 * done.cost:
                return "converged"
            # The rays were too few for this lens: go on with those that judge it
            values, dense, self.merit = self._best_values, True, Merit(self.best.lens, self.goal, DENSE)
        return f"the limit of {limit} tried lenses"

    def _lens(self, values: np.ndarray) -> Lens | None:
        return moved(self.lens, self.cells, values * self._scales, self.goal, self.rules)

    def _residuals(self, values: np.ndarray) -> np.ndarray:
        if self.cancelled():
            raise _CancelledError
        lens = self._lens(values)
        errors = None if lens is None else self.merit.residuals(lens)
        return np.full(self._size, inf) if errors is None else errors

    def _slopes(self, values: np.ndarray) -> np.ndarray:
        return derivatives(self._residuals, values)

    def _try(self, values: np.ndarray) -> np.ndarray:
        """Residuals of a lens that the solver tries; one that is better, as it is judged, is a step."""
        errors = self._residuals(values)
        self._tried += 1
        total, lens = float(errors @ errors), self._lens(values)
        if lens is not None and total < self._lowest:
            self._lowest, judgement = total, judge(lens, self.goal)
            if judgement.total < self.best.judgement.total and judgement.light > DARKEST * self.start.light:
                focused = self.rules(with_best_focus(lens, self.goal, judgement))
                self.best, self._best_values = Step(focused, judgement, self.best.number + 1), values.copy()
                self.progress(self.best)
        return errors


def ending(done: Improvement) -> str:
    """Why an improvement ended, and what else has changed by much, in words."""
    light = 100.0 * (done.end.light / done.start.light - 1.0)
    if abs(light) < LIGHT:
        return done.ended
    return f"{done.ended}; {significant(abs(light), 2)} % {'more' if light > 0.0 else 'less'} light passes"


def variables(lens: Lens, vary: str) -> tuple[Cell, ...]:
    """The numbers that a word names, as surfaces and quantities; MeritError for another word.

    "radii": the curvatures, without planes that bend no ray; "thicknesses": the gaps, without the last one and those
    that vary with zoom or focus; "all": both.
    """
    if vary not in VARIED:
        raise MeritError(f"vary {vary!r}: choose one of {', '.join(VARIED)}, or list numbers")
    media = [lens.front_index, *(surface.glass.n_d for surface in lens.surfaces)]
    radii = [(i, CURVATURE) for i in range(len(lens.surfaces)) if media[i] != media[i + 1]]
    gaps = [(i, THICKNESS) for i in range(len(lens.surfaces) - 1)
            if lens.positions is None or i not in lens.positions.gaps]
    return (*(radii if vary != "thicknesses" else ()), *(gaps if vary != "radii" else ()))


def derivatives(residuals: Callable[[np.ndarray], np.ndarray], values: np.ndarray) -> np.ndarray:
    """Derivatives of residuals by each number, (residuals, numbers): forward differences, else backward, else 0."""
    current, columns = residuals(values), []
    for step in STEP * np.eye(len(values)):
        for sign in (1.0, -1.0):
            column = sign * (residuals(values + sign * step) - current) / STEP
            if np.isfinite(column).all():
                break
        columns.append(column if np.isfinite(column).all() else np.zeros(len(current)))
    return np.stack(columns, 1)


def moved(lens: Lens, cells: Sequence[Cell], values: np.ndarray, goal: Goal,
          rules: Callable[[Lens], Lens]) -> Lens | None:
    """The lens with other numbers, at the f-number of the goal, its rules kept; None for one that cannot be."""
    changed: dict[int, Surface] = {}
    try:
        for (i, quantity), value in zip(cells, values.tolist(), strict=True):
            changed[i] = with_value_of(changed.get(i, lens.surfaces[i]), quantity, value)
        made, position = with_surfaces(lens, list(changed.items())), goal.positions[0]
        if position.held:
            f_number = held_lengths(position.of(made), inf, goal.primary_wavelength, False)[0]
            made = made.with_stop_radius(made.stop.semi_diameter * f_number / position.held[0])
        return rules(made)
    except (ValueError, ArithmeticError):
        return None


def with_best_focus(lens: Lens, goal: Goal, judgement: Judgement) -> Lens:
    """The lens with its last gap up to the best focus of a judgement; one that varies moves by what infinity needs."""
    last, table = len(lens.surfaces) - 1, lens.positions
    if table is None or last not in table.gaps:
        return with_surfaces(lens, [(last, replace(lens.surfaces[last], thickness=judgement.films[0]))])
    films = [film for film, position in zip(judgement.films, goal.positions, strict=True) if not position.close]
    k = table.gaps.index(last)
    rows = tuple(tuple((*gaps[:k], gaps[k] + film - row[0][k], *gaps[k + 1:]) for gaps in row)
                 for film, row in zip(films, table.thicknesses, strict=True))
    return replace(lens, positions=replace(table, thicknesses=rows)).at()


def _checked(lens: Lens, cells: Sequence[Cell]) -> tuple[Cell, ...]:
    """The cells, each once; MeritError for none, and for numbers that cannot change."""
    for i, quantity in cells:
        if quantity == SEMI_DIAMETER:
            raise MeritError(f"the semi-diameter of surface {i} bends no ray: it cannot be improved; untick it")
        if quantity == THICKNESS and i == len(lens.surfaces) - 1:
            raise MeritError("the last gap follows from the best focus: untick it")
        if quantity == THICKNESS and lens.positions is not None and i in lens.positions.gaps:
            raise MeritError(f"the gap behind surface {i} varies with zoom or focus: untick it, or edit it at the "
                             "stations of the lens")
    if not cells:
        raise MeritError("no number is free to change: tick a cell, or remove its rule")
    return tuple(dict.fromkeys(cells))


def _scale(lens: Lens, cell: Cell) -> float:
    """A change of a number that moves the light by much: the unit of its steps."""
    i, quantity = cell
    size = lens.surfaces[i].semi_diameter
    if quantity in (CURVATURE, CURVATURE_X):
        return 0.1 / size
    if quantity == THICKNESS:
        return 0.1 * size
    return 0.5 if quantity == CONIC else 0.02 * size ** (1 - int(quantity[1:]))


TRIED = 8               # glasses instead of each
SETTLING = 5            # lenses that are tried before a glass is judged
GAIN = 0.01             # relative fall of the merit that is worth another glass
ROUNDS = 10             # at most
FAR_N, FAR_V = 0.05, 8.0        # differences of n_d and V_d that count equally
SAME = 0.1              # glasses nearer to each other, in these, are tried once


def substitute(lens: Lens, vary: str | Sequence[Cell], goal: Goal, glasses: Sequence[Glass], *,
               rules: Callable[[Lens], Lens] = lambda lens: lens,
               progress: Callable[[Step], None] = lambda step: None,
               cancelled: Callable[[], bool] = lambda: False) -> Improvement:
    """Improve a lens whose glasses may change too, to one of `glasses` with n_d and V_d; else as `improve`.

    MeritError for a lens without a glass to replace.
    """
    places = [i for i, surface in enumerate(lens.surfaces) if surface.glass.n_d > 1.0 and surface.glass.v_d]
    if not places:
        raise MeritError("the glasses of this lens have no Abbe numbers: none can be replaced")
    done = improve(lens, vary, goal, rules=rules, progress=progress, cancelled=cancelled)
    start = done.start
    for _ in range(ROUNDS):
        best: Improvement | None = None
        total = done.end.total * (1.0 - GAIN)
        for i in places:
            for glass in around(done.lens.surfaces[i].glass, glasses):
                if cancelled() or done.ended == "cancelled":
                    return replace(done, ended="cancelled")
                try:
                    other = rules(with_surfaces(done.lens, [(i, replace(done.lens.surfaces[i], glass=glass))]))
                    tried = improve(other, vary, goal, rules=rules, cancelled=cancelled, limit=SETTLING)
                except ValueError:      # a lens that passes no light, or a glass that is not known at a wavelength
                    continue
                if tried.end.total < total:
                    best, total = tried, tried.end.total
        if best is None:
            break
        done = _onward(best, done.steps + 1, vary, goal, rules, progress, cancelled)
        done = replace(done, start=start)
    return done


def _onward(best: Improvement, number: int, vary: str | Sequence[Cell], goal: Goal, rules: Callable[[Lens], Lens],
            progress: Callable[[Step], None], cancelled: Callable[[], bool]) -> Improvement:
    """The improvement of a lens whose glass was replaced at step `number`."""
    done = improve(best.lens, vary, goal, rules=rules, cancelled=cancelled,
                   progress=lambda step: progress(replace(step, number=number + step.number)))
    return replace(done, steps=number + done.steps)


def around(glass: Glass, glasses: Sequence[Glass]) -> list[Glass]:
    """The glasses nearest to one, different from it and from each other."""
    def apart(one: Glass, other: Glass) -> float:
        return hypot((one.n_d - other.n_d) / FAR_N, ((one.v_d or 0.0) - (other.v_d or 0.0)) / FAR_V)

    nearest: list[Glass] = []
    for candidate in sorted((one for one in glasses if one.v_d), key=lambda one: apart(one, glass)):
        if apart(candidate, glass) > SAME and all(apart(candidate, other) > SAME for other in nearest):
            nearest.append(candidate)
            if len(nearest) == TRIED:
                break
    return nearest
