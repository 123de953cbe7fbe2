"""Surfaces of every kind: their sag, and rays through them against 40-digit geometry and closed forms of optics."""

from dataclasses import replace
from math import cos, inf, isnan, nan, sin, sqrt

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st

import lensbench as lb
from tests.core.oracles import LAW, lens

HEIGHT = st.floats(-6.0, 6.0)
SLOPE = st.floats(-1.0, 1.0)
POWERS = st.lists(st.integers(2, 20), max_size=5, unique=True)
EDGE = mpmath.mpf("1e-12")


@st.composite
def surfaces(draw, glass=lb.AIR):
    """A plane, sphere, conic, asphere of any powers, cylinder or toroid, well curved within its rim."""
    rim = draw(st.floats(4.0, 9.0))
    radius = st.one_of(st.floats(6.0, 100.0), st.floats(-100.0, -6.0))
    curvature = st.one_of(st.just(0.0), radius.map(lambda r: 1.0 / r))
    kind = draw(st.sampled_from(["sphere", "conic", "asphere", "toroid"]))
    conic, terms, across = 0.0, (), None
    if kind in ("conic", "asphere"):
        conic = draw(st.floats(-3.0, 2.0))
    if kind == "asphere":       # each term lifts the rim by up to 0.1 mm
        terms = tuple((p, draw(st.floats(-0.1, 0.1)) * rim**-p) for p in draw(POWERS))
    if kind == "toroid":
        across = draw(curvature)
    return lb.Surface(draw(st.floats(0.5, 8.0)), rim, glass, 0.0 if across is not None else conic,
                      terms, across, curvature=draw(curvature))


@st.composite
def stacks(draw, most=6):
    """Random lenses of all kinds of surfaces; the last medium is air."""
    count = draw(st.integers(1, most))
    return lb.Lens(tuple(
        draw(surfaces(lb.AIR if i % 2 or i == count - 1 else lb.Glass(draw(st.floats(1.4, 1.95)))))
        for i in range(count)), 0)


# --- 40-digit geometry: another algorithm for hits, and the same fates

def sag_of(surface, x, y):
    """The definition of the sag in mpmath, nan beyond the equator."""
    c, k, across = map(mpmath.mpf, (surface.curvature, surface.conic, surface.curvature_x or 0.0))
    if surface.curvature_x is not None:
        inside, bend = 1 - (across * x) ** 2 - (c * y) ** 2, across * x**2 + c * y**2
    else:
        inside, bend = 1 - (1 + k) * c**2 * (x**2 + y**2), c * (x**2 + y**2)
    if inside <= 0:
        return mpmath.nan
    r = mpmath.sqrt(x**2 + y**2)
    return bend / (1 + mpmath.sqrt(inside)) + sum(mpmath.mpf(a) * r**p for p, a in surface.aspheric)


def squares(surface):
    """(1 + k) c² across and along: the equator is where their sum times x², y² is 1."""
    c, k = mpmath.mpf(surface.curvature), mpmath.mpf(surface.conic)
    if surface.curvature_x is not None:
        return mpmath.mpf(surface.curvature_x) ** 2, c**2
    return (1 + k) * c**2, (1 + k) * c**2


def equator(surface, o, d):
    """The stretch of the ray o + t d within the surface's equator, (-60, 60) where it has none; None: never there."""
    square_x, square_y = squares(surface)
    a = square_x * d[0] ** 2 + square_y * d[1] ** 2
    b = square_x * o[0] * d[0] + square_y * o[1] * d[1]
    e = square_x * o[0] ** 2 + square_y * o[1] ** 2 - 1
    if square_x < 0 or a == 0:
        return (mpmath.mpf(-60), mpmath.mpf(60)) if square_x < 0 or e < 0 else None
    if b * b - a * e <= 0:
        return None
    middle, half = -b / a, mpmath.sqrt(b * b - a * e) / a
    return max(middle - half, mpmath.mpf(-60)), min(middle + half, mpmath.mpf(60))


