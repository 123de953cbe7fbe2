"""Curves of chief rays over the field: distortion, field curvature and astigmatism, lateral colour.

Lengths in mm, angles in radians. Foci are measured from the film, positive behind it; heights from the film's centre,
positive along the field. For distortion the chief ray of a film point, through the middle of the stop, is traced from
the film to the plane in focus (or to infinity), and the ideal image of the point that it meets is compared with the
film point: f tan θ at infinity, otherwise the paraxial magnification. A fisheye can be measured against the projection
that it follows best.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.analysis.aberrations import check_symmetry, coddington
from lensbench.core.analysis.grids.chief_rays import find_chief_rays
from lensbench.core.analysis.grids.field_conditions import Conditions, wanted_chief_rays
from lensbench.core.cameras.fisheye import PROJECTIONS, image_height
from lensbench.core.imaging.film import Film
from lensbench.core.optics.focus import focused_distance
from lensbench.core.optics.glass import D_LINE
from lensbench.core.optics.lens_surface import LensError
from lensbench.core.optics.paraxial import first_order
from lensbench.core.optics.prescription import Lens
from lensbench.core.optics.scalar_trace import trace
from lensbench.core.pupils.region import exit_pupil

RECTILINEAR = "rectilinear"
SLIGHT = 0.05           # percent, below which the kind is "none"
POINTS = 33             # of the exit-pupil regions, which are empty where no light falls
GRID_RADII = 65         # film radii from which a grid is interpolated
CLOSE = 1e-3            # tangent of an object point that counts as close to the axis


@dataclass(frozen=True, eq=False)
class Distortion:
    """Distortion at n film radii, from `distortion`; NaN where no light falls.

    Args:
        projection: The ideal projection, "rectilinear" or one of a FisheyeCamera's.
        focal_length: Scale of the projection, mm.
        radii: (n,) film radii, mm.
        angles: (n,) angles from the axis at which the chief rays leave for the scene, radians.
        ideal: (n,) ideal film radii of the same object points, mm.
    """

    projection: str
    focal_length: float
    radii: np.ndarray
    angles: np.ndarray
    ideal: np.ndarray

    @property
    def percent(self) -> np.ndarray:
        """(n,) percent of the ideal radius: negative for barrel, positive for pincushion distortion."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.radii > 0.0, 100.0 * (self.radii / self.ideal - 1.0), 0.0)

    @property
    def rms(self) -> float:
        """Root mean square of the radial errors, mm; inf where some angle has no ideal image."""
        error = (self.radii - self.ideal)[~np.isnan(self.angles)]
        return float(np.sqrt((error**2).mean())) if np.isfinite(error).all() and error.size else math.inf

    @property
    def kind(self) -> str:
        """The word "none", "barrel", "pincushion", or "moustache": barrel near the axis and pincushion beyond."""
        percent = self.percent[np.isfinite(self.percent)]
        if not percent.size or np.abs(percent).max() < SLIGHT:
            return "none"
        low, high = percent.min(), percent.max()
        if low < -SLIGHT and high > SLIGHT or abs(percent[-1]) < 0.5 * max(-low, high):
            return "moustache"
        return "barrel" if -low > high else "pincushion"

    def displaced(self, points: ArrayLike) -> np.ndarray:
        """Real images (…, 2) of ideal film points (…, 2), mm from the axis; NaN beyond the greatest radius."""
        points = np.asarray(points, float)
        r = np.hypot(points[..., 0], points[..., 1])
        known = np.isfinite(self.ideal)
        order = np.argsort(self.ideal[known])
        radii = np.interp(r, np.append(0.0, self.ideal[known][order]), np.append(0.0, self.radii[known][order]),
                          right=math.nan)
        with np.errstate(invalid="ignore"):
            return points * np.where(r > 0.0, radii / np.where(r > 0.0, r, 1.0), 1.0)[..., None]


