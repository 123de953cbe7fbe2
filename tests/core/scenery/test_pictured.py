"""Pictures on spheres, floors and large rectangles: every texel in its place, and means over wide footprints."""

import math

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.kernels.block import BLUE, GREEN, PIXEL_SPREAD, RED, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program

pytestmark = pytest.mark.slow


def pattern(values):
    return lb.Pattern("image", image=lb.Image.of(values))


def look(scene, origins, ways, spread=0.0):
    ways = ways / np.linalg.norm(ways, axis=1)[:, None]
    n = len(ways)
    given = {X: origins[:, 0], Y: origins[:, 1], Z: origins[:, 2], L: ways[:, 0], M: ways[:, 1], N: ways[:, 2],
             PIXEL_SPREAD: np.full(n, spread)}
    return Program(scene.steps(), np.float64).run(given, [RED, GREEN, BLUE], n).T


def test_a_picture_goes_once_around_a_sphere_from_its_back():
    random = np.random.default_rng(2)
    values = random.uniform(0.0, 1.0, (24, 48, 3))
    ball = lb.Sphere((50.0, -20.0, -900.0), 100.0, lb.Material((1.0,) * 3, "light", pattern=pattern(values)))
    line, column = random.integers(0, 24, 300), random.integers(0, 48, 300)
    theta, phi = math.pi * (line + 0.5) / 24, 2.0 * math.pi * (column + 0.5) / 48 - math.pi
    away = np.column_stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)])
    seen = look(lb.Scene("ball", spheres=(ball,)), np.array(ball.centre) + 300.0 * away, -away)
    np.testing.assert_allclose(seen, values[line, column], atol=5e-5)


def test_a_picture_repeats_on_the_floor_upright():
    random = np.random.default_rng(3)
    values = random.uniform(0.0, 1.0, (30, 20, 3))
    sky = lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3)
    scene = lb.Scene("floor", sky=sky, floor=lb.Floor(-200.0, 40.0, image=lb.Image.of(values)))
    line, column = random.integers(0, 30, 300), random.integers(0, 20, 300)
    over, down = random.integers(-4, 5, 300), random.integers(-4, 5, 300)
    # tiles of 40 mm × 60 mm from the origin: columns to the right, rows towards the camera
    x, z = 40.0 * (over + (column + 0.5) / 20), 60.0 * (down + (line + 0.5) / 30)
    from_ = np.column_stack([x + 10.0, np.full(300, 50.0), z + 20.0])
    seen = look(scene, from_, np.column_stack([x, np.full(300, -200.0), z]) - from_)
    np.testing.assert_allclose(seen, values[line, column], atol=5e-5)


def test_a_footprint_of_many_pictures_sees_their_mean():
    values = np.zeros((16, 16, 3))
    values[:4] = 0.8
    sky = lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3)
    scene = lb.Scene("floor", sky=sky, floor=lb.Floor(-200.0, 40.0, image=lb.Image.of(values)))
    ways = np.column_stack([np.linspace(-1.0, 1.0, 50), -np.ones(50), -np.ones(50)])
    seen = look(scene, np.zeros((50, 3)), ways, 0.5)
    np.testing.assert_allclose(seen, 0.2, atol=1e-4)


def test_a_reduction_of_a_large_picture_is_the_mean_of_its_texels():
    side = 2048
    values = np.zeros((side, side, 3), np.float32)
    values[::2, ::2] = values[1::2, 1::2] = 0.5
    wall = lb.Rectangle((0.0, 0.0, -1000.0), (400.0, 0.0, 0.0), (0.0, 400.0, 0.0),
                        lb.Material((1.0,) * 3, "light", pattern=pattern(values)))
    ways = np.column_stack([np.linspace(-0.3, 0.3, 64), np.linspace(-0.2, 0.3, 64), -np.ones(64)])
    seen = look(lb.Scene("wall", plates=(wall,)), np.zeros((64, 3)), ways, 0.01)
    np.testing.assert_allclose(seen, 0.25, atol=2e-5)           # half of 0.5


def test_the_largest_picture_is_read_in_place():
    # 8192 × 8192: 400 MB of codes, where copies in the parameters of a program would take gigabytes
    side = 8192
    values = np.zeros((side, side, 3), np.float32)
    values[8191, 8190], values[0, 3], values[5000, 7000] = (0.1, 0.2, 0.3), (0.4, 0.5, 0.6), (0.7, 0.8, 0.9)
    wall = lb.Rectangle((0.0, 0.0, -1000.0), (400.0, 0.0, 0.0), (0.0, 400.0, 0.0),
                        lb.Material((1.0,) * 3, "light", pattern=pattern(values)))
    line, column = np.array([8191, 0, 5000]), np.array([8190, 3, 7000])
    places = np.column_stack([(2.0 * column + 1.0) / side - 1.0, 1.0 - (2.0 * line + 1.0) / side]) * 400.0
    ways = np.column_stack([places, np.full(3, -1000.0)])
    seen = look(lb.Scene("wall", plates=(wall,)), np.zeros((3, 3)), ways)
    np.testing.assert_allclose(seen, values[line, column], atol=3e-5)


def test_a_sphere_with_an_image_that_moves_or_lights_is_refused():
    image = pattern(np.ones((2, 4, 3)))
    with pytest.raises(lb.SceneError, match="cannot move"):
        lb.Sphere((0.0, 0.0, -9.0), 1.0, lb.Material(pattern=image), velocity=(1.0, 0.0, 0.0))
    with pytest.raises(lb.SceneError, match="spherical lamp"):
        lb.Sphere((0.0, 0.0, -9.0), 1.0, lb.Material(kind="lamp", pattern=image))


def test_the_poles_of_a_sphere_show_the_first_and_the_last_row_of_its_picture():
    values = np.zeros((8, 16, 3))
    values[0], values[-1] = (0.8, 0.0, 0.0), (0.0, 0.0, 0.8)
    ball = lb.Sphere((0.0, 0.0, 0.0), 100.0, lb.Material((1.0,) * 3, "light", pattern=pattern(values)))
    theta, phi = np.linspace(0.0, math.pi / 20, 50), np.linspace(0.0, 30.0, 50)
    north = np.column_stack([np.sin(theta) * np.sin(phi), np.cos(theta), np.sin(theta) * np.cos(phi)])
    for away, colour in ((north, (0.8, 0.0, 0.0)), (north * [1.0, -1.0, 1.0], (0.0, 0.0, 0.8))):
        np.testing.assert_allclose(look(lb.Scene("ball", spheres=(ball,)), 300.0 * away, -away),
                                   np.tile(colour, (50, 1)), atol=5e-5)


def test_a_floor_seen_at_a_slant_looks_the_same_at_any_scale():
    values = np.random.default_rng(5).uniform(0.0, 1.0, (32, 32, 3))
    ways = np.column_stack([np.linspace(-4.0, 4.0, 200), -np.ones(200), -np.linspace(0.1, 4.0, 200)])
    large, small = (look(lb.Scene("floor", floor=lb.Floor(-200.0 * size, 40.0 * size, image=lb.Image.of(values))),
                         np.zeros((200, 3)), ways, 0.004) for size in (1.0, 1.0 / 40.0))
    assert np.quantile(np.abs(large - small), 0.97) < 1e-4              # a reduction may change by a digit
