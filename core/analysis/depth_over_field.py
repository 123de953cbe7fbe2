"""Depth of field of a real lens over the field: how near and how far an object is sharp at each point of the film.

Lengths in mm. Blur is the diameter 2√2 × the rms radius of the spot of all wavelengths about its centroid, as in
`real_circle_of_confusion`. It is traced at even steps of the reciprocal of the object distance, in which it falls and
rises nearly straight; between them its square is a parabola. A lens that draws softer than the limit is sharp nowhere.
"""

from dataclasses import dataclass, replace
from math import inf, isinf

import numpy as np

from lensbench.core.analysis.grids.field_conditions import Conditions, field_names
from lensbench.core.analysis.grids.traced_grid import ray_grid
from lensbench.core.analysis.spot_diagram import spots
from lensbench.core.kernels.pauses import pause
from lensbench.core.optics.finding import Finding, Kind
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.system import FieldKind
from lensbench.core.text import significant

PLACES = 9              # object distances that are traced at first
WIDTHS = 2.0            # depths of field to either side of the plane in focus, that these cover
WIDER = 2.0             # × the range of places, while a limit or the least blur of a field lies beyond
TRIALS = 4
PUPIL = 16


@dataclass(frozen=True, eq=False)
class FieldDepth:
    """Depth of field at F fields, from `field_depth`; NaN for a dark field and one that is sharp at no distance.

    Args:
        heights: (F,) distance of the fields from the film's centre, mm.
        near, far: (F,) nearest and farthest object plane → first vertex that is blurred by the limit at most, mm; far
            may be inf. NaN where it lies beyond the range that was traced.
        best, least: (F,) object distance of the least blur (inf at infinity), and that blur, mm. best: NaN where it
            lies beyond the range that was traced; least is then the least of the traced ones.
        limit: Greatest blur that counts as sharp, mm.
        distances: (D,) object distances that were traced, the nearest first, mm.
        blur: (D, F) blur of each, mm.
        findings: Fields that are sharp nowhere, those whose least blur lies beyond the traced range, and those of the
            rays.
    """

    heights: np.ndarray
    near: np.ndarray
    far: np.ndarray
    best: np.ndarray
    least: np.ndarray
    limit: float
    distances: np.ndarray
    blur: np.ndarray
    findings: tuple[Finding, ...]


