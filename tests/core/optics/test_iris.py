"""The stop's shape: areas and moments of rounded polygons, in pupils, in weights and in bokeh."""

import math
from dataclasses import replace

import numpy as np
import pytest

import lensbench as lb
from lensbench import lenses
from lensbench.core.kernels.block import U0, U1, WEIGHT, L, M, N, X, Y, Z
from lensbench.core.kernels.program import Program
from lensbench.core.optics.block_trace import trace_steps

FILM = lb.Film(36.0, 24.0, 960, 640)
SHAPES = [(3, 0.0, 0.0), (5, 0.3, 0.0), (6, -1.0, 0.5), (9, 2.0, 0.9), (7, 0.1, 0.999999)]


def arcs(blades, rotation, roundness, points=4000):
    """The edge by its definition: arcs through two corners of the unit circle and a point between them."""
    edge = []
    for k in range(blades):
        a, c = (rotation + math.pi / 2 + 2.0 * math.pi * (k + j) / blades for j in (0, 1))
        flat = math.cos(math.pi / blades)
        top = flat + roundness * (1.0 - flat)
        p, q, r = (size * np.array([math.cos(t), math.sin(t)])
                   for t, size in ((a, 1.0), (0.5 * (a + c), top), (c, 1.0)))
        if roundness == 0.0:
            edge.append(p + np.linspace(0.0, 1.0, points, endpoint=False)[:, None] * (r - p))
            continue
        centre = np.linalg.solve(2.0 * np.array([q - p, r - p]), [q @ q - p @ p, r @ r - p @ p])
        begin, end = (math.atan2(*(v - centre)[::-1]) for v in (p, r))
        turn = begin + np.linspace(0.0, (end - begin) % (2.0 * math.pi), points, endpoint=False)
        edge.append(centre + math.dist(p, centre) * np.column_stack([np.cos(turn), np.sin(turn)]))
    return np.concatenate(edge)


def moments(edge):
    """Area, and mean of x² + y² over it, of a polygon about the origin: exact for its triangles."""
    a, b = edge, np.roll(edge, -1, 0)
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return 0.5 * cross.sum(), (cross * ((a * a).sum(1) + (a * b).sum(1) + (b * b).sum(1))).sum() / 6.0 / cross.sum()


@pytest.mark.parametrize("shape", SHAPES)
def test_the_area_of_an_iris_is_that_of_its_arcs(shape):
    """4,000 chords an arc: short of its area by 1e-7 at most."""
    area, _ = moments(arcs(*shape))
    assert lb.Iris(*shape).area == pytest.approx(area, rel=3e-7)
    assert lb.Iris(*shape).contains(*(0.999999 * arcs(*shape)).T).all()
    assert not lb.Iris(*shape).contains(*(1.000001 * arcs(*shape)).T).any()


@pytest.mark.parametrize("shape", SHAPES)
def test_the_opening_has_its_edge_in_it(shape):
    angles = np.linspace(-math.pi, math.pi, 500)
    iris = lb.Iris(*shape)
    radii = iris.radius(angles)
    assert iris.contains(radii * np.cos(angles), radii * np.sin(angles)).all()


@pytest.mark.parametrize("shape", SHAPES)
def test_the_outline_goes_once_round_the_opening_from_corner_to_corner(shape):
    """400 chords a blade: short of the area by 2 (π / 400 n)² / 3 at most, here 5e-6."""
    blades, rotation, _ = shape
    outline = lb.Iris(*shape).outline(400)
    area, _ = moments(outline)
    assert len(outline) == 400 * blades and area == pytest.approx(lb.Iris(*shape).area, rel=5e-6)
    corners = rotation + 0.5 * math.pi + 2.0 * math.pi * np.arange(blades) / blades
    np.testing.assert_allclose(outline[::400], np.column_stack([np.cos(corners), np.sin(corners)]), atol=1e-12)


