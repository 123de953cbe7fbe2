"""One wrong sign or digit that explains a wrong focus or focal length, or a glass that nobody makes.

Every radius, gap and index is changed by the usual copying mistakes: sign lost, point moved, two digits swapped, one
digit misread. A change must restore both the stated focal length and the stored back focus. If only one of them is
known, changed digits match it by chance, and only changes of a sign are tried. Of the known glasses that one digit of
an index or Abbe number makes, those that the lens has elsewhere come first; others are judged by its focus for an
index, by its longitudinal colour for an Abbe number.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import isfinite

import numpy as np

from lensbench.core.optics.finding import Change, Finding, Kind
from lensbench.core.optics.glass import Glass
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.optics.paraxial import first_order, ray_matrix
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant
from lensbench.lenses.checks.glasses import distance_to_known
from lensbench.lenses.checks.hypotheses import Hypothesis, with_surface

BELIEVED = {"sign": 3e-3, "point": 2e-3, "swapped digits": 2e-3, "digit": 1e-3}     # misfit, of the focal length
RARITY = {"sign": 1.0, "point": 2.0, "swapped digits": 3.0, "digit": 5.0}
CAUSES = {"sign": "a radius has the wrong sign", "point": "a decimal point is misplaced",
          "swapped digits": "two digits are swapped", "digit": "a digit is misread"}
NOMINAL = 0.3           # weight of the stated focal length for a sign: there are few, and 50 mm is often 50.4
MOST = 40               # changes that are traced, of those that restore the figures
DIGITS = 7              # significant ones that are varied
INDICES = (1.3, 2.2)
KNOWN_GLASS = 1.5       # steps of the map of glasses: so near a known glass is the right index
UNKNOWN_RARITY = 3.0    # × for an index of no known glass


@dataclass(frozen=True)
class _Change:
    surface: int
    quantity: str                   # "radius", "thickness" or "n_d"
    old: float
    new: float
    kind: str

    def applied(self, lens: Lens) -> Lens:
        surfaces = list(lens.surfaces)
        surfaces[self.surface] = _changed(surfaces[self.surface], self.quantity, self.new)
        return replace(lens, surfaces=tuple(surfaces))


def hypotheses(lens: Lens) -> Iterator[Hypothesis]:
    """The changes that restore the figures, the likeliest first; only signs if but one figure is known."""
    stored, stated = lens.surfaces[-1].thickness, lens.stated_efl
    if not (stored > 0.0 or stated):
        return
    changes, efl, bfl = _figures(lens, both=stored > 0.0 and bool(stated))
    if not changes:
        return
    misfits = np.zeros(len(changes))
    if stated:
        weights = np.array([NOMINAL if change.kind == "sign" else 1.0 for change in changes])
        misfits = np.maximum(misfits, weights * np.abs(efl / stated - 1.0))
    if stored > 0.0:
        misfits = np.maximum(misfits, np.abs((bfl - stored) / (stated or efl)))
    misfits = np.where(np.isfinite(misfits) & (efl > 0.0), misfits, np.inf)
    believed = [k for k in np.argsort(misfits) if misfits[k] <= BELIEVED[changes[k].kind]]
    for k in believed[:MOST]:
        change, surface = changes[k], lens.surfaces[changes[k].surface]
        rarity = RARITY[change.kind]
        if change.quantity == "n_d" and surface.glass.v_d is not None:
            if distance_to_known(change.new, surface.glass.v_d) > KNOWN_GLASS:
                rarity *= UNKNOWN_RARITY
            elif distance_to_known(change.old, surface.glass.v_d) > KNOWN_GLASS:
                rarity /= UNKNOWN_RARITY
        yield Hypothesis(
            Kind.SIGN if change.kind == "sign" else Kind.DIGIT,
            Change(change.quantity, change.surface, change.old, change.new), CAUSES[change.kind],
            f"{change.quantity} of surface {change.surface}: {significant(change.new, 7)} instead of "
            f"{significant(change.old, 7)} (one {change.kind})", change.applied(lens), rarity)


def _figures(lens: Lens, both: bool) -> tuple[list[_Change], np.ndarray, np.ndarray]:
    """Every change, with the focal length and back focus (mm) that it gives, (m,) each."""
    changes: list[_Change] = []
    lengths, foci = [np.empty(0)], [np.empty(0)]
    n, last = lens.indices(), len(lens.surfaces)
    for i, surface in enumerate(lens.surfaces):
        options = list(_changes(i, surface, both, is_last=i == last - 1))
        if not options:
            continue
        changes += options
        tried = [_changed(surface, change.quantity, change.new) for change in options]
        c = np.array([s.vertex_curvature for s in tried])
        gap, glass = np.array([s.thickness for s in tried]), np.array([s.glass.n_d for s in tried])
        height, _, slope, _ = ray_matrix(lens, 0, i)    # of the ray that enters parallel at height 1: (A, C)
        w = slope - (glass - n[i]) * c * height
        y = np.full(len(options), height)
        if i + 1 < last:
            y = y + gap / glass * w
            w = w - (n[i + 2] - glass) * lens.surfaces[i + 1].vertex_curvature * y
            y, w = _onward(lens, i + 1, y, w)
        lengths.append(-1.0 / w)
        foci.append(-n[-1] * y / w)
    return changes, np.concatenate(lengths), np.concatenate(foci)


def _onward(lens: Lens, i: int, y: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Height and reduced slope behind the last surface, of rays just behind surface i."""
    if i == len(lens.surfaces) - 1:
        return y, w
    y = y + lens.surfaces[i].thickness / lens.indices()[i + 1] * w
    a, b, c, d = ray_matrix(lens, i + 1, len(lens.surfaces))
    return a * y + b * w, c * y + d * w


