"""Ghosts of two reflections: the closed form of a plate, a brute-force trace, block against scalar."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.analysis.ghost_ranking import light_place
from lensbench.core.cameras.film_landing import landing_step
from lensbench.core.kernels.block import lane_buffer
from lensbench.core.optics.ghost_grid import entrance_grid, grid_rays, pair_boxes
from lensbench.core.optics.ghost_path import DIRECT, ghost_order, ghost_pairs, ghost_path, no_such_pair, pair_share
from lensbench.core.optics.ghost_trace import GhostTracer
from tests.core.oracles import of_one_colour

N = 1.5
PLATE = lb.Lens((lb.Surface(4.0, 20.0, lb.Glass(N), curvature=0.0), lb.Surface(50.0, 20.0, curvature=0.0)), 0)
GAUSS = lenses.load("pbrt-dgauss-50mm")
POSES = {0: (0.0, 0.4, 0.0, 0.03), 2: (0.5, -0.3, 0.04, -0.05), 5: (0.0, 0.3, 0.1, 0.0)}
BODIES = {0: 0, 1: 0, 2: 2, 3: 2, 5: 5}         # moved surfaces, and about which vertex they turn as one body
BENT = replace(GAUSS, surfaces=tuple(
    replace(surface, pose=lb.SurfacePose(*POSES[BODIES[i]], pivot=i - BODIES[i]) if i in BODIES else None)
    for i, surface in enumerate(GAUSS.surfaces)))
RASTER = [landing_step(lb.Film(36.0, 24.0, 96, 64), 1.0)]


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


@pytest.mark.parametrize("pair", [(3, 3), (5, 2), (-1, 4), (0, 11), (9, 40)])
def test_a_pair_that_the_lens_does_not_have_is_refused(pair):
    """The kernel called whatever lay behind its list of stages: a window that kept a pair of the lens before ended."""
    tracer, rays = GhostTracer(GAUSS, 36.0, RASTER, real=np.float64), np.zeros((7, 1))
    with pytest.raises(lb.LensError, match=f"no ghost of surfaces {pair[0]} and {pair[1]}"):
        tracer.trace(lane_buffer(np.float64), pair, rays, np.empty((6, 1)))
    with pytest.raises(lb.LensError, match="from 0 to 10"):
        ghost_path(GAUSS, pair, (0.0, 0.0, -10.0), (0.0, 0.0, 1.0))


def _two_bounces(lens, pair, point, ray, n, bodies):
    """A brute-force trace: spheres by their centres, Snell's law in vectors, each surface written out in turn."""
    def placed(i, z):
        """The point of the axis at z, where the body of surface i has taken it: tilted about x, about y, and moved."""
        if i not in bodies:
            return np.array([0.0, 0.0, z])
        right, up, a, b = POSES[bodies[i]]
        pivot = lens.vertices[bodies[i]]
        y, z = -(z - pivot) * math.sin(a), (z - pivot) * math.cos(a)
        return np.array([z * math.sin(b) + right, y + up, z * math.cos(b) + pivot])

    def sphere(i):
        vertex, c = placed(i, lens.vertices[i]), lens.surfaces[i].curvature
        p, d, axis = point, ray, placed(i, lens.vertices[i] + 1.0) - vertex
        if c == 0.0:
            return p + (vertex - p) @ axis / (d @ axis) * d, axis
        centre = placed(i, lens.vertices[i] + 1.0 / c)
        b, e = d @ (p - centre), (p - centre) @ (p - centre) - 1.0 / c**2
        hits = [p + t * d for t in (-b - math.sqrt(b * b - e), -b + math.sqrt(b * b - e))]
        hit = min(hits, key=lambda h: abs((h - vertex) @ axis))
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


@pytest.mark.parametrize("pair", [(0, 1), (2, 7)])
def test_the_share_of_a_pair_is_that_of_fresnel_for_the_indices_of_its_colour(pair):
    lens, wavelength = lenses.load("lib-tronnier-1953"), 0.4358
    n = np.array(lens.indices(wavelength))
    reflected = ((n[1:] - n[:-1]) / (n[1:] + n[:-1])) ** 2
    mirrors = (i for i, _, mirror in ghost_order(len(lens.surfaces), pair) if mirror)
    passed = np.prod([1.0 - reflected[i] for i, _, mirror in ghost_order(len(lens.surfaces), pair) if not mirror])
    expected = passed * np.prod([reflected[i] for i in mirrors])
    assert pair_share(lens, pair, wavelength) == pytest.approx(expected, rel=1e-12)
    assert pair_share(lens, pair) != pytest.approx(expected, rel=1e-4)
    one = of_one_colour(lens, wavelength)
    assert pair_share(lens, pair, wavelength, "single-layer") == pytest.approx(
        pair_share(one, pair, wavelength, "single-layer"), rel=1e-12)
    assert pair_share(one, pair, wavelength, "single-layer") > 1.5 * pair_share(one, pair, lb.D_LINE, "single-layer")


def test_pairs_of_which_one_reflects_need_no_reason():
    for pairs in ((), ((0, 1),), ((0, 9), (0, 1)), ((0, 9), DIRECT)):
        assert no_such_pair(PLATE, pairs) == "", pairs
    assert "no ghost of surfaces 0 and 9" in no_such_pair(PLATE, ((0, 9), (3, 4)))


