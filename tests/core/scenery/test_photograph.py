"""A photograph with a depth map: a pinhole in its place sees it again; beside it, near and far things move apart."""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.scenery.photograph import photograph_scene

FOV = 0.7


def sample(rows=80, columns=120):
    """A photograph of smooth colours, and a disk at 1 m before a slope from 2 m to 4 m."""
    y, x = np.mgrid[0:rows, 0:columns] + 0.5
    picture = np.stack([0.3 + 0.2 * np.sin(x / 9.0), 0.4 + 0.3 * np.cos(y / 7.0), 0.2 + 0.001 * x], -1)
    depth = 2000.0 + 2000.0 * y / rows
    disk = np.hypot(x - columns / 2, y - rows / 2) < 20.0
    picture[disk] = (0.9, 0.1, 0.1)
    return picture, np.where(disk, 1000.0, depth), disk


def falloff(rows=80, columns=120):
    """cos⁴ of the angle of each pixel: the camera's own falloff, which the photograph gets a second time."""
    y, x = np.mgrid[0:rows, 0:columns] + 0.5
    per = 2.0 * math.tan(FOV / 2.0) / columns
    return 1.0 / (1.0 + ((x - columns / 2) ** 2 + (y - rows / 2) ** 2) * per**2)[..., None] ** 2


@pytest.mark.slow
def test_a_pinhole_in_its_place_sees_the_photograph():
    picture, depth, _ = sample()
    scene = photograph_scene(picture, depth, FOV)
    film = lb.Film(36.0, 24.0, 120, 80)
    camera = lb.PerspectiveCamera(film, fov=2.0 * math.atan(math.tan(FOV / 2.0) * 80 / 120))     # of the shorter side
    seen = lb.render(camera, scene, samples=64)
    blurred = np.abs(np.asarray(seen) / falloff() - picture)
    # a pixel is a mean over interpolated texels: at the edge of the disk it takes half of its neighbours
    assert np.median(blurred) < 2e-3 and np.percentile(blurred, 90) < 0.02 and blurred.max() < 0.45
    found = lb.depth_map(camera, scene)
    inside = np.abs(found / depth - 1.0)
    assert np.median(inside) < 0.005 and (inside > 0.05).mean() < 0.02


@pytest.mark.slow
def test_a_camera_beside_it_sees_what_was_hidden_as_filled():
    picture, depth, _ = sample()
    film = lb.Film(36.0, 24.0, 120, 80)
    place = np.eye(4)
    place[0, 3] = 60.0                                                  # mm to the right
    views = {}
    for fill in ("plain", "shown", "none"):
        camera = lb.PerspectiveCamera(film, fov=2.0 * math.atan(math.tan(FOV / 2.0) * 80 / 120),
                                      world_from_camera=place)
        scene = photograph_scene(picture, depth, FOV, fill=fill)
        views[fill] = np.asarray(lb.render(camera, scene, samples=16)) / falloff()
    marked = (views["shown"][..., 0] > 0.8) & (views["shown"][..., 1] < 0.05) & (views["shown"][..., 2] > 0.8)
    # the disk at 1 m moves by 60 mm, the slope behind it at 3 m by a third of that: 13 pixels less
    scale = 120 / (2.0 * math.tan(FOV / 2.0))
    width = marked[40].sum()
    assert width == pytest.approx(60.0 * scale * (1 / 1000.0 - 1 / 3000.0), abs=2.5)
    hole = np.abs(views["none"][marked] - 0.25 * picture.mean((0, 1)))
    assert np.percentile(hole, 80) < 2e-3                               # the dim sky; pixels of edges are mixed
    # filled with the colours of the slope, whose green depends on the row alone
    rows = np.nonzero(marked)[0]
    assert np.median(np.abs(views["plain"][marked][:, 1] - picture[rows, 5, 1])) < 0.06


def test_what_no_photograph_can_be_is_one_clear_line():
    picture, depth, _ = sample(8, 12)
    for change, reason in (({"depth": depth[:, :8]}, "another shape"), ({"depth": -depth}, "not positive"),
                           ({"depth": depth * np.nan}, "not positive"), ({"depth": depth[0]}, "shape"),
                           ({"depth": depth * np.inf}, "no finite"), ({"photograph": picture[..., 0]}, "shape"),
                           ({"photograph": picture * np.nan}, "not finite"), ({"fov": 4.0}, "fov"),
                           ({"fill": "magic"}, "plain, shown, none")):
        with pytest.raises(lb.SceneError, match=reason) as caught:
            photograph_scene(**{"photograph": picture, "depth": depth, "fov": FOV, **change})
        assert "\n" not in str(caught.value)


def test_neighbours_on_one_surface_share_their_corners():
    picture, depth, disk = sample(20, 30)
    scene = photograph_scene(picture, np.full((20, 30), 1500.0), FOV)
    mesh, = scene.meshes
    assert len(np.unique(np.round(mesh.points, 3), axis=0)) == 21 * 31 and (mesh.points[:, 2] == -1500.0).all()
