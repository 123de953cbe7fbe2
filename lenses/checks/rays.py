"""Real rays of the axial beam, at full aperture: they must pass, and meet as well as in lenses of the same kind."""

from lensbench.kernels.figures import fixed, significant
from lensbench.lenses.checks.axial_beam import ON_THE_FILM, AxialBeam, allowed_blur, axial_beam
from lensbench.optics.finding import Finding, Kind
from lensbench.optics.paraxial import first_order
from lensbench.optics.prescription import Lens
from lensbench.optics.scalar_trace import Fate

WORDS = {
    Fate.MISSED: "misses surface {0}", Fate.CLIPPED: "falls outside the rim of surface {0}",
    Fate.TOTAL_REFLECTION: "is totally reflected at surface {0}", Fate.BACKWARD: "is bent backward at surface {0}",
}
OPEN = 0.75                     # of the aperture's radius: rims of published lenses, estimated or of a zoom, leave 0.8


def ray_findings(lens: Lens) -> list[Finding]:
    """A ray parallel to the axis that fails within the aperture, or a beam that does not meet in a point."""
    findings: list[Finding] = []
    for section in lens.sections:
        beam = axial_beam(section)
        if beam is not None and not findings:
            findings = _findings(section, beam)
    return findings


def _findings(lens: Lens, beam: AxialBeam) -> list[Finding]:
    findings = []
    if beam.fate != Fate.PASSED:
        findings.append(_failure(Kind.RAY, beam, beam.fate, beam.failed_at, beam.failed_share))
    if beam.cut_by is not None and beam.open_share < OPEN:
        findings.append(_failure(Kind.RIM, beam, Fate.CLIPPED, beam.cut_by, beam.open_share))
    return findings or _blur(lens, beam)


def _blur(lens: Lens, beam: AxialBeam) -> list[Finding]:
    efl = abs(first_order(lens).efl)
    allowed = allowed_blur(lens, beam.f_number) * efl
    if beam.blur > allowed:
        blur, allowed, where = beam.blur, allowed, "in best focus"
    elif lens.surfaces[-1].thickness != 0.0 and beam.film_blur > ON_THE_FILM * allowed:
        blur, allowed, where = beam.film_blur, ON_THE_FILM * allowed, "on the film"
    else:
        return []
    return [Finding(Kind.BLUR, None, f"a point on the axis becomes a disk of {significant(blur, 3)} mm rms radius "
                                     f"{where}, at full aperture, f/{significant(beam.f_number, 3)}: "
                                     f"{significant(100.0 * blur / efl, 2)} % of the focal length, where lenses of "
                                     f"this speed and kind stay below {significant(100.0 * allowed / efl, 2)} %",
                    figures={"blur": blur, "allowed": allowed, "f_number": beam.f_number})]


def _failure(kind: Kind, beam: AxialBeam, fate: Fate, surface: int, share: float) -> Finding:
    height = share * beam.radius
    return Finding(
        kind, surface, f"a ray {significant(height, 4)} mm from the axis, {fixed(100.0 * share, 0)} % of the "
        f"aperture's radius, {WORDS[fate].format(surface)}", figures={"height": height, "share": share})
