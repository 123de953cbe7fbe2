"""The trace of a ray grid: chief rays, the open pupil found from the film, and the object's rays in each wavelength.

Lengths in mm, lens frame. See `traced_grid` for the reference points, axes and pupil coordinates.
"""

from math import inf, isinf

import numpy as np

from lensbench.analysis.grids.cell_coverage import of_mean_1, open_areas, towards_centroids
from lensbench.analysis.grids.chief_rays import find_chief_rays
from lensbench.analysis.grids.field_beams import (
    OFFSET_S,
    OFFSET_T,
    OPD,
    PUPIL_S,
    PUPIL_T,
    SHARE,
    SLOPE_S,
    SLOPE_T,
    FieldBeams,
)
from lensbench.analysis.grids.field_conditions import Conditions, field_names, wanted_chief_rays
from lensbench.analysis.grids.grid_cells import Landed, trace_cells
from lensbench.analysis.grids.open_region import open_boxes
from lensbench.analysis.grids.stop_transmission import stop_transmission
from lensbench.analysis.grids.traced_grid import RayGrid
from lensbench.kernels.byte_cache import byte_cache
from lensbench.kernels.cache import njit
from lensbench.kernels.figures import significant
from lensbench.kernels.named_objects import refusing_names
from lensbench.optics.finding import Finding, Kind
from lensbench.optics.lens_surface import LensError
from lensbench.optics.paraxial import first_order
from lensbench.optics.prescription import Lens

MOST_KEPT = 48 << 20    # bytes of rays: sixteen grids of a moving picture; the newest stays, of 128 points too
PUPIL = 32              # grid points across the pupil of a field: about 800 rays
RIM = 6.4               # over the points across: share of the squares of a sum that rays outside a rim may have


@byte_cache(MOST_KEPT, 16)
@refusing_names
def ray_grid(lens: Lens, film_distance: float, conditions: Conditions, pupil: int = PUPIL) -> RayGrid:
    """The rays of an analysis; kept for the last lens states, at most sixteen.

    Parameters
    ----------
    lens : Lens
        The lens, stopped down and focused.
    film_distance : float
        Last vertex → film, mm.
    conditions : Conditions
        Fields, wavelengths and object distance.
    pupil : int
        Points of the grid across the pupil of each field, at least 8. 32 suits spots and a picture that moves; 64
        and 128 suit fine diffraction figures.

    Returns
    -------
    RayGrid

    Raises
    ------
    LensError
        For a film that is not behind the lens or not in air, for an afocal lens, for fewer than 8 points, and where
        no light of any field reaches the film.
    """
    if pupil < 8:
        raise LensError(f"{pupil} points across the pupil: at least 8 are needed")
    check_traceable(lens, film_distance, conditions)
    image, lens = lens.stop_image, lens.with_open_stop

    # Find the chief rays and, from the film, the open regions of the exit pupil
    line, distance = conditions.primary_wavelength, conditions.object_distance
    wanted, by_image = wanted_chief_rays(lens, conditions)
    chief = find_chief_rays(lens, film_distance, wanted, distance, by_image, line)
    beams = FieldBeams.of(lens, film_distance, chief, distance, line)
    boxes, findings = open_boxes(beams, conditions)

    # Trace the object's rays through the cells of these regions
    cells, landed, incomplete = trace_cells(beams, boxes, pupil, conditions)
    rows, victim, coverage = landed.rows, landed.victim, landed.coverage

    # Weigh them by the light of their cells
    weight = np.empty_like(landed.weight)
    of_mean_1(cells.beam, landed.weight, 0, True, weight)
    coverage[~weight.any((2, 3))] = 0.0                 # the rims end all rays that the object point sends
    intensity = np.empty((len(boxes), 1, pupil, pupil))
    of_mean_1(cells.beam, coverage, conditions.primary, False, intensity)
    open_area = open_areas(cells.open_, cells.grid)
    within = rows[SHARE] <= 1.0
    lost = (within & (victim >= 0)).sum((2, 3))
    uneven, steep = _rim_shares(landed, weight, conditions.primary) > RIM / pupil, np.empty(len(boxes))
    _steep_shares(rows, cells.grid, coverage, victim, conditions.primary, steep)
    if image is not None:
        seen = stop_transmission(beams, cells.grid, image)
        open_area *= _mean(seen.light, cells.open_)
        weight *= seen.light[:, None]
        coverage *= seen.open_part[:, None]
        intensity *= seen.dimming[:, None]
        victim[(victim == -1) & (seen.light[:, None] == 0.0)] = lens.stop_index
        weight /= _mean(weight, weight > 0.0)[..., None, None]
        intensity /= _mean(intensity, coverage[:, conditions.primary, None] > 0.0)[..., None, None]

    beyond = beams.beyond_the_plane
    dark = (np.isfinite(cells.grid).all((1, 2)) | beyond) & ~coverage[:, conditions.primary].any((1, 2))
    findings += _findings(conditions, incomplete, uneven, steep > RIM / pupil, dark, beyond)
    made = RayGrid(
        lens, film_distance, conditions, chief.angles, chief.images, beams.axes, landed.chief, beams.chief_pupil,
        cells.grid, offset_s=rows[OFFSET_S], offset_t=rows[OFFSET_T], slope_s=rows[SLOPE_S], slope_t=rows[SLOPE_T],
        pupil_s=rows[PUPIL_S], pupil_t=rows[PUPIL_T], opd=rows[OPD], weight=weight, open_centre=landed.open_centre,
        coverage=coverage, intensity=intensity[:, 0], victim=victim, stop_share=rows[SHARE],
        open_area=open_area, beams=beams, mirrored=beams.mirrored and image is None,
        sphere_curvatures=beams.sphere_curvatures,
        launched=within.sum((2, 3)), lost=lost,
        findings=(*conditions.findings, *findings))
    if not made.lit.any():
        reasons = [str(each) for each in findings if each.kind is Kind.DARK]
        raise LensError("; ".join(reasons) or "no light of these fields reaches the film")
    return made