def hit(surface, o, d, way):
    """Length along the ray to the surface, None where it misses, and how clear that is; o, d in the vertex's frame.

    Spheres and conics by the general quadratic; the others by bisection between the equators, where
    the ray's height above the surface rises all the way.
    """
    if not surface.aspheric and surface.curvature_x is None:
        c, k = mpmath.mpf(surface.curvature), mpmath.mpf(surface.conic)
        a = c * (1 + k * d[2] ** 2)
        b = c * (o[0] * d[0] + o[1] * d[1] + (1 + k) * o[2] * d[2]) - d[2]
        e = c * (o[0] ** 2 + o[1] ** 2 + (1 + k) * o[2] ** 2) - 2 * o[2]
        if abs(a) < mpmath.mpf("1e-30"):
            return (-e / (2 * b) if b * way < 0 else None), abs(b)
        if b * b - a * e < 0:
            return None, abs(b * b - a * e)
        t = (-b - way * mpmath.sqrt(b * b - a * e)) / a         # where the ray goes through as it travels
        side = 1 - (1 + k) * c * (o[2] + t * d[2])
        return (t if side > 0 else None), min(abs(side), abs(b * b - a * e))

    def above(t):
        return way * (o[2] + t * d[2] - sag_of(surface, o[0] + t * d[0], o[1] + t * d[1]))

    ends = equator(surface, o, d)
    if ends is None:
        return None, mpmath.mpf(1)
    shrink = (ends[1] - ends[0]) * mpmath.mpf("1e-20")
    low, high = ends[0] + shrink, ends[1] - shrink
    places = [low + (high - low) * j / 40 for j in range(41)]
    near = [t for t in places if all(abs(o[i] + t * d[i]) < 1.5 * surface.semi_diameter for i in (0, 1))]
    assume(len(near) > 1)                       # far outside the rims powers run away, and there may be many hits
    heights = [above(t) for t in near]
    assume(all(b - a > (t - s) / 20 for a, b, s, t in zip(heights, heights[1:], near, near[1:], strict=False)))
    if heights[0] > 0 or heights[-1] < 0:
        assume(len(near) == len(places) and ends[1] < 60 and ends[0] > -60)     # or one may lie farther out
        return None, min(abs(heights[0]), abs(heights[-1]))
    low, high = near[0], near[-1]
    for _ in range(130):
        middle = (low + high) / 2
        low, high = (low, middle) if above(middle) > 0 else (middle, high)
    return low, mpmath.mpf(1)


def normal_of(surface, x, y):
    """Unit normal towards +z by differences of the definition, good to 25 digits."""
    with mpmath.workdps(80):
        h = mpmath.mpf("1e-26")
        slopes = [(sag_of(surface, x + h * (i == 0), y + h * (i == 1))
                   - sag_of(surface, x - h * (i == 0), y - h * (i == 1))) / (2 * h) for i in (0, 1)]
        normal = mpmath.matrix([-slopes[0], -slopes[1], 1])
        return normal / mpmath.norm(normal)


def in_forty_digits(stack, origin, direction, forward):
    """Fate, surface, point and direction of a ray, and the smallest distance from any edge on its way."""
    p, d = mpmath.matrix(origin), mpmath.matrix(direction)
    d /= mpmath.norm(d)
    n = stack.indices()
    way, clear, reached = (1 if forward else -1), mpmath.mpf(1), -1
    order = range(len(n) - 1) if forward else range(len(n) - 2, -1, -1)
    for i in order:
        surface, z = stack.surfaces[i], mpmath.mpf(stack.vertices[i])
        if reached >= 0 and d[2] * way <= 0:
            return lb.Fate.BACKWARD, reached, p, d, clear
        t, room = hit(surface, [p[0], p[1], p[2] - z], d, way)
        clear = min(clear, room)
        if t is None:
            return lb.Fate.MISSED, reached, p, d, clear
        p, reached = p + t * d, i
        rim = surface.semi_diameter - mpmath.sqrt(p[0] ** 2 + p[1] ** 2)
        clear = min(clear, abs(rim))
        if rim < 0:
            return lb.Fate.CLIPPED, reached, p, d, clear
        normal = normal_of(surface, p[0], p[1])
        before, after = (n[i], n[i + 1]) if forward else (n[i + 1], n[i])
        ratio, cosine = mpmath.mpf(before) / after, (d.T * normal)[0] * way
        left = 1 - ratio**2 * (1 - cosine**2)
        clear = min(clear, abs(left), abs(cosine))
        if left < 0:
            return lb.Fate.TOTAL_REFLECTION, reached, p, d, clear
        d = ratio * d + way * (mpmath.sqrt(left) - ratio * cosine) * normal
        clear = min(clear, abs(d[2]))
    return (lb.Fate.PASSED if way < 0 or d[2] > 0 else lb.Fate.BACKWARD), reached, p, d, clear


