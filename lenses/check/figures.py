"""Focal length, back focus and f-number: computed from the surfaces, against the stated values."""

from math import isinf

from lensbench.kernels.figures import significant
from lensbench.optics.finding import Finding, Kind
from lensbench.optics.paraxial import FirstOrder, first_order
from lensbench.optics.prescription import Lens

FOCAL_LENGTH = 0.02     # of the stated one: published focal lengths are nominal, and round to two digits
BACK_FOCUS = 0.01       # of the focal length: published back foci are those of best focus, or of a rounded table
BLUR = 0.005            # of the focal length: the disk on the axis, at full aperture, that a wrong back focus leaves
FOCI = 0.01             # of the focal length: between the two sections of an anamorphic lens
F_NUMBER = 0.25         # of the stated one: estimated rims, and stops that are larger than the marking
FASTEST = 0.5           # f-number: a cone of 180° in air


def figure_findings(lens: Lens) -> list[Finding]:
    """Findings where first-order figures contradict the stated ones, or each other."""
    sections = [first_order(lens)]
    if not lens.is_rotationally_symmetric:
        sections.append(first_order(lens.section("x")))
    if all(isinf(section.efl) for section in sections):
        return [Finding(Kind.FOCAL_LENGTH, None, "the lens is afocal: it forms no image of its own")]
    findings = []
    if len(sections) == 2 and not abs(sections[0].bfl - sections[1].bfl) <= FOCI * abs(sections[0].efl):
        findings.append(Finding(Kind.FOCI, None, "the two sections do not focus in one plane: y–z "
                                              f"{significant(sections[0].bfl, 5)} mm behind the last surface, x–z "
                                              f"{significant(sections[1].bfl, 5)} mm"))
    return [*findings, *_back_focus(lens, sections[0]), *_focal_length(lens, sections), *_f_number(lens, sections[0])]


def _back_focus(lens: Lens, section: FirstOrder) -> list[Finding]:
    stored, bfl, efl = lens.surfaces[-1].thickness, section.bfl, abs(section.efl)
    inside = ", inside the lens" if bfl < 0.0 else ""
    if isinf(bfl) or (stored == 0.0 and not inside):                # not stored
        return []
    off = bfl - stored
    blur = abs(off) / section.f_number if section.f_number else 0.0
    if stored != 0.0 and abs(off) <= BACK_FOCUS * efl and blur <= BLUR * efl:
        return []
    message = f"the paraxial focus lies {significant(bfl, 5)} mm behind the last surface{inside}"
    if stored != 0.0:
        message += (f", the stored back focus is {significant(stored, 5)} mm: a point on the axis becomes a disk of "
                    f"{significant(blur, 2)} mm, "
                    f"{significant(blur / efl, 2)} focal lengths")
    return [Finding(Kind.BACK_FOCUS, len(lens.surfaces) - 1, message)]


def _focal_length(lens: Lens, sections: list[FirstOrder]) -> list[Finding]:
    lengths = [section.efl for section in sections]
    words = " and ".join(significant(efl, 5) for efl in lengths) + " mm"
    words += " (y–z and x–z)" if len(lengths) == 2 else ""
    if lens.stated_efl is None or not lens.stated_efl:
        return [] if max(lengths) > 0.0 else [
            Finding(Kind.FOCAL_LENGTH, None, f"the focal length is {words}: the lens diverges")]
    errors = [abs(efl / lens.stated_efl - 1.0) for efl in lengths]
    if min(errors) <= FOCAL_LENGTH:
        return []
    message = (f"the focal length is {words}, {significant(100.0 * min(errors), 3)} % from the stated "
               f"{significant(lens.stated_efl)} mm")
    if len(sections) == 1 and lens.surfaces[-1].thickness != 0.0 and not _back_focus(lens, sections[0]):
        message += "; yet the back focus is right, so that the stated length may be of another lens or scale"
    return [Finding(Kind.FOCAL_LENGTH, None, message)]


def _f_number(lens: Lens, section: FirstOrder) -> list[Finding]:
    stated = lens.stated_f_number
    if section.f_number < FASTEST:
        return [Finding(Kind.F_NUMBER, lens.stop_index,
                        f"the stop opens the lens to f/{significant(section.f_number, 3)}: "
                        f"no lens in air is faster than f/{significant(FASTEST)}")]
    if stated is None or stated <= 0.0 or abs(section.f_number / stated - 1.0) <= F_NUMBER:
        return []
    return [Finding(Kind.F_NUMBER, lens.stop_index,
                    f"the stop opens the lens to f/{significant(section.f_number, 3)}, where "
                    f"f/{significant(stated)} is stated")]
