"""A camera's intrinsics and pose as JSON."""

import json

import numpy as np

import lensbench as lb


def intrinsics(of: lb.Camera) -> str | None:
    """Focal length and principal point in pixels, and the pose, as JSON; None for a camera that is not projective."""
    try:
        found = of.intrinsics
    except lb.CameraError:
        return None
    film = of.film
    pose = np.reshape(of.placement(0.0, np.array([[film.pixels_x / 2.0, film.pixels_y / 2.0]])), (4, 4))
    return json.dumps({
        "width": film.pixels_x, "height": film.pixels_y, "fx": found.fx, "fy": found.fy, "cx": found.cx,
        "cy": found.cy, "K": found.matrix.tolist(), "world_from_camera": pose.tolist(),
        "units": "pixels, mm",
        "convention": "K: x right, y down, z forward; world_from_camera: x right, y up, looks along -z",
    }, indent=2)