def distortion(lens: Lens, film_distance: float, film_radii: ArrayLike, projection: str = RECTILINEAR,
               wavelength: float = D_LINE) -> Distortion:
    """The distortion of a lens.

    Args:
        lens: The lens.
        film_distance: From the last vertex to the film, mm. Objects lie where the film is focused, at infinity where
            the film is nearer to the lens than the rear focus.
        film_radii: (n,) film radii, mm.
        projection: "rectilinear", one of a FisheyeCamera's, or "best": the one of these with the least rms error.
        wavelength: µm.
    Raises:
        LensError: For an unknown projection and an afocal lens.
    """
    if projection not in (RECTILINEAR, *PROJECTIONS, "best"):
        raise LensError(f"projection {projection!r}: choose one of {', '.join((RECTILINEAR, *PROJECTIONS, 'best'))}")
    fo = first_order(lens, wavelength)
    if math.isinf(fo.efl):
        raise LensError("an afocal lens has no focal length to measure its distortion by")
    radii = np.atleast_1d(np.asarray(film_radii, float))
    chief = find_chief_rays(lens, film_distance, np.column_stack([radii, 0.0 * radii]), by_image=True,
                            wavelength=wavelength)
    left, _, right, _ = exit_pupil(lens, film_distance, radii, wavelength, points=POINTS).bounds.T
    points, directions = (np.where((right > left)[:, None], values, math.nan)      # rims do not end chief rays
                          for values in (chief.points, chief.directions))
    angles = np.arctan2(directions[:, 0], directions[:, 2]) + 0.0       # no −0
    extension = film_distance - fo.bfl
    far = extension < 1e-9 * fo.efl
    scale = ideal_scale(lens, film_distance, wavelength)

    def against(name: str) -> Distortion:
        if name == RECTILINEAR:
            with np.errstate(invalid="ignore"):
                if far:
                    ideal = np.where(angles < 0.5 * math.pi, scale * np.tan(angles), math.inf)
                else:
                    away = (fo.ffl - lens.front_index * fo.efl**2 / extension - points[:, 2]) / directions[:, 2]
                    ideal = -(points[:, 0] + away * directions[:, 0]) * extension / fo.efl
                    ideal = np.where(away < 0.0, ideal, math.inf)
            return Distortion(name, scale, radii, angles, np.where(np.isnan(angles), math.nan, ideal))
        return Distortion(name, scale, radii, angles, scale * image_height(name, angles))

    if projection != "best":
        return against(projection)
    return min((against(name) for name in (RECTILINEAR, *PROJECTIONS)), key=lambda fit: fit.rms)


def ideal_scale(lens: Lens, film_distance: float, wavelength: float) -> float:
    """Paraxial height (mm) on the film over the tangent at the entrance pupil: f for a film at the rear focus."""
    fo = first_order(lens, wavelength)
    away = 0.0 if math.isinf(fo.entrance_pupil.z) else fo.entrance_pupil.z - fo.ffl
    return lens.front_index * fo.efl + away * (film_distance - fo.bfl) / fo.efl