@pytest.mark.parametrize("distance", (0.7, 30.0))
@pytest.mark.parametrize("shape", SHAPES)
def test_the_light_on_the_axis_is_the_integral_of_cos4(shape, distance):
    """By the definition, ring by ring of each sector: the chords of 4,000 an arc are short by 3e-7 at most."""
    radius, edge = 2.0, 2.0 * arcs(*shape)
    node, weight = np.polynomial.legendre.leggauss(40)
    after = np.roll(edge, -1, 0)
    middles = 0.5 * (edge + after)
    sector = (edge[:, 0] * after[:, 1] - edge[:, 1] * after[:, 0]) / (middles * middles).sum(1)     # its angle, nearly
    r = 0.5 * (1.0 + node) * np.hypot(*middles.T)[:, None]
    rings = (r * (distance**2 / (distance**2 + r * r)) ** 2) @ (0.5 * weight) * np.hypot(*middles.T)
    assert lb.Iris(*shape).axis_irradiance(radius, distance) == pytest.approx(float(rings @ sector), rel=1e-6)


def test_straight_blades_are_the_polygon_and_full_roundness_the_circle():
    for n in range(3, 25):
        assert lb.Iris(n).area == pytest.approx(0.5 * n * math.sin(2.0 * math.pi / n), rel=1e-14)
        assert lb.Iris(n, 0.4, 1.0).area == math.pi and lb.Iris(n, 0.4, 1.0).steps == []
    assert lb.Iris().area == math.pi


def lattice(n):
    return np.column_stack([(np.arange(n) + 0.5) / n, (np.arange(n) * 0.6180339887498949) % 1.0])


@pytest.mark.parametrize("real", [np.float32, np.float64])
@pytest.mark.parametrize("shape", SHAPES)
def test_an_ideal_lens_fills_its_iris_evenly(shape, real):
    """Second moments and the counts of a 12 × 12 grid, against the polygon; 2^16 points of a lattice err by 1e-3."""
    n = 1 << 16
    camera = lb.PerspectiveCamera(FILM, lens_radius=4.0, focus_distance=900.0, blades=shape[0],
                                  blade_rotation=shape[1], roundness=shape[2])
    places = camera.generate_rays(np.tile([480.0, 320.0], (n, 1)), lattice(n), dtype=real).origins[:, :2] / 4.0
    area, second = moments(arcs(*shape))
    assert (places**2).sum(1).mean() == pytest.approx(second, rel=1e-3)
    assert lb.Iris(*shape).contains(*(0.9995 * places).T).all()
    counts, *_ = np.histogram2d(*places.T, bins=12, range=[[-1, 1], [-1, 1]])
    corners = np.stack(np.meshgrid(np.linspace(-1, 1, 13), np.linspace(-1, 1, 13), indexing="ij"), -1)
    within = lb.Iris(*shape).contains(*corners.reshape(-1, 2).T).reshape(13, 13)
    whole = within[1:, 1:] & within[:-1, 1:] & within[1:, :-1] & within[:-1, :-1]
    assert whole.sum() > 15
    np.testing.assert_allclose(counts[whole], n * (1 / 36) / area, rtol=0.04)      # a cell's 600 to 1,400 points


@pytest.mark.parametrize("shape", SHAPES)
def test_blades_leave_samples_on_their_side_of_the_axis(shape):
    """Equal areas turn a point of the circle by less than the angle of half a blade."""
    uv = lattice(1000)
    round_, bladed = (lb.PerspectiveCamera(FILM, lens_radius=4.0, focus_distance=900.0, blades=blades,
                                           blade_rotation=shape[1], roundness=shape[2]).generate_rays(
        np.tile([480.0, 320.0], (1000, 1)), uv).origins[:, :2] @ [1.0, 1.0j] for blades in (0, shape[0]))
    assert np.abs(np.angle(bladed / round_)).max() < math.pi / shape[0]


@pytest.mark.parametrize("shape", [(3, 0.0, 0.0), (4, 0.7, 0.0), (5, 0.3, 0.0), (17, -1.0, 0.0)])
def test_equal_turns_of_the_disk_sweep_equal_areas_of_a_polygon(shape):
    """A part of a turn from corner to corner becomes that part of the side: its triangle has that part of the area."""
    uv = lattice(2000)
    round_, bladed = (lb.PerspectiveCamera(FILM, lens_radius=4.0, focus_distance=900.0, blades=blades,
                                           blade_rotation=shape[1]).generate_rays(
        np.tile([480.0, 320.0], (2000, 1)), uv, dtype=np.float64).origins[:, :2] @ [0.25, 0.25j]
        for blades in (0, shape[0]))
    corner = np.exp(1j * (shape[1] + 0.5 * math.pi))
    turns = np.angle(round_ / corner) / (2.0 * math.pi) % 1.0 * shape[0]
    a, b = (corner * np.exp(2j * math.pi * (np.floor(turns) + end) / shape[0]) for end in (0.0, 1.0))
    assert bladed == pytest.approx(np.abs(round_) * (a + (turns - np.floor(turns)) * (b - a)), abs=1e-7)


