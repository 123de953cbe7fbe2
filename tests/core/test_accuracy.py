"""The choice of a model: what it promises is what point lights look like through the model and through the lens."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.accuracy import LADDER
from lensbench.judge import Judge

FILM = lb.Film(36.0, 24.0, 960, 640)
NAMES = ("pbrt-dgauss-50mm", "pbrt-wide-22mm", "pbrt-telephoto-250mm", "lv-czj-tessar-50-f28", "lib-richter-topogon",
         "lentil-takumar-1969", "lv-zeiss-distagon-35mm-f4-contarex")
UV = np.random.default_rng(3).permutation((np.stack(np.meshgrid(*[(np.arange(12) + 0.5) / 12] * 2), -1)).reshape(-1, 2))


def settings(seed):
    """A camera and a scene at random; the depths of the scene lie about the plane in focus or beside it."""
    random = np.random.default_rng(seed)
    lens = lenses.load(NAMES[random.integers(len(NAMES))])
    fo = lb.first_order(lens)
    nearest = max(lb.nearest_focus(lens), 12.0 * fo.efl)
    focus = nearest * 10.0 ** random.uniform(0.1, 1.5)
    f_number = fo.f_number * 2.0 ** random.uniform(0.0, 3.0)
    size = random.uniform(0.3, 1.0)
    film = lb.Film(36.0 * size, 24.0 * size, *(int(side * 2.0 ** random.uniform(-2.0, 0.0)) for side in (960, 640)))
    depths = sorted(focus * 10.0 ** random.uniform(-0.4, 0.6, 2))
    depths = (max(depths[0], 0.7 * nearest), max(depths[1], nearest))
    camera = lb.LensCamera(lens, film, focus, f_number, dispersion=False)
    return camera, replace(lb.builtin_scene("room"), depth_range=depths)


def images(camera, points):
    """Middles (n, 2) and twice the deviations (n, 2) of the blurs of points, in pixels, and their light."""
    spots, light = [], []
    for point in points:
        rows = np.tile(point, (len(UV), 1))
        raster, _ = camera.raster_from_point(rows, UV)
        good = np.isfinite(raster).all(1)
        weights = np.zeros(len(UV))
        weights[good] = camera.generate_rays(raster[good], UV[good]).weights
        # Film per area of the scene, for this place in the pupil
        step = 1e-4 * np.linalg.norm(point)
        (dx, _), (dy, _) = (camera.raster_from_point(rows + step * np.eye(3)[k], UV) for k in (0, 1))
        jacobian = np.abs((dx - raster)[:, 0] * (dy - raster)[:, 1] - (dx - raster)[:, 1] * (dy - raster)[:, 0])
        weights[good] *= jacobian[good]
        assert weights.sum() > 0.0, "a point that the lens does not see"
        middle = (raster[good] * weights[good, None]).sum(0) / weights[good].sum()
        size = 2.0 * np.sqrt((((raster[good] - middle) ** 2) * weights[good, None]).sum(0) / weights[good].sum())
        spots.append([middle, size])
        light.append(weights.sum())
    return np.array(spots), np.array(light)


def apart(camera, model, degree, depths):
    """The greatest error in pixels and in stops of a model for point lights along the film's diagonal."""
    film, worst_px, worst_stops = camera.film, 0.0, 0.0
    for depth in depths:
        # Not on the axis itself: places in the pupil turn with the film point, and there no turn is like another
        raster = np.array([[0.62, 0.62], [0.8, 0.8], [0.96, 0.96]]) * [film.pixels_x, film.pixels_y]
        rays = camera.generate_rays(raster, np.zeros((3, 2)))
        along = (-depth - rays.origins[:, 2]) / rays.directions[:, 2]
        points = rays.origins + along[:, None] * rays.directions
        true, true_light = images(camera, points)
        seen, light = images(replace(camera, model=model, degree=degree or 9), points)
        worst_px = max(worst_px, np.abs(true - seen).max())
        stops = np.log2(light / light[0] * true_light[0] / true_light)
        worst_stops = max(worst_stops, np.abs(stops).max())
    return worst_px, worst_stops


@pytest.mark.parametrize("seed", range(8))
def test_point_lights_through_the_choice_are_within_the_tolerance(seed):
    camera, scene = settings(seed)
    choice = lb.choose_model(camera, scene)
    assert choice.error_px <= 0.5 and choice.error_stops <= 0.05
    if choice.model == "trace":
        return
    px, stops = apart(camera, choice.model, choice.degree, scene.depth_range)
    # 144 rays of a pupil place its middle and its rim to a hundredth or two of a blur of some tens of pixels
    assert px <= 0.5 + 0.25 and stops <= 0.05 + 0.03
    below = [rung for rung in choice.table if rung.error_px > 2.0]
    if below and below[-1].model not in ("pinhole",):           # what was refused for pixels was rightly refused
        assert apart(camera, below[-1].model, below[-1].degree, scene.depth_range)[0] > 0.5


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
    lens = lb.Lens((lb.Surface(1e-3, 0.01, 5.0, glass), lb.Surface(-1e-3, 0.01, 5.0), lb.Surface(0.0, 0.0, 4.0)), 2)
    film = lb.Film(20.0, 14.0, 400, 280)
    scene = replace(lb.builtin_scene("room"), depth_range=(2e4, 9e4))
    choice = lb.choose_model(lb.LensCamera(lens, film, 60000.0), scene)
    assert choice.model in ("thin", "thick")


def test_every_judgement_is_a_number_or_says_why_not():
    camera = lb.LensCamera(lenses.load("pbrt-fisheye-10mm"), FILM, 1200.0)
    judge = Judge(camera, (400.0, 8000.0))
    for model, degree in LADDER[:-1]:
        rung = judge.rung(model, degree)
        assert rung.error_px >= 0.0 and rung.error_stops >= 0.0 and rung.worst
    bladed = Judge(replace(camera, lens=replace(camera.lens, blades=6)), (400.0, 8000.0))
    assert math.isinf(bladed.rung("polynomial", 9).error_px) and "blades" in bladed.rung("polynomial", 9).worst
    with pytest.raises(lb.CameraError, match="tolerances must be positive"):
        lb.choose_model(camera, lb.builtin_scene("room"), 0.0)


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
    assert 0.0 < choice.ns_per_ray < choice.trace_ns_per_ray


def test_colour_of_a_lens_counts_where_pictures_show_it():
    # A singlet of flint: its blue image is larger or nearer than its red one, by far more than a pixel
    flint = lb.Glass(1.72, 29.5)
    lens = lb.Lens((lb.Surface(1.0 / 80.0, 4.0, 5.0, flint), lb.Surface(-1.0 / 80.0, 6.0, 5.0),
                    lb.Surface(0.0, 0.0, 2.0)), 2)
    film = lb.Film(8.0, 6.0, 1600, 1200)
    plain, coloured = (lb.LensCamera(lens, film, 4000.0, dispersion=colour) for colour in (False, True))
    depths = (4000.0, 8000.0)
    without, with_colour = (Judge(each, depths).rung("thick") for each in (plain, coloured))
    assert with_colour.error_px > 2.0 * without.error_px and "colour" in with_colour.worst
    assert Judge(coloured, depths).rung("polynomial", 9).error_px < 0.1
