"""The stated field: the rims must let the chief ray pass from most of it."""

from math import degrees

import numpy as np

from lensbench.kernels.figures import significant
from lensbench.optics.finding import Finding, Kind
from lensbench.optics.prescription import Lens
from lensbench.optics.scalar_trace import Fate, trace
from lensbench.optics.system import FieldKind

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
