"""The base class of every camera: what its kinds define (`camera_stages`), rays, projection and coordinate spaces."""

import math
from dataclasses import dataclass

import numpy as np

from lensbench.core.cameras.film_projection import FilmProjection
from lensbench.core.cameras.ray_generation import RayGeneration
from lensbench.core.cameras.rays import CameraError
from lensbench.core.imaging.coordinate_spaces import Intrinsics, Places, Spaces, film_window, transform_points
from lensbench.core.lazy import called


@dataclass(frozen=True, eq=False, kw_only=True)
class Camera(RayGeneration, FilmProjection):
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

    def spaces(self, near: float = 1.0, far: float = math.inf, time=0.0) -> Spaces:
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

    def places(self, raster_xy, distance: float, time=0.0, object_from_world=None) -> Places:
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
