"""A sky shown by a picture: what rays see of it, and the light that it gives, against sums over the sphere in numpy."""

import math
import tracemalloc
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench.core.kernels.block import A3, A4, A5, A6, FINISH, NX, NY, NZ, V0, V1, L, M, N, rows, stage
from lensbench.core.kernels.program import Program
from lensbench.core.scenery.shading.image_sky_light import COSINE, SINE, sky_cells, sky_density, sky_rays_step
from lensbench.core.scenery.shading.rough_clearcoat import image_rough_clearcoat_step
from tests.core.scenery.test_scene import shoot, square_lights


def directions(across, down):
    """Directions of the middles of across × down cells (down, across, 3), as `EnvironmentCamera` documents them."""
    theta = math.pi * (np.arange(down) + 0.5)[:, None] / down
    phi = 2.0 * math.pi * (np.arange(across) + 0.5) / across - math.pi
    return np.stack(np.broadcast_arrays(np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)), -1)


@pytest.fixture(scope="module")
def picture():
    random = np.random.default_rng(5)
    image = random.uniform(0.0, 1.0, (32, 64, 3))
    image[7:9, 40:42] = (300.0, 250.0, 150.0)                   # a sun with half of the light
    return image.astype(np.float32)


@pytest.fixture(scope="module")
def scene(picture):
    return lb.Scene("sky", sky=lb.ImageSky(lb.Image.of(picture)))


def test_every_texel_is_seen_in_its_direction(scene, picture):
    seen = shoot(scene.steps(shadows=False), 0.0, directions(64, 32).reshape(-1, 3)).reshape(32, 64, 3)
    np.testing.assert_allclose(seen, picture, rtol=2e-5, atol=3e-4)     # 1e-6 of a neighbour of 300


def test_between_the_last_column_and_the_first_the_picture_goes_on(scene, picture):
    theta = math.pi * 16.5 / 32
    seen = shoot(scene.steps(shadows=False), 0.0, [(0.0, math.cos(theta), math.sin(theta))])
    np.testing.assert_allclose(seen[0], (picture[16, 0] + picture[16, -1]) / 2.0, rtol=1e-5)


def test_a_positive_turn_moves_what_is_ahead_to_the_left(scene, picture):
    turned = replace(scene, sky=replace(scene.sky, turn=math.pi / 2, brightness=2.0))
    ahead = shoot(scene.steps(shadows=False), 0.0, [(0.0, 0.1, -1.0)])
    np.testing.assert_allclose(shoot(turned.steps(shadows=False), 0.0, [(-1.0, 0.1, 0.0)]), 2.0 * ahead, rtol=1e-6)


def irradiance(picture, normal):
    """Irradiance / π on a normal under the picture, bilinear between texels: a sum over 2048 × 1024 cells."""
    height, width = picture.shape[:2]
    across, down = 2048, 1024
    x, y = (np.arange(across) + 0.5) * width / across - 0.5, (np.arange(down) + 0.5) * height / down - 0.5
    y = np.clip(y, 0.0, height - 1.0)
    left, top = np.floor(x).astype(int), np.minimum(np.floor(y).astype(int), height - 2)
    s, t = (x - left)[:, None], (y - top)[:, None, None]
    lines = picture[top] * (1.0 - t) + picture[top + 1] * t
    radiance = lines[:, left % width] * (1.0 - s) + lines[:, (left + 1) % width] * s
    edges = np.cos(math.pi * np.arange(down + 1) / down)
    weights = (edges[:-1] - edges[1:])[:, None] * 2.0 * math.pi / across
    weights = weights * np.maximum(directions(across, down) @ normal, 0.0)
    return np.einsum("yxc,yx->c", radiance, weights) / math.pi


