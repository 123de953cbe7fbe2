"""The ray grid: every ray of an analysis, traced once for fields × wavelengths × points of the exit pupil.

Lengths in mm, lens frame; light runs from the scene to the film. Each field has a *reference point*: where the chief
ray of the primary wavelength meets the film. Places on the film are given from there along two axes: *tangential*, away
from the film's centre, and *sagittal*, across it (of a field above the centre: +y and +x).

The pupil coordinates of a ray are the direction cosines from its point on the reference sphere to the reference point,
sagittal and tangential. The reference sphere is centred on the reference point and passes the exit pupil on the chief
ray; it is a plane for an exit pupil at infinity. In these coordinates a diffraction pattern is a plain Fourier
transform, and an area is the light that the film receives.

The optical path difference W is positive where the ray's path to the reference sphere is shorter than the chief ray's,
as Welford has it. A ray lands at ∂W / ∂p from the reference point, p its pupil coordinates.

The grid of each field covers the region that the rims leave open, found by rays from the reference point back to
the scene. These rays also say where the rays of the object must start, so that the latter, traced forward in
every wavelength, fill the exit pupil evenly.

References:
    Welford, "Aberrations of Optical Systems", ch. 7: reference sphere and wavefront aberration.

    The trace of a ray grid: chief rays, the open pupil found from the film, and the object's rays in each wavelength.

    Lengths in mm, lens frame. See `traced_grid` for the reference points, axes and pupil coordinates.

    Foci of narrow beams about the chief rays of a ray grid, for lenses of any symmetry.

    Lengths in mm. Two rays close to the chief ray on either side of it in the pupil cross it at its focus: the sagittal
    focus for rays beside it along the sagittal axis, the tangential one for the other. `field_curves` has the same for
    lenses of rotational symmetry by Coddington's equations. In other wavelengths the beam is about the same ray of the
    object, the chief ray of the primary wavelength.
"""

from dataclasses import dataclass
from functools import cached_property
from math import inf, isinf

import numpy as np

from lensbench.core.analysis.grids.chief_rays import find_chief_rays
from lensbench.core.analysis.grids.field_beams import (
    OFFSET_S, OFFSET_T, OPD, PUPIL_S, PUPIL_T, SHARE, SLOPE_S, SLOPE_T, FieldBeams
)
from lensbench.core.analysis.grids.field_conditions import Conditions, field_names, wanted_chief_rays
from lensbench.core.analysis.grids.grid_cells import Landed, of_mean_1, open_areas, towards_centroids, trace_cells
from lensbench.core.analysis.grids.open_region import open_boxes, stop_transmission
from lensbench.core.kernels.byte_cache import byte_cache
from lensbench.core.kernels.cache import njit
from lensbench.core.named_objects import accepting_names
from lensbench.core.optics.finding import Finding, Kind
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.text import significant


