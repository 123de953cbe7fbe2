"""The real beam of an axis point at infinity, at full aperture: whether it passes, where it focuses and how well.

Lengths in mm. The aperture is that of the stop, or the stated one if that is smaller. Clear apertures do not end the
beam: they are often estimates, and `open_share` states where they begin to cut. The rays must pass, and meet as well as
in lenses of the same kind.
"""

from dataclasses import dataclass
from math import inf, isfinite

import numpy as np

from lensbench.core.optics.finding import Finding, Kind
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import Fate, trace
from lensbench.core.text import fixed, significant

RINGS = 16                          # of equal area: enough for the rms of a blur to a few per cent
SHARES = np.append(np.sqrt((np.arange(RINGS) + 0.5) / RINGS), 1.0)      # of the aperture's radius; the last: its rim
EDGES = np.linspace(0.02, 1.0, 50)

# Largest rms radius of the blur in best focus, in focal lengths, over the f-number. Of 310 published lenses wide open
# nine tenths stay below a fifth of it, and those at its edge are fisheyes and lenses for soft pictures.
BLUR = 0.012
SLOWEST = 3.0                       # f-number: faster lenses are allowed no more than this one
TOLERANT = ("fisheye", "soft", "meniscus", "landscape", "petzval", "hypergon", "magnifier")
TOLERANCE = 2.0                     # × that such kinds are allowed
ON_THE_FILM = 2.5                   # × on the stored film plane, which balances zones and field against each other


@dataclass(frozen=True)
class AxialBeam:
    """A traced beam; lengths in mm.

    radius: of the full aperture in the entrance pupil; f_number: of this aperture. blur, film_blur, paraxial_blur: rms
    radii in best focus, on the stored film plane and at the paraxial focus; inf if a ray fails. focus: last vertex →
    best focus. open_share: share of the radius up to which the clear apertures pass the rays, and cut_by the surface
    that cuts there. fate, failed_at, failed_share: the end of the lowest ray that no clear aperture blocks, its surface
    and its height as a share of the radius; PASSED, −1 and 1 if all pass.
    """

    radius: float
    f_number: float
    blur: float
    film_blur: float
    paraxial_blur: float
    focus: float
    open_share: float
    cut_by: int | None
    fate: Fate
    failed_at: int
    failed_share: float


def axial_beam(lens: Lens) -> AxialBeam | None:
    """The beam of a rotationally symmetric lens; None if it is afocal or has no entrance pupil. Kept by the lens."""
    if ("axial beam", 0.0) not in lens.known:
        lens.known["axial beam", 0.0] = _beam(lens)
    known: AxialBeam | None = lens.known["axial beam", 0.0]
    return known


def allowed_blur(lens: Lens, f_number: float) -> float:
    """Largest rms radius of the blur in best focus, in focal lengths, for the lens's kind at an f-number.

    inf for a single element, which nothing corrects.
    """
    if sum(surface.glass.n_d > 1.0 for surface in lens.surfaces) < 2:
        return inf
    kind = f"{lens.kind} {lens.name}".lower()
    return BLUR / max(f_number, SLOWEST) * (TOLERANCE if any(word in kind for word in TOLERANT) else 1.0)


def _beam(lens: Lens) -> AxialBeam | None:
    fo = first_order(lens)
    radius = fo.entrance_pupil.radius
    if not (isfinite(fo.efl) and isfinite(radius) and radius > 0.0):
        return None
    if lens.stated_f_number and lens.stated_f_number > 0.0:
        radius = min(radius, abs(fo.efl) / (2.0 * lens.stated_f_number))
    open_share, cut_by = _clipped(lens, radius)
    rays = trace(lens, _starts(lens, SHARES * radius), [0.0, 0.0, 1.0], clip=False, forward=True)
    failed = np.flatnonzero(rays.fate)
    blur = film_blur = paraxial_blur = focus = inf
    fate, failed_at, share = Fate.PASSED, -1, 1.0
    if failed.size:
        k = int(failed[0])
        fate, share = Fate(int(rays.fate[k])), float(SHARES[k])
        failed_at = int(rays.surface[k]) + (fate == Fate.MISSED)
    else:
        slope = (rays.directions[:, 1] / rays.directions[:, 2])[:-1]
        height = rays.points[:-1, 1] + (lens.length - rays.points[:-1, 2]) * slope
        focus = -float(height @ slope) / float(slope @ slope)
        blur, film_blur, paraxial_blur = (float(np.sqrt(np.mean((height + z * slope)**2)))
                                          for z in (focus, lens.surfaces[-1].thickness, fo.bfl))
    return AxialBeam(radius, abs(fo.efl) / (2.0 * radius), blur, film_blur, paraxial_blur, focus, open_share, cut_by,
                     fate, failed_at, share)


def _clipped(lens: Lens, radius: float) -> tuple[float, int | None]:
    """Share of the radius up to which the rims let the rays pass, and the surface whose rim ends the next one."""
    rays = trace(lens, _starts(lens, EDGES * radius), [0.0, 0.0, 1.0], forward=True)
    cut = np.flatnonzero(rays.fate == Fate.CLIPPED)
    if not cut.size:
        return 1.0, None
    first = int(cut[0])
    return float(EDGES[first - 1]) if first else 0.0, int(rays.surface[first])


def _starts(lens: Lens, heights: np.ndarray) -> np.ndarray:
    """Points before the lens at heights over the axis, (n, 3)."""
    before = -lens.surfaces[0].semi_diameter - float(heights[-1])
    return np.stack([0.0 * heights, heights, np.full_like(heights, before)], axis=1)


WORDS = {
    Fate.MISSED: "misses surface {0}", Fate.CLIPPED: "is vignetted by surface {0}",
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
