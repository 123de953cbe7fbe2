"""Aspheres that were copied wrongly: conics as 1 + k, coefficients at other powers of the height, lost exponents."""

from collections.abc import Callable, Iterator
from dataclasses import replace

from lensbench.core.optics.finding import Change, Finding, Kind
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant
from lensbench.lenses.checks.hypothesis import Hypothesis

LOWEST, HIGHEST = 2, 20
EVEN = 5.0                          # rarity of a change of one surface alone
VANISHING = 1e-3                    # of the largest term at the rim: the least r⁴ of 216 published lenses has 1e-2
Terms = tuple[tuple[int, float], ...]

POWERS: dict[str, Callable[[Terms], Terms]] = {
    "one even power lower": lambda terms: tuple((power - 2, a) for power, a in terms),
    "one even power higher": lambda terms: tuple((power + 2, a) for power, a in terms),
    "one power lower": lambda terms: tuple((power - 1, a) for power, a in terms),
    "one power higher": lambda terms: tuple((power + 1, a) for power, a in terms),
    "at the powers 3, 4, 5 …": lambda terms: tuple((3 + i, a) for i, (_, a) in enumerate(terms)),
    "at the powers 4, 5, 6 …": lambda terms: tuple((4 + i, a) for i, (_, a) in enumerate(terms)),
    "at the powers 4, 6, 8 …": lambda terms: tuple((4 + 2 * i, a) for i, (_, a) in enumerate(terms)),
}


def vanishing_terms(lens: Lens) -> list[Finding]:
    """A finding where the terms in r⁴ of all aspheres, two at least, are as good as 0 beside the higher ones."""
    shares = {}
    for i, surface in enumerate(lens.surfaces):
        terms = {power: abs(a) * surface.semi_diameter**power for power, a in surface.aspheric}
        if terms and (4 not in terms or len(terms) == 1):
            return []
        if terms:
            shares[i] = terms[4] / max(terms.values())
    share = max(shares.values(), default=1.0)
    if len(shares) < 2 or share > VANISHING:
        return []
    return [Finding(Kind.ASPHERE, None, f"the terms in r⁴{_of(list(shares))} are at most {significant(share, 2)} of "
                                        "the higher ones at the edge: the source lost exponents or mixed powers",
                    figures={"share": share})]


def hypotheses(lens: Lens) -> Iterator[Hypothesis]:
    """Other readings of all conics, of all coefficients, and of the coefficients of one surface."""
    aspheric = [i for i, s in enumerate(lens.surfaces) if s.aspheric]
    conic = [i for i, s in enumerate(lens.surfaces) if s.conic != 0.0]
    both = sorted({*aspheric, *conic})
    for indices in (conic, both) if conic and both != conic else (both,):
        if indices:
            yield from _conics(lens, indices)
    for words, moved in POWERS.items():
        for indices in (aspheric, *([i] for i in aspheric if len(aspheric) > 1)):
            yield from _powers(lens, indices, words, moved, 1.5 if indices == aspheric else EVEN)
    if aspheric:
        yield _without(lens, aspheric)


def _conics(lens: Lens, indices: list[int]) -> Iterator[Hypothesis]:
    """All conics one smaller, or one larger."""
    first, where = lens.surfaces[indices[0]].conic, indices[0] if len(indices) == 1 else None
    yield Hypothesis(Kind.CONIC, Change("conic", where, first, first - 1.0),
                     "the conic constants are given as κ = 1 + k",
                     f"1 subtracted from the conic constant{_of(indices)}",
                     _changed(lens, indices, lambda s: replace(s, conic=s.conic - 1.0)))
    yield Hypothesis(Kind.CONIC, Change("conic", where, first, first + 1.0),
                     "1 was subtracted from conic constants that were k already",
                     f"1 added to the conic constant{_of(indices)}",
                     _changed(lens, indices, lambda s: replace(s, conic=s.conic + 1.0)))


def _powers(lens: Lens, indices: list[int], words: str, moved: Callable[[Terms], Terms],
            rarity: float) -> Iterator[Hypothesis]:
    """The same coefficients at other powers, where these exist."""
    terms = [lens.surfaces[i].aspheric for i in indices]
    after = [moved(row) for row in terms]
    if not indices or after == terms or not all(LOWEST <= power <= HIGHEST for row in after for power, _ in row):
        return
    yield Hypothesis(
        Kind.ASPHERE, Change("aspheric power", indices[0] if len(indices) == 1 else None, float(terms[0][0][0]),
                             float(after[0][0][0])), "the aspheric coefficients belong to other powers of the height",
        f"the coefficients{_of(indices)} {words} (the first at r^{after[0][0][0]} instead of r^{terms[0][0][0]})",
        _changed(lens, indices, lambda s: replace(s, aspheric=moved(s.aspheric))), rarity)


def _without(lens: Lens, indices: list[int]) -> Hypothesis:
    """No coefficients: where the rays then pass, these are wrong in a way that is not known."""
    first = lens.surfaces[indices[0]].aspheric[0]
    return Hypothesis(
        Kind.ASPHERE, Change("aspheric power", None, float(first[0]), 0.0), "the aspheric coefficients are wrong",
        f"without the coefficients{_of(indices)} all rays pass; no other order of their powers makes the lens good",
        _changed(lens, indices, lambda s: replace(s, aspheric=())), 100.0, frozenset((Kind.BLUR,)))


def _changed(lens: Lens, indices: list[int], change: Callable[[Surface], Surface]) -> Lens:
    return replace(lens, surfaces=tuple(change(s) if i in indices else s for i, s in enumerate(lens.surfaces)))


def _of(indices: list[int]) -> str:
    return f" of surface{'s' if len(indices) > 1 else ''} {', '.join(map(str, indices))}"