@dataclass(frozen=True, eq=False)
class RayGrid:
    """Rays of one lens state, from `ray_grid`. F fields, C wavelengths, N × N points of the exit pupil.

    In arrays (F, C, N, N) the last axis is sagittal and the one before it tangential. They are NaN where no ray comes
    through, and filled for rays just beyond a rim, which `coverage` excludes.

    Args:
        lens, film_distance, conditions: As given; film_distance in mm from the last vertex.
        angles: (F, 2) angle from the axis of the chief ray's light in the scene, as a vector (rad).
        images: (F, 2) reference points, x and y on the film, mm; NaN for a field without a chief ray.
        axes: (F, 2, 2) unit vectors (x, y): the sagittal and the tangential axis.
        chief: (F, C, 2) where the chief ray of each wavelength meets the film, sagittal and tangential, mm from the
            reference point.
        chief_pupil: (F, 2) pupil coordinates of the primary chief ray.
        pupil: (F, 2, N) pupil coordinates of the grid's columns (sagittal) and rows (tangential), evenly spaced.
        offset_s, offset_t: (F, C, N, N) where each ray meets the film, mm from the reference point.
        slope_s, slope_t: (F, C, N, N) change of these with the film's place, mm per mm along +z.
        pupil_s, pupil_t: (F, C, N, N) pupil coordinates of each ray; close to those of its column and row.
        opd: (F, C, N, N) optical path difference W, mm.
        weight: (F, C, N, N) light of each ray, of mean 1 over the rays of a field that carry some: the part of its cell
            of the beam that the rims leave open, times the cell's area and the transmission of a picture in the stop.
        open_centre: (2, F, C, N, N) centroid of the open part of each ray's cell, from its middle, in cells: sagittal,
            tangential.
        coverage: (F, C, N, N) the part of each cell of the exit pupil that the rims and a picture in the stop leave
            open, 0 to 1.
        intensity: (F, N, N) light of an evenly lit beam per area of the exit pupil, dimmed by the grey of a picture in
            the stop, of mean 1 over the open cells.
        victim: (F, C, N, N) index of the surface that ends the ray, −1 for a ray that passes, −2 for one that is not
            traced: it lies far outside the rims.
        stop_share: (F, C, N, N) squared distance from the axis in the stop over that of the stop's rim; NaN as the
            others.
        open_area: (F,) area of the open region that the reference point sees, in pupil coordinates: the irradiance of
            the film under a scene of radiance 1, blades and a picture in the stop included; 0 for a dark field.
        beams: How rays of these fields are given and traced; for analyses that trace more of them.
        mirrored: Whether the light of the sagittal half of each field is the mirror image of the other.
        sphere_curvatures: (F,) 1 / radius of the reference spheres, 1/mm; 0 for a plane.
        launched, lost: (F, C) rays of the grid that meet the stop within its rim, and those of them that other surfaces
            end.
        findings: Those of the conditions, and what the grid cannot show: dark fields and their reason.
    """

    lens: Lens
    film_distance: float
    conditions: Conditions
    angles: np.ndarray
    images: np.ndarray
    axes: np.ndarray
    chief: np.ndarray
    chief_pupil: np.ndarray
    pupil: np.ndarray
    offset_s: np.ndarray
    offset_t: np.ndarray
    slope_s: np.ndarray
    slope_t: np.ndarray
    pupil_s: np.ndarray
    pupil_t: np.ndarray
    opd: np.ndarray
    weight: np.ndarray
    open_centre: np.ndarray
    coverage: np.ndarray
    intensity: np.ndarray
    victim: np.ndarray
    stop_share: np.ndarray
    open_area: np.ndarray
    beams: FieldBeams
    mirrored: bool
    sphere_curvatures: np.ndarray
    launched: np.ndarray
    lost: np.ndarray
    findings: tuple[Finding, ...]

    @property
    def passed(self) -> np.ndarray:
        """(F, C, N, N) whether a ray passes all rims."""
        return self.victim == -1

    @property
    def lit(self) -> np.ndarray:
        """(F,) whether any light reaches a field in the primary wavelength."""
        return np.asarray(self.coverage[:, self.conditions.primary].any((1, 2)))

    @cached_property
    def light(self) -> np.ndarray:
        """(4, F, C, N, N) offset_s, offset_t, slope_s and slope_t, for sums over the rays with `weight`.

        In a cell at a rim they are taken halfway from the ray to the centroid of the cell's open part. A sum then
        misses the integral by a term of the fourth order in the size of a cell: of the second order, the error of the
        rims, 1/24 of the integrand's slope across them, cancels that of the midpoint rule in all other cells.
        """
        arrays = (self.offset_s, self.offset_t, self.slope_s, self.slope_t)
        made = np.empty((4, *self.opd.shape))
        shape = (-1, *self.opd.shape[2:])
        for array, out in zip(arrays, made, strict=True):
            towards_centroids(array.reshape(shape), self.weight.reshape(shape), self.open_centre.reshape(2, *shape),
                              out.reshape(shape))
        return made

    @property
    def steps(self) -> np.ndarray:
        """(F, 2) spacing of the grid in pupil coordinates, sagittal and tangential; NaN for a dark field."""
        return self.pupil[:, :, 1] - self.pupil[:, :, 0]

    @property
    def image_heights(self) -> np.ndarray:
        """(F,) distance of the reference points from the film's centre, mm."""
        return np.hypot(self.images[:, 0], self.images[:, 1])

    @property
    def field_angles(self) -> np.ndarray:
        """(F,) angle of the fields from the axis in the scene, rad."""
        return np.hypot(self.angles[:, 0], self.angles[:, 1])

    @cached_property
    def grid_opd(self) -> np.ndarray:
        """(F, C, N, N) W at the exact points of the grid, mm.

        A ray's own pupil coordinates differ a little from its cell's; its offset is the slope of W between them.
        """
        return (self.opd + self.offset_s * (self.pupil[:, 0][:, None, None, :] - self.pupil_s)
                + self.offset_t * (self.pupil[:, 1][:, None, :, None] - self.pupil_t))


MOST_KEPT = 48 << 20    # bytes of rays: sixteen grids of a moving picture; the newest stays, of 128 points too
PUPIL = 32              # grid points across the pupil of a field: about 800 rays
RIM = 6.4               # over the points across: share of the squares of a sum that rays outside a rim may have


