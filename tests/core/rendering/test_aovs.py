"""AOVs: each agrees with an independent computation for every sample."""

from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.charts.samplers import white_noise
from lensbench.core.kernels.block import BLUE, GREEN, RED, TIME, U0, U1, WEIGHT, Step, X, Y
from lensbench.core.kernels.program import Program
from lensbench.core.rendering.aovs import aov_steps

FILM = lb.Film(36.0, 24.0, 60, 40)
SCENE = lb.builtin_scene("still-life")
TURNED = np.array([[0.8, 0.0, 0.6, 10.0], [0.0, 1.0, 0.0, -20.0], [-0.6, 0.0, 0.8, 30.0], [0.0, 0.0, 0.0, 1.0]])
N = 3000


def camera(name="pbrt-dgauss-50mm", model="trace", **more):
    return lb.LensCamera(lenses.load(name), FILM, 1200.0, model=model, **more)


def seen(of, view, n=N):
    """Samples anywhere on film and pupil, the colours (n, 3) and weights (n,) of the AOV, in double."""
    random = np.random.default_rng(5)
    xy, uv, time = random.uniform(0, [60, 40], (n, 2)), random.uniform(0, 1, (n, 2)), random.uniform(0, 1, n)
    film = (0.5 - xy / [60.0, 40.0]) * [36.0, -24.0]
    place = uv if view == "fate" else of.stage_uv(film, uv)        # which aims into the whole opening
    out = Program(aov_steps(of, SCENE, view), np.float64).run(
        {X: xy[:, 0], Y: xy[:, 1], U0: place[:, 0], U1: place[:, 1], TIME: time}, [RED, GREEN, BLUE, WEIGHT], n)
    return xy, uv, time, out[:3].T, out[3]


@pytest.mark.parametrize("of", [camera(world_from_camera=TURNED),
                                lb.PerspectiveCamera(FILM, lens_radius=5.0)])
def test_direction_time_and_weight_are_those_of_the_rays(of):
    xy, uv, time, direction, weight = seen(of, "direction")
    rays = of.generate_rays(xy, uv, time)
    there = rays.weights > 0.0
    np.testing.assert_array_equal(weight, there)
    np.testing.assert_allclose(2.0 * direction[there] - 1.0, rays.directions[there], atol=1e-14)
    assert np.all((direction[there] >= 0.0) & (direction[there] <= 1.0))
    np.testing.assert_allclose(seen(of, "time")[3][there, 0], time[there], atol=1e-15)
    np.testing.assert_allclose(seen(of, "weight")[4], rays.weights, rtol=1e-14)


def test_the_origin_lies_on_the_first_surface_in_the_camera_frame():
    of = camera(world_from_camera=TURNED)
    *_, origin, weight = seen(of, "origin")
    x, y, z = origin[weight > 0.0].T
    front = of.lens.surfaces[0]
    assert np.all(np.hypot(x, y) <= front.semi_diameter * (1.0 + 1e-12))
    np.testing.assert_allclose(z + of.lens.length + of.film_distance, front.sag(x, y), atol=1e-10)


def test_the_depth_of_a_pinhole_is_the_depth_map():
    of = camera(model="pinhole", world_from_camera=TURNED)
    y, x = (np.mgrid[0:40, 0:60] + 0.5).reshape(2, -1)
    half = np.full(x.size, 0.5)
    out = Program(aov_steps(of, SCENE, "depth")).run({X: x, Y: y, U0: half, U1: half}, [RED, WEIGHT], x.size)
    depth = lb.depth_map(of, SCENE).ravel()
    assert np.isfinite(depth).any() and np.isinf(depth).any()
    np.testing.assert_allclose(out[0], 1000.0 / depth, rtol=1e-5)           # float32 along metres of ray


@pytest.mark.parametrize("of", [
    lb.EnvironmentCamera(lb.Film(36.0, 18.0, 60, 40), world_from_camera=TURNED),
    lb.FisheyeCamera(lb.Film(36.0, 24.0, 60, 40), fov=3.8, fov_axis="longer", world_from_camera=TURNED)],
    ids=["panorama", "fisheye"])
def test_the_depth_of_a_camera_that_sees_behind_itself_is_the_distance_along_the_ray(of):
    y, x = (np.mgrid[0:40, 0:60] + 0.5).reshape(2, -1)
    rays = of.generate_rays(np.stack([x, y], 1), np.full((x.size, 2), 0.5))
    there = rays.weights > 0.0
    true = SCENE.distance(rays.origins[there], rays.directions[there])
    depth = lb.depth_map(of, SCENE).ravel()
    assert np.isnan(depth[~there]).all() and depth[there].min() > 0.0 and np.isfinite(true).any()
    np.testing.assert_allclose(1000.0 / depth[there], 1000.0 / true, rtol=1e-3, atol=1e-6)
    half = np.full(x.size, 0.5)
    out = Program(aov_steps(of, SCENE, "depth")).run({X: x, Y: y, U0: half, U1: half}, [RED, WEIGHT], x.size)
    np.testing.assert_allclose(out[0][there], 1000.0 / depth[there], rtol=1e-4)


