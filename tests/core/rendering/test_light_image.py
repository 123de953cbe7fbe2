"""Light tracing gives the picture of the camera's rays, with less noise."""

import math
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.kernels.block import B
from lensbench.core.rendering import light_image
from lensbench.core.rendering.entrance_bounds import COLUMNS, RIM, ROWS, entrance_bounds
from lensbench.core.scenery.objects.basic_shapes import Disk, Rectangle, Sphere
from lensbench.core.scenery.objects.material import Image, Material, Pattern
from lensbench.core.scenery.objects.surroundings import Sky
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.small_lights import samples_of, small_lights, split_light

BLACK = (0.0, 0.0, 0.0)
DARK = Sky(BLACK, BLACK, BLACK)
FILM = lb.Film(36.0, 24.0, 90, 60)
MODELS = ("trace", "polynomial", "thick", "thin", "pinhole", "perspective", "bladed trace", "bladed thin")


def bright(colour=(40.0, 30.0, 20.0)):
    return Material(colour, "light")


def view(model, lens="pbrt-dgauss-50mm", focus=1500.0, f_number=2.0, film=FILM, **more):
    if model == "perspective":
        return lb.PerspectiveCamera(film, fov=0.45, lens_radius=12.0, focus_distance=focus, **more)
    design = lenses.load(lens)
    if model.startswith("bladed "):
        model, f_number = model.removeprefix("bladed "), None       # wide open, the corners on the rim
        design = replace(design, blades=5, blade_rotation=0.3, blade_reach=1.0)
    return lb.LensCamera(design, film, focus, f_number, model=model, **more)


def add_own(rendering, passes):
    """Add samples until so many passes have traced lights, with the period that the picture chooses."""
    while rendering._light_image._passes < passes:
        rendering.add(8)


def both(camera, scene, samples, own):
    """The picture with light tracing and the one by the camera's rays alone; the objects whose light is traced.

    own: passes that trace lights.
    """
    traced, plain = lb.Rendering(camera, scene, seed=5), lb.Rendering(camera, scene, seed=6, light_tracing=False)
    add_own(traced, own)
    plain.add(samples)
    return traced.image().astype(float), plain.image().astype(float), traced.light_traced


