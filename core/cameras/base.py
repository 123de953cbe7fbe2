"""The base class of every camera: rays, projection onto the film with the importance of rays, coordinate spaces.

`camera_stages` has what a camera kind defines, `ray_generation` its rays.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lensbench.core.cameras.film_landing import FilmImportance, Importance, gaussian_importance
from lensbench.core.cameras.ray_generation import RayGeneration
from lensbench.core.cameras.real_lens_projection import solve_film_points
from lensbench.core.cameras.shutter import CameraError, project_onto_open_rows
from lensbench.core.imaging.coordinate_spaces import Intrinsics, Places, Spaces, film_window, transform_points
from lensbench.core.kernels.block import Step
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import unit_table
from lensbench.core.lazy import called
from lensbench.core.optics.glass import D_LINE


@dataclass(frozen=True, eq=False, kw_only=True)
class Camera(RayGeneration):
    """Fields and methods that all camera kinds share; each kind adds a field `film`.

    Args:
        weights: str. "relative": the unvignetted axis point has weight 1 at every stop. "physical": cos⁴θ · area / z² ·
            effective time, and radiance falls by the squared index when light leaves a medium. "radiance", or "one":
            every ray of an ideal camera has weight 1, without cos⁴θ, so that a pixel shows the mean radiance that it
            sees.
        medium: Medium or None. Medium between the camera and the scene; None is clear air. A flat window at the
            camera's foremost point separates air from a medium of another index. The camera is focused and weighted as
            in air, so objects in water appear nearer by the index on its focus scale.
        **placement: Keyword arguments of `PlacedShutter`: transform to the world, and shutter.
    Raises:
        CameraError: Unknown weights; shutter times that contradict each other.
        TransformError: A world_from_camera that is not rigid.
    """

    def _repr_html_(self) -> str:
        """Section and figures, for a notebook."""
        return called("app.notebook.cards", "camera_card", self)

    def check_overrides(self) -> None:
        """CameraError for a camera kind that overrides a method that pictures do not call: they run the camera's
        stages.
        """
        for name in ("generate_rays", "generate_ray_differentials"):
            if getattr(getattr(self, name), "__func__", None) is not getattr(Camera, name):
                raise CameraError(f"{type(self).__name__} overrides {name}, which pictures do not call: give the "
                                  "function of its rays to lb.CustomCamera(film, rays), or override camera_steps "
                                  "with a stage")

    # Projection onto the film

    def raster_from_point(self, points: ArrayLike, pupil_uv: ArrayLike | None = None, time: ArrayLike = 0.0,
                          wavelength: float = D_LINE) -> tuple[np.ndarray, np.ndarray]:
        """Projection of points of the world onto the raster. Other objects of the scene hide nothing.

        Args:
            points: (n, 3) array. Points in the world (mm).
            pupil_uv: (n, 2) array or None. Pupil samples in [0, 1]² of the rays that project; None: the centre of the
                pupil.
            time: float or (n,) array. Shutter samples in [0, 1), as `generate_rays` takes them.
            wavelength: Wavelength of the light (µm).
        Returns:
            raster: (n, 2) array. Raster points (pixels); those of points that are not visible are NaN or have no
                meaning.
            visible: (n,) bool array. False for points behind the camera, blocked by the lens, or beside the film.
        Raises:
            ValueError: Points that are not finite, pupil samples outside the unit square, or times outside [0, 1].
        """
        points = np.atleast_2d(np.asarray(points, float))
        if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all():
            raise ValueError(f"points of the shape {points.shape}: they must be (n, 3) finite numbers")
        if pupil_uv is None and self.with_open_stop is not self:
            return self.with_open_stop.raster_from_point(points, None, time, wavelength)
        centre = self.pupil_centre if pupil_uv is None else pupil_uv
        pupil_uv = np.broadcast_to(unit_table(centre, np.float64), (len(points), 2))

        def project(row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            """Raster points with the camera where it is while these rows of the film are open."""
            there = transform_points(np.linalg.inv(self.placement(time, row)), points)
            if self.has_port:
                film, visible = self._film_by_newton(self.aimed(wavelength), there, pupil_uv)
            else:
                film, visible = self.film_from_point(there, pupil_uv, wavelength)
            return self.raster_from_film(film), visible

        return project_onto_open_rows(self, project, len(points))

    def film_from_point(self, points: np.ndarray, pupil_uv: np.ndarray, wavelength: float = D_LINE
                       ) -> tuple[np.ndarray, np.ndarray]:
        """Film points (n, 2), mm, whose rays through pupil_uv (n, 2) in [0, 1]² meet points (n, 3), mm, of the camera
        frame.

        Also returns whether the camera sees each point, (n,) bool; wavelength: µm.
        """
        if self._is_projective:
            return self.gaussian.film_points(points, pupil_uv)
        return self._film_by_newton(self.camera_steps(wavelength), points, pupil_uv)

    def _film_by_newton(self, steps: list[Step], points: np.ndarray, pupil_uv: np.ndarray
                       ) -> tuple[np.ndarray, np.ndarray]:
        """`film_from_point` by Newton's method, with steps from the film to the ray in the camera frame."""
        program = Program(steps, np.float64)
        return solve_film_points(program, points, pupil_uv, self.stage_uv, self.stage_centre,
                                 self.film.diagonal / 2.0, self._newton_start(points))

    def _newton_start(self, points: np.ndarray) -> np.ndarray | None:
        """Film points (n, 2) near those that see points (n, 3) of the camera frame; None where none are needed."""
        return None

    def raster_from_film(self, film_xy: np.ndarray) -> np.ndarray:
        """Raster points (n, 2), pixels, of film_xy (n, 2), mm: the inverse of `film_step`."""
        across, right, down, bottom = self.film_step.parameters
        return np.stack([(right - film_xy[:, 0]) / across, (film_xy[:, 1] + bottom) / down], 1)

    def importance(self, origins: ArrayLike, directions: ArrayLike, time: ArrayLike = 0.0, wavelength: float = D_LINE
                  ) -> Importance:
        """Importance and densities of rays that run from the camera into the scene.

        To connect a point of the scene to the camera, pass drawn pupil samples to `raster_from_point` and the raster
        points that it returns to `generate_rays`. Per solid angle at the point, that ray is chosen with the density
        position_pdf · distance² / cos θ, with the distance to the point where the ray crosses the entrance pupil.

        Args:
            origins: (n, 3) array. Any points on the rays, in the world (mm).
            directions: (n, 3) array. Directions in the world, of any length.
            time: float or (n,) array. Shutter samples in [0, 1), as `generate_rays` takes them.
            wavelength: Wavelength of the light (µm).
        Raises:
            ValueError: Rays of other shapes, not finite, or with a zero direction.
            CameraError: A camera behind a window to a medium.
        """
        if self.has_port:
            raise CameraError("importance is known in air, not through the window to a medium of another index")
        origins, directions = (np.atleast_2d(np.asarray(values, float)) for values in (origins, directions))
        length = np.linalg.norm(directions, axis=-1)
        if origins.shape != directions.shape or origins.shape[1:] != (3,) or not (
                np.isfinite(origins).all() and np.isfinite(directions).all() and (length > 0.0).all()):
            raise ValueError("rays need origins and directions of the shape (n, 3), finite, and no direction zero")
        unit_directions = directions / length[:, None]

        def importance_at(row: np.ndarray) -> FilmImportance:
            """Importance, with the camera where it is while these rows of the film are open."""
            camera_from_world = np.linalg.inv(self.placement(time, row))
            local_origins = transform_points(camera_from_world, origins)
            local_directions = (camera_from_world[..., :3, :3] @ unit_directions[..., None])[..., 0]
            local_directions /= np.linalg.norm(local_directions, axis=1)[:, None]
            return self.film_importance(local_origins, local_directions, wavelength)

        def project(row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            importance = importance_at(row)
            return self.raster_from_film(importance.film), importance.passes

        raster, visible = project_onto_open_rows(self, project, len(unit_directions))
        raster = np.where(np.isfinite(raster), raster, 0.0)
        importance = importance_at(raster)
        we, position_pdf, direction_pdf = (np.where(visible, value, 0.0) for value in importance[1:4])
        if not importance.is_point:                     # per mm² of the world, to which the placement may scale
            area = np.abs(np.linalg.det(self.placement(time, raster)[..., :3, :3])) ** (2.0 / 3.0)
            we, position_pdf = we / area, position_pdf / area
        return Importance(we, position_pdf, direction_pdf, np.where(visible[:, None], raster, math.nan), visible)

    def film_importance(self, origins: np.ndarray, directions: np.ndarray,
                        wavelength: float = D_LINE) -> FilmImportance:
        """Importance and densities of rays in the camera frame: origins (mm) and unit directions, (n, 3) each;
        wavelength: µm.

        CameraError for a camera kind that is not projective and does not override this.
        """
        return gaussian_importance(self._weighted_gaussian, self._weighted_gain, self._film_area, origins, directions)

    @property
    def _film_area(self) -> float:
        """Area (mm²) of the film, at the scale of `film_step`."""
        across, _, down, _ = self.film_step.parameters
        return across * self.film.pixels_x * down * self.film.pixels_y

    # Spaces

    @property
    def intrinsics(self) -> Intrinsics:
        """Focal lengths and principal point in pixels; a traced lens has those of its first order.

        Raises CameraError for a camera that is not projective.
        """
        across, right, down, bottom = self.film_step.parameters
        lens, pose = self.gaussian, self.film_pose
        if pose.is_tilted or pose.is_curved:
            raise CameraError("a tilted or curved film has no focal length in pixels: its pixels are not perpendicular "
                              "to the axis")
        per_slope = -1.0 / (lens.slope_film if lens.slope_film != 0.0 else lens.origin_film)
        return Intrinsics(per_slope / across, per_slope / down, (right - pose.shift) / across,
                          (bottom + pose.rise) / down)

    def spaces(self, near: float = 1.0, far: float = math.inf, time: ArrayLike = 0.0) -> Spaces:
        """Transforms between raster, screen, camera and world, for the camera at a shutter sample `time` in [0, 1).

        near, far: distances (mm) of the planes of depth 0 and 1; an orthographic camera needs a finite far plane, and
        ValueError is raised for planes in the wrong order. CameraError for a camera that is not projective.
        """
        film, lens = self.film, self.gaussian
        if not self.film_pose.is_upright:
            raise CameraError("the screen of a tilted, shifted or curved film is no view of a symmetric pinhole camera")
        half = min(film.width, film.height) / 2.0
        perspective = lens.slope_film != 0.0
        per_slope = lens.slope_film if perspective else lens.origin_film
        eye = lens.z + lens.origin_film / lens.slope_film if perspective else lens.z
        return Spaces(film.pixels_x, film.pixels_y, self.window or film_window(film), -1.0 / (per_slope * half),
                      near, far, perspective, eye, self.placement(time))

    def places(self, raster_xy: ArrayLike, distance: float, time: ArrayLike = 0.0,
               object_from_world: ArrayLike | None = None) -> Places:
        """Raster points (n, 2) in every space, for every camera kind: the data of a read-out under the mouse.

        raster_xy: pixels. distance: to the object (mm), along the ray through the centre of the pupil; time: shutter
        samples in [0, 1); each one or (n,). object_from_world: (4, 4) into the frame of an object, or None: the world.
        """
        film = self.film
        raster = np.atleast_2d(np.asarray(raster_xy, float))

        # Raster, NDC, screen and film are affine images of each other
        ndc = raster / [film.pixels_x, film.pixels_y]
        left, right, bottom, top = self.window or film_window(film)
        screen = ndc * [right - left, bottom - top] + [left, top]
        across, middle, down, low = self.film_step.parameters
        on_film = np.column_stack([middle - raster[:, 0] * across, raster[:, 1] * down - low, np.zeros(len(raster))])

        # Follow the rays to the given distance
        rays = self.with_open_stop.generate_rays(raster, np.tile(self.pupil_centre, (len(raster), 1)), time)
        visible = rays.weights > 0.0
        world = rays.origins + rays.directions * np.broadcast_to(distance, visible.shape)[:, None]
        world = np.where(visible[:, None], world, np.nan)
        in_camera = transform_points(np.linalg.inv(self.placement(time, raster)), world)
        in_object = world if object_from_world is None else transform_points(object_from_world, world)
        return Places(raster, ndc, screen, on_film, in_camera, world, in_object)
