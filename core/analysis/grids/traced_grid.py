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

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lensbench.analysis.grids.cell_coverage import towards_centroids
from lensbench.analysis.grids.field_beams import FieldBeams
from lensbench.analysis.grids.field_conditions import Conditions
from lensbench.optics.finding import Finding
from lensbench.optics.prescription import Lens


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
        beam that the rims leave open, times the cell's area and the transmission of a picture in the stop.
    open_centre
        (2, F, C, N, N) centroid of the open part of each ray's cell, from its middle, in cells: sagittal, tangential.
    coverage
        (F, C, N, N) the part of each cell of the exit pupil that the rims and a picture in the stop leave open, 0 to
        1.
    intensity
        (F, N, N) light of an evenly lit beam per area of the exit pupil, dimmed by the grey of a picture in the stop,
        of mean 1 over the open cells.
    victim
        (F, C, N, N) index of the surface that ends the ray, −1 for a ray that passes, −2 for one that is not traced:
        it lies far outside the rims.
    stop_share
        (F, C, N, N) squared distance from the axis in the stop over that of the stop's rim; NaN as the others.
    open_area
        (F,) area of the open region that the reference point sees, in pupil coordinates: the irradiance of the film
        under a scene of radiance 1, blades and a picture in the stop included; 0 for a dark field.
    beams
        How rays of these fields are given and traced; for analyses that trace more of them.
    mirrored
        Whether the light of the sagittal half of each field is the mirror image of the other.
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
