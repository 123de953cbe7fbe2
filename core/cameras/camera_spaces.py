"""Intrinsics, transforms and read-outs of a camera in its coordinate spaces; see `imaging.coordinate_spaces`."""


import numpy as np

from lensbench.cameras.camera_stages import CameraStages
from lensbench.cameras.ray_generation import RayGeneration
from lensbench.cameras.rays import CameraError
from lensbench.imaging.coordinate_spaces import Intrinsics, Places, Spaces, film_window, transform_points


def intrinsics(camera: CameraStages) -> Intrinsics:
    """Focal lengths and principal point in pixels."""
    across, right, down, bottom = camera.film_step.parameters
    lens = camera.gaussian
    if camera.film_pose.is_tilted or camera.film_pose.is_curved:
        raise CameraError("a tilted or curved film has no focal length in pixels: its pixels are not perpendicular to "
                          "the axis")
    right, bottom = right - camera.film_pose.shift, bottom + camera.film_pose.rise
    per_slope = -1.0 / (lens.slope_film if lens.slope_film != 0.0 else lens.origin_film)
    return Intrinsics(per_slope / across, per_slope / down, right / across, bottom / down)


def spaces(camera: CameraStages, near: float, far: float, time) -> Spaces:
    """Transforms between the camera's spaces, with depth from `near` to `far` (mm), at a shutter sample."""
    film, lens = camera.film, camera.gaussian
    if not camera.film_pose.is_upright:
        raise CameraError("the screen of a film out of line is no view of a symmetric pinhole camera")
    half = min(film.width, film.height) / 2.0
    perspective = lens.slope_film != 0.0
    per_slope = lens.slope_film if perspective else lens.origin_film
    eye = lens.z + lens.origin_film / lens.slope_film if perspective else lens.z
    return Spaces(film.pixels_x, film.pixels_y, camera.window or film_window(film), -1.0 / (per_slope * half),
                  near, far, perspective, eye, camera.placement(time))


def places(camera: RayGeneration, raster_xy, distance, time, object_from_world) -> Places:
    """Raster points (n, 2) in every space; distance (mm): along the ray through the centre of the pupil."""
    film = camera.film
    raster = np.atleast_2d(np.asarray(raster_xy, float))

    # Raster, NDC, screen and film are affine images of each other
    ndc = raster / [film.pixels_x, film.pixels_y]
    left, right, bottom, top = camera.window or film_window(film)
    screen = ndc * [right - left, bottom - top] + [left, top]
    across, middle, down, low = camera.film_step.parameters
    on_film = np.column_stack([middle - raster[:, 0] * across, raster[:, 1] * down - low, np.zeros(len(raster))])

    # Follow the rays to the given distance
    rays = camera.with_open_stop.generate_rays(raster, np.tile(camera.pupil_centre, (len(raster), 1)), time)
    seen = rays.weights > 0.0
    world = np.where(seen[:, None], rays.origins + rays.directions * np.broadcast_to(distance, seen.shape)[:, None],
                     np.nan)
    in_camera = transform_points(np.linalg.inv(camera.placement(time, raster)), world)
    in_object = world if object_from_world is None else transform_points(object_from_world, world)
    return Places(raster, ndc, screen, on_film, in_camera, world, in_object)
