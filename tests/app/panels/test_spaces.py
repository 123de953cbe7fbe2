"""Spaces: the point under the mouse lies where its ray meets the scene, and intrinsics have their unit."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.app.bench.camera_kinds import camera
from lensbench.app.panels.spaces import along, intrinsic_rows, rows
from tests.app.conftest import SMALL
from tests.app.kinds import of_kind

WALL = -1200.0                  # mm: the wall x = WALL, to the left of the camera


@pytest.mark.parametrize(("kind", "fov"), [("perspective", 1.0), ("fisheye", 2.0), ("fisheye", 4.0),
                                           ("environment", 1.0)])
def test_a_point_of_a_wall_lies_on_the_wall(kind, fov):
    settings = replace(of_kind(SMALL, kind), position=(100.0, 50.0, -30.0), yaw=0.6, pitch=0.1, f_number=None,
                       fisheye_fov=fov, pixels_x=80, pixels_y=40)
    wall = lb.Rectangle((WALL, -9000.0, 9000.0), (0.0, 18000.0, 0.0), (0.0, 0.0, -18000.0))
    of = camera(settings)
    depth = lb.depth_map(of, lb.Scene("wall", plates=(wall,)))
    count = 0
    for raster in [(10.5, 20.5), (20.5, 15.5), (25.5, 22.5), (40.5, 20.5), (60.5, 30.5)]:
        ray = of.generate_rays([raster], [of.pupil_centre])
        (start, *_), (to, *_) = ray.origins[0], ray.directions[0]
        distance = (WALL - start) / to              # along a unit ray to the plane
        if not (ray.weights[0] > 0.0 and 0.0 < distance < 8000.0):
            continue
        count += 1
        assert along(of, raster, depth) == pytest.approx(distance, rel=1e-5)
        table = {name: numbers for name, numbers, *_ in rows(of, raster, depth)}
        point = ray.origins[0] + distance * ray.directions[0]
        world = [float(value.replace("−", "-")) for value in table["World"]]
        np.testing.assert_allclose(world, point / 1000.0, atol=6e-4)        # three printed digits
        assert float(table["Distance"][0]) == pytest.approx(distance / 1000.0, abs=6e-4)
    assert count >= 2


def test_the_focal_length_of_parallel_rays_is_in_pixels_per_millimetre_of_the_scene():
    settings = replace(of_kind(SMALL, "orthographic"), scene_width=480.0)
    of = camera(settings)
    (name, numbers, unit, _), *_ = intrinsic_rows(of)
    assert (name, unit) == ("fx, fy", "px/mm")
    raster, _ = of.raster_from_point([[0.0, 0.0, -900.0], [100.0, 0.0, -900.0]])
    assert float(numbers[0]) == pytest.approx((raster[1, 0] - raster[0, 0]) / 100.0, rel=1e-3)
    perspective = camera(of_kind(SMALL, "perspective"))
    (_, numbers, unit, _), *_ = intrinsic_rows(perspective)
    assert unit == "px" and math.isclose(float(numbers[0]), perspective.intrinsics.fx, abs_tol=0.05)