def distortion_grid(lens: Lens, film_distance: float, film: Film, lines: int = 9, projection: str = RECTILINEAR,
                    wavelength: float = D_LINE, steps: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Crossings of a square grid over the film, ideal and as the lens images them.

    Args:
        lens: The lens. One without rotational symmetry is compared with f tan θ of each direction of the film, about
            the image of the axis, f being that of objects close to the axis.
        film_distance: From the last vertex to the film, mm.
        film: The film that the grid covers.
        lines: Grid lines along the film's shorter side, at least 2; those along the longer side have nearly the same
            spacing.
        projection, wavelength: As for `distortion`; a lens without rotational symmetry has RECTILINEAR alone.
        steps: Points along a line from one crossing to the next: each row and column whose index is a multiple of
            `steps` is a line of the grid.
    Returns:
        Ideal and real points, (rows, columns, 2) each, mm from the axis; NaN where no light falls, of a lens without
            rotational symmetry where no chief ray arrives.
    Raises:
        LensError: For fewer than 2 lines, and as `distortion`.
    """
    if lines < 2 or steps < 1:
        raise LensError(f"a grid of {lines} lines with {steps} steps: at least 2 lines with 1 step are needed")
    gap = min(film.width, film.height) / (lines - 1)
    x, y = (np.linspace(-side / 2.0, side / 2.0, max(1, round(side / gap)) * steps + 1)
            for side in (film.width, film.height))
    ideal = np.stack(np.meshgrid(x, y), -1)
    if lens.is_rotationally_symmetric:
        radii = np.linspace(0.0, 0.75 * film.diagonal, GRID_RADII)  # pincushion can put a corner beyond the film's
        return ideal, distortion(lens, film_distance, radii, projection, wavelength).displaced(ideal)
    if projection != RECTILINEAR:
        raise LensError(f"projection {projection!r}: a lens with {lens.asymmetry} is compared with "
                        f"{RECTILINEAR} alone")
    return ideal, _displaced_every_way(lens, film_distance, ideal, wavelength)


def _displaced_every_way(lens: Lens, film_distance: float, ideal: np.ndarray, wavelength: float) -> np.ndarray:
    """Real images (…, 2) of ideal film points (…, 2), of a lens without rotational symmetry; NaN without a chief ray.

    The ideal image is linear in the tangents of the object point, with the scale of objects close to the axis.
    """
    distance = focused_distance(lens, film_distance)
    away = distance - lens.length - film_distance               # object → first vertex

    def images(slopes: np.ndarray) -> np.ndarray:
        """(n, 2) on the film, of object points in these directions (n, 2) from the axis: tangents."""
        size = np.hypot(slopes[:, 0], slopes[:, 1])
        angles = slopes * np.where(size > 0.0, np.arctan(size) / np.where(size > 0.0, size, 1.0), 1.0)[:, None]
        aims = angles if math.isinf(away) else -slopes * away
        return find_chief_rays(lens, film_distance, aims, away, False, wavelength).images

    middle, *ends = images(CLOSE * np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]))
    scale = np.array([ends[0][0] - ends[1][0], ends[2][1] - ends[3][1]]) / (2.0 * CLOSE)
    return images(ideal.reshape(-1, 2) / scale).reshape(ideal.shape) - middle


FIELD_POINTS = 41


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


def field_curves(lens: Lens, film_distance: float, conditions: Conditions, points: int = FIELD_POINTS) -> FieldCurves:
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
    if math.isinf(fo.efl):
        raise LensError("an afocal lens has neither foci nor image heights")
    aims, by_image = wanted_chief_rays(lens, conditions)
    largest = float(np.hypot(aims[:, 0], aims[:, 1]).max())
    along = np.linspace(0.0, largest, points)
    # An object height above the axis has its image below: let the image rise
    sign = 1.0 if by_image or math.isinf(distance) else -1.0
    aims = np.column_stack([0.0 * along, sign * along])
    chief = find_chief_rays(lens, film_distance, aims, distance, by_image, line)
    film_z, heights = lens.length + film_distance, chief.images[:, 1]
    sources = chief.angles
    if not math.isinf(distance):
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
        if not math.isinf(distance):
            point = np.column_stack([sources[good], np.full(int(good.sum()), -distance)])
            vergences = -lens.front_index / np.linalg.norm(paths[:, 1] - point, axis=1)
        foci[:, c, good] = coddington(lens, paths[:, 1:], own.directions[good], colour, vergences)
    angles = chief.angles[:, 1]
    return FieldCurves(conditions, angles, heights, foci[0].T - film_z, foci[1].T - film_z,
                       heights**2 / (2.0 * fo.petzval_radius), lateral.T,
                       *_ideal(lens, film_distance, conditions, angles, sources[:, 1]))


def _ideal(lens: Lens, film_distance: float, conditions: Conditions, angles: np.ndarray,
           sources: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n,) heights of the paraxial chief ray on this film: f tan θ at the rear focus; and in proportion to θ."""
    fo, distance = first_order(lens, conditions.primary_wavelength), conditions.object_distance
    pupil, scale = fo.entrance_pupil.z, ideal_scale(lens, film_distance, conditions.primary_wavelength)
    if math.isinf(distance):
        with np.errstate(invalid="ignore"):
            return np.where(np.abs(angles) < 0.5 * np.pi, scale * np.tan(angles), math.inf), scale * angles
    if math.isinf(pupil):
        return -sources * lens.front_index * fo.efl / (fo.ffl + distance), np.full(len(angles), np.nan)
    return -sources / (distance + pupil) * scale, np.full(len(angles), np.nan)


def _percent(heights: np.ndarray, ideal: np.ndarray) -> np.ndarray:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(heights == 0.0, 0.0, 100.0 * (heights / ideal - 1.0))