@byte_cache(MOST_KEPT, 16)
@accepting_names
def ray_grid(lens: Lens, film_distance: float, conditions: Conditions, pupil: int = PUPIL) -> RayGrid:
    """The rays of an analysis; kept for the last lens states, at most sixteen.

    Args:
        lens: The lens, stopped down and focused.
        film_distance: Last vertex → film, mm.
        conditions: Fields, wavelengths and object distance.
        pupil: Points of the grid across the pupil of each field, at least 8. 32 suits spots and a picture that moves;
            64 and 128 suit fine diffraction figures.
    Raises:
        LensError: For a film that is not behind the lens or not in air, for an afocal lens, for fewer than 8 points,
            and where no light of any field reaches the film.
    """
    if pupil < 8:
        raise LensError(f"{pupil} points across the pupil: at least 8 are needed")
    check_traceable(lens, film_distance, conditions)
    image, lens = lens.stop_image, lens.with_open_stop

    # Find the chief rays and, from the film, the open regions of the exit pupil
    line, distance = conditions.primary_wavelength, conditions.object_distance
    aims, by_image = wanted_chief_rays(lens, conditions)
    chief = find_chief_rays(lens, film_distance, aims, distance, by_image, line)
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
        image_light = stop_transmission(beams, cells.grid, image)
        open_area *= _mean(image_light.light, cells.open_)
        weight *= image_light.light[:, None]
        coverage *= image_light.open_part[:, None]
        intensity *= image_light.dimming[:, None]
        victim[(victim == -1) & (image_light.light[:, None] == 0.0)] = lens.stop_index
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
        reasons = [str(finding) for finding in findings if finding.kind is Kind.DARK]
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
    findings = []
    if incomplete.any():
        fields = np.flatnonzero(incomplete)
        findings.append(Finding(Kind.SAMPLING, None, "strong aberrations: the rays of the grid miss a part of the "
                                f"light of {field_names(conditions, fields)}", figures={"fields": float(fields.size)}))
    if uneven.any():
        fields = np.flatnonzero(uneven)
        findings.append(Finding(Kind.SAMPLING, None, "rays at the edge of the pupil land far from the others: spots "
                                f"and contrast of {field_names(conditions, fields)} need more points across the pupil",
                                figures={"uneven": float(fields.size)}))
    if steep.any():
        fields = np.flatnonzero(steep)
        findings.append(Finding(Kind.SAMPLING, None, "the wavefront bends steeply at the edge of the pupil: its rms, "
                                f"its Strehl ratio and the PSF of {field_names(conditions, fields)} need more points "
                                "across the pupil", figures={"steep": float(fields.size)}))
    if (dark & beyond).any():
        fields = np.flatnonzero(dark & beyond)
        findings.append(Finding(Kind.DARK, None, f"{field_names(conditions, fields)} look beyond 90°, where a plane "
                                "object has no point: these fields are dark. An object at infinity lights them",
                                figures={"fields": float(fields.size)}))
    if (dark & ~beyond).any():
        fields = np.flatnonzero(dark & ~beyond)
        findings.append(Finding(Kind.DARK, None, "rims end all rays of the object points whose chief rays meet "
                                f"{field_names(conditions, fields)}: these fields are dark",
                                figures={"fields": float(fields.size)}))
    return findings


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
                    share = coverage[f, primary, i, j]
                    w = (rows[OPD, f, primary, i, j]
                         + rows[OFFSET_S, f, primary, i, j] * (grid[f, 0, j] - rows[PUPIL_S, f, primary, i, j])
                         + rows[OFFSET_T, f, primary, i, j] * (grid[f, 1, i] - rows[PUPIL_T, f, primary, i, j]))
                    if not (share > 0.0 and abs(w) < inf):
                        continue
                    if again == 0:
                        total += share
                        mean += share * w
                    else:
                        square_share = share * (w - mean) ** 2
                        square += square_share
                        if victim[f, primary, i, j] >= 0:
                            beyond += square_share
            mean = mean / total if again == 0 and total > 0.0 else mean
        out[f] = beyond / square if square > 0.0 else 0.0


STEP = 1e-4             # of the pupil coordinates, to either side of the chief ray


def close_foci(rays: RayGrid) -> np.ndarray:
    """Sagittal and tangential foci of each field and wavelength.

    Args:
        rays: From `ray_grid`.
    Returns:
        (F, C, 2) focus behind the film, mm along +z, sagittal and tangential; NaN for a field without a chief ray.
    """
    beams, count = rays.beams, len(rays.images)
    s = beams.chief_pupil[:, :1] + STEP * np.array([1.0, -1.0, 0.0, 0.0])
    t = beams.chief_pupil[:, 1:] + STEP * np.array([0.0, 0.0, 1.0, -1.0])
    places = beams.towards_scene(s, t)[0].reshape(-1, 2)
    of_field = np.repeat(np.arange(count), 4)
    known = np.isfinite(places).all(1)
    starts = beams.starts(of_field, places)
    foci = np.full((count, len(rays.conditions.wavelengths), 2), np.nan)
    for c, line in enumerate(rays.conditions.wavelengths):
        landed, _ = beams.forward(line, of_field, starts)
        for a, (offset, slope) in enumerate(((OFFSET_S, SLOPE_S), (OFFSET_T, SLOPE_T))):
            apart, turned = (np.where(known, landed[row], np.nan).reshape(-1, 4)[:, 2 * a:2 * a + 2] @ [1.0, -1.0]
                             for row in (offset, slope))
            with np.errstate(divide="ignore", invalid="ignore"):
                foci[:, c, a] = -apart / turned
    return foci