@pytest.mark.parametrize("pair", [(0, 1), (1, 9), (3, 8), (2, 4)])
@pytest.mark.parametrize(("lens", "bodies"), [(GAUSS, {}), (BENT, BODIES)])
def test_a_traced_pair_is_the_brute_force_trace(pair, lens, bodies):
    for x, y, tilt in ((0.3, 0.2, 0.0), (2.0, -1.0, 0.02)):
        ray = np.array([tilt, 0.5 * tilt, 1.0]) / math.hypot(tilt, 0.5 * tilt, 1.0)
        start = np.array([x, y, -10.0])
        found = ghost_path(lens, pair, start, ray, clip=False)
        point, after = _two_bounces(lens, pair, start, ray, lens.indices(), bodies)
        assert np.allclose(found.points[-1], point, atol=1e-10) and np.allclose(found.direction, after, atol=1e-12)


@pytest.mark.parametrize(("lens", "blades", "real"), [
    (GAUSS, 6, np.float64), (GAUSS, 0, np.float32), (BENT, 5, np.float64),
    pytest.param("lentil-schneider-anamorphic-31-2001", 0, np.float64, marks=pytest.mark.slow)])
def test_block_and_scalar_agree(lens, blades, real):
    lens = replace(lenses.load(lens) if isinstance(lens, str) else lens, blades=blades, blade_reach=1.0)
    distance = lb.film_distance(lens, math.inf)
    tracer = GhostTracer(lens, distance, RASTER, coating="multi-layer", real=real)
    lanes, light = lane_buffer(real), light_place(lens, distance, (0.05, 0.03, math.inf))
    met = 0
    for pair in ghost_pairs(lens)[::6]:
        boxes = pair_boxes(tracer, lanes, light, pair)
        if not boxes:
            continue
        box = boxes[0]
        rays, grid = grid_rays(tracer, light, box, 21), entrance_grid(tracer, lanes, light, pair, box, 21)
        scan = entrance_grid(tracer, lanes, light, pair, box, 21, reflecting=False)
        assert np.array_equal(scan[[0, 1, 5]], grid[[0, 1, 5]], equal_nan=True)     # the search sees the same rays
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


def test_a_ghost_ray_that_a_surface_within_turns_against_its_travel_ends_there():
    """Light on its way back leaves the flank of a ball beside its equator, away from the normal: see the tracer's test.

    A mirror of 45° in the ball sends it there.
    """
    edge, way = math.radians(3.0), np.array([0.0, math.cos(math.radians(0.5)), -math.sin(math.radians(0.5))])
    flank = np.array([0.0, 10.0 * math.cos(edge), 35.0 - 10.0 * math.sin(edge)])
    mirror = flank - 5.0 * way
    tilt = math.atan2(way[1], 1.0 - way[2])
    gap = mirror[2] - mirror[1] * math.tan(tilt) - 25.0
    lens = lb.Lens((lb.Surface(25.0, 99.0, lb.Glass(1.3), curvature=0.0),
                    lb.Surface(gap, 9.9999, lb.Glass(1.9), curvature=0.1),
                    lb.Surface(10.0, 30.0, curvature=0.0, pose=lb.SurfacePose(tilt_x=tilt)),
                    lb.Surface(5.0, 30.0, curvature=0.0)), 3)
    back = lb.trace(lb.Lens(lens.surfaces[:2], 0), mirror, [0.0, 0.0, -1.0])
    path = ghost_path(lens, (0, 2), back.points[0] + 5.0 * back.directions[0], -back.directions[0])
    assert (path.fate, path.weight) == (lb.Fate.BACKWARD, 0.0)
    assert np.allclose(path.points[-1], flank, atol=1e-9)


@pytest.mark.parametrize("towards", [(0.3, -0.5, -1.0), (-0.95, 0.2, -0.2), (0.0, 0.0, -1.0)])
@pytest.mark.parametrize("near", [False, True])
def test_the_rays_of_a_grid_carry_the_light_of_its_rectangle_across_the_beam(towards, near):
    """That of the area for a far light, of the solid angle for a near one; midpoints of 60² cells know it to 10⁻³."""
    towards = np.array(towards) / np.linalg.norm(towards)
    tracer = GhostTracer(GAUSS, lb.film_distance(GAUSS, math.inf), RASTER, real=np.float64)
    light = np.append(40.0 * towards + ([0.0, 0.0, tracer.front_z] if near else 0.0), float(near))
    if not near:
        light[:3] = towards
    box, cells = (-5.0, -7.0, 12.0, 9.0), 60
    rays = grid_rays(tracer, light, box, cells, (0.5, 0.5)).reshape(7, cells + 1, cells + 1)[:, :-1, :-1].reshape(7, -1)
    places = rays[:3].T - [0.0, 0.0, tracer.front_z]
    np.testing.assert_allclose(places @ towards, 0.0, atol=1e-12)
    if near:
        sight = places - 40.0 * towards
        np.testing.assert_allclose(rays[3:6].T, sight / np.linalg.norm(sight, axis=1)[:, None], atol=1e-12)
        light_there = 40.0**2 * sum(
            sign * math.atan(a * b / (40.0 * math.sqrt(a * a + b * b + 40.0**2)))
            for a, b, sign in ((12.0, 9.0, 1), (-5.0, 9.0, -1), (12.0, -7.0, -1), (-5.0, -7.0, 1)))
    else:
        np.testing.assert_allclose(rays[3:6].T, np.tile(-towards, (cells * cells, 1)), atol=1e-12)
        light_there = 17.0 * 16.0
    assert rays[6].sum() == pytest.approx(light_there, rel=1e-3)