@pytest.mark.parametrize("shape", SHAPES)
def test_the_rim_of_the_disk_goes_once_round_the_area_of_the_opening(shape):
    """Chords of equal areas, drawn outwards until they enclose it: without, they are short by up to 4e-4."""
    side = np.linspace(-1.0, 1.0, 20_000, endpoint=False)
    square = np.concatenate([np.column_stack(it) for it in (
        (1.0 + 0.0 * side, side), (-side, 1.0 + 0.0 * side), (-1.0 + 0.0 * side, -side), (side, -1.0 + 0.0 * side))])
    camera = lb.PerspectiveCamera(FILM, lens_radius=4.0, focus_distance=900.0, blades=shape[0],
                                  blade_rotation=shape[1], roundness=shape[2])
    uv = 0.5 + 0.5 * square
    edge = camera.generate_rays(np.tile([480.0, 320.0], (len(uv), 1)), uv, dtype=np.float64).origins[:, :2] / 4.0
    area, _ = moments(edge)
    assert abs(area) == pytest.approx(lb.Iris(*shape).area, rel=1e-6)


@pytest.mark.parametrize(("shape", "reach"), [((3, 0.0, 0.0), 1.0), ((5, 0.3, 0.0), 1.1), ((7, -1.0, 0.4), 1.02)])
def test_an_iris_upside_down_has_its_edge_opposite(shape, reach):
    iris, angles = lb.Iris(*shape, reach=reach), np.linspace(-math.pi, math.pi, 500)
    np.testing.assert_allclose(iris.upside_down.radius(angles + math.pi), iris.radius(angles), rtol=1e-12)
    assert np.ptp(iris.upside_down.radius(angles) - iris.radius(angles)) > 0.01


@pytest.mark.parametrize("real", [np.float32, np.float64])
def test_samples_beside_the_first_corner_stay_beside_it(real):
    """A turn just below 0 is 1 after rounding: the last chord, and none behind it."""
    before = np.finfo(real).eps * np.array([-40.0, -1.0, -0.5, 0.0, 0.5, 1.0, 40.0])
    for blades, u in ((3, 0.99), (7, 0.6)):
        uv = np.column_stack([np.full(before.size, u), 0.5 + before]).astype(real)
        camera = lb.PerspectiveCamera(FILM, lens_radius=4.0, focus_distance=900.0, blades=blades)
        places = camera.generate_rays(np.tile([480.0, 320.0], (before.size, 1)), uv, dtype=real).origins[:, :2] / 4.0
        np.testing.assert_allclose(places, [[0.0, 2.0 * u - 1.0]] * before.size, atol=1e-4)


def test_an_iris_is_mirrored_where_its_edge_is():
    azimuth = np.linspace(0.0, 2.0 * math.pi, 721)
    for blades in (3, 4, 5, 8):
        for steps in (0.0, 0.3, 0.5, 1.0, 1.5, 2.0, -3.0, 7.0):
            for roundness, reach in ((0.0, 1.0), (0.3, 1.03), (1.0, 1.0), (0.0, math.inf)):
                iris = lb.Iris(blades, steps * math.pi / blades, roundness, reach=reach)
                edge, mirrored = iris.radius(azimuth), iris.radius(math.pi - azimuth)
                assert iris.is_mirrored == bool(np.abs(edge - mirrored).max() < 1e-9), (blades, steps, roundness)


