"""Pictures: the same for any number of threads, in the right place, with the right light."""

import math
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.app.studies.charts.samplers import white_noise
from lensbench.core.kernels.block import Step
from lensbench.core.kernels.program import Program
from lensbench.core.kernels.sampling import sampling_steps
from lensbench.core.optics.finding import Kind

FILM = lb.Film(36.0, 24.0, 150, 100)


def camera(model="trace", film=FILM, **more):
    return lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), film, 1200.0, 2.8, model=model, **more)


def test_the_film_is_the_same_bit_for_bit_for_any_number_of_threads():
    scene = lb.builtin_scene("still-life")
    pictures = [lb.render(camera(), scene, samples=3, seed=7, threads=threads) for threads in (1, 2, 5)]
    assert np.array_equal(pictures[0], pictures[1]) and np.array_equal(pictures[0], pictures[2])
    assert not np.array_equal(pictures[0], lb.render(camera(), scene, samples=3, seed=8))


def test_a_picture_without_small_lights_goes_on_from_its_sums():
    scene = lb.builtin_scene("white-wall")
    begun, at_once, resumed = (lb.Rendering(camera(film=lb.Film(36.0, 24.0, 24, 16)), scene) for _ in range(3))
    begun.add(1)
    resumed.restore(begun.state)
    assert resumed.add(1) and at_once.add(2)
    assert np.array_equal(resumed.image(), at_once.image())


@pytest.mark.parametrize(("scene", "disperses", "named"), [
    ("still-life", False, {}), ("still-life", False, {"view": "depth"}),
    pytest.param("still-life", True, {}, marks=pytest.mark.slow),
    pytest.param("night-lights", False, {"flare": lb.Flare(stars=1.0)}, marks=pytest.mark.slow)])
def test_a_picture_in_bands_is_the_whole_picture_bit_for_bit(scene, disperses, named):
    lens = lenses.load("lv-leica-summicron-m-50f2-v5" if disperses else "pbrt-dgauss-50mm")
    view = lb.LensCamera(lens, lb.Film(2.0, 24.0, 90, 1080), 1200.0, 2.8, dispersion=disperses)
    whole, in_bands = (lb.Rendering(view, lb.builtin_scene(scene), in_bands=each, **named) for each in (False, True))
    assert whole.add(3)
    found = []
    while not found or in_bands.next_band():
        assert in_bands.add(1) and in_bands.add(2)
        found.append(in_bands.image())
    assert [len(band) for band in found] == [512, 512, 56]
    assert np.array_equal(np.concatenate(found), whole.image())
    assert np.array_equal(np.concatenate([*whole.bands()]), whole.image())


def test_samples_added_one_by_one_are_those_added_at_once():
    scene = lb.builtin_scene("still-life")
    by_one, at_once = lb.Rendering(camera(), scene), lb.Rendering(camera(), scene)
    with ThreadPoolExecutor(2) as pool:
        for _ in range(4):
            assert by_one.add(1, pool=pool)
    assert at_once.add(4)
    assert by_one.samples == at_once.samples == 4
    assert np.array_equal(by_one.image(), at_once.image())


def test_a_cancelled_rendering_stops():
    rendering = lb.Rendering(camera(film=lb.Film(pixels_x=960, pixels_y=640)), lb.builtin_scene("still-life"))
    calls = []

    def wanted():
        calls.append(threading.get_ident())
        return len(calls) < 5

    assert not rendering.add(1, wanted=wanted)
    assert len(calls) <= 5 + 8                                  # each thread asks once more at the most


