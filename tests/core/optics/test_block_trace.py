"""The block kernel against the scalar reference, and float32 against float64 on a large sensor."""

from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.kernels.block import CLEARANCE, WEIGHT, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.optics.block_trace import surface_steps
from tests.core.optics.test_surfaces import rays_that_leave_an_ellipsoid_behind_its_equator
from tests.core.oracles import lens as reference_lens


def reshaped(change):
    """The aspheric 50/1.8 with each surface changed: change(surface, index) gives the fields."""
    lens = reference_lens("rf50")
    return replace(lens, surfaces=tuple(replace(s, **change(s, i)) for i, s in enumerate(lens.surfaces)))


ASPHERIC = {
    "even": reference_lens("rf50"),
    "conics": reshaped(lambda s, i: {"aspheric": (), "conic": (-0.6, 0.8, -2.0, 0.3)[i % 4]}),
    "odd": reshaped(lambda s, i: {"aspheric": (*s.aspheric, (3, 1e-5), (5, -2e-6)) if s.aspheric else ()}),
    "conic aspheres": reshaped(lambda s, i: {"conic": -0.5} if s.aspheric else {"aspheric": ((4, 1e-7), (20, 1e-28))}),
    "toroids": reshaped(lambda s, i: {"aspheric": (), "curvature_x": 0.7 * s.curvature if i % 2 else None}),
    "cylinders": reshaped(lambda s, i: {"aspheric": (), "curvature_x": 0.0 if i > 7 else None}),
}
NAMES = ["pbrt-dgauss-50mm", "pbrt-fisheye-10mm", "pbrt-wide-22mm", "lenshh-cooke-triplet-50"]


def block(lens, film_distance, origins, directions, towards="scene", real=np.float64):
    """Rows X … N, WEIGHT, CLEARANCE of rays given in the lens frame, and answered in it."""
    shift = lens.length + film_distance
    o = np.array(origins) - [0.0, 0.0, shift]
    out = Program(surface_steps(lens, film_distance, towards=towards), real).run(
        dict(zip([X, Y, Z, L, M, N, WEIGHT], [*o.T, *np.array(directions).T, np.ones(len(o))], strict=True)),
        [X, Y, Z, L, M, N, WEIGHT, CLEARANCE], len(o))
    out[2] += shift
    return out


def film_rays(lens, film_distance, n, rng, spread=1.3, film=15.0):
    """Rays from film points to the rear element and beyond, in the lens frame."""
    rear = lens.surfaces[-1].semi_diameter * spread
    origins = np.stack([*rng.uniform(-film, film, (2, n)), np.full(n, lens.length + film_distance)], 1)
    targets = np.stack([*rng.uniform(-rear, rear, (2, n)), np.full(n, lens.length)], 1)
    d = targets - origins
    return origins, d / np.linalg.norm(d, axis=1)[:, None]


def found(name):
    """A lens of ASPHERIC, or of the library."""
    return ASPHERIC[name] if name in ASPHERIC else lenses.load(name)


