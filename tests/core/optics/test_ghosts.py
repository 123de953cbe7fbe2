"""Ghosts of two reflections: closed forms of plate and singlet, a brute-force trace, block against scalar, energy."""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.analysis.ghost_ranking import ghosts, light_place, paraxial_ghost
from lensbench.analysis.reflection_tree import light_budget
from lensbench.cameras.film_landing import landing_step
from lensbench.kernels.block import lane_buffer
from lensbench.optics.finding import Kind
from lensbench.optics.ghost_grid import entrance_grid, grid_rays, pair_box
from lensbench.optics.ghost_trace import GhostTracer, ghost_pairs, ghost_path
from lensbench.rendering.ghost_cells import add_cells
from lensbench.rendering.ghost_image import Flare, GhostImage

N = 1.5
R = ((N - 1.0) / (N + 1.0)) ** 2
PLATE = lb.Lens((lb.Surface(0.0, 4.0, 20.0, lb.Glass(N)), lb.Surface(0.0, 50.0, 20.0)), 0)
GAUSS = lenses.load("pbrt-dgauss-50mm")
FILM = lb.Film(36.0, 24.0, 24, 16)
RASTER = [landing_step(lb.Film(36.0, 24.0, 96, 64), 1.0)]


def test_a_plate_reflects_the_geometric_series_and_its_budget_is_whole():
    found = light_budget(PLATE, (0.0, 0.0, -5.0), (0.0, 0.0, 1.0), least=1e-12)
    assert found.to_film[0] == pytest.approx((1.0 - R)**2, rel=1e-12)
    assert found.to_film[2] == pytest.approx((1.0 - R)**2 * R**2, rel=1e-12)
    assert sum(found.to_film) == pytest.approx((1.0 - R) / (1.0 + R), abs=1e-9)
    assert found.total == pytest.approx(1.0, abs=1e-12) and found.left < 1e-9


def test_the_ghost_of_a_tilted_ray_leaves_a_plate_two_thicknesses_aside():
    angle = 0.4
    inside = math.asin(math.sin(angle) / N)
    ray = (math.sin(angle), 0.0, math.cos(angle))
    path = ghost_path(PLATE, (0, 1), (0.0, 0.0, 0.0), ray)
    assert path.points[-1, 0] - path.points[2, 0] == pytest.approx(2.0 * 4.0 * math.tan(inside), rel=1e-12)
    assert np.allclose(path.direction, ray, atol=1e-14)
    s = (math.sin(angle - inside) / math.sin(angle + inside))**2
    p = (math.tan(angle - inside) / math.tan(angle + inside))**2
    mean = 0.5 * (s + p)
    assert path.weight == pytest.approx(mean**2 * (1.0 - mean)**2, rel=1e-12)
    found = light_budget(PLATE, (0.0, 0.0, 0.0), ray, least=1e-12)
    assert sum(found.to_film) == pytest.approx((1.0 - mean) / (1.0 + mean), abs=1e-9)


def test_the_ghost_of_a_thin_singlet_focuses_where_the_closed_form_says():
    """A thin lens of power φ and two reflections has the power φ (3 n − 1) / (n − 1)."""
    c, d = 0.01, 1e-7
    thin = lb.Lens((lb.Surface(c, d, 1.0, lb.Glass(N)), lb.Surface(-c, 100.0, 1.0)), 0)
    focus, diameter, share = paraxial_ghost(thin, 30.0, (0, 1))
    short = 100.0 * (N - 1.0) / (3.0 * N - 1.0)
    assert focus + 30.0 == pytest.approx(short, rel=1e-6)
    assert diameter == pytest.approx(2.0 * (30.0 / short - 1.0), rel=1e-6) and share == pytest.approx(R**2, rel=1e-9)
    near = ghost_path(thin, (0, 1), (1e-4, 0.0, -1.0), (0.0, 0.0, 1.0))
    assert near.points[-1, 2] - near.points[-1, 0] * near.direction[2] / near.direction[0] == pytest.approx(short,
                                                                                                          rel=1e-5)


def test_every_order_of_a_singlet_adds_up_to_one():
    one = lb.Lens((lb.Surface(0.02, 6.0, 12.0, lb.Glass(1.7)), lb.Surface(-0.03, 40.0, 12.0)), 0)
    for ray, coating in (((0.0, 0.1, 1.0), "uncoated"), ((0.3, 0.0, 1.0), "single-layer")):
        found = light_budget(one, (3.0, 2.0, -1.0), ray, coating=coating, least=1e-9)
        assert found.total == pytest.approx(1.0, abs=1e-12) and found.left < 1e-6
    direct = light_budget(one, (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)).to_film[0]
    assert direct == pytest.approx(lb.transmission(one), rel=1e-12)