@pytest.mark.slow
@settings(LAW, max_examples=150)
@given(stacks(), HEIGHT, HEIGHT, SLOPE, SLOPE, st.booleans())
def test_rays_through_surfaces_of_any_kind_agree_with_forty_digits_fate_by_fate(stack, x, y, dx, dy, back):
    origin = [x, y, stack.length + 3.0 if back else -3.0]
    direction = [dx, dy, -1.0 if back else 1.0]
    agree(stack, origin, direction, not back)


@pytest.mark.slow
@settings(LAW, max_examples=100)
@given(st.floats(4.0, 9.0), st.floats(0.3, 0.99), st.floats(-3.0, 2.0), stacks(most=4), st.floats(1.0, 1.4),
       st.floats(-0.4, 0.7), st.floats(-0.9, 0.9), st.floats(0.05, 0.95))
def test_rays_from_beyond_a_right_angle_agree_with_forty_digits_fate_by_fate(rim, bulge, conic, rear, front_index,
                                                                             beyond, x, y):
    """A dome of any conic before a random lens, in water or air; the ray is aimed at a point of the dome."""
    dome = lb.Surface(3.0, rim, lb.Glass(1.7), min(conic, 0.9 / bulge**2 - 1.0), curvature=bulge / rim)
    stack = replace(rear, surfaces=(dome, *rear.surfaces), front_index=front_index)
    x, y = 0.3 * x * rim, -y * rim
    direction = np.array([0.0, cos(beyond), -sin(beyond)])
    agree(stack, np.array([x, y, float(dome.sag(x, y))]) - 7.0 * direction, direction, True)


def agree(stack, origin, direction, forward):
    """Fate and surface exactly, points and directions to rounding, or hypothesis tries another ray at an edge."""
    with mpmath.workdps(40):
        fate, surface, point, after, clear = in_forty_digits(stack, list(map(float, origin)),
                                                             list(map(float, direction)), forward)
        assume(clear > EDGE)
    t = lb.trace(stack, origin, direction, forward=forward)
    assert (t.fate[0], t.surface[0]) == (fate, surface)
    # what lies near an edge is as much worse as its root: grazing incidence, the critical angle; and arms are long
    tolerance = 1e-14 * max(1.0, 1.0 / sqrt(float(clear))) * max(1.0, 0.1 * float(max(abs(v) for v in point)))
    np.testing.assert_allclose(t.points[0], [float(v) for v in point], rtol=0.0, atol=30.0 * tolerance)
    np.testing.assert_allclose(t.directions[0], [float(v) for v in after], rtol=0.0, atol=10.0 * tolerance)


def rays_that_leave_an_ellipsoid_behind_its_equator(curvature, conic, glass=lb.AIR, count=40):
    """A surface, and rays (origins, directions) that cross it in the sense of +z behind its equator alone.

    The ellipsoid z = a (1 − cos t), r = b sin t is closed and convex: a ray meets it once inwards and once outwards. At
    t in (π/2, π) the gradient −F, which points inwards, has a negative z component, and every ray with a positive
    product with it crosses there in the sense that the vertex's side has.
    """
    a, b = 1.0 / (curvature * (1.0 + conic)), 1.0 / (curvature * sqrt(1.0 + conic))
    surface = lb.Surface(3.0, 2.0 * b, glass, conic, curvature=curvature)
    t = np.linspace(0.55, 0.9, count) * np.pi
    points = np.stack([-b * np.sin(t), np.zeros(count), a * (1.0 - np.cos(t))], 1)
    side = 1.0 - (1.0 + conic) * curvature * points[:, 2]
    gradients = np.stack([-curvature * points[:, 0], np.zeros(count), side], 1)
    directions = gradients / np.linalg.norm(gradients, axis=1)[:, None] + [[0.0, 0.0, 1.01]]
    assert (directions[:, 2] > 0.0).all() and ((directions * gradients).sum(1) > 0.0).all()
    return surface, points - 3.0 * directions, directions / np.linalg.norm(directions, axis=1)[:, None]


@pytest.mark.parametrize(("curvature", "conic"), [(0.1, 0.0), (0.1, 0.5), (0.08, -0.4)])
def test_a_ray_that_meets_the_conic_behind_its_equator_alone_misses(curvature, conic):
    surface, origins, directions = rays_that_leave_an_ellipsoid_behind_its_equator(curvature, conic)
    traced = lb.trace(lb.Lens((surface, lb.Surface(0.0, 1e3, curvature=0.0)), 0), origins, directions)
    assert (traced.fate == lb.Fate.MISSED).all()