@pytest.mark.parametrize("f_number", [None, 5.6, 22.0])
@pytest.mark.parametrize("model", ["trace", "polynomial", "thick", "thin", "pinhole"])
def test_the_axis_has_weight_one_behind_any_iris_and_light_as_its_area(model, f_number):
    n, middle = 1 << 14, np.tile([480.0, 320.0], (1 << 14, 1))
    lens = lenses.load("pbrt-dgauss-50mm")
    bladed = replace(lens, blades=5, blade_rotation=0.2, roundness=0.3)
    camera = lb.LensCamera(bladed, FILM, 1200.0, f_number, model=model)
    assert camera.generate_rays(middle, lattice(n)).weights.mean() == pytest.approx(1.0, abs=2e-3)
    if f_number:        # as much light as a round stop of this f-number, but for the pupil's aberration
        whole, part = (lb.LensCamera(it, FILM, 1200.0, f_number, model=model, weights="physical")
                       for it in (lens, bladed))
        light = [it.generate_rays(middle, lattice(n)).weights.mean() for it in (whole, part)]
        assert not camera.lens.iris.is_round and light[1] / light[0] == pytest.approx(1.0, rel=3e-3)


def test_the_samples_that_pass_are_as_many_as_the_iris_has_of_the_circle():
    """0.4 % of the table's outline lie outside the region."""
    lens = replace(lenses.load("pbrt-dgauss-50mm"), blades=6)
    camera = lb.LensCamera(lens, FILM, 1200.0, 8.0)
    weights = camera.generate_rays(np.tile([480.0, 320.0], (1 << 14, 1)), lattice(1 << 14)).weights
    assert (weights > 0.0).mean() == pytest.approx(3.0 * math.sin(math.pi / 3) / math.pi, abs=0.01)


def test_rays_that_pass_the_blades_are_those_of_the_reference_tracer_and_of_the_way_back():
    lens = replace(lenses.load("lenshh-cooke-triplet-50"), blades=5, blade_rotation=0.7, roundness=0.2)
    stopped = lb.stopped_down(lens, 8.0)
    round_, bladed = (lb.LensCamera(it, FILM, 1500.0) for it in (replace(stopped, blades=0), stopped))
    rng = np.random.default_rng(4)
    raster, uv = rng.random((4000, 2)) * [960, 640], rng.random((4000, 2))
    every, some = (it.generate_rays(raster, uv) for it in (round_, bladed))
    lit = every.weights > 0.0
    shift = np.array([0.0, 0.0, bladed.lens.length + bladed.film_distance])
    back = lb.trace(bladed.lens, every.origins[lit] + shift, -every.directions[lit])
    passed = back.fate == lb.Fate.PASSED
    assert 0.7 < passed.mean() < 0.85
    np.testing.assert_array_equal(passed, some.weights[lit] > 0.0)
    assert (back.surface[~passed] == bladed.lens.stop_index).all() and (back.fate[~passed] == lb.Fate.CLIPPED).all()
    np.testing.assert_allclose(some.directions[lit][passed], every.directions[lit][passed], atol=1e-13)
    given = {row: column for row, column in zip((X, Y, Z, L, M, N), [*every.origins[lit].T, *-every.directions[lit].T],
                                                strict=True)}
    back = Program(trace_steps(bladed.lens, bladed.film_distance, towards="film"), np.float64).run(
        {**given, WEIGHT: np.ones(lit.sum())}, [WEIGHT], lit.sum())
    np.testing.assert_array_equal(back[0] > 0.0, passed)


def test_the_open_region_is_the_image_of_the_iris_and_of_a_round_stop_the_exit_pupil():
    lens = replace(lb.stopped_down(lenses.load("pbrt-dgauss-50mm"), 11.0), blades=5, blade_rotation=0.3,
                   blade_reach=1.0)
    distance = lb.film_distance(lens, math.inf)
    pupil = lb.exit_pupil(lens, distance, [0.0, 9.0])
    open_area, _ = moments(lb.open_region(lens, distance, (0.0, 0.0)))
    assert open_area / pupil.area[0] == pytest.approx(lb.Iris(5).area / math.pi, rel=2e-3)  # 512 points miss corners
    outline = lb.open_region(lens, distance, (0.0, 9.0))
    film = np.array([0.0, 9.0, lens.length + distance])
    for size, fate in ((0.999, lb.Fate.PASSED), (1.002, lb.Fate.CLIPPED)):
        at = outline.mean(0) + size * (outline - outline.mean(0))
        ways = np.column_stack([at, np.full(len(at), lens.length)]) - film
        assert (lb.trace(lens, film, ways).fate == fate).all()
    round_ = lb.open_region(replace(lens, blades=0), distance, (9.0, 0.0))
    np.testing.assert_array_equal(round_, pupil.boundary(1))


