"""Pictures of moving cameras: blur, the rolling shutter, depth and time."""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.kernels.block import TIME, U0, U1, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.scenery.objects.basic_shapes import Rectangle
from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.scene import Scene
from tests.core.imaging.test_animated_transform import DARK, FILM, turned


def edge_scene():
    """A white half plane of light, x < 0, at 1 m."""
    return Scene("edge", sky=DARK, plates=(Rectangle((-5000.0, 0.0, -1000.0), (5000.0, 0.0, 0.0), (0.0, 5000.0, 0.0),
                                                     Material((1.0,) * 3, "light")),))


def panning(millimetres, **more):
    """A pinhole with 1 mm of scene at 1 m to a pixel of 120 × 80, moved to the right in one second."""
    end = np.eye(4)
    end[0, 3] = millimetres
    return lb.PerspectiveCamera(FILM, fov=2.0 * math.atan(0.040),
                                world_from_camera=lb.AnimatedTransform(np.eye(4), end), **more)


def lit(camera, scene, samples):
    """The part of each pixel that is lit: the picture over that of a white wall, which has the same falloff."""
    white = lb.render(lb.PerspectiveCamera(FILM, fov=camera.fov), lb.builtin_scene("white-wall"), samples=64)
    return (lb.render(camera, scene, samples=samples) / white)[..., 0]


@pytest.mark.parametrize("ramp", [0.0, 0.1, 0.25])
def test_the_blur_of_a_moving_edge_is_the_cumulative_of_the_shutter(ramp):
    """A camera that moves 80 mm/s to the right, 0.5 s open: the edge goes 40 px to the left.

    At a pixel's centre the light is the part of the exposure before the edge has passed, averaged over the pixel.
    """
    camera = panning(80.0, shutter_close=0.5, shutter_ramp=ramp)
    line = lit(camera, edge_scene(), 256).mean(0)
    x = (np.arange(120 * 50) + 0.5) / 50
    passed = np.clip((60.0 - x) / 80.0, 0.0, 0.5)               # s at which the edge comes to x
    grid = np.linspace(0.0, 0.5, 5001)
    through = np.ones_like(grid) if ramp == 0.0 else np.clip(np.minimum(grid, 0.5 - grid) / ramp, 0.0, 1.0)
    area = np.concatenate([[0.0], np.cumsum(0.5 * (through[1:] + through[:-1]))])
    wanted = np.interp(passed, grid, area / area[-1]).reshape(120, 50).mean(1)
    # 80 lines of 256 samples, stratified in time: an edge pixel errs by less than 1/256 before the mean of the lines
    np.testing.assert_allclose(line, wanted, atol=2e-3)


@pytest.mark.parametrize("direction", ["down", "up", "left", "right"])
def test_a_rolling_shutter_skews_by_speed_times_readout(direction):
    """An edge across the lines, the camera moving along them: its place differs by speed × readout over the film."""
    across = direction in ("down", "up")
    speed, readout = 20.0, 1.0                                   # mm, and pixels, a second
    end = np.eye(4)
    end[0 if across else 1, 3] = speed * 2.0
    camera = lb.PerspectiveCamera(
        FILM, fov=2.0 * math.atan(0.040), shutter_close=0.0, readout=readout, readout_direction=direction,
        world_from_camera=lb.AnimatedTransform(np.eye(4), end, 0.0, 2.0))
    plate = Rectangle((0.0, 5000.0, -1000.0), (9e3, 0.0, 0.0), (0.0, 5000.0, 0.0), Material((1.0,) * 3, "light"))
    scene = edge_scene() if across else Scene("edge", sky=DARK, plates=(plate,))
    edge = lit(camera, scene, 64).sum(1 if across else 0)        # raster x, or y, of the edge in every line
    place = (np.arange(len(edge)) + 0.5) / len(edge)
    delay = readout * (place if direction in ("down", "right") else 1.0 - place)
    # the camera goes right, or up: the edge goes left, or down. Two pixels of 64 samples share an edge: 1/32
    wanted = 60.0 - speed * delay if across else 40.0 + speed * delay
    np.testing.assert_allclose(edge, wanted, atol=0.04)
    skew = np.polyfit(place, edge, 1)[0]
    assert abs(skew) == pytest.approx(speed * readout, rel=1e-3)


