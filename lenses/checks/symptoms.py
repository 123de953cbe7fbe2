"""Symptoms: findings about a lens as a whole. Where there are any, other checks look for a surface that causes them."""

from lensbench.lenses.checks.field import field_findings
from lensbench.lenses.checks.figures import figure_findings
from lensbench.lenses.checks.rays import ray_findings
from lensbench.lenses.checks.stop import stop_findings
from lensbench.optics.finding import Finding
from lensbench.optics.prescription import Lens


def symptom_findings(lens: Lens) -> list[Finding]:
    """Findings about the figures, the axial beam, the stop and the field."""
    return [*figure_findings(lens), *ray_findings(lens), *stop_findings(lens), *field_findings(lens)]