@pytest.mark.parametrize("terms", [((4, 1e-5),), ((3, 2e-4),), ((4, 2e-5), (6, -1e-8))])
def test_a_ray_that_passes_a_surface_at_a_hundred_picometres_misses(terms):
    """Along tangents of an asphere that bulges towards the ray, moved away by 10⁻⁷ mm: its residual is never 0."""
    surface = lb.Surface(0.0, 9.0, lb.Glass(1.6), curvature=0.03, aspheric=terms)
    y = np.linspace(1.0, 7.0, 60)
    slope = (surface.sag(0.0, y + 1e-5) - surface.sag(0.0, y - 1e-5)) / 2e-5
    tangents = np.stack([np.zeros(60), np.ones(60), slope], 1) / np.sqrt(1.0 + slope**2)[:, None]
    normals = np.stack([np.zeros(60), -slope, np.ones(60)], 1) / np.sqrt(1.0 + slope**2)[:, None]
    points = np.stack([np.zeros(60), y, surface.sag(0.0, y)], 1)
    for away in (1e-7, 1e-8, 1e-9):
        # On the convex side, before the surface: the ray never reaches it
        traced = lb.trace(lb.Lens((surface,), 0), points - away * normals - 2.0 * tangents, tangents)
        assert (traced.fate == lb.Fate.MISSED).all()


@pytest.mark.parametrize("size", [1.0, 30.0, 1000.0])
def test_no_ray_is_lost_to_rounding_on_an_asphere_of_any_size(size):
    """Residuals are rounded at the size of the coordinates: 2,000 rays of all slopes within the rim meet it."""
    random = np.random.default_rng(3)
    surface = lb.Surface(0.0, 30.0 * size, lb.Glass(1.6), -0.7,
                         ((4, 1e-6 / size**3), (6, -1e-10 / size**5), (3, 2e-6 / size**2)), curvature=0.02 / size)
    places = size * random.uniform(-20.0, 20.0, (2000, 2))
    directions = np.stack([*random.uniform(-0.8, 0.8, (2, 2000)), np.ones(2000)], 1)
    points = np.column_stack([places, surface.sag(*places.T)])
    origins = points - size * random.uniform(1.0, 40.0, (2000, 1)) * directions
    traced = lb.trace(lb.Lens((surface,), 0), origins, directions, record=True)
    assert (traced.fate != lb.Fate.MISSED).all()
    hits = traced.paths[:, 1] if traced.paths.shape[1] > 1 else traced.points
    np.testing.assert_allclose(hits, points, atol=1e-11 * size)


@pytest.mark.parametrize("azimuth", [0.0, 0.5, 2.0, 4.0])
def test_a_ray_enters_a_steep_bowl_where_its_flank_faces_the_ray(azimuth):
    """A line enters the inside of a convex surface once: at 75° from the axis, against slopes of up to 64°."""
    surface = lb.Surface(0.0, 9.0, lb.Glass(1.6), curvature=0.0, aspheric=((4, 1e-3),))
    out = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    r = np.linspace(2.0, 8.0, 40)
    points = r[:, None] * out + 1e-3 * r[:, None] ** 4 * [0.0, 0.0, 1.0]
    direction = np.cos(1.3) * np.array([0.0, 0.0, 1.0]) - np.sin(1.3) * out
    traced = lb.trace(lb.Lens((surface,), 0), points - 3.0 * direction, np.tile(direction, (40, 1)), record=True)
    assert (traced.fate != lb.Fate.MISSED).all()
    hits = traced.paths[:, 1] if traced.paths.shape[1] > 1 else traced.points
    np.testing.assert_allclose(hits, points, atol=1e-12)


# --- Sag

@LAW
@given(surfaces(), HEIGHT, HEIGHT)
def test_the_sag_is_that_of_the_definition(surface, x, y):
    square_x, square_y = squares(surface)
    assume(abs(1.0 - square_x * x * x - square_y * y * y) > 1e-3)       # where its root keeps its digits
    with mpmath.workdps(40):
        expected = float(sag_of(surface, mpmath.mpf(x), mpmath.mpf(y)))
    found = float(surface.sag(x, y))
    assert (isnan(found) and isnan(expected)) or found == pytest.approx(expected, rel=1e-13, abs=1e-15)


