"""Other glasses in place of those of a lens, each tried by a few steps of the improvement.

A round tries glasses around each glass of the lens and keeps the best of all; rounds go on while one helps.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import hypot

from lensbench.core.design.goal import Goal, MeritError
from lensbench.core.design.improve import Cell, Improvement, Step, improve
from lensbench.core.optics.glass import Glass
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.surface_numbers import with_surfaces

TRIED = 8               # glasses in place of each
SETTLING = 5            # lenses that are tried before a glass is judged
GAIN = 0.01             # relative fall of the merit that is worth another glass
ROUNDS = 10             # at most
FAR_N, FAR_V = 0.05, 8.0        # differences of n_d and V_d that count equally
SAME = 0.1              # glasses nearer to each other, in these, are tried once


def substitute(lens: Lens, vary: str | Sequence[Cell], goal: Goal, glasses: Sequence[Glass], *,
               rules: Callable[[Lens], Lens] = lambda lens: lens,
               progress: Callable[[Step], None] = lambda step: None,
               cancelled: Callable[[], bool] = lambda: False) -> Improvement:
    """Improve a lens whose glasses may change too.

    Parameters
    ----------
    lens, vary, goal, rules, progress, cancelled
        As for `improve`.
    glasses : sequence of Glass
        Those that may replace the glasses of the lens, in order of preference; those without n_d and V_d are left out.

    Raises
    ------
    LensError
        As `improve`, and for a lens without a glass to replace.
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

    found: list[Glass] = []
    for each in sorted((one for one in glasses if one.v_d), key=lambda one: apart(one, glass)):
        if apart(each, glass) > SAME and all(apart(each, other) > SAME for other in found):
            found.append(each)
            if len(found) == TRIED:
                break
    return found
