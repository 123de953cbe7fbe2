"""The base class of every camera.

Its parts are files of their own: `camera_stages` has what a camera kind defines or overrides and the stages made of it,
`placed_shutter` the transform to the world and the shutter, `ray_generation` the rays, `film_projection` the projection
of points and rays of the world onto the film, `camera_spaces` the coordinate spaces.
"""

import math
from dataclasses import dataclass

from lensbench.core.cameras import ray_generation as camera_spaces
from lensbench.core.cameras.film_projection import FilmProjection
from lensbench.core.cameras.ray_generation import RayGeneration
from lensbench.core.cameras.rays import CameraError
from lensbench.core.imaging.coordinate_spaces import Intrinsics, Places, Spaces
from lensbench.core.lazy import called


@dataclass(frozen=True, eq=False, kw_only=True)
class Camera(RayGeneration, FilmProjection):
    """Fields and methods that all camera kinds share; each kind adds a field `film`.

    Parameters
    ----------
    weights : str
        "relative": the unvignetted axis point has weight 1 at every stop. "physical": cos⁴θ · area / z² · effective
        time, and radiance falls by the squared index when light leaves a medium. "radiance", or "one": every ray of
        an ideal camera has weight 1, without cos⁴θ, so that a pixel shows the mean radiance that it sees.
    medium : Medium or None
        Medium between the camera and the scene; None is clear air. A flat window at the camera's foremost point
        separates air from a medium of another index. The camera is focused and weighted as in air, so objects in
        water appear nearer by the index on its focus scale.
    **placement
        Keyword arguments of `PlacedShutter`: transform to the world, and shutter.

    Raises
    ------
    CameraError
        Unknown weights; shutter times that contradict each other.
    TransformError
        A world_from_camera that is not rigid.
    """

    def _repr_html_(self) -> str:
        """Section and figures, for a notebook."""
        return called("app.notebook.cards", "camera_card", self)

    def check_overrides(self) -> None:
        """Refuse a camera kind that overrides a method that pictures do not call.

        Pictures run the camera's stages; `generate_rays` and `generate_ray_differentials` run the same stages and
        return what they computed.

        Raises
        ------
        CameraError
            With what to do instead.
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
        return camera_spaces.intrinsics(self)

    def spaces(self, near: float = 1.0, far: float = math.inf, time=0.0) -> Spaces:
        """Transforms between raster, screen, camera and world.

        Parameters
        ----------
        near, far : float
            Distances (mm) of the planes that depth 0 and 1 lie on; an orthographic camera needs a finite far plane.
        time : float
            Shutter sample in [0, 1) at which the camera is placed.

        Raises
        ------
        CameraError
            A camera that is not projective.
        ValueError
            Planes in the wrong order.
        """
        return camera_spaces.spaces(self, near, far, time)

    def places(self, raster_xy, distance: float, time=0.0, object_from_world=None) -> Places:
        """Raster points in every space, for every camera kind: the data of a read-out under the mouse.

        Parameters
        ----------
        raster_xy : (n, 2) array
            Raster points (pixels).
        distance : float or (n,) array
            Distance (mm) to the object, along the ray through the centre of the pupil.
        time : float or (n,) array
            Shutter samples in [0, 1).
        object_from_world : (4, 4) array or None
            Transform from the world into the frame of an object; None: the object frame is the world.
        """
        return camera_spaces.places(self, raster_xy, distance, time, object_from_world)