@LAW
@given(surfaces(), st.floats(0.1, 10.0), HEIGHT, HEIGHT)
def test_a_scaled_surface_has_the_scaled_sag(surface, factor, x, y):
    sag = float(surface.sag(x, y))
    square_x, square_y = squares(surface)
    assume(square_x * x * x + square_y * y * y < 0.99 and abs(sag) < 20.0)
    found = float(surface.scaled(factor).sag(factor * x, factor * y))
    assert found == pytest.approx(factor * sag, rel=1e-12, abs=1e-14)


def test_sags_take_arrays_and_end_at_the_equator():
    ball = lb.Surface(1.0, 10.0, curvature=0.1)
    np.testing.assert_allclose(ball.sag([0.0, 6.0, 8.0, 10.5]), [0.0, 2.0, 4.0, nan], atol=1e-15)
    assert ball.sag(np.zeros((2, 1)), np.zeros(3)).shape == (2, 3)
    parabola = lb.Surface(1.0, 50.0, curvature=0.1, conic=-1.0)
    assert float(parabola.sag(40.0)) == pytest.approx(80.0, rel=1e-15)


# --- Closed forms of optics

@LAW
@given(st.floats(10.0, 100.0), st.floats(1.3, 1.9), st.floats(0.01, 0.95))
def test_an_ellipsoid_of_eccentricity_1_over_n_focuses_a_beam_in_glass_to_a_point(radius, n, height):
    """Descartes: k = −1/n², glass behind; the focus lies at n R / (n − 1)."""
    y = height * radius * n / sqrt(n * n - 1.0)                 # of its equator
    shell = lb.Lens((lb.Surface(0.0, 1e3, lb.Glass(n), curvature=1.0 / radius, conic=-1.0 / n**2),), 0)
    t = lb.trace(shell, [0.0, y, -5.0], [0.0, 0.0, 1.0])
    assert t.fate[0] == lb.Fate.PASSED
    focus = t.points[0, 2] - t.points[0, 1] / t.directions[0, 1] * t.directions[0, 2]
    assert focus == pytest.approx(n * radius / (n - 1.0), rel=1e-10)


@LAW
@given(st.floats(10.0, 100.0), st.floats(1.3, 1.9), st.floats(0.01, 3.0))
def test_a_hyperboloid_behind_glass_focuses_a_beam_to_a_point_however_wide(radius, n, height):
    """Plano-convex with k = −n²: the focus lies R / (n − 1) behind the vertex."""
    drop = lb.Lens((lb.Surface(5.0, 1e4, lb.Glass(n), curvature=0.0),
                    lb.Surface(0.0, 1e4, curvature=-1.0 / radius, conic=-n * n)), 0)
    t = lb.trace(drop, [0.0, height * radius, -3.0], [0.0, 0.0, 1.0])
    assert t.fate[0] == lb.Fate.PASSED
    focus = t.points[0, 2] - t.points[0, 1] / t.directions[0, 1] * t.directions[0, 2] - 5.0
    assert focus == pytest.approx(radius / (n - 1.0), rel=1e-11)