@pytest.mark.parametrize("model", ["trace", "thin", "pinhole"])
def test_a_white_world_is_the_cameras_falloff_and_one_on_the_axis(model):
    """Every pixel is the mean weight there: 1 on the axis, cos⁴ and vignetting beyond, within the noise."""
    picture = lb.render(camera(model), lb.builtin_scene("white-wall"), samples=256)
    assert np.ptp(picture, axis=2).max() < 1e-6
    middle = picture[49:51, 74:76, 0].mean()
    assert middle == pytest.approx(1.0, abs=3e-3)
    if model == "pinhole":
        y, x = (np.mgrid[0:100, 0:150] + 0.5)
        rays = camera(model).generate_rays(np.column_stack([x.ravel(), y.ravel()]), np.full((15000, 2), 0.5))
        np.testing.assert_allclose(picture[..., 0].ravel(), rays.weights, atol=1e-3)
    else:
        assert (picture[0, 0, 0] < 0.75) and np.allclose(picture, picture[::-1, ::-1], atol=0.02)


def test_a_white_world_fades_as_quadrature_says_along_a_radius():
    """Rows of the picture against the solved regions' own cos⁴ integrals, within 0.1 % of the axis."""
    film = lb.Film(36.0, 24.0, 120, 80)
    view = camera(film=film)
    picture = lb.render(view, lb.builtin_scene("white-wall"), samples=1024)[..., 0]
    rows, columns = np.mgrid[0:80, 0:120]
    radii = np.hypot((0.5 - (columns + 0.5) / 120) * 36.0, ((rows + 0.5) / 80 - 0.5) * 24.0)
    pupil = lb.exit_pupil(view.lens, view.film_distance, np.linspace(0.0, 21.6, 200))
    expected = np.interp(radii, pupil.film_radii, pupil.cos4_area) / pupil.cos4_area[0]
    # groups of pixels of like radius: the sampling noise of one pixel at 1024 samples is some parts in 1000
    for low in np.arange(0.0, 20.0, 2.0):
        ring = (radii >= low) & (radii < low + 2.0)
        assert picture[ring].mean() == pytest.approx(expected[ring].mean(), abs=1e-3)


@pytest.mark.slow
def test_a_known_grid_lands_where_the_traced_chief_rays_say():
    """Edges of a dark square on white, at 2 m, within 0.1 px of where rays through the stop put them."""
    from lensbench.core.scenery.objects.basic_shapes import Rectangle
    from lensbench.core.scenery.objects.material import Material
    from lensbench.core.scenery.objects.surroundings import Sky
    from lensbench.core.scenery.scene import Scene

    film = lb.Film(36.0, 24.0, 300, 200)
    lens = lenses.load("pbrt-dgauss-50mm")
    view = lb.LensCamera(lens, film, 2000.0, 16.0)
    white = Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3)
    x0, x1, y0, y1 = 150.0, 420.0, 60.0, 300.0
    black = Rectangle(((x0 + x1) / 2, (y0 + y1) / 2, -2000.0), ((x1 - x0) / 2, 0.0, 0.0), (0.0, (y1 - y0) / 2, 0.0),
                      Material((0.0, 0.0, 0.0), "light"))
    dark = lb.render(view, Scene("square", white, plates=(black,)), samples=256)[..., 0]
    lit = lb.render(view, Scene("nothing", white), samples=256)[..., 0]
    covered = 1.0 - dark / lit
    # the chief ray to each edge's middle: solve for the raster point whose middle ray hits it
    stop_down = lb.LensCamera(lens.with_stop_radius(0.01), film, 2000.0)

    def raster_of(x, y):
        guess = np.array([film.pixels_x * (0.5 + x / 2000.0), film.pixels_y * (0.5 - y / 2000.0)])
        for _ in range(30):
            points = guess + np.array([[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]])
            rays = stop_down.generate_rays(points, np.full((3, 2), 0.5))
            t = (-2000.0 - rays.origins[:, 2]) / rays.directions[:, 2]
            hit = (rays.origins + t[:, None] * rays.directions)[:, :2]
            jacobian = np.column_stack([(hit[1] - hit[0]) / 0.5, (hit[2] - hit[0]) / 0.5])
            guess = guess + np.linalg.solve(jacobian, [x, y] - hit[0])
        return guess

    left, right = raster_of(x0, (y0 + y1) / 2), raster_of(x1, (y0 + y1) / 2)
    top, bottom = raster_of((x0 + x1) / 2, y1), raster_of((x0 + x1) / 2, y0)
    row, column = int(left[1]), int(top[0])
    assert covered[row].sum() == pytest.approx(right[0] - left[0], abs=0.1)
    assert covered[:, column].sum() == pytest.approx(bottom[1] - top[1], abs=0.1)
    assert np.flatnonzero(covered[row] > 0.5)[0] == pytest.approx(left[0], abs=0.6)
    assert (covered[row] * (np.arange(300) + 0.5)).sum() / covered[row].sum() == pytest.approx(
        (left[0] + right[0]) / 2, abs=0.1)


