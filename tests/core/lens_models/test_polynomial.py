"""The fitted lens: its rays are those of the scalar reference within the error that it states."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.kernels.block import U0, U1, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.lens_models import polynomial as polynomial_stage
from lensbench.core.lens_models.polynomial import DEGREES, Polynomial, _errors
from lensbench.core.optics.glass import D_LINE
from lensbench.core.pupils.radial_sampler import PupilTable

PIXEL = 0.004                   # mm: of 24 million on full frame
FILM = lb.Film(36.0, 24.0, 9000, 6000)
SAMPLES = 4000


def bench_of(name="pbrt-dgauss-50mm", f_number=2.8, distance=2000.0, radius=21.6, index=1.0):
    """index: before the lens."""
    lens = replace(lenses.load(name), front_index=index)
    lens = lb.stopped_down(lens, f_number) if f_number else lens
    film_distance = lb.film_distance(lens, distance)
    return lens, film_distance, PupilTable.of(lens, film_distance, radius, widened=False)


def samples(radius):
    """Points of the film's disk, and of the square, evenly spread at random."""
    random = np.random.default_rng(5)
    r, turn = radius * np.sqrt(random.random(SAMPLES)), 2.0 * math.pi * random.random(SAMPLES)
    return {X: r * np.cos(turn), Y: r * np.sin(turn), U0: random.random(SAMPLES), U1: random.random(SAMPLES)}


def apart(lens, film_distance, table, polynomial, distance, real=np.float64):
    """How far from the scalar reference's the polynomial's rays meet the sphere of objects at a distance, mm on film.

    By the paraxial magnification; for the rays that the lens passes.
    """
    given = samples(table.radius)
    origin, rows = np.zeros(3), [X, Y, Z, L, M, N]
    aimed = Program([table.step(1.0)], np.float64).run(given, rows, SAMPLES).T
    shift = np.array([0.0, 0.0, lens.length + film_distance])          # camera frame → lens frame
    true = lb.trace(lens, aimed[:, :3] + shift, aimed[:, 3:])
    passed = true.fate == lb.Fate.PASSED
    ray = Program([table.step(1.0), polynomial.step], real).run(given, rows, SAMPLES).T.astype(float)
    fo = lb.first_order(lens)
    origin[2] = fo.entrance_pupil.z
    away = distance - shift[2] + origin[2]

    def seen(points, directions):
        offset = points - origin
        foot = offset - (offset * directions).sum(1, keepdims=True) * directions
        return directions + foot / away

    efl = lens.front_index * fo.efl             # of the scene's side
    behind = efl if math.isinf(away) else efl * away / (away - origin[2] + fo.front_principal - efl)
    off = seen(ray[:, :3] + shift, ray[:, 3:]) - seen(true.points, true.directions)
    return np.sqrt((off[passed] ** 2).sum(1)) * behind, passed


@pytest.mark.parametrize(("name", "f_number", "distance"), [
    ("pbrt-dgauss-50mm", None, 1200.0), ("pbrt-dgauss-50mm", 2.8, 2000.0), ("pbrt-fisheye-10mm", None, 2000.0),
    ("pbrt-fisheye-10mm", None, math.inf)])
def test_degree_nine_is_within_a_fiftieth_of_a_pixel_of_the_reference(name, f_number, distance):
    lens, film_distance, table = bench_of(name, f_number, distance)
    error, passed = apart(lens, film_distance, table, Polynomial.fit(lens, film_distance, table, 9, distance=distance),
                          distance)
    assert passed.mean() > 0.995            # the sampled regions pass what they promise
    assert np.sqrt((error**2).mean()) <= 0.02 * PIXEL


@pytest.mark.slow
@pytest.mark.parametrize(("name", "index"), [
    ("pbrt-dgauss-50mm", 1.0), ("pbrt-wide-22mm", 1.0), ("pbrt-telephoto-250mm", 1.0), ("pbrt-dgauss-50mm", 1.33)])
def test_the_stated_error_is_the_error_and_every_degree_is_better_than_the_one_before(name, index):
    lens, film_distance, table = bench_of(name, None, 20000.0, index=index)
    stated = []
    for degree in DEGREES:
        polynomial = Polynomial.fit(lens, film_distance, table, degree, distance=20000.0)
        stated.append(polynomial.rms)
        true = max(np.sqrt((apart(lens, film_distance, table, polynomial, at)[0] ** 2).mean())
                   for at in (20000.0, math.inf))
        assert 0.7 < polynomial.rms / true < 1.5           # 131 rays judge what 4,000 find: some tens of per cent
        assert polynomial.worst >= polynomial.rms
    assert all(2.0 * better < worse for worse, better in zip(stated, stated[1:], strict=False))