def test_a_camera_that_swings_makes_a_straight_pole_wobble():
    """Rolled about its axis while its lines open: each line sees the pole from its own angle, in closed form."""
    turn, readout = 0.2, 1.0
    camera = lb.PerspectiveCamera(FILM, fov=2.0 * math.atan(0.040), shutter_close=0.0, readout=readout,
                                  world_from_camera=lb.AnimatedTransform(turned((0, 0, 1), -turn),
                                                                         turned((0, 0, 1), turn)))
    edge = lit(camera, edge_scene(), 64).sum(1)
    y = (np.arange(80 * 20) + 0.5) / 20
    angle = -turn + 2.0 * turn * y / 80.0
    # the camera at angle α sees the line x = 0 as x cos α = y′ sin α, y′ upwards from the middle
    wanted = (60.0 + (40.0 - y) * np.tan(angle)).reshape(80, 20).mean(1)
    np.testing.assert_allclose(edge, wanted, atol=0.04)
    assert np.ptp(np.diff(edge)) > 0.3                          # no straight line, as it is under a global shutter


def test_a_moving_picture_is_the_same_bit_for_bit_for_any_number_of_threads():
    end = turned((0, 1, 0), 0.05, (30.0, 0.0, 0.0))
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0, 2.8, shutter_close=0.5, shutter_ramp=0.1,
                           readout=0.5, world_from_camera=lb.AnimatedTransform(np.eye(4), end))
    scene = lb.builtin_scene("still-life")
    pictures = [lb.render(camera, scene, samples=3, seed=7, threads=threads) for threads in (1, 2, 5)]
    assert np.array_equal(pictures[0], pictures[1]) and np.array_equal(pictures[0], pictures[2])
    still = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0, 2.8)
    assert not np.array_equal(pictures[0], lb.render(still, scene, samples=3, seed=7))


def test_depth_is_seen_from_where_the_camera_is_at_that_time():
    end = np.eye(4)
    end[2, 3] = 500.0
    wall = Scene("wall", plates=(Rectangle((0.0, 0.0, -1700.0), (9e3, 0.0, 0.0), (0.0, 9e3, 0.0)),))
    camera = lb.PerspectiveCamera(FILM, shutter_close=0.5, readout=0.5,
                                  world_from_camera=lb.AnimatedTransform(np.eye(4), end))
    for time in (0.0, 0.5, 0.99):
        lines = 0.5 * time + 0.5 * (np.arange(80) + 0.5) / 80
        np.testing.assert_allclose(lb.depth_map(camera, wall, time)[:, 30], 1700.0 + 500.0 * lines, rtol=1e-6)


def test_single_precision_carries_rays_as_double_does():
    way = lb.AnimatedTransform(turned((1, 2, 0), 0.4, (100, 2000, -300)), turned((1, 0, 2), 2.9, (-100, 2200, 300)))
    step = way.steps(0.0, 1.0)
    rng = np.random.default_rng(3)
    d = rng.normal(size=(3, 1000))
    d /= np.linalg.norm(d, axis=0)
    given_ = {X: rng.normal(size=1000), Y: rng.normal(size=1000), Z: rng.normal(size=1000), L: d[0], M: d[1], N: d[2],
              TIME: rng.random(1000), U0: np.zeros(1000), U1: np.zeros(1000)}
    single, double = (Program(step, real).run(given_, [X, Y, Z, L, M, N], 1000).astype(float)
                      for real in (np.float32, np.float64))
    np.testing.assert_allclose(single[:3], double[:3], atol=2e-3)       # 4 ulp of 2 m
    np.testing.assert_allclose(single[3:], double[3:], atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(double[3:], axis=0), 1.0, atol=1e-14)


def test_the_aovs_of_time_and_depth_are_those_of_a_moving_camera():
    end = np.eye(4)
    end[2, 3] = 500.0
    wall = Scene("wall", plates=(Rectangle((0.0, 0.0, -1700.0), (9e3, 0.0, 0.0), (0.0, 9e3, 0.0)),))
    camera = lb.PerspectiveCamera(FILM, shutter_close=0.25, readout=0.75,
                                  world_from_camera=lb.AnimatedTransform(np.eye(4), end))
    lines = 0.125 + 0.75 * (np.arange(80) + 0.5) / 80            # the middle of each line's exposure
    for view, wanted in (("time", lines), ("depth", 1e3 / (1700.0 + 500.0 * lines))):
        rendering = lb.Rendering(camera, wall, view=view)
        rendering.add(64)
        # times are stratified by 64 in each pixel
        np.testing.assert_allclose(rendering.image()[..., 0].mean(1), wanted, atol=1e-3)
