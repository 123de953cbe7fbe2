"""The depth of a scene at each pixel of a camera."""

import numpy as np

from lensbench.analysis.model_choice import resolved
from lensbench.cameras.base import Camera
from lensbench.imaging.animated_transform import AnimatedTransform
from lensbench.kernels.block import GREEN, RED, TIME, U0, U1, WEIGHT, N, X, Y, Z
from lensbench.kernels.program import Program
from lensbench.rendering.aovs import sees_behind
from lensbench.scenery.scene import Scene


def depth_map(camera: Camera, scene: Scene, time: float = 0.5) -> np.ndarray:
    """Depth of the scene at the centre of each pixel, along the ray through the middle of the pupil.

    Parameters
    ----------
    camera
        Any camera; one of the model "auto" is resolved as by `render`.
    scene
        The scene, world frame, mm.
    time
        When, in [0, 1) of the shutter; matters where camera or scene move.

    Returns
    -------
    ndarray
        float32 (h, w) mm from the camera's origin along its −z, the top row first; inf where only sky is seen, NaN
        where the camera passes no light. Of a camera that also sees sideways or behind itself, such as a panorama or
        a fisheye over 180°, the distance along each ray in mm.
    """
    camera.check_overrides()
    camera, film = resolved(camera, scene).with_open_stop, camera.film
    h, w = film.pixels_y, film.pixels_x
    y, x = np.mgrid[0:h, 0:w] + 0.5
    n = w * h
    middle = camera.stage_centre
    given = {X: x.ravel(), Y: y.ravel(), U0: np.full(n, middle[0]), U1: np.full(n, middle[1]), TIME: np.full(n, time)}
    # Distance along the ray, and whether there is a hit
    steps = [*camera.steps(timed=scene.moves), *scene.depth_steps(camera.shutter_open)]
    along, hit, weight = Program(steps).run(given, [RED, GREEN, WEIGHT], n)
    # The ray's start and slope along the camera's axis
    z, slope, clock = Program([camera.clock, camera.film_step, *camera.aimed()]).run(given, [Z, N, TIME], n)
    place = camera.world_from_camera
    scale = place.scale_at(camera.shutter_open + clock) if isinstance(place, AnimatedTransform) else 1.0
    with np.errstate(invalid="ignore", over="ignore"):
        depth = along if sees_behind(camera) else -(z * scale + slope * along)
    depth = np.where(hit > 0.0, depth, np.inf)
    return np.where(weight > 0.0, depth, np.nan).reshape(h, w).astype(np.float32)
