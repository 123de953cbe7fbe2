"""Lenses with cylinders: their cameras sample regions that no turn about the axis maps onto each other."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.kernels.block import U0, U1, WEIGHT, L, M, N, X, Y
from lensbench.core.kernels.program import Program
from lensbench.core.pupils.film_grid_sampler import PupilGrid, SpectralPupilGrid
from lensbench.core.pupils.outline_solver import Aim, solve_outlines

FILM = lb.Film(24.0, 18.0, 480, 360)
POINTS = [(0.0, 0.0), (5.0, 0.0), (0.0, 6.0), (-7.3, 5.1), (9.0, -3.0)]        # mm


@pytest.fixture(scope="module")
def camera():
    return lb.LensCamera(lenses.load("lentil-schneider-anamorphic-31-2001"), FILM, 3000.0)


def camera_lens(stop):
    return lenses.load("lentil-schneider-anamorphic-31-2001").with_stop_radius(stop)


def square():
    k = np.arange(1 << 15)
    return np.column_stack([(k + 0.5) / len(k), k * 0.6180339887498949 % 1.0])


def quadrature(camera, x, y):
    """∫ cos⁴θ dA (mm²) over what passes from a film point, by a grid of rays of the scalar reference."""
    lens, z, a = camera.lens, camera.film_distance, 1.02 * camera.lens.surfaces[-1].semi_diameter
    # A rear rim has sag: seen slantwise it lies beside its own height
    steps = (np.arange(700) + 0.5) / 350.0 - 1.0
    u, v = (grid.ravel() for grid in np.meshgrid(steps * a + 0.05 * x, steps * a + 0.05 * y))
    way = np.column_stack([u - x, v - y, np.full(u.size, -z)])
    passed = lb.trace(lens, [x, y, lens.length + z], way).fate == lb.Fate.PASSED
    cos2 = z * z / (way**2).sum(1)
    return float((passed * cos2**2).sum() * (a / 350.0) ** 2)


def rays_through_the_stop(lens, film_distance, n, random, wavelength=lb.D_LINE):
    """Film and rear points (m, 2) mm of n random rays from places of the stop, as far as they pass the whole lens."""
    behind = replace(lens, surfaces=lens.surfaces[lens.stop_index:], stop_index=0)
    height, angle = lens.stop.semi_diameter * np.sqrt(random.random(n)), 2.0 * math.pi * random.random(n)
    ways = np.column_stack([random.uniform(-0.5, 0.5, (n, 2)), np.ones(n)])
    starts = np.column_stack([height * np.cos(angle), height * np.sin(angle), np.zeros(n)]) - ways
    t = lb.trace(behind, starts, ways, wavelength)
    slopes = t.directions[:, :2] / t.directions[:, 2:]
    rear = t.points[:, :2] + (behind.length - t.points[:, 2:]) * slopes
    film = rear + film_distance * slopes
    film, rear = (points[(t.fate == lb.Fate.PASSED) & (abs(film) <= [20.0, 15.0]).all(1)] for points in (film, rear))
    passed = lb.trace(lens, np.column_stack([film, np.full(len(film), lens.length + film_distance)]),
                      np.column_stack([rear - film, np.full(len(film), -film_distance)]),
                      wavelength).fate == lb.Fate.PASSED
    return film[passed], rear[passed]


@pytest.mark.parametrize("seed", range(6))
def test_a_film_point_that_some_ray_reaches_is_lit_however_small_the_stop(seed):
    random = np.random.default_rng(seed)
    lens = camera_lens(0.02 * 500.0 ** random.random())
    if seed % 2:        # other cylinders, and rims that cut the field elsewhere
        lens = replace(lens, surfaces=tuple(
            surface if k == lens.stop_index else
            replace(surface, semi_diameter=surface.semi_diameter * random.uniform(0.6, 1.0),
                    curvature_x=surface.curvature_x and surface.curvature_x * random.uniform(0.5, 1.2))
            for k, surface in enumerate(lens.surfaces)))
    film_distance = random.uniform(42.0, 55.0)
    film, rear = rays_through_the_stop(lens, film_distance, 3000, random)
    assert len(film) > 300
    aim = Aim(lens, film_distance)
    places = np.column_stack([film, np.zeros(len(film))])
    assert (aim.clearances(places, rear) <= 1.0 + 1e-9).all()               # the stop itself was met to rounding
    assert (aim.find_light(places)[1] < 1.0).all()
    few = film[:60]
    assert solve_outlines(lens, film_distance, few, 24, 1e-3 * lens.stop.semi_diameter)[1].any((1, 2)).all()


@pytest.mark.slow
def test_irradiance_is_that_of_quadrature(camera):
    raster = [((0.5 - x / 24.0) * 480.0, (y / 18.0 + 0.5) * 360.0) for x, y in POINTS]
    axis = quadrature(camera, 0.0, 0.0)
    for place, (x, y) in zip(raster, POINTS, strict=True):
        weights = camera.generate_rays(np.tile(place, (1 << 15, 1)), square()).weights
        # 700 cells across resolve a rim to about a thousandth; the relative weight of the axis is 1
        assert weights.mean() == pytest.approx(quadrature(camera, x, y) / axis, rel=1e-3)


def test_nearly_every_sample_passes(camera):
    random = np.random.default_rng(1)
    n = 40000
    weights = camera.generate_rays(random.random((n, 2)) * [480, 360], random.random((n, 2))).weights
    assert (weights > 0.0).mean() > 0.9


def test_the_squeeze_is_that_of_the_two_sections(camera):
    lens = lenses.load("lentil-schneider-anamorphic-31-2001")
    far = lb.LensCamera(lens, FILM, math.inf)
    rays = far.generate_rays([[240.0, 180.0], [241.0, 180.0], [240.0, 181.0]], np.tile([0.5, 0.5], (3, 1)))
    slopes = rays.directions[:, :2] / rays.directions[:, 2:]
    across, down = abs(slopes[1, 0] - slopes[0, 0]), abs(slopes[2, 1] - slopes[0, 1])
    ratio = lb.first_order(lens.section("y")).efl / lb.first_order(lens.section("x")).efl
    assert across / down == pytest.approx(ratio, rel=1e-3)          # but for distortion within a pixel
    assert ratio == pytest.approx(1.0 / 0.52, rel=1e-3)             # the published squeeze
    point = lb.trace(lens, [0.0, 0.0, -100.0], [1e-6, 0.0, 1.0])    # and the two sections are those of the tracer
    other = lb.trace(lens, [0.0, 0.0, -100.0], [0.0, 1e-6, 1.0])
    assert abs(point.directions[0, 0]) != pytest.approx(abs(other.directions[0, 1]), rel=0.1)


def test_the_outline_parts_the_rays_that_pass_from_those_that_do_not(camera):
    lens, z = camera.lens, camera.film_distance
    for x, y in POINTS:
        outline = lb.open_region(lens, z, (x, y))
        middle = outline.mean(0)
        for share, passes in ((1.0 - 1e-6, True), (1.0 + 1e-6, False)):
            points = middle + share * (outline - middle)
            way = np.column_stack([points - [x, y], np.full(len(points), -z)])
            passed = lb.trace(lens, [x, y, lens.length + z], way).fate == lb.Fate.PASSED
            assert (passed == passes).mean() > 0.99         # seen from elsewhere than its own centre it may lean


def test_film_points_in_all_quadrants_see_mirrored_regions(camera):
    uv = np.random.default_rng(2).random((500, 2))
    corner = camera.generate_rays(np.tile([60.0, 70.0], (500, 1)), uv)
    for sx, sy in ((-1, 1), (1, -1), (-1, -1)):
        other = camera.generate_rays(np.tile([240.0 - sx * 180.0, 180.0 - sy * 110.0], (500, 1)),
                                     np.where([sy < 0, sx < 0], 1.0 - uv, uv))      # mirrored as the film points are
        np.testing.assert_allclose(other.weights, corner.weights, rtol=1e-9)
        good = corner.weights > 0.0
        np.testing.assert_allclose(other.directions[good], corner.directions[good] * [sx, sy, 1.0], atol=1e-9)


@pytest.mark.parametrize("stop", [10.2, *(pytest.param(stop, marks=pytest.mark.slow) for stop in (1.02, 0.1))])
def test_no_light_is_lost_and_few_samples_are_where_it_ends_on_the_film(stop):
    lens, random, n = camera_lens(stop), np.random.default_rng(5), 40000
    grid = PupilGrid.of(lens, 43.34, 18.0, 12.0)
    film, rear = rays_through_the_stop(lens, 43.34, n, random)
    inside = (abs(film) <= [18.0, 12.0]).all(1)
    assert (grid.sampled_area(film[inside], rear[inside]) == 0.0).mean() < 5e-4
    # Of the weight of the samples nine tenths pass, in the last tenth of the way to the end of light as well
    film = (random.random((n, 2)) - 0.5) * [36.0, 24.0]
    given = {X: film[:, 0], Y: film[:, 1], U0: random.random(n), U1: random.random(n)}
    l, m, along, weight = Program([grid.step(1.0)], np.float64).run(given, [L, M, N, WEIGHT], n)
    starts = np.column_stack([film, np.full(n, lens.length + 43.34)])
    passed = weight * (lb.trace(lens, starts, np.stack([l, m, along], 1)).fate == lb.Fate.PASSED)
    assert passed.sum() > 0.97 * weight.sum()
    near = np.hypot(*(film / [18.0, 12.0]).T) > 0.85
    assert passed[near].sum() > 0.9 * weight[near].sum()


@pytest.mark.slow
@pytest.mark.parametrize("stop", [10.2, 0.3])
def test_no_light_of_any_colour_is_lost(stop):
    lens, random = camera_lens(stop), np.random.default_rng(6)
    grids = SpectralPupilGrid(lens, 43.34, 18.0, 12.0)
    for wavelength in (0.4209, 0.45, 0.5452, 0.6505):
        film, rear = rays_through_the_stop(lens, 43.34, 20000, random, wavelength)
        inside = (abs(film) <= [18.0, 12.0]).all(1)
        grid = grids.at(wavelength)
        area = grid.sampled_area(film[inside], rear[inside])
        assert (area == 0.0).mean() < 5e-4
        # And the regions are no larger than those solved at this very wavelength
        own = PupilGrid.of(lens, 43.34, 18.0, 12.0, wavelength).sampled_area(film[inside], rear[inside])
        assert area.sum() == pytest.approx(own.sum(), rel=0.01)
    assert PupilGrid.of(lens, 43.34, 18.0, 12.0, 0.7).nodes.edge == pytest.approx(grids.at(0.7).nodes.edge)


def test_for_a_lens_that_is_symmetric_the_grid_gives_what_the_table_gives():
    lens = lenses.load("pbrt-dgauss-50mm")
    distance = lb.film_distance(lens, 2000.0)
    step = PupilGrid.of(lens, distance, 18.0, 12.0).step(1.0)
    uv = square()
    for x, y in ((0.0, 0.0), (6.0, 8.0), (15.0, -9.0)):
        given = {X: np.full(len(uv), x), Y: np.full(len(uv), y), U0: uv[:, 0], U1: uv[:, 1]}
        l, m, n, weight = Program([step], np.float64).run(given, [L, M, N, WEIGHT], len(uv))
        passed = lb.trace(lens, [x, y, lens.length + distance], np.stack([l, m, n], 1)).fate == lb.Fate.PASSED
        exact = lb.exit_pupil(lens, distance, [math.hypot(x, y)]).cos4_area[0]
        assert (weight * passed).mean() == pytest.approx(exact, rel=1e-3)


def test_sampled_areas_are_those_of_the_weights(camera):
    grid, n = camera.pupil, 20000
    random = np.random.default_rng(4)
    film = np.tile([7.3, -5.1], (n, 1))
    given = {X: film[:, 0], Y: film[:, 1], U0: random.random(n), U1: random.random(n)}
    l, m, along, weight = Program([grid.step(1.0)], np.float64).run(given, [L, M, N, WEIGHT], n)
    rear = film - np.stack([l, m], 1) / along[:, None] * camera.film_distance
    np.testing.assert_allclose(grid.sampled_area(film, rear), weight / along**4, rtol=1e-9)


def test_what_assumes_symmetry_says_so(camera):
    for model in ("polynomial", "thick", "thin", "pinhole"):
        with pytest.raises(lb.CameraError, match="choose the full trace"):
            replace(camera, model=model)
    with pytest.raises(lb.LensError, match="open_region"):
        lb.exit_pupil(camera.lens, camera.film_distance, [0.0])
    with pytest.raises(lb.LensError, match="rotationally symmetric"):
        lb.chief_ray(camera.lens, 0.1)
    assert lb.choose_model(camera, lb.builtin_scene("room")).model == "trace"