def test_the_weight_is_the_picture_of_an_even_sky():
    even = lb.Scene("even", sky=lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3))
    of = camera(dispersion=False)
    pictures = []
    for view in ("", "weight"):
        rendering = lb.Rendering(of, even, view=view)
        rendering.add(4)
        pictures.append(rendering.image())
    np.testing.assert_allclose(pictures[0], pictures[1], rtol=1e-6)


def test_a_fate_is_that_of_the_reference_tracer_surface_by_surface():
    of = replace(camera("lv-czj-tessar-50-f28"), f_number=4.0)
    lens, d = of.lens, of.film_distance
    xy, uv, _, colours, weight = seen(of, "fate")
    assert np.all(weight == 1.0)
    rays = np.array([(0.5 - xy[:, 0] / 60) * 36.0, (xy[:, 1] / 40 - 0.5) * 24.0, np.full(N, lens.length + d)]).T
    # The place in the opening, by the thin lens's own mapping of the square to the disk
    rear = lens.surfaces[-1]
    a, b = concentric(uv[:, 1], uv[:, 0])
    aim = np.array([a, b, np.full(N, (lens.length + rear.sag(rear.semi_diameter)) / rear.semi_diameter)]).T
    directions = aim * rear.semi_diameter - rays
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    t = lb.trace(lens, rays, directions)
    ended = np.where(np.isin(t.fate, [lb.Fate.MISSED, lb.Fate.BACKWARD]), t.surface - 1, t.surface)
    ended = np.where(t.surface < 0, len(lens.surfaces) - 1, ended)
    expected = np.where((t.fate == lb.Fate.PASSED)[:, None], 1.0, lb.fate_colours(lens)[ended])
    assert len(set(ended[t.fate != lb.Fate.PASSED])) >= 3 and (t.fate == lb.Fate.PASSED).any()
    np.testing.assert_allclose(colours, expected, atol=1e-12)


def test_the_fates_of_a_decentred_lens_are_those_of_the_lens_in_line_beside_it():
    """Eight pixels of 0.6 mm: rays were aimed at the centred rear aperture, wherever the last surface stood."""
    straight = replace(camera("lv-czj-tessar-50-f28"), f_number=4.0)
    moved = replace(straight, lens=replace(straight.lens, surfaces=tuple(
        replace(surface, pose=lb.SurfacePose(decentre_x=4.8)) for surface in straight.lens.surfaces)))
    random = np.random.default_rng(6)
    xy, uv = random.uniform([10.0, 0.0], [50.0, 40.0], (N, 2)), random.uniform(0.0, 1.0, (N, 2))
    colours = [Program(aov_steps(of, SCENE, "fate"), np.float64).run(
        {X: xy[:, 0] + shift, Y: xy[:, 1], U0: uv[:, 0], U1: uv[:, 1]}, [RED, GREEN, BLUE], N)
        for of, shift in ((straight, 8.0), (moved, 0.0))]
    assert (np.abs(colours[0] - colours[1]).max(0) < 1e-9).mean() > 0.999       # a ray on an edge may round
    assert len(np.unique(colours[0], axis=1).T) > 3


def concentric(u, v):
    """Shirley and Chiu: the square's rings become the disk's."""
    a, b = 2.0 * u - 1.0, 2.0 * v - 1.0
    steep = np.abs(b) > np.abs(a)
    with np.errstate(invalid="ignore", divide="ignore"):
        angle = np.where(steep, np.pi / 2 - np.pi / 4 * a / b, np.pi / 4 * b / a)
    radius = np.where(steep, b, a)
    return radius * np.cos(angle), radius * np.sin(angle)


def test_an_aov_is_rendered_as_any_picture_and_an_unknown_one_is_refused():
    of = camera()
    rendering = lb.Rendering(of, SCENE, steps=[Step(white_noise, [of.film.pixels_x, of.film.pixels_y])], view="time")
    rendering.add(64)
    rendering.add(64)
    image = rendering.image()
    assert image.shape == (40, 60, 3)
    # 128 uniform numbers, all but a few samples of the pupil's edge: σ = 0.0255 each, 2400 pixels
    assert abs(image[15:25, 20:40].mean() - 0.5) < 0.01
    with pytest.raises(ValueError, match="choose one of direction"):
        lb.Rendering(of, SCENE, view="colour")
