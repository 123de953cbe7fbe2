"""Rays of a camera, and their derivatives per pixel, by the stages that pictures run."""

import math

import numpy as np

from lensbench.cameras.camera_stages import CameraStages
from lensbench.cameras.differentials import Differentials, ray_slopes
from lensbench.cameras.rays import CameraError, Rays, checked_times
from lensbench.kernels.block import TIME, U0, U1, WEIGHT, L, M, N, X, Y, Z
from lensbench.kernels.program import Program
from lensbench.kernels.sampling import unit_square
from lensbench.optics.glass import D_LINE


class RayGeneration(CameraStages):
    """The part of `Camera` that turns raster points and pupil samples into rays of the world."""

    def generate_rays(self, raster_xy, pupil_uv, time=0.0, dtype=np.float64, wavelength: float = D_LINE) -> Rays:
        """Rays through raster points and pupil samples, by the same stages that the renderer runs.

        Parameters
        ----------
        raster_xy : (n, 2) array
            Raster points (pixels), the origin at the top left and pixel centres at +0.5.
        pupil_uv : (n, 2) array
            Pupil samples in [0, 1]², by which equal areas of the square have equal areas of the pupil. In every camera
            (0.5, 0.5) is the pupil's centre, and `unit_disk` maps them to the pupil: to a disk, or to the exit-pupil
            region of the film point.
        time : float or (n,) array
            Shutter samples in [0, 1]: the part of the light that the shutter has let through, 0 as it begins to open
            and 1 as it has closed.
        dtype : type
            Precision of the stages, float64 or float32.
        wavelength : float
            Wavelength of the light (µm).

        Returns
        -------
        Rays
            Origins (mm) and unit directions in the world, weights, and times in seconds, which include the delay of
            each ray's row.

        Raises
        ------
        CameraError
            Arrays of other shapes, raster points that are not finite, or times outside [0, 1].
        ValueError
            Pupil samples outside the unit square.
        """
        raster_xy, pupil_uv = np.atleast_2d(np.asarray(raster_xy, float)), unit_square(pupil_uv, dtype)
        if raster_xy.shape[1:] != (2,) or raster_xy.shape != pupil_uv.shape:
            raise CameraError(f"raster points {raster_xy.shape} and pupil points {pupil_uv.shape} must both be (n, 2)")
        if not np.isfinite(raster_xy).all():
            raise CameraError("raster points must be finite numbers")
        n = len(raster_xy)
        times = np.broadcast_to(checked_times(time), (n,))
        pupil_uv = self._stage_uv_of_raster(raster_xy, pupil_uv, dtype)
        given = {X: raster_xy[:, 0], Y: raster_xy[:, 1], U0: pupil_uv[:, 0], U1: pupil_uv[:, 1], TIME: times}
        out = Program(self.steps(wavelength, timed=True), dtype).run(given, [X, Y, Z, L, M, N, WEIGHT, TIME], n)
        return Rays(out[:3].T, out[3:6].T, out[6], self.shutter_open + out[7].astype(float))

    def _stage_uv_of_raster(self, raster_xy: np.ndarray, pupil_uv: np.ndarray, dtype) -> np.ndarray:
        """`stage_uv` of raster points (n, 2), within the unit square for numbers of this type."""
        film = Program([self.film_step], np.float64).run({X: raster_xy[:, 0], Y: raster_xy[:, 1]}, [X, Y],
                                                         len(raster_xy)).T
        return unit_square(self.stage_uv(film, pupil_uv), dtype)

    def generate_ray_differentials(self, raster_xy, pupil_uv, time=0.0, dtype=np.float64, wavelength: float = D_LINE
                                   ) -> tuple[Rays, Differentials, Differentials]:
        """Rays, and their derivatives per pixel to the right and per pixel down.

        The derivatives hold the pupil point fixed: the point of the unit disk, or of an exit-pupil region on the plane
        of the last vertex. They hold the shutter sample `time` fixed too, so with a rolling shutter they include the
        motion of the camera between rows. They have a closed form, or are differences of the camera's own stages with
        a relative error of 1e-7 in double precision.

        Parameters
        ----------
        raster_xy, pupil_uv, time, dtype, wavelength
            As for `generate_rays`.

        Returns
        -------
        rays : Rays
            The rays of `generate_rays`; a blocked neighbour does not change their weights.
        dx, dy : Differentials
            Derivatives in the world per pixel to the right and down; NaN where the ray itself is blocked.

        Raises
        ------
        CameraError, ValueError
            As for `generate_rays`.
        """
        rays = self.generate_rays(raster_xy, pupil_uv, time, dtype, wavelength)
        raster = np.atleast_2d(np.asarray(raster_xy, float))
        uv = self._stage_uv_of_raster(raster, unit_square(pupil_uv, dtype), dtype)
        given = {X: raster[:, 0], Y: raster[:, 1], U0: uv[:, 0], U1: uv[:, 1],
                 TIME: np.broadcast_to(checked_times(time), (len(raster),))}
        slopes = ray_slopes(self, given, dtype, wavelength, timed=True)
        slopes = np.where(rays.weights[:, None] > 0.0, slopes, math.nan)
        dx, dy = (Differentials(slope[:, :3], slope[:, 3:]) for slope in slopes)
        return rays, dx, dy