@LAW
@given(st.floats(12.0, 100.0), HEIGHT, HEIGHT, SLOPE, SLOPE, st.sampled_from(["aspheric", "both"]))
def test_a_parabola_written_as_an_asphere_bends_as_it_does(radius, x, y, dx, dy, written):
    c = 1.0 / radius
    plain = lb.Surface(0.0, 1e2, lb.Glass(1.6), curvature=c, conic=-1.0)
    a_2 = 0.5 * c if written == "aspheric" else 0.2 * c
    other = lb.Surface(0.0, 1e2, lb.Glass(1.6), curvature=0.0, aspheric=((2, a_2),)) if written == "aspheric" else \
        lb.Surface(0.0, 1e2, lb.Glass(1.6), curvature=0.6 * c, conic=-1.0, aspheric=((2, a_2),))
    a, b = (lb.trace(lb.Lens((s,), 0), [x, y, -3.0], [0.4 * dx, 0.4 * dy, 1.0]) for s in (plain, other))
    assert a.fate[0] == b.fate[0] == lb.Fate.PASSED
    np.testing.assert_allclose(b.points, a.points, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(b.directions, a.directions, rtol=0.0, atol=1e-14)


@LAW
@given(st.floats(15.0, 100.0), HEIGHT, HEIGHT, SLOPE)
def test_a_cylinder_leaves_the_momentum_along_its_axis_alone(radius, x, y, dx):
    rod = lb.Lens((lb.Surface(4.0, 1e2, lb.Glass(1.6), curvature=1.0 / radius, curvature_x=0.0),
                   lb.Surface(0.0, 1e2, curvature=0.0)), 0)
    direction = np.array([dx, 0.2, 1.0]) / np.linalg.norm([dx, 0.2, 1.0])
    t = lb.trace(rod, [x, y, -2.0], direction)
    assert t.fate[0] == lb.Fate.PASSED
    assert t.directions[0, 0] == pytest.approx(direction[0], abs=1e-15)
    turned = lb.Lens((lb.Surface(4.0, 1e2, lb.Glass(1.6), curvature=0.0, curvature_x=1.0 / radius), rod.surfaces[1]), 0)
    across = lb.trace(turned, [y, x, -2.0], direction[[1, 0, 2]])
    np.testing.assert_allclose(across.points[0, [1, 0, 2]], t.points[0], rtol=0.0, atol=1e-14)


@pytest.mark.slow
@LAW
@given(stacks(), HEIGHT, HEIGHT, SLOPE, SLOPE)
def test_light_runs_back_along_its_own_path_through_every_kind(stack, x, y, dx, dy):
    there = lb.trace(stack, [x, y, -3.0], [dx, dy, 1.0], record=True)
    assume(there.fate[0] == lb.Fate.PASSED)
    back = lb.trace(stack, there.points + 2.0 * there.directions, -there.directions, record=True)
    assume(abs(there.directions[0, 2]) > 0.05)
    assert back.fate[0] in (lb.Fate.PASSED, lb.Fate.CLIPPED)            # a rim may be met within its rounding
    if back.fate[0] == lb.Fate.PASSED:
        np.testing.assert_allclose(back.paths[0, 1:][::-1], there.paths[0, 1:], rtol=0.0, atol=1e-10)


# --- Prescriptions

@pytest.mark.parametrize(("fields", "message"), [
    ({"conic": nan}, "conic is nan"),
    ({"aspheric": ((1, 0.1),)}, "power 1"),
    ({"aspheric": ((21, 0.1),)}, "power 21"),
    ({"aspheric": ((4.5, 0.1),)}, "power 4.5"),
    ({"aspheric": ((4, inf),)}, r"r\^4 is inf"),
    ({"aspheric": ((4, 0.1), (4, 0.2))}, r"r\^4 is given twice"),
    ({"curvature_x": inf}, "curvature_x is inf"),
    ({"curvature_x": 0.0, "conic": -1.0}, "neither a conic"),
])
def test_invalid_surfaces_are_refused_in_one_line(fields, message):
    with pytest.raises(lb.LensError, match=message):
        lb.Surface(1.0, 5.0, curvature=0.02, **fields)


def test_terms_are_kept_by_rising_power_without_zeros_so_that_equal_surfaces_compare_equal():
    one = lb.Surface(1.0, 5.0, curvature=0.02, aspheric=((6, 1e-7), (4, 1e-5), (8, 0.0)))
    assert one == lb.Surface(1.0, 5.0, curvature=0.02, aspheric=((4, 1e-5), (6, 1e-7)))
    assert lb.Surface(1.0, 5.0, curvature=0.02, curvature_x=0.02) == lb.Surface(1.0, 5.0, curvature=0.02)
    assert lens("rf50").scaled(2.0).scaled(0.5) == lens("rf50")


def test_a_surface_has_the_radius_of_its_curvature_and_a_plane_an_infinite_one():
    assert [lb.Surface(1.0, 5.0, curvature=c).radius for c in (0.02, -0.125, 0.0)] == [50.0, -8.0, inf]


@pytest.mark.parametrize("given", [(50.0, 4.0, 10.0), (0.5, 0.1, 0.3), (50.0, 4.0, 10.0, lb.Glass(1.5))])
def test_a_number_is_a_curvature_or_a_radius_by_its_name_alone(given):
    """Of a prescription the first column is the radius; it was taken as the curvature."""
    with pytest.raises(TypeError, match="either its curvature or its radius of curvature, by name"):
        lb.Surface(*given)
    by_radius = lb.Surface(*given[1:], radius=given[0])
    assert by_radius == lb.Surface(*given[1:], curvature=1.0 / given[0]) and by_radius.thickness == given[1]
