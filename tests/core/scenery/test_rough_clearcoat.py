"""Lights in rough coats, out of focus: each sample shows them on average over its part of the pupil and the pixel."""

import math

import numpy as np
import pytest
from numba import njit

import lensbench as lb
from lensbench import lenses
from lensbench.core.cameras.pupil_footprint import FULL_PUPIL_SAMPLES, footprint_steps
from lensbench.core.imaging.transform import AnimatedTransform
from lensbench.core.kernels.block import (
    A0, A3, DEPTH, FINISH, KEYS, NX, NY, OX, OY, PITCH, PIXEL_SIDE, PIXEL_SPREAD, PUPIL_RADIUS, PUPIL_SPREAD, SAMPLE,
    SB, SR, TB, TR, U0, U1, B, L, M, N, X, Y, lane_buffer
)
from lensbench.core.kernels.program import Program
from lensbench.core.scenery.intersect.sky import SKY
from lensbench.core.scenery.objects.basic_shapes import Rectangle, Sphere
from lensbench.core.scenery.objects.material import Material
from lensbench.core.scenery.objects.surroundings import Floor, Sky
from lensbench.core.scenery.scene import Scene
from lensbench.core.scenery.shading.rough_clearcoat import lobe_mean, rough_lights, rough_open
from lensbench.core.scenery.surface_codes import MATTE

NO_INTEGERS = np.zeros(0, np.int64)
FILM = lb.Film(36.0, 24.0, 90, 60)
BLACK = (0.0, 0.0, 0.0)
DARK = Sky(BLACK, BLACK, BLACK)
LIGHTS = tuple(Sphere((x, 900.0, -away), 35.0, Material((60.0, 40.0, 20.0), "light"))
               for x, away in ((-900.0, 9000.0), (300.0, 12000.0), (1300.0, 8000.0), (-300.0, 16000.0)))
STREET = Scene("street", sky=DARK, floor=Floor(-700.0, 500.0, BLACK, BLACK, gloss=0.96), spheres=LIGHTS)
TURNED = np.array([[0.8, 0.0, 0.6, 4000.0], [0.0, 1.0, 0.0, 0.0], [-0.6, 0.0, 0.8, 0.0], [0.0, 0.0, 0.0, 1.0]])


def camera(model, **more):
    if model == "perspective":
        return lb.PerspectiveCamera(FILM, fov=0.45, lens_radius=12.0, focus_distance=1200.0, **more)
    return lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0, 2.0, model=model, **more)


def picture(view, scene, samples, **more):
    rendering = lb.Rendering(view, scene, light_tracing=False, adaptive=False, **more)
    rendering.add(samples)
    return rendering.image().astype(float)


def rms(values):
    return math.sqrt((values**2).mean())