def bokeh(model, blades, far=True, f_number=2.8, rotation=0.0, roundness=0.0):
    """The picture of a small lamp on the axis, far behind or before the plane in focus: linear, one channel."""
    lens = replace(lenses.load("pbrt-dgauss-50mm"), blades=blades, blade_rotation=rotation, roundness=roundness)
    lamp = lb.Material(kind="lamp", colour=(1e4, 1e4, 1e4))
    scene = lb.Scene("lamp", sky=lb.Sky((0.0,) * 3, (0.0,) * 3, (0.0,) * 3),
                     spheres=(lb.Sphere((0.0, 0.0, -20_000.0 if far else -600.0), 12.0 if far else 0.3, lamp),))
    camera = lb.LensCamera(lens, lb.Film(3.0, 3.0, 96, 96), 1000.0 if far else 8000.0, f_number, model=model,
                           weights="physical")
    return lb.render(camera, scene, samples=384)[..., 0].astype(float)


@pytest.mark.parametrize("model", ["trace", "thick", "thin"])
def test_far_lights_show_the_iris_upright_and_near_ones_upside_down(model):
    for far, sign in ((True, 1.0), (False, -1.0)):
        image = bokeh(model, 3, far)
        rows, columns = image.sum(1), image.sum(0)
        at = np.arange(96) + 0.5
        middle = (rows * at).sum() / rows.sum()
        second, third = ((rows * (at - middle) ** power).sum() / rows.sum() for power in (2, 3))
        # 2 √2 / 5 is that of a triangle along its height, its point at the top
        assert third / second**1.5 == pytest.approx(-sign * 0.5657, abs=0.08)
        assert (columns * at).sum() / columns.sum() == pytest.approx(48.0, abs=0.5)


def test_the_bokeh_of_a_rounded_iris_has_its_area_and_second_moment():
    """The thin lens images the iris to scale: light as of a round one; spread as the second moment; noise 1 %."""
    round_, six = bokeh("thin", 0), bokeh("thin", 6, rotation=0.4, roundness=0.4)
    area, second = moments(arcs(6, 0.4, 0.4))
    assert six.sum() / round_.sum() == pytest.approx(1.0, rel=0.01)
    y, x = np.mgrid[0:96, 0:96] + 0.5 - 48.0
    spread = [((x * x + y * y) * it).sum() / it.sum() for it in (round_, six)]
    assert spread[1] / spread[0] == pytest.approx(second / 0.5 / (area / math.pi), rel=0.015)


def test_turning_an_iris_turns_its_bokeh():
    """By a quarter of a turn, counter-clockwise: the triangle's point goes left. Noise of blocks of pixels: 10 %."""
    up, left = (bokeh("trace", 3, rotation=turn).reshape(12, 8, 12, 8).sum((1, 3)) for turn in (0.0, math.pi / 2))
    assert np.abs(np.rot90(up) - left).sum() / up.sum() < 0.2
    assert np.abs(up - left).sum() / up.sum() > 0.3


@pytest.mark.parametrize(("make", "says"), [
    (lambda: lb.Iris(2), "3 to 24"),
    (lambda: lb.Iris(-5), "3 to 24"),
    (lambda: lb.Iris(25), "3 to 24"),
    (lambda: lb.Iris(math.nan), "3 to 24"),
    (lambda: lb.Iris(5, math.inf), "finite angle"),
    (lambda: lb.Iris(5, 0.0, 1.1), "between 0"),
    (lambda: lb.Iris(5, 0.0, math.nan), "between 0"),
    (lambda: lb.Iris(5, reach=0.9), "on the stop's rim"),
    (lambda: replace(lenses.load("pbrt-dgauss-50mm"), blades=5, blade_reach=math.nan), "on the stop's rim"),
    (lambda: replace(lenses.load("pbrt-dgauss-50mm"), blades=2), "3 to 24"),
    (lambda: lb.PerspectiveCamera(FILM, lens_radius=2.0, roundness=-1.0), "between 0"),
])
def test_an_iris_that_cannot_be_is_refused_in_one_line(make, says):
    with pytest.raises(ValueError, match=says) as caught:
        make()
    assert "\n" not in str(caught.value)