def field_depth(lens: Lens, film_distance: float, conditions: Conditions, limit: float,
                pupil: int = PUPIL) -> FieldDepth:
    """Near and far limit of the depth of field at each field of a lens.

    Args:
        lens: The lens, stopped down and focused.
        film_distance: Last vertex → film, mm.
        conditions: Fields, as places of the film (REAL_IMAGE_HEIGHT), wavelengths, and the distance of the plane in
            focus.
        limit: Diameter of the blur that counts as sharp, mm.
        pupil: Points across the pupil.
    Raises:
        LensError: For a limit that is not positive, other kinds of field, and as `ray_grid` at the plane in focus.
    """
    if not 0.0 < limit < inf:
        raise LensError(f"limit {significant(limit)} mm of the blur: it must be a positive length")
    if conditions.field_kind is not FieldKind.REAL_IMAGE_HEIGHT:
        raise LensError("depth of field over the film needs fields that are positions on the film")
    rays = ray_grid(lens, film_distance, conditions, pupil)
    focus = 0.0 if isinf(conditions.object_distance) else 1.0 / conditions.object_distance
    paraxial = first_order(lens, conditions.primary_wavelength)

    # In the reciprocal of the distance the depth is limit / (aperture × focal length) to either side
    step = limit / (2.0 * abs(paraxial.entrance_pupil.radius * paraxial.efl)) * WIDTHS / (PLACES // 2)
    traced: dict[float, np.ndarray] = {}

    def blur_at(nearness: float) -> None:
        """Put the blur (F,) of an object into `traced`, by 1 / distance (1/mm); NaN where no rays can be traced."""
        if nearness not in traced:
            pause()
            away = inf if nearness == 0.0 else 1.0 / nearness
            try:
                grid = ray_grid(lens, film_distance, replace(conditions, object_distance=away), pupil)
            except LensError:                   # too near: within the lens, or no light of it reaches the film
                traced[nearness] = np.full(len(rays.images), np.nan)
                return
            size = spots(grid, "centroid").white_rms_radius[:, 0]
            traced[nearness] = np.where(grid.lit, 2.0 * np.sqrt(2.0) * size, np.nan)

    half, lit = PLACES // 2, rays.lit
    for _ in range(TRIALS):
        for k in range(-half, half + 1):
            blur_at(max(focus + k * step, 0.0))
        dioptres = np.array(sorted(traced))
        blur = np.array([traced[dioptre] for dioptre in dioptres])
        lowest = np.argmin(np.nan_to_num(blur[:, lit], nan=np.inf), axis=0)
        ends_far = dioptres[0] == 0.0 or _beyond(blur[0], limit, lit) and (lowest > 0).all()
        if ends_far and _beyond(blur[-1], limit, lit) and (lowest < len(dioptres) - 1).all():
            break
        step *= WIDER
    near, far, best, least = (np.full(len(lit), np.nan) for _ in range(4))
    for f in np.flatnonzero(lit):
        near[f], far[f], best[f], least[f] = _limits(dioptres, blur[:, f], limit)
    findings = list(rays.findings)
    outside = lit & ((best == dioptres[-1]) | (best == dioptres[0]) & (dioptres[0] > 0.0))
    if outside.any():                           # where the blur is least is not known
        best[outside] = np.nan
        findings.append(Finding(
            Kind.FIELD, None, f"at {field_names(conditions, np.flatnonzero(outside))} the blur is least nearer or "
            f"farther than the distances that were traced", figures={"fields": float(outside.sum())}))
    soft = lit & (least > limit)
    if soft.any():
        places = "at every field" if soft[lit].all() else f"at {field_names(conditions, np.flatnonzero(soft))}"
        findings.append(Finding(
            Kind.DARK, None, f"{places} the lens blurs more than the limit at every distance",
            figures={"fields": float(soft.sum())}))
    with np.errstate(divide="ignore"):
        return FieldDepth(rays.image_heights, 1.0 / near, 1.0 / far, 1.0 / best, least, limit, 1.0 / dioptres[::-1],
                          blur[::-1], tuple(findings))


def _beyond(blur: np.ndarray, limit: float, lit: np.ndarray) -> bool:
    """Whether the blur (F,) of one distance is above the limit at every field that light reaches."""
    return bool(np.all((np.nan_to_num(blur, nan=np.inf) > limit)[lit]))


def _limits(dioptres: np.ndarray, blur: np.ndarray, limit: float) -> tuple[float, float, float, float]:
    """Near and far end of the sharp range and the best place, in the reciprocal of the distance; and the least blur."""
    known = np.isfinite(blur)
    x, square = dioptres[known], blur[known] ** 2
    if x.size < 3:
        return np.nan, np.nan, np.nan, np.nan
    # The least of the parabola through the lowest three
    i = int(np.clip(np.argmin(square), 1, x.size - 2))
    a, b, c = np.polyfit(x[i - 1:i + 2] - x[i], square[i - 1:i + 2], 2)
    best = float(np.clip(x[i] - b / (2.0 * a), x[0], x[-1])) if a > 0.0 else float(x[np.argmin(square)])
    low = float(np.polyval((a, b, c), best - x[i]))
    low = min(max(low, 0.0), float(square.min()))
    if low > limit * limit:
        return np.nan, np.nan, best, low**0.5
    ends = []
    for side in (1, -1):
        order = np.flatnonzero((x - best) * side > 0.0)[::side]         # outward from the best place
        beyond = [k for k in order if square[k] > limit * limit]
        if not beyond:
            ends.append(0.0 if side < 0 and x[0] == 0.0 else np.nan)
            continue
        k = beyond[0]
        ends.append(_crossing(x, square, k, side, best, low, limit * limit))
    return ends[0], ends[1], best, low**0.5


def _crossing(x: np.ndarray, square: np.ndarray, k: int, side: int, best: float, low: float, level: float) -> float:
    """Where the squared blur reaches a level between the place before k and k: a parabola through both and the best."""
    before = k - side
    x0, y0 = (x[before], square[before]) if 0 <= before < x.size and (x[before] - best) * side > 0.0 else (best, low)
    x1, y1 = x[k], square[k]
    x2, y2 = (x[k + side], square[k + side]) if 0 <= k + side < x.size else (best, low)
    if x2 == x0:
        return float(x0 + (level - y0) / (y1 - y0) * (x1 - x0))
    a, b, c = np.polyfit(np.array([x0, x1, x2]) - x1, (y0, y1, y2), 2)
    roots = np.roots((a, b, c - level)) + x1
    inside = [float(r.real) for r in roots if abs(r.imag) < 1e-15 and min(x0, x1) - 1e-15 <= r.real <= max(x0, x1)]
    return inside[0] if inside else float(x0 + (level - y0) / (y1 - y0) * (x1 - x0))
