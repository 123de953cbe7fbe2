"""Glasses of a catalogue in place of those of a lens, each tried by a few steps of the improvement.

A round tries glasses around each glass of the lens and keeps the best of all; rounds go on while one helps.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice
from math import hypot

from lensbench.app.studies.improvement.improve import Cell, Step, improved
from lensbench.app.studies.improvement.merit import Goal, Merit, MeritError
from lensbench.lenses import glass_catalogue
from lensbench.lenses.editing.cells import with_glass
from lensbench.lenses.editing.document import EditError, LensDocument
from lensbench.lenses.glass_catalogue import Entry
from lensbench.optics.glass import Glass, GlassError

TRIED = 8               # glasses in place of each
SETTLING = 4            # steps after which a glass is judged
GAIN = 0.01             # relative fall of the merit that is worth another glass
ROUNDS = 10             # at most
FAR_N, FAR_V = 0.05, 8.0        # differences of n_d and V_d that count alike
SAME = 0.1              # glasses nearer to each other, in these, are tried once


def substituted(document: LensDocument, cells: Sequence[Cell], goal: Goal, maker: str | None = None) -> Iterator[Step]:
    """The steps of an improvement that may also change glasses.

    Parameters
    ----------
    document, cells, goal
        As for `improved`.
    maker : str or None
        Of the glasses, as the catalogues name it, such as SCHOTT; None: of every maker. Those no longer made are left
        out.

    Yields
    ------
    Step
        Each at least as good as the one before; the same one again after each glass that was tried in vain.

    Raises
    ------
    MeritError
        As `improved`, for a lens without a glass to replace, and for an unknown maker.
    """
    known = [entry for entry in glass_catalogue.entries() if entry.n_d and entry.v_d and not entry.obsolete
             and maker in (None, entry.maker)]
    if not known:
        makers = ", ".join(dict.fromkeys(entry.maker for entry in glass_catalogue.entries()))
        raise MeritError(f"no glass of {maker}: choose one of {makers}")
    places = [i for i, surface in enumerate(document.surfaces) if surface.glass.n_d > 1.0 and surface.glass.v_d]
    if not places:
        raise MeritError("the glasses of this lens have no Abbe numbers: none can be replaced")
    merit = Merit(document.lens, goal)                  # one for all, so that all are judged by the same rays
    best = Step(document, 0.0, 0.0, 0)
    for best in improved(document, cells, goal, merit):
        yield best
    for _ in range(ROUNDS):
        found: Step | None = None
        for i in places:
            for entry in around(best.document.surfaces[i].glass, known):
                tried = _settled(best.document, i, entry, cells, goal, merit)
                if tried is not None and tried.merit < (found or best).merit * (1.0 - GAIN):
                    found = tried
                yield best
        if found is None:
            return
        number = best.number
        for step in improved(found.document, cells, goal, merit):
            best = replace(step, number=number + 1 + step.number)
            yield best


def around(glass: Glass, known: Sequence[Entry]) -> list[Entry]:
    """The glasses nearest to one, different from it and from each other."""
    def apart(entry: Entry, n_d: float | None, v_d: float | None) -> float:
        return hypot(((entry.n_d or 0.0) - (n_d or 0.0)) / FAR_N, ((entry.v_d or 0.0) - (v_d or 0.0)) / FAR_V)

    found: list[Entry] = []
    for entry in sorted(known, key=lambda entry: (apart(entry, glass.n_d, glass.v_d), entry.rank, entry.name)):
        if apart(entry, glass.n_d, glass.v_d) > SAME and all(
                apart(entry, other.n_d, other.v_d) > SAME for other in found):
            found.append(entry)
            if len(found) == TRIED:
                break
    return found


def _settled(document: LensDocument, surface: int, entry: Entry, cells: Sequence[Cell], goal: Goal,
             merit: Merit) -> Step | None:
    """The lens with another glass after a few steps; None for one that cannot be."""
    try:
        steps = improved(with_glass(document, surface, entry.make()), cells, goal, merit)
        return list(islice(steps, 1 + SETTLING))[-1]
    except (EditError, MeritError, GlassError):
        return None