@pytest.mark.slow
@pytest.mark.parametrize("model", ["trace", "polynomial", "thin", "perspective"])
def test_a_gleam_out_of_focus_is_in_the_first_picture_nearly_what_it_is_in_the_last(model):
    """Against 2048 samples, each at its point. The place in the pixel still makes some noise: less in the mean of 8."""
    view = camera(model)
    last, at_points = (picture(view, STREET, n, seed=n, filtered=False)[36:] for n in (2048, 1))
    firsts = [picture(view, STREET, 1, seed=seed)[36:] for seed in range(8)]
    assert rms(firsts[1] - last) < 0.4 * rms(at_points - last)
    assert rms(np.mean(firsts, 0) - last) < 0.12 * rms(last)
    assert firsts[1].sum() == pytest.approx(last.sum(), rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("model", ["trace", "perspective"])
def test_many_samples_show_what_they_would_at_points(model):
    """The disks that samples represent shrink: what the first ones blurred falls as one over the number of samples."""
    view = camera(model, world_from_camera=TURNED)
    scene = Scene("turned", sky=DARK, floor=STREET.floor, spheres=tuple(
        Sphere(tuple(TURNED[:3, :3] @ s.centre + TURNED[:3, 3]), s.radius, s.material) for s in LIGHTS))
    truth = picture(view, scene, 4096, seed=5, filtered=False)[36:]
    rendering, off = lb.Rendering(view, scene, seed=4, light_tracing=False, adaptive=False), []
    for samples in (256, 1024):
        rendering.add(samples - rendering.samples)
        found = rendering.image().astype(float)[36:]
        off.append(rms(found - truth) / rms(truth))
    assert off[1] < 2e-3 and off[1] < 0.4 * off[0]
    assert found.sum() == pytest.approx(truth.sum(), rel=1e-3)


@pytest.mark.slow
def test_gleams_in_a_ball_of_glass_are_found_sooner_and_are_the_same():
    ball = Sphere((0.0, 0.0, -1250.0), 150.0, Material((0.99,) * 3, "glass"))
    scene = Scene("ball", sky=DARK, floor=STREET.floor, spheres=(ball, *LIGHTS))
    black = Scene("black", sky=DARK, spheres=(ball, *LIGHTS))       # the lights themselves, by the same rays
    view, pictures = camera("perspective"), []
    for samples, filtered in ((2048, False), (2, True), (2, False), (256, True)):
        gleams = picture(view, scene, samples, seed=samples, filtered=filtered) - picture(
            view, black, samples, seed=samples, filtered=filtered)
        pictures.append(gleams[18:33, 33:57])                       # in the ball
    last, few, at_points, many = pictures
    assert rms(few - last) < 0.7 * rms(at_points - last)
    assert many.sum() == pytest.approx(last.sum(), rel=5e-3)


@pytest.mark.slow
def test_the_disks_that_samples_stand_for_are_together_as_large_as_the_pupil_and_keep_the_focus():
    view = camera("perspective", world_from_camera=TURNED)
    before, after = footprint_steps(view, np.float64)
    program = Program([*before, *view.steps(), *after], np.float64)
    lanes, key = lane_buffer(np.float64), np.zeros(KEYS, np.uint32)
    table = lanes.reshape(-1, PITCH)[:, :B]
    k = np.arange(B)
    for number, part in ((0, 1.0), (FULL_PUPIL_SAMPLES - 1, 1.0), (15, 0.25**0.75), (255, (4 / 256) ** 0.75)):
        key[SAMPLE] = number
        table[X], table[Y], table[U0], table[U1] = 20.0, 41.0, (k + 0.5) / B, k * 0.6180339887 % 1.0
        for address, step in zip(program.code.ends[0], [*before, *view.steps(), *after], strict=False):
            step.kernel(lanes, program.code.numbers[address:address + np.size(step.parameters)], NO_INTEGERS, key)
        origins, ways = table[X:X + 3].copy(), table[L:L + 3]
        radius, fan, off = table[PUPIL_RADIUS], table[PUPIL_SPREAD], table[OX:OX + 3]
        assert radius == pytest.approx(np.full(B, 12.0 * part), rel=0.02)
        middles = origins - radius * off
        assert middles.var(1).sum() / 2.0 + (12.0 * part) ** 2 / 4.0 == pytest.approx(12.0**2 / 4.0, rel=0.03)
        # where the disk has no size all rays meet: at the distance in focus
        meeting = origins - ways * radius / fan
        assert meeting.std(1).max() < 1e-6
        assert (meeting.mean(1) - TURNED[:3, 3]) @ -TURNED[:3, 2] == pytest.approx(1200.0, rel=1e-3)


def test_where_a_film_point_has_one_ray_or_the_camera_moves_a_sample_stands_for_its_point_of_the_pupil():
    later = np.eye(4)
    later[0, 3] = 30.0
    for view in (camera("pinhole"), camera("thin", world_from_camera=AnimatedTransform(np.eye(4), later)),
                 lb.EnvironmentCamera(FILM), lb.PerspectiveCamera(FILM)):
        assert footprint_steps(view, np.float32) == ([], [])


@pytest.mark.slow
def test_what_is_in_focus_or_smooth_is_not_blurred():
    """A plate in focus, rough and tilted, whose streaks end at an edge: within a pixel of it no light leaks out."""
    plate = Rectangle((0.0, -60.0, -1200.0), (150.0, 0.0, 0.0), (0.0, 60.0, -60.0), Material(BLACK, "coat", gloss=0.9))
    lamp = Sphere((0.0, 2000.0, -1200.0), 100.0, Material((60.0,) * 3, "light"))
    scene = Scene("plate", sky=DARK, spheres=(lamp,), plates=(plate,))
    view = camera("thin")
    found, points = (picture(view, scene, 64, seed=4, filtered=filtered) for filtered in (True, False))
    assert points.max() > 0.05
    assert np.abs(found - points).max() < 0.02 * points.max()


def test_the_average_of_a_lobe_keeps_its_light_and_has_its_limits():
    real = np.float64

    @njit(error_model="numpy")
    def lobes(places, reach, width):
        out = np.empty_like(places)
        for i in range(places.size):
            a, b, c, d = lobe_mean(real, places[i] ** 2, reach * reach, width * width)
            out[i] = a / b * math.sqrt(c / d)
        return out

    x = np.sinh(np.linspace(-12.0, 12.0, 40001))
    for reach in (0.0, 1e-3, 0.1, 0.5, 1.0, 2.0, 5.0, 20.0, 300.0):
        found = lobes(x * 0.04, reach * 0.04, 0.04)
        assert np.trapezoid(found, x) == pytest.approx(math.pi / 2.0, rel=6e-3)
        if reach <= 1e-3:
            np.testing.assert_allclose(found, (1.0 + x * x) ** -2.0, rtol=1e-5)
        if reach == 300.0:
            inside = np.abs(x) < 0.9 * reach
            np.testing.assert_allclose(found[inside], math.pi / 4.0 / reach, rtol=6e-3)
            assert found[np.abs(x) > 1.1 * reach].max() < 1e-3 * found.max()


def test_a_gleam_is_finite_and_never_negative_however_grazing_the_ray_and_wide_the_part():
    step = next(step for step in lb.builtin_scene("night-lights").steps() if step.kernel.__name__ == "rough_clearcoat")
    random, parameters = np.random.default_rng(2), np.asarray(step.parameters, np.float32)
    lanes, key = lane_buffer(), np.zeros(KEYS, np.uint32)
    table = lanes.reshape(-1, PITCH)[:, :B]
    for _ in range(200):
        fall, turn = 10.0 ** random.uniform(-8.0, 0.0, B), random.uniform(0.0, 2.0 * math.pi, B)
        level = np.sqrt(1.0 - fall**2)
        table[L], table[M], table[N] = level * np.cos(turn), -fall, level * np.sin(turn)
        table[DEPTH], table[NX:NY + 2], table[NY] = 1350.0 / fall, 0.0, 1.0
        table[PUPIL_RADIUS] = size = 10.0 ** random.uniform(-3.0, 1.5)
        table[PUPIL_SPREAD] = -size / 10.0 ** random.uniform(1.0, 5.0)
        table[OX:OX + 3] = random.uniform(-1.0, 1.0, (3, B))
        table[PIXEL_SIDE], table[PIXEL_SPREAD] = random.uniform(-5.0, 5.0, B), random.uniform(-0.1, 0.1, B)
        table[FINISH], table[TR:TB + 1], table[SR:SB + 1] = random.choice([0.5, 0.955, 0.9985]), 1.0, 0.0
        step.kernel(lanes, parameters, np.asarray(step.integers, np.int64), key)
        assert np.isfinite(table[SR:SB + 1]).all() and table[SR:SB + 1].min() >= 0.0


@pytest.mark.parametrize("coated", [1, 17, 400, B])
def test_a_coated_lane_reflects_the_same_whatever_the_others_of_its_block_are(coated):
    step = next(step for step in lb.builtin_scene("night-lights").steps() if step.kernel.__name__ == "rough_clearcoat")
    random, parameters = np.random.default_rng(3), np.asarray(step.parameters, np.float32)
    fall, turn, found = random.uniform(0.05, 0.5, B), random.uniform(-0.3, 0.3, B), []
    which = random.permutation(B)[:coated]
    for finish in (np.full(B, 0.955), np.where(np.isin(np.arange(B), which), 0.955, MATTE)):
        lanes, key = lane_buffer(), np.zeros(KEYS, np.uint32)
        table = lanes.reshape(-1, PITCH)[:, :B]
        level = np.sqrt(1.0 - fall**2)
        table[L], table[M], table[N] = level * np.sin(turn), -fall, -level * np.cos(turn)
        table[DEPTH], table[NY], table[FINISH], table[TR:TB + 1] = 1350.0 / fall, 1.0, finish, 1.0
        step.kernel(lanes, parameters, np.asarray(step.integers, np.int64), key)
        found.append(table[SR:SB + 1].copy())
    alone = found[1][:, which]
    assert alone.min() > 0.0 and alone == pytest.approx(found[0][:, which], rel=1e-5)
    assert np.count_nonzero(found[1]) == 3 * coated


def test_the_last_places_of_the_film_have_the_pupil_of_its_last_cell():
    """Also the very edges, to which single precision rounds a place just before them."""
    (before,), _ = footprint_steps(camera("perspective"), np.float32)
    across, down = FILM.pixels_x, FILM.pixels_y
    x, y = np.array([[across, across - 0.5, 0.5, 0.5, across], [0.5, 0.5, down, down - 0.5, down]], float)
    found = Program([before], np.float32).run({X: x, Y: y}, [PUPIL_RADIUS, OX, OY], 5)
    np.testing.assert_array_equal(found[:, [0, 2]], found[:, [1, 3]])
    last = Program([before], np.float32).run({X: x[:1] - 0.5, Y: y[2:3] - 0.5}, [PUPIL_RADIUS, OX, OY], 1)
    np.testing.assert_array_equal(found[:, 4:], last)


def test_points_that_reflect_lie_where_the_ray_through_the_middle_of_the_part_meets_the_surface():
    random = np.random.default_rng(4)
    lanes = lane_buffer(np.float64)
    table = lanes.reshape(-1, PITCH)[:, :B]
    ways, normals, aside = random.normal(size=(3, B, 3))
    ways, normals = (v / np.linalg.norm(v, axis=1)[:, None] for v in (ways, normals))
    normals = normals * -np.sign((ways * normals).sum(1))[:, None] - ways       # none of them grazes
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    start, depth = random.normal(0.0, 99.0, (B, 3)), random.uniform(500.0, 900.0, B)
    table[X:X + 3], table[L:L + 3], table[NX:NX + 3], table[OX:OX + 3] = start.T, ways.T, normals.T, 0.1 * aside.T
    table[DEPTH], table[FINISH], table[PUPIL_RADIUS], table[PUPIL_SPREAD] = depth, 0.9, 12.0, -0.01
    rough_open(lanes, np.ones(SKY))
    hit, middle = start + depth[:, None] * ways, start - 1.2 * aside
    way = ways + 0.001 * aside
    met = middle + (((hit - middle) * normals).sum(1) / (way * normals).sum(1))[:, None] * way
    np.testing.assert_allclose(table[A0:A0 + 3].T, met, atol=1e-7)


def test_the_pupil_of_a_thin_lens_is_where_the_camera_is_and_its_focus_in_the_plane_of_focus():
    for place in (np.eye(4), TURNED):
        _, (after,) = footprint_steps(camera("perspective", world_from_camera=place), np.float64)
        right, up, back, plane = np.reshape(after.parameters[:12], (4, 3))
        np.testing.assert_allclose(np.stack([right, up, back], 1), place[:3, :3], atol=1e-12)
        np.testing.assert_allclose(plane, place[:3, 3], atol=1e-6)
        assert after.parameters[12] == pytest.approx(-1200.0, rel=1e-6)


def gleams(real, points, ways, lights, gloss, size=0.0, fan=0.0):
    """Light of lights (x, y, z, area over π) on a horizontal coat at points (n, 3), of rays along ways (n, 3)."""
    lanes = lane_buffer(real)
    table = lanes.reshape(-1, PITCH)[:, :B]
    table[FINISH] = MATTE
    n = len(points)
    table[A0:A0 + 3, :n], table[L:N + 1, :n] = points.T, ways.T
    table[NX:NX + 3, :n], table[FINISH, :n] = np.array([[0.0], [1.0], [0.0]]), gloss
    table[DEPTH, :n], table[PUPIL_RADIUS, :n], table[PUPIL_SPREAD, :n] = 1000.0, size, fan
    rough_lights(lanes, np.array([[*light, 1.0, 1.0, 1.0] for light in lights], real).ravel())
    return table[A3, :n].astype(float)


@pytest.mark.parametrize("gloss", [0.95, 0.99, 0.998])
def test_a_gleam_turns_with_ray_and_light_however_straight_down_the_ray(gloss):
    """About the normal; a sample's part has a direction, along the plane of incidence, down to a hundred-thousandth."""
    away, turns = np.array([2e-5, 1e-3, 0.0099, 0.0101, 0.1]), np.linspace(0.0, 6.0, 7)
    found = []
    for turn in turns:
        across = np.array([math.cos(turn), 0.0, math.sin(turn)])
        ways = away[:, None] * across - np.sqrt(1.0 - away**2)[:, None] * [0.0, 1.0, 0.0]
        light = 3000.0 * (0.004 * across + 0.003 * np.array([-across[2], 0.0, across[0]])) + [0.0, 3000.0, 0.0]
        found.append(gleams(np.float64, np.zeros((len(away), 3)), ways, [(*light, 40.0)], gloss, 10.0, 2e-3))
    np.testing.assert_allclose(found, np.tile(found[0], (len(turns), 1)), rtol=1e-9)
    assert (found[0] > 0.0).all()


def test_a_light_just_above_the_coat_has_its_gleam_far_from_the_origin():
    """Single precision, against double: 5 and 20 mm above, ten metres away, where coordinates are exact to 1e-3 mm."""
    rng = np.random.default_rng(5)
    points = np.column_stack([1e4 + rng.uniform(-30.0, 30.0, 400), np.full(400, -700.0), rng.uniform(-30.0, 30.0, 400)])
    points = points.astype(np.float32).astype(float)
    ways = np.column_stack([rng.uniform(0.2, 0.8, 400), np.full(400, -0.3), rng.uniform(-0.3, 0.3, 400)])
    ways = (ways / np.linalg.norm(ways, axis=1)[:, None]).astype(np.float32).astype(float)
    for height, gloss, within in ((5.0, 0.9, 1e-4), (20.0, 0.99, 5e-4)):
        light = [(1e4, -700.0 + height, 0.0, 1.0)]
        single, double = (gleams(real, points, ways, light, np.float32(gloss)) for real in (np.float32, np.float64))
        assert np.abs(single - double).max() < within * double.max()