def test_a_t_number_counts_what_the_blades_cover():
    lens = lenses.load("pbrt-dgauss-50mm")
    assert (lb.t_number(replace(lens, blades=6, blade_reach=1.0)) / lb.t_number(lens)) ** 2 == pytest.approx(
        math.pi / (3.0 * math.sin(math.pi / 3)))


@pytest.mark.parametrize("blades", [5, 7, 9])
def test_blades_come_forth_from_behind_the_rim_as_a_lens_is_stopped_down(blades):
    """Straight blades at a distance d cut segments acos d − d √(1 − d²) off the disk; inside, it is a polygon."""
    lens = replace(lenses.load("lib-tronnier-1953"), blades=blades, blade_rotation=0.2)
    widest = lb.first_order(lens).f_number
    assert lens.iris.is_round and widest == lb.first_order(replace(lens, blades=0)).f_number
    half = math.pi / blades
    corners_appear = math.pi - blades * (half - math.cos(half) * math.sin(half))        # area with reach 1
    reaches = []
    for number in widest * np.linspace(1.0, 1.6, 25):
        stopped = lb.stopped_down(lens, float(number))
        iris, share = stopped.iris, (widest / number) ** 2
        closed, distance = stopped.stop.semi_diameter / lens.stop.semi_diameter, iris.reach * math.cos(half)
        if share * math.pi > corners_appear:
            distance = min(distance, 1.0)
            area = math.pi - blades * (math.acos(distance) - distance * math.sqrt(1.0 - distance**2))
            assert closed == 1.0
        else:
            area = blades * math.cos(half) * math.sin(half) * closed**2
            assert iris.reach == 1.0
        assert area == pytest.approx(share * math.pi, rel=1e-9)
        assert lb.first_order(stopped).f_number == pytest.approx(number, rel=1e-9)
        assert iris.area * closed**2 == pytest.approx(area, rel=1e-9)
        again = lb.stopped_down(stopped, float(1.3 * number))                           # as if closed at once
        once = lb.stopped_down(lens, float(1.3 * number))
        assert again.stop.semi_diameter == pytest.approx(once.stop.semi_diameter, rel=1e-9)
        assert again.blade_reach == pytest.approx(once.blade_reach, rel=1e-9)
        reaches.append(iris.reach * closed)
    assert (np.diff(reaches) < 0.0).all()


def test_the_widest_f_number_leaves_the_stop_round_whatever_the_blades():
    """By rounding, 1 / cos(π / n) · cos(π / n) may lie below 1: the open lens was then traced behind blades."""
    plain = lenses.load("pbrt-dgauss-50mm")
    for blades in range(3, 25):
        for roundness in (0.0, 0.3, 0.7):
            lens = replace(plain, blades=blades, roundness=roundness)
            assert lb.stopped_down(lens, lb.first_order(lens).f_number) == lens and lens.iris.is_round
            assert lb.stopped_down(lens, 2.0) == lens           # engraved, for a prescription of f/2.03


@pytest.mark.parametrize(("blades", "by"), [(3, 1.15), (5, 1.4), (7, 1.1), (7, 4.0)])
def test_blades_change_no_figure_of_an_f_number(blades, by):
    """Depth of field, blur, falloff, exposure and best focus are those of the round stop of as much area."""
    plain = lenses.load("pbrt-dgauss-50mm")
    number = by * lb.first_order(plain).f_number
    round_, bladed = (lb.stopped_down(replace(plain, blades=count), number) for count in (0, blades))
    away = lb.film_distance(plain, 2000.0)
    assert not bladed.iris.is_round and bladed.with_round_stop.iris.is_round
    assert bladed.with_round_stop.stop.semi_diameter == pytest.approx(round_.stop.semi_diameter, rel=1e-9)
    for figure in (lambda it: lb.first_order(it).f_number, lambda it: lb.working_f_number(it, away),
                   lambda it: lb.t_number(it), lambda it: lb.thick_depth_of_field(it, away, 2000.0, 0.03),
                   lambda it: lb.thick_circle_of_confusion(it, away, [5000.0]),
                   lambda it: lb.thick_hyperfocal(it, 0.03),
                   lambda it: lb.falloff(it, away, [0.0, 12.0]).irradiance,
                   lambda it: lb.film_distance(it, 2000.0, "real")):
        assert figure(bladed) == pytest.approx(figure(round_), rel=2e-3)      # real rays: the pupil's aberration
    wedges = [lb.analysis.sharp_focus(lb.LensCamera(it, FILM, 2000.0), 0.03) for it in (round_, bladed)]
    for one, other in zip(*((wedge.near, wedge.far) for wedge in wedges), strict=True):
        assert one.offset == pytest.approx(other.offset, rel=1e-9)


