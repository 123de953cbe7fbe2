"""The causes that would explain what is wrong with a lens, the most probable first.

Each hypothesis is one change. It is named if the lens with it has fewer kinds of findings and no new ones, and if a
beam that was blurred is several times sharper. Hypotheses that leave fewer findings come first, then those that
reproduce the stated figures better, with rare mistakes counted less.

Symptoms: findings about a lens as a whole. Where there are any, other checks look for a surface that causes them.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf, isfinite, sqrt

import numpy as np

from lensbench.core.optics.finding import Finding, Kind, Severity
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant
from lensbench.lenses.checks import hypotheses, single_change
from lensbench.lenses.checks.axial_beam import allowed_blur, axial_beam, ray_findings
from lensbench.lenses.checks.figures import field_findings, figure_findings, lit_field
from lensbench.lenses.checks.geometry import geometry_findings
from lensbench.lenses.checks.hypotheses import Hypothesis, stop_findings


def symptom_findings(lens: Lens) -> list[Finding]:
    """Findings about the figures, the axial beam, the stop and the field."""
    return [*figure_findings(lens), *ray_findings(lens), *stop_findings(lens), *field_findings(lens)]


PARAXIAL = {Kind.FOCAL_LENGTH, Kind.BACK_FOCUS}
OPTICAL = {Kind.RAY, Kind.BLUR}
SHAPES = {Kind.HEMISPHERE, Kind.EDGE, Kind.CROSSING, Kind.THICKNESS}
REFRACTING = {Kind.SIGN, Kind.DIGIT, Kind.CONIC, Kind.ASPHERE, Kind.MEDIUM}
SHARPER = 2.0           # × : less may be chance
RARE = 5.0              # rarity from which that is multiplied by √rarity, and a better shape alone proves nothing
BLURRED = 1.5           # × : a change that explains the figures alone leaves the blur in best focus as it is,
SHARP = 2e-4            # or small, in focal lengths
FAILED = 5.0            # × the allowed blur
RIVAL = 5.0             # × the misfit of the best one: other changes that fit nearly as well are named too
MOST = 3                # causes that are named; more would prove none
FLOOR = 1e-5            # of the focal length: a misfit below it is rounding


@dataclass(frozen=True)
class _Judged:
    hypothesis: Hypothesis
    cleared: frozenset[Kind]            # kinds of findings that the change removes
    left: int                           # kinds that remain
    misfit: float                       # of the figures and the blur, in focal lengths


def cause_findings(lens: Lens, symptoms: list[Finding]) -> list[Finding]:
    """The causes of a lens's symptoms as findings, each with its change and the figures that follow.

    Nothing for a lens with a cylinder or toroid. symptoms: of `symptom_findings` and `geometry_findings`.
    """
    before = _kinds(symptoms)
    if not before or not lens.is_rotationally_symmetric:
        return []
    judged: list[_Judged] = []
    tried: set[Lens] = set()
    for hypothesis in _hypotheses(lens, before):
        if hypothesis.lens not in tried:    # two words for one change are no rivals
            tried.add(hypothesis.lens)
            cause = _judge(lens, hypothesis, before)
            judged += [cause] if cause else []
    judged.sort(key=lambda cause: (cause.left, cause.misfit * cause.hypothesis.rarity))
    findings: list[Finding] = []
    while judged:                           # findings that one change leaves may have a cause of their own
        named, proven = _named(judged)
        findings += [_finding(lens, cause, proven) for cause in named]
        explained = judged[0].cleared
        judged = [cause for cause in judged if not cause.cleared & explained]
    return findings


def _named(judged: list[_Judged]) -> tuple[list[_Judged], bool]:
    """The best one and its rivals, and whether it has none.

    Of too many rivals those that are no digits, of which some always fit.
    """
    best = judged[0]
    limit = RIVAL * max(best.misfit * best.hypothesis.rarity, FLOOR)
    near = [cause for cause in judged if cause.left == best.left and cause.misfit * cause.hypothesis.rarity <= limit]
    proven = len(near) == 1
    if len(near) > MOST:
        near = [cause for cause in near if cause.hypothesis.kind is not Kind.DIGIT]
    return near if len(near) <= MOST else [], proven


def _hypotheses(lens: Lens, before: set[Kind]) -> Iterator[Hypothesis]:
    """The hypotheses that could explain findings of these kinds."""
    if before & (PARAXIAL | OPTICAL | SHAPES):
        yield from single_change.hypotheses(lens)
        yield from hypotheses.surrounding_hypotheses(lens)
        yield from hypotheses.aspheric_hypotheses(lens)
    if before & {Kind.F_NUMBER, Kind.STOP, Kind.FIELD}:
        yield from hypotheses.stop_hypotheses(lens)


def _judge(lens: Lens, hypothesis: Hypothesis, before: set[Kind]) -> _Judged | None:
    """The hypothesis with its misfit; None if the lens is no better with it."""
    changed = hypothesis.lens
    after = _kinds(symptom_findings(changed))
    if not before - after or after - before - hypothesis.expects:
        return None
    if before & OPTICAL and not (after | hypothesis.expects) & OPTICAL:
        film = hypothesis.kind not in (Kind.CONIC, Kind.ASPHERE)        # these leave the paraxial focus where it is
        needed = SHARPER * (sqrt(hypothesis.rarity) if hypothesis.rarity >= RARE else 1.0)
        if not _blur(changed, film) * needed <= _blur(lens, film):
            return None
    elif not before & OPTICAL and hypothesis.kind in REFRACTING and (
            _blur(changed, False) > max(BLURRED * _blur(lens, False), SHARP)):
        return None
    after |= _kinds(geometry_findings(changed))
    if not before - after or after - before - hypothesis.expects:
        return None
    if hypothesis.rarity >= RARE and not (before - after) - SHAPES:
        return None
    return _Judged(hypothesis, frozenset(before - after), len(after), _misfit(changed))


def _kinds(findings: list[Finding]) -> set[Kind]:
    return {finding.kind for finding in findings if finding.severity is Severity.WARNING}


def _blur(lens: Lens, film: bool) -> float:
    """Rms radius of the blur in focal lengths: in best focus, or there or on the film, whichever is larger.

    If a ray fails it is so much that every lens with an allowed blur is sharper.
    """
    beam = axial_beam(lens)
    efl = abs(first_order(lens).efl)
    if beam is None or not isfinite(efl):
        return inf
    if not isfinite(beam.blur):
        return FAILED * allowed_blur(lens, beam.f_number)
    return max(beam.blur, beam.film_blur if film and lens.surfaces[-1].thickness else 0.0) / efl


def _misfit(lens: Lens) -> float:
    """Departure from the stated focal length and the stored back focus, and the blur, in focal lengths."""
    fo, beam = first_order(lens), axial_beam(lens)
    stored = lens.surfaces[-1].thickness
    total = abs(fo.efl / lens.stated_efl - 1.0) if lens.stated_efl else 0.0
    if stored > 0.0:
        total += abs(fo.bfl - stored) / abs(fo.efl)
    if beam is not None and isfinite(beam.blur):
        total += beam.blur / abs(fo.efl)
    return total if isfinite(total) else inf


def _finding(lens: Lens, cause: _Judged, proven: bool) -> Finding:
    hypothesis = cause.hypothesis
    figures = _figures(lens, hypothesis.lens)
    names = {"focal_length": "focal length", "back_focus": "back focus", "blur": "blur on the axis",
             "field": "half field"}
    told = [f"{words} {significant(figures[name], 4)} → {significant(figures[name + '_after'], 4)} "
            f"{'°' if name == 'field' else 'mm'}"
            for name, words in names.items() if _differ(figures, name)]
    if _differ(figures, "f_number"):
        told.append(f"f/{significant(figures['f_number'], 3)} → f/{significant(figures['f_number_after'], 3)}")
    perhaps = "" if proven else "perhaps "
    results = f": {', '.join(told)}" if told else ""
    rest = "" if cause.left == 0 else "; other findings remain"
    return Finding(hypothesis.kind, hypothesis.change.surface, f"{perhaps}{hypothesis.cause}{results}{rest}",
                   hypothesis.words, figures=figures, change=hypothesis.change)


def _figures(lens: Lens, changed: Lens) -> dict[str, float]:
    """Figures before the change and after it; lengths in mm, the field in degrees."""
    figures: dict[str, float] = {}
    for end, variant in (("", lens), ("_after", changed)):
        fo, beam = first_order(variant), axial_beam(variant)
        figures |= {f"focal_length{end}": fo.efl, f"f_number{end}": fo.f_number}
        if len(lens.surfaces) == len(changed.surfaces):         # a plate that is added has a back focus of its own
            figures[f"back_focus{end}"] = fo.bfl
        if beam is not None:
            figures[f"blur{end}"] = beam.film_blur if variant.surfaces[-1].thickness else beam.blur
        if lens.system.largest_field:
            figures[f"field{end}"] = lit_field(variant)[0]
    return {name: float(value) for name, value in figures.items() if np.isfinite(value)}


def _differ(figures: dict[str, float], name: str) -> bool:
    """Whether the change alters a figure that is known before and after it."""
    before, after = figures.get(name), figures.get(f"{name}_after")
    return before is not None and after is not None and abs(after - before) > 1e-4 * abs(before)