def _changed(surface: Surface, quantity: str, value: float) -> Surface:
    if quantity == "radius":
        return replace(surface, curvature=1.0 / value)
    if quantity == "thickness":
        return replace(surface, thickness=value)
    return replace(surface, glass=replace(surface.glass, n_d=value, formula="model", coefficients=(), wavelengths=None))


def _changes(i: int, surface: Surface, both: bool, is_last: bool) -> Iterator[_Change]:
    """Copying mistakes that are possible in the numbers of a surface."""
    kinds = tuple(BELIEVED) if both else ("sign",)
    if surface.curvature != 0.0:
        radius = 1.0 / surface.curvature
        for kind in kinds:
            for new in slips(radius, kind):
                yield _Change(i, "radius", radius, new, kind)
    if surface.thickness != 0.0 and not is_last:
        for kind in kinds:
            if kind != "sign":                          # a gap has none
                for new in slips(surface.thickness, kind):
                    yield _Change(i, "thickness", surface.thickness, new, kind)
    if surface.glass.n_d > 1.0:
        for kind in kinds:
            if kind in ("digit", "swapped digits"):
                for new in slips(surface.glass.n_d, kind):
                    if INDICES[0] < new < INDICES[1]:
                        yield _Change(i, "n_d", surface.glass.n_d, new, kind)


def slips(value: float, kind: str) -> set[float]:
    """Numbers that result from a number by this kind of copying mistake."""
    if kind == "sign":
        return {-value}
    if kind == "point":
        return {value * factor for factor in (0.01, 0.1, 10.0, 100.0)}
    text = np.format_float_positional(float(f"{value:.{DIGITS}g}"), trim="0")
    positions = [k for k, letter in enumerate(text) if letter.isdigit()]
    if kind == "swapped digits":
        texts = [text[:j] + text[k] + text[j + 1:k] + text[j] + text[k + 1:] for j, k in zip(positions, positions[1:],
                                                                                          strict=False)]
    else:
        texts = [text[:k] + digit + text[k + 1:] for k in positions for digit in "0123456789"]
    return {float(changed) for changed in texts if changed != text} - {0.0, value}


NEAR = 1.2                      # steps of the map of glasses
F_LINE, C_LINE = 0.4861327, 0.6562725
COLOUR = 1e-3                   # of the focal length: the longitudinal colour of an achromat, as much as one step
FOCUS = 2e-3                    # of the focal length: a shift of the focus by another index, as much as one step
SAME_N, SAME_V = 1e-4, 0.1      # between a candidate and a glass of the lens, which is then the right one
BONUS = 50.0                    # steps, for a glass that the lens has elsewhere: its figures may be of the wrong one
MELTS = 2                       # elements of the same wrong glass, at most
GLASS_DIGITS_MOST = 3                        # candidates that are named
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
        candidates = sorted(_candidates(lens, finding.surface), key=lambda candidate: candidate.steps)
        limit = candidates[0].steps + RIVAL if candidates else 0.0
        near = [candidate for candidate in candidates if candidate.steps <= limit][:GLASS_DIGITS_MOST]
        causes += [_cause(lens, candidate, len(near)) for candidate in near]
    return causes


def _candidates(lens: Lens, i: int) -> Iterator[_Candidate]:
    glass = lens.surfaces[i].glass
    before = first_order(lens)
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
            steps += abs(fo.efl / (stated or before.efl) - 1.0) / FOCUS
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
        Kind.DIGIT, i, f"a digit of {candidate.quantity} {verb} misread: {significant(new)} instead of "
                       f"{significant(old)} makes it a known glass ({why})",
        f"{candidate.quantity} of surface {i}: {significant(new)} instead of {significant(old)}",
        figures={"focal_length": first_order(lens).efl, "focal_length_after": fo.efl,
                 "colour_after": candidate.colour * fo.efl},
        change=Change(candidate.quantity, i, old, new))