@pytest.mark.slow
@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.6, 0.64, 0.48), (0.0, -0.6, 0.8)])
def test_sampled_light_is_that_of_a_sum_over_the_sphere(scene, picture, normal):
    wall = lb.Disk((0.0, 0.0, -1000.0), normal, 100.0, lb.Material((0.5, 0.5, 0.5)))
    v0, v1 = square_lights(640)
    seen = shoot(replace(scene, plates=(wall,)).steps(), np.zeros((len(v0), 3)), (0.0, 0.0, -1.0), (v0, v1))
    np.testing.assert_allclose(seen.mean(0) / 0.5, irradiance(picture, np.asarray(normal)), rtol=5e-3)


@pytest.mark.slow
def test_a_sphere_hides_the_part_of_a_uniform_sky_of_its_closed_form():
    # r² cos θ / d² of the light of a uniform sky (exact for a sphere above the horizon)
    sky = lb.ImageSky(lb.Image.of(np.ones((4, 8, 3))))
    floor = lb.Disk((0.0, -500.0, 0.0), (0.0, 1.0, 0.0), 5000.0, lb.Material((1.0, 1.0, 1.0)))
    ball = lb.Sphere((0.0, 0.0, -1000.0), 300.0)
    scene = lb.Scene("ball", sky=sky, plates=(floor,), spheres=(ball,))
    v0, v1 = square_lights(192)
    lit = np.array([100.0, -500.0, -400.0])
    seen = shoot(scene.steps(), np.zeros((len(v0), 3)), lit, (v0, v1)).mean(0)
    to = np.array(ball.centre) - lit
    expected = 1.0 - ball.radius**2 * to[1] / np.linalg.norm(to) ** 3
    np.testing.assert_allclose(seen, expected, rtol=2e-3)


def test_what_no_sky_can_be_is_refused():
    for values in (np.full((2, 4, 3), np.nan), np.full((2, 4, 3), -1.0)):
        with pytest.raises(lb.SceneError, match="negative or not finite"):
            lb.ImageSky(lb.Image.of(values))
    with pytest.raises(lb.SceneError, match="brightness"):
        lb.ImageSky(lb.Image.of(np.ones((2, 4, 3))), brightness=-1.0)


def test_the_gradient_of_a_gradient_is_itself():
    sines = np.cos(math.pi * (np.arange(64) + 0.5) / 64)[:, None, None]
    values = np.where(sines > 0.0, 0.2 + sines * np.array([0.1, 0.3, 0.5]), 0.07) + np.zeros((64, 128, 3))
    found = lb.ImageSky(lb.Image.of(values)).gradient
    assert found.zenith == pytest.approx((0.3, 0.5, 0.7), rel=1e-3) and found.ground == pytest.approx((0.07,) * 3)
    assert found.horizon == pytest.approx((0.2,) * 3, rel=1e-3)


@pytest.mark.parametrize("width", [3000, 5000])
def test_a_small_sun_of_a_large_picture_keeps_its_light(width):
    # A sun of a few texels, in any place among the cells that the picture is reduced to
    height = width // 2
    edges = np.cos(math.pi * np.arange(height + 1) / height)
    cell = (edges[:-1] - edges[1:]) * 2.0 * math.pi / width
    for line, column in ((400, 1), (401, 700), (402, 1501)):
        values = np.zeros((height, width, 3), np.float32)
        values[line:line + 3, column:column + 3] = 1e4
        assert sky_cells(lb.ImageSky(lb.Image.of(values))).flux == pytest.approx(3e4 * cell[line:line + 3].sum(),
                                                                                 rel=1e-9)


