"""Model choice: images of point lights through the chosen model are within the tolerances of those through the lens."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis import model_choice
from lensbench.core.analysis.model_choice import LADDER, ModelErrors
from lensbench.core.kernels.block import B
from tests.core import point_lights
from tests.core.point_lights import setting, verdict

FILM = lb.Film(36.0, 24.0, 960, 640)
SOME = (6, 15, 20, 31, 38)              # of trials/test_choices.py: pinhole, thin lens, polynomials, in colours


@pytest.mark.slow
@pytest.mark.parametrize("seed", SOME)
def test_images_of_lights_through_the_choice_are_those_through_the_lens(seed):
    _, camera, depths = setting(seed)
    choice = lb.choose_model(camera, replace(lb.builtin_scene("room"), depth_range=depths))
    chosen = choice.model, choice.degree
    assert choice.error_px <= 0.5 and choice.error_stops <= 0.05
    simpler = choice.table[-2][:2] if len(choice.table) > 1 else chosen
    seen = verdict(camera, depths, [simpler], chosen)
    assert seen.passes(chosen)
    # What was refused by far is far off
    if len(choice.table) > 1 and 1.0 < choice.table[-2].error_px < math.inf:
        assert not seen.passes(simpler)


def test_lights_are_measured_alike_from_the_scene_and_from_the_film():
    # The trace in the polynomial's place: places within a thousandth of the blur, light within half a hundredth
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0, 2.8, model="polynomial", degree=11)
    points = point_lights.lights(camera, (900.0, 3000.0))
    there = point_lights.moments(point_lights.through_the_lens(replace(camera, model="trace"), points))
    here = point_lights.moments(point_lights.through_polynomial(camera, points, there.along + there.across))
    np.testing.assert_allclose(here.middle, there.middle, atol=2e-3 * there.along.max())
    np.testing.assert_allclose(here.along, there.along, rtol=0.01, atol=5e-4)
    np.testing.assert_allclose(here.light, there.light, rtol=5e-3)


def test_the_ladder_is_climbed_in_its_order_and_no_further_than_needed():
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0, 2.8)
    choice = lb.choose_model(camera, lb.builtin_scene("still-life"))
    assert [(rung.model, rung.degree) for rung in choice.table] == list(LADDER[:len(choice.table)])
    assert all(rung.error_px > 0.5 or rung.error_stops > 0.05 for rung in choice.table[:-1])
    assert choice.table[-1][:2] == (choice.model, choice.degree)
    assert choice.reason.startswith("polynomial of degree 3: ")
    tight = lb.choose_model(camera, lb.builtin_scene("still-life"), 1e-6, 1e-6)
    assert tight.model == "trace" and tight.error_px == 0.0
    assert lb.choose_model(camera, lb.builtin_scene("still-life"), 1e3, 1e3).model == "pinhole"


def test_a_choice_does_not_flicker_about_its_tolerance():
    camera, scene = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0, 2.8), lb.builtin_scene("still-life")
    error = next(rung.error_px for rung in lb.choose_model(camera, scene).table if rung.degree == 3)
    loose, tight = lb.choose_model(camera, scene, error * 1.01), lb.choose_model(camera, scene, error * 0.99)
    assert (loose.degree, tight.degree) == (3, 5)
    assert lb.choose_model(camera, scene, error * 1.01, previous=tight).degree == 5
    assert lb.choose_model(camera, scene, error * 0.99, previous=loose).degree == 5       # never beyond the tolerance
    assert lb.choose_model(camera, scene, error * 1.3, previous=tight).degree == 3


def test_an_ideal_lens_of_thin_glass_needs_no_trace():
    # A weak, slow lens of thin glass: what is left of aberrations is far below a pixel, and brightness follows cos⁴
    glass = lb.Glass(1.5)
    lens = lb.Lens((lb.Surface(0.01, 5.0, glass, curvature=1e-3), lb.Surface(0.01, 5.0, curvature=-1e-3),
                    lb.Surface(0.0, 4.0, curvature=0.0)), 2)
    film = lb.Film(20.0, 14.0, 400, 280)
    scene = replace(lb.builtin_scene("room"), depth_range=(2e4, 9e4))
    choice = lb.choose_model(lb.LensCamera(lens, film, 60000.0), scene)
    assert choice.model in ("thin", "thick")


def test_every_error_is_a_number_or_has_a_reason():
    camera = lb.LensCamera(lenses.load("pbrt-fisheye-10mm"), FILM, 1200.0)
    judge = ModelErrors(camera, (400.0, 8000.0))
    for model, degree in LADDER[:-1]:
        rung = judge.rung(model, degree)
        assert rung.error_px >= 0.0 and rung.error_stops >= 0.0 and rung.worst
    bladed = ModelErrors(replace(camera, lens=replace(camera.lens, blades=6, blade_reach=1.0)), (400.0, 8000.0))
    assert math.isinf(bladed.rung("polynomial", 9).error_px) and "blades" in bladed.rung("polynomial", 9).worst
    with pytest.raises(lb.CameraError, match="tolerances must be positive"):
        lb.choose_model(camera, lb.builtin_scene("room"), 0.0)


def test_a_camera_nearer_to_the_scene_has_nearer_depths():
    camera, scene = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 1200.0, 16.0), lb.builtin_scene("still-life")
    there = np.eye(4)
    there[2, 3] = -300.0
    moved = lb.choose_model(replace(camera, world_from_camera=there), scene)
    nearer = lb.choose_model(camera, replace(scene, depth_range=(100.0, 8300.0)))
    assert moved.table == nearer.table != lb.choose_model(camera, scene).table


def test_a_lens_that_passes_no_light_is_traced():
    # A field stop that is wider than nothing by no ray
    lens = lenses.load("pbrt-dgauss-50mm")
    shut = replace(lens, surfaces=(replace(lens.surfaces[0], semi_diameter=1e-9), *lens.surfaces[1:]))
    choice = lb.choose_model(lb.LensCamera(shut, FILM, 1200.0), lb.builtin_scene("room"))
    assert choice.model == "trace"


def test_an_automatic_camera_takes_the_picture_of_the_model_that_is_chosen():
    camera, scene = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), lb.Film(36.0, 24.0, 60, 40), 1200.0, 8.0,
                                  model="auto"), lb.builtin_scene("still-life")
    choice = lb.choose_model(camera, scene)
    assert choice.model != "trace"
    chosen, traced = choice.applied(camera), replace(camera, model="trace")
    np.testing.assert_array_equal(lb.render(camera, scene, 2), lb.render(chosen, scene, 2))
    np.testing.assert_array_equal(lb.depth_map(camera, scene), lb.depth_map(chosen, scene))
    # Rays of its own know no scene: they are those of the lens, and so are the views of them
    for mine, true in zip(camera.generate_rays([[3.0, 4.0]], [[0.2, 0.7]]),
                          traced.generate_rays([[3.0, 4.0]], [[0.2, 0.7]]), strict=True):
        np.testing.assert_array_equal(mine, true)
    for view in ("fate", "origin"):
        first, second = (lb.Rendering(each, scene, view=view) for each in (camera, traced))
        assert first.add() and second.add()
        np.testing.assert_array_equal(first.image(), second.image())
    assert choice.ns_per_ray > 0.0 and choice.trace_ns_per_ray > 0.0


def test_a_camera_that_seems_to_take_less_than_its_samples_takes_a_part_of_them(monkeypatch):
    # A clock by which the samples alone take 100 µs, with a pinhole 90 µs and with a trace 400 µs
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), lb.Film(36.0, 24.0, 60, 40), 1200.0, 8.0)
    ticks = itertools.cycle([0.0, 1e-4, 1.0, 1.00009, 2.0, 2.0004])
    monkeypatch.setattr(model_choice, "perf_counter", lambda: next(ticks))
    least, traced = model_choice.ray_times([replace(camera, model="pinhole"), camera])
    rays = model_choice.BLOCKS * B
    assert least == pytest.approx(model_choice.RESOLVED * 9e4 / rays) and traced == pytest.approx(3e5 / rays)


def test_colour_of_a_lens_counts_where_pictures_show_it():
    # A singlet of flint: its blue image is larger or nearer than its red one, by far more than a pixel
    flint = lb.Glass(1.72, 29.5)
    lens = lb.Lens((lb.Surface(4.0, 5.0, flint, curvature=1.0 / 80.0), lb.Surface(6.0, 5.0, curvature=-1.0 / 80.0),
                    lb.Surface(0.0, 2.0, curvature=0.0)), 2)
    film = lb.Film(8.0, 6.0, 1600, 1200)
    plain, coloured = (lb.LensCamera(lens, film, 4000.0, dispersion=colour) for colour in (False, True))
    depths = (4000.0, 8000.0)
    without, with_colour = (ModelErrors(each, depths).rung("thick") for each in (plain, coloured))
    assert with_colour.error_px > 2.0 * without.error_px and "colour" in with_colour.worst
    assert ModelErrors(coloured, depths).rung("polynomial", 9).error_px < 0.1


@pytest.mark.parametrize(("a", "b"), [(0.02, 0.0), (0.0, 1e-4), (-0.01, 2e-5)])
def test_a_light_is_brighter_by_the_area_that_a_distortion_takes_from_its_image(a, b):
    """Of the shift s(r) = a r + b r³ the Jacobian is (1 + s′)(1 + s / r), in closed form."""
    errors = ModelErrors(lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), lb.Film(), 2000.0, 4.0), (500.0, 5000.0))
    r = errors._radii
    found = errors._stretched((a * r + b * r**3)[None])[0]
    wanted = np.log2((1.0 + a + 3.0 * b * r**2) * (1.0 + a + b * r**2))
    np.testing.assert_allclose(found, wanted, atol=0.02 + 0.15 * np.abs(wanted).max() * (b != 0.0))


def test_brightness_on_the_axis_adds_to_that_over_the_field():
    """The lens's own rays with 2^(g (r − r₀)) of their light, and as much brighter on the axis as `offset` says."""
    errors = ModelErrors(lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), lb.Film(), 2000.0, 4.0), (500.0, 5000.0))
    gain = 0.3 * errors._radii / errors._radii[-1]
    found = [errors._compared("thick", 0, errors._true_lines, errors._true_weights * 2.0 ** gain[:, None],
                              [errors._true], offset).error_stops for offset in (0.0, 0.1, -0.1)]
    each = found[0] / 0.3
    np.testing.assert_allclose(found, each * np.array([0.3, 0.4, 0.2]), rtol=1e-9)


def test_the_time_of_a_ray_is_that_of_one_sample(monkeypatch):
    """A clock by which each sample of the film takes 2 ns, and 7 ns with a camera."""
    taken, passed = {}, [0.0]

    def expose(self, film, lanes, first, last, sample, samples, *_):
        passed[0] += taken.setdefault(self, 7e-9 if taken else 2e-9) * (last - first) * B * samples

    monkeypatch.setattr(model_choice.Program, "expose", expose)
    monkeypatch.setattr(model_choice, "perf_counter", lambda: passed[0])
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), lb.Film(36.0, 24.0, 60, 40), 1200.0, 8.0, model="pinhole")
    assert model_choice.ray_times([camera]) == pytest.approx((5.0,), rel=1e-9)