def test_a_rim_that_is_narrower_than_the_blades_is_the_working_f_number():
    """The blades cut an opening of 5 sides within the stop; a front rim of 0.8 of its corners leaves a circle there."""
    plain = replace(lenses.load("pbrt-dgauss-50mm"), blades=5)
    stopped = lb.stopped_down(plain, 4.0)
    away = lb.film_distance(plain, math.inf)
    flat = math.cos(math.pi / 5.0)                      # the nearest point of a blade
    beam = replace(stopped.with_stop_radius(0.8 * flat * stopped.stop.semi_diameter), blades=0)
    rims = list(stopped.surfaces)
    height = lb.first_order(beam).entrance_pupil.radius
    rims[0] = replace(rims[0], semi_diameter=height)    # parallel to the axis, the beam is as high there
    narrow = replace(stopped, surfaces=tuple(rims))
    assert lb.working_f_number(narrow, away) == pytest.approx(lb.working_f_number(beam, away), rel=2e-3)


@pytest.mark.parametrize("roundness", [0.0, 0.4])
def test_an_opening_cut_off_by_the_rim_is_the_blades_within_a_circle(roundness):
    """Area and second moment of the arcs clipped at the rim, by 4000 chords an arc; samples, and rays it blocks."""
    iris = lb.Iris(7, 0.3, roundness, None, 1.05)
    assert not iris.is_round and iris.radius(np.linspace(0.0, 7.0, 999)).max() == 1.0
    edge = 1.05 * arcs(7, 0.3, roundness)
    edge /= np.maximum(np.hypot(*edge.T), 1.0)[:, None]
    area, second = moments(edge)
    assert iris.area == pytest.approx(area, rel=3e-7)
    assert iris.mean(lambda r: 0.5 * math.pi * r**4) / iris.area == pytest.approx(second, rel=3e-7)
    grid = np.linspace(-1.1, 1.1, 201)
    x, y = (each.ravel() for each in np.meshgrid(grid, grid))
    [blocking] = iris.blocking(3.0)
    weights = Program([blocking], np.float64).run({X: 3.0 * x, Y: 3.0 * y, WEIGHT: np.ones(x.size)}, [WEIGHT], x.size)
    within = np.hypot(x, y) <= 1.0                      # the rim blocks the others
    np.testing.assert_array_equal((weights[0] > 0.0)[within], iris.contains(x, y)[within])
    uv = lattice(1 << 14)
    u, v = Program(iris.steps, np.float64).run({U0: uv[:, 0], U1: uv[:, 1]}, [U0, U1], len(uv))
    places = lb.unit_disk(np.column_stack([u, v]))
    assert iris.contains(*(0.999 * places.T)).all()
    assert (places**2).sum(1).mean() == pytest.approx(second, rel=1e-3)


def test_views_of_fates_show_the_blades_as_the_stop():
    """One ray for each of 262,144 points near the axis: as many pass as the iris has of the circle. Noise 2 %."""
    lens = lb.stopped_down(lenses.load("pbrt-dgauss-50mm"), 5.6)
    passed, stopped = [], []
    for it in (lens, replace(lens, blades=3, blade_reach=1.0)):
        camera = lb.LensCamera(it, lb.Film(0.2, 0.2, 512, 512), 1500.0)
        rendering = lb.Rendering(camera, lb.builtin_scene("still-life"), view="fate")
        rendering.add(1)
        image = rendering.image().reshape(-1, 3)
        passed.append((image == 1.0).all(1).mean())
        stopped.append((np.abs(image - lb.fate_colours(lens)[lens.stop_index]) < 1e-5).all(1).mean())
    assert passed[1] / passed[0] == pytest.approx(lb.Iris(3).area / math.pi, rel=0.03)
    assert passed[0] + stopped[0] == pytest.approx(passed[1] + stopped[1], rel=0.01)
