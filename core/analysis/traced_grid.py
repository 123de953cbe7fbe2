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

References
----------
Welford, "Aberrations of Optical Systems", ch. 7: reference sphere and wavefront aberration.
"""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import inf, isinf, nan

import numpy as np

from lensbench.analysis.chief_rays import find_chief_rays
from lensbench.analysis.field_beams import (
    LANDED,
    LEVEL,
    OFFSET_S,
    OFFSET_T,
    OPD,
    PUPIL_S,
    PUPIL_T,
    SHARE,
    SLOPE_S,
    SLOPE_T,
    FieldBeams,
    cell_slope,
    field_name,
)
from lensbench.analysis.field_conditions import Conditions, wanted_chief_rays
from lensbench.kernels.cache import njit
from lensbench.kernels.figures import significant
from lensbench.optics.finding import Finding, Kind
from lensbench.optics.paraxial import first_order
from lensbench.optics.prescription import Lens, LensError

PUPIL = 32              # grid points across the pupil of a field: about 800 rays
BEYOND = 4.0            # cells beyond the rims, of which rays are traced too: half of them
THREADS = 2


@dataclass(frozen=True, eq=False)
class RayGrid:
    """Rays of one lens state, from `ray_grid`. F fields, C wavelengths, N × N points of the exit pupil.

    In arrays (F, C, N, N) the last axis is sagittal and the one before it tangential. They are NaN where no ray comes
    through, and filled for rays just beyond a rim, which `coverage` excludes.

    Parameters
    ----------
    lens, film_distance, conditions
        As given; film_distance in mm from the last vertex.
    angles
        (F, 2) angle from the axis of the chief ray's light in the scene, as a vector (rad).
    images
        (F, 2) reference points, x and y on the film, mm; NaN for a field without a chief ray.
    axes
        (F, 2, 2) unit vectors (x, y): the sagittal and the tangential axis.
    chief
        (F, C, 2) where the chief ray of each wavelength meets the film, sagittal and tangential, mm from the reference
        point.
    chief_pupil
        (F, 2) pupil coordinates of the primary chief ray.
    pupil
        (F, 2, N) pupil coordinates of the grid's columns (sagittal) and rows (tangential), evenly spaced.
    offset_s, offset_t
        (F, C, N, N) where each ray meets the film, mm from the reference point.
    slope_s, slope_t
        (F, C, N, N) change of these with the film's place, mm per mm along +z.
    pupil_s, pupil_t
        (F, C, N, N) pupil coordinates of each ray; close to those of its column and row.
    opd
        (F, C, N, N) optical path difference W, mm.
    weight
        (F, C, N, N) light of each ray, of mean 1 over the rays of a field that carry some: the part of its cell of the
        beam that the rims leave open, times the cell's area.
    open_centre
        (2, F, C, N, N) centroid of the open part of each ray's cell, from its middle, in cells: sagittal, tangential.
    coverage
        (F, C, N, N) the part of each cell of the exit pupil that the rims leave open, 0 to 1.
    intensity
        (F, N, N) light of an evenly lit beam per area of the exit pupil, of mean 1 over the open cells.
    victim
        (F, C, N, N) index of the surface that ends the ray, −1 for a ray that passes, −2 for one that is not traced:
        it lies far outside the rims.
    stop_share
        (F, C, N, N) squared distance from the axis in the stop over that of the stop's rim; NaN as the others.
    open_area
        (F,) area of the open region that the reference point sees, in pupil coordinates: the irradiance of the film
        under a scene of radiance 1, blades included; 0 for a dark field.
    beams
        How rays of these fields are given and traced; for analyses that trace more of them.
    sphere_curvatures
        (F,) 1 / radius of the reference spheres, 1/mm; 0 for a plane.
    launched, lost
        (F, C) rays of the grid that meet the stop within its rim, and those of them that other surfaces end.
    findings
        Those of the conditions, and what the grid cannot show: dark fields and their reason.
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
            _towards_centroids(array.reshape(shape), self.weight.reshape(shape), self.open_centre.reshape(2, *shape),
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


@lru_cache(maxsize=16)
def ray_grid(lens: Lens, film_distance: float, conditions: Conditions, pupil: int = PUPIL) -> RayGrid:
    """The rays of an analysis; kept for the last sixteen lens states.

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
    if not 0.0 < film_distance < inf:
        raise LensError(f"film distance {significant(film_distance)} mm: the film must lie behind the last vertex")
    if pupil < 8:
        raise LensError(f"{pupil} points across the pupil: at least 8 are needed")
    if lens.indices()[-1] != 1.0:
        raise LensError("this lens ends in glass: its film must be in air")
    line = conditions.primary_wavelength
    if isinf(first_order(lens, line).efl) and isinf(conditions.object_distance):
        raise LensError("an afocal lens forms no image of a far object: give the object a finite distance, or add a "
                        "lens that focuses")

    # The chief rays, and from them the axes of each field
    wanted, by_image = wanted_chief_rays(lens, conditions)
    distance = conditions.object_distance
    chief = find_chief_rays(lens, film_distance, wanted, distance, by_image, line)
    beams = FieldBeams.of(lens, film_distance, chief, distance, line)

    # The open region of the exit pupil, and where its rays leave for the scene
    boxes, findings = beams.open_boxes(conditions)
    share = (np.arange(pupil) + 0.5) / pupil
    grid = boxes[..., :1] + share * (boxes[..., 1:] - boxes[..., :1])
    s, t = (np.ascontiguousarray(np.broadcast_to(each, (len(grid), pupil, pupil)))
            for each in (grid[:, 0, None, :], grid[:, 1, :, None]))
    places, level = beams.towards_scene(s, t)
    open_cells = np.zeros(level.shape)
    unused = np.empty((2, *level.shape))
    _cover(level, s, t, grid, open_cells, unused)
    near = (level <= 1.0 + BEYOND / pupil) | (beams.linear_stop_share(s, t) <= 1.0)
    keep = np.flatnonzero((near & np.isfinite(places).all(-1)).ravel())
    of_field = keep // pupil**2
    begun = beams.starts(of_field, places.reshape(-1, 2)[keep])

    # The rays of the object, forward in each wavelength
    count, colours = len(grid), conditions.wavelengths
    values = np.full((len(colours), LANDED, count, pupil, pupil), nan)
    victim, coverage = np.full(values.shape[:1] + values.shape[2:], -2, np.int16), np.zeros_like(values[:, 0])
    weight, centre = np.zeros_like(coverage), np.zeros((2, *coverage.shape))
    chiefs = np.zeros((len(colours), count, 2))

    def trace_colour(c: int) -> None:
        """Fill the arrays of one wavelength."""
        chiefs[c] = beams.on_axes(beams.chief_of(colours[c]).images - chief.images)
        landed, victim[c].reshape(-1)[keep] = beams.forward(colours[c], of_field, begun)
        values[c].reshape(LANDED, -1)[:, keep] = landed
        _cover(values[c, LEVEL], values[c, PUPIL_S], values[c, PUPIL_T], grid, coverage[c], unused)
        _cover(values[c, LEVEL], s, t, grid, weight[c], centre[:, c])

    with ThreadPoolExecutor(THREADS) as pool:
        list(pool.map(trace_colour, range(len(colours))))
    beam = beams.beam_areas(places)
    weight = _of_mean_1(weight * beam, weight > 0.0)
    coverage[~weight.any((2, 3))] = 0.0                 # the rims end all rays that the object point sends
    centre = np.ascontiguousarray(centre.transpose(0, 2, 1, 3, 4))
    victim, weight, coverage, chiefs = (np.ascontiguousarray(np.swapaxes(each, 0, 1))
                                        for each in (victim, weight, coverage, chiefs))
    arrays = np.ascontiguousarray(values.transpose(1, 2, 0, 3, 4))
    within = arrays[SHARE] <= 1.0
    ended = np.flatnonzero(np.isfinite(grid).all((1, 2)) & ~coverage[:, conditions.primary].any((1, 2)))
    if ended.size:
        names = ", ".join(field_name(conditions, int(i)) for i in ended)
        findings.append(Finding(Kind.DARK, None, "rims end all rays of the object points whose chief rays meet "
                                f"{names}: these fields are dark", figures={"fields": float(ended.size)}))
    made = RayGrid(
        lens, film_distance, conditions, chief.angles, chief.images, beams.axes, chiefs, beams.chief_pupil, grid,
        offset_s=arrays[OFFSET_S], offset_t=arrays[OFFSET_T], slope_s=arrays[SLOPE_S], slope_t=arrays[SLOPE_T],
        pupil_s=arrays[PUPIL_S], pupil_t=arrays[PUPIL_T], opd=arrays[OPD], weight=weight, open_centre=centre,
        coverage=coverage, intensity=_of_mean_1(beam, coverage[:, conditions.primary] > 0.0), victim=victim,
        stop_share=arrays[SHARE], open_area=_open_areas(open_cells, grid), beams=beams,
        sphere_curvatures=beams.sphere_curvatures, launched=within.sum((2, 3)),
        lost=(within & (victim >= 0)).sum((2, 3)), findings=(*conditions.findings, *findings))
    if not made.lit.any():
        raise LensError("no light of these fields reaches the film" + (f": {findings[-1]}" if findings else ""))
    return made


def _open_areas(open_cells: np.ndarray, grid: np.ndarray) -> np.ndarray:
    """(F,) areas in pupil coordinates of the covered parts of the cells."""
    return open_cells.sum((1, 2)) * np.nan_to_num((grid[:, :, 1] - grid[:, :, 0]).prod(1))


def _of_mean_1(values: np.ndarray, where: np.ndarray) -> np.ndarray:
    """The values (…, N, N), scaled to a mean of 1 over the chosen cells of each N × N."""
    count, total = where.sum((-2, -1), keepdims=True), (values * where).sum((-2, -1), keepdims=True)
    return np.where(total > 0.0, values * (count / np.where(total > 0.0, total, 1.0)), 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def _cover(level, s, t, grid, out, centre):
    """The part (F, N, N) of each cell where a level (F, N, N) is below 1, from its value and slopes.

    s, t: (F, N, N) pupil coordinates at which the level is known, near the cells' centres grid (F, 2, N). centre
    (2, F, N, N) receives the centroid of the open part from the middle of the cell, in cells.
    """
    fields, rows, columns = level.shape
    for f in range(fields):
        per_s, per_t = 1.0 / (grid[f, 0, 1] - grid[f, 0, 0]), 1.0 / (grid[f, 1, 1] - grid[f, 1, 0])
        for i in range(rows):
            for j in range(columns):
                here = level[f, i, j]
                centre[0, f, i, j], centre[1, f, i, j] = 0.0, 0.0
                if not here < np.inf:
                    out[f, i, j] = 0.0
                    continue
                a, b = cell_slope(level[f], i, j, 0), cell_slope(level[f], i, j, 1)
                here += a * (grid[f, 1, i] - t[f, i, j]) * per_t + b * (grid[f, 0, j] - s[f, i, j]) * per_s
                up, right = a, b
                a, b = max(abs(a), abs(b)), min(abs(a), abs(b))
                d = 1.0 - here                          # a half-plane: d + slopes · offset > 0
                half, flat = 0.5 * (a + b), 0.5 * (a - b)
                if abs(d) >= half or a == 0.0:
                    part = 1.0 if d >= 0.0 else 0.0
                elif abs(d) <= flat:
                    part = 0.5 + d / a
                else:
                    corner = (half - abs(d)) ** 2 / (2.0 * a * b)
                    part = 1.0 - corner if d > 0.0 else corner
                out[f, i, j] = part
                if part < 1.0 and a > 0.0:
                    centre[0, f, i, j] = -0.5 * (1.0 - part) * right / a
                    centre[1, f, i, j] = -0.5 * (1.0 - part) * up / a


@njit(cache=True, nogil=True, error_model="numpy")
def _towards_centroids(values, weight, centre, out):
    """Values (n, N, N) halfway to the centroids (2, n, N, N) of the cells' open parts; 0 where the weight is 0."""
    for f in range(values.shape[0]):
        for i in range(values.shape[1]):
            for j in range(values.shape[2]):
                ds, dt = centre[0, f, i, j], centre[1, f, i, j]
                here = values[f, i, j]
                if ds != 0.0 or dt != 0.0:
                    here += 0.5 * (ds * cell_slope(values[f], i, j, 1) + dt * cell_slope(values[f], i, j, 0))
                out[f, i, j] = here if weight[f, i, j] > 0.0 else 0.0