@pytest.mark.slow
def test_the_picture_converges_faster_than_white_noise():
    """At 64 samples the default net errs less than three quarters as much as independent samples."""
    view, scene = camera("thin"), lb.builtin_scene("still-life")
    truth = lb.render(view, scene, samples=4096, seed=99)

    def error(steps):
        rendering = lb.Rendering(view, scene, steps=steps)
        rendering.add(64)
        return float(np.sqrt(((np.minimum(rendering.image(), 4.0) - np.minimum(truth, 4.0)) ** 2).mean()))

    assert error(sampling_steps(150, 100, lit=True)) < 0.75 * error([Step(white_noise, [150, 100])])


def test_depth_is_the_distance_along_the_axis_and_sky_is_infinite():
    from lensbench.core.scenery.objects.basic_shapes import Rectangle
    from lensbench.core.scenery.scene import Scene

    scene = Scene("wall", plates=(Rectangle((-150.0, 0.0, -1700.0), (150.0, 0.0, 0.0), (0.0, 200.0, 0.0)),))
    view = camera()
    depth = lb.depth_map(view, scene)
    assert depth.shape == (100, 150)
    assert np.isinf(depth[50, 120]) and depth[50, 50] == pytest.approx(1700.0, rel=1e-5)
    moved = np.eye(4)
    moved[2, 3] = 500.0
    assert lb.depth_map(camera(world_from_camera=moved), scene)[50, 60] == pytest.approx(2200.0, rel=1e-5)


def test_film_that_no_light_reaches_stays_black_and_costs_no_tracing():
    lens = lenses.load("pbrt-fisheye-10mm")
    view = lb.LensCamera(lens, lb.Film(110.0, 72.0, 512, 60), 1000.0)
    picture = lb.render(view, lb.builtin_scene("white-wall"), samples=4)
    assert np.isfinite(picture).all()
    assert (picture[0] == 0.0).all() and (picture[:, 0] == 0.0).all() and picture[30, 256].min() > 0.9
    steps = view.steps()
    out = Program([*steps, Step(steps[0].kernel, steps[0].parameters)]).run({5: np.full(512, 1.0)}, [5], 512)
    assert np.isfinite(out).all()


@pytest.mark.slow
@pytest.mark.parametrize("scene", [name for name in lb.SCENES])
@pytest.mark.parametrize("model", ["trace", "pinhole"])
def test_every_scene_renders_to_numbers(scene, model):
    picture = lb.render(camera(model, film=lb.Film(36.0, 24.0, 96, 64)), lb.builtin_scene(scene), samples=2)
    assert picture.shape == (64, 96, 3) and picture.dtype == np.float32
    assert np.isfinite(picture).all() and (picture >= 0.0).all() and picture.max() > 0.05


def test_no_sample_at_all_is_refused():
    with pytest.raises(ValueError, match="at least 1"):
        lb.render(camera(), lb.builtin_scene("still-life"), samples=0)
    with pytest.raises(TypeError, match="must be a whole number"):
        lb.render(camera(), lb.builtin_scene("still-life"), samples=1.5)
    for number in (0, -3):              # an index was out of range, in scenes with small lights
        rendering = lb.Rendering(camera(film=lb.Film(36.0, 24.0, 24, 16)), lb.builtin_scene("still-life"))
        with pytest.raises(ValueError, match="at least 1"):
            rendering.add(number)


