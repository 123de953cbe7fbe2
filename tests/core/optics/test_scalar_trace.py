"""The reference tracer against 40-digit values, pbrt's rays, and the laws of refraction."""

from math import cos, pi, radians, sin

import numpy as np
import pytest
from hypothesis import assume, given, strategies as st

import lensbench as lb
from tests.core.oracles import DATA, LAW, REFERENCE, TRACED, WAVELENGTHS, lens, lenses, pbrt_rays

HEIGHT = st.floats(-6.0, 6.0)
SLOPE = st.floats(-0.6, 0.6)


def one_surface(curvature: float, n: float, behind: bool = False) -> lb.Lens:
    """Glass of index n behind (or, with behind=True, before) a surface; light comes from the air side."""
    return lb.Lens((lb.Surface(5.0, 1e3, lb.Glass(n), curvature=0.0), lb.Surface(0.0, 1e3, curvature=curvature)),
                   1) if behind \
        else lb.Lens((lb.Surface(0.0, 1e3, lb.Glass(n), curvature=curvature),), 0)


# --- Reference values

@pytest.mark.parametrize(("name", "line"), WAVELENGTHS)
def test_rays_agree_with_the_forty_digit_tracer(name, line):
    reference = REFERENCE[name]
    rays = [ray[2:] for ray in reference["rays"] if ray[1] == line and ray[4] == "ok"]
    starts, directions, _, _, _, images, after = (list(column) for column in zip(*rays, strict=True))
    t = lb.trace(lens(name, line), starts, directions, clip=False)
    assert set(t.fate) == {lb.Fate.PASSED}
    to_film = (reference["film_z"] - t.points[:, 2]) / t.directions[:, 2]
    on_film = t.points + to_film[:, None] * t.directions
    np.testing.assert_allclose(on_film[:, :2], images, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(t.directions, after, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("name", TRACED)
def test_rays_end_where_the_forty_digit_tracer_ends_them(name):
    fate_of = {"ok": lb.Fate.PASSED, "miss": lb.Fate.MISSED, "tir": lb.Fate.TOTAL_REFLECTION}
    # rays aimed at the very edge of the stop may fall on either side of it
    rays = [ray for ray in REFERENCE[name]["rays"] if ray[1] == "d" and ray[0] != "stop_aimed"]
    starts, directions = [ray[2] for ray in rays], [ray[3] for ray in rays]
    free, clipped = (lb.trace(lens(name), starts, directions, clip=clip) for clip in (False, True))
    beyond_the_equator = 0
    for i, (_, _, _, _, status, failed, rim, _, _) in enumerate(rays):
        if status == "tir" and free.fate[i] == lb.Fate.MISSED:
            # the reference takes hits beyond the equator too, and finds total reflection there
            beyond_the_equator += 1
            assert free.surface[i] == failed - 1
        elif status != "ok":
            assert free.fate[i] == fate_of[status]
            assert free.surface[i] == (failed - 1 if status == "miss" else failed)
        if rim is None and status == "ok":
            assert clipped.fate[i] == lb.Fate.PASSED
        elif rim is not None and (failed is None or rim < failed):
            assert (clipped.fate[i], clipped.surface[i]) == (lb.Fate.CLIPPED, rim)
    assert beyond_the_equator == (1 if name == "fisheye" else 0)


@pytest.mark.parametrize("name", ["dgauss", "fisheye"])
def test_two_thousand_rays_agree_with_pbrt_fate_by_fate(name):
    data = np.load(DATA / "pbrt_rays.npz")
    rear_z, film, toward = data[f"{name}_rear_z"], data[f"{name}_film"], data[f"{name}_toward"]
    direction = np.column_stack([toward, np.full(len(toward), rear_z)])
    t = lb.trace(lens(name), *pbrt_rays(name, film, direction, float(rear_z)))
    fate = np.array([lb.Fate.PASSED, lb.Fate.MISSED, lb.Fate.CLIPPED, lb.Fate.TOTAL_REFLECTION, lb.Fate.BACKWARD])
    np.testing.assert_array_equal(t.fate, fate[data[f"{name}_status"]])
    passed = t.fate == lb.Fate.PASSED
    np.testing.assert_array_equal(t.surface[~passed], data[f"{name}_surface"][~passed])
    out = data[f"{name}_out"]
    # pbrt's points are metres in double: 1e-17 m of rounding a surface, tilted by the slopes
    np.testing.assert_allclose(t.points[passed, :2], 1000.0 * out[:, :2], rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(t.directions[passed, :2], out[:, 2:], rtol=0.0, atol=1e-12)
    assert (t.directions[passed, 2] < 0.0).all()


def test_the_rays_that_pbrt_sees_turn_backward_at_the_stop_are_blocked():
    rows = np.genfromtxt(DATA / "pbrt_backward_rays.csv", delimiter=",", dtype=None, encoding="utf-8")
    for name, rear_z, *numbers, stop in rows:
        x, y, dx, dy, dz = numbers
        rays = pbrt_rays(name, np.array([[x, y]]), np.array([[dx, dy, dz]]), rear_z)
        t = lb.trace(lens(name), *rays)
        assert t.fate[0] in (lb.Fate.BACKWARD, lb.Fate.CLIPPED, lb.Fate.MISSED, lb.Fate.TOTAL_REFLECTION)
        free = lb.trace(lens(name), *rays, clip=False)
        assert free.fate[0] == lb.Fate.BACKWARD
        assert free.surface[0] == stop + 1 == lens(name).stop_index + 1     # bent by the surface before the stop
        assert np.isfinite(free.points).all() and free.directions[0, 2] >= 0.0


# --- Laws

@LAW
@given(st.floats(-0.1, 0.1), st.floats(1.3, 2.0), HEIGHT, HEIGHT, SLOPE, SLOPE, st.booleans())
def test_refraction_obeys_snell_and_stays_in_one_plane(curvature, n, x, y, dx, dy, behind):
    t = lb.trace(one_surface(curvature, n, behind), [x, y, -3.0], [dx, dy, 1.0], record=True)
    assume(t.fate[0] in (lb.Fate.PASSED, lb.Fate.TOTAL_REFLECTION))
    z = t.points[0, 2] - (5.0 if behind else 0.0)
    normal = np.array([-curvature * t.points[0, 0], -curvature * t.points[0, 1], 1.0 - curvature * z])
    incoming = np.array([dx, dy, 1.0]) / np.linalg.norm([dx, dy, 1.0])
    if behind:                                          # bent by the plane in front
        incoming = np.array([*incoming[:2] / n, np.sqrt(1.0 - (incoming[:2] @ incoming[:2]) / n**2)])
    before, after = (n, 1.0) if behind else (1.0, n)
    if t.fate[0] == lb.Fate.PASSED:
        # n d × N is kept as a vector: its length is Snell's law, its direction the plane of incidence
        refracted = after * np.cross(t.directions[0], normal)
        np.testing.assert_allclose(refracted, before * np.cross(incoming, normal), atol=1e-13)
        assert np.dot(t.directions[0], normal) > 0.0
        assert np.linalg.norm(t.directions[0]) == pytest.approx(1.0, abs=1e-15)
    else:
        assert before / after * np.linalg.norm(np.cross(incoming, normal)) > 1.0
        np.testing.assert_allclose(t.directions[0], incoming, atol=1e-15)


@LAW
@given(st.floats(-0.1, 0.1), HEIGHT, HEIGHT, SLOPE, SLOPE, st.booleans())
def test_a_hit_lies_on_the_ray_on_the_sphere_and_on_the_vertex_side_of_its_equator(curvature, x, y, dx, dy, back):
    origin = np.array([x, y, 4.0 if back else -4.0])
    direction = np.array([dx, dy, -1.0 if back else 1.0])
    t = lb.trace(one_surface(curvature, 1.0), origin, direction)
    if t.fate[0] == lb.Fate.MISSED:
        assert t.surface[0] == -1
        np.testing.assert_array_equal(t.points[0], origin)
        return
    point = t.points[0]
    np.testing.assert_allclose(np.cross(point - origin, direction), 0.0, atol=1e-12)
    assert curvature * point @ point == pytest.approx(2.0 * point[2], abs=1e-13)
    assert curvature * point[2] < 1.0


@LAW
@given(st.floats(8.0, 60.0), st.floats(-0.9, 0.9), st.floats(-1.0, 1.0), st.floats(1.3, 1.9), st.floats(0.0, 0.6),
       st.sampled_from([0.0, -1e-12]))
def test_a_sphere_knows_no_front_and_light_may_reach_it_from_beyond_a_right_angle(radius, height, x, n, angle, conic):
    """Turned about its centre, a ray stays the same; k = −1e-12 takes the way of conics, with a shape as good as equal.

    So what hits the dome from its front and what comes from up to 35° behind its equator are refracted alike.
    """
    dome = lb.Lens((lb.Surface(0.0, 1e3, lb.Glass(n), conic, curvature=1.0 / radius),), 0)
    turn = 0.5 * pi + angle
    across = height * radius
    straight = lb.trace(dome, [x, across, -3.0], [0.0, 0.0, 1.0])
    cosine, sine = cos(turn), sin(turn)
    about = np.array([[1.0, 0.0, 0.0], [0.0, cosine, sine], [0.0, -sine, cosine]])
    centre = np.array([0.0, 0.0, radius])
    turned = lb.trace(dome, about @ ([x, across, -3.0] - centre) + centre, about @ [0.0, 0.0, 1.0], forward=True)
    assume(straight.fate[0] == lb.Fate.PASSED)
    point = about @ (straight.points[0] - centre) + centre
    assume(abs(point[2] - radius) > 1e-6)
    if point[2] > radius:                               # beyond the equator
        assert turned.fate[0] == lb.Fate.MISSED
        return
    np.testing.assert_allclose(turned.points[0], point, rtol=0.0, atol=1e-9 if conic else 1e-11)
    after = about @ straight.directions[0]
    np.testing.assert_allclose(turned.directions[0], after, rtol=0.0, atol=1e-9 if conic else 1e-12)
    assert turned.fate[0] == (lb.Fate.PASSED if after[2] > 0.0 else lb.Fate.BACKWARD)


def test_rays_that_run_across_the_axis_are_traced_where_their_order_is_given():
    dome, way = one_surface(0.1, 1.5), [0.0, 1.0, 0.0]
    assert lb.trace(dome, [0.0, -20.0, 5.0], way).fate[0] == lb.Fate.MISSED
    t = lb.trace(dome, [0.0, -20.0, 5.0], way, forward=True)
    assert t.fate[0] == lb.Fate.PASSED
    np.testing.assert_allclose(t.points[0], [0.0, -np.sqrt(75.0), 5.0], rtol=0.0, atol=1e-13)
    assert lb.trace(dome, [0.0, -20.0, 5.0], way, forward=False).points[0, 1] == pytest.approx(np.sqrt(75.0))
    plane = lb.trace(one_surface(0.0, 1.5), [0.0, 0.0, -1.0], [[0.0, 1.0, 0.0], [0.0, 1.0, -0.1]], forward=True)
    assert set(plane.fate) == {lb.Fate.MISSED}


@LAW
@given(st.floats(12.0, 60.0), st.floats(0.1, 0.9), st.floats(0.0, 2.0 * pi), st.sampled_from([1.0, -1.0]))
def test_a_ray_that_meets_only_the_far_half_of_a_sphere_misses(radius, height, turn, sign):
    """It crosses the ball between its equator and its far pole, hardly rising: both hits are beyond the equator."""
    along = np.array([cos(turn), sin(turn), sign * 0.01 * (1.0 - height)])
    origin = np.array([0.0, 0.0, sign * radius * (1.0 + height)]) - 2.0 * radius * along
    assert sign * (origin + radius * along)[2] > radius
    t = lb.trace(one_surface(sign / radius, 1.5), origin, along)
    assert (t.fate[0], t.surface[0]) == (lb.Fate.MISSED, -1)


@LAW
@given(lenses(), HEIGHT, HEIGHT, SLOPE, SLOPE)
def test_light_runs_back_along_its_own_path(stack, x, y, dx, dy):
    t = lb.trace(stack, [x, y, -10.0], [dx, dy, 1.0], clip=False, record=True)
    assume(t.fate[0] == lb.Fate.PASSED)
    back = lb.trace(stack, t.points + 7.0 * t.directions, -t.directions, clip=False, record=True)
    assert back.fate[0] == lb.Fate.PASSED
    np.testing.assert_allclose(back.paths[0, :0:-1], t.paths[0, 1:], atol=1e-9)
    np.testing.assert_allclose(-back.directions[0], np.array([dx, dy, 1.0]) / np.linalg.norm([dx, dy, 1.0]), atol=1e-10)


@LAW
@given(lenses(), HEIGHT, HEIGHT, SLOPE, SLOPE)
def test_the_skew_invariant_of_a_ray_is_kept(stack, x, y, dx, dy):
    t = lb.trace(stack, [x, y, -10.0], [dx, dy, 1.0], clip=False)
    assume(t.fate[0] == lb.Fate.PASSED)
    n = stack.indices()[-1]
    before = (x * dy - y * dx) / np.sqrt(dx * dx + dy * dy + 1.0)
    after = n * (t.points[0, 0] * t.directions[0, 1] - t.points[0, 1] * t.directions[0, 0])
    assert after == pytest.approx(before, abs=1e-11)


@pytest.mark.parametrize("name", TRACED)
def test_real_rays_approach_the_paraxial_focus_as_the_square_of_their_height(name):
    heights = lb.first_order(lens(name)).efl * np.array([8e-3, 4e-3, 2e-3, 1e-3])
    origins = np.column_stack([0.0 * heights, heights, 0.0 * heights])
    t = lb.trace(lens(name), origins, [0.0, 0.0, 1.0])
    crossing = t.points[:, 2] - t.points[:, 1] * t.directions[:, 2] / t.directions[:, 1]
    error = np.abs(crossing - lens(name).length - lb.first_order(lens(name)).bfl)
    # each halving divides the error by 4, up to the next order of the height
    np.testing.assert_allclose(error[:-1] / error[1:], 4.0, rtol=0.02)


@LAW
@given(st.floats(15.0, 80.0), st.floats(1.4, 1.9), st.floats(0.05, 0.6))
def test_the_aplanatic_points_of_a_sphere_image_without_error(radius, n, angle):
    """Light from R (1 + 1/n) behind the vertex of a glass ball's surface seems to come from R (1 + n)."""
    glass_before = lb.Lens((lb.Surface(3.0 * radius, 1e4, lb.Glass(n), curvature=0.0),
                            lb.Surface(0.0, 1e4, curvature=-1.0 / radius)), 1)
    assume(n * sin(angle) < 0.999)
    inside = np.array([0.0, sin(angle), cos(angle)])
    outside = np.array([0.0, n * sin(angle), np.sqrt(1.0 - (n * sin(angle)) ** 2)])
    source = np.array([0.0, 0.0, 3.0 * radius - radius * (1.0 + 1.0 / n)])
    t = lb.trace(glass_before, source - source[2] / cos(angle) * inside - outside, outside)
    assume(t.fate[0] == lb.Fate.PASSED)
    crossing = t.points[0, 2] - t.points[0, 1] * t.directions[0, 2] / t.directions[0, 1]
    assert 3.0 * radius - crossing == pytest.approx(radius * (1.0 + n), rel=1e-11)


# --- Fates, ends and paths

def test_each_fate_ends_where_the_page_says():
    stopped = lb.Lens((lb.Surface(4.0, 8.0, lb.Glass(1.6), curvature=0.05), lb.Surface(3.0, 2.0, curvature=0.0),
                       lb.Surface(0.0, 9.0, curvature=0.2)), 1)
    rays = {
        "passed": ([0.0, 0.5, -5.0], [0.0, 0.0, 1.0]),
        "clipped": ([0.0, 6.0, -5.0], [0.0, 0.0, 1.0]),
        "missed before the lens": ([0.0, 30.0, -5.0], [0.0, 0.0, 1.0]),
        "across": ([0.0, 1.0, -5.0], [0.0, 1.0, 0.0]),
    }
    t = lb.trace(stopped, [o for o, _ in rays.values()], [d for _, d in rays.values()], record=True)
    assert list(t.fate) == [lb.Fate.PASSED, lb.Fate.CLIPPED, lb.Fate.MISSED, lb.Fate.MISSED]
    assert list(t.surface) == [2, 1, -1, -1]
    np.testing.assert_array_equal(t.points[2:], [rays["missed before the lens"][0], rays["across"][0]])
    reached = np.isfinite(t.paths).all(axis=2).sum(axis=1)
    assert list(reached) == [4, 3, 1, 1]
    for i, last in enumerate(reached - 1):
        np.testing.assert_array_equal(t.paths[i, last], t.points[i])
    assert np.isnan(t.paths[1, 3:]).all() and np.isnan(t.paths[2, 1:]).all()


def test_a_miss_within_the_lens_ends_on_the_surface_before_it():
    bent = lb.Lens((lb.Surface(4.0, 50.0, curvature=0.0), lb.Surface(0.0, 50.0, curvature=0.2)), 0)
    t = lb.trace(bent, [0.0, 6.0, -1.0], [0.0, 0.0, 1.0])
    assert (t.fate[0], t.surface[0]) == (lb.Fate.MISSED, 0)
    np.testing.assert_array_equal(t.points[0], [0.0, 6.0, 0.0])


@pytest.mark.parametrize("above", [False, True])
def test_total_reflection_sets_in_at_the_critical_angle(above):
    n = 1.5
    prism = lb.Lens((lb.Surface(1.0, 50.0, lb.Glass(n), curvature=0.2), lb.Surface(0.0, 50.0, curvature=0.0)), 0)
    centre = np.array([0.0, 0.0, 5.0])                     # a ray towards the sphere's centre enters unbent
    angle = np.arcsin(1.0 / n) + (1e-9 if above else -1e-9)
    direction = np.array([0.0, sin(angle), cos(angle)])
    t = lb.trace(prism, centre - 9.0 * direction, direction)
    assert t.fate[0] == (lb.Fate.TOTAL_REFLECTION if above else lb.Fate.PASSED)
    assert t.surface[0] == 1 and t.points[0, 2] == pytest.approx(1.0, abs=1e-14)
    if above:
        np.testing.assert_allclose(t.directions[0], direction, atol=1e-14)


@pytest.mark.parametrize(("last", "outside"), [(True, 1.0), (False, 1.0), (False, 1.3)])
def test_a_ray_bent_against_its_travel_is_backward_unless_it_leaves_for_the_scene(last, outside):
    """Light in glass, towards the scene, leaves the flank of a ball at 3° from its equator, away from the normal.

    Within a lens it ends on the surface that bent it. The last one it leaves as the light of a fisheye beyond 90° does.
    """
    ball = lb.Surface(0.0, 20.0, lb.Glass(1.9), curvature=0.1)
    before = lb.Surface(30.0, 99.0, lb.Glass(outside), curvature=0.0)
    flank = lb.Lens((ball,), 0) if last else lb.Lens((before, ball), 0)
    vertex = flank.length
    normal, inside = (np.array([0.0, cos(radians(angle)), -sin(radians(angle))]) for angle in (3.0, 0.5))
    point = np.array([0.0, 0.0, vertex + 10.0]) + 10.0 * normal
    t = lb.trace(flank, point - 5.0 * inside, inside, record=True)
    assert (t.fate[0], t.surface[0]) == ((lb.Fate.PASSED, 0) if last else (lb.Fate.BACKWARD, 1))
    np.testing.assert_allclose(t.points[0], point, atol=1e-13)
    leaving = radians(3.0) - np.arcsin(1.9 / outside * sin(radians(2.5)))
    np.testing.assert_allclose(t.directions[0], [0.0, cos(leaving), -sin(leaving)], atol=1e-14)
    assert t.directions[0, 2] > 0.0
    assert np.isfinite(t.paths[0]).all(axis=1).sum() == 2


@pytest.mark.parametrize("name", TRACED)
def test_without_rims_no_ray_is_clipped_and_the_others_are_the_same(name):
    rng = np.random.default_rng(3)
    origins = np.column_stack([rng.uniform(-20.0, 20.0, (500, 2)), np.full(500, -30.0)])
    directions = np.column_stack([rng.uniform(-0.4, 0.4, (500, 2)), np.ones(500)])
    rims, free = lb.trace(lens(name), origins, directions), lb.trace(lens(name), origins, directions, clip=False)
    assert not (free.fate == lb.Fate.CLIPPED).any() and (rims.fate == lb.Fate.CLIPPED).any()
    passed = rims.fate == lb.Fate.PASSED
    np.testing.assert_array_equal(rims.points[passed], free.points[passed])
    assert np.isfinite(free.points).all() and np.isfinite(free.directions).all()


@pytest.mark.parametrize("name", TRACED)
def test_single_precision_follows_double_to_its_own_rounding(name):
    rng = np.random.default_rng(5)
    wide = lens(name)
    aim = np.column_stack([rng.uniform(-3.0, 3.0, (400, 2)), np.full(400, wide.length)])
    film = np.array([1.0, 4.0, wide.length + 40.0])
    coarse, fine = (lb.trace(wide, film, aim - film, dtype=dtype) for dtype in (np.float32, np.float64))
    assert coarse.points.dtype == coarse.directions.dtype == np.float32
    same = (coarse.fate == fine.fate) & (fine.fate == lb.Fate.PASSED)
    assert (coarse.fate == fine.fate).mean() > 0.99
    # 40 mm · 2⁻²⁴ a step, a dozen steps, magnified a few times
    np.testing.assert_allclose(coarse.points[same], fine.points[same], atol=1e-3)
    np.testing.assert_allclose(coarse.directions[same], fine.directions[same], atol=1e-4)
