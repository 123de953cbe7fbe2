"""Focal length, back focus, f-number and field: computed from the surfaces, against the stated values."""

from math import degrees, isfinite, isinf

import numpy as np

from lensbench.core.optics.finding import Finding, Kind, Severity
from lensbench.core.optics.paraxial import FirstOrder, first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import Fate, trace
from lensbench.core.optics.system import FieldKind
from lensbench.core.text import significant
from lensbench.lenses.checks.axial_beam import axial_beam

PUBLISHED = 5           # significant digits of a printed radius
SOLVED = 9              # significant digits of a radius left by a solve
SINGLE = 6e-8           # relative: digits beyond it are the noise of a float32
DOUBLE = 1e-12


def digit_findings(lens: Lens) -> list[Finding]:
    """The one radius with many digits among radii with few, unless a solve or pickup of the file sets it."""
    radii = {i: 1.0 / s.curvature for i, s in enumerate(lens.surfaces) if s.curvature}
    long = [i for i, radius in radii.items() if _digits(radius, SINGLE) > PUBLISHED + 1]
    rest = [_digits(radius, SINGLE) for i, radius in radii.items() if i not in long]
    if len(long) != 1 or len(rest) < 3 or max(rest) > PUBLISHED or _digits(radii[long[0]], DOUBLE) < SOLVED:
        return []
    if any(finding.kind is Kind.RULE and finding.surface == long[0] for finding in lens.findings):
        return []
    return [Finding(Kind.SOLVED_RADIUS, long[0],
                    f"radius {significant(radii[long[0]], 10)} mm has many digits where no other has more than "
                    f"{max(rest)}: it was solved for, to focus the lens, and is not that of the source; another number "
                    "may be wrong")]


def _digits(value: float, tolerance: float) -> int:
    """Number of significant decimal digits that give a value to a relative tolerance."""
    return next(digits for digits in range(1, 18) if abs(float(f"{value:.{digits}g}") - value) <= tolerance * abs(value)
                or digits == 17)


FOCAL_LENGTH = 0.02     # of the stated one: published focal lengths are nominal, and round to two digits
BACK_FOCUS = 0.01       # of the focal length: published back foci are those of best focus, or of a rounded table
WITHIN = 0.03           # of the focal length: how far a back focus is moved to balance spherical aberration
BLUR = 0.005            # of the focal length: the disk on the axis, at full aperture, that a wrong back focus leaves
FOCI = 0.01             # of the focal length: between the two sections of an anamorphic lens
ENGRAVED = 0.05         # of the stated one, for a zoom in focus: its range is nominal, such as 35–200 for 36.2–194.9 mm
F_NUMBER = 0.15         # of the stated one: of published lenses the stop opens at most 13 % more than the marking
FASTEST = 0.5           # f-number: a cone of 180° in air


def figure_findings(lens: Lens) -> list[Finding]:
    """Findings where first-order figures contradict the stated ones, or each other."""
    sections = [first_order(lens)]
    if len(lens.sections) > 1:
        sections.append(first_order(lens.section("x")))
    if all(isinf(section.efl) for section in sections):
        return [Finding(Kind.FOCAL_LENGTH, None, "the lens is afocal: it forms no image of its own")]
    findings = []
    if len(sections) == 2 and not abs(sections[0].bfl - sections[1].bfl) <= FOCI * abs(sections[0].efl):
        rear, across = (significant(section.bfl, 5) for section in sections)
        findings.append(Finding(Kind.FOCI, None, f"the two sections do not focus in one plane: y–z {rear} mm behind "
                                                 f"the last surface, x–z {across} mm"))
    return [*findings, *_back_focus(lens, sections[0]), *_focal_length(lens, sections), *_f_number(lens, sections[0])]


def _back_focus(lens: Lens, section: FirstOrder) -> list[Finding]:
    stored, bfl, efl = lens.surfaces[-1].thickness, section.bfl, abs(section.efl)
    inside = ", inside the lens" if bfl < 0.0 else ""
    if isinf(bfl) or (stored == 0.0 and not inside):                # not stored
        return []
    off = bfl - stored
    blur = abs(off) / section.f_number if section.f_number else 0.0
    if stored != 0.0 and abs(off) <= WITHIN * efl and (
            agree(bfl, stored) or (abs(off) <= BACK_FOCUS * efl and blur <= BLUR * efl)):
        return []
    figures = {"back_focus": bfl, "stored": stored}
    beam = axial_beam(lens) if stored != 0.0 and lens.is_rotationally_symmetric else None
    if beam is not None and beam.film_blur < beam.paraxial_blur and abs(off) <= WITHIN * efl:
        message = (f"the stored back focus, {significant(stored, 5)} mm, is set for the full aperture: there a point "
                   f"on the axis becomes a disk of {significant(beam.film_blur, 2)} mm rms radius, at the paraxial "
                   f"focus, {significant(bfl, 5)} mm, one of {significant(beam.paraxial_blur, 2)} mm")
        return [Finding(Kind.BACK_FOCUS, len(lens.surfaces) - 1, message, severity=Severity.NOTE, figures=figures)]
    message = f"the paraxial focus lies {significant(bfl, 5)} mm behind the last surface{inside}"
    if stored != 0.0:
        message += (f", the stored back focus is {significant(stored, 5)} mm: a point on the axis becomes a disk of "
                    f"{significant(blur, 2)} mm, {significant(blur / efl, 2)} focal lengths")
    return [Finding(Kind.BACK_FOCUS, len(lens.surfaces) - 1, message, figures=figures)]


