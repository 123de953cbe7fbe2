"""Exit-pupil regions of the film behind a real lens, and where pupil samples lie in them. Lengths in mm."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lensbench.imaging.film import Film
from lensbench.imaging.film_pose import FilmPose
from lensbench.kernels.concentric_map import unit_disk
from lensbench.optics.glass import D_LINE
from lensbench.optics.paraxial import first_order, ray_matrix
from lensbench.optics.prescription import Lens
from lensbench.pupils.film_grid_sampler import PupilGrid
from lensbench.pupils.posed_sampler import PosedPupil
from lensbench.pupils.radial_sampler import PupilTable
from lensbench.pupils.spectral_grid import SpectralPupilGrid

Regions = PupilTable | PupilGrid | PosedPupil


@dataclass(frozen=True, eq=False)
class FilmRegions:
    """Exit-pupil regions of a film. widened: for rays that are traced, so that none is missed at the rim."""

    lens: Lens
    film: Film
    film_distance: float
    pose: FilmPose
    widened: bool

    def at(self, wavelength: float) -> Regions:
        """The regions at a wavelength (µm): by film radius, over a film grid, or by radius and distance."""
        lens, distance = self.lens, self.film_distance
        if not lens.is_rotationally_symmetric:
            return self._grids.at(wavelength)
        if self.pose.is_upright:
            return PupilTable.of(lens, distance, self.film.diagonal / 2.0, wavelength, widened=self.widened)
        return PosedPupil.of(lambda place, radius: PupilTable.of(lens, place, radius, wavelength, self.widened),
                             distance, lens.length + distance - first_order(lens, D_LINE).exit_pupil.z, self.pose,
                             self.pose.extent(self.film.width, self.film.height))

    @cached_property
    def _grids(self) -> SpectralPupilGrid:
        return SpectralPupilGrid(self.lens, self.film_distance, self.film.width / 2.0, self.film.height / 2.0,
                                 self.pose)

    def stage_uv(self, film_xy: np.ndarray, pupil_uv: np.ndarray) -> np.ndarray:
        """Angle (turns) and squared radius (n, 2) of pupil samples in the regions of film points, both (n, 2).

        The point of the region has the direction that the point of `unit_disk` has, so that the same sample is nearly
        the same point of the pupil for every film point and every model.
        """
        disk = unit_disk(pupil_uv) * self._pupil_side
        if self.lens.is_rotationally_symmetric:         # regions rotate with the film point, and halves are mirrored
            if not self.pose.is_upright:
                film_xy = self.pose.points(film_xy)[:, :2]
            azimuth = np.where((film_xy * film_xy).sum(1) > 1e-12, np.arctan2(film_xy[:, 1], film_xy[:, 0]), 0.0)
            angle = np.arctan2(disk[:, 1], disk[:, 0]) - azimuth
            turn = np.arctan2(np.sin(angle), np.cos(angle)) / (2.0 * math.pi)
            turn = np.where(turn < 0.0, 0.5 - turn, np.minimum(turn, np.nextafter(0.5, 0.0)))
        else:                                           # regions are mirrored into the first quadrant of the film
            disk = disk * np.where(film_xy < 0.0, -1.0, 1.0)
            turn = np.arctan2(disk[:, 1], disk[:, 0]) / (2.0 * math.pi) % 1.0
        return np.stack([np.clip(turn, 0.0, np.nextafter(1.0, 0.0)), np.minimum((disk * disk).sum(1), 1.0)], 1)

    @property
    def reach(self) -> float:
        """Largest distance from the axis (mm) at which rays of a film out of line cross z = 0."""
        rear = self.lens.surfaces[-1].semi_diameter
        extent = self.pose.extent(self.film.width, self.film.height)
        r, z = np.hypot(extent[:, 0], extent[:, 1]), extent[:, 2]
        return float((r + np.abs(z) * (r + rear) / (self.film_distance + z)).max())

    @cached_property
    def _pupil_side(self) -> float:
        """Sign of the height of a point of the stop in the exit pupil: −1 where that is an inverted image of it."""
        return math.copysign(1.0, ray_matrix(self.lens, self.lens.stop_index, len(self.lens.surfaces))[3])
