"""Focal length, back focus and f-number: computed from the surfaces, against the stated values."""

from math import isfinite, isinf

from lensbench.kernels.figures import significant
from lensbench.lenses.checks.axial_beam import axial_beam
from lensbench.optics.finding import Finding, Kind, Severity
from lensbench.optics.paraxial import FirstOrder, first_order
from lensbench.optics.prescription import Lens

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
    places = len(text.partition(".")[2])
    if abs(stated) < 10.0:
        places = max(places, 1)                         # 5 for 5.0: a number does not keep its last zero
    return round(computed, places) == stated