@pytest.mark.slow
def test_a_sharp_coat_mirrors_the_sun_before_the_picture_and_the_picture_beside_a_moving_lamp(scene):
    ahead, back = (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)
    coat = lb.Rectangle((0.0, 0.0, -1000.0), (100.0, 0.0, 0.0), (0.0, 100.0, 0.0), lb.Material((0.0,) * 3, "coat"))
    picture = replace(scene, plates=(coat,))
    plain = shoot(picture.steps(), 0.0, [ahead])
    seen = shoot(scene.steps(), 0.0, [back])
    np.testing.assert_allclose(plain, 0.04 * seen, rtol=1e-5)
    sun = replace(picture, sun=lb.Sun(back, (1.0, 1.0, 1.0), 0.1))
    # Irradiance / π over the part of the hemisphere that the disk's projection fills
    np.testing.assert_allclose(shoot(sun.steps(), 0.0, [ahead]), 0.04 / math.sin(0.1) ** 2, rtol=5e-3)
    lamp = lb.Rectangle((3000.0, 0.0, 0.0), (0.0, 0.0, 10.0), (0.0, 10.0, 0.0), lb.Material((9.0,) * 3, "lamp"),
                        velocity=(1.0, 0.0, 0.0))
    np.testing.assert_allclose(shoot(replace(picture, plates=(coat, lamp)).steps(), 0.0, [ahead]), plain, rtol=1e-5)


@stage
def density(lanes, p, ints, key):
    """A6: `sky_density`.  p, ints: sky_rays_step."""
    sky_density(lanes, ints, p[COSINE], p[SINE], rows(lanes)[A6])


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_the_density_of_the_places_that_the_sky_chooses_is_one_over_the_sphere_and_highest_at_its_sun(scene, turn):
    sampled = sky_rays_step(replace(scene.sky, turn=turn))
    ways = directions(512, 256)
    x, y, z = ways.reshape(-1, 3).T
    (found,) = Program([sampled._replace(kernel=density)], np.float64).run({A3: x, A4: y, A5: z}, [A6], x.size)
    edges = np.cos(math.pi * np.arange(257) / 256)
    solid = np.repeat(edges[:-1] - edges[1:], 512) * 2.0 * math.pi / 512
    assert found @ solid == pytest.approx(1.0, rel=1e-5)
    theta, phi = math.pi * 8.0 / 32, 2.0 * math.pi * 41.0 / 64 - math.pi - turn
    sun = [math.sin(theta) * math.sin(phi), math.cos(theta), -math.sin(theta) * math.cos(phi)]
    assert ways.reshape(-1, 3)[np.argmax(found)] @ sun > math.cos(0.15)
    light = (found * solid)[ways.reshape(-1, 3) @ sun > math.cos(0.15)].sum()
    assert 0.4 < light < 0.7                            # half of the sky's light is there


def facets_mirror(sky, normal, view, gloss):
    """Radiance that facets of Trowbridge and Reitz with Smith's hiding mirror, F0 = 0.04: a sum over the sphere."""
    ways = directions(2048, 1024)
    radiance = shoot(lb.Scene("sky", sky=sky).steps(shadows=False), 0.0, ways.reshape(-1, 3)).reshape(ways.shape)
    edges = np.cos(math.pi * np.arange(1025) / 1024)
    solid = (edges[:-1] - edges[1:])[:, None] * 2.0 * math.pi / 2048
    half = ways + view
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    alpha2, slant, seen = (1.0 - gloss) ** 2, ways @ normal, view @ normal
    facets = alpha2 / (math.pi * (1.0 + (alpha2 - 1.0) * (half @ normal) ** 2) ** 2)
    open_ = [2.0 * c / (c + np.sqrt(alpha2 + (1.0 - alpha2) * c * c)) for c in (np.abs(slant), seen)]
    mirrored = 0.04 + 0.96 * (1.0 - half @ view) ** 5
    part = np.where(slant > 0.0, mirrored * facets * open_[0] * open_[1] / (4.0 * seen), 0.0)
    return np.einsum("yx,yxc->c", part * solid, radiance)


