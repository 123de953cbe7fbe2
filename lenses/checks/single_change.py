"""One wrong sign or digit that explains a wrong focus or focal length.

Every radius, gap and index is changed by the usual copying mistakes: sign lost, point
moved, two digits swapped, one digit misread. A change must restore both the stated
focal length and the stored back focus. If only one of them is known, changed digits
match it by chance, and only changes of a sign are tried.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from lensbench.kernels.figures import significant
from lensbench.lenses.checks.glasses import distance_to_known
from lensbench.lenses.checks.hypothesis import Hypothesis
from lensbench.optics.finding import Change, Kind
from lensbench.optics.lens_surface import Surface
from lensbench.optics.paraxial import ray_matrix
from lensbench.optics.prescription import Lens

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
            f"{change.quantity} of surface {change.surface}: {significant(change.new, 7)} in place of "
            f"{significant(change.old, 7)} (one {change.kind})", change.applied(lens), rarity)


def _figures(lens: Lens, both: bool) -> tuple[list[_Change], np.ndarray, np.ndarray]:
    """Every change, with the focal length and back focus (mm) that it gives, (m,) each."""
    changes: list[_Change] = []
    lengths, foci = [np.empty(0)], [np.empty(0)]
    n, last = lens.indices(), len(lens.surfaces)
    for i, surface in enumerate(lens.surfaces):
        here = list(_changes(i, surface, both, is_last=i == last - 1))
        if not here:
            continue
        changes += here
        tried = [_changed(surface, change.quantity, change.new) for change in here]
        c = np.array([s.vertex_curvature for s in tried])
        gap, glass = np.array([s.thickness for s in tried]), np.array([s.glass.n_d for s in tried])
        height, _, slope, _ = ray_matrix(lens, 0, i)    # of the ray that enters parallel at height 1: (A, C)
        w = slope - (glass - n[i]) * c * height
        y = np.full(len(here), height)
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
    places = [k for k, letter in enumerate(text) if letter.isdigit()]
    if kind == "swapped digits":
        texts = [text[:j] + text[k] + text[j + 1:k] + text[j] + text[k + 1:] for j, k in zip(places, places[1:],
                                                                                          strict=False)]
    else:
        texts = [text[:k] + digit + text[k + 1:] for k in places for digit in "0123456789"]
    return {float(changed) for changed in texts if changed != text} - {0.0, value}