def binned(picture, size=6):
    h, w, _ = picture.shape
    return picture.reshape(h // size, size, w // size, size, 3).mean((1, 3))


@pytest.mark.slow
@pytest.mark.parametrize("model", MODELS)
def test_a_small_light_gives_the_picture_that_the_cameras_rays_find(model):
    """Three spheres: behind the plane in focus off the axis, beyond the corner's vignetting, and in focus.

    Some 1e5 of the camera's rays find a light: a noise of 0.3 % at the most, less by the net.
    """
    size, far = (20.0 if model == "pinhole" else 110.0), 12000.0
    scene = Scene("lights", sky=DARK, spheres=(
        Sphere((900.0, 700.0, -far), size, bright()), Sphere((-3100.0, 2000.0, -far), size, bright()),
        Sphere((-120.0, -100.0, -1440.0), 3.0, bright())))
    traced, plain, lights = both(view(model), scene, 8192, 64)
    assert lights == {0, 1, 2}
    assert traced.sum((0, 1)) == pytest.approx(plain.sum((0, 1)), rel=3e-3)
    a, b = binned(traced), binned(plain)
    assert np.abs(a - b).max() < 0.03 * b.max()
    assert (a[b == 0.0] < 0.01 * b.max()).all()


def through_the_front(camera, point, steps=240):
    """Rays from a point of the camera frame over the first surface, on a grid, by the scalar tracer.

    Where they cross the plane of the first vertex (n, 2), unit directions, which pass, and the étendue of each for a
    light of the area 1 that faces it.
    """
    lens = camera.lens
    end = lens.length + camera.film_distance
    first = lens.surfaces[0]
    reach = first.semi_diameter + abs(float(first.sag(first.semi_diameter)))
    at = (np.arange(steps) + 0.5) / steps * 2.0 * reach - reach
    aims = np.stack([*np.meshgrid(at, at), np.zeros((steps, steps))], 2).reshape(-1, 3)
    origin = np.asarray(point) + [0.0, 0.0, end]
    way = aims - origin
    far = np.linalg.norm(way, axis=1)
    way /= far[:, None]
    passed = lb.trace(lens, origin, way).fate == lb.Fate.PASSED
    return aims[:, :2], way, passed, way[:, 2] / far**2 * (2.0 * reach / steps) ** 2


def test_the_rim_of_the_rectangle_has_all_of_its_cells_that_have_no_cell_beyond():
    assert np.pad(np.zeros((ROWS - 2, COLUMNS - 2), int), 1, constant_values=1).sum() == RIM


@pytest.mark.slow
@pytest.mark.parametrize(("name", "f_number", "angles"), [
    ("pbrt-dgauss-50mm", None, (0.0, 8.0, 18.0, 22.0)), ("pbrt-dgauss-50mm", 16.0, (0.0, 20.0)),
    ("pbrt-fisheye-10mm", None, (0.0, 30.0, 60.0)), ("pbrt-wide-22mm", None, (10.0, 35.0)),
    ("lib-petzval-portrait", None, (0.0, 9.0, 13.0)), ("lib-us10281683", None, (0.0, 15.0))])
def test_no_light_that_would_pass_the_lens_misses_the_rectangle_before_it(name, f_number, angles):
    """Of what the scalar tracer brings through from the middle and the rims of a light, less than 0.05 %."""
    camera = view("trace", name, 3000.0, f_number)
    landing = camera.film_landing()
    for angle in np.radians(angles):
        turn = 0.7 if angle > 0.0 else 0.0
        middle = 8000.0 * np.array([math.sin(angle) * math.cos(turn), math.sin(angle) * math.sin(turn),
                                    -math.cos(angle)])
        front = entrance_bounds(landing, middle[None], np.array([40.0]))
        assert front.passing[0] > 0.2
        for offset in ((0.0, 0.0), (40.0, 0.0), (0.0, -40.0), (-40.0, 0.0)):
            point = middle + [*offset, 0.0]
            cross, directions, passed, _ = through_the_front(camera, point)
            assert passed.sum() > 100
            start = np.column_stack([cross, np.full(len(cross), landing.front[2])])[passed]
            w, d = front.towards[0], directions[passed]
            on_plane = start + d * (((front.middles[0] - start) @ w) / (d @ w))[:, None]
            a, b = ((on_plane - front.middles[0]) @ axis / (axis @ axis) for axis in front.axes[0])
            assert ((abs(a) > 1.0) | (abs(b) > 1.0)).mean() < 5e-4


@pytest.mark.slow
@pytest.mark.parametrize(("name", "angle"), [("pbrt-dgauss-50mm", 0.0), ("pbrt-dgauss-50mm", 14.0),
                                             ("pbrt-fisheye-10mm", 50.0), ("pbrt-wide-22mm", 25.0),
                                             ("lib-petzval-portrait", 4.0)])
def test_the_light_on_the_film_is_what_the_scalar_tracer_brings_through_the_lens(name, angle):
    """Radiance · étendue / (area of a pixel) · z² / normaliser, summed over the picture.

    The grid of the oracle leaves a part in a thousand of the rim uncertain, less by the sum over it.
    """
    camera = view("trace", name, 3000.0, None, film=lb.Film(36.0, 24.0, 150, 100), dispersion=False)
    a = math.radians(angle)
    middle = 9000.0 * np.array([math.sin(a) * 0.8, math.sin(a) * 0.6, -math.cos(a)])
    disk = Disk(tuple(middle), tuple(middle), 6.0, bright((2000.0,) * 3))
    scene = Scene("light", sky=DARK, plates=(disk,))
    traced = lb.Rendering(camera, scene)
    add_own(traced, 64)
    assert traced.light_traced == {0}
    _, _, passed, étendue = through_the_front(camera, middle, 1200)
    pixel = 36.0 / 150 * 24.0 / 100
    expected = 2000.0 * math.pi * 6.0**2 * étendue[passed].sum() / pixel * (
        camera.film_distance**2 / camera.axis_irradiance)
    assert traced.image().astype(float).sum((0, 1)) == pytest.approx(np.full(3, expected), rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("model", ["trace", "thin"])
def test_an_edge_before_a_light_cuts_its_disk_where_the_cameras_rays_see_it_cut(model):
    light = Sphere((150.0, 100.0, -9000.0), 80.0, bright())
    hidden = replace(light, centre=(-1500.0, 900.0, -9000.0))
    edge = Rectangle((350.0 + 62.0, 100.0, -4500.0), (340.0, 0.0, 0.0), (0.0, 300.0, 0.0), Material((0.0, 0.0, 0.0)))
    wall = Rectangle((-750.0, 450.0, -4500.0), (90.0, 0.0, 0.0), (0.0, 90.0, 0.0), Material((0.0, 0.0, 0.0)))
    scene = Scene("edge", sky=DARK, spheres=(light, hidden), plates=(edge, wall))
    open_scene = replace(scene, plates=())
    traced, plain, lights = both(view(model), scene, 4096, 64)
    assert 0 in lights
    uncut = lb.Rendering(view(model), replace(open_scene, spheres=(light,)))
    uncut.add(64)
    part = traced.sum() / uncut.image().astype(float).sum()
    assert 0.2 < part < 0.8
    assert traced.sum() == pytest.approx(plain.sum(), rel=4e-3)
    assert np.abs(binned(traced) - binned(plain)).max() < 0.03 * binned(plain).max()


@pytest.mark.slow
def test_no_light_is_counted_twice_in_mirrors_glass_and_coats():
    """A light seen at first hand, in a metal mirror, through a glass ball and in a coat, over a lamp that lights."""
    lamp = Sphere((300.0, 380.0, -6000.0), 25.0, Material((60.0, 60.0, 60.0), "lamp"))
    scene = Scene("mirrors", sky=Sky((0.1,) * 3, (0.1,) * 3, (0.1,) * 3), spheres=(
        lamp, Sphere((-150.0, 60.0, -1500.0), 90.0, Material((0.99,) * 3, "glass")),
        Sphere((150.0, -120.0, -1500.0), 60.0, Material((0.3,) * 3, "coat"))), plates=(
        Rectangle((0.0, -350.0, -3000.0), (900.0, 0.0, 0.0), (0.0, 0.0, -1500.0), Material((0.9,) * 3, "metal")),))
    traced, plain, lights = both(view("trace"), scene, 8192, 256)
    assert 0 in lights
    assert traced.sum() == pytest.approx(plain.sum(), rel=2e-3)
    a, b = binned(traced), binned(plain)
    assert np.abs(a - b).max() < 0.04 * b.max()


@pytest.mark.slow
def test_every_channel_of_a_lens_that_disperses_has_its_own_wavelengths():
    lens = lb.Lens((lb.Surface(25.0, 2.5, curvature=0.0), lb.Surface(3.0, 12.0, lb.Glass(1.62, 36.4),
                                                                     curvature=-1 / 60.0),
                    lb.Surface(0.0, 12.0, curvature=-1 / 22.5)), 0)
    camera = lb.LensCamera(lens, lb.Film(3.0, 2.0, 150, 100), 1500.0)
    assert camera.disperses
    scene = Scene("lamp", sky=DARK, spheres=(Sphere((12.0, 8.0, -6000.0), 3.0, bright((100.0,) * 3)),))
    traced, plain, lights = both(camera, scene, 2049, 65)
    assert lights == {0}
    assert traced.sum((0, 1)) == pytest.approx(plain.sum((0, 1)), rel=1e-2)
    for c in range(3):
        spread = []
        for picture in (traced[..., c], plain[..., c]):
            y, x = np.mgrid[0:100, 0:150]
            share = picture / picture.sum()
            spread.append([(share * x).sum(), (share * y).sum(), (share * (x - (share * x).sum()) ** 2).sum()])
        assert spread[0] == pytest.approx(spread[1], rel=0.02)


@pytest.mark.slow
def test_the_film_is_the_same_bit_for_bit_for_any_number_of_threads_and_in_whatever_portions():
    scene = lb.builtin_scene("night-lights")
    pictures = []
    for threads, portions in ((1, (3,)), (2, (1, 2)), (5, (2, 1))):
        rendering = lb.Rendering(view("trace"), scene, seed=7)
        for samples in portions:
            assert rendering.add(samples, threads=threads)
        pictures.append(rendering.image())
    assert len(rendering.light_traced) > 20
    assert np.array_equal(pictures[0], pictures[1]) and np.array_equal(pictures[0], pictures[2])


def test_lights_that_the_cameras_rays_find_well_are_left_to_them():
    large = Sphere((100.0, 50.0, -1500.0), 60.0, bright())
    scene = Scene("large", sky=DARK, spheres=(large,))
    camera = view("trace", f_number=8.0)
    rendering = lb.Rendering(camera, scene)
    assert rendering.light_traced == frozenset()
    rendering.add(2)
    alone = lb.Rendering(camera, scene, light_tracing=False)
    alone.add(2)
    assert np.array_equal(rendering.image(), alone.image())


def test_no_light_is_traced_behind_the_camera_beside_the_film_or_while_the_camera_moves():
    lights = tuple(Sphere(centre, 20.0, bright()) for centre in ((0.0, 0.0, 9000.0), (8000.0, 0.0, -3000.0)))
    assert lb.Rendering(view("trace"), Scene("away", sky=DARK, spheres=lights)).light_traced == frozenset()
    scene = Scene("one", sky=DARK, spheres=(Sphere((0.0, 100.0, -9000.0), 20.0, bright()),))
    assert lb.Rendering(view("trace"), scene).light_traced == {0}
    later = np.eye(4)
    later[0, 3] = 30.0
    moved = view("trace", world_from_camera=lb.AnimatedTransform(np.eye(4), later))
    assert lb.Rendering(moved, scene).light_traced == frozenset()


def test_a_small_picture_traces_lights_in_few_passes_after_the_first_ones(monkeypatch):
    """Where each light takes more rays than its picture needs, they stay below those of the camera."""
    camera, rays = view("trace", focus=1200.0, f_number=2.8, film=lb.Film(32.0, 18.0, 120, 68)), []
    list_rays = light_image._list_rays

    def counted(found, lanes, code, light, first, blocks, *rest):
        rays.append(blocks * B)
        return list_rays(found, lanes, code, light, first, blocks, *rest)

    monkeypatch.setattr(light_image, "_list_rays", counted)
    rendering = lb.Rendering(camera, lb.builtin_scene("still-life"), seed=1)
    of_each = []
    for _ in range(4):
        rendering.add(1, threads=1)
        of_each.append(sum(rays) - sum(of_each))
    assert min(of_each) > 5 * 120 * 68                  # nothing is missing in the first pictures
    rendering.add(124, threads=1)
    assert sum(rays) < 128 * 120 * 68


def test_few_passes_with_lights_make_the_light_of_many():
    camera, scene = view("trace"), lb.builtin_scene("still-life")
    few, many = (lb.Rendering(camera, scene, light_passes=passes) for passes in (1, None))
    few.add(8), many.add(8)
    assert few._light_image._passes == 1 and many._light_image._passes > 1
    sums = [rendering._light_image.image().sum() for rendering in (few, many)]
    assert sums[0] == pytest.approx(sums[1], rel=0.01)


@pytest.mark.slow
def test_a_cancelled_rendering_with_small_lights_stops():
    rendering = lb.Rendering(view("trace"), lb.builtin_scene("night-lights"))
    calls = []

    def wanted():
        calls.append(0)
        return len(calls) < 5

    assert not rendering.add(1, wanted=wanted, threads=2)
    assert len(calls) <= 5 + 2


def test_a_camera_away_from_the_origin_sees_the_same_light():
    """The camera turned and shifted together with the scene takes the same picture, but for float32."""
    place = np.eye(4)
    place[:3, :3] = [[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]]
    place[:3, 3] = [2000.0, -300.0, 500.0]
    here = np.array([300.0, 200.0, -9000.0])
    there = tuple(place[:3, :3] @ here + place[:3, 3])
    pictures = [lb.render(view("trace", world_from_camera=matrix), Scene("s", sky=DARK, spheres=(
        Sphere(centre, 25.0, bright()),)), samples=16) for matrix, centre in ((np.eye(4), tuple(here)), (place, there))]
    assert pictures[0].sum() == pytest.approx(pictures[1].sum(), rel=1e-4)
    assert np.abs(binned(pictures[0]) - binned(pictures[1])).max() < 0.01 * binned(pictures[0]).max()


@pytest.mark.slow
def test_the_windows_of_a_house_are_lights_of_their_own_and_the_wall_is_left_to_the_camera():
    """The picture on a plate is split into bright patches and the rest; the two add up to it."""
    values = np.full((24, 32, 3), 0.02)
    values[1::6, 2::8] = (30.0, 20.0, 10.0)
    values[2::6, 3::8] = (10.0, 20.0, 30.0)
    wall = Rectangle((1500.0, 900.0, -50000.0), (4000.0, 300.0, 0.0), (-225.0, 3000.0, 0.0), Material(
        (1.0, 1.0, 1.0), "light", pattern=Pattern("image", image=Image.of(values))))
    lights = small_lights((wall,))
    assert len(lights) == 16
    left, alone = split_light((wall,), tuple(lights[3:]))
    parts = [plate.material.pattern.image.values for plate in (*left, *alone)]
    np.testing.assert_array_equal(sum(parts), wall.material.pattern.image.values)
    assert parts[1].max() == 30.0 and (parts[0] > 1.0).any(2).sum() == 6       # three windows of two texels are left
    traced, plain, found = both(view("trace", focus=1000.0), Scene("house", sky=DARK, plates=(wall,)), 4096, 64)
    assert found == {0}
    assert traced.sum((0, 1)) == pytest.approx(plain.sum((0, 1)), rel=3e-3)
    assert np.abs(binned(traced) - binned(plain)).max() < 0.03 * binned(plain).max()


def test_the_points_of_a_light_are_its_own_light():
    """Moments over the points against those of the disk, of the square, and of a picture's tent from a single texel."""
    values = np.zeros((9, 9, 3))
    values[4, 4] = (6.0, 3.0, 1.0)
    tent = Rectangle((0.0, 0.0, -9e4), (90.0, 0.0, 0.0), (0.0, 90.0, 0.0), Material(
        (1.0, 0.5, 1.0), "light", pattern=Pattern("image", image=Image.of(values))))
    square = replace(tent, material=bright((6.0, 1.5, 1.0)))
    for thing, second, mean in ((Sphere((0.0, 0.0, -9e4), 9.0, bright((6.0, 1.5, 1.0))), 1 / 4, 1.0),
                                (square, 1 / 3, 1.0), (tent, 1 / 6, 1 / 4)):
        (light,) = small_lights((thing,))
        points = samples_of(thing, light)
        for colour, radiance in zip(points[:, 2:].T, (6.0, 1.5, 1.0), strict=True):
            assert colour.mean() == pytest.approx(radiance * mean, rel=1e-6)
            for axis in (0, 1):                         # 64 points: the mean to 1/64, the second moment likewise
                assert (points[:, axis] * colour).mean() == pytest.approx(0.0, abs=0.02 * radiance)
                assert (points[:, axis] ** 2 * colour).mean() == pytest.approx(second * mean * radiance, rel=0.06)
    # The points of the picture, which is even, lie in steps that are even too: as far to the right as to the left
    for axis in (0, 1):
        places = np.unique(points[:, axis].round(9))
        sums = (places + places[0]) / np.diff(places).min()
        np.testing.assert_allclose(sums, sums.round(), atol=1e-5)


def test_the_disk_of_a_light_with_a_size_of_its_own_is_as_even_as_that_of_a_point():
    """One ray represents many, whose places on the light are spread together with those before the lens."""
    unevenness = []
    for size in (3e-4, 4e-3):
        scene = Scene("one", sky=DARK, spheres=(Sphere((1200.0, 1000.0, -20000.0), size * 20000.0, bright()),))
        pictures = []
        for seed in range(12):
            rendering = lb.Rendering(view("perspective", film=lb.Film(36.0, 24.0, 240, 160)), scene, seed=seed)
            rendering.add(1)
            pictures.append(rendering.image()[..., 0].astype(float))
        mean = np.mean(pictures, 0)
        unevenness.append(np.std(pictures, 0)[mean > 0.8 * mean.max()].mean() / mean.max())
    assert unevenness[1] < unevenness[0] < 0.2


def test_a_picture_without_patches_that_lie_apart_is_no_small_light():
    random = np.random.default_rng(3)
    wall = Rectangle((0.0, 0.0, -9000.0), (300.0, 0.0, 0.0), (0.0, 300.0, 0.0), Material(
        (1.0, 1.0, 1.0), "light", pattern=Pattern("image", image=Image.of(random.uniform(0.0, 9.0, (16, 16, 3))))))
    assert small_lights((wall,)) == []


@pytest.mark.slow
def test_a_picture_with_borrowed_light_becomes_its_own_bit_for_bit():
    scene = lb.builtin_scene("night-lights")
    before, camera = (view("polynomial", focus=focus, degree=5) for focus in (1400.0, 1500.0))
    lender = lb.Rendering(before, scene, seed=5)
    lender.add(1)
    own, borrowing = lb.Rendering(camera, scene, seed=5), lb.Rendering(camera, scene, seed=5, layer=lender.layer())
    borrowing.add(1)
    assert borrowing.is_borrowing and borrowing.light().any()
    with ThreadPoolExecutor(2) as pool:
        borrowing.adopt(borrowing.own_light(pool, 2))
    own.add(1)
    if not borrowing.samples:
        borrowing.add(1)
    np.testing.assert_array_equal(borrowing.image(), own.image())
    for rendering in (own, borrowing):
        rendering.add(5)
    np.testing.assert_array_equal(borrowing.image(), own.image())


@pytest.mark.parametrize(("focus", "turn"), [
    (900.0, 0.0), (1300.0, 0.0), (1800.0, 0.0), (4000.0, 0.0), (1500.0, 0.04)])
def test_a_borrowed_light_has_the_place_the_size_and_the_light_of_its_own(focus, turn):
    lamp = Scene("one", sky=DARK, spheres=(Sphere((80.0, -50.0, -5000.0), 2.0, bright()),))
    film = lb.Film(36.0, 24.0, 360, 240)
    before = view("thin", film=film)
    there = lb.look_at((0.0, 0.0, 0.0), (100.0 * turn, 0.0, -100.0))
    camera = view("thin", focus=focus, film=film, world_from_camera=there)
    lender, own = lb.Rendering(before, lamp), lb.Rendering(camera, lamp)
    lender.add(1)
    borrowing = lb.Rendering(camera, lamp, layer=lender.layer())
    y, x = np.mgrid[0:240, 0:360]
    figures = []
    for rendering in (own, borrowing):
        rendering.add(1)
        light = rendering.light()[..., 0]
        total = light.sum()
        middle = (light * x).sum() / total, (light * y).sum() / total
        spread = np.sqrt((light * ((x - middle[0]) ** 2 + (y - middle[1]) ** 2)).sum() / total)
        figures.append((total, *middle, spread))
    np.testing.assert_allclose(figures[1][0], figures[0][0], rtol=0.02)
    np.testing.assert_allclose(figures[1][1:], figures[0][1:], atol=0.35)       # pixels; a sharp one is one pixel


@pytest.mark.slow
def test_lights_traced_to_a_tilted_film_bring_what_the_camera_gathers():
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), lb.Film(36.0, 24.0, 45, 30), 1200.0, 4.0,
                           film_pose=lb.FilmPose(0.17, -0.1, 2.0, 1.0))
    scene, pictures = lb.load_scene("still-life"), []
    for traced, samples in ((True, 512), (False, 4096)):
        made = lb.Rendering(camera, scene, light_tracing=traced)
        made.add(samples)
        pictures.append(np.asarray(made.image()))
    assert pictures[0].mean() == pytest.approx(pictures[1].mean(), rel=2e-3)
    assert pictures[0][:12].mean() == pytest.approx(pictures[1][:12].mean(), rel=4e-3)      # the string of lights


