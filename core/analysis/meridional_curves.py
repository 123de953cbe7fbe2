"""Curves over the field: field curvature and astigmatism, distortion, lateral colour.

Lengths in mm. All follow from the chief rays of many field points in one meridian. Foci are measured from the film,
positive behind it; heights from the film's centre, positive along the field.
"""

from dataclasses import dataclass
from math import inf, isinf

import numpy as np

from lensbench.core.analysis.aberrations import check_symmetry, coddington
from lensbench.core.analysis.distortion import ideal_scale
from lensbench.core.analysis.grids.chief_rays import find_chief_rays
from lensbench.core.analysis.grids.field_conditions import Conditions, wanted_chief_rays
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import trace

POINTS = 41


@dataclass(frozen=True, eq=False)
class FieldCurves:
    """Curves of one lens state at n field points and C wavelengths, from `field_curves`; NaN beyond the sight.

    Args:
        conditions: As given.
        angles: (n,) angle of the field from the axis in the scene, rad.
        heights: (n,) where the primary chief ray meets the film.
        tangential, sagittal: (n, C) foci of a narrow beam about the chief ray, mm behind the film, along the axis.
        petzval: (n,) sag of the Petzval surface at these heights, mm from its place on the axis, in the primary
            wavelength.
        lateral_colour: (n, C) height of each wavelength's chief ray less that of the primary one, mm.
        ideal: (n,) height of an ideal projection, that of the paraxial chief ray on this film: f tan θ on one at the
            rear focus; inf from 90° on.
        ideal_f_theta: (n,) the same in proportion to the angle, f θ; NaN for a near object.
    """

    conditions: Conditions
    angles: np.ndarray
    heights: np.ndarray
    tangential: np.ndarray
    sagittal: np.ndarray
    petzval: np.ndarray
    lateral_colour: np.ndarray
    ideal: np.ndarray
    ideal_f_theta: np.ndarray

    @property
    def distortion(self) -> np.ndarray:
        """(n,) percent of the ideal height f tan θ; 0 on the axis."""
        return _percent(self.heights, self.ideal)

    @property
    def f_theta_distortion(self) -> np.ndarray:
        """(n,) percent of the height f θ; 0 on the axis."""
        return _percent(self.heights, self.ideal_f_theta)


def field_curves(lens: Lens, film_distance: float, conditions: Conditions, points: int = POINTS) -> FieldCurves:
    """Field curvature, astigmatism, distortion and lateral colour.

    Source: Welford, Aberrations of Optical Systems, ch. 9 (Coddington's equations).

    Args:
        lens: Rotationally symmetric lens, focused.
        film_distance: Last vertex → film, mm.
        conditions: The largest of its fields ends the curves; wavelengths and object distance as they are.
        points: Field points from the axis to the largest, at least 2.
    Returns:
        Rims do not end the rays.
    Raises:
        LensError: For a lens with a cylinder or toroid, an afocal lens, or fewer than 2 points.
    """
    check_symmetry(lens)
    if points < 2:
        raise LensError(f"{points} points of the field: at least 2 are needed")
    line, distance = conditions.primary_wavelength, conditions.object_distance
    fo = first_order(lens, line)
    if isinf(fo.efl):
        raise LensError("an afocal lens has neither foci nor image heights")
    aims, by_image = wanted_chief_rays(lens, conditions)
    largest = float(np.hypot(aims[:, 0], aims[:, 1]).max())
    along = np.linspace(0.0, largest, points)
    # An object height above the axis has its image below: let the image rise
    sign = 1.0 if by_image or isinf(distance) else -1.0
    aims = np.column_stack([0.0 * along, sign * along])
    chief = find_chief_rays(lens, film_distance, aims, distance, by_image, line)
    film_z, heights = lens.length + film_distance, chief.images[:, 1]
    sources = chief.angles
    if not isinf(distance):
        away = (-distance - chief.points[:, 2]) / chief.directions[:, 2]
        sources = chief.points[:, :2] + away[:, None] * chief.directions[:, :2]
    foci = np.full((2, len(conditions.wavelengths), points), np.nan)
    lateral = np.empty((len(conditions.wavelengths), points))
    for c, colour in enumerate(conditions.wavelengths):
        own = chief if c == conditions.primary else find_chief_rays(lens, film_distance, sources, distance, False,
                                                                    colour, near=chief.at_stop)
        lateral[c] = own.images[:, 1] - heights
        good = np.isfinite(own.points).all(1)
        starts = own.points[good] - lens.surfaces[0].semi_diameter * own.directions[good]
        paths = trace(lens, starts, own.directions[good], colour, clip=False, record=True, forward=True).paths
        assert paths is not None
        vergences: np.ndarray | float = 0.0
        if not isinf(distance):
            point = np.column_stack([sources[good], np.full(int(good.sum()), -distance)])
            vergences = -lens.front_index / np.linalg.norm(paths[:, 1] - point, axis=1)
        foci[:, c, good] = coddington(lens, paths[:, 1:], own.directions[good], colour, vergences)
    angles = chief.angles[:, 1]
    return FieldCurves(conditions, angles, heights, foci[0].T - film_z, foci[1].T - film_z,
                       heights**2 / (2.0 * fo.petzval_radius), lateral.T,
                       *_ideal(lens, film_distance, conditions, angles, sources[:, 1]))


def _ideal(lens: Lens, film_distance: float, conditions: Conditions, angles: np.ndarray,
           sources: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n,) ideal heights: of the paraxial chief ray on this film, f tan θ at the rear focus, and in proportion to the
    angle.
    """
    fo, distance = first_order(lens, conditions.primary_wavelength), conditions.object_distance
    pupil, scale = fo.entrance_pupil.z, ideal_scale(lens, film_distance, conditions.primary_wavelength)
    if isinf(distance):
        with np.errstate(invalid="ignore"):
            return np.where(np.abs(angles) < 0.5 * np.pi, scale * np.tan(angles), inf), scale * angles
    if isinf(pupil):
        return -sources * lens.front_index * fo.efl / (fo.ffl + distance), np.full(len(angles), np.nan)
    return -sources / (distance + pupil) * scale, np.full(len(angles), np.nan)


def _percent(heights: np.ndarray, ideal: np.ndarray) -> np.ndarray:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(heights == 0.0, 0.0, 100.0 * (heights / ideal - 1.0))
