"""Other readings of a lens table, each a change that may make the lens good; and doubts about its stop and aspheres.

Aspheres that were copied wrongly: conics as 1 + k, coefficients at other powers of the height, lost exponents. What
belongs to a lens and is not in its table: water before it, glass before the film, the unit of its lengths. The stop at
another surface, or with another semi-diameter: what the stated f-number asks for; whether the stop limits the light,
and whether a plane that was made for it is another surface.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import isfinite
from typing import Any

from lensbench.core.optics.finding import Change, Finding, Kind
from lensbench.core.optics.glass import Glass
from lensbench.core.optics.lens_surface import Surface
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant
from lensbench.lenses.tables.paraxial import axial_heights


@dataclass(frozen=True)
class Hypothesis:
    """One change that may make a lens good.

    kind: of the finding that names it. cause: what went wrong, as the first part of a sentence. words: the change, such
    as "radius of surface 3: 45 instead of −45". lens: with the change. rarity: how much rarer this mistake is than a
    lost sign, or how many such changes are tried; the misfit counts so much more. expects: findings that may be new
    with the change.
    """

    kind: Kind
    change: Change
    cause: str
    words: str
    lens: Lens
    rarity: float = 1.0
    expects: frozenset[Kind] = frozenset()


def with_surface(lens: Lens, i: int, **changes: Any) -> Lens:
    """The lens with one surface changed."""
    surfaces = list(lens.surfaces)
    surfaces[i] = replace(surfaces[i], **changes)
    return replace(lens, surfaces=tuple(surfaces))


LOWEST_POWER, HIGHEST_POWER = 2, 20
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


def aspheric_hypotheses(lens: Lens) -> Iterator[Hypothesis]:
    """Other readings of all conics, of all coefficients, and of the coefficients of one surface."""
    aspheric = [i for i, s in enumerate(lens.surfaces) if s.aspheric]
    conic = [i for i, s in enumerate(lens.surfaces) if s.conic != 0.0]
    both = sorted({*aspheric, *conic})
    for indices in (conic, both) if conic and both != conic else (both,):
        if indices:
            yield from _conics(lens, indices)
    for words, moved in POWERS.items():
        for indices in (aspheric, *([i] for i in aspheric if len(aspheric) > 1)):
            yield from _other_powers(lens, indices, words, moved, 1.5 if indices == aspheric else EVEN)
    if aspheric:
        yield _without(lens, aspheric)


def _conics(lens: Lens, indices: list[int]) -> Iterator[Hypothesis]:
    """All conics one smaller, or one larger."""
    first, where = lens.surfaces[indices[0]].conic, indices[0] if len(indices) == 1 else None
    for step, cause, verb in ((-1.0, "the conic constants are given as κ = 1 + k", "subtracted from"),
                              (1.0, "1 was subtracted from conic constants that were k already", "added to")):
        yield Hypothesis(Kind.CONIC, Change("conic", where, first, first + step), cause,
                         f"1 {verb} the conic constant{_of(indices)}",
                         replace(lens, surfaces=tuple(replace(s, conic=s.conic + step) if i in indices else s
                                                      for i, s in enumerate(lens.surfaces))))


def _other_powers(lens: Lens, indices: list[int], words: str, moved: Callable[[Terms], Terms],
            rarity: float) -> Iterator[Hypothesis]:
    """The same coefficients at other powers, where these exist."""
    terms = [lens.surfaces[i].aspheric for i in indices]
    after = [moved(row) for row in terms]
    powers = [power for row in after for power, _ in row]
    if not indices or after == terms or not all(LOWEST_POWER <= power <= HIGHEST_POWER for power in powers):
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


WATER = 1.333
PLATE = Glass(1.5168, 64.17)                # window and filters of a sensor
PLATES = (0.2, 6.0)                         # mm: their thickness, in digital cameras and telephones
DIGITAL = 1990                              # before this year there is film, with nothing before it
BEHIND = 8.0                                # mm of air: what a table may leave out behind its last gap
BEHIND_SHARE = 0.4                          # and of the focal length
PLATE_FOCAL_LENGTH = 0.005                   # a plate does not change it
SAME_AT_STATIONS = 0.1                      # of the shift of the focus: it is alike at every zoom station
UNITS = {10.0: "centimetres", 25.4: "inches", 1000.0: "metres", 0.1: "millimetres that were read as centimetres",
         1.0 / 25.4: "millimetres that were read as inches", 0.001: "millimetres that were read as metres"}
NORMAL = (1.0, 10.0, 100.0, 1000.0)         # focal lengths that tables are normalised to
SCALE = 0.02                                # between the ratio of focal lengths and the unit


def surrounding_hypotheses(lens: Lens) -> Iterator[Hypothesis]:
    """Water or air in front, a plate before the film, another unit."""
    before, after = (1.0, WATER) if lens.front_index == 1.0 else (lens.front_index, 1.0)
    cause = "the lens is immersed in water" if after > 1.0 else "the lens is in air"
    yield Hypothesis(Kind.MEDIUM, Change("front_index", None, before, after), cause,
                     f"front_index {significant(after)} instead of "
                     f"{significant(before)}", replace(lens, front_index=after))
    yield from _plates(lens)
    yield from _scales(lens)


def _plates(lens: Lens) -> Iterator[Hypothesis]:
    """A plane plate in the last gap, or behind it, that explains a wrong back focus and nothing else."""
    fo, last = first_order(lens), lens.surfaces[-1]
    shift, glass = last.thickness - fo.bfl, f"n_d {significant(PLATE.n_d)}"
    if (lens.year and lens.year < DIGITAL) or last.thickness <= 0.0 or not isfinite(shift):
        return
    if lens.stated_efl and not abs(fo.efl / lens.stated_efl - 1.0) <= PLATE_FOCAL_LENGTH:
        return
    if not all(abs(other - shift) <= SAME_AT_STATIONS * abs(shift) for other in _shifts(lens)):
        return
    if shift > 0.0:
        thickness = shift / (1.0 - 1.0 / PLATE.n_d)
        if not PLATES[0] <= thickness <= min(PLATES[1], last.thickness):
            return
        space, behind = 0.5 * (last.thickness - thickness), 0.5 * (last.thickness - thickness)
        words = f"a plate of {significant(thickness, 3)} mm ({glass}) in the gap before the film"
    else:
        if -shift > min(BEHIND, BEHIND_SHARE * abs(fo.efl)):
            return
        space, thickness, behind = last.thickness, -0.5 * shift * PLATE.n_d, -0.5 * shift
        words = (f"glass and air behind the last gap that together equal {significant(-shift, 3)} mm of air, such as "
                 f"a plate of up to {significant(-shift * PLATE.n_d, 3)} mm ({glass})")
    if not behind > 0.0:
        return
    rim = last.semi_diameter
    surfaces = (*lens.surfaces[:-1], replace(last, thickness=space), Surface(thickness, rim, PLATE, curvature=0.0),
                Surface(behind, rim, curvature=0.0))
    yield Hypothesis(Kind.COVER_GLASS, Change("cover glass", len(lens.surfaces) - 1, 0.0, thickness),
                     "the cover glass or sensor stack before the film is not in the table", words,
                     replace(lens, surfaces=surfaces, positions=None), 3.0)


def _shifts(lens: Lens) -> list[float]:
    """From the focus to the stored film at every zoom station (mm)."""
    stations = lens.positions.zoom_stations if lens.zooms and lens.positions else ()
    there = [lens.at(zoom=zoom) for zoom in stations]
    return [station.surfaces[-1].thickness - first_order(station).bfl for station in there]


def _scales(lens: Lens) -> Iterator[Hypothesis]:
    """Another unit of all lengths, or a table that is normalised to a round focal length."""
    efl, stated = first_order(lens).efl, lens.stated_efl
    if not stated or not isfinite(efl) or not efl > 0.0:
        return
    ratio = stated / efl
    units = {factor: f"the lengths are {unit}" for factor, unit in UNITS.items()}
    normal = next((f for f in NORMAL if abs(efl / f - 1.0) <= SCALE), None)
    if normal and not any(abs(ratio / factor - 1.0) <= SCALE for factor in units):
        units[ratio] = f"the table is normalised to a focal length of {significant(normal)}"
    for factor, cause in units.items():
        if abs(ratio / factor - 1.0) <= SCALE:
            yield Hypothesis(Kind.SCALE, Change("scale", None, 1.0, factor), cause, f"all lengths × "
                                                                                    f"{significant(factor, 6)}",
                             replace(lens.scaled(factor), stated_efl=stated))


F_NUMBER = 0.05             # of the stated one
DIAMETERS = 0.08            # of a factor of 2, for rims that hold diameters
STOP_FOCAL_LENGTH = 0.02    # of the stated one; otherwise the f-number says nothing about the stop
SAME = 0.15                 # of the stated f-number: the stop is not doubted


def is_plane_in_air(lens: Lens, i: int) -> bool:
    """Whether a surface bends no ray: a plane with air on both sides."""
    n, surface = lens.indices(), lens.surfaces[i]
    return n[i] == n[i + 1] == 1.0 and surface.curvature == 0.0 and surface.is_spherical


def planes_in_air(lens: Lens) -> list[int]:
    """Surfaces within the lens, with glass before and behind, that bend no ray."""
    glass = [i for i, surface in enumerate(lens.surfaces) if surface.glass.n_d != 1.0]
    return [i for i in range(len(lens.surfaces)) if glass and glass[0] < i <= glass[-1] and is_plane_in_air(lens, i)]


def stop_hypotheses(lens: Lens) -> Iterator[Hypothesis]:
    """Other surfaces as the stop, the rim of the stop, and rims that are diameters."""
    stated, f_number = lens.stated_f_number, first_order(lens).f_number
    planes, marked = planes_in_air(lens), lens.stop_index
    for i in range(len(lens.surfaces)):
        if i == marked or (planes and i not in planes):
            continue
        there = replace(lens, stop_index=i)
        if stated and not abs(first_order(there).f_number / stated - 1.0) <= F_NUMBER:
            continue
        if stated is None and i not in planes:
            continue
        yield Hypothesis(Kind.STOP, Change("stop_index", i, float(marked), float(i)),
                         "the stop is marked at the wrong surface", f"the stop at surface {i} instead of {marked}",
                         there, 1.0 if i in planes else 4.0)
    efl = first_order(lens).efl
    sound = abs(efl / lens.stated_efl - 1.0) <= STOP_FOCAL_LENGTH if lens.stated_efl else False
    if not (stated and sound and isfinite(f_number) and abs(f_number / stated - 1.0) > SAME):
        return
    ratio = f_number / stated
    for factor, cause in ((0.5, "the semi-diameters are diameters"), (2.0, "the semi-diameters are halved")):
        if abs(ratio / factor - 1.0) <= DIAMETERS:
            rims = tuple(replace(s, semi_diameter=factor * s.semi_diameter) for s in lens.surfaces)
            yield Hypothesis(Kind.RIM, Change("semi_diameter", None, lens.stop.semi_diameter,
                                              factor * lens.stop.semi_diameter), cause, f"all semi-diameters × "
                                                                                        f"{significant(factor)}",
                             replace(lens, surfaces=rims), 1.5)
    radius = ratio * lens.stop.semi_diameter
    yield Hypothesis(Kind.STOP, Change("semi_diameter", marked, lens.stop.semi_diameter, radius),
                     "the stop's semi-diameter is not that of the stated f-number",
                     f"semi-diameter of surface {marked}: {significant(radius, 4)} mm instead of "
                     f"{significant(lens.stop.semi_diameter, 4)} mm",
                     lens.with_stop_radius(radius), 10.0)


LIMITING = 0.67         # of the stop's beam: what other rims must leave of it; rims that are estimates leave 0.72


def stop_findings(lens: Lens) -> list[Finding]:
    """Findings about a stop that does not limit the light because another rim does, or that is marked on glass."""
    heights = axial_heights(lens.surfaces)
    beams = [surface.semi_diameter / abs(height) if height else float("inf")
             for surface, height in zip(lens.surfaces, heights, strict=True)]
    narrowest = min(range(len(beams)), key=beams.__getitem__)
    planes = planes_in_air(lens)
    findings = []
    assumed = any(finding.kind is Kind.NO_STOP for finding in lens.findings)
    if not assumed and len(planes) == 1 and 0 < lens.stop_index and not is_plane_in_air(lens, lens.stop_index):
        findings.append(Finding(
            Kind.STOP, lens.stop_index, f"the stop is marked on surface {lens.stop_index}, which refracts; surface "
            f"{planes[0]} is a plane in air between the elements, as stops are"))
    if not beams[narrowest] < LIMITING * beams[lens.stop_index]:
        return findings
    return [*findings, Finding(
        Kind.STOP, lens.stop_index, f"the stop does not limit the light: on the axis surface {narrowest} "
                                    f"passes a beam of {significant(2.0 * beams[narrowest], 4)} mm, the stop one of "
                                    f"{significant(2.0 * beams[lens.stop_index], 4)} mm",
        figures={"beam": 2.0 * beams[narrowest], "stop_beam": 2.0 * beams[lens.stop_index]})]