def test_the_error_of_a_lens_that_leaves_the_picture_upright_is_a_length_as_any_others():
    """A relay behind a lens: its focal length is negative, and degree 9 is nearer than degree 5 all the same."""
    one = lenses.load("pbrt-dgauss-50mm").surfaces
    gap = lb.first_order(lenses.load("pbrt-dgauss-50mm")).bfl + 100.0
    lens = lb.Lens((*one[:-1], replace(one[-1], thickness=gap), *one), 5).with_stop_radius(3.0)
    order = lb.first_order(lens)
    assert order.efl < 0.0 < order.bfl
    table = PupilTable.of(lens, order.bfl, 3.0)
    found = [Polynomial.fit(lens, order.bfl, table, degree) for degree in (5, 9)]
    assert all(0.0 < fit.rms < fit.worst for fit in found)
    assert found[1].rms < 0.1 * found[0].rms and found[1].worst < 0.1 * found[0].worst


def test_single_precision_is_within_three_thousandths_of_a_pixel():
    lens, film_distance, table = bench_of()
    steps = [table.step(1.0), Polynomial.fit(lens, film_distance, table, 9, distance=2000.0).step]
    given = samples(table.radius)
    single, double = (Program(steps, real).run(given, [L, M, N], SAMPLES).astype(float)
                      for real in (np.float32, np.float64))
    assert np.abs(single - double).max() * 50.0 < 0.003 * 36.0 / 960.0       # pixels of the bench's own film
    assert np.abs((single**2).sum(0) - 1.0).max() < 1e-6


@pytest.mark.slow
def test_a_turned_film_point_has_a_turned_ray():
    lens, film_distance, table = bench_of()
    step = Polynomial.fit(lens, film_distance, table, 7).step
    turn = 0.7
    rotation = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    film, aim = np.array([12.0, 5.0]), np.array([0.1, -0.2])

    def ray(film, aim):
        given = {X: film[:1], Y: film[1:], L: aim[:1], M: aim[1:], N: [-math.sqrt(1.0 - aim @ aim)]}
        return Program([step], np.float64).run(given, [X, Y, Z, L, M, N], 1)[:, 0]

    plain, turned = ray(film, aim), ray(rotation @ film, rotation @ aim)
    np.testing.assert_allclose(turned[:2], rotation @ plain[:2], atol=1e-12)
    np.testing.assert_allclose(turned[3:5], rotation @ plain[3:5], atol=1e-14)
    np.testing.assert_allclose(turned[[2, 5]], plain[[2, 5]], atol=1e-12)


def test_a_white_wall_is_as_bright_as_through_the_trace():
    wall = lb.Scene("white", sky=lb.Sky((1.0,) * 3, (1.0,) * 3, (1.0,) * 3))
    film = lb.Film(36.0, 24.0, 48, 32)
    lens = lenses.load("pbrt-dgauss-50mm")
    traced, fitted = (lb.render(lb.LensCamera(lens, film, 2000.0, 2.8, model=model), wall, 256)
                      for model in ("trace", "polynomial"))
    # No sample of the polynomial is lost: it has no noise but that of cos⁴, and the trace has 0.6 % lost at random
    assert fitted.mean() == pytest.approx(traced.mean(), rel=2e-3)
    np.testing.assert_allclose(fitted, traced, atol=0.02)


def test_the_camera_shows_what_the_trace_shows():
    raster = np.random.default_rng(2).random((500, 2)) * [9000.0, 6000.0]
    middle = np.full((500, 2), 0.5)
    traced, fitted = (lb.LensCamera(lenses.load("pbrt-dgauss-50mm"), FILM, 2000.0, 2.8, model=model).generate_rays(
        raster, middle) for model in ("trace", "polynomial"))
    # 0.1 px of 4 µm behind 50 mm
    assert np.abs(traced.directions - fitted.directions).max() < 0.1 * PIXEL / 50.0


SINGLETS = {
    "plano-convex": lb.Lens((lb.Surface(6.0, 12.0, lb.Glass(1.8, 30.0), curvature=0.02),
                             lb.Surface(50.0, 12.0, curvature=0.0)), 0),
    "biconvex": lb.Lens((lb.Surface(8.0, 9.0, lb.Glass(1.6, 50.0), curvature=0.025),
                         lb.Surface(30.0, 9.0, curvature=-0.02)), 1)}