def _focal_length(lens: Lens, sections: list[FirstOrder]) -> list[Finding]:
    lengths = [section.efl for section in sections]
    words = " and ".join(significant(efl, 5) for efl in lengths) + " mm"
    words += " (y–z and x–z)" if len(lengths) == 2 else ""
    if lens.stated_efl is None or not lens.stated_efl:
        return [] if max(lengths) > 0.0 else [
            Finding(Kind.FOCAL_LENGTH, None, f"the focal length is {words}: the lens diverges")]
    errors = [abs(efl / lens.stated_efl - 1.0) for efl in lengths]
    if min(errors) <= FOCAL_LENGTH or any(agree(efl, lens.stated_efl) for efl in lengths):
        return []
    figures = {"focal_length": lengths[0], "stated": lens.stated_efl}
    in_focus = len(sections) == 1 and lens.surfaces[-1].thickness != 0.0 and not _back_focus(lens, sections[0])
    if lens.zooms and in_focus and min(errors) <= ENGRAVED:
        message = (f"the focal length is {words}, where {significant(lens.stated_efl)} mm is stated: the zoom is in "
                   "focus, and its engraved range is nominal")
        return [Finding(Kind.FOCAL_LENGTH, None, message, severity=Severity.NOTE, figures=figures)]
    message = (f"the focal length is {words}, {significant(100.0 * min(errors), 3)} % from the stated "
               f"{significant(lens.stated_efl)} mm")
    if in_focus:
        message += "; yet the back focus is right, so that the stated length may be of another lens or scale"
    return [Finding(Kind.FOCAL_LENGTH, None, message, figures=figures)]


def _f_number(lens: Lens, section: FirstOrder) -> list[Finding]:
    stated = lens.stated_f_number
    if section.f_number < FASTEST:
        return [Finding(Kind.F_NUMBER, lens.stop_index,
                        f"the stop opens the lens to f/{significant(section.f_number, 3)}: "
                        f"no lens in air is faster than f/{significant(FASTEST)}")]
    if stated is None or stated <= 0.0 or agree(section.f_number, stated) or (
            abs(section.f_number / stated - 1.0) <= F_NUMBER):
        return []
    # The tables of most zooms have one size of the stop, that of the first station
    assumed = lens.positions is not None and lens.positions.zoom != 0.0 and not lens.positions.stops
    return [Finding(Kind.F_NUMBER, lens.stop_index,
                    f"the stop opens the lens to f/{significant(section.f_number, 3)}, where f/{significant(stated)} "
                    "is stated",
                    severity=Severity.NOTE if assumed else Severity.WARNING,
                    figures={"f_number": section.f_number, "stated": stated})]


def agree(computed: float, stated: float) -> bool:
    """Whether a computed figure, rounded to the printed digits of the stated one, is the stated one."""
    text = f"{significant(stated, 12)}"
    if not isfinite(computed) or "e" in text:
        return False
    decimals = len(text.partition(".")[2])
    if abs(stated) < 10.0:
        decimals = max(decimals, 1)                         # 5 for 5.0: a number does not keep its last zero
    return round(computed, decimals) == stated


LIT = 0.7                       # of the stated half angle: published rims, and good estimates, pass it
ANGLES = np.radians(np.linspace(0.0, 89.0, 357))        # of the chief ray at the stop


def field_findings(lens: Lens) -> list[Finding]:
    """Finding about a stated field of which the chief ray meets a rim, or no surface."""
    stated = lens.system.largest_field if lens.system.field_kind is FieldKind.ANGLE else 0.0
    if not stated > 0.0 or not lens.is_rotationally_symmetric:
        return []
    lit, why = lit_field(lens)
    if lit >= LIT * stated:
        return []
    return [Finding(Kind.FIELD, why, f"the stated half field of {significant(stated)}° is not lit: beyond "
                                     f"{significant(lit, 3)}° the ray through the centre of the stop does not pass "
                                     f"surface {why}",
                    figures={"stated": stated, "lit": lit})]


def lit_field(lens: Lens) -> tuple[float, int | None]:
    """Largest half field (degrees) up to which the chief ray passes, and the surface that ends the next one."""
    n, stop = lens.indices(), lens.stop_index
    up = np.stack([0.0 * ANGLES, np.sin(ANGLES), -np.cos(ANGLES)], axis=1)
    passed, ended = np.ones(len(ANGLES), bool), np.full(len(ANGLES), -1)
    outside = ANGLES
    if stop > 0:                                        # from the stop to the scene
        front = Lens(lens.surfaces[:stop], 0, front_index=lens.front_index)
        rays = trace(front, [0.0, 0.0, lens.vertices[stop]], up, forward=False)
        passed &= rays.fate == Fate.PASSED
        ended = np.where(rays.fate == Fate.MISSED, np.maximum(rays.surface - 1, 0), rays.surface)
        outside = np.arctan2(np.abs(rays.directions[:, 1]), -rays.directions[:, 2])
    rear = Lens(lens.surfaces[stop:], 0, front_index=n[stop])
    rays = trace(rear, [0.0, 0.0, 0.0], -up, forward=True)
    ended = np.where(passed, stop + rays.surface + (rays.fate == Fate.MISSED), ended)
    passed &= rays.fate == Fate.PASSED
    failed = np.flatnonzero(~passed)
    if not failed.size:
        return degrees(float(outside.max())), None
    first = int(failed[0])
    return (degrees(float(outside[:first].max())) if first else 0.0), int(ended[first])