@pytest.mark.slow
@pytest.mark.parametrize("gloss", [0.9, 0.6])
@pytest.mark.parametrize("normal", [(0.0, 0.0, 1.0), (0.6, 0.64, 0.48), (0.0, 0.98, 0.199), (-0.9, 0.2, 0.387)])
def test_a_rough_coat_spreads_the_picture_as_its_facets_do(scene, normal, gloss):
    normal = np.asarray(normal) / np.linalg.norm(normal)
    sky = replace(scene.sky, turn=0.7, brightness=0.5)
    coat = lb.Disk((0.0, 0.0, -1000.0), tuple(normal), 100.0, lb.Material((0.0,) * 3, "coat", gloss=gloss))
    v0, v1 = square_lights(400)
    expected = facets_mirror(sky, normal, np.array([0.0, 0.0, 1.0]), gloss)
    for real in (np.float64, np.float32):
        seen = shoot(replace(scene, sky=sky, plates=(coat,)).steps(), np.zeros((len(v0), 3)), (0.0, 0.0, -1.0),
                     (v0, v1), real)
        np.testing.assert_allclose(seen.mean(0, dtype=float), expected, rtol=4e-3)


def test_a_rough_coat_shows_the_floor_in_place_of_the_picture_below_it():
    # Black above and a floor of its own light below: a coat that looks down sees the floor alone
    values = np.zeros((8, 16, 3))
    values[:4] = 0.7                                            # the floor has the irradiance / π 0.7
    sky = lb.ImageSky(lb.Image.of(values))
    floor = lb.Floor(-300.0, 100.0, (0.5, 0.5, 0.5), (0.5, 0.5, 0.5))
    tilted = np.array([0.0, -math.sin(0.3), math.cos(0.3)])     # mirrors a ray along −z downwards
    coat = lb.Disk((0.0, 0.0, -1000.0), tuple(tilted), 100.0, lb.Material((0.0,) * 3, "coat", gloss=0.97))
    v0, v1 = square_lights(64)
    seen = [shoot(lb.Scene("floor", sky=sky, plates=(coat,), floor=ground).steps(), np.zeros((len(v0), 3)),
                  (0.0, 0.0, -1.0), (v0, v1)).mean(0) for ground in (floor, None)]
    mirrored = 0.04 + 0.96 * (1.0 - math.cos(0.3)) ** 5
    np.testing.assert_allclose(seen[0], mirrored * 0.5 * 0.7, rtol=0.03)      # of a uniform sky above
    assert (seen[1] < 0.05 * seen[0]).all()


def test_the_gradient_of_a_large_picture_takes_no_copy_of_it():
    sky = lb.ImageSky(lb.Image.of(np.ones((256, 512, 3))))
    tracemalloc.start()
    try:
        assert sky.gradient.zenith == pytest.approx((1.0,) * 3)
        assert tracemalloc.get_traced_memory()[1] < 0.5 * len(sky.image.data)
    finally:
        tracemalloc.stop()


def test_a_facet_of_a_rough_coat_mirrors_the_ray_about_its_normal(scene):
    """The ways that the stage looks along last: unit vectors, whose facets lie about the normal evenly to all sides."""
    count, random = 4096, np.random.default_rng(8)
    ways, normals = random.normal(size=(2, 3, count))
    ways, normals = (v / np.linalg.norm(v, axis=0) for v in (ways, normals))
    ways *= -np.sign(np.sum(ways * normals, 0))                 # from outside
    given = dict(zip((L, M, N, NX, NY, NZ), (*ways, *normals), strict=True))
    given |= {FINISH: np.full(count, 0.9), V0: random.uniform(size=count), V1: random.uniform(size=count)}
    program = Program([image_rough_clearcoat_step(scene.sky, None, np.zeros(3))], np.float64)
    mirrored = program.run(given, [A3, A4, A5], count)
    np.testing.assert_allclose(np.linalg.norm(mirrored, axis=0), 1.0, atol=1e-12)
    facet = mirrored - ways
    facet *= np.sign(np.sum(facet * normals, 0)) / np.linalg.norm(facet, axis=0)
    # across the plane of ray and normal the facets tilt as much to one side as to the other
    aside = np.cross(normals.T, ways.T)
    aside = np.sum(facet * (aside / np.linalg.norm(aside, axis=1)[:, None]).T, 0)
    assert abs(aside.mean()) < 4.0 * aside.std() / math.sqrt(count)
    assert 0.04 < np.median(abs(aside)) < 0.12                  # α = 0.1
