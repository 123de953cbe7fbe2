"""One bounce of diffuse light against closed forms, and against sums over surfaces in numpy."""

from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.kernels.block import BLUE, GREEN, RED, V0, V1, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from tests.core.scenery.test_scene import shoot, square_lights

pytestmark = pytest.mark.slow

DARK = lb.Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3)


def seen(scene, point, eye, side=256):
    """Mean radiance of a point of a surface over side² samples of light, by the renderer's stages."""
    v0, v1 = square_lights(side)
    return shoot(scene.steps(), np.tile(eye, (len(v0), 1)), np.subtract(point, eye), (v0, v1), np.float32).mean(0)


def test_a_disk_lit_from_below_lights_the_floor_by_its_closed_form():
    # a uniform disk of radiance ρ E / π: E′ / π = ρ E / π · R² / (R² + h²) below its centre
    disk = lb.Disk((0.0, 100.0, -1000.0), (0.0, 1.0, 0.0), 400.0, lb.Material((0.9, 0.3, 0.1)))
    floor = lb.Floor(-250.0, light=(0.5,) * 3, dark=(0.5,) * 3)
    sun = lb.Sun((0.0, -1.0, 0.0), (2.0, 2.0, 2.0))         # through the floor, which is seen from above only
    scene = lb.Scene("disk", sky=DARK, sun=sun, floor=floor, plates=(disk,))
    assert not seen(scene, (0.0, -250.0, -1000.0), (0.0, 0.0, 300.0)).any()
    found = seen(replace(scene, diffuse_bounce=True), (0.0, -250.0, -1000.0), (0.0, 0.0, 300.0))
    expected = 0.5 * np.array([0.9, 0.3, 0.1]) * 2.0 * 400.0**2 / (400.0**2 + 350.0**2)
    np.testing.assert_allclose(found, expected, rtol=0.01)


def test_a_red_wall_reddens_the_floor_as_a_sum_over_the_wall_says():
    # A Cornell-like corner: a lamp, a red wall, a white floor
    wall = lb.Rectangle((-300.0, 0.0, -1000.0), (0.0, 0.0, 300.0), (0.0, 250.0, 0.0), lb.Material((0.8, 0.1, 0.05)))
    ground = lb.Rectangle((0.0, -250.0, -1000.0), (300.0, 0.0, 0.0), (0.0, 0.0, 300.0), lb.Material((0.7, 0.7, 0.7)))
    lamp = lb.Rectangle((100.0, 300.0, -1000.0), (60.0, 0.0, 0.0), (0.0, 0.0, 60.0), lb.Material((9.0,) * 3, "lamp"))
    scene = lb.Scene("corner", sky=DARK, plates=(wall, ground, lamp))
    point, eye = np.array([-150.0, -250.0, -950.0]), np.array([100.0, 100.0, -300.0])
    indirect = (seen(replace(scene, diffuse_bounce=True), point, eye, 512) - seen(scene, point, eye, 512)) / 0.7

    def form(a, normal_a, b, normal_b):
        """cos cos / (π d²) between points (n, 3) and (m, 3)."""
        to = b[None] - a[:, None]
        d2 = np.sum(to**2, -1)
        return np.maximum(to @ normal_a, 0.0) * np.abs(to @ normal_b) / (np.pi * d2**2)

    cells = (np.arange(120) + 0.5) / 60.0 - 1.0
    y, z = np.meshgrid(250.0 * cells, 300.0 * cells - 1000.0)
    on_wall = np.column_stack([np.full(y.size, -300.0), y.ravel(), z.ravel()])
    few = (np.arange(12) + 0.5) / 6.0 - 1.0
    x, z = np.meshgrid(60.0 * few + 100.0, 60.0 * few - 1000.0)
    on_lamp = np.column_stack([x.ravel(), np.full(x.size, 300.0), z.ravel()])
    right, up = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    lit = 9.0 * form(on_wall, right, on_lamp, up).sum(1) * (120.0**2 / on_lamp.shape[0])
    arriving = (form(point[None], up, on_wall, right)[0] * lit).sum() * (500.0 * 600.0 / len(on_wall))
    np.testing.assert_allclose(indirect, arriving * np.array([0.8, 0.1, 0.05]), rtol=0.01, atol=2e-5)