@pytest.mark.parametrize(("across", "down"), [(1, 1), (1, 700), (700, 1), (63, 9), (513, 2)])
def test_a_film_of_any_shape_shows_the_falloff_of_its_own_points(across, down):
    view = camera("pinhole", film=lb.Film(36.0, 24.0, across, down))
    picture = lb.render(view, lb.builtin_scene("white-wall"), samples=256)[..., 0]
    fine = (np.arange(64) + 0.5) / 64
    x, y = (np.arange(across)[:, None] + fine).ravel(), (np.arange(down)[:, None] + fine).ravel()
    x, y = (0.5 - x / across) * 36.0, (0.5 - y / down) * 24.0
    behind = 12.0 / math.tan(math.acos(view.generate_rays([[across / 2, 0.0]], [[0.5, 0.5]]).weights[0] ** 0.25))
    weights = 1.0 / (1.0 + (x**2 + y[:, None] ** 2) / behind**2) ** 2
    np.testing.assert_allclose(picture, weights.reshape(down, 64, across, 64).mean((1, 3)), atol=2e-3)


def test_pixels_need_not_be_square():
    film = lb.Film(36.0, 24.0, 75, 100)
    wide = lb.render(camera(film=film), lb.builtin_scene("white-wall"), samples=16)
    assert wide.shape == (100, 75, 3)
    assert film.pitch == pytest.approx(math.sqrt(36.0 / 75 * 24.0 / 100))


@pytest.mark.slow
def test_a_picture_without_shadows_is_lit_from_the_middle_of_lamps_that_move_too():
    lamp = lb.Disk((0.0, 300.0, -600.0), (0.0, 1.0, 0.2), 150.0, lb.Material((9.0,) * 3, "lamp"))
    still, moving = (lb.Rendering(camera("pinhole"), lb.Scene("lamp", floor=lb.Floor(-100.0), plates=(disk,)),
                                  shadows=False)
                     for disk in (lamp, replace(lamp, velocity=(1e-6, 0.0, 0.0))))
    still.add(2)
    moving.add(2)
    np.testing.assert_allclose(moving.image(), still.image(), rtol=1e-4)


@pytest.mark.parametrize(("f_number", "pixels", "missing"), [
    (22.0, 3600, True), (22.0, 900, False), (2.0, 3600, False)])
def test_a_picture_states_that_it_lacks_diffraction_where_airys_disk_exceeds_a_pixel(f_number, pixels, missing):
    """Airy's disk is 2.44 λ N across: 31.5 µm at f/22, of the pixels of 10 and 40 µm. Nothing stated it."""
    camera = lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), lb.Film(36.0, 24.0, pixels, pixels * 2 // 3), math.inf,
                           f_number)
    found = lb.Rendering(camera, lb.builtin_scene("still-life")).findings
    assert [each.kind for each in found] == [Kind.NO_DIFFRACTION] * missing
    if missing:
        assert found[0].figures["disk"] == pytest.approx(2.44 * 0.5875618e-3 * 22.0, rel=1e-3)
        assert found[0].figures["pixels"] == pytest.approx(found[0].figures["disk"] * 100.0, rel=1e-9)


@pytest.mark.parametrize("camera", [
    lb.FisheyeCamera(lb.Film(36.0, 24.0, 3600, 2400)), lb.PerspectiveCamera(lb.Film(36.0, 24.0, 3600, 2400))],
    ids=["fisheye", "pinhole"])
def test_cameras_without_an_aperture_state_nothing_about_diffraction(camera):
    assert lb.Rendering(camera, lb.builtin_scene("still-life")).findings == ()