ALONE = """
import hashlib, sys
import lensbench as lb
from numba import float32, int64
from lensbench.core.rendering import light_rays

if sys.argv[1] == "alone":
    for part in (light_rays._find_path_plane, light_rays._aim_at_ball):
        part.compile((float32[::1], float32[::1], int64))
camera = lb.PerspectiveCamera(lb.Film(36.0, 24.0, 90, 60), lens_radius=12.0, focus_distance=1200.0)
rendering = lb.Rendering(camera, lb.builtin_scene("still-life"), seed=7)
rendering.add(2)
print(hashlib.sha256(rendering.light().tobytes()).hexdigest())
"""


@pytest.mark.slow
def test_light_has_the_same_bits_in_a_process_that_compiled_the_parts_of_its_stages_by_themselves():
    """LLVM takes a function of another kernel for its own copy, which is rounded otherwise, unless it is inlined."""
    assert len({subprocess.run([sys.executable, "-c", ALONE, how], capture_output=True, text=True, check=True).stdout
                for how in ("alone", "within")}) == 1


def test_patches_that_mirror_each_other_in_a_picture_are_lights_that_do():
    values = np.full((24, 40, 3), 0.01)
    values[3:6, 4:9] = values[3:6, 31:36] = values[18:21, 4:9] = values[18:21, 31:36] = 9.0
    wall = Rectangle((700.0, -300.0, -50000.0), (400.0, 30.0, 0.0), (-22.5, 300.0, 0.0), Material(
        (1.0, 1.0, 1.0), "light", pattern=Pattern("image", image=Image.of(values))))
    lights = small_lights((wall,))
    assert len(lights) == 4
    offsets = np.array([light.centre for light in lights]) - wall.centre
    along = np.stack([offsets @ axis / np.dot(axis, axis) for axis in wall.half_axes], 1)
    assert np.abs(along).min() > 0.5
    np.testing.assert_allclose(np.abs(along), np.broadcast_to(np.abs(along[0]), (4, 2)), rtol=1e-12)
    # half-axes of a part of a picture that light from the middles of the texels beside it reaches
    for light in lights:
        np.testing.assert_allclose(light.right, np.multiply(wall.half_axes[0], 6.0 / 40.0), rtol=1e-12)
        np.testing.assert_allclose(light.up, np.multiply(wall.half_axes[1], 4.0 / 24.0), rtol=1e-12)


@pytest.mark.parametrize("row", [1, 30, 62])
def test_a_bright_patch_is_a_light_of_its_own_wherever_it_lies_in_its_picture(row):
    values = np.full((64, 8, 3), 0.02)
    values[row, 3] = (30.0, 20.0, 10.0)
    values[row, 6] = (10.0, 20.0, 30.0)
    sign = Rectangle((0.0, 0.0, -9000.0), (80.0, 0.0, 0.0), (0.0, 640.0, 0.0), Material(
        (1.0, 1.0, 1.0), "light", pattern=Pattern("image", image=Image.of(values))))
    up = 640.0 * (1.0 - 2.0 * (row + 0.5) / 64)
    centres = [light.centre for light in small_lights((sign,))]
    np.testing.assert_allclose(centres, [(-10.0, up, -9000.0), (50.0, up, -9000.0)], atol=1e-9)