def _two_bounces(lens, pair, point, ray, n):
    """A brute-force trace: spheres by their centres, Snell's law in vectors, each surface written out in turn."""
    def sphere(i):
        vertex, c = lens.vertices[i], lens.surfaces[i].curvature
        p, d = point, ray
        if c == 0.0:
            return p + (vertex - p[2]) / d[2] * d, np.array([0.0, 0.0, 1.0])
        centre = np.array([0.0, 0.0, vertex + 1.0 / c])
        b, e = d @ (p - centre), (p - centre) @ (p - centre) - 1.0 / c**2
        hits = [p + t * d for t in (-b - math.sqrt(b * b - e), -b + math.sqrt(b * b - e))]
        hit = min(hits, key=lambda h: abs(h[2] - vertex))
        return hit, (hit - centre) * abs(c)

    first, second = pair
    plan = [(i, 1) for i in range(second)] + [(second, 0)] + [(i, -1) for i in range(second - 1, first, -1)]
    plan += [(first, 0)] + [(i, 1) for i in range(first + 1, len(lens.surfaces))]
    for i, way in plan:
        point, normal = sphere(i)
        if way == 0:
            ray = ray - 2.0 * (ray @ normal) * normal
            continue
        a, b = (n[i], n[i + 1]) if way > 0 else (n[i + 1], n[i])
        normal = normal if ray @ normal > 0.0 else -normal
        across = (ray - (ray @ normal) * normal) * a / b
        ray = across + math.sqrt(1.0 - across @ across) * normal
    return point, ray


@pytest.mark.parametrize("pair", [(0, 1), (1, 9), (3, 8), (2, 4)])
def test_a_traced_pair_is_the_brute_force_trace(pair):
    for x, y, tilt in ((0.3, 0.2, 0.0), (2.0, -1.0, 0.02)):
        ray = np.array([tilt, 0.5 * tilt, 1.0]) / math.hypot(tilt, 0.5 * tilt, 1.0)
        start = np.array([x, y, -10.0])
        found = ghost_path(GAUSS, pair, start, ray, clip=False)
        point, after = _two_bounces(GAUSS, pair, start, ray, GAUSS.indices())
        assert np.allclose(found.points[-1], point, atol=1e-10) and np.allclose(found.direction, after, atol=1e-12)


@pytest.mark.parametrize(("name", "blades", "real"), [
    ("pbrt-dgauss-50mm", 6, np.float64), ("pbrt-dgauss-50mm", 0, np.float32),
    pytest.param("lentil-schneider-anamorphic-31-2001", 0, np.float64, marks=pytest.mark.slow)])
def test_block_and_scalar_agree(name, blades, real):
    lens = replace(lenses.load(name), blades=blades)
    distance = lb.film_distance(lens, math.inf)
    tracer = GhostTracer(lens, distance, RASTER, coating="multi-layer", real=real)
    lanes, light = lane_buffer(real), light_place(lens, distance, (0.05, 0.03, math.inf))
    met = 0
    for pair in ghost_pairs(lens)[::6]:
        box = pair_box(tracer, lanes, light, pair)
        if box is None:
            continue
        rays, grid = grid_rays(tracer, light, box, 21), entrance_grid(tracer, lanes, light, pair, box, 21)
        for k in range(0, rays.shape[1], 53):
            start = rays[:3, k].astype(float) - [0.0, 0.0, tracer.front_z]
            path = ghost_path(lens, pair, start, rays[3:6, k], coating="multi-layer")
            if abs(float(grid[5, k]) - 1.0) < 1e-4:
                continue                                # on the very edge, rounding decides
            assert (path.weight > 0.0) == (grid[2, k] > 0.0)
            if path.weight > 0.0:
                met += 1
                t = (lens.length + distance - path.points[-1, 2]) / path.direction[2]
                x, y = path.points[-1, :2] + t * path.direction[:2]
                close = 1e-9 if real is np.float64 else 5e-3
                assert math.hypot(grid[0, k] - (18.0 - x) * 96 / 36, grid[1, k] - (12.0 + y) * 64 / 24) < close
                light_there = path.weight * rays[6, k] / (36 / 96 * 24 / 64)
                assert grid[2, k] == pytest.approx(light_there, rel=1e-2)       # between the nodes of the tables
    assert met > 20


