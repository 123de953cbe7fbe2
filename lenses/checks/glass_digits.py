"""The digit of an index or Abbe number that makes a known glass of one that nobody makes.

Candidates that the lens has elsewhere come first. Others are told apart by the lens: its focus for an index, its
longitudinal colour for an Abbe number.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite

from lensbench.kernels.figures import significant
from lensbench.lenses.checks.glasses import distance_to_known
from lensbench.lenses.checks.hypothesis import with_surface
from lensbench.lenses.checks.single_change import slips
from lensbench.optics.finding import Change, Finding, Kind
from lensbench.optics.glass import Glass
from lensbench.optics.paraxial import first_order
from lensbench.optics.prescription import Lens

NEAR = 1.2                      # steps of the map of glasses
F_LINE, C_LINE = 0.4861327, 0.6562725
COLOUR = 1e-3                   # of the focal length: the longitudinal colour of an achromat, as much as one step
FOCUS = 2e-3                    # of the focal length: a shift of the focus by another index, as much as one step
SAME_N, SAME_V = 1e-4, 0.1      # between a candidate and a glass of the lens, which is then the right one
BONUS = 50.0                    # steps, for a glass that the lens has elsewhere: its figures may be of the wrong one
MELTS = 2                       # elements of the same wrong glass, at most
MOST = 3                        # candidates that are named
RIVAL = 1.0                     # steps behind the best one


@dataclass(frozen=True)
class _Candidate:
    quantity: str
    glass: Glass
    surface: int
    steps: float                # away from what is expected, the smaller the likelier
    colour: float               # F–C shift of the focus, of the focal length


def glass_causes(lens: Lens, findings: list[Finding]) -> list[Finding]:
    """For each glass that nobody makes the digit that would make it a known one, the likeliest first."""
    causes: list[Finding] = []
    for finding in findings:
        if finding.kind is not Kind.GLASS or finding.surface is None or "steps" not in finding.figures:
            continue
        same = [s.glass for s in lens.surfaces if s.glass == lens.surfaces[finding.surface].glass]
        if len(same) > MELTS or "names" in finding.figures:
            continue                                # the same digit is not misread so often
        found = sorted(_candidates(lens, finding.surface), key=lambda candidate: candidate.steps)
        near = [candidate for candidate in found if candidate.steps <= found[0].steps + RIVAL][:MOST]
        causes += [_cause(lens, candidate, len(near)) for candidate in near]
    return causes


def _candidates(lens: Lens, i: int) -> Iterator[_Candidate]:
    glass = lens.surfaces[i].glass
    here = first_order(lens)
    stored, stated = lens.surfaces[-1].thickness, lens.stated_efl
    assert glass.v_d is not None
    others = [s.glass for s in lens.surfaces if s.glass.v_d and s.glass != glass]
    changed = [("V_d", glass.n_d, v) for v in _one_digit(glass.v_d)]
    changed += [("n_d", n, glass.v_d) for n in _one_digit(glass.n_d)]
    for quantity, n, v in changed:
        if not (1.3 < n < 2.2 and 15.0 < v < 100.0):
            continue
        away = distance_to_known(n, v, glass_only=True)
        elsewhere = any(abs(known.n_d - n) <= SAME_N and abs((known.v_d or 0.0) - v) <= SAME_V for known in others)
        if away > NEAR and not elsewhere:
            continue
        other = Glass(n, v, glass.name)
        tried = with_surface(lens, i, glass=other)
        fo = first_order(tried)
        if not (isfinite(fo.efl) and fo.efl > 0.0):
            continue
        colour = abs(first_order(tried, F_LINE).bfl - first_order(tried, C_LINE).bfl) / fo.efl
        steps = away + colour / COLOUR if isfinite(colour) else away
        if quantity == "n_d":
            steps += abs(fo.efl / (stated or here.efl) - 1.0) / FOCUS
            steps += abs(fo.bfl - stored) / fo.efl / FOCUS if stored > 0.0 else 0.0
        if elsewhere:
            steps -= BONUS
        yield _Candidate(quantity, other, i, steps, colour)


def _one_digit(value: float) -> set[float]:
    """The number with one digit misread, or two swapped."""
    return slips(value, "digit") | slips(value, "swapped digits")


def _cause(lens: Lens, candidate: _Candidate, rivals: int) -> Finding:
    before, after, i = lens.surfaces[candidate.surface].glass, candidate.glass, candidate.surface
    old, new = (before.n_d, after.n_d) if candidate.quantity == "n_d" else (before.v_d or 0.0, after.v_d or 0.0)
    fo = first_order(with_surface(lens, i, glass=after))
    elsewhere = next((k for k, s in enumerate(lens.surfaces) if k != i and s.glass.v_d and abs(s.glass.n_d - after.n_d)
                      <= SAME_N and abs(s.glass.v_d - (after.v_d or 0.0)) <= SAME_V), None)
    why = f"as behind surface {elsewhere}" if elsewhere is not None else (
        f"the colours F and C then focus {significant(candidate.colour * fo.efl, 2)} mm apart")
    verb = "may be" if rivals > 1 else "is"
    return Finding(
        Kind.DIGIT, i, f"a digit of {candidate.quantity} {verb} misread: {significant(new)} in place of "
                       f"{significant(old)} makes it a known glass ({why})",
        f"{candidate.quantity} of surface {i}: {significant(new)} in place of {significant(old)}",
        figures={"focal_length": first_order(lens).efl, "focal_length_after": fo.efl,
                 "colour_after": candidate.colour * fo.efl},
        change=Change(candidate.quantity, i, old, new))