@pytest.mark.slow
@pytest.mark.parametrize(("name", "degree", "side", "slower", "distance"), [
    ("lib-us10281683", 11, 34.0, 25.0, 1000.0), ("lib-us10281683", 9, 8.7, 1.0, 3000.0),
    ("lib-us10281683", 11, 9.0, 200.0, 3000.0), ("lib-us10281683", 11, 150.0, 200.0, math.inf),
    *((name, degree, side, 1.0, 1000.0) for name in SINGLETS for degree in (3, 5, 9) for side in (24.0, 160.0))])
def test_a_fit_that_does_not_hold_is_refused_and_any_other_gives_unit_directions(name, degree, side, slower, distance):
    lens = SINGLETS.get(name) or lenses.load(name)
    camera = lb.LensCamera(lens, lb.Film(side, side, 64, 64), distance, lb.first_order(lens).f_number * slower,
                           model="polynomial", degree=degree)
    random = np.random.default_rng(7)
    try:
        rays = camera.generate_rays(64.0 * random.random((SAMPLES, 2)), random.random((SAMPLES, 2)))
    except lb.LensError as error:
        assert "no polynomial" in str(error) or "too little light" in str(error)
        rung = lb.choose_model(replace(camera, model="auto"), lb.builtin_scene("white-wall"))
        assert rung.model != "polynomial" or rung.degree != degree          # Auto refuses this one too
        return
    seen = rays.weights > 0.0
    assert not np.isnan(rays.weights).any() and np.isfinite(rays.origins[seen]).all()
    assert np.abs((rays.directions[seen] ** 2).sum(1) - 1.0).max(initial=0.0) < 2e-4


def test_what_cannot_be_fitted_is_refused():
    lens, film_distance, table = bench_of()
    with pytest.raises(lb.LensError, match="choose one of 3, 5, 7, 9, 11"):
        Polynomial.fit(lens, film_distance, table, 4)
    with pytest.raises(lb.CameraError, match="choose one of 3, 5, 7, 9, 11"):
        lb.LensCamera(lens, FILM, model="polynomial", degree=13)
    dark = PupilTable.of(lens, film_distance, 400.0, widened=False)
    assert Polynomial.fit(lens, film_distance, dark).rms < math.inf       # the table ends where the light does


def test_every_degree_runs_the_same_kernel_of_a_module():
    lens, film_distance, table = bench_of()
    steps = [Polynomial.fit(lens, film_distance, table, degree).step for degree in DEGREES]
    assert [step.kernel for step in steps] == [polynomial_stage.polynomial] * len(DEGREES)
    assert len({step.integers for step in steps}) == len(DEGREES)


@pytest.mark.parametrize("nearness", [0.0, 1e-3])
def test_rays_that_point_the_true_way_have_no_error_however_long_their_directions(nearness):
    """The values of the polynomials in the frame of the film point and the aim, of rays whose lines they hold."""
    random, n = np.random.default_rng(3), 40
    points, ways = random.normal(0.0, 3.0, (n, 3)), random.normal(size=(n, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    film, v, size = random.uniform(1.0, 20.0, n), random.uniform(0.3, 1.0, (2, n)), random.uniform(0.5, 2.0, (n, 1))

    def coordinates(of):
        """(3, n) factors of the film point, of the aim, and of z."""
        up = of[:, 1] / v[1]
        return np.stack([(of[:, 0] - up * v[0]) / (film / 21.6), up, of[:, 2]])

    lines = np.concatenate([points.T, ways.T, np.full((1, n), 0.5)])
    for wrong in (0.0, 1e-3):
        aside = np.cross(ways, (0.6, 0.0, 0.8))
        aside /= np.linalg.norm(aside, axis=1)[:, None]
        turned = np.cos(wrong) * ways + np.sin(wrong) * aside
        there = coordinates(size * turned + nearness * points)
        rms, worst = _errors(film, lines, v, 21.6, there, coordinates(points), nearness, 0)
        assert (rms, worst) == pytest.approx((2.0 * np.sin(0.5 * wrong),) * 2, abs=1e-12)


def test_the_d_line_decides_whether_the_regions_of_a_picture_can_be_fitted():
    """Of some colours the regions are irregular, of others not: a picture that has begun must not end in an error."""
    lens = lenses.load("nikon-af-s-nikkor-g-ed-18-35-f35")
    lens = lens.with_stop_radius(0.7 * lens.stop.semi_diameter)
    camera = lb.LensCamera(lens, lb.Film(36.0, 24.0, 60, 40), model="polynomial")
    irregular = [PupilTable.of(lens, camera.film_distance, camera.film.diagonal / 2.0, colour, widened=False).irregular
                 for colour in (D_LINE, 0.46)]
    assert irregular == [False, True]
    assert np.isfinite(camera.generate_rays([[20.0, 20.0]], [[0.5, 0.5]], wavelength=0.46)[0]).all()