def test_the_traced_table_agrees_with_the_paraxial_estimate_on_the_axis():
    lens = lb.stopped_down(GAUSS, 32.0)                 # so narrow that aberrations are small
    found = ghosts(lens, lb.film_distance(lens, math.inf))
    assert len(found.rows) == 45 and found.rows[0].brightness >= found.rows[-1].brightness
    for row in found.rows:
        # A grid of 31 cells counts the rays within a circle to some percent
        assert row.share == pytest.approx(row.paraxial_share, rel=0.1)
        assert row.diameter == pytest.approx(row.paraxial_diameter, rel=0.1, abs=0.01)


def test_cells_keep_the_light_and_fill_what_they_cover_evenly():
    x, y = np.meshgrid(np.linspace(4.3, 26.7, 8), np.linspace(2.2, 15.9, 8))
    found = np.ones((6, 64), np.float32)
    found[0], found[1] = x.ravel() + 0.3 * y.ravel(), y.ravel()
    film, gain = np.zeros((40 * 20, 3), np.float32), np.array([1.0, 2.0, 0.5], np.float32)
    for top, bottom in ((0, 7), (7, 20)):               # threads take rows of their own
        add_cells(film, found, 7, 40, top, bottom, gain)
    assert np.allclose(film.sum(0), 49.0 * gain, rtol=2e-2)
    inner = film.reshape(20, 40, 3)[6:12, 12:20, 1]
    assert np.allclose(inner, inner[0, 0], rtol=1e-5)
    found[:2] = 5.5                                     # a focus: all light on one pixel
    film[:] = 0.0
    add_cells(film, found, 7, 40, 0, 20, gain)
    assert np.allclose(film[5 * 40 + 5], 49.0 * gain, rtol=1e-5)


def test_the_light_of_a_picture_of_ghosts_is_that_of_the_table():
    """The sun on the axis: the sum over the film of each pair is its share of the sun's picture."""
    lens = lb.stopped_down(GAUSS, 16.0)
    camera = lb.LensCamera(lens, lb.Film(36.0, 24.0, 96, 64), weights="physical")
    scene = lb.Scene((), sun=lb.Sun((0.0, 0.0, -1.0), (1.0, 1.0, 1.0)))
    row = next(row for row in ghosts(lens, camera.film_distance).rows if 2.0 < row.diameter < 8.0)
    sums = []
    with ThreadPoolExecutor(2) as pool:
        for threads, strength in ((1, 1.0), (2, 0.5)):
            image = GhostImage(camera, scene, Flare(strength=strength, pairs=((row.first, row.second),)))
            image.add(1, pool, threads, lambda: True)
            picture = np.zeros((64, 96, 3), np.float32)
            image.add_to(picture)
            sums.append(picture)
    assert np.allclose(sums[0], 2.0 * sums[1], rtol=1e-5)
    direct = lb.Rendering(camera, scene)
    direct.add(64, threads=2)
    assert sums[0][..., 1].sum() == pytest.approx(row.share * direct.image()[..., 1].sum(), rel=0.06)


def test_a_picture_that_can_have_no_ghosts_says_why():
    scene = lb.Scene((), sun=lb.Sun((0.0, 0.0, -1.0)))
    assert "surfaces" in GhostImage(lb.PerspectiveCamera(lb.Film(), 0.6), scene, Flare()).reason
    first, *others = GAUSS.surfaces
    tilted = replace(GAUSS, surfaces=(replace(first, pose=lb.SurfacePose(tilt_x=0.02)), *others))
    for camera, words in ((lb.LensCamera(tilted, FILM), "out of line"),
                          (lb.LensCamera(GAUSS, FILM, medium=lb.Medium.water(5000.0)), "port")):
        finding, = lb.Rendering(camera, scene, flare=Flare()).findings
        assert finding.kind == Kind.NO_GHOSTS and words in finding.message
        assert lb.Rendering(camera, scene).findings == ()


def test_lights_beyond_the_brightest_are_counted_in_a_finding():
    lamp = lb.Material((1.0, 1.0, 1.0), "light")
    lamps = tuple(lb.Sphere((300.0 * (i % 10 - 5), 300.0 * (i // 10 - 3), -9000.0), 12.0, lamp) for i in range(50))
    with ThreadPoolExecutor(1) as pool:
        for count, expected in ((50, [2.0]), (48, [])):
            image = GhostImage(lb.LensCamera(GAUSS, FILM), lb.Scene(spheres=lamps[:count]), Flare(pairs=((0, 1),)))
            image.add(1, pool, 1, lambda: True)
            assert [each.figures["lights"] for each in image.findings] == expected
            assert all(each.kind == Kind.DIM_LIGHTS and 0.03 < each.figures["share"] < 0.05
                       and "2 dimmer lights" in str(each) for each in image.findings)
