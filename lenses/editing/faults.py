"""What is wrong with an edited lens, surface by surface: crossing glass, no image, lost rays, unsolved solves."""

from dataclasses import replace
from math import isfinite

import numpy as np

from lensbench.core.optics.finding import Finding, Kind, Severity
from lensbench.core.optics.glass import GlassError
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant
from lensbench.lenses.checks.axial_beam import ray_findings
from lensbench.lenses.checks.geometry import geometry_findings
from lensbench.lenses.editing.document import LensDocument
from lensbench.lenses.tables.paraxial import FAR, at_reference, image_distance


@np.errstate(all="ignore")          # an infinite or undefined figure fails every comparison
def faults(document: LensDocument) -> tuple[Finding, ...]:
    """Why a lens cannot be built, or forms no image; empty for a sound one.

    Solves without a solution, clear apertures beyond their surface, elements and neighbours that cross
    (Kind.HEMISPHERE, EDGE, CROSSING, THICKNESS), no real image (NO_IMAGE), and the lowest ray of the axial beam that
    fails (RAY). All but NO_IMAGE name a surface, from 0.
    """
    lens = document.lens
    findings = [f for f in document.findings if f.kind is Kind.UNSOLVED]
    findings += [f for f in geometry_findings(lens) if f.severity is Severity.WARNING]
    traced, _ = at_reference(lens.with_open_stop)
    try:
        traced.indices()
    except GlassError as error:
        return *findings, Finding(Kind.GLASS, None, str(error))
    distance = traced.system.object_distances[0]
    findings += _image(traced, distance if abs(distance) < FAR else np.inf)
    if abs(distance) >= FAR:
        open_wide = replace(traced, stated_f_number=None)         # the figure belongs to the lens before the edits
        findings += [f for f in ray_findings(open_wide) if f.kind is Kind.RAY]
    return tuple(findings)


def _image(lens: Lens, distance: float) -> list[Finding]:
    """The finding about a lens that throws no real image behind its last surface."""
    for section in lens.sections:
        try:
            image = image_distance(section.surfaces, distance, front_index=section.front_index)
        except ArithmeticError:
            image = np.inf
        if not isfinite(image) or abs(image) >= FAR:
            return [Finding(Kind.NO_IMAGE, None, "the lens is afocal: it forms no image")]
        if image <= 0.0:
            return [Finding(Kind.NO_IMAGE, None, "its image is virtual: it lies "
                                                 f"{significant(-image, 4)} mm before the last surface",
                            figures={"image": image})]
    return []