def _mean(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Weighted means (…) of values (…, N, N); 1 where all weights are 0."""
    total = weights.sum((-2, -1), dtype=float)
    return np.divide((values * weights).sum((-2, -1)), total, out=np.ones_like(total), where=total > 0.0)


def check_traceable(lens: Lens, film_distance: float, conditions: Conditions) -> None:
    """LensError for what has no rays to trace."""
    if not 0.0 < film_distance < inf:
        raise LensError(f"film distance {significant(film_distance)} mm: the film must lie behind the last vertex")
    if lens.indices()[-1] != 1.0:
        raise LensError("this lens ends in glass: its film must be in air")
    if isinf(first_order(lens, conditions.primary_wavelength).efl) and isinf(conditions.object_distance):
        raise LensError("an afocal lens forms no image of a far object: give the object a finite distance, or add a "
                        "lens that focuses")


def _findings(conditions: Conditions, incomplete: np.ndarray, uneven: np.ndarray, steep: np.ndarray, dark: np.ndarray,
              beyond: np.ndarray) -> list[Finding]:
    """What the rays of a grid do not show, by fields (F,): missed light, too few rays at the rims, no light.

    uneven: for spots; steep: for the wavefront.

    beyond: fields from beyond 90°, which a plane object does not light.
    """
    found = []
    if incomplete.any():
        fields = np.flatnonzero(incomplete)
        found.append(Finding(Kind.SAMPLING, None, "strong aberrations: the rays of the grid miss a part of the light "
                             f"of {field_names(conditions, fields)}", figures={"fields": float(fields.size)}))
    if uneven.any():
        fields = np.flatnonzero(uneven)
        found.append(Finding(Kind.SAMPLING, None, "rays at the rims land far from the others: spots and contrast of "
                             f"{field_names(conditions, fields)} need more points across the pupil",
                             figures={"uneven": float(fields.size)}))
    if steep.any():
        fields = np.flatnonzero(steep)
        found.append(Finding(Kind.SAMPLING, None, "the wavefront bends steeply at the rims: its rms, its Strehl ratio "
                             f"and the PSF of {field_names(conditions, fields)} need more points across the pupil",
                             figures={"steep": float(fields.size)}))
    if (dark & beyond).any():
        fields = np.flatnonzero(dark & beyond)
        found.append(Finding(Kind.DARK, None, f"{field_names(conditions, fields)} look beyond 90°, where a plane "
                             "object has no point: these fields are dark. An object at infinity lights them",
                             figures={"fields": float(fields.size)}))
    if (dark & ~beyond).any():
        fields = np.flatnonzero(dark & ~beyond)
        found.append(Finding(Kind.DARK, None, "rims end all rays of the object points whose chief rays meet "
                             f"{field_names(conditions, fields)}: these fields are dark",
                             figures={"fields": float(fields.size)}))
    return found


def _rim_shares(landed: Landed, weight: np.ndarray, primary: int) -> np.ndarray:
    """(F,) share of the squared spot radius that cells hold whose rays lie outside a rim; NaN where no light is.

    The values of such a cell are those of light within the rim only as far as they change evenly there.
    """
    light, ended = weight[:, primary], landed.victim[:, primary] >= 0
    offsets = np.empty((2, *light.shape))
    for row, out in zip((OFFSET_S, OFFSET_T), offsets, strict=True):
        towards_centroids(landed.rows[row, :, primary], light, landed.open_centre[:, :, primary], out)
    with np.errstate(divide="ignore", invalid="ignore"):
        middle = (light * offsets).sum((2, 3)) / light.sum((1, 2))
        square = light * ((offsets - middle[:, :, None, None])**2).sum(0)
        return np.asarray((square * ended).sum((1, 2)) / square.sum((1, 2)))


@njit(cache=True, nogil=True, error_model="numpy")
def _steep_shares(rows, grid, coverage, victim, primary, out):
    """Into out (F,): the share of the variance of W that such cells hold, on the grid (F, 2, N); 0 where no light is.

    rows (9, F, C, N, N), coverage and victim (F, C, N, N) of Landed.
    """
    fields, _, n, _ = coverage.shape
    for f in range(fields):
        total, mean, square, beyond = 0.0, 0.0, 0.0, 0.0
        for again in range(2):
            for i in range(n):
                for j in range(n):
                    part = coverage[f, primary, i, j]
                    w = (rows[OPD, f, primary, i, j]
                         + rows[OFFSET_S, f, primary, i, j] * (grid[f, 0, j] - rows[PUPIL_S, f, primary, i, j])
                         + rows[OFFSET_T, f, primary, i, j] * (grid[f, 1, i] - rows[PUPIL_T, f, primary, i, j]))
                    if not (part > 0.0 and abs(w) < inf):
                        continue
                    if again == 0:
                        total += part
                        mean += part * w
                    else:
                        here = part * (w - mean) ** 2
                        square += here
                        if victim[f, primary, i, j] >= 0:
                            beyond += here
            mean = mean / total if again == 0 and total > 0.0 else mean
        out[f] = beyond / square if square > 0.0 else 0.0