def test_the_sky_lights_what_it_sees():
    # under a white sky a plate open to all of it: its albedo; below a black disk: less the part that the disk covers
    sky = lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3)
    plate = lb.Rectangle((0.0, -250.0, -1000.0), (900.0, 0.0, 0.0), (0.0, 0.0, 900.0), lb.Material((0.6, 0.5, 0.4)))
    lid = lb.Disk((0.0, 50.0, -1000.0), (0.0, 1.0, 0.0), 300.0, lb.Material((0.0, 0.0, 0.0)))
    scene = lb.Scene("sky", sky=sky, plates=(plate,), diffuse_bounce=True)
    found = seen(scene, (0.0, -250.0, -1000.0), (0.0, 0.0, 300.0))
    np.testing.assert_allclose(found, (0.6, 0.5, 0.4), rtol=1e-4)
    found = seen(replace(scene, plates=(plate, lid)), (0.0, -250.0, -1000.0), (0.0, 0.0, 300.0), 705)
    np.testing.assert_allclose(found, np.array([0.6, 0.5, 0.4]) * 0.5, rtol=0.01)       # R = h: half of it


def test_mirrors_and_lights_are_what_they_were():
    # of rays that meet a mirror, a light or the sky first the bounce changes nothing
    mirror = lb.Sphere((0.0, 0.0, -800.0), 100.0, lb.Material((0.9, 0.9, 0.9), "metal"))
    light = lb.Sphere((300.0, 50.0, -900.0), 60.0, lb.Material((5.0, 4.0, 3.0), "light"))
    black = lb.Floor(-250.0, light=(0.0,) * 3, dark=(0.0,) * 3)
    scene = lb.Scene("mirror", floor=black, spheres=(mirror, light))
    random = np.random.default_rng(3)
    n = 3000
    ways = np.column_stack([random.uniform(-0.4, 0.6, n), random.uniform(-0.3, 0.3, n), -np.ones(n)])
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    given = {X: np.zeros(n), Y: np.zeros(n), Z: np.zeros(n), L: ways[:, 0], M: ways[:, 1], N: ways[:, 2],
             V0: random.random(n), V1: random.random(n)}
    plain, bounced = (Program(one.steps(), np.float64).run(given, [RED, GREEN, BLUE], n)
                      for one in (scene, replace(scene, diffuse_bounce=True)))
    np.testing.assert_allclose(bounced, plain, rtol=1e-12)


def test_a_mesh_sends_the_light_that_a_rectangle_sends():
    wall = lb.Rectangle((-300.0, 0.0, -1000.0), (0.0, 0.0, 300.0), (0.0, 250.0, 0.0), lb.Material((0.8, 0.1, 0.05)))
    corners = [[-300.0, -250.0, -700.0], [-300.0, -250.0, -1300.0], [-300.0, 250.0, -1300.0], [-300.0, 250.0, -700.0]]
    mesh = lb.Mesh.of(corners, [[0, 1, 2], [0, 2, 3]], lb.Material((0.8, 0.1, 0.05)))
    floor = lb.Floor(-250.0, light=(0.7,) * 3, dark=(0.7,) * 3)
    scene = lb.Scene("corner", sky=DARK, sun=lb.Sun((0.8, 0.5, 0.2)), floor=floor, diffuse_bounce=True)
    point, eye = (-200.0, -250.0, -1000.0), (0.0, 0.0, 300.0)
    by_plate, by_mesh = (seen(one, point, eye) for one in (replace(scene, plates=(wall,)),
                                                           replace(scene, meshes=(mesh,))))
    np.testing.assert_allclose(by_mesh, by_plate, rtol=1e-3)
    assert by_plate[0] > 1.1 * by_plate[2]