@pytest.mark.parametrize("name", [*NAMES, *ASPHERIC])
@pytest.mark.parametrize("towards", ["scene", "film"])
def test_the_block_kernel_agrees_with_the_reference(name, towards):
    lens = found(name)
    distance = lb.first_order(lens).bfl
    rng = np.random.default_rng(3)
    if towards == "scene":
        origins, directions = film_rays(lens, distance, 20_000, rng)
    else:
        a = lens.surfaces[0].semi_diameter
        origins = np.stack([*rng.uniform(-a, a, (2, 20_000)), np.full(20_000, -5.0)], 1)
        directions = np.stack([*rng.uniform(-0.5, 0.5, (2, 20_000)), np.ones(20_000)], 1)
        directions /= np.linalg.norm(directions, axis=1)[:, None]
    reference = lb.trace(lens, origins, directions)
    out = block(lens, distance, origins, directions, towards)
    passed = reference.fate == lb.Fate.PASSED
    assert np.array_equal(out[6] > 0.0, passed)
    assert 100 < passed.sum() < 19_900                              # both kinds are there
    np.testing.assert_allclose(out[:3].T[passed], reference.points[passed], rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(out[3:6].T[passed], reference.directions[passed], rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("name", NAMES)
def test_float32_keeps_every_fate_and_a_hundredth_of_a_pixel_at_24_megapixels(name):
    """A 36 × 24 mm film of 6000 × 4000 pixels: the direction's error on the film is angle × focal length."""
    lens = lenses.load(name)
    fo = lb.first_order(lens)
    count = 200_000
    rng = np.random.default_rng(5)
    # rays through the sampled region, as a camera makes them; the rim's last 1e-5 decides either way
    camera = lb.LensCamera(lens, lb.Film(pixels_x=6000, pixels_y=4000))
    raster, uv = rng.uniform(0.0, 1.0, (count, 2)) * [6000, 4000], rng.uniform(0.0, 1.0, (count, 2))
    program = [camera.film.step, camera.camera_steps()[0]]
    rows = Program(program, np.float32).run(
        {X: raster[:, 0], Y: raster[:, 1], 0: uv[:, 0], 1: uv[:, 1]}, [X, Y, Z, L, M, N], count)
    given = dict(zip([X, Y, Z, L, M, N, WEIGHT], [*rows, np.ones(count, np.float32)], strict=True))
    steps = camera.camera_steps()[1:]
    single = Program(steps, np.float32).run(given, [L, M, N, WEIGHT, CLEARANCE], count).astype(float)
    double = Program(steps, np.float64).run(given, [L, M, N, WEIGHT, CLEARANCE], count)
    sure = ~(np.abs(double[4] - 1.0) < 1e-5)
    assert np.array_equal((single[3] > 0.0)[sure], (double[3] > 0.0)[sure])
    both = (single[3] > 0.0) & (double[3] > 0.0)
    cross = np.linalg.norm(np.cross(single[:3].T[both], double[:3].T[both]), axis=1)
    pixels = cross * fo.efl / (36.0 / 6000)
    assert pixels.max() < 0.01


@pytest.mark.parametrize("name", ASPHERIC)
def test_aspheres_in_float32_keep_a_hundredth_of_a_pixel(name):
    lens = ASPHERIC[name]
    distance = lb.first_order(lens).bfl
    origins, directions = film_rays(lens, distance, 50_000, np.random.default_rng(7))
    double = block(lens, distance, origins, directions)
    single = block(lens, distance, origins, directions, real=np.float32).astype(float)
    sure = ~(np.abs(double[7] - 1.0) < 1e-5)
    assert np.array_equal((single[6] > 0.0)[sure], (double[6] > 0.0)[sure])
    both = (single[6] > 0.0) & (double[6] > 0.0)
    angle = np.linalg.norm(np.cross(single[3:6].T[both], double[3:6].T[both]), axis=1)
    assert (angle * 49.56 / 0.006).max() < 0.01


def test_a_hit_on_a_steep_hyperboloid_far_beside_its_vertex_keeps_its_digits():
    """There the usual quotient of the intersection cancels, and its other form is taken."""
    lens = lb.Lens((lb.Surface(5.0, 30.0, lb.Glass(1.6), curvature=0.05, conic=-10.0),), 0)
    rng = np.random.default_rng(2)
    origins = np.stack([*rng.uniform(-25.0, 25.0, (2, 5000)), np.full(5000, -10.0)], 1)
    directions = np.stack([*rng.uniform(-0.8, 0.8, (2, 5000)), np.ones(5000)], 1)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    reference = lb.trace(lens, origins, directions)
    out = block(lens, 40.0, origins, directions, "film")
    passed = reference.fate == lb.Fate.PASSED
    assert np.array_equal(out[6] > 0.0, passed) and 100 < passed.sum() < 4900
    np.testing.assert_allclose(out[:3].T[passed], reference.points[passed], rtol=0.0, atol=1e-11)


def test_a_plane_and_a_sphere_of_a_million_kilometres_bend_a_ray_alike():
    for curvature in (0.0, 1e-9, -1e-9, 1e-12):
        lens = lb.Lens((lb.Surface(5.0, 10.0, lb.Glass(1.6), curvature=0.02),
                        lb.Surface(5.0, 12.0, curvature=curvature)), 0)
        rng = np.random.default_rng(0)
        origins, directions = film_rays(lens, 40.0, 500, rng, spread=0.5, film=5.0)
        for real, tolerance in ((np.float64, 1e-6), (np.float32, 2e-5)):
            flat = block(lb.Lens((lens.surfaces[0], lb.Surface(5.0, 12.0, curvature=0.0)), 0), 40.0, origins,
                         directions,
                         real=real)
            bent = block(lens, 40.0, origins, directions, real=real)
            assert np.abs(bent[:6] - flat[:6]).max() < tolerance


def test_rays_that_turn_backward_are_blocked_without_a_nan_in_their_weight():
    """A film six times too large: nothing but a blocked sample comes of it."""
    lens = lenses.load("pbrt-fisheye-10mm")
    origins, directions = film_rays(lens, lb.first_order(lens).bfl, 50_000, np.random.default_rng(1), 3.0, 130.0)
    reference = lb.trace(lens, origins, directions)
    out = block(lens, lb.first_order(lens).bfl, origins, directions)
    assert np.array_equal(out[6] > 0.0, reference.fate == lb.Fate.PASSED)
    assert set(np.unique(out[6])) <= {0.0, 1.0}


def test_strong_aspheres_lose_no_light_at_the_films_edge_in_single_precision():
    lens = lenses.load("lib-us10281683")                    # twelve aspheric surfaces, as telephones have them
    camera = lb.LensCamera(lens, lb.Film(6.6, 4.4, 600, 400), 300.0)
    rng = np.random.default_rng(5)
    raster, uv = rng.random((100_000, 2)) * [600, 400], rng.random((100_000, 2))
    single, double = (camera.generate_rays(raster, uv, dtype=real).weights > 0.0 for real in (np.float32, np.float64))
    assert double.mean() > 0.98
    # A ray within a rounding of a rim may fall on either side of it
    assert (single != double).sum() <= 5


def test_aspheres_that_take_many_steps_lose_no_light_in_single_precision():
    """At 46 mm from the axis of the shift lens, nine steps lost a quarter of the rays."""
    lens = lenses.load("fujifilm-fujinon-gf-t-s-30-f56")
    z, r = lb.film_distance(lens, np.inf), 46.3
    x, y = (a.ravel() for a in np.meshgrid(np.linspace(19.0, 20.6, 200), np.linspace(0.0, 4.0, 200)))
    way = np.column_stack([x - r, y, np.full(x.size, -z)])
    directions, origins = way / np.linalg.norm(way, axis=1)[:, None], np.tile([r, 0.0, lens.length + z], (x.size, 1))
    single, double = (block(lens, z, origins, directions, real=real)[6] > 0.0 for real in (np.float32, np.float64))
    assert double.sum() > 10_000 and (single != double).sum() <= 0.002 * double.sum()
    assert (double != (lb.trace(lens, origins, directions).fate == lb.Fate.PASSED)).sum() == 0


@pytest.mark.parametrize(("curvature", "conic"), [(0.1, 0.0), (0.1, 0.5), (0.08, -0.4)])
@pytest.mark.parametrize("terms", [(), ((4, 1e-30),)], ids=["conic", "asphere"])
def test_no_ray_that_meets_a_surface_behind_its_equator_alone_passes(curvature, conic, terms):
    surface, origins, directions = rays_that_leave_an_ellipsoid_behind_its_equator(curvature, conic)
    lens = lb.Lens((replace(surface, aspheric=terms), lb.Surface(0.0, 1e3, curvature=0.0)), 0)
    weight, clearance = block(lens, 50.0, origins, directions, "film")[6:]
    assert not (weight > 0.0).any() and np.isinf(clearance).all()


@pytest.mark.parametrize("fields", [{}, {"conic": 0.5}, {"aspheric": ((4, 1e-9),)}, {"aspheric": ((3, 1e-9),)},
                                    {"curvature_x": 0.09}], ids=["sphere", "conic", "even", "odd", "toroid"])
def test_a_ray_higher_than_the_equator_misses_every_kind_of_surface(fields):
    surface = lb.Surface(3.0, 1e3, curvature=0.1, **fields)          # air behind it: the ray would go on
    lens = lb.Lens((surface, lb.Surface(0.0, 1e3, curvature=0.0)), 0)
    heights = np.linspace(10.01, 14.0, 50) / np.sqrt(1.0 + surface.conic)
    origins = np.stack([np.zeros(50), heights, np.full(50, -2.0)], 1)
    directions = np.tile([0.0, 0.0, 1.0], (50, 1))
    assert (lb.trace(lens, origins, directions).fate == lb.Fate.MISSED).all()
    assert not (block(lens, 50.0, origins, directions, "film")[6] > 0.0).any()
    below = block(lens, 50.0, origins * [1.0, 0.4, 1.0], directions, "film")
    assert (below[6] > 0.0).all()
