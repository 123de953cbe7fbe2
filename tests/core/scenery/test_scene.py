"""What the scenes' stages see, against textbook geometry in numpy and closed forms of light."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import lensbench as lb
from lensbench.core.kernels.block import BLUE, GREEN, RED, V0, V1, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.scenery.builtin.library import SHIPPED

WITH_MESHES = (*SHIPPED, "foliage", "dusk-street", "low-sun")         # their stages are compiled by slow tests alone
ALL = (*(pytest.param(name, marks=pytest.mark.slow) if name in WITH_MESHES else name for name in lb.SCENES),
       "benchmark")


def shoot(steps, origins, directions, lights=None, real=np.float64):
    """Run the steps over rays (n, 3): RED, GREEN, BLUE as (n, 3)."""
    o, d = np.broadcast_arrays(np.asarray(origins, float), np.asarray(directions, float))
    o, d = o.reshape(-1, 3), d.reshape(-1, 3)
    d = d / np.sqrt(np.sum(d * d, 1, keepdims=True))
    n = len(o)
    given_ = {X: o[:, 0], Y: o[:, 1], Z: o[:, 2], L: d[:, 0], M: d[:, 1], N: d[:, 2]}
    given_ |= {V0: np.full(n, 0.5), V1: np.full(n, 0.5)} if lights is None else {V0: lights[0], V1: lights[1]}
    return Program(steps, real).run(given_, [RED, GREEN, BLUE], n).T


def random_rays(n, seed=0, spread=1.0):
    """Rays from near the origin to everywhere that a lens looks."""
    random = np.random.default_rng(seed)
    slopes = random.uniform(-spread, spread, (n, 2))
    return random.normal(0.0, 10.0, (n, 3)), np.column_stack([slopes, np.full(n, -1.0)])


def unit(d):
    return d / np.sqrt(np.sum(d * d, -1, keepdims=True))


def square_lights(side):
    """V0, V1: the middles of side × side cells of the square."""
    v = (np.arange(side) + 0.5) / side
    return np.repeat(v, side), np.tile(v, side)


# Values

@pytest.mark.parametrize("name", ALL)
def test_a_builtin_scene_is_one_value(name):
    from lensbench.core.scenery.builtin.library import builtin_scene

    scene = builtin_scene(name)
    assert scene is builtin_scene(name)
    assert scene == replace(scene) and hash(scene) == hash(replace(scene))
    assert scene != replace(scene, ambient=(0.5, 0.5, 0.5))
    assert 0.0 < scene.depth_range[0] < scene.depth_range[1]


def test_an_unknown_scene_names_the_known_ones():
    with pytest.raises(lb.SceneError, match="still-life, night-lights, focus-ruler, grid-wall, white-wall, room"):
        lb.builtin_scene("stil-life")


@pytest.mark.parametrize("make", [
    lambda: lb.Sphere((0.0, 0.0, 0.0), 0.0), lambda: lb.Sphere((0.0, math.nan, 0.0), 1.0),
    lambda: lb.Sphere((0.0, 0.0, 0.0), math.inf), lambda: lb.Material((1.2, 0.0, 0.0)),
    lambda: lb.Material((-0.1, 0.0, 0.0)), lambda: lb.Material(kind="velvet"), lambda: lb.Material(gloss=0.0),
    lambda: lb.Disk((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1.0), lambda: lb.Disk((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), -1.0),
    lambda: lb.Rectangle((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0)), lambda: lb.Sun((0.0, 0.0, 0.0)),
    lambda: lb.Floor(tile=0.0), lambda: lb.Floor(gloss=2.0), lambda: lb.Sky(zenith=(-1.0, 0.0, 0.0)),
    lambda: lb.Pattern("dots"), lambda: lb.Pattern("image"), lambda: lb.Image(2, 2, b""),
])
def test_what_cannot_be_is_refused(make):
    with pytest.raises(lb.SceneError):
        make()


# What is met first

@pytest.mark.slow
@pytest.mark.parametrize("name", ALL)
def test_the_depth_stages_meet_what_the_textbook_meets(name):
    from lensbench.core.scenery.builtin.library import builtin_scene

    scene = builtin_scene(name)
    o, d = random_rays(4000, spread=0.5)
    depth, hit, _ = shoot(scene.depth_steps(), o, d).T
    reference = scene.distance(o, unit(d))
    assert np.array_equal(hit == 1.0, reference < 1e8)
    near = hit == 1.0
    # both are double; where a ray grazes a sphere the two formulas differ by its root's loss of digits
    assert depth[near] == pytest.approx(reference[near], rel=1e-9)
    assert np.all(depth[~near] >= 1e8)


@pytest.mark.slow
@pytest.mark.parametrize("turn", [0.0, 0.7, 2.6, -1.4])
def test_a_block_skips_nothing_that_one_of_its_rays_meets(turn):
    # blocks of rays in thin fans, as a row of the picture gives, from a camera that looks any way
    scene = lb.builtin_scene("room")
    random = np.random.default_rng(5)
    for pitch in random.uniform(-1.4, 1.4, 12):
        x = np.linspace(-0.4, 0.4, 512)
        y = np.full(512, math.tan(pitch * 0.4)) + random.uniform(0.0, 2e-3, 512)
        d = unit(np.column_stack([x, y, np.full(512, -1.0)]))
        c, s, cp, sp = math.cos(turn), math.sin(turn), math.cos(pitch), math.sin(pitch)
        frame = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ [[1, 0, 0], [0, cp, -sp], [0, sp, cp]]
        d, o = d @ frame.T, random.normal(0.0, 12.0, (512, 3)) @ frame.T
        depth, hit, _ = shoot(scene.depth_steps(), o, d).T
        reference = scene.distance(o, d)
        assert np.where(hit == 1.0, depth, np.inf) == pytest.approx(reference, rel=1e-9)


@pytest.mark.slow
def test_a_block_skips_no_small_sphere_at_its_edge():
    # 400 spheres of 1 to 4 mm before a pupil of 30 mm: many touch a block with a ray or two alone
    random = np.random.default_rng(12)
    slopes = random.uniform(-0.4, 0.4, (400, 2))
    away = np.exp(random.uniform(np.log(150.0), np.log(3000.0), 400))
    balls = tuple(lb.Sphere((float(x * d), float(y * d), -float(d)), float(r))
                  for (x, y), d, r in zip(slopes, away, random.uniform(1.0, 4.0, 400), strict=True))
    scene = lb.Scene("shot", spheres=balls)
    for y in np.linspace(-0.38, 0.38, 24):
        d = unit(np.column_stack([np.linspace(-0.4, 0.4, 512), np.full(512, y), np.full(512, -1.0)]))
        o = random.uniform(-15.0, 15.0, (512, 3))
        depth, hit, _ = shoot(scene.depth_steps(), o, d).T
        # at the very edge of a sphere, half of the digits
        assert np.where(hit == 1.0, depth, np.inf) == pytest.approx(scene.distance(o, d), rel=1e-7)


@pytest.mark.slow
@settings(max_examples=40)
@given(st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=3).filter(lambda v: np.linalg.norm(v) > 1e-3),
       st.floats(1.0, 100.0))
def test_a_sphere_is_met_on_its_surface_and_lit_along_its_normal(towards, radius):
    direction = unit(np.array(towards))
    sphere = lb.Sphere((3.0, -2.0, -500.0), radius, lb.Material((1.0, 1.0, 1.0)))
    sun = lb.Sun(tuple(direction), (1.0, 1.0, 1.0))
    scene = lb.Scene("one", sky=lb.Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3), sun=sun, spheres=(sphere,))
    o, d = np.zeros(3), unit(np.array([3.0, -2.0, -500.0]) + 0.5 * radius * unit(np.array([0.3, 0.9, 0.1])))
    t = scene.distance(o, d)[0]
    normal = (t * d - np.array(sphere.centre)) / radius
    assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-8)     # of 500² against 1² in double
    # Lambert's cosine, irradiance / π times albedo
    assert shoot(scene.steps(shadows=False), o, d)[0] == pytest.approx(max(0.0, normal @ direction), abs=1e-6)


@pytest.mark.slow
def test_a_spheres_picture_has_the_size_of_its_tangent_cone():
    distance, radius = 1000.0, 100.0
    scene = lb.Scene("one", spheres=(lb.Sphere((0.0, 0.0, -distance), radius),))
    edge = math.asin(radius / distance)
    angles = np.array([edge - 1e-6, edge + 1e-6])
    d = np.column_stack([np.sin(angles), np.zeros(2), -np.cos(angles)])
    assert list(shoot(scene.depth_steps(), np.zeros(3), d)[:, 1]) == [1.0, 0.0]


@pytest.mark.slow
def test_the_floor_is_checkered_every_tile():
    scene = lb.Scene("one", sky=lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3),
                     floor=lb.Floor(-100.0, 50.0, (0.8,) * 3, (0.2,) * 3))
    i, k = np.meshgrid(np.arange(-6, 6), np.arange(1, 9), indexing="ij")
    points = np.column_stack([(i.ravel() + 0.5) * 50.0, np.full(i.size, -100.0), -(k.ravel() + 0.5) * 50.0])
    seen = shoot(scene.steps(shadows=False), np.zeros(3), points)[:, 0]
    odd = (i.ravel() + k.ravel()) % 2
    assert len(np.unique(seen[odd == 0].round(6))) == 1 and len(np.unique(seen[odd == 1].round(6))) == 1
    assert sorted({seen[odd == 0][0].round(6), seen[odd == 1][0].round(6)}) == pytest.approx([0.2, 0.8], abs=1e-6)


def test_the_sky_has_its_three_colours_and_is_between_two_of_them_by_the_height():
    sky = lb.Sky((0.1, 0.3, 0.9), (0.8, 0.5, 0.2), (0.05, 0.06, 0.07))
    d = random_rays(200, 3)[1]
    d = unit(np.vstack([d, -d, [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]]]))
    seen = shoot(lb.Scene("sky", sky=sky).steps(), 0.0, d)
    zenith, horizon = np.array(sky.zenith), np.array(sky.horizon)
    height = d[:, 1:2]
    wanted = np.where(height < 0.0, sky.ground, horizon * (1.0 - height) + zenith * height)
    np.testing.assert_allclose(seen, wanted, rtol=1e-12)


def patterned(kind, **values):
    wall = lb.Rectangle((0.0, 0.0, -1000.0), (100.0, 0.0, 0.0), (0.0, 60.0, 0.0),
                        lb.Material((0.75,) * 3, "light", pattern=lb.Pattern(kind, (0.25,) * 3, **values)))
    return lb.Scene("wall", sky=lb.Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3), plates=(wall,))


def wall_points(n=3000, seed=3):
    random = np.random.default_rng(seed)
    return random.uniform(-1.0, 1.0, (n, 2)) * (100.0, 60.0)


def look_at_wall(scene, points):
    return shoot(scene.steps(), np.zeros(3), np.column_stack([points, np.full(len(points), -1000.0)]))[:, 0]


@pytest.mark.slow
def test_a_star_changes_colour_at_equal_angles():
    points = wall_points()
    angle = np.degrees(np.arctan2(points[:, 1] / 60.0, points[:, 0] / 100.0)) % 360.0
    inside = abs(angle / 15.0 - np.round(angle / 15.0)) > 1e-3      # the polynomial's arc tangent is good to 1e-5
    wanted = np.where((angle // 15.0) % 2 == 1, 0.25, 0.75)
    assert look_at_wall(patterned("star", columns=12.0), points)[inside] == pytest.approx(wanted[inside])


@pytest.mark.slow
def test_a_checker_and_a_grid_lie_where_their_numbers_say():
    points = wall_points()
    x, y = points[:, 0] + 100.0, points[:, 1] + 60.0
    wanted = np.where((x // 25.0 + y // 30.0) % 2 == 1, 0.25, 0.75)
    assert look_at_wall(patterned("checker", columns=8.0, rows=4.0), points) == pytest.approx(wanted)
    # 8 × 4 cells between lines 4 mm wide, the outermost whole: line centres every 24.5 and 29 mm from 2 mm on
    off_x, off_y = ((x - 2.0) + 12.25) % 24.5 - 12.25, ((y - 2.0) + 14.5) % 29.0 - 14.5
    wanted = np.where(np.minimum(abs(off_x), abs(off_y)) <= 2.0, 0.25, 0.75)
    assert look_at_wall(patterned("grid", columns=8.0, rows=4.0, line=4.0), points) == pytest.approx(wanted)


@pytest.mark.slow
def test_a_ruler_has_a_tick_every_millimetre():
    scene = patterned("ruler", columns=10.0, line=0.2)
    ticks = np.column_stack([np.arange(-99.0, 100.0), np.full(199, -59.0)])
    assert look_at_wall(scene, ticks) == pytest.approx(0.25)
    assert look_at_wall(scene, ticks + (0.5, 0.0)) == pytest.approx(0.75)
    high = look_at_wall(scene, ticks + (0.0, 8.0))          # 9 mm up, only every tenth is left
    assert np.flatnonzero(high < 0.5).tolist() == list(range(9, 199, 10))


@pytest.mark.slow
def test_an_image_shows_its_texels_upright_and_is_linear_between():
    values = np.random.default_rng(2).random((4, 5, 3))
    image = lb.Pattern("image", image=lb.Image.of(values))
    wall = lb.Rectangle((0.0, 0.0, -1000.0), (50.0, 0.0, 0.0), (0.0, 40.0, 0.0), lb.Material((1.0,) * 3, "light",
                                                                                             pattern=image))
    scene = lb.Scene("wall", plates=(wall,))
    row, column = np.mgrid[0:4, 0:5]
    middles = np.column_stack([-40.0 + 20.0 * column.ravel(), 30.0 - 20.0 * row.ravel(), np.full(20, -1000.0)])
    assert shoot(scene.steps(), np.zeros(3), middles) == pytest.approx(values.reshape(-1, 3), abs=1e-6)
    between = shoot(scene.steps(), np.zeros(3), [(-30.0, 20.0, -1000.0)])[0]
    assert between == pytest.approx(values[:2, :2].mean((0, 1)), abs=1e-6)
    corner = shoot(scene.steps(), np.zeros(3), [(-49.9, 39.9, -1000.0)])[0]
    assert corner == pytest.approx(values[0, 0], abs=1e-6)


# No number is lost

@pytest.mark.parametrize("real", [np.float32, pytest.param(np.float64, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", ALL)
def test_no_ray_gives_anything_but_a_finite_radiance(name, real):
    from lensbench.core.scenery.builtin.library import builtin_scene

    scene = builtin_scene(name)
    axes = np.array([(x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (x, y, z) != (0, 0, 0)])
    origins = np.array([(0, 0, 0), (0, -250, 0), (0, -1150, -900), (100, 200, -3000)], float)
    random = np.random.default_rng(1)
    o = np.concatenate([np.repeat(origins, len(axes), 0), random.uniform(-2000, 2000, (4000, 3))])
    d = np.concatenate([np.tile(axes, (len(origins), 1)), random.normal(0, 1, (4000, 3))])
    edge = 1.0 - 2.0**-24                               # the greatest sample that the sampler gives
    v = random.choice([0.0, 0.5, edge], (2, len(o)))
    seen = shoot(scene.steps(), o, d, v, real)
    assert np.all(np.isfinite(seen)) and np.all(seen >= 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("name", ALL)
def test_float32_shows_what_float64_shows(name):
    from lensbench.core.scenery.builtin.library import builtin_scene

    scene = builtin_scene(name)
    o, d = random_rays(6000, seed=7, spread=0.35)
    v = np.random.default_rng(8).random((2, 6000))
    single, double = shoot(scene.steps(), o, d, v, np.float32), shoot(scene.steps(), o, d, v)
    # an edge falls to the other side, or a mirrored ray finds another light, for a few rays in a thousand
    apart = np.any(abs(single - double) > 2e-3 + 0.01 * double, 1)
    assert np.mean(apart) < 0.012


def test_a_wall_far_away_has_no_acne_and_no_light_comes_through_it():
    # the sun stands before the wall at 100 m, and behind a second wall
    for distance in (500.0, 8000.0, 100e3):
        wide = distance
        wall = lb.Rectangle((0.0, 0.0, -distance), (wide, 0.0, 0.3 * wide), (0.0, wide, 0.0), lb.Material((1.0,) * 3))
        dark = lb.Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3)
        scene = lb.Scene("wall", sky=dark, sun=lb.Sun((0.05, 0.3, 1.0), (1.0,) * 3, 1e-4), plates=(wall,))
        o, d = random_rays(4000, spread=0.3)
        v = np.random.default_rng(1).random((2, 4000))
        seen = shoot(scene.steps(), o, d, v, np.float32)[:, 0]
        normal, sun = unit(np.array([-0.3, 0.0, 1.0])), unit(np.array([0.05, 0.3, 1.0]))
        assert seen == pytest.approx(normal @ sun, abs=2e-4)
        behind = lb.Scene("wall", sky=dark, sun=lb.Sun((0.05, 0.3, -1.0), (1.0,) * 3, 1e-4), plates=(wall,))
        assert np.all(shoot(behind.steps(), o, d, v, np.float32) == 0.0)


@pytest.mark.slow
def test_radiance_along_own_rays_is_that_of_the_pictures():
    scene = lb.builtin_scene("focus-ruler")
    camera = lb.PerspectiveCamera(lb.Film(36.0, 24.0, 60, 40), 0.6, weights="one")
    place, places = np.random.default_rng(0), np.stack(np.mgrid[0:60, 0:40], -1).reshape(-1, 2)
    samples = [scene.radiance(camera.generate_rays(places + place.random(places.shape), np.full(places.shape, 0.5)),
                              samples=1, seed=seed) for seed in range(8)]
    rendering = lb.Rendering(camera, scene, light_tracing=False)
    rendering.add(32)
    assert np.mean(samples) == pytest.approx(rendering.image().mean(), rel=0.01)
    sky = lb.Scene(sky=lb.Sky((1.0, 2.0, 3.0), (1.0, 2.0, 3.0), (1.0, 2.0, 3.0)))
    np.testing.assert_allclose(sky.radiance([0, 0, 0], [0.0, 0.0, -7.0]), [[1.0, 2.0, 3.0]])
    blocked = lb.Rays(np.full((1, 3), np.nan), np.zeros((1, 3)), np.zeros(1), np.zeros(1))
    assert (sky.radiance(blocked) == 0.0).all()


@pytest.mark.parametrize("arguments, message", [
    (([0, 0, 0], [0, 0, 0]), "length 0"), (([0, 0, math.nan], [0, 0, 1]), "finite"), (([0, 0], [0, 0]), "n, 3"),
    ((5,), "rays of a camera"), (([0, 0, 0], [0, 0, 1], 0.0, 0), "at least 1")])
def test_what_is_no_ray_has_no_radiance(arguments, message):
    with pytest.raises(ValueError, match=message):
        lb.Scene().radiance(*arguments)


def test_a_scene_takes_lists_of_its_shapes():
    ball = lb.Sphere((0.0, 0.0, -500.0), 50.0)
    assert lb.Scene(spheres=[ball]) == lb.Scene(spheres=(ball,)) and hash(lb.Scene(spheres=[ball]))
    with pytest.raises(lb.SceneError, match="spheres of a scene: Rectangle"):
        lb.Scene(spheres=[lb.Rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0))])


def test_a_surface_that_is_not_described_is_a_grey_that_reflects_half():
    assert lb.Material() == lb.Material((0.5, 0.5, 0.5), "matte")


@pytest.mark.parametrize("real", [np.float32, pytest.param(np.float64, marks=pytest.mark.slow)])
def test_the_tiles_of_a_floor_have_its_two_colours(real):
    light, dark = (0.9, 0.5, 0.2), (0.1, 0.3, 0.05)
    scene = lb.Scene("floor", sky=lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3), floor=lb.Floor(-200.0, 40.0, light, dark))
    tiles = 40.0 * (np.arange(-4, 4) + 0.5)
    points = np.stack([*np.meshgrid(tiles, tiles), np.full((8, 8), -200.0)], -1)[..., [0, 2, 1]]
    seen = shoot(scene.steps(shadows=False), 0.0, points, real=real).reshape(8, 8, 3)
    found = [seen[i::2, j::2] for i in (0, 1) for j in (0, 1)]
    if found[0][0, 0, 0] < 0.5:
        found = [found[k] for k in (1, 0, 3, 2)]
    for part, colour in zip(found, (light, dark, dark, light), strict=True):
        np.testing.assert_allclose(part, np.broadcast_to(colour, part.shape), atol=2e-6)
